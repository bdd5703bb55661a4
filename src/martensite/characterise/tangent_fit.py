"""Transformation temperatures over stress by the tangent method, with Clausius–Clapeyron slopes.

Stresses are set and temperatures measured, so temperature is fitted against stress:

    T_i = T_0 + b σ_i,    C = 1/b

This is done for each of A_s, A_f, M_s, M_f and the half-way temperatures. Each direction is also fitted with a common
slope of start and finish:

    A_s,i = A_s + b_A σ_i,    A_f,i = A_f + b_A σ_i;    M_s, M_f and b_M alike.

The least-squares common slope is the slope of the middles (A_s,i + A_f,i)/2. Start and finish at zero stress lie half
the mean width below and above the middle. Errors of start and finish at one stress may be correlated, so errors of
middles and widths are added as independent, with the degrees of freedom of Welch and Satterthwaite. Errors at
different stresses are independent, with n - 2 degrees of freedom for a slope; with two stresses, intervals are
unbounded. The interval of C is the inverted interval of b.

The transformation strain over stress is constant or saturates (`martensite.characterise.transformation_strain`). The
results are a first guess, good to a few kelvin, because tangents cut off the round ends of real transformations.
`TangentFit.guess` widens the strips for laws with cosine kinetics.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from martensite.base.confidence import EVERYTHING, LEVEL, Interval
from martensite.base.errors import DataError, ParameterError, suggest_name
from martensite.characterise.estimate import MeasuredValue
from martensite.characterise.regression import LinearFit, fit_powers
from martensite.characterise.tangent_lines import COSINE
from martensite.characterise.tangent_points import TangentPoints, find_tangent_points
from martensite.characterise.transformation_strain import StrainFit, fit_transformation_strain
from martensite.signals.records import Record


@dataclass(frozen=True)
class Direction:
    """Direction of the transformation over stress."""

    names: tuple[str, str]
    """Names of its start and finish temperature."""
    start: MeasuredValue
    """At zero stress, along the common slope [K]."""
    finish: MeasuredValue
    """At zero stress, along the common slope [K]."""
    shift: MeasuredValue
    """Common slope b of temperature against stress [K/Pa]."""
    own: dict[str, LinearFit]
    """Start, finish and half-way temperature, each with a separate slope over stress."""
    widening: float
    """Probability of the change of width with stress if the slopes are equal; NaN without degrees of freedom."""

    @property
    def slope(self) -> float:
        """Return the Clausius–Clapeyron slope C = 1/b [Pa/K], negative for falling temperatures."""
        return 1.0 / self.shift.value if self.shift.value else math.inf

    def slope_interval(self, level: float = LEVEL) -> Interval:
        """Return the confidence interval of C [Pa/K]; unbounded if the interval of b contains zero."""
        return invert_interval(self.shift.interval(level))

    def to_dict(self, level: float = LEVEL) -> dict[str, Any]:
        """Return all numbers by name, for JSON."""
        own = {
            name: {
                "zero_stress": fit.coefficient(0).to_dict(level),
                "slope": 1.0 / fit.values[1] if fit.values[1] else None,
                "slope_interval": list(invert_interval(fit.interval(1, level))),
            }
            for name, fit in self.own.items()
        }
        return {
            self.names[0]: self.start.to_dict(level),
            self.names[1]: self.finish.to_dict(level),
            "slope": self.slope,
            "slope_interval": list(self.slope_interval(level)),
            "separately": own,
            "widening_p_value": self.widening,
        }


def fit_direction(levels: Sequence[TangentPoints], names: tuple[str, str], half: str) -> Direction:
    """Fit start, finish (`names`) and half-way temperature of a direction over two or more stresses."""
    stresses = [points.stress for points in levels]
    columns = {name: [getattr(p, name) for p in levels] for name in (*names, half)}
    own = {name: fit_powers(stresses, column, (0, 1)) for name, column in columns.items()}
    pairs = list(zip(*(columns[name] for name in names), strict=True))
    widths = [b - a for a, b in pairs]
    middle = fit_powers(stresses, [0.5 * (a + b) for a, b in pairs], (0, 1))
    width = fit_powers(stresses, widths, (0,)).coefficient(0)
    start, finish = (_add_width(middle.coefficient(0), width, sign) for sign in (-0.5, 0.5))
    widening = fit_powers(stresses, widths, (0, 1)).p_value(1)
    return Direction(names, start, finish, middle.coefficient(1), own, widening)


def _add_width(middle: MeasuredValue, width: MeasuredValue, sign: float) -> MeasuredValue:
    """Return middle + sign width, with independent errors."""
    value = middle.value + sign * width.value
    parts = (middle.error**2, middle.freedom), ((sign * width.error) ** 2, width.freedom)
    total = sum(square for square, _ in parts)
    if not total > 0.0:  # scatter is zero or unknown
        return MeasuredValue(value, math.sqrt(total), middle.freedom)
    freedom = total**2 / sum(square**2 / spare for square, spare in parts)
    return MeasuredValue(value, math.sqrt(total), freedom)


def invert_interval(interval: Interval) -> Interval:
    """Return the interval of 1/b from the interval of b; unbounded if b may be zero."""
    low, high = interval
    if low <= 0.0 <= high:
        return EVERYTHING
    return 1.0 / high, 1.0 / low


ENDS = ("tangents", "cosine")
DISTINCT = 1e5
"""Least range of the stresses [Pa]."""


@dataclass(frozen=True)
class TangentFit:
    """Results of the tangent method for cycles under several stresses."""

    levels: tuple[TangentPoints, ...]
    """Results of the cycles in the order of stress."""
    reverse: Direction
    """Transformation to austenite: A_s, A_f, C_A."""
    forward: Direction
    """Transformation to martensite: M_s, M_f, C_M."""
    strain: StrainFit
    """H(σ)."""

    @property
    def A_s(self) -> MeasuredValue:
        """Return the austenite start temperature at zero stress [K]."""
        return self.reverse.start

    @property
    def A_f(self) -> MeasuredValue:
        """Return the austenite finish temperature at zero stress [K]."""
        return self.reverse.finish

    @property
    def M_s(self) -> MeasuredValue:
        """Return the martensite start temperature at zero stress [K]."""
        return self.forward.start

    @property
    def M_f(self) -> MeasuredValue:
        """Return the martensite finish temperature at zero stress [K]."""
        return self.forward.finish

    @property
    def C_A(self) -> float:
        """Clausius–Clapeyron slope of the reverse transformation [Pa/K]."""
        return self.reverse.slope

    @property
    def C_M(self) -> float:
        """Clausius–Clapeyron slope of the forward transformation [Pa/K]."""
        return self.forward.slope

    @property
    def eps_L(self) -> MeasuredValue:
        """Return the mean transformation strain [-]."""
        return self.strain.mean

    @property
    def remarks(self) -> tuple[str, ...]:
        """Return remarks in sentences; remarks on cycles begin with their names."""
        remarks = [f"{points.name}: {text}" for points in self.levels for text in points.remarks]
        for name, direction in (("C_A", self.reverse), ("C_M", self.forward)):
            low, high = direction.slope_interval()
            if not (direction.slope > 0.0 and (low > 0.0 or len(self.levels) == 2)):
                remarks.append(
                    f"{name} is not found: its interval, {low / 1e6:.3g} to {high / 1e6:.3g} "
                    "MPa/K, allows temperatures that do not rise with stress."
                )
            elif direction.widening < 1.0 - LEVEL:
                slopes = (1e-6 / direction.own[each].values[1] for each in direction.names)
                remarks.append(
                    f"{' and '.join(direction.names)} rise differently with stress, by themselves at "
                    f"{' and '.join(f'{slope:.3g}' for slope in slopes)} MPa/K: {name} is a "
                    "compromise."
                )
        return tuple(remarks)

    def guess(self, ends: str = "tangents") -> dict[str, float]:
        """Return the identified law parameters by canonical name, in SI.

        Slopes of the outer lines are omitted: they are not thermal expansions if transformation trails off. `eps_L` is
        the mean transformation strain. `H_min`, `H_sat` and `H_k` describe H(σ); if it is constant, the first two are
        the mean.

        Args:
            ends: `tangents` for the intersections, or `cosine` for strips π/2 times as wide about the same middle. The
                tangents of these cosines have the same intersections.

        Raises:
            ParameterError: `ends` is neither.
        """
        if ends not in ENDS:
            raise ParameterError(f"Argument `ends` is `{ends}`. {suggest_name(ends, ENDS)}")
        parameters: dict[str, float] = {}
        for name, one in (("C_A", self.reverse), ("C_M", self.forward)):
            strip = one.start.value, one.finish.value
            wider = COSINE if ends == "cosine" else 1.0
            middle, half = 0.5 * sum(strip), 0.5 * wider * (strip[1] - strip[0])
            parameters |= dict(zip(one.names, (middle - half, middle + half), strict=True))
            if one.slope > 0.0:
                parameters[name] = one.slope
        parameters |= {"eps_L": self.strain.mean.value}
        for name in ("H_min", "H_sat", "H_k", "sigma_crit"):
            estimate: MeasuredValue | None = getattr(self.strain, name)
            if estimate is not None:
                parameters[name] = estimate.value
        return parameters

    def to_dict(self, level: float = LEVEL) -> dict[str, Any]:
        """Return all values by name in SI, for JSON; without the rows."""
        return {
            "levels": [points.to_dict() for points in self.levels],
            "reverse": self.reverse.to_dict(level),
            "forward": self.forward.to_dict(level),
            "transformation_strain": self.strain.to_dict(level),
            "guess": self.guess(),
            "remarks": list(self.remarks),
        }


def fit_tangents(
    cycles: Sequence[Record | TangentPoints], *, stresses: Sequence[float] | None = None, cycle: int = -1
) -> TangentFit:
    """Read isobaric cycles under several stresses by the tangent method.

    Args:
        cycles: records for `find_tangent_points`, or its results.
        stresses: constant stress of each record [Pa], by default from its column. Results keep their stress.
        cycle: index of the cycle in each record, by default the last.

    Raises:
        DataError: a record has no isobaric cycle, or all stresses are equal.
        ParameterError: stresses and records differ in length.
    """
    if stresses is not None and len(stresses) != len(cycles):
        raise ParameterError(f"There must be one stress per record, but there are {len(stresses)} and {len(cycles)}.")
    given = [None] * len(cycles) if stresses is None else stresses
    levels = [_read_points(one, stress, cycle) for one, stress in zip(cycles, given, strict=True)]
    levels.sort(key=lambda points: points.stress)
    if not levels or levels[-1].stress - levels[0].stress < DISTINCT:
        raise DataError(
            "C_A and C_M need cycles at two or more different stresses, but there "
            f"{_count_levels(levels)}; `tangent_points` reads a single cycle."
        )
    return TangentFit(
        tuple(levels),
        reverse=fit_direction(levels, ("A_s", "A_f"), "A_half"),
        forward=fit_direction(levels, ("M_s", "M_f"), "M_half"),
        strain=fit_transformation_strain([p.stress for p in levels], [p.H for p in levels]),
    )


def _read_points(one: Record | TangentPoints, stress: float | None, cycle: int) -> TangentPoints:
    if isinstance(one, TangentPoints):
        return one
    return find_tangent_points(one, stress=stress, cycle=cycle)


def _count_levels(levels: Sequence[TangentPoints]) -> str:
    """Describe the number of cycles and their stress."""
    if not levels:
        return "are none"
    at = f"at {levels[0].stress / 1e6:.4g} MPa"
    return f"is only one, {at}" if len(levels) == 1 else f"are {len(levels)}, all {at}"
