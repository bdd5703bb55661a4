"""Safety limits of an element: what a run must warn about."""

from __future__ import annotations

from martensite.parameters import Parametrised, param
from martensite.runtimes.namespace import Scalar


class Limits(Parametrised):
    """Limits beyond which a run warns; infinite where nothing is known."""

    temperature_limit: Scalar = param(
        "K", "highest temperature without damage", above=0.0, default=float("inf")
    )
    stress_limit: Scalar = param(
        "Pa", "highest stress for long life", above=0.0, default=float("inf")
    )
    strain_limit: Scalar = param(
        "1", "largest strain amplitude for long life", above=0.0, default=float("inf")
    )
