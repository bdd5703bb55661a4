"""The numerics laboratory: random scenarios against an ODE that shares nothing with the package."""
