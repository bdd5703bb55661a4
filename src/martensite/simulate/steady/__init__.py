"""Steady states, limit cycles and response curves of systems under constant or periodic drives."""
