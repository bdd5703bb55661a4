"""Limit checks of a run or a steady state.

`run`, `check`, `steady`, `wire`, `size` and `design` share these limits (`martensite.simulate.alarms`) and this
envelope (`martensite.simulate.envelope`), so their results are consistent.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from typing import TYPE_CHECKING, Any

from martensite.actuators.assembly import AbstractSystem
from martensite.base import units
from martensite.base.formats import typeset_unit
from martensite.base.status import Status
from martensite.simulate.alarms import Alarm, alarms_of
from martensite.simulate.envelope import Envelope, describe_bound

if TYPE_CHECKING:
    from martensite.simulate.result import Result

LIMITS = ("temperature", "stress", "strain", "supply", "rig")
"""Kinds of alarms that exceed a limit; other kinds, such as slack, are cautions."""
REMEDIES = {
    "temperature": "To lower the temperature, reduce the drive or its duration, or improve the cooling.",
    "stress": "To lower the stress, reduce the load or use a thicker element.",
    "strain": "To lower the strain, reduce the load or the stroke, or use a longer element.",
    "supply": "To stay within the source, lower the command or raise the limit of the source.",
    "rig": "To stay within the supply, lower the commands or raise its `current_limit`.",
}
"""Remedies by kind of limit."""
SHOWN = {"K": "degC", "Pa": "MPa", "1": "%"}
"""Display units of limits, by SI unit."""


@dataclass(frozen=True)
class Judgement:
    """Exceeded limits of a run or a state."""

    alarms: tuple[Alarm, ...]
    """Exceeded limits only."""
    outside: str
    """Description of the exceeded bound of the envelope; empty inside the envelope."""

    @property
    def is_within_limits(self) -> bool:
        """Return True if the state is within all limits."""
        return not (self.alarms or self.outside)

    @property
    def kinds(self) -> set[str]:
        """Return the kinds of the exceeded limits, with `envelope` outside the envelope."""
        return {alarm.kind for alarm in self.alarms} | ({"envelope"} if self.outside else set())

    @property
    def verdict(self) -> str:
        """Return one sentence with each exceeded limit and its value, or the confirmation of all limits."""
        if self.is_within_limits:
            return "All limits are kept."
        words = [f"STOPPED. {self.outside}"] if self.outside else []
        if self.alarms:
            words.append(f"LIMIT EXCEEDED: {'; '.join(dict.fromkeys(map(describe_excess, self.alarms)))}.")
        return " ".join(words)

    def list_remedies(self) -> list[str]:
        """Return one sentence with a remedy for each exceeded limit."""
        return [REMEDIES[kind] for kind in dict.fromkeys(alarm.kind for alarm in self.alarms)]

    def to_dict(self) -> dict[str, Any]:
        """Return the judgement as data for JSON."""
        return {
            "kept": self.is_within_limits,
            "outside": self.outside,
            "exceeded": [asdict(alarm) for alarm in self.alarms],
        }


def describe_excess(alarm: Alarm) -> str:
    """Return the value and limit of an exceeded limit, without a time."""
    where = f"`{alarm.port}`: " if alarm.port else ""
    readable_unit = SHOWN.get(alarm.unit, alarm.unit)
    worst, limit = (
        f"{units.from_si(v, readable_unit, alarm.unit):.4g} {typeset_unit(readable_unit)}".strip()
        for v in (alarm.worst, alarm.limit)
    )
    if alarm.kind == "supply":
        return f"{where}the drive asks for {worst}, but the source delivers {limit}"
    if alarm.kind == "rig":
        return f"the sources ask the supply for {worst}, but its `current_limit` is {limit}"
    name = "the change of strain" if alarm.kind == "strain" else alarm.kind
    return f"{where}{name} reaches {worst}, above the `{alarm.kind}_limit` of {limit}"


def judge_run(result: Result) -> Judgement:
    """Return the limits that a run exceeds."""
    left = result.status is Status.OUT_OF_ENVELOPE
    outside = next((words for words in result.warnings if words.startswith("The run stopped")), "") if left else ""
    return Judgement(tuple(alarm for alarm in result.alarms if alarm.kind in LIMITS), outside)


def judge_columns(system: AbstractSystem, times: Sequence[float], columns: Mapping[str, Sequence[float]]) -> Judgement:
    """Return the limits that sampled outputs, in SI, exceed."""
    envelope = Envelope(system)
    rows = zip(*(columns[name] for name in system.outputs()), strict=True)
    crossing = next(filter(None, map(envelope.find_exit, rows)), None)
    outside = "" if crossing is None else f"The envelope is left: {describe_bound(system, *crossing)}"
    alarms = alarms_of(system, times, columns)
    return Judgement(tuple(alarm for alarm in alarms if alarm.kind in LIMITS), outside)


def judge_state(system: AbstractSystem, outputs: Mapping[str, float], before: Mapping[str, float]) -> Judgement:
    """Return the limits that a steady state exceeds.

    Args:
        system: system in the steady state.
        outputs: outputs of the state, in SI.
        before: outputs of the previous state, in SI; reference of the strain change.
    """
    times = (0.0, 1.0, 2.0)
    judgement = judge_columns(system, times, {name: (before[name], value, value) for name, value in outputs.items()})
    return replace(judgement, alarms=tuple(alarm for alarm in judgement.alarms if alarm.duration >= times[1]))
