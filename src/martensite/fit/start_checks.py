"""Checks of a problem before its solution: samples, idle parameters, units.

A free parameter has no effect if the derivatives of all compared outputs are zero at the start and at points spread
over the bounds. The unit of a column is doubtful if its range is more than 100 times, or less than a hundredth of, the
range of the model at the start, and not much nearer at any of these points.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from martensite.base.errors import DataError, ParameterError
from martensite.fit.evaluation import Evaluation
from martensite.fit.free_parameters import is_nuisance
from martensite.fit.problem import Problem
from martensite.search.free_numbers import FreeNumber
from martensite.search.quantity_text import format_change, format_number, format_quantity, join_phrases, list_names
from martensite.search.starts import draw_points

POINTS = 8
"""Number of test points over the bounds."""
FAR_RATIO, NEAR_RATIO = 100.0, 20.0
"""Doubtful ratio of ranges, and ratio at another point that clears a column."""
LEAST_CHANGE = 1e-3
"""Change of a martensite fraction below which nothing transforms."""
NO_EFFECT = 1e-9
"""Derivative, per search range and relative to the range, that counts as zero."""


def check_start(problem: Problem, follows: Sequence[str] = ()) -> list[str]:
    """Raise an error for an impossible fit, and return remarks on doubtful inputs.

    Args:
        problem: problem with the fitted records.
        follows: drive columns of the records, for messages.

    Raises:
        DataError: too few samples, or a unit that is wrong by orders of magnitude.
        ParameterError: a free parameter without effect.
    """
    _require_rows(problem)
    notes = list(_describe_moved_starts(problem))
    first = problem.evaluate(problem.start, slopes=True)
    if first is None:
        return [*notes, "The runs fail at the start of the fit; other starts are tried."]
    idle = find_idle(problem, first)
    doubtful = _find_doubtful(problem, first)
    if not idle and not doubtful:
        return notes
    n = len(problem.free)
    points = [problem.order.find_shares(point) for point in draw_points(n, POINTS)]
    evaluations = [problem.evaluate(u, slopes=bool(idle)) for u in points]
    others = [(u, one) for u, one in zip(points, evaluations, strict=True) if one is not None]
    notes += _refuse_idle(problem, idle, others, follows)
    return notes + _refuse_units(problem, first, doubtful, others, follows)


def _describe_moved_starts(problem: Problem) -> Iterator[str]:
    """Yield the starts that violated the order of a law."""
    for free, u in zip(problem.free, problem.start, strict=True):
        if abs(free.share(free.start) - u) > NO_EFFECT:
            start, at = (format_quantity(x, free.unit) for x in (free.start, free.value(float(u))))
            yield f"`{free.name}` starts at {at} and not at {start}, which its law does not allow beside the others."


def detect_transformation(problem: Problem, u: Any) -> bool:
    """Return whether the martensite fraction of any element changes in any record for some parameters."""
    for k, one in enumerate(problem.experiments):
        system = problem.system(k, u)
        outputs = [system.label(port, "martensite_fraction") for port in system.actuators()]
        fractions = one.sample_outputs(system, outputs, problem.training_rows[k].any(axis=1), problem.step)
        if not np.isfinite(fractions).all() or (np.ptp(fractions, axis=0) > LEAST_CHANGE).any():
            return True
    return False


def find_silent_outputs(problem: Problem) -> list[tuple[str, str]]:
    """Return the record and output of all outputs that no free parameter moves at the start."""
    evaluation = problem.evaluate(problem.start, slopes=True)
    if evaluation is None:
        return []
    own = [i for i, free in enumerate(problem.free) if not is_nuisance(free.path)]
    return [
        (one.name, output)
        for one, fitted in zip(problem.experiments, evaluation.fitted_records, strict=True)
        for k, output in enumerate(one.outputs)
        if not np.any(np.abs(fitted.jacobian[:, k, own]) > NO_EFFECT)
    ]


def _require_rows(problem: Problem) -> None:
    samples, wanted = sum(problem.lengths), len(problem.free)
    if samples <= wanted:
        raise DataError(
            f"{samples} samples are too few for {wanted} free parameters; give more rows, hold "
            "out less, or free fewer parameters."
        )


def find_idle(problem: Problem, evaluation: Evaluation) -> list[int]:
    """Return the free parameters with zero derivatives in all compared outputs."""
    largest = np.max(np.abs(evaluation.jacobian), axis=0)
    return [i for i in range(len(problem.free)) if not largest[i] > NO_EFFECT]


def _refuse_idle(
    problem: Problem, idle: Sequence[int], others: Sequence[tuple[Any, Evaluation]], follows: Sequence[str]
) -> list[str]:
    notes: list[str] = []
    dead: list[int] = []
    for i in idle:
        if any(i not in find_idle(problem, one) for _, one in others):
            notes.append(
                f"`{problem.names[i]}` changes nothing at the start of the fit, but does elsewhere within the bounds."
            )
        else:
            dead.append(i)
    if not dead:
        return notes
    names = list_names([problem.names[i] for i in dead])
    outputs = list_names(list(dict.fromkeys(n for one in problem.experiments for n in one.outputs)))
    one = len(dead) == 1
    raise ParameterError(
        f"Free parameter{'' if one else 's'} {names} change{'s' if one else ''} no compared output "
        f"({outputs}), neither at the start nor at {len(others)} points within the "
        f"bounds; {_suggest_remedy(problem, dead, follows)}"
    )


def _suggest_remedy(problem: Problem, dead: Sequence[int], follows: Sequence[str]) -> str:
    acted = _find_moved_outputs(problem, problem.free[dead[0]])
    if acted:
        it = "it moves" if len(dead) == 1 else f"`{problem.names[dead[0]]}` moves"
        remedy = f"{it} {list_names(acted)}: compare such a column, or keep the parameter fixed."
    else:
        remedy = "such a parameter needs a log in which it comes to bear, or is to be kept fixed."
    ranges = _describe_ranges(problem, follows)
    if ranges and len(dead) == len(problem.free):
        remedy += f" In the first record {ranges}: are columns swapped, or units wrong?"
    return remedy


def _find_moved_outputs(problem: Problem, free: FreeNumber) -> list[str]:
    """Return all outputs that a parameter moves at the start."""
    outputs: list[str] = []
    if is_nuisance(free.path):
        return outputs
    for k, one in enumerate(problem.experiments):
        names = list(one.system.outputs())
        runner = one.runner(problem.step, names)
        values = np.array(runner.compiled.values(problem.system(k, problem.start)))
        seeds = np.array([[float(free.moves(path))] for path in runner.paths])
        marched = runner.run_slopes(values, seeds * free.slope(free.share(free.start)))
        if not runner.native or marched is None:
            continue
        moved = np.max(np.abs(marched[1][:, :, 0]), axis=0)
        sizes = np.max(np.abs(marched[0]), axis=0)
        outputs += [n for n, m, s in zip(names, moved, sizes, strict=True) if m > NO_EFFECT * s]
    return list(dict.fromkeys(outputs))


def _describe_ranges(problem: Problem, follows: Sequence[str]) -> str:
    record = problem.experiments[0].record
    phrases: list[str] = []
    for name in follows:
        finite_numbers = [x for x in record[name].tolist() if math.isfinite(x)]
        low, high = (format_quantity(end, record.units[name]) for end in (min(finite_numbers), max(finite_numbers)))
        phrases.append(f"`{name}` goes from {low} to {high}")
    return join_phrases(phrases)


def _find_doubtful(problem: Problem, evaluation: Evaluation) -> list[tuple[int, int]]:
    """Return the experiment and output whose measured range is far from the modelled range."""
    return [
        (e, k)
        for e, one in enumerate(problem.experiments)
        for k in range(len(one.outputs))
        if not 1.0 / FAR_RATIO <= _compare_ranges(problem, evaluation, e, k) <= FAR_RATIO
    ]


def _compare_ranges(problem: Problem, evaluation: Evaluation, e: int, k: int) -> float:
    used = problem.training_rows[e][:, k]
    measured = np.ptp(problem.experiments[e].measured[used, k])
    modelled = np.ptp(evaluation.fitted_records[e].model[used, k])
    return float(measured / modelled) if modelled > 0.0 else math.inf


def _refuse_units(
    problem: Problem,
    first: Evaluation,
    doubtful: Sequence[tuple[int, int]],
    others: Sequence[tuple[Any, Evaluation]],
    follows: Sequence[str],
) -> list[str]:
    notes: list[str] = []
    for e, k in doubtful:
        one, ratio = problem.experiments[e], _compare_ranges(problem, first, e, k)
        output, elsewhere = one.outputs[k], [_compare_ranges(problem, f, e, k) for _, f in others]
        measured = float(np.ptp(one.measured[problem.training_rows[e][:, k], k]))
        modelled = float(np.ptp(first.fitted_records[e].model[problem.training_rows[e][:, k], k]))
        unit = one.describe_outputs()[output].unit
        clause = (
            f"Column `{one.columns[output]}` of record `{one.record.name}` ranges over "
            f"{format_change(measured, unit, 3)}, the scenario at its start over "
            f"{format_change(modelled, unit, 3)}"
        )
        if any(1.0 / NEAR_RATIO <= r <= NEAR_RATIO for r in elsewhere):
            notes.append(f"{clause}: the start is far off.")
            continue
        doubt = _describe_doubt(ratio, 2 if unit == "1" else 3, follows)
        raise DataError(f"{clause}, and nowhere within the bounds much nearer: {doubt}")
    return notes


def _describe_doubt(ratio: float, decades: int, follows: Sequence[str]) -> str:
    """Describe the doubt about a column whose range is `ratio` times the range of the model.

    Units of its kind differ by multiples of `decades`: 3, or 2 for fractions and per cent.
    """
    drive = f", and that of {list_names(list(follows))}, which drives," if follows else ""
    swapped = "Or were columns swapped?"
    if not 0.0 < ratio < math.inf:
        return f"is its unit{drive} right? {swapped}"
    steps = abs(math.log10(ratio)) / decades
    factor = format_number(10.0 ** (decades * max(1, round(steps))))
    size = "large" if ratio > 1.0 else "small"
    return f"is its unit{drive} right? It looks {factor} times too {size}: a factor of {factor} would fit. {swapped}"
