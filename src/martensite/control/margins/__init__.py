"""Linear loops of a bench on both branches: margins, tests, and gain schedules."""
