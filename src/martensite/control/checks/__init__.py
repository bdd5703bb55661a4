"""What a guard checks, one file per check."""
