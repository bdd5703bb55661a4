"""What several sensors have in common."""
