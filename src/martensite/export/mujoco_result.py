"""Result of a run of a MuJoCo model with shape-memory elements: columns over time, in SI."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

from martensite.base.errors import UnknownNameError
from martensite.base.status import Status
from martensite.export.strand import TracedStrand
from martensite.simulate.alarms import JUDGED, Alarm, alarms_of
from martensite.simulate.march import classify_step


@dataclass
class MujocoResult:
    """Columns over time."""

    step: float
    """[s]"""
    times: list[float] = field(default_factory=list[float])
    """Sample times, those of the model [s]."""
    tendons: dict[str, dict[str, list[float]]] = field(default_factory=dict[str, dict[str, list[float]]])
    """By tendon and output: those of `martensite.actuators.assembly.OUTPUTS`, the `elongation` of the tendon from where
    its element is at zero strain [m], and its `length` [m]."""
    joints: dict[str, list[float]] = field(default_factory=dict[str, list[float]])
    """Position of every joint that was asked for [rad or m]."""
    poses: list[list[float]] = field(default_factory=list[list[float]])
    """All coordinates of the model, for pictures."""
    coarse_time: float | None = None
    """Start of the first step that is too long for a law [s]."""
    followed: dict[str, dict[str, list[float]]] = field(default_factory=dict[str, dict[str, list[float]]])
    """By tendon the `time` and the outputs that alarms are about, at every step; filled by `follow`."""
    alarms: list[Alarm] = field(default_factory=list[Alarm])
    """Exceeded limits, slack, a saturated supply; `port` is the tendon."""

    def __getitem__(self, name: str) -> list[float]:
        """Return a column: `time`, a joint, or `tendon.output`, such as `wire.temperature`."""
        columns = {"time": self.times} | self.joints
        for tendon, own in self.tendons.items():
            columns |= {f"{tendon}.{output}": column for output, column in own.items()}
        if name not in columns:
            raise UnknownNameError("column", name, columns)
        return columns[name]

    @property
    def warnings(self) -> list[str]:
        """Return the alarms in words, and coarse steps."""
        found = [alarm.sentence for alarm in self.alarms]
        if self.coarse_time is not None:
            found.append(f"Warning: first at t = {self.coarse_time:.6g} s. {Status.LONG_STEP.sentence}")
        return found

    def note_crossing(self, time: float, crossing: float) -> None:
        """Keep the start [s] of the first step in which an element crossed too much of a transformation strip."""
        if self.coarse_time is None and classify_step(0.0, crossing) is Status.LONG_STEP:
            self.coarse_time = time

    def sample(self, data: Any, rows: Mapping[str, Mapping[str, float]], joints: Mapping[str, int]) -> None:
        """Append the present: rows of outputs by tendon, coordinates by their numbers."""
        self.times.append(float(data.time))
        self.poses.append(data.qpos.tolist())
        for name, index in joints.items():
            self.joints.setdefault(name, []).append(float(data.qpos[index]))
        for tendon, row in rows.items():
            columns = self.tendons.setdefault(tendon, {name: [] for name in row})
            for name, value in row.items():
                columns[name].append(value)

    def follow(self, time: float, rows: Mapping[str, Mapping[str, float]]) -> None:
        """Keep what alarms are about, at a time [s]: call it after every step, with rows of outputs by tendon."""
        for tendon, row in rows.items():
            judged = {"time": time} | {name: row[name] for name in JUDGED if name in row}
            columns = self.followed.setdefault(tendon, {name: [] for name in judged})
            for name, value in judged.items():
                columns[name].append(value)

    def judge(self, strand: TracedStrand) -> None:
        """Add the alarms of an element: at every step that was followed, else at the samples."""
        columns = self.followed.get(strand.name) or {"time": self.times, **self.tendons[strand.name]}
        for alarm in alarms_of(strand.system, columns["time"], columns):
            words = alarm.sentence.replace("Warning: ", f"Warning: `{strand.name}`: ", 1)
            self.alarms.append(replace(alarm, port=strand.name, sentence=words))
