"""Solvers that martensite is compared with; each stands on its own."""
