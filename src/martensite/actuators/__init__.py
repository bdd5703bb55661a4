"""Actuators: elements, mechanisms, and the systems they form."""
