"""Commands of the group `hardware`."""
