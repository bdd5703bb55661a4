"""Every number that the paper prints and this study uses, in SI units except °C as printed."""

from __future__ import annotations

from dataclasses import dataclass

PAPER = "migaone-paper"
"""Key of the paper in the bibliography."""


@dataclass(frozen=True)
class Step:
    """A row of Table 2: the steady state of one step response."""

    voltage: float
    """[V]"""
    temperature: float
    """[°C]"""
    film: float
    """h [W/(m² K)]"""


@dataclass(frozen=True)
class Printed:
    """The paper's numbers."""

    # Table 1
    heat_capacity: float = 320.0
    """[J/(kg K)]"""
    ambient: float = 38.5
    """[°C]"""
    diameter: float = 0.038e-3
    """[m]"""
    surface: float = 3.26e-5
    """[m²]"""
    volume: float = 3.10e-10
    """[m³]"""
    # Table 2
    steps: tuple[Step, ...] = (
        Step(1.0, 47.65, 47.83),
        Step(1.5, 57.50, 53.07),
        Step(2.0, 72.00, 57.28),
        Step(2.5, 87.00, 64.55),
    )
    # Section 3, after Table 2
    h0: float = 42.53
    """[W/(m² K)]"""
    h1: float = 0.0
    """[W/(m² K²)]"""
    h2: float = 0.00294
    """[W/(m² K³)]"""
    r_squared: float = 0.9899
    # Section 4.1
    diameter_in_text: float = 0.015 * 0.0254
    """[m], printed as 0.015 inch"""
    stroke: float = 8e-3
    """[m]"""
    resistance: float = 2.7
    """[ohm], printed as about"""
    supply: float = 5.0
    """[V]"""
    actuation_time: float = 1.0
    """[s], printed as about"""

    @property
    def temperatures(self) -> list[float]:
        """Steady temperatures of Table 2 [°C]."""
        return [step.temperature for step in self.steps]

    @property
    def films(self) -> list[float]:
        """Film coefficients of Table 2 [W/(m² K)]."""
        return [step.film for step in self.steps]

    @property
    def coefficients(self) -> tuple[float, float, float]:
        """The printed polynomial (h₀, h₁, h₂)."""
        return self.h0, self.h1, self.h2
