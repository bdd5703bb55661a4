"""Runs of the benchmark: all wires and tasks of a plant side by side, in C where there is a compiler.

One program serves an entry on a plant, with its guard and every fault; in a lane all faults but one begin never. What
is measured of a lane is made while it runs, from the true output without noise:

    error       rms of (r - y) over the span asked for, from `judged_from` on
    settling    mean over all jumps of the time until |r - y| stays within 5 % of the span, until the next jump
    overshoot   how far y goes beyond r after a jump, from the side where it was, over the span
    energy      ∫ P dt of all elements              hottest    highest temperature of any element
    itae        ∫ t |r - y| dt over the span, t from the last jump on
    activity    mean change of a duty from period to period
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchmarks.control.faults import build_faults
from benchmarks.control.guards import GUARDS, SENSORS
from benchmarks.control.tasks import DISTURBANCE, FOLLOWED, SETTLED, BenchmarkTask, draw_noise
from benchmarks.control.wires import SEED
from martensite.control.checks.base import LIMITED
from martensite.control.loop.bench import Bench
from martensite.control.loop.names import ALARM, JITTER, NOISE, list_previews, list_references
from martensite.control.loop.parts import FaultTable
from martensite.simulate.lanes import Lanes
from martensite.simulate.march import SOLVED

Numbers = NDArray[np.float64]
NEVER = 1e9
"""When a fault begins that does not [s]."""
CHUNK = 200
"""Periods whose outputs are kept at a time."""
NO_FAULT = "none"
MEASURES = (
    "error",  # fraction of the span
    "settling",  # [s]
    "overshoot",  # fraction of the span
    "energy",  # [J]
    "hottest",  # [K]
    "above",  # 1 if true, as the next two
    "alarm",
    "failed",
    "itae",  # [s²]
    "activity",  # change of the duty cycle
    "cost",  # [s]
)
"""Measures of a run."""


def add_faults(bench: Bench, tasks: Sequence[BenchmarkTask]) -> Bench:
    """The bench with every fault, none of which begins, and with what disturbs its tasks."""
    span, duration = max(one.span for one in tasks), tasks[0].duration
    found: dict[str, Any] = dict(build_faults(bench, duration, sensor=FOLLOWED, span=span))
    for one in tasks:
        if one.disturbance:
            found[DISTURBANCE] = one.build_disturbance()
    return bench.with_parts(faults=FaultTable(**found))


def start_faults(bench: Bench, tasks: Sequence[BenchmarkTask], active: str, wires: int) -> dict[str, Numbers]:
    """When faults begin in every lane [s], by path: that which is `active` when it says, the others never."""
    found: dict[str, Numbers] = {}
    for name, one in bench.faults.members().items():
        begins = [
            one.start if name == active or (name == DISTURBANCE and task.disturbance) else NEVER for task in tasks
        ]
        ends = [max(one.end, begin + 1.0) for begin in begins]
        found[f"faults.{name}.start"] = np.repeat(np.array(begins, float), wires)
        if any(math.isfinite(end) for end in ends):
            found[f"faults.{name}.end"] = np.repeat(np.array(ends, float), wires)
    return found


class PlantRuns:
    """Lanes of one entry on one plant: wires of the first task, those of the second, and so on."""

    def __init__(
        self,
        bench: Bench,
        tasks: Sequence[BenchmarkTask],
        wires: Mapping[str, Numbers],
        *,
        faulty: bool = True,
        guard: str = SENSORS,
        values: Mapping[str, Any] | None = None,
        native: bool | None = None,
        seed: int = SEED,
    ) -> None:
        """Compile a program and make its lanes.

        Args:
            bench: a plant, under controllers or not.
            tasks: on that plant, all of one length.
            wires: parameters by path, shape (wires,) each.
            faulty: whether the bench shall have the faults of the benchmark.
            guard: which one it shall have, of `GUARDS`.
            values: parameters by path that differ from lane to lane otherwise.
            native: whether to run in C; by default if there is a compiler.
            seed: of the noise.
        """
        bench = bench.with_parts(supervisor=GUARDS[guard](bench))
        self.bench = add_faults(bench, tasks) if faulty else bench
        self.tasks, self.wires = list(tasks), len(next(iter(wires.values())))
        self.seed = seed
        self.steps = round(tasks[0].duration / bench.period)
        repeated = {path: np.tile(row, len(tasks)) for path, row in wires.items()}
        self.lanes = Lanes(self.bench, len(tasks) * self.wires, {**repeated, **(values or {})}, native)
        self._find_columns()
        self._set_signals()

    def _find_columns(self) -> None:
        seen, plant = self.lanes.names.index, self.bench.plant
        ports = list(plant.actuators())
        self._output = seen(self.tasks[0].output)
        self._hottest, self._power = ([seen(plant.label(p, n)) for p in ports] for n in ("hottest", "power"))
        self._drives = [seen(plant.drive_at(port)) for port in ports]
        limits = [one.element.limits.temperature_limit for one in plant.actuators().values()]
        self.limits = np.array(limits)[:, None]
        self._alarm = seen(ALARM) if ALARM in self.lanes.names else None

    def _set_signals(self) -> None:
        """References and noise of all lanes, shape (steps + 1, drives, lanes); what nobody has is 0."""
        times = self.bench.period * np.arange(self.steps + 1)
        self.times, drives = times, list(self.lanes.drives)
        self.signals = np.zeros((self.steps + 1, len(drives), self.lanes.lanes))
        self.reference = np.array([[one.reference.value(float(t)) for t in times] for one in self.tasks])
        noisy = [k for k, name in enumerate(drives) if name.startswith((NOISE, JITTER))]
        for k, task in enumerate(self.tasks):
            own = slice(k * self.wires, (k + 1) * self.wires)
            _, self.signals[:, noisy, own] = draw_noise(self.bench, task.name, self.wires, self.steps + 1, self.seed)
        self.set_references()

    def set_references(self, gain: Any = 1.0, offset: Any = 0.0) -> None:
        """Give the controllers what they shall follow, now and as far ahead as they look.

        Args:
            gain: what the reference of a task is multiplied by, a number or shape (lanes,).
            offset: what is added then.
        """
        leads = dict.fromkeys(list_references(self.bench), 0.0)
        leads |= {one.name: one.time for one in list_previews(self.bench)}
        for name, lead in leads.items():
            rows = np.array([[one.reference.value(float(t) + lead) for t in self.times] for one in self.tasks])
            self.signals[:, self.lanes.drives.index(name)] = gain * np.repeat(rows.T, self.wires, axis=1) + offset

    def run(self, fault: str = NO_FAULT) -> dict[str, Numbers]:
        """Outcomes of every lane under a fault, by measure."""
        self.begin(fault)
        parts = [
            self.keep(self.lanes.advance(self.signals[k : k + CHUNK], self.bench.period))
            for k in range(1, self.steps + 1, CHUNK)
        ]
        return self.judge({name: np.concatenate([one[name] for one in parts]) for name in parts[0]})

    def begin(self, fault: str = NO_FAULT) -> None:
        """All lanes at rest, with a fault."""
        if self.bench.faults.members():
            self.lanes.set_values(start_faults(self.bench, self.tasks, fault, self.wires))
        self.lanes.reset(self.signals[0])

    def keep(self, rows: Numbers) -> dict[str, Numbers]:
        """What is judged of outputs, shape (periods, lanes) each."""
        alarm = np.zeros_like(rows[:, 0]) if self._alarm is None else rows[:, self._alarm]
        hot = rows[:, self._hottest]
        return {
            "output": rows[:, self._output].copy(),
            "hottest": hot.max(axis=1),
            "excess": (hot - self.limits).max(axis=1),
            "power": rows[:, self._power].sum(axis=1),
            "alarm": alarm.copy(),
            **{f"duty {k}": rows[:, place].copy() for k, place in enumerate(self._drives)},
        }

    def judge(self, kept: Mapping[str, Numbers]) -> dict[str, Numbers]:
        """Measures of all lanes, of what was kept after every period."""
        lost = ~np.isfinite(kept["output"]).all(axis=0) | ~(self.lanes.worst[0] <= SOLVED)
        found = {name: np.zeros(self.lanes.lanes) for name in MEASURES}
        for k, task in enumerate(self.tasks):
            own = slice(k * self.wires, (k + 1) * self.wires)
            error = (self.reference[k, 1:, None] - kept["output"][:, own]) / task.span
            rows = measure_errors(task, self.reference[k, 1:], error, self.bench.period)
            for name, row in rows.items():
                found[name][own] = row
        found["energy"] = kept["power"].sum(axis=0) * self.bench.period
        duties = [row for name, row in kept.items() if name.startswith("duty")]
        found["activity"] = np.mean([np.abs(np.diff(row, axis=0)).mean(axis=0) for row in duties], axis=0)
        found["hottest"] = kept["hottest"].max(axis=0)
        found["above"] = (kept["excess"].max(axis=0) > 0.0).astype(float)
        found["alarm"] = ((kept["alarm"] > 0.0) & (kept["alarm"] < LIMITED)).any(axis=0).astype(float)
        found["limited"] = (kept["alarm"] > LIMITED).mean(axis=0)
        found["failed"] = lost.astype(float)
        found["error"] = np.where(lost, math.inf, found["error"])
        return found


def measure_errors(task: BenchmarkTask, reference: Numbers, error: Numbers, period: float) -> dict[str, Numbers]:
    """Error, settling, overshoot and ITAE of runs.

    Args:
        task: what was asked for.
        reference: shape (steps,), at the end of every period.
        error: r - y in shares of the span, shape (steps, wires).
        period: length of a period [s].
    """
    times = period * np.arange(1, len(reference) + 1)
    judged = times >= task.judged_from - 1e-9
    rms = np.sqrt(np.mean(error[judged] ** 2, axis=0))
    events = task.list_events()
    ends = [*events[1:], task.duration + period]
    waits, beyond = list[Numbers](), list[Numbers]()
    for begin, end in zip(events, ends, strict=True):
        inside = np.flatnonzero((times > begin - 1e-9) & (times < end - 1e-9))
        waits.append(_find_settling(error[inside], period))
        beyond.append(_find_overshoot(error[inside]))
    since = times - np.array([0.0, *events])[np.searchsorted(events, times + 1e-9)]
    itae = np.asarray(period * (since @ np.abs(error)), float)
    over = np.max(beyond, axis=0) if task.overshoots else np.zeros(error.shape[1])
    return {"error": rms, "settling": np.mean(waits, axis=0), "overshoot": over, "itae": itae}


def _find_overshoot(error: Numbers) -> Numbers:
    """How far an error goes beyond 0 after a jump, from the side on which it begins; 0 if it begins settled."""
    side = np.where(np.abs(error[0]) > SETTLED, np.sign(error[0]), 0.0)
    return np.maximum((-side * error).max(axis=0), 0.0)


def _find_settling(error: Numbers, period: float) -> Numbers:
    """Time until all that follows is settled [s]; the length of the piece if nothing is."""
    out = np.abs(error) > SETTLED
    last = len(out) - np.argmax(out[::-1], axis=0)
    return np.where(out.any(axis=0), period * last, 0.0)
