"""Every number that the paper prints and this study uses, in SI units except °C as printed."""

from __future__ import annotations

from dataclasses import dataclass

PAPER = "ranjith2018"
"""Key of the paper in the bibliography."""


@dataclass(frozen=True)
class Printed:
    """The paper's numbers."""

    # Table 1, and section 2
    side: float = 0.100
    """Of the plates [m]."""
    height: float = 0.060
    """Distance of the plates, and initial length of the springs [m]."""
    plate_mass: float = 0.075
    """Of the top plate [kg]."""
    centroid: float = 0.0289
    """Distance of the centroid from a side, d_c [m]."""
    diameter: float = 0.75e-3
    """Of the wire [m]."""
    coil_diameter: float = 6e-3
    """"Outer diameter" in section 2, "spring diameter" in Table 1 [m]."""
    turns: float = 20.0
    spring_mass: float = 1e-3
    """[kg]"""
    A_s: float = 42.6
    """[°C]"""
    A_f: float = 50.3
    M_s: float = 43.0
    M_f: float = 35.0
    C_A: float = 6.0
    """[MPa/°C], printed as GPa/°C."""
    C_M: float = 12.0
    ambient: float = 25.0
    """[°C]"""
    film: float = 150.0
    """[W/(m² K)], printed without a unit."""
    G_A: float = 26.9e9
    """[Pa]"""
    G_M: float = 17e9
    R_A: float = 0.7246
    """[ohm]"""
    R_M: float = 0.8197
    # Section 4
    high: float = 5.0
    """[V]"""
    low: float = 3.0
    """[V]"""
    current: float = 2.5
    """Largest current [A]."""
    contraction: float = 0.03
    """"Complete contraction" of a spring [m]."""
    angle: float = 25.0
    """Of the response times [°]."""
    fast: float = 18.0
    """Response time at the high voltage [s]."""
    slow: float = 30.0
    """At the low voltage, "around" [s]."""
    target: float = 30.0
    """Of the ON/OFF control [°]."""
