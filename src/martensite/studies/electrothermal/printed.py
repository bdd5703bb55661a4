"""Every number stated about the record that this study uses, in SI units but for °C.

The authors of the record state geometry and offset in the program that evaluates it,
`read_data.py` beside the files; the rest was read off the same record for material
`flexinol-90` and for the page on resistance.
"""

from __future__ import annotations

from dataclasses import dataclass

SOURCE = "leal2016"
"""Key of the record in the bibliography."""


@dataclass(frozen=True)
class Stated:
    """What is stated about run 5."""

    # read_data.py
    diameter: float = 0.381e-3
    """[m]"""
    length: float = 0.19
    """[m]"""
    offset: float = 1.21007069871 + 0.474710578241 - 0.949421156482 - 0.504768862708
    """Taken off the set-point [V]: a sum of four corrections, 230.6 mV."""
    drop: float = 3.0
    """By how much the counter of the set-point is said to fall back [V]."""
    drops: float = 1.0
    """How often it is said to."""
    # read off the record
    martensite_low: float = 1.50
    """Lowest resistance of martensite [ohm]"""
    martensite_high: float = 1.58
    """Highest [ohm]"""
    austenite: float = 1.40
    """Resistance of austenite, right after the drop [ohm]"""
    drop_start: float = 1.25
    """Current at which the resistance starts to fall [A]"""
    drop_end: float = 1.7
    """Current at which it has fallen [A]"""
    rise: float = 0.02
    """Share by which it then rises per 40 K of apparent temperature."""
    per_metre: tuple[float, float, float] = (8.3, 7.9, 7.4)
    """Martensite at most and at least, austenite [ohm/m]"""
    rho_A: float = 8.4e-7
    """Resistivity of austenite in material `flexinol-90` [ohm m]"""
    rho_M: float = 9.2e-7
    """Resistivity of martensite there [ohm m]"""
    # Ranges of set-points that these statements are about
    cold: tuple[float, float] = (1.3, 2.2)
    """Martensite, without the three lowest plateaus [V]"""
    hot: tuple[float, float] = (2.4, 3.4)
    """Austenite, before its resistance rises [V]"""
