"""Question of a design: free parameters, the quantity to minimise or maximise, and constraints.

    free        element.diameter=0.05..0.5 mm      mechanism.offset=1.5..8 mm      drive.peak=1..5 W
    goal        energy                             max(temperature)                element.count
    subject     max(stress) <= 200 MPa             stroke >= 30 deg                rise-time <= 1 s

A goal, and the left side of a constraint, is a measure of a run (`martensite.simulate.measures`) or
a free number itself. With several cases, such as a cold and a warm room, the goal is the mean over
them, and constraints must hold in each.

Life of a design: it stays within the limits that its elements declare, with a margin,

    max(stress)      <= (1 - m) stress_limit
    stroke(strain)   <= (1 - m) strain_limit
    max(hottest)     <= T_a + (1 - m) (temperature_limit - T_a)

m is the margin and T_a the ambient temperature. The limits belong to the material, which names their sources: a working
stress such as the 172 MPa of the maker of Flexinol, a largest strain, a highest temperature. A fatigue law with a
source is not available, so a design within these limits does not imply a number of cycles.
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
    """Something that a design is judged by."""

    words: str
    unit: str
    """SI"""
    measure: AbstractMeasure | None = None
    place: int | None = None
    """Index of the free parameter that is the aim; None for a measure."""


@dataclass(frozen=True)
class Constraint:
    """A limit of something that a design is judged by."""

    aim: DesignAim
    most: bool
    """True if the limit is the largest value allowed, else it is the smallest."""
    limit: float
    """SI"""
    note: str = ""
    """Origin of a constraint that was not given explicitly."""

    @property
    def words(self) -> str:
        """Return the constraint as text, such as `max(stress) <= 200 MPa`."""
        unit = units.choose_familiar_unit(self.limit, self.aim.unit)
        number = f"{units.from_si(self.limit, unit, self.aim.unit):.6g}"
        sign = "<=" if self.most else ">="
        return f"{self.aim.words} {sign} {number}{'' if unit == '1' else f' {unit}'}"

    @property
    def scale(self) -> float:
        """Return a difference that counts, in SI."""
        if self.aim.unit == "K":
            return BOX_TEMPERATURE
        return abs(self.limit) or 1.0

    @property
    def sign(self) -> float:
        """1 if more of it is better, else -1."""
        return -1.0 if self.most else 1.0


@dataclass(frozen=True)
class DesignQuestion:
    """Free parameters, goal and constraints of a design."""

    free: tuple[FreeNumber, ...]
    goal: DesignAim
    most: bool
    """True if the goal shall be as large as it can, else as small."""
    subject: tuple[Constraint, ...] = ()
    cases: tuple[Mapping[str, float], ...] = ({},)
    """Numbers of the system by path that differ from case to case."""

    @property
    def aims(self) -> tuple[DesignAim, ...]:
        """Return the goal, then what is constrained."""
        return self.goal, *(one.aim for one in self.subject)


def read_question(
    steering: WaveformLevels,
    free: Sequence[str],
    goal: str,
    subject: Sequence[str] = (),
    *,
    most: bool = False,
    cases: Sequence[str] = (),
    written: Mapping[str, str] | None = None,
) -> DesignQuestion:
    """Return the question that texts ask about a system.

    Args:
        steering: the system and its waveforms.
        free: such as `element.diameter=0.05..0.5 mm`.
        goal: a measure or a free number.
        subject: such as `max(stress) <= 200 MPa`.
        most: whether the goal shall be as large as it can.
        cases: more cases, each the numbers that differ, such as `environment.temperature=35 degC`.
        written: path in the system -> path in the scenario.

    Raises:
        InputError: a text that cannot be read, an unknown name, a wrong unit.
    """
    if not free:
        raise ParameterError("Nothing is free: name what may change, such as `element.diameter=0.05..0.5 mm`.")
    known = list_targets(steering, written)
    freed = tuple(read_design_number(text, known, steering.system) for text in free)
    paths = [target.path for one in freed for target in one.targets]
    twice = next((path for path in paths if paths.count(path) > 1), None)
    if twice is not None:
        raise ParameterError(f"`{twice}` is listed as free more than once.")
    aim = read_aim(goal, steering, freed)
    limits = tuple(read_constraint(text, steering, freed) for text in subject)
    return DesignQuestion(freed, aim, most, limits, ({}, *(_read_case(text, known, freed) for text in cases)))


def read_aim(words: str, steering: WaveformLevels, freed: Sequence[FreeNumber]) -> DesignAim:
    """Return a measure, or a free number by its name or path.

    Raises:
        ParameterError: it is neither, or no output of the system is called so.
    """
    words = words.strip()
    for place, one in enumerate(freed):
        if words == one.name or any(words in (c.path, c.name) for c in one.targets):
            return DesignAim(one.name, one.unit, place=place)
    name = words.partition("(")[0].strip()
    if name not in MEASURES.names():
        valid = [*MEASURES.names(), *(one.name for one in freed)]
        raise ParameterError(f"`{words}` is neither a measure nor a free parameter. {suggest_name(name, valid)}")
    found = parse_measure(words)
    return DesignAim(words, found.unit_in(steering.system), found)


def read_constraint(text: str, steering: WaveformLevels, freed: Sequence[FreeNumber]) -> Constraint:
    """Read a constraint from a text such as `max(stress) <= 200 MPa`.

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


