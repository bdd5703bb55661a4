"""Supervisors, which limit or cut the signals of controllers."""
