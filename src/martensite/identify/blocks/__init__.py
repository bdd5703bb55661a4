"""Blocks of dynamic models: static nonlinearities, linear systems, hysteresis operators."""
