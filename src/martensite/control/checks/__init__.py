"""What a guard checks."""
