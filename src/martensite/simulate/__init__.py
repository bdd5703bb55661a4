"""The time march, its result and its status."""
