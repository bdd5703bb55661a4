"""Tuning on the bench: parameters of controllers of least cost, over a batch of plants.

`martensite.control.tuning.goals` defines the cost, `martensite.control.tuning.gain_search` the search, with exact
derivatives through the loop. Starts are the parameters of the bench and given ones, such as gains by rules. Sensors,
observers and controllers are the same in every run; only plants are drawn.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from martensite.base.errors import SolveError
from martensite.base.files import write_file
from martensite.control.loop.bench import Bench
from martensite.control.tuning.gain_search import GainCosts, TuningSearch, build_free_gains, search_gains
from martensite.control.tuning.goals import Cost, Course, Numbers, TuningGoal
from martensite.control.tuning.judgement import MEASURES, JudgedLoop, TuningJudgement, judge_loops
from martensite.control.tuning.loop_runs import LoopOutputs, LoopRuns
from martensite.control.tuning.measures import Measures, measure_loop
from martensite.control.tuning.plant_spread import Plants
from martensite.search.box_search import Tell
from martensite.search.free_numbers import FreeNumber
from martensite.signals.base import AbstractWaveform

if TYPE_CHECKING:
    from martensite.scenario.scenario import Scenario


@dataclass(frozen=True, eq=False)
class TunedBench:
    """Tuned parameters, and the loop before and after."""

    bench: Bench
    before: dict[str, float]
    after: dict[str, float]
    cost_before: float
    cost: float
    measures_before: Measures
    """Measures on the nominal plant."""
    measures: Measures
    outputs_before: LoopOutputs
    outputs: LoopOutputs
    times: Numbers
    evaluations: int
    gradients: int
    ends: tuple[float, ...]
    judgement: TuningJudgement
    notes: list[str] = field(default_factory=list[str])

    @property
    def worse(self) -> bool:
        """Return True if the error is larger than before."""
        return self.judgement.worse

    def save(self, scenario: Scenario, path: str | PathLike[str], *, anyway: bool = False) -> None:
        """Write a scenario with the tuned parameters.

        Args:
            scenario: scenario of the tuned bench.
            path: file to write.
            anyway: whether to write a result that is worse than before.

        Raises:
            InputError: the result is worse than before.
        """
        self.judgement.require_better(anyway=anyway)
        write_file(Path(path), scenario.write_changed(self.after, "tuned"))

    def rows(self) -> list[tuple[str, float, float]]:
        """Return name, value before and value after of all parameters and measures, in SI."""
        rows = [(path, self.before[path], value) for path, value in self.after.items()]
        rows.append(("cost", self.cost_before, self.cost))
        after = self.measures.to_dict()
        return rows + [(n, v, after[n]) for n, v in self.measures_before.to_dict().items()]


def tune_bench(
    bench: Bench,
    duration: float,
    free: Sequence[str] = ("Kp", "Ki", "Kd"),
    *,
    goal: TuningGoal | None = None,
    plants: Plants | None = None,
    judged: Plants | None = None,
    starts: Sequence[Mapping[str, float]] = (),
    drive: str | None = None,
    search: TuningSearch | None = None,
    noise_seed: int | None = 0,
    waveforms: Mapping[str, AbstractWaveform] | None = None,
    watch: Tell | None = None,
    keep: Callable[[dict[str, float]], None] | None = None,
    native: bool | None = None,
) -> TunedBench:
    """Return the parameters of controllers of least cost.

    Args:
        bench: bench with controllers and their references.
        duration: duration of every run [s].
        free: paths, or unique endings, of parameters of controllers, optionally with bounds: `Kp=1..100`.
        goal: weights of the cost.
        plants: plants of the search; default: the nominal plant.
        judged: plants of the comparison with the parameters of the bench; default: the nominal plant.
        starts: further starts of the search, as parameters by path.
        drive: drive of the loop; required for several controllers.
        search: settings of the search.
        noise_seed: seed of the sensor noise, equal in every run; None for runs without noise.
        waveforms: signals of drives without a controller.
        watch: called with a sentence and the completed fraction.
        keep: called with every best set of parameters so far, by path.
        native: whether to run in C; default: if there is a compiler.

    Raises:
        ParameterError: an unknown name, a parameter that cannot be searched, or a constant reference at the output.
        SolveError: no start can be run.
    """
    runs = LoopRuns(bench, duration, drive=drive, seed=noise_seed, waveforms=waveforms, native=native)
    values = {path: float(value) for path, value in zip(runs.paths, runs.base, strict=True)}
    parameters = build_free_gains(bench, free, starts)
    before = {one.path: values[one.path] for one in parameters}
    first = runs.run(runs.table({}, 1))
    course = Course(first.one(0), bench.period) if _is_finite(first) else _find_scales(runs, starts)
    settings = search or TuningSearch()
    costs = GainCosts(runs, Cost(goal or TuningGoal(), course), parameters, plants, settings.slopes)
    cost, best, ends = search_gains(costs, [before, *[{**before, **start} for start in starts]], settings, watch, keep)
    after = {path: float(value) for path, value in costs.numbers(best).items()}
    measure = MEASURES[costs.cost.goal.error]
    comparison = compare_gains(runs, after, course, judged, measure)
    return replace(
        comparison,
        cost_before=float(costs.compute_costs({p: [v] for p, v in before.items()}, 1)[0]),
        cost=cost,
        evaluations=costs.evaluations,
        gradients=costs.gradients,
        ends=ends,
        notes=_list_bounds(parameters, best / costs.widths),
    )


def compare_gains(
    runs: LoopRuns,
    after: Mapping[str, float],
    course: Course | None = None,
    judged: Plants | None = None,
    measure: str = "rms",
) -> TunedBench:
    """Return a loop on the nominal plant before and after a change of parameters by path.

    Costs use the default goal with the scales of `course`, by default of the loop before. The errors are compared on
    the plants `judged` by a `measure` of `judgement`.

    Raises:
        ParameterError: the reference stays where the output begins.
    """
    before = {path: float(runs.base[runs.place(path)]) for path in after}
    both = runs.run(runs.table({p: [before[p], after[p]] for p in after}, 2))
    first, second = both.one(0), both.one(1)
    course = course or Course(first, runs.bench.period)
    costs = Cost(TuningGoal(), course)(both)
    return TunedBench(
        runs.bench.with_values(after),
        before,
        dict(after),
        float(costs[0]),
        float(costs[1]),
        measure_loop(first, course),
        measure_loop(second, course),
        first,
        second,
        runs.times,
        evaluations=2,
        gradients=0,
        ends=(),
        judgement=judge_loops(JudgedLoop(runs, before), JudgedLoop(runs, after), judged, measure),
    )


def _is_finite(outputs: LoopOutputs) -> bool:
    return bool(np.isfinite(outputs.output[0]).all())


def _find_scales(runs: LoopRuns, starts: Sequence[Mapping[str, float]]) -> Course:
    for start in starts:
        outputs = runs.run(runs.table(start, 1))
        if _is_finite(outputs):
            return Course(outputs.one(0), runs.bench.period)
    raise SolveError("The loop fails with its present parameters and with all starting points.")


def _list_bounds(free: Sequence[FreeNumber], shares: Numbers) -> list[str]:
    remarks: list[str] = []
    for one, fraction in zip(free, shares.tolist(), strict=True):
        bound = one.bound(fraction)
        if bound is not None:
            end = one.low if bound == "lower" else one.high
            remarks.append(
                f"`{one.path}` ended at its bound {end:.4g}: a better number may be beyond it, or it does not matter."
            )
    return remarks
