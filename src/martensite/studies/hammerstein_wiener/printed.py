"""Every number that the paper prints on its models and its controller, in SI units."""

from __future__ import annotations

from dataclasses import dataclass

PAPER = "copaci2019"
"""Key of the paper in the bibliography."""
MODELS = f"{PAPER}, section 3.1"
CONTROL = f"{PAPER}, section 3.2"


@dataclass(frozen=True)
class Printed:
    """The paper's numbers."""

    fit_temperature: float = 92.38
    """Stage 1, duty to temperature [%]."""
    fit_position: float = 80.42
    """Stage 2, temperature to position [%]."""
    error_heating: float = 3e-3
    """Largest error of the position of both stages in series, "about" [m]."""
    error_cooling: float = 5e-3
    """The same while it cools [m]."""
    stroke: float = 0.04
    """Over the length of the wire."""
    current: float = 4.0
    """Largest current [A]."""
