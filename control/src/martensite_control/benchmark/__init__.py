"""The benchmark of controllers."""
