"""Every number of the thesis's chapter 3 that this study uses, in SI units except °C."""

from __future__ import annotations

from dataclasses import dataclass

THESIS = "kossoski2018"
"""Key of the thesis in the bibliography."""


@dataclass(frozen=True)
class Row:
    """A row of Table 2 with the voltage that belongs to it: a steady state of the wire."""

    voltage: float
    """[V]; section 3.2.2: 0.5 V to 1.3 V in steps of 0.1 V"""
    temperature: float
    """Surface temperature [°C]"""
    conductivity: float
    """Of air at the film temperature [W/(m K)]"""
    diffusivity: float
    """Thermal, of air [m²/s]"""
    viscosity: float
    """Kinematic, of air [m²/s]"""
    prandtl: float


@dataclass(frozen=True)
class Printed:
    """The thesis's numbers."""

    # Table 1
    resistance_A: float = 13.0
    """[ohm]"""
    resistance_M: float = 15.0
    """[ohm]"""
    diameter: float = 375e-6
    """[m]"""
    length: float = 0.1
    """[m]"""
    # Section 3.2.2
    current: float = 0.69
    """[A], at `current_at`"""
    current_at: float = 0.9
    """[V]"""
    # Section 3.2.3, text after Table 2
    austenite_from: float = 1.0
    """Voltage from which R_A is used, below it R_M [V]"""
    # Table 2
    rows: tuple[Row, ...] = (
        Row(0.5, 33.0, 0.02551, 2.14e-5, 1.56e-5, 0.7296),
        Row(0.6, 39.0, 0.02588, 2.21e-5, 1.61e-5, 0.7282),
        Row(0.7, 46.0, 0.02625, 2.28e-5, 1.66e-5, 0.7268),
        Row(0.8, 58.0, 0.02662, 2.35e-5, 1.70e-5, 0.7255),
        Row(0.9, 73.0, 0.02730, 2.48e-5, 1.78e-5, 0.7230),
        Row(1.0, 75.0, 0.02734, 2.487e-5, 1.79e-5, 0.7229),
        Row(1.1, 80.0, 0.02738, 2.49e-5, 1.81e-5, 0.7220),
        Row(1.2, 93.0, 0.02800, 2.63e-5, 1.89e-5, 0.7210),
        Row(1.3, 101.0, 0.02820, 2.69e-5, 1.92e-5, 0.7100),
    )

    @property
    def voltages(self) -> list[float]:
        """Voltages of the rows [V]."""
        return [row.voltage for row in self.rows]

    @property
    def temperatures(self) -> list[float]:
        """Steady temperatures of Table 2 [°C]."""
        return [row.temperature for row in self.rows]

    def resistance(self, voltage: float) -> float:
        """Resistance that the thesis uses at a voltage [V], as printed [ohm]."""
        austenite = voltage > self.austenite_from - 1e-9
        return self.resistance_A if austenite else self.resistance_M
