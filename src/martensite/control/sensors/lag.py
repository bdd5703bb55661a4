"""A lag of first order, exact for a truth that is held over the step.

τ dx/dt = y - x,    x(t + Δt) = x + (1 - exp(-Δt/τ)) (y - x)
"""

from __future__ import annotations

from martensite.kernels.namespace import Namespace, Scalar


def follow_lag(xp: Namespace, felt: Scalar, truth: Scalar, lag: Scalar, dt: Scalar) -> Scalar:
    """What is felt of a truth that has been as it is for `dt` [s]; the truth if there is no lag."""
    some = lag > 0.0
    share = 1.0 - xp.exp(-dt / xp.where(some, lag, 1.0))
    return xp.where(some, felt + share * (truth - felt), truth)
