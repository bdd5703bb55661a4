"""Layout of the paths of a material point: legs, choices, and properties of the law.

Default values follow from simulations of the law (`simulate.transformation_points`): transformation temperatures
without load, and stress and strain at the end of a transformation.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from functools import cached_property

from martensite.base.errors import ParameterError
from martensite.kernels import floats
from martensite.physics.laws.base import AbstractLaw, Fractions
from martensite.simulate.compiled_law import AUSTENITE
from martensite.simulate.point import PathLeg, PointResult, material_point
from martensite.simulate.transformation_points import LoadingPoint, Marks, find_isobar, find_loaded

TWINNED, ORIENTED = Fractions(1.0, 0.0), Fractions(1.0, 1.0)
STARTS = {"austenite": AUSTENITE, "martensite": ORIENTED, "twinned": TWINNED}
"""Phase states by name: `martensite` is fully oriented, `twinned` is not oriented."""
ZERO = 273.15


@dataclass(frozen=True)
class PathRates:
    """Rates along paths, for rate-dependent laws."""

    temperature: float = 1.0
    """[K/s]"""
    stress: float = 10e6
    """[Pa/s]"""
    strain: float = 1e-3
    """[1/s]"""


@dataclass(frozen=True)
class Choices:
    """Choices for a path; other values follow from the law."""

    temperatures: tuple[float, ...] = ()
    """[K]"""
    stresses: tuple[float, ...] = ()
    """[Pa]"""
    strain: float | None = None
    """[-]"""
    fractions: Fractions | None = None
    """Phase state at the start."""
    rates: PathRates = field(default_factory=PathRates)


@dataclass(frozen=True)
class ThermomechanicalPath:
    """Path with its start and its legs."""

    label: str
    stress: float
    """At the start [Pa]."""
    temperature: float
    """At the start [K]."""
    fractions: Fractions
    legs: tuple[PathLeg, ...]

    def follow(
        self, law: AbstractLaw, *, steps: int = 100, tolerance: float | None = 1e-4, runtime: str = "floats"
    ) -> PointResult:
        """Simulate the law along this path; for arguments see `material_point`."""
        return material_point(
            law,
            self.legs,
            start=(self.stress, self.temperature),
            fractions=self.fractions,
            steps=steps,
            tolerance=tolerance,
            runtime=runtime,
            label=self.label,
        )


@dataclass(frozen=True)
class Guide:
    """Law with choices and the values that follow from both."""

    law: AbstractLaw
    choices: Choices

    @cached_property
    def marks(self) -> Marks:
        """Return the transformation temperatures without load [K]."""
        return self.marks_at(0.0)

    def marks_at(self, stress: float) -> Marks:
        """Return the transformation temperatures at a stress [K]."""
        marks = find_isobar(self.law, stress)
        if any(math.isnan(value) for value in marks):
            raise ParameterError(
                f"The law `{self.law.registered_name}` does not transform fully between 100 K and "
                f"800 K at {stress / 1e6:.4g} MPa; choose other parameters or your own path."
            )
        return marks

    @cached_property
    def cold_state(self) -> tuple[float, Fractions]:
        """Return a temperature with stable martensite without load, and the initial phase state.

        The state is twinned martensite below M_f if stress orients it, else austenite between M_s and A_s.
        """
        temperature = self.marks.M_f - 10.0
        fractions = TWINNED
        if not (self.law.has_twins and find_loaded(self.law, temperature, TWINNED)):
            temperature = 0.5 * (self.marks.M_s + self.marks.A_s)
            fractions = AUSTENITE
        if self.choices.temperatures:
            temperature = self.choices.temperatures[0]
        return temperature, self.choices.fractions or fractions

    def hot(self, *above: float) -> tuple[float, ...]:
        """Return the chosen temperatures [K], or temperatures above A_f."""
        return self.choices.temperatures or tuple(self.marks.A_f + more for more in above)

    def top(self, temperature: float, fractions: Fractions) -> LoadingPoint:
        """Return the point at which loading completes the transformation."""
        point = find_loaded(self.law, round(temperature, 6), fractions)
        if point is None or point.stress < 1e6:
            point = find_loaded(self.law, round(temperature, 6), AUSTENITE)
        if point is None:
            raise ParameterError(
                f"The law `{self.law.registered_name}` is not transformed by 3 GPa at "
                f"{temperature - ZERO:.4g} degC; choose another temperature."
            )
        return point

    def rest(self, temperature: float, fractions: Fractions) -> float:
        """Return the strain without load [-]."""
        return self.law.strain(floats, fractions, 0.0, temperature)

    def load(self, temperature: float, fractions: Fractions) -> float:
        """Return the chosen stress, or a rounded stress beyond the end of the transformation [Pa]."""
        if self.choices.stresses:
            return self.choices.stresses[0]
        return 10e6 * math.ceil((1.08 * self.top(temperature, fractions).stress + 15e6) / 10e6)

    def stress(self, change: float, end: float) -> PathLeg:
        """Return a leg that changes stress."""
        return PathLeg(stress=end, duration=_compute_time(change, self.choices.rates.stress))

    def strain(self, change: float, end: float) -> PathLeg:
        """Return a leg that changes strain."""
        return PathLeg(strain=end, duration=_compute_time(change, self.choices.rates.strain))

    def heat(self, begin: float, end: float, hold: str | None = None) -> PathLeg:
        """Return a leg that changes temperature."""
        duration = _compute_time(end - begin, self.choices.rates.temperature)
        return PathLeg(temperature=end, hold=hold, duration=duration)


def _compute_time(change: float, rate: float) -> float:
    return max(abs(change) / rate, 1e-3)


def format_celsius(temperature: float) -> str:
    """Return a temperature for a label."""
    return f"{temperature - ZERO:.4g} °C"


def format_megapascal(stress: float) -> str:
    """Return a stress for a label."""
    return f"{stress / 1e6:.4g} MPa"