def _read_case(text: str, known: Sequence[Target], freed: Sequence[FreeNumber]) -> dict[str, float]:
    """Return the numbers of the system that differ in a case."""
    found: dict[str, float] = {}
    free = {target.path for one in freed for target in one.targets}
    for piece in text.split(","):
        match = _SETTING.match(piece)
        if match is None:
            raise ParameterError(f"`{text}` is no case; write what differs, such as `environment.temperature=35 degC`.")
        for target in find_alike(match[1], known):
            if target.path in free or target.level is not None:
                what = "is free" if target.path in free else "is a level of a waveform"
                raise ParameterError(f"`{match[1]}` {what} and cannot differ from case to case.")
            try:
                found[target.path] = units.parse_quantity(match[2], target.unit)
            except UnitError as error:
                raise UnitError(f"Case `{text}`: {error}") from None
    return found


# ---------------------------------------------------------------- limits of the elements


NOTE = "limit of the element"


def build_life_constraints(
    steering: WaveformLevels, freed: Sequence[FreeNumber], margin: float = 0.0
) -> list[Constraint]:
    """Return constraints that keep every element within its limits; empty without declared limits and margin.

    The margin is the share of every limit that is left, 0 to below 1.

    Raises:
        ParameterError: the margin is none, or one of limits that no element declares.
    """
    if not 0.0 <= margin < 1.0:
        words = "a number of cycles has a source for straight Flexinol wires only, see `size --life`"
        raise ParameterError(f"A margin of life must be at least 0 and below 1, but is {margin}; {words}.")
    system, found = steering.system, list[Constraint]()
    for port, one in system.actuators().items():
        for form, name, limit in _list_limits(one, margin):
            aim = read_aim(form.format(system.label(port, name)), steering, freed)
            found.append(Constraint(aim, True, limit, NOTE))
    if margin and not found:
        raise ParameterError(
            "No element declares a limit, so nothing is known of its life; give it some, such as "
            'stress_limit = "172 MPa" in `limits` of the element, or constrain the stress itself.'
        )
    return found


def _list_limits(one: Actuator, margin: float) -> Iterator[tuple[str, str, float]]:
    """Measure, output and limit [SI] of everything that is limited."""
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
        margin: share of the limits that is left; None if limits are ignored.
        missed: constraints that the design misses.
        exceeded: limits that its runs exceed, in words.
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
    kept = ", ".join(f"{one.words}" for one in constraints)
    left = f" with {100.0 * margin:.3g} % to spare" if margin else ""
    return (
        f"Life: the limits that the elements declare are kept{left} ({kept}). No law of fatigue is "
        "known here, so this is no number of cycles."
    )
