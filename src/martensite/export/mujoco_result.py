"""Result of a run of a MuJoCo model with shape-memory elements: columns over time, in SI."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

from martensite.base.errors import require_known
from martensite.base.status import Status
from martensite.export.strand import TracedStrand
from martensite.simulate.alarms import JUDGED, Alarm, alarms_of
from martensite.simulate.march import classify_step


@dataclass
class MujocoResult:
    """Columns over time of a run."""

    step: float
    """Time step [s]."""
    times: list[float] = field(default_factory=list[float])
    """Sample times of the model [s]."""
    tendons: dict[str, dict[str, list[float]]] = field(default_factory=dict[str, dict[str, list[float]]])
    """By tendon and output: `martensite.actuators.assembly.OUTPUTS`, the `elongation` of the tendon from zero strain of
    its element [m], and its `length` [m].
    """
    joints: dict[str, list[float]] = field(default_factory=dict[str, list[float]])
    """Positions of the recorded joints [rad or m]."""
    poses: list[list[float]] = field(default_factory=list[list[float]])
    """All coordinates of the model, for pictures."""
    coarse_time: float | None = None
    """Start of the first step that is too long for a law [s]."""
    followed: dict[str, dict[str, list[float]]] = field(default_factory=dict[str, dict[str, list[float]]])
    """By tendon, `time` and the outputs that alarms need at each step; filled by `follow`."""
    alarms: list[Alarm] = field(default_factory=list[Alarm])
    """Exceeded limits, slack, a saturated supply; `port` is the tendon."""

    def __getitem__(self, name: str) -> list[float]:
        """Return a column: `time`, a joint, or `tendon.output`, such as `wire.temperature`."""
        columns = {"time": self.times} | self.joints
        for tendon, own in self.tendons.items():
            columns |= {f"{tendon}.{output}": column for output, column in own.items()}
        require_known("column", name, columns)
        return columns[name]

    @property
    def warnings(self) -> list[str]:
        """Return the sentences of alarms and coarse steps."""
        sentences = [alarm.sentence for alarm in self.alarms]
        if self.coarse_time is not None:
            sentences.append(f"Warning: first at t = {self.coarse_time:.6g} s. {Status.LONG_STEP.sentence}")
        return sentences

    def note_crossing(self, time: float, crossing: float) -> None:
        """Record the start [s] of the first step in which an element crossed too much of a transformation strip."""
        if self.coarse_time is None and classify_step(0.0, crossing) is Status.LONG_STEP:
            self.coarse_time = time

    def sample(self, data: Any, rows: Mapping[str, Mapping[str, float]], joints: Mapping[str, int]) -> None:
        """Append the present outputs by tendon, and coordinates by index."""
        self.times.append(float(data.time))
        self.poses.append(data.qpos.tolist())
        for name, index in joints.items():
            self.joints.setdefault(name, []).append(float(data.qpos[index]))
        for tendon, row in rows.items():
            columns = self.tendons.setdefault(tendon, {name: [] for name in row})
            for name, value in row.items():
                columns[name].append(value)

    def follow(self, time: float, rows: Mapping[str, Mapping[str, float]]) -> None:
        """Record the outputs that alarms need at a time [s]; call it after each step."""
        for tendon, row in rows.items():
            levels = {"time": time} | {name: row[name] for name in JUDGED if name in row}
            columns = self.followed.setdefault(tendon, {name: [] for name in levels})
            for name, value in levels.items():
                columns[name].append(value)

    def judge(self, strand: TracedStrand) -> None:
        """Add the alarms of an element, from all recorded steps, else from the samples."""
        columns = self.followed.get(strand.name) or {"time": self.times, **self.tendons[strand.name]}
        for alarm in alarms_of(strand.system, columns["time"], columns):
            words = alarm.sentence.replace("Warning: ", f"Warning: `{strand.name}`: ", 1)
            self.alarms.append(replace(alarm, port=strand.name, sentence=words))
