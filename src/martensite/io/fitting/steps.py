"""Steps of the runs of a fit: short enough at the start, and looked at again at the end.

Where all temperatures are prescribed and nothing depends on rates, the rows of a record are
steps enough; one run with the halved step shows whether this is so. Elsewhere one simulation
to the tolerance of the scenario gives the step.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

from martensite.identify.fitting.experiment import Experiment
from martensite.identify.fitting.problem import Problem
from martensite.identify.fitting.runner import Runner
from martensite.runtimes.c99 import compiler

NOTICEABLE = 0.1
"""Change on halving the step, as a share of the error left, from which on it is told."""


def with_step(experiment: Experiment, tolerance: float) -> tuple[Experiment, list[str]]:
    """An experiment with a step to the tolerance (share of range), and what to say of it.

    Raises:
        SolveError: the run fails at its start values.
    """
    import numpy as np

    sources = [one.source for one in experiment.system.actuators().values()]
    if all(source.sets_temperature for source in sources):
        apart = _apart(*(_run(one) for one in (experiment, halved(experiment))))
        if np.all(apart <= tolerance):
            return experiment, []
    return _simulated(experiment, tolerance)


def halved(experiment: Experiment) -> Experiment:
    """The experiment with half the longest step that it takes."""
    return replace(experiment, step=0.5 * experiment.grid().longest)


def _simulated(experiment: Experiment, tolerance: float) -> tuple[Experiment, list[str]]:
    from martensite.simulate.api import simulate

    result = simulate(
        experiment.system, experiment.waveform, float(experiment.times[-1]),
        tolerance=tolerance, runtime="floats" if compiler() is None else "c",
    )  # fmt: skip
    notes: list[str] = []
    if result.accuracy is not None and result.accuracy > tolerance:
        notes.append(
            f"Record `{experiment.name}`: the tolerance of {tolerance:.1e} was not reached at the "
            f"start; steps of {result.step:.3g} s change the run by {result.accuracy:.1e} of range."
        )
    return replace(experiment, step=result.step), notes


def _run(experiment: Experiment) -> Any:
    runner = Runner(experiment)
    return runner.run(runner.compiled.values(experiment.system)).values


def _apart(coarse: Any, fine: Any) -> Any:
    """Largest change of each output as a share of its range."""
    import numpy as np

    reach = np.ptp(fine, axis=0)
    with np.errstate(invalid="ignore", divide="ignore"):
        share = np.max(np.abs(fine - coarse), axis=0) / reach
    return np.where(reach > 0.0, share, math.inf)


def remarks_on_step(problem: Problem, values: Sequence[float], tolerance: float) -> list[str]:
    """What halving all steps changes at the optimum, if that is noticeable.

    Args:
        problem: with the records that the fit saw.
        values: of its free parameters, as shares of their ranges.
        tolerance: share of range below which a change does not matter.
    """
    import numpy as np

    fixed = [one if problem.step is None else replace(one, step=problem.step)
             for one in problem.experiments]  # fmt: skip
    fine = replace(problem, experiments=tuple(map(halved, fixed)), step=None)
    before, after = problem.evaluate(values), fine.evaluate(values)
    if before is None or after is None:
        return ["The runs fail at the optimum with halved steps; the fit is not to be trusted."]
    pairs = list(zip(before.fitted, after.fitted, strict=True))
    worst = max(float(np.max(_apart_or_0(a.model, b.model))) for a, b in pairs)
    moved = math.sqrt(float(np.mean((after.residuals - before.residuals) ** 2)))
    if worst <= tolerance or moved <= NOTICEABLE * math.sqrt(before.cost):
        return []
    step = max(one.grid().longest for one in fixed)
    return [
        f"Halving the steps changes the fitted runs by up to {100.0 * worst:.2g} % of their range "
        f"and the cost from {before.cost:.4g} to {after.cost:.4g}: steps of up to {step:.3g} s are "
        f'too long for this fit; repeat it with a step of "{0.25 * step:.2g} s".'
    ]


def _apart_or_0(coarse: Any, fine: Any) -> Any:
    """As `_apart`; 0 for what does not move."""
    import numpy as np

    apart = _apart(coarse, fine)
    return np.where(np.isfinite(apart), apart, 0.0)
