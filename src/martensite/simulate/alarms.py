"""Alarms: exceeded limits, with the first time, the duration and the amount.

Alarms are computed from the accepted steps of a run (`martensite.simulate.track`), with straight lines between
points. Short pulses in long runs are therefore included.

| kind | condition | limit |
| --- | --- | --- |
| temperature | the hottest point of the element is too hot | `temperature_limit` |
| stress | the stress is too high | `stress_limit` |
| strain | the strain differs too much from its farthest earlier value | `strain_limit` |
| slack | the element loses its tension | 0 N |
| supply | the demand of the drive is outside the range of the source | `reach` of the source |
| rig | several sources exceed the current of a common supply | its `current_limit` |
| drift | the oriented fraction changes in the first cycle | at the start |
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from martensite.actuators.assembly import AbstractSystem, Actuator, Machine
from martensite.actuators.assembly.base import AbstractSystemAround
from martensite.base.status import Status
from martensite.physics.electrical.base import AbstractSource
from martensite.physics.laws.base import AbstractLaw
from martensite.simulate.compiled_law import describe_compression, describe_forgotten_loops

if TYPE_CHECKING:
    from martensite.simulate.result import Result

Numbers: TypeAlias = NDArray[np.float64]
Values: TypeAlias = Sequence[float] | Numbers
Columns = Mapping[str, Any]
"""Values of outputs by name, in SI."""
FRACTIONS = ("martensite_fraction", "oriented_fraction")
SUPPLY = ("supply_demand", "supply_voltage")
JUDGED = ("hottest", "stress", "strain", "force", "drive", "resistance", *FRACTIONS, *SUPPLY)
"""Judged outputs of an actuator and of a common supply."""
EXACT = ("drive", "resistance", *FRACTIONS)
"""Outputs with extremes at the rows of a track."""
WIDENED = 1.1
"""Factor on changes above which the curve between rows is evaluated."""
ROUNDING = 1e-9
"""Tolerance of a demand above the reach, as a fraction of the demand."""
DRIFT = 0.05
"""Change of the oriented fraction in the first cycle that counts as zero."""
CYCLE = 0.5
"""Change of the martensite fraction that counts as a cycle."""
RETURNED = 0.01
"""Martensite fraction that may be missing after a cycle."""
DOUBT_FRACTION = 0.8
"""Fraction of the doubtful stress of a law that triggers a warning."""
LOADED_ALIKE = 0.2
"""Relative difference of two stresses up to which orientation is compared."""


@dataclass(frozen=True)
class Alarm:
    """Exceeded limit, with all numbers in SI."""

    kind: str
    """temperature, stress, strain, slack, supply, rig or drift."""
    quantity: str
    """Judged output."""
    unit: str
    """SI unit of `worst`, `limit` and `excess`."""
    worst: float
    """Value farthest beyond the limit; the change of a strain, or the demand on a supply."""
    limit: float
    """Limit at that time; the largest deliverable value of a supply."""
    excess: float
    """Distance of both."""
    first: float
    """Time at which the limit was first exceeded [s]."""
    duration: float
    """Total time beyond the limit [s]."""
    worst_time: float
    """Time of the worst value [s]."""
    sentence: str
    """Alarm message."""
    port: str = ""
    """Actuator of the alarm."""


@dataclass(frozen=True)
class RunWarnings:
    """Alarms of a run, and warnings on alarms and on laws outside their range."""

    alarms: Sequence[Alarm] = ()
    sentences: Sequence[str] = ()


@dataclass(frozen=True)
class Excursion:
    """Interval in which a margin is above zero."""

    first: float
    duration: float
    worst: int
    """Index of the largest margin."""

    def words(self) -> str:
        """Return the first time and duration in words."""
        return f"first at t = {self.first:.4g} s, for {self.duration:.3g} s in all"


def find_excursion(times: Values, margins: Values) -> Excursion | None:
    """Return the time in which a margin is above zero, linear between its points; None if never."""
    time, margin = np.asarray(times, float), np.asarray(margins, float)
    worst = int(margin.argmax())
    if not margin[worst] > 0.0:
        return None
    begin, end, length = margin[:-1], margin[1:], np.diff(time)
    high, low = np.maximum(begin, end), np.minimum(begin, end)
    apart = np.where(high > low, high - low, 1.0)
    share = np.where(high > 0.0, np.where(low > 0.0, 1.0, high / apart), 0.0)
    above = np.where(low > 0.0, 1.0, share) * length
    at = int(np.argmax(margin > 0.0))
    first = float(time[at] - (above[at - 1] if at else 0.0))
    return Excursion(first, float(above.sum()), worst)


def alarms_of(system: AbstractSystem, times: Values, columns: Columns) -> list[Alarm]:
    """Return all alarms of a run, from points of its columns in SI."""
    times, columns = np.asarray(times, float), {name: np.asarray(column, float) for name, column in columns.items()}
    alarms: list[Alarm] = []
    alone = len(system.actuators()) == 1 and not system.signals()
    for port, actuator in system.actuators().items():
        own = {name: columns[system.label(port, name)] for name in JUDGED if name not in SUPPLY}
        several = system.label(port, "stress") != "stress"
        alarms += [_at_port(alarm, port) if several else alarm for alarm in _of_actuator(actuator, times, own, alone)]
    return alarms + _watch_supply(system, times, columns)


def _watch_supply(system: AbstractSystem, times: Numbers, columns: Columns) -> list[Alarm]:
    """Return the alarm of a common supply that the sources overload."""
    plant = system.plant if isinstance(system, AbstractSystemAround) else system
    if not isinstance(plant, Machine) or plant.supply is None:
        return []
    limit, demand = plant.supply.current_limit, columns["supply_demand"]
    when = find_excursion(times, demand - limit * (1.0 + ROUNDING))
    if when is None:
        return []
    at, worst = when.worst, float(demand[when.worst])
    sentence = (
        f"Warning: the sources ask the supply for {worst:.4g} A at t = {times[at]:.4g} s, more than its "
        f"`current_limit` of {limit:.4g} A; its voltage falls to {columns['supply_voltage'][at]:.4g} V, {when.words()}."
    )
    return [_make_alarm(times, when, ("rig", "supply_demand", "A"), worst, limit, sentence)]


def _at_port(alarm: Alarm, port: str) -> Alarm:
    sentence = alarm.sentence.replace("Warning: ", f"Warning: `{port}`: ", 1)
    return replace(alarm, port=port, sentence=sentence)


def _of_actuator(actuator: Actuator, times: Numbers, columns: Columns, alone: bool) -> list[Alarm]:
    limits = actuator.element.limits
    hot = "temperature", "K", limits.temperature_limit, 273.15, "°C", 1.0
    high = "stress", "Pa", limits.stress_limit, 0.0, "MPa", 1e6
    candidates = (
        _watch_above(times, columns["hottest"], "hottest", *hot),
        _watch_above(times, columns["stress"], "stress", *high),
        _watch_strain(times, columns["strain"], limits.strain_limit),
        _watch_slack(times, columns["force"]),
        find_undelivered(actuator.source, times, columns["drive"], columns["resistance"]),
        _watch_first_cycle(times, columns, alone),
    )
    return [alarm for alarm in candidates if alarm is not None]


def _make_alarm(
    times: Numbers, when: Excursion, what: tuple[str, str, str], worst: float, limit: float, sentence: str
) -> Alarm:
    at = float(times[when.worst])
    return Alarm(*what, worst, limit, abs(worst - limit), when.first, when.duration, at, sentence)


def _watch_above(
    times: Numbers,
    values: Numbers,
    quantity: str,
    kind: str,
    unit: str,
    limit: float,
    zero: float,
    readable_unit: str,
    scale: float,
) -> Alarm | None:
    when = find_excursion(times, values - limit)
    if when is None:
        return None
    worst = float(values[when.worst])
    sentence = (
        f"Warning: {kind} reaches {(worst - zero) / scale:.4g} {readable_unit}, above the "
        f"`{kind}_limit` of {(limit - zero) / scale:.4g} {readable_unit}, {when.words()}."
    )
    return _make_alarm(times, when, (kind, quantity, unit), worst, limit, sentence)


def _watch_strain(times: Numbers, strain: Numbers, limit: float) -> Alarm | None:
    changes = farthest_changes(strain)
    when = find_excursion(times, changes - limit)
    if when is None:
        return None
    worst = float(changes[when.worst])
    sentence = (
        f"Warning: strain varies by {100 * worst:.3g} %, more than the "
        f"`strain_limit` of {100 * limit:.3g} %, {when.words()}."
    )
    return _make_alarm(times, when, ("strain", "strain", "1"), worst, limit, sentence)


def farthest_changes(strain: Values) -> Numbers:
    """Return the distance of every strain from its farthest earlier value."""
    values = np.asarray(strain, float)
    return np.maximum(np.maximum.accumulate(values) - values, values - np.minimum.accumulate(values))


def _watch_slack(times: Numbers, force: Numbers) -> Alarm | None:
    """Return the alarm of an element that loses its tension; slack has no magnitude."""
    slack = force <= 0.0
    if not slack.any() or slack[0]:
        return None
    at = int(slack.argmax())
    duration = float(np.diff(times)[slack[:-1] & slack[1:]].sum())
    first = float(times[at])
    when = Excursion(first, duration, at)
    sentence = f"Warning: the element is slack (no force), {when.words()}."
    return Alarm("slack", "force", "N", float(force[at]), 0.0, 0.0, first, duration, first, sentence)


def _watch_first_cycle(times: Numbers, columns: Columns, alone: bool) -> Alarm | None:
    """Return the alarm of an oriented fraction that changed in the first cycle.

    Fractions are compared at similar stress. For a single free element they are compared at any stress, since the
    drift changes the stress.
    """
    fraction, oriented = (columns[name] for name in FRACTIONS)
    at = _find_return(fraction, columns["stress"], alone)
    if at is None:
        return None
    shares = float(oriented[0] / fraction[0]), float(oriented[at] / fraction[at])
    if abs(shares[1] - shares[0]) <= DRIFT:
        return None
    strains = columns["strain"][0], columns["strain"][at]
    (start, share), (long, short) = shares, (f"{100 * strain:.3g} %" for strain in strains)
    sentence = (
        f"Warning: the first cycle drifts: {100 * start:.3g} % of the martensite is oriented at "
        f"the start (strain {long}), {100 * share:.3g} % at t = {times[at]:.4g} s (strain "
        f"{short}); use later cycles."
    )
    when = Excursion(float(times[at]), float(times[-1] - times[at]), at)
    what = "drift", "oriented_fraction", "1"
    return _make_alarm(times, when, what, share, start, sentence)


def _find_return(fraction: Numbers, stress: Numbers, alone: bool) -> int | None:
    """Return the point after a first cycle with the stress nearest to the initial stress; None if none fits."""
    full, hot = fraction[0] - RETURNED, fraction[0] - CYCLE
    below = fraction < hot
    if hot < 0.0 or not below.any():
        return None
    back = np.flatnonzero((fraction >= full) & (np.arange(len(fraction)) >= below.argmax()))
    if not len(back):
        return None
    begin = int(back[0])
    departure = fraction[begin:] < full
    end = begin + int(departure.argmax()) if departure.any() else len(fraction)
    at = begin + int(np.abs(stress[begin:end] - stress[0]).argmin())
    alike = abs(stress[at] - stress[0]) <= LOADED_ALIKE * max(abs(stress[at]), abs(stress[0]))
    return at if alone or alike else None


def find_undelivered(source: AbstractSource, times: Values, drive: Values, resistance: Values) -> Alarm | None:
    """Return the alarm of a source whose demand exceeds its range; None if it never does."""
    time, demand = np.asarray(times, float), np.asarray(drive, float)
    when = find_excursion(time, undelivered_margins(source, demand, resistance))
    if when is None:
        return None
    worst = float(demand[when.worst])
    reached = source.reach(float(resistance[when.worst]))
    limit = min(max(worst, reached.least), reached.most)
    unit = "" if source.unit == "1" else f" {source.unit}"
    sentence = (
        f"Warning: the drive `{source.registered_name}` cannot deliver what is demanded, at "
        f"t = {time[when.worst]:.4g} s only {limit:.4g}{unit} of {worst:.4g}{unit}, "
        f"{when.words()}."
    )
    return _make_alarm(time, when, ("supply", "drive", source.unit), worst, limit, sentence)


def undelivered_margins(source: AbstractSource, drive: Values, resistance: Values) -> Numbers:
    """Return the excess of each demand over the reach of the source, in its unit."""
    demand = np.asarray(drive, float)
    reached = source.reach(np.asarray(resistance, float))  # type: ignore[arg-type] # the reach of every point at once
    return np.maximum(demand - reached.most, reached.least - demand) - ROUNDING * np.abs(demand)


def judge_limits(result: Result) -> RunWarnings:
    """Return the alarms of a run and their messages, from its track or else its samples."""
    system, alarms = result.system, list[Alarm]()
    if system.actuators():
        names = [name for name in system.outputs() if name.rpartition(".")[2] in JUDGED]
        times, columns = result.list_rows(names)
        if result.track is None:
            alarms = alarms_of(system, times, columns)
        elif near := alarms_of(system, times, {name: _widen(name, column) for name, column in columns.items()}):
            followed = {one.quantity if one.kind == "rig" else system.label(one.port, one.quantity) for one in near}
            alarms = alarms_of(system, *result.draw_curves(names, sorted(followed)))
    coarse = [f"Warning: {result.status.sentence}"] if result.status is Status.LONG_STEP else []
    sentences = [alarm.sentence for alarm in alarms]
    return RunWarnings(alarms, [*sentences, *coarse, *_describe_doubts(result, result.list_rows()[1])])


def _widen(name: str, column: Numbers) -> Numbers:
    """Return a column with enlarged changes, so that near misses between rows are evaluated."""
    return column if name.rpartition(".")[2] in EXACT else column[0] + WIDENED * (column - column[0])


def _describe_doubts(result: Result, columns: Columns) -> list[str]:
    """Return warnings for stresses near the validity limit of a law."""
    warnings: list[str] = []
    for port, one in result.system.actuators().items():
        law, name = one.element.law, result.system.label(port, "stress")
        if not isinstance(law, AbstractLaw) or name not in columns:
            continue
        path = (columns[result.system.label(port, one)] for one in ("stress", "temperature", *FRACTIONS))
        warnings += describe_forgotten_loops(law, *path)
        warnings += describe_compression(law, columns[name])
        doubt = law.doubt()
        if doubt is None:
            continue
        most = float(np.abs(columns[name]).max())
        if most > DOUBT_FRACTION * doubt.stress:
            words = f"Caution: {doubt.sentence} The stress comes to {most / 1e6:.4g} MPa."
            warnings.append(words)
    return list(dict.fromkeys(warnings))
