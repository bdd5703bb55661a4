"""Question of a design: free parameters, a goal and constraints.

    free        element.diameter=0.05..0.5 mm      mechanism.offset=1.5..8 mm      drive.peak=1..5 W
    goal        energy                             max(temperature)                element.count
    subject     max(stress) <= 200 MPa             stroke >= 30 deg                rise-time <= 1 s

A goal, and the left side of a constraint, is a measure of a run (`martensite.simulate.measures`) or a free parameter.
With several cases, such as a cold and a warm room, the goal is the mean over them, and constraints hold in each.

The life of a design: it stays within the declared limits of its elements with a margin m,

    max(stress)      <= (1 - m) stress_limit
    stroke(strain)   <= (1 - m) strain_limit
    max(hottest)     <= T_a + (1 - m) (temperature_limit - T_a)

T_a is the ambient temperature. The limits and their sources belong to the material. A fatigue law with a source is not
available, so these limits do not imply a number of cycles.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

from martensite.actuators.assembly import Actuator
from martensite.base import units
from martensite.base.errors import ParameterError, UnitError, suggest_name
from martensite.design.optimise.targets import list_targets, read_design_number
from martensite.search.free_numbers import BOX_TEMPERATURE, FreeNumber, Target, find_alike
from martensite.simulate.measures.base import MEASURES, AbstractMeasure, parse_measure
from martensite.simulate.waveform_levels import WaveformLevels

_CONSTRAINT = re.compile(r"^(.*?[^<>=\s])\s*(<=|>=|<|>|≤|≥)\s*(.*?)\s*$")
_SETTING = re.compile(r"^\s*([^=\s]+)\s*=\s*(.*?)\s*$")


@dataclass(frozen=True)
class DesignAim:
    """Quantity that judges a design."""

    words: str
    unit: str
    """SI"""
    measure: AbstractMeasure | None = None
    place: int | None = None
    """Index of the free parameter that is the aim; None for a measure."""


@dataclass(frozen=True)
class Constraint:
    """Limit of an aim."""

    aim: DesignAim
    is_upper_limit: bool
    """True for an upper limit."""
    limit: float
    """SI"""
    note: str = ""
    """Origin of an implicit constraint."""

    @property
    def words(self) -> str:
        """Return the constraint as text, such as `max(stress) <= 200 MPa`."""
        unit = units.choose_familiar_unit(self.limit, self.aim.unit)
        number = f"{units.from_si(self.limit, unit, self.aim.unit):.6g}"
        sign = "<=" if self.is_upper_limit else ">="
        return f"{self.aim.words} {sign} {number}{'' if unit == '1' else f' {unit}'}"

    @property
    def scale(self) -> float:
        """Return a significant difference, in SI."""
        if self.aim.unit == "K":
            return BOX_TEMPERATURE
        return abs(self.limit) or 1.0

    @property
    def sign(self) -> float:
        """Return 1 if larger values are better, else -1."""
        return -1.0 if self.is_upper_limit else 1.0


@dataclass(frozen=True)
class DesignQuestion:
    """Free parameters, goal and constraints of a design."""

    free: tuple[FreeNumber, ...]
    goal: DesignAim
    is_maximised: bool
    """True to maximise the goal."""
    subject: tuple[Constraint, ...] = ()
    cases: tuple[Mapping[str, float], ...] = ({},)
    """Values by path of each case."""

    @property
    def aims(self) -> tuple[DesignAim, ...]:
        """Return the goal, then the constrained quantities."""
        return self.goal, *(one.aim for one in self.subject)


def read_question(
    steering: WaveformLevels,
    free: Sequence[str],
    goal: str,
    subject: Sequence[str] = (),
    *,
    most: bool = False,
    cases: Sequence[str] = (),
    scenario_paths: Mapping[str, str] | None = None,
) -> DesignQuestion:
    """Return the question of texts about a system.

    Args:
        steering: system and its waveforms.
        free: free parameters, such as `element.diameter=0.05..0.5 mm`.
        goal: measure or free parameter.
        subject: constraints, such as `max(stress) <= 200 MPa`.
        most: maximise the goal.
        cases: further cases with their values, such as `environment.temperature=35 degC`.
        scenario_paths: path in the scenario by path in the system.

    Raises:
        InputError: a text is malformed, a name is unknown, or a unit is wrong.
    """
    if not free:
        raise ParameterError("Nothing is free: name what may change, such as `element.diameter=0.05..0.5 mm`.")
    targets = list_targets(steering, scenario_paths)
    freed = tuple(read_design_number(text, targets, steering.system) for text in free)
    paths = [target.path for one in freed for target in one.targets]
    twice = next((path for path in paths if paths.count(path) > 1), None)
    if twice is not None:
        raise ParameterError(f"`{twice}` is listed as free more than once.")
    aim = read_aim(goal, steering, freed)
    limits = tuple(read_constraint(text, steering, freed) for text in subject)
    return DesignQuestion(freed, aim, most, limits, ({}, *(_read_case(text, targets, freed) for text in cases)))


def read_aim(words: str, steering: WaveformLevels, freed: Sequence[FreeNumber]) -> DesignAim:
    """Return a measure, or a free parameter by its name or path.

    Raises:
        ParameterError: it is neither, or its output is unknown.
    """
    words = words.strip()
    for place, one in enumerate(freed):
        if words == one.name or any(words in (c.path, c.name) for c in one.targets):
            return DesignAim(one.name, one.unit, place=place)
    name = words.partition("(")[0].strip()
    if name not in MEASURES.names():
        valid = [*MEASURES.names(), *(one.name for one in freed)]
        raise ParameterError(f"`{words}` is neither a measure nor a free parameter. {suggest_name(name, valid)}")
    measure = parse_measure(words)
    return DesignAim(words, measure.unit_in(steering.system), measure)


def read_constraint(text: str, steering: WaveformLevels, freed: Sequence[FreeNumber]) -> Constraint:
    """Return the constraint of a text such as `max(stress) <= 200 MPa`.

    Raises:
        InputError: the text is malformed, or the limit has another unit.
    """
    match = _CONSTRAINT.match(text.strip())
    if match is None:
        raise ParameterError(
            f"`{text}` is no constraint; write a measure, <= or >=, and a limit, such as `max(stress) <= 200 MPa`."
        )
    words, sign, limit = match.groups()
    aim = read_aim(words, steering, freed)
    try:
        return Constraint(aim, sign in ("<=", "<", "≤"), units.parse_quantity(limit, aim.unit))
    except UnitError as error:
        raise UnitError(f"Constraint `{text}`: {error}") from None


def _read_case(text: str, targets: Sequence[Target], freed: Sequence[FreeNumber]) -> dict[str, float]:
    """Return the parameters of a case by path."""
    values: dict[str, float] = {}
    free = {target.path for one in freed for target in one.targets}
    for piece in text.split(","):
        match = _SETTING.match(piece)
        if match is None:
            raise ParameterError(f"`{text}` is no case; write what differs, such as `environment.temperature=35 degC`.")
        for target in find_alike(match[1], targets):
            if target.path in free or target.level is not None:
                what = "is free" if target.path in free else "is a level of a waveform"
                raise ParameterError(f"`{match[1]}` {what} and cannot differ from case to case.")
            try:
                values[target.path] = units.parse_quantity(match[2], target.unit)
            except UnitError as error:
                raise UnitError(f"Case `{text}`: {error}") from None
    return values


# ---------------------------------------------------------------- limits of the elements


NOTE = "limit of the element"


def build_life_constraints(
    steering: WaveformLevels, freed: Sequence[FreeNumber], margin: float = 0.0
) -> list[Constraint]:
    """Return constraints that keep every element within its declared limits.

    The margin is a fraction of every limit, from 0 to below 1.

    Raises:
        ParameterError: the margin is out of range, or no element declares a limit for it.
    """
    if not 0.0 <= margin < 1.0:
        words = "a number of cycles has a source for straight Flexinol wires only, see `size --life`"
        raise ParameterError(f"A margin of life must be at least 0 and below 1, but is {margin}; {words}.")
    system, constraints = steering.system, list[Constraint]()
    for port, one in system.actuators().items():
        for form, name, limit in _list_limits(one, margin):
            aim = read_aim(form.format(system.label(port, name)), steering, freed)
            constraints.append(Constraint(aim, True, limit, NOTE))
    if margin and not constraints:
        raise ParameterError(
            "No element declares a limit, so nothing is known of its life; give it some, such as "
            'stress_limit = "172 MPa" in `limits` of the element, or constrain the stress itself.'
        )
    return constraints


def _list_limits(one: Actuator, margin: float) -> Iterator[tuple[str, str, float]]:
    """Yield the measure, output and limit [SI] of every declared limit."""
    limits, ambient = one.element.limits, one.environment.temperature
    above = ambient + (1.0 - margin) * (limits.temperature_limit - ambient)
    rows = (
        ("max({})", "stress", (1.0 - margin) * limits.stress_limit),
        ("stroke({})", "strain", (1.0 - margin) * limits.strain_limit),
        ("max({})", "hottest", above),
    )
    for form, name, limit in rows:
        if math.isfinite(limit):
            yield form, name, limit


def describe_life(
    constraints: Sequence[Constraint], margin: float | None, missed: Sequence[str] = (), exceeded: Sequence[str] = ()
) -> str:
    """Return sentences on the life of a design.

    Args:
        constraints: limits of the elements.
        margin: fraction of the limits; None if limits are ignored.
        missed: violated constraints of the design.
        exceeded: exceeded limits, in words.
    """
    if margin is None and exceeded:
        words = f"{len(exceeded)} {'limit' if len(exceeded) == 1 else 'limits'}: {'; '.join(exceeded)}"
        return f"Life: the limits that the elements declare are ignored, as asked. The design exceeds {words}."
    if margin is None:
        return "Life: the limits that the elements declare are ignored, as asked, so nothing is known of it."
    if not constraints:
        return "Life: no element declares a limit, so none is kept and nothing is known of it."
    lost = [one.words for one in constraints if one.words in missed] or exceeded
    if lost:
        return f"Life: limits that the elements declare are not kept ({', '.join(lost)}), so nothing is known of it."
    limits = ", ".join(f"{one.words}" for one in constraints)
    left = f" with {100.0 * margin:.3g} % to spare" if margin else ""
    return (
        f"Life: the limits that the elements declare are kept{left} ({limits}). No law of fatigue is "
        "known here, so this is no number of cycles."
    )
