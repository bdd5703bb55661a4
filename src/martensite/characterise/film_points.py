"""Steady states of a heated wire as points of a film coefficient.

Every steady state gives

    h = P/[S (T - T_a)],    S = π d l,    P = V²/R = V I,

with the power P in the wire, its lateral surface S and the ambient temperature T_a. What is
measured is the flux P/S and T; h follows from them and from T_a, which is why the points keep
their ambient temperature and can be moved to another one.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from martensite.base.errors import DataError, ParameterError
from martensite.characterise.columns import check_columns

ABSOLUTE_ZERO = -273.15
"""[°C]"""


@dataclass(frozen=True)
class FilmPoints:
    """Film coefficients at temperatures, and the ambient temperature that they rest on."""

    temperatures_degC: tuple[float, ...]
    """Steady temperatures [°C]."""
    h: tuple[float, ...]
    """Film coefficients [W/(m² K)]."""
    ambient_degC: float | None = None
    """Ambient temperature [°C]; None if it is not known."""

    def __post_init__(self) -> None:
        """Raise `DataError` if a point cannot be one of a wire heated above its ambient."""
        columns = {"temperatures": self.temperatures_degC, "film_coefficients": self.h}
        check_columns("a wire", "points", 2, **columns)
        if min(self.h) <= 0.0:
            raise DataError(f"Film coefficients must be above 0, but one is {min(self.h):.6g}.")
        if self.ambient_degC is not None:
            _check_ambient(self.ambient_degC, self.temperatures_degC)

    def __len__(self) -> int:
        return len(self.h)

    @property
    def ambient(self) -> float:
        """Ambient temperature [°C].

        Raises:
            DataError: it is not known.
        """
        if self.ambient_degC is None:
            raise DataError("The ambient temperature of these film coefficients is not known.")
        return self.ambient_degC

    @property
    def fluxes(self) -> tuple[float, ...]:
        """Heat flux P/S through the surface [W/m²]: measured, whatever the ambient was."""
        pairs = zip(self.temperatures_degC, self.h, strict=True)
        return tuple(h * (at - self.ambient) for at, h in pairs)

    def at_ambient(self, ambient_degC: float) -> FilmPoints:
        """The same fluxes and temperatures had the ambient been another one [°C]."""
        _check_ambient(ambient_degC, self.temperatures_degC)
        return FilmPoints(
            self.temperatures_degC,
            tuple(flux / (at - ambient_degC) for at, flux in zip(self.temperatures_degC, self.fluxes, strict=True)),
            ambient_degC,
        )

    def to_dict(self) -> dict[str, Any]:
        """All numbers by name, for JSON."""
        return {name: list(v) if isinstance(v, tuple) else v for name, v in vars(self).items()}


def points_from_power(
    temperatures_degC: Sequence[float], powers: Sequence[float], *, diameter: float, length: float, ambient_degC: float
) -> FilmPoints:
    """Film coefficients of a wire from steady temperatures and heating powers.

    Args:
        temperatures_degC: steady temperatures [°C].
        powers: heating powers [W].
        diameter: diameter of the wire [m].
        length: length of the wire [m].
        ambient_degC: ambient temperature [°C].

    Raises:
        ParameterError: the diameter or the length is not above 0.
        DataError: the points are not of a wire heated above its ambient.
    """
    if not (0.0 < diameter < math.inf and 0.0 < length < math.inf):
        raise ParameterError(f"Diameter and length must be above 0 m, but are {diameter:g} m and {length:g} m.")
    check_columns("a wire", "points", 2, temperatures=temperatures_degC, powers=powers)
    _check_ambient(ambient_degC, temperatures_degC)
    surface = math.pi * diameter * length
    pairs = zip(temperatures_degC, powers, strict=True)
    h = tuple(power / (surface * (at - ambient_degC)) for at, power in pairs)
    return FilmPoints(tuple(temperatures_degC), h, ambient_degC)


def powers_from_voltage(voltages: Sequence[float], resistances: Sequence[float] | float) -> list[float]:
    """Heating powers V²/R [W] from voltages [V] and one resistance, or one per voltage [ohm].

    Raises:
        ParameterError: a resistance is not above 0.
        DataError: resistances and voltages are not equally many.
    """
    each = [resistances] * len(voltages) if isinstance(resistances, (int, float)) else resistances
    if len(each) != len(voltages):
        raise DataError(f"There must be one resistance per voltage, but there are {len(each)} and {len(voltages)}.")
    if not all(ohms > 0.0 for ohms in each):
        raise ParameterError(f"A resistance must be above 0 ohm, but one is {min(each):g} ohm.")
    return [volts * volts / ohms for volts, ohms in zip(voltages, each, strict=True)]


def _check_ambient(ambient: float, temperatures: Sequence[float]) -> None:
    coldest = min(temperatures)
    if not ABSOLUTE_ZERO <= ambient < coldest:
        raise DataError(
            f"The ambient temperature must be below the coldest point, {coldest:g} degC, but is {ambient:g} degC."
        )
