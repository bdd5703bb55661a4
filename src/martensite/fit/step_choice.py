"""Choice of time steps for a fit, at the start and again at the end.

If all temperatures are prescribed and nothing depends on rates, one step per row may suffice; a run with halved steps
tests this. Otherwise equal steps are halved until a run agrees with a run under error control. A fit then keeps its
steps, so that the cost is a smooth function of the parameters.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np

from martensite.base.errors import SolveError
from martensite.fit.experiment import Experiment
from martensite.fit.fit import Fit

NOTICEABLE_CHANGE = 0.5
"""Change of a parameter on halving the steps, in standard errors, from which it is reported."""
NEGLIGIBLE_CHANGE = 1e-6
"""Negligible change of a parameter, as a fraction of its search range."""


def choose_step(experiment: Experiment, tolerance: float) -> tuple[Experiment, list[str]]:
    """Return an experiment with a step chosen by the tolerance (fraction of range), and remarks.

    Raises:
        SolveError: the run fails at its start values.
    """
    sources = [one.source for one in experiment.system.actuators().values()]
    if all(source.sets_temperature for source in sources):
        apart = _compare_runs(*(_run_experiment(one) for one in (experiment, halve_step(experiment))))
        if np.all(apart <= tolerance):
            return experiment, []
    return _find_step(experiment, tolerance)


def halve_step(experiment: Experiment) -> Experiment:
    """Return the experiment with its longest step halved."""
    return replace(experiment, step=0.5 * experiment.grid().longest)


def _find_step(experiment: Experiment, tolerance: float) -> tuple[Experiment, list[str]]:
    from martensite.simulate.trial_runs import find_step

    duration = float(experiment.times[-1] + experiment.lead)
    equal_step = find_step(experiment.system, experiment.waveform, duration, tolerance)
    notes: list[str] = []
    if equal_step.apart > tolerance:
        notes.append(
            f"Record `{experiment.name}`: the tolerance of {tolerance:.1e} was not reached at the "
            f"start; a run in steps of {equal_step.step:.3g} s is off by {equal_step.apart:.1e} of range."
        )
    return replace(experiment, step=equal_step.step), notes


def _run_experiment(experiment: Experiment) -> Any:
    runner = experiment.runner()
    outputs = runner.run_one(runner.base)
    if outputs is None:
        raise SolveError(f"The run of record `{experiment.name}` fails at its start values.")
    return outputs


def _compare_runs(coarse: Any, fine: Any) -> Any:
    reach = np.ptp(fine, axis=0)
    with np.errstate(invalid="ignore", divide="ignore"):
        share = np.max(np.abs(fine - coarse), axis=0) / reach
    return np.where(reach > 0.0, share, math.inf)


def describe_step_error(fit: Fit) -> list[str]:
    """Describe the effect of halving all steps, if noticeable compared with the noise.

    The change of the parameters is about the least-squares solution of J dz = dr for the change dr of the residuals.
    """
    problem = fit.problem
    fixed = [one if problem.step is None else replace(one, step=problem.step) for one in problem.experiments]
    fine = replace(problem, experiments=tuple(map(halve_step, fixed)), step=None)
    after = fine.evaluate(fit.values)
    if after is None:
        return ["The runs fail at the optimum with halved steps; the fit is not to be trusted."]
    change = after.residuals - fit.evaluation.residuals
    moved = np.linalg.lstsq(fit.evaluation.jacobian, change, rcond=None)[0]
    sizes = [free.slope(u) for free, u in zip(problem.free, fit.values, strict=True)]
    errors = np.array(fit.uncertainty.errors) * fit.uncertainty.widening / np.abs(sizes)
    with np.errstate(invalid="ignore", divide="ignore"):
        shares = np.where((errors > 0.0) & (np.abs(moved) > NEGLIGIBLE_CHANGE), np.abs(moved) / errors, 0.0)
    worst = int(np.argmax(shares))
    if not shares[worst] > NOTICEABLE_CHANGE:
        return []
    step = max(one.grid().longest for one in fixed)
    return [
        f"Steps of up to {step:.3g} s are too long for so little noise: half of them would move "
        f"`{problem.names[worst]}` by about {shares[worst]:.2g} of its standard errors, and the "
        f'cost from {fit.cost:.4g} to {after.cost:.4g}; repeat the fit with --step "'
        f'{0.25 * step:.2g} s".'
    ]
