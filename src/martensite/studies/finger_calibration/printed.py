"""Every number that the paper prints on its calibration, in SI units."""

from __future__ import annotations

from dataclasses import dataclass

PAPER = "finger-paper"
"""Key of the paper in the bibliography."""
METHOD = f"{PAPER}, section 5.2"
TABLE = f"{PAPER}, Table 1"


@dataclass(frozen=True)
class Range:
    """A parameter that the paper searches for."""

    name: str
    value: float
    """In Table 1 [SI]."""
    low: float
    """Of the range that is searched [SI]."""
    high: float


@dataclass(frozen=True)
class Printed:
    """The paper's numbers."""

    # Section 5.2 and Table 1
    searched: tuple[Range, ...] = (
        Range("E_M", 30e9, 15e9, 35e9),
        Range("T_L", 320.0, 295.0, 395.0),
        Range("Delta_sigma", 52e6, 40e6, 150e6),
        Range("sigma_L", 1e6, 0.5e6, 50e6),
        Range("dsigma_dT", 4e6, 4e6, 7e6),
    )
    """"chosen for the optimization", with the admissible range of each."""
    fixed: tuple[tuple[str, float], ...] = (
        ("E_A", 50e9), ("eps_T", 0.04), ("cooling.h", 200.0), ("heat_capacity", 500.0),
        ("latent_heat", 25e3),
    )  # fmt: skip
    """"arbitrarily fixed to conventional values"."""
    frequency: float = 0.015
    """Of the power [Hz]."""
    offsets: tuple[float, ...] = (1.5e-3, 3.5e-3, 5.5e-3)
    """Distances r; the calibration has the first one only [m]."""
    powers: tuple[float, ...] = (1.4, 2.0)
    """Of the tests of Figure 6 [W]; that of the calibration is not printed."""

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the parameters that are searched for."""
        return tuple(one.name for one in self.searched)

    @property
    def table(self) -> tuple[float, ...]:
        """Their values in Table 1 [SI]."""
        return tuple(one.value for one in self.searched)
