"""Gains by search: exact derivatives through the closed loop, over perturbed plants."""
