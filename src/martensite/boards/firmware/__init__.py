"""Firmware around the loop of a scenario: settings, projects for boards, wiring."""
