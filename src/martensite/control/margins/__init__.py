"""Loops of a bench for small signals: linear systems on both branches, margins, tests, figures, gain schedules."""
