"""Every number that the paper prints and this study uses, in SI units."""

from __future__ import annotations

from dataclasses import dataclass

PAPER = "finger-paper"
"""Key of the paper in the bibliography."""


@dataclass(frozen=True)
class Printed:
    """The paper's numbers."""

    # Section 2
    diameter: float = 0.1e-3
    """[m]"""
    length: float = 0.44
    """Of the whole wire as austenite [m]."""
    ambient: float = 295.0
    """[K]"""
    phalanx: float = 50e-3
    """Length of the second phalanx [m]."""
    side: float = 19e-3
    """Of its square base [m]."""
    offsets: tuple[float, ...] = (1.5e-3, 3.5e-3, 5.5e-3)
    """r of section 5 [m]."""
    stiffness: float = 50.0
    """[N/m]"""
    extension: float = 1e-3
    """"pre-strain of 1 mm" of the spring, read as an extension [m]."""
    # Table 1
    E_M: float = 30e9
    """[Pa]"""
    eps_T: float = 0.04
    film: float = 200.0
    """α [W/(m² K)], printed in W/m²."""
    # Section 5
    powers: tuple[float, ...] = (1.4, 2.0)
    """[W]"""
    start: float = 3.0
    """The power rises from here [s]."""
    ramp: float = 2.0
    """[s]"""
    fall: float = 13.0
    """It falls from here [s]."""
    frequency: float = 0.015
    """Of the calibration test [Hz]."""
    error: float = 4.0
    """Largest difference to the measured angles [°]."""
