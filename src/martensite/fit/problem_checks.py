"""What makes a problem impossible: nothing free, nothing fitted, or one number moved twice."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from martensite.base.errors import ParameterError
from martensite.fit.experiment import Experiment
from martensite.fit.free_parameters import is_nuisance
from martensite.search.free_numbers import FreeNumber

if TYPE_CHECKING:
    from martensite.fit.problem import Problem


def check_problem(problem: Problem) -> None:
    """Refuse a problem that has no solution.

    Raises:
        ParameterError: the sentence says why.
    """
    if not problem.experiments:
        raise ParameterError("A fit needs at least one record; none given.")
    if not problem.free:
        raise ParameterError("A fit needs at least one free parameter; none given.")
    for kind, names in (
        ("record", [one.name for one in problem.experiments]),
        ("free parameter", list(problem.names)),
    ):
        double = next((name for name in names if names.count(name) > 1), None)
        if double is not None:
            raise ParameterError(f"There are two of {kind} `{double}`; give each its own name.")
    if all(one.held_out for one in problem.experiments):
        raise ParameterError("All records are kept back, and none is left to be fitted.")
    for one in problem.experiments:
        _refuse_double(one, problem.free)


def _refuse_double(one: Experiment, free: Sequence[FreeNumber]) -> None:
    """Refuse two free parameters that move the same number of an experiment."""
    own = [x for x in free if x.record in (None, one.name) and not is_nuisance(x.path)]
    for leaf in one.system.leaves():
        movers = [x.name for x in own if x.moves(leaf.path)]
        if len(movers) > 1:
            raise ParameterError(
                f"Free parameters `{movers[0]}` and `{movers[1]}` both move `{leaf.path}` of "
                f"record `{one.name}`; leave one of them out."
            )
