"""Tuning on the bench itself: parameters of controllers of least cost, over a batch of plants.

The cost is that of `martensite.control.tuning.goals`, the search that of
`martensite.control.tuning.gain_search`, with exact derivatives through the loop. Starts are the
numbers of the bench and those that are given, such as gains by rules.

Sensors, observers and controllers are those of the bench in every run; what is drawn are plants.
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
from martensite.control.tuning.loop_runs import LoopRuns, Seen
from martensite.control.tuning.measures import Measures, measure_loop
from martensite.control.tuning.plant_spread import Plants
from martensite.search.box_search import Tell
from martensite.search.free_numbers import FreeNumber
from martensite.signals.base import AbstractWaveform

if TYPE_CHECKING:
    from martensite.scenario.scenario import Scenario


@dataclass(frozen=True, eq=False)
class TunedBench:
    """Parameters that were found, and what the loop does with them."""

    bench: Bench
    """The bench with them."""
    before: dict[str, float]
    """By path."""
    after: dict[str, float]
    cost_before: float
    cost: float
    measured_before: Measures
    """On the nominal plant."""
    measured: Measures
    seen_before: Seen
    seen: Seen
    """The run on the nominal plant, sample by sample."""
    times: Numbers
    evaluations: int
    """Runs, one per plant."""
    gradients: int
    """Runs with derivatives."""
    ends: tuple[float, ...]
    """Costs at which searches ended, best first."""
    judgement: TuningJudgement
    """Errors before and after on the plants that it is judged on."""
    notes: list[str] = field(default_factory=list[str])
    """Sentences on bounds that were hit."""

    @property
    def worse(self) -> bool:
        """Return True if the error on the judged plants is larger than before."""
        return self.judgement.worse

    def save(self, scenario: Scenario, path: str | PathLike[str], *, anyway: bool = False) -> None:
        """Write a scenario with the new numbers.

        Args:
            scenario: the scenario whose bench was tuned.
            path: file to write.
            anyway: also write a result that is worse than before.

        Raises:
            InputError: the result is worse than before.
        """
        self.judgement.require_better(anyway=anyway)
        write_file(Path(path), scenario.write_changed(self.after, "tuned"))

    def rows(self) -> list[tuple[str, float, float]]:
        """Return the name, and number before and after, of everything, for people to read; SI."""
        found = [(path, self.before[path], value) for path, value in self.after.items()]
        found.append(("cost", self.cost_before, self.cost))
        after = self.measured.to_dict()
        return found + [(n, v, after[n]) for n, v in self.measured_before.to_dict().items()]


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
        bench: with controllers, whose references are what shall be followed.
        duration: length of every run [s].
        free: paths, or unique endings, of parameters of controllers, with bounds if they are not
            to be chosen: `Kp=1..100`.
        goal: what a loop shall do.
        plants: those it shall do it on; the nominal one alone if None.
        judged: plants on which the result is compared with the numbers of the bench; the nominal one if None.
        starts: numbers by path where searches begin, beside those of the bench.
        drive: whose loop is judged; needed if there are several.
        search: how to search.
        noise_seed: of the noise of the sensors, the same in every run; None for none.
        waveforms: of drives of the plant that no controller has.
        watch: called with a sentence and the share that is done.
        keep: called with every set of numbers, by path, that is the best so far.
        native: whether to run in C; by default if there is a compiler.

    Raises:
        ParameterError: an unknown name, a parameter that cannot be searched, no reference.
        SolveError: no start can be run.
    """
    runs = LoopRuns(bench, duration, drive=drive, seed=noise_seed, waveforms=waveforms, native=native)
    own = {path: float(value) for path, value in zip(runs.paths, runs.base, strict=True)}
    freed = build_free_gains(bench, free, starts)
    before = {one.path: own[one.path] for one in freed}
    first = runs.run(runs.table({}, 1))
    course = Course(first.one(0), bench.period) if _is_finite(first) else _find_scales(runs, starts)
    how = search or TuningSearch()
    costs = GainCosts(runs, Cost(goal or TuningGoal(), course), freed, plants, how.slopes)
    cost, best, ends = search_gains(costs, [before, *[{**before, **start} for start in starts]], how, watch, keep)
    after = {path: float(value) for path, value in costs.numbers(best).items()}
    measure = MEASURES[costs.cost.goal.error]
    found = compare_gains(runs, after, course, judged, measure)
    return replace(
        found,
        cost_before=float(costs.compute_costs({p: [v] for p, v in before.items()}, 1)[0]),
        cost=cost,
        evaluations=costs.evaluations,
        gradients=costs.gradients,
        ends=ends,
        notes=_list_bounds(freed, best / costs.widths),
    )


def compare_gains(
    runs: LoopRuns,
    after: Mapping[str, float],
    course: Course | None = None,
    judged: Plants | None = None,
    measure: str = "rms",
) -> TunedBench:
    """Return a loop on the nominal plant before and after a change of numbers by path.

    Costs are those of the default goal; `course` says with what scales, by default those of the
    loop before. The result is judged on the plants `judged` by a `measure` of `judgement`.

    Raises:
        ParameterError: the reference asks for nothing.
    """
    before = {path: float(runs.base[runs.place(path)]) for path in after}
    both = runs.run(runs.table({p: [before[p], after[p]] for p in after}, 2))
    begun, ended = both.one(0), both.one(1)
    course = course or Course(begun, runs.bench.period)
    costs = Cost(TuningGoal(), course)(both)
    return TunedBench(
        runs.bench.with_values(after),
        before,
        dict(after),
        float(costs[0]),
        float(costs[1]),
        measure_loop(begun, course),
        measure_loop(ended, course),
        begun,
        ended,
        runs.times,
        evaluations=2,
        gradients=0,
        ends=(),
        judgement=judge_loops(JudgedLoop(runs, before), JudgedLoop(runs, after), judged, measure),
    )


def _is_finite(seen: Seen) -> bool:
    return bool(np.isfinite(seen.output[0]).all())


def _find_scales(runs: LoopRuns, starts: Sequence[Mapping[str, float]]) -> Course:
    """Return the scales from the first start that runs, where the bench itself does not."""
    for start in starts:
        found = runs.run(runs.table(start, 1))
        if _is_finite(found):
            return Course(found.one(0), runs.bench.period)
    raise SolveError("The loop fails with its present parameters and with all starting points.")


def _list_bounds(free: Sequence[FreeNumber], shares: Numbers) -> list[str]:
    """Return the sentences on bounds that were hit."""
    found: list[str] = []
    for one, share in zip(free, shares.tolist(), strict=True):
        bound = one.bound(share)
        if bound is not None:
            end = one.low if bound == "lower" else one.high
            found.append(
                f"`{one.path}` ended at its bound {end:.4g}: a better number may be beyond it, or it does not matter."
            )
    return found
