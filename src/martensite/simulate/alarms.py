"""Alarms: what went beyond a limit, when first, for how long, and by how much.

Judged on sampled columns, linear in between. So a crossing on a straight line is found exactly,
and a peak between two samples is not seen: choose more samples where pulses are short.

| kind | beyond the limit when | limit |
| --- | --- | --- |
| temperature | the hottest place of the element is too hot | `temperature_limit` |
| stress | the stress is too high | `stress_limit` |
| strain | the strain is too far from the farthest value that it had before | `strain_limit` |
| slack | the element, once under force, has none | 0 N |
| supply | the drive asks for more (or less) than the source can deliver | `reach` of the source |
| rig | several sources ask a supply that they share for more current | its `current_limit` |
| drift | another share of the martensite is oriented after the first cycle | at the start |
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import TYPE_CHECKING

from martensite.actuators.assembly import AbstractSystem, Actuator, Machine
from martensite.actuators.assembly.base import AbstractSystemAround
from martensite.base.status import Status
from martensite.physics.electrical.base import AbstractSource
from martensite.physics.laws.base import AbstractLaw
from martensite.simulate.compiled_law import describe_compression, describe_forgotten_loops

if TYPE_CHECKING:
    from martensite.simulate.result import Result

Columns = Mapping[str, Sequence[float]]
FRACTIONS = ("martensite_fraction", "oriented_fraction")
JUDGED = ("hottest", "stress", "strain", "force", "drive", "resistance", *FRACTIONS)
"""Outputs of an actuator that alarms are about."""
ROUNDING = 1e-9
"""Share of a demand by which it may exceed what can be delivered."""
DRIFT = 0.05
"""Change of the oriented share in a first cycle that is none."""
CYCLE = 0.5
"""Martensite fraction that a cycle loses and regains."""
RETURNED = 0.01
"""Martensite fraction that may be missing after a cycle."""
NEAR = 0.8
"""Share of a stress from which a law is doubtful, from which on it is said."""
LOADED_ALIKE = 0.2
"""Difference of two stresses, as a share of the larger, under which orientation is compared."""


@dataclass(frozen=True)
class Alarm:
    """One limit that was exceeded; all numbers in SI."""

    kind: str
    """temperature, stress, strain, slack, supply, rig or drift."""
    quantity: str
    """Output that was judged."""
    unit: str
    """SI unit of `worst`, `limit` and `excess`."""
    worst: float
    """Value farthest beyond the limit; of the strain its change; of a supply the demand."""
    limit: float
    """What was allowed then; of a supply what it could deliver."""
    excess: float
    """Distance of the two."""
    first: float
    """Time at which the limit was first exceeded [s]."""
    duration: float
    """Time spent beyond the limit in all [s]."""
    worst_time: float
    """Time of the worst value [s]."""
    sentence: str
    """The same in words."""
    port: str = ""
    """Which of several actuators it is about."""


@dataclass(frozen=True)
class Excursion:
    """When a margin was above zero."""

    first: float
    duration: float
    worst: int
    """Number of the sample with the largest margin."""

    def words(self) -> str:
        """First time and duration in words."""
        return f"first at t = {self.first:.4g} s, for {self.duration:.3g} s in all"


def find_excursion(times: Sequence[float], margins: Sequence[float]) -> Excursion | None:
    """When a margin, linear between samples, was above zero; None if never."""
    worst = max(range(len(margins)), key=margins.__getitem__)
    if not margins[worst] > 0.0:
        return None
    first, duration = (times[0] if margins[0] > 0.0 else None), 0.0
    for (t0, m0), (t1, m1) in pairwise(zip(times, margins, strict=True)):
        above = _share_above(m0, m1) * (t1 - t0)
        if first is None and m1 > 0.0:
            first = t1 - above
        duration += above
    return Excursion(times[0] if first is None else first, duration, worst)


def _share_above(begin: float, end: float) -> float:
    """Share of a straight line that is above zero."""
    if begin > 0.0 and end > 0.0:
        return 1.0
    high, low = max(begin, end), min(begin, end)
    return high / (high - low) if high > 0.0 else 0.0


def alarms_of(system: AbstractSystem, times: Sequence[float], columns: Columns) -> list[Alarm]:
    """All alarms of a run, from its sampled columns in SI."""
    found: list[Alarm] = []
    alone = len(system.actuators()) == 1 and not system.signals()
    for port, actuator in system.actuators().items():
        own = {name: columns[system.label(port, name)] for name in JUDGED}
        several = system.label(port, "stress") != "stress"
        found += [_at_port(alarm, port) if several else alarm for alarm in _of_actuator(actuator, times, own, alone)]
    return found + _watch_supply(system, times, columns)


def _watch_supply(system: AbstractSystem, times: Sequence[float], columns: Columns) -> list[Alarm]:
    """That of a supply which is shared, if there is one and it cannot give what all ask for together."""
    plant = system.plant if isinstance(system, AbstractSystemAround) else system
    if not isinstance(plant, Machine) or plant.supply is None:
        return []
    limit, demand = plant.supply.current_limit, columns["supply_demand"]
    when = find_excursion(times, [asked - limit * (1.0 + ROUNDING) for asked in demand])
    if when is None:
        return []
    at, worst = when.worst, demand[when.worst]
    sentence = (
        f"Warning: the sources ask the supply for {worst:.4g} A at t = {times[at]:.4g} s, more than its "
        f"`current_limit` of {limit:.4g} A; its voltage falls to {columns['supply_voltage'][at]:.4g} V, {when.words()}."
    )
    return [_make_alarm(times, when, ("rig", "supply_demand", "A"), worst, limit, sentence)]


def _at_port(alarm: Alarm, port: str) -> Alarm:
    sentence = alarm.sentence.replace("Warning: ", f"Warning: `{port}`: ", 1)
    return replace(alarm, port=port, sentence=sentence)


def _of_actuator(actuator: Actuator, times: Sequence[float], columns: Columns, alone: bool) -> list[Alarm]:
    limits = actuator.element.limits
    hot = "temperature", "K", limits.temperature_limit, 273.15, "°C", 1.0
    high = "stress", "Pa", limits.stress_limit, 0.0, "MPa", 1e6
    found = (
        _watch_above(times, columns["hottest"], "hottest", *hot),
        _watch_above(times, columns["stress"], "stress", *high),
        _watch_strain(times, columns["strain"], limits.strain_limit),
        _watch_slack(times, columns["force"]),
        find_undelivered(actuator.source, times, columns["drive"], columns["resistance"]),
        _watch_first_cycle(times, columns, alone),
    )
    return [alarm for alarm in found if alarm is not None]


def _make_alarm(
    times: Sequence[float], when: Excursion, what: tuple[str, str, str], worst: float, limit: float, sentence: str
) -> Alarm:
    return Alarm(*what, worst, limit, abs(worst - limit), when.first, when.duration, times[when.worst], sentence)


def _watch_above(
    times: Sequence[float],
    values: Sequence[float],
    quantity: str,
    kind: str,
    unit: str,
    limit: float,
    zero: float,
    shown: str,
    scale: float,
) -> Alarm | None:
    when = find_excursion(times, [value - limit for value in values])
    if when is None:
        return None
    worst = values[when.worst]
    sentence = (
        f"Warning: {kind} reaches {(worst - zero) / scale:.4g} {shown}, above the "
        f"`{kind}_limit` of {(limit - zero) / scale:.4g} {shown}, {when.words()}."
    )
    return _make_alarm(times, when, (kind, quantity, unit), worst, limit, sentence)


def _watch_strain(times: Sequence[float], strain: Sequence[float], limit: float) -> Alarm | None:
    changes = farthest_changes(strain)
    when = find_excursion(times, [change - limit for change in changes])
    if when is None:
        return None
    worst = changes[when.worst]
    sentence = (
        f"Warning: strain varies by {100 * worst:.3g} %, more than the "
        f"`strain_limit` of {100 * limit:.3g} %, {when.words()}."
    )
    return _make_alarm(times, when, ("strain", "strain", "1"), worst, limit, sentence)


def farthest_changes(strain: Sequence[float]) -> list[float]:
    """Distance of every value of the strain from the farthest that it had before."""
    changes: list[float] = []
    low = high = strain[0]
    for value in strain:
        low, high = min(low, value), max(high, value)
        changes.append(max(high - value, value - low))
    return changes


def _watch_slack(times: Sequence[float], force: Sequence[float]) -> Alarm | None:
    """No force, after there was some; it has no size, since a slack wire has no stress."""
    at = next((k for k, value in enumerate(force) if value <= 0.0), None)
    if at is None or not force[0] > 0.0:
        return None
    whole = (f0 <= 0.0 and f1 <= 0.0 for f0, f1 in pairwise(force))
    steps = ((t1 - t0) for t0, t1 in pairwise(times))
    duration = sum(step for step, slack in zip(steps, whole, strict=True) if slack)
    when = Excursion(times[at], duration, at)
    sentence = f"Warning: the element is slack (no force), {when.words()}."
    return Alarm("slack", "force", "N", force[at], 0.0, 0.0, when.first, duration, times[at], sentence)


def _watch_first_cycle(times: Sequence[float], columns: Columns, alone: bool) -> Alarm | None:
    """Another orientation after the first cycle than at the start.

    Compared at much the same stress; for an element that is alone on what nothing else drives, at whatever stress that
    leaves, which differs because of the drift.
    """
    fraction, oriented = (columns[name] for name in FRACTIONS)
    at = _find_return(fraction, columns["stress"], alone)
    if at is None:
        return None
    shares = oriented[0] / fraction[0], oriented[at] / fraction[at]
    if abs(shares[1] - shares[0]) <= DRIFT:
        return None
    strains = columns["strain"][0], columns["strain"][at]
    (start, share), (long, short) = shares, (f"{100 * strain:.3g} %" for strain in strains)
    sentence = (
        f"Warning: the first cycle drifts: {100 * start:.3g} % of the martensite is oriented at "
        f"the start (strain {long}), {100 * share:.3g} % at t = {times[at]:.4g} s (strain "
        f"{short}); judge by later cycles."
    )
    when = Excursion(times[at], times[-1] - times[at], at)
    what = "drift", "oriented_fraction", "1"
    return _make_alarm(times, when, what, share, start, sentence)


def _find_return(fraction: Sequence[float], stress: Sequence[float], alone: bool) -> int | None:
    """Where after a first cycle the stress is most like that of the start; None if it is not."""
    full, hot = fraction[0] - RETURNED, fraction[0] - CYCLE
    below = next((k for k, value in enumerate(fraction) if value < hot), len(fraction))
    back = next((k for k in range(below, len(fraction)) if fraction[k] >= full), None)
    if back is None or hot < 0.0:
        return None
    end = next((k for k in range(back, len(fraction)) if fraction[k] < full), len(fraction))
    at = min(range(back, end), key=lambda k: abs(stress[k] - stress[0]))
    alike = abs(stress[at] - stress[0]) <= LOADED_ALIKE * max(abs(stress[at]), abs(stress[0]))
    return at if alone or alike else None


def find_undelivered(
    source: AbstractSource, times: Sequence[float], drive: Sequence[float], resistance: Sequence[float]
) -> Alarm | None:
    """The alarm of a source that is asked for what it cannot deliver; None if it never is."""
    when = find_excursion(times, undelivered_margins(source, drive, resistance))
    if when is None:
        return None
    worst = drive[when.worst]
    reached = source.reach(resistance[when.worst])
    limit = min(max(worst, reached.least), reached.most)
    unit = "" if source.unit == "1" else f" {source.unit}"
    sentence = (
        f"Warning: the drive `{source.registered_name}` cannot deliver what is demanded, at "
        f"t = {times[when.worst]:.4g} s only {limit:.4g}{unit} of {worst:.4g}{unit}, "
        f"{when.words()}."
    )
    return _make_alarm(times, when, ("supply", "drive", source.unit), worst, limit, sentence)


def undelivered_margins(source: AbstractSource, drive: Sequence[float], resistance: Sequence[float]) -> list[float]:
    """How far each demand is beyond what the source can deliver, in its unit."""
    reached = (source.reach(ohms) for ohms in resistance)
    return [max(u - reach.most, reach.least - u) - ROUNDING * abs(u) for u, reach in zip(drive, reached, strict=True)]


def add_warnings(result: Result, columns: Columns | None = None) -> Result:
    """Note alarms and warnings in a result; judged on other columns than its own if given."""
    result.alarms.extend(alarms_of(result.system, result.times, columns or result.columns))
    result.warnings.extend(alarm.sentence for alarm in result.alarms)
    if result.status is Status.LONG_STEP:
        result.warnings.append(f"Warning: {result.status.sentence}")
    result.warnings.extend(_describe_doubts(result, columns or result.columns))
    return result


def _describe_doubts(result: Result, columns: Columns) -> list[str]:
    """Of laws that the stress brings near to where they are doubtful."""
    found: list[str] = []
    for port, one in result.system.actuators().items():
        law, name = one.element.law, result.system.label(port, "stress")
        if not isinstance(law, AbstractLaw) or name not in columns:
            continue
        path = (columns[result.system.label(port, one)] for one in ("stress", "temperature", *FRACTIONS))
        found += describe_forgotten_loops(law, *path)
        found += describe_compression(law, columns[name])
        doubt = law.doubt()
        if doubt is None:
            continue
        most = max(map(abs, columns[name]))
        if most > NEAR * doubt.stress:
            words = f"Caution: {doubt.sentence} The stress comes to {most / 1e6:.4g} MPa."
            found.append(words)
    return list(dict.fromkeys(found))
