"""What every part promises, as suites that anybody can run on a part of his own."""
