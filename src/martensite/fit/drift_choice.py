"""Choice between laws of drift in a table of cycles: exponential, logarithm of the cycles, or both.

If both amplitudes of a quantity are free, such as `residual_strain` and `residual_strain_per_decade`, each law is
fitted to the earlier cycles and predicts the later ones. Both together win only with a clearly smaller error, and if
the intervals of their amplitudes exclude 0.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from martensite.base.errors import SolveError
from martensite.fit.condition_fits import hold_later
from martensite.fit.condition_runs import ConditionExperiment
from martensite.fit.descents import INTERRUPTED, OUT_OF_TIME
from martensite.fit.experiment import Experiment
from martensite.fit.fit import HELD_OUT, Fit, compute_rms, list_compared
from martensite.fit.fit_verdicts import format_error
from martensite.fit.log_trials import CLEARLY, choose_model
from martensite.fit.problem import Problem
from martensite.search.free_numbers import FreeNumber
from martensite.search.quantity_text import format_number, join_phrases, list_names
from martensite.search.time_box import OutOfTimeError

PER_DECADE = "_per_decade"
"""End of the names of amplitudes of the logarithm."""


@dataclass(frozen=True)
class TriedDrift:
    """Law of drift, fitted to the earlier cycles."""

    name: str
    problem: Problem
    """Problem of all rows, with the amplitudes of other laws at 0."""
    fit: Fit
    dropped: tuple[str, ...]

    @property
    def error(self) -> float:
        """Return the error in the later cycles, as a fraction of the range of each output."""
        rows, problem = list_compared(self.fit), self.fit.problem
        squares = [
            (one.residuals[one.held_out_rows] / problem.scale(one.output)) ** 2
            for one in rows
            if one.held_out_rows.any()
        ]
        return math.sqrt(float(np.mean(np.concatenate(squares))))

    def excludes_zero(self, names: Sequence[str]) -> bool:
        """Return whether the intervals of some parameters exclude 0."""
        ends = (self.fit.uncertainty.widen_interval(name) for name in names)
        return all(low > 0.0 or high < 0.0 for low, high in ends)

    def describe(self) -> str:
        """Return the name and the errors in the later cycles."""
        rows = list_compared(self.fit)
        outputs = {one.output: one.description.unit for one in rows}
        errors = (
            f"{format_error(name, compute_rms([x for x in rows if x.output == name], HELD_OUT), unit)} (`{name}`)"
            for name, unit in outputs.items()
        )
        return f"{self.name} {join_phrases(list(errors))}"


def choose_drift(problem: Problem, solve: Callable[[Problem], Fit]) -> tuple[Problem, list[str]]:
    """Return the problem with the law of drift that predicts the later cycles, and remarks; unchanged without a choice.

    Raises:
        KeyboardInterrupt: the comparison was interrupted.
        SolveError: no law can be fitted.
    """
    ends = (name.removesuffix(PER_DECADE) for name in problem.names if name.endswith(PER_DECADE))
    settling = [name for name in ends if name in problem.names]
    slow, later = [name + PER_DECADE for name in settling], hold_later(problem.experiments)
    if not slow or later is None:
        return problem, []
    free = tuple(_allow_zero(x) if x.name in (*slow, *settling) else x for x in problem.free)
    relaxed_problem = replace(problem, free=free)
    try:
        tried, notes = _try_laws(
            relaxed_problem, {"exponential": slow, "logarithm": settling, "both": []}, later, solve
        )
    except OutOfTimeError:
        return problem, ["The laws of drift were not compared, because of the time box (`--time-box`)."]
    simple = [one for one in tried if one.dropped or one.excludes_zero([*slow, *settling])]
    return _conclude(choose_model(simple or tried), tried, later, notes)


def _try_laws(
    problem: Problem,
    laws: Mapping[str, Sequence[str]],
    later: Sequence[ConditionExperiment],
    solve: Callable[[Problem], Fit],
) -> tuple[list[TriedDrift], list[str]]:
    """Return the laws fitted to the earlier cycles, and remarks; `laws` lists the amplitudes that are 0."""
    tried, notes = list[TriedDrift](), list[str]()
    for name, dropped in laws.items():
        reduced_problem = _drop_numbers(problem, dropped)
        experiments = tuple(
            replace(new, held_out_intervals=old.held_out_intervals)
            for new, old in zip(reduced_problem.experiments, later, strict=True)
        )
        try:
            fit = solve(replace(reduced_problem, experiments=experiments))
        except SolveError as error:
            notes.append(f"Drift law not compared: {name}. {error}")
            continue
        if fit.reason in (INTERRUPTED, OUT_OF_TIME):
            raise KeyboardInterrupt if fit.reason == INTERRUPTED else OutOfTimeError
        tried.append(TriedDrift(name, reduced_problem, fit, tuple(dropped)))
    if not tried:
        raise SolveError(f"No law of drift can be fitted. {' '.join(notes)}")
    return tried, notes


def _conclude(
    best: TriedDrift, tried: Sequence[TriedDrift], later: Sequence[ConditionExperiment], notes: list[str]
) -> tuple[Problem, list[str]]:
    least = min(one.cycles[round(first) - 1] for one in later for first, _ in one.held_out_intervals)
    text = (
        f"Drift law: {best.name}. Errors in the later cycles, from {format_number(least, 6)} on, predicted from the "
        f"earlier ones: {'; '.join(one.describe() for one in tried)}. Both need less than {100.0 * CLEARLY:.0f} % "
        "of the error of one alone, and amplitudes with intervals that exclude 0."
    )
    if best.dropped:
        text += f" Set {list_names(list(best.dropped))} to 0 in the scenario."
    return best.problem, [*notes, text]


def _drop_numbers(problem: Problem, names: Sequence[str]) -> Problem:
    """Return the problem with some free parameters fixed at 0."""
    dropped = [free for free in problem.free if free.name in names]
    experiments = list[Experiment]()
    for one in problem.experiments:
        paths = [leaf.path for leaf in one.system.leaves() if any(free.moves(leaf.path) for free in dropped)]
        experiments.append(replace(one, system=one.system.with_values(dict.fromkeys(paths, 0.0))))
    return replace(problem, experiments=tuple(experiments), free=tuple(x for x in problem.free if x.name not in names))


def _allow_zero(free: FreeNumber) -> FreeNumber:
    """Return a free amplitude with 0 within its bounds."""
    return replace(free, low=min(free.low, 0.0), high=max(free.high, 0.0), logarithmic=False)
