"""Constrained minimisation in a box: descents from several starts, then a neighbourhood search.

From every start SLSQP (Kraft (1988); SciPy) descends with exact derivatives, or L-BFGS-B (Byrd, Lu, Nocedal and Zhu
(1995); SciPy) without constraints. If the end violates constraints, L-BFGS-B first minimises the sum of squared
violations, and the descent is repeated. Newton's method moves an end with small violations, such as on a kink, onto
its constraint. Last, clouds of points around the best end are evaluated, because kinks and jumps may stop a descent
early. Without derivatives the method is Nelder and Mead.
"""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from importlib import import_module
from typing import Any, NamedTuple, Protocol, TypeAlias

import numpy as np
from numpy.typing import NDArray

from martensite.base.errors import SolveError

Numbers: TypeAlias = NDArray[np.float64]
Tell: TypeAlias = Callable[[str, float], None]
LARGEST_SLACK = 10.0
"""Largest slack that counts."""
FAILED_GOAL = 1e6
"""Goal of a point if its run fails or never reaches it."""
FEASIBLE_VIOLATION = 1e-5
"""Largest negligible violation of a constraint."""
NEARLY_FEASIBLE = 1e-3
"""Largest violation from which a descent can start."""
CLOUD_POINTS = 16
"""Number of points of a cloud around an end."""
STUCK_RUNS = 20
"""Number of runs counted for a point without a direction towards its violated constraints."""
PROJECTIONS, PROJECTION_MARGIN = 3, 1e-6
"""Largest number of projections of a point with small violations onto constraints, and distance beyond them."""
GOAL_TOLERANCE = 1e-6
"""Change of the goal at which a descent ends."""


class JudgedPoints(NamedTuple):
    """Evaluated points of a search."""

    goal: Numbers
    """(points,)"""
    slack: Numbers
    """Distance of constraints from their limits, negative for violations, (points, constraints)."""

    @property
    def violation(self) -> Numbers:
        """Return the sum of all violations, (points,)."""
        return np.maximum(-self.slack, 0.0).sum(axis=1)

    @property
    def feasible(self) -> NDArray[np.bool_]:
        """Return whether all constraints are satisfied, (points,)."""
        return (self.slack >= -FEASIBLE_VIOLATION).all(axis=1) & (self.goal < FAILED_GOAL)

    def order(self) -> list[int]:
        """Return the order from best to worst: feasible points by goal, then others by violation."""
        lost = np.where(self.feasible, 0.0, FEASIBLE_VIOLATION + self.violation)
        return [int(k) for k in np.lexsort((self.goal, lost))]


class PointSlopes(NamedTuple):
    """Evaluated point with derivatives with respect to its places."""

    goal: float
    slack: Numbers
    goal_slope: Numbers
    """(free,)"""
    slack_slope: Numbers
    """(constraints, free)"""


class BoxPoint(NamedTuple):
    """Evaluated point."""

    z: Numbers
    goal: float
    violation: float
    feasible: bool

    def is_better_than(self, other: BoxPoint) -> bool:
        """Return whether this point is better than another."""
        if self.feasible and other.feasible:
            return self.goal < other.goal
        return self.feasible or (not other.feasible and self.violation < other.violation)


class SearchMark(NamedTuple):
    """Progress of a search at a given time."""

    runs: int
    """Number of runs, with and without derivatives."""
    goal: float
    """Goal of the best point, or of the point with the smallest violation while no point is feasible."""
    violation: float


class BoxObjective(Protocol):
    """Objective of a search: places z of free parameters, each from 0 to its width."""

    @property
    def widths(self) -> Numbers:
        """Return the width of the box, (free,), on a scale where a step of 1 is large."""
        ...

    @property
    def scatter(self) -> Numbers:
        """Return the standard deviation of a cloud, (free,)."""
        ...

    @property
    def runs(self) -> int:
        """Return the number of runs."""
        ...

    @property
    def differentiable(self) -> bool:
        """Return whether there are derivatives."""
        ...

    @property
    def partial(self) -> bool:
        """Return whether derivatives cover only a part of the objective, such as some plants."""
        ...

    def judge(self, z: Numbers) -> JudgedPoints:
        """Evaluate goals and slacks of points (points, free), in one batch."""
        ...

    def differentiate(self, z: Numbers) -> PointSlopes | None:
        """Return one point with its derivatives; None if a run fails."""
        ...


class BoxSearch:
    """Search that stores its best evaluated point."""

    def __init__(
        self, objective: BoxObjective, *, iterations: int, clouds: int, seed: int = 0, watch: Tell | None = None
    ) -> None:
        """Prepare a search; `watch` receives a sentence and the completed fraction.

        Each descent has `iterations`, half of its allowed runs with derivatives. The neighbourhood of the best end is
        searched `clouds` times.
        """
        self.objective, self.iterations, self.cloud_count = objective, iterations, clouds
        self.watch = watch
        self.size = len(objective.widths)
        self.history: list[SearchMark] = []
        self.best: BoxPoint | None = None
        self.keep: Callable[[BoxPoint], None] | None = None
        """Callback with every new best point."""
        self.ends: list[float] = []
        """Goals at the ends of descents."""
        self._memory: dict[bytes, PointSlopes | None] = {}
        self._rng = np.random.default_rng(seed)

    def judge(self, z: Numbers) -> list[BoxPoint]:
        """Evaluate points, (points, free), in one batch."""
        return self.note_points(z, self.objective.judge(z))

    def note_points(self, z: Numbers, judged: JudgedPoints) -> list[BoxPoint]:
        """Return the evaluated points, and store the best."""
        rows = zip(z, judged.goal, judged.violation, judged.feasible, strict=True)
        points = [BoxPoint(p, float(g), float(v), bool(k)) for p, g, v, k in rows]
        for point in points:
            if self.best is None or point.is_better_than(self.best):
                self.best = point
                if self.keep is not None:
                    self.keep(point)
                self.history.append(SearchMark(self.objective.runs, point.goal, point.violation))
        return points

    def differentiate(self, z: Numbers) -> PointSlopes | None:
        """Return a point with its derivatives, computed once; None if the run fails."""
        key = z.tobytes()
        if key not in self._memory:
            point = self._memory[key] = self.objective.differentiate(z)
            if point is not None and not self.objective.partial:
                self.note_points(z[None], JudgedPoints(np.array([point.goal]), point.slack[None]))
        return self._memory[key]

    @property
    def best_point(self) -> BoxPoint:
        """Return the best point."""
        if self.best is None:
            raise SolveError("No design was evaluated.")
        return self.best

    def scatter_points(
        self, z: Numbers, count: int, wide: float = 1.0, fixed: NDArray[np.bool_] | None = None
    ) -> Numbers:
        """Return points around a centre, (count, free), in a multiple of the distance of a cloud."""
        spread = wide * self.objective.scatter * self._rng.standard_normal((count, self.size))
        if fixed is not None:
            spread[:, fixed] = 0.0
        return np.clip(z + spread, 0.0, self.objective.widths)

    def look_around(self, fixed: NDArray[np.bool_] | None = None) -> None:
        """Search the neighbourhood of the best point, and continue from a better point."""
        for _ in range(self.cloud_count):
            before = self.best_point
            self.judge(self.scatter_points(before.z, CLOUD_POINTS, fixed=fixed))
            if self.best_point is before:
                break
            self.descend(self.best_point.z, fixed)

    def descend(self, begin: Numbers, fixed: NDArray[np.bool_] | None = None) -> None:
        """Descend from a point with some parameters fixed, and store the best point."""
        fixed = np.zeros(self.size, np.bool_) if fixed is None else fixed
        if not self.objective.differentiable:
            end = self._follow_values(begin, fixed)
        else:
            end = self._follow_slopes(begin, fixed)
            if not self._is_nearly_feasible(end) and not fixed.all():
                end = self._reduce_violation(begin, fixed)
                end = self._follow_slopes(end, fixed) if self._is_nearly_feasible(end) else end
            if self._is_nearly_feasible(end):
                end = self._project(end, fixed)
        one = None if self.objective.partial else self._memory.get(end.tobytes())
        self.ends.append(self.judge(end[None])[0].goal if one is None else one.goal)

    def _is_nearly_feasible(self, z: Numbers) -> bool:
        point = self.differentiate(z)
        return point is not None and bool((point.slack >= -NEARLY_FEASIBLE).all())

    def _follow_slopes(self, begin: Numbers, fixed: NDArray[np.bool_]) -> Numbers:
        """Return the end of SLSQP, or of L-BFGS-B without constraints."""
        first = self.differentiate(begin)
        if first is None or fixed.all():
            return begin
        place, options = _MovingPart(begin, fixed, self), {"ftol": GOAL_TOLERANCE}
        constraint = {"type": "ineq", "fun": lambda u: place(u).slack, "jac": lambda u: place(u).slack_slope[:, ~fixed]}
        given = {"method": "SLSQP", "constraints": [constraint] if len(first.slack) else [], "options": options}
        return place.minimise(lambda one: (one.goal, one.goal_slope), given)

    def _reduce_violation(self, begin: Numbers, fixed: NDArray[np.bool_]) -> Numbers:

        def missed(one: PointSlopes) -> tuple[float, Numbers]:
            lost = np.maximum(-one.slack, 0.0)
            return float(0.5 * lost @ lost), -(lost @ one.slack_slope)

        given = {"method": "L-BFGS-B", "options": {}}
        return _MovingPart(begin, fixed, self).minimise(missed, given)

    def _project(self, z: Numbers, fixed: NDArray[np.bool_]) -> Numbers:
        """Project a point with small violations onto the violated constraints."""
        for _ in range(PROJECTIONS):
            one = self.differentiate(z)
            lost = np.zeros(0, np.bool_) if one is None else one.slack < 0.0
            if one is None or not lost.any():
                break
            rows = one.slack_slope[lost][:, ~fixed]
            z = z.copy()
            z[~fixed] += np.linalg.lstsq(rows, PROJECTION_MARGIN - one.slack[lost], rcond=1e-6)[0]
            z = np.clip(z, 0.0, self.objective.widths)
        return z

    def _follow_values(self, begin: Numbers, fixed: NDArray[np.bool_]) -> Numbers:
        place = _MovingPart(begin, fixed, self)
        solution = import_module("scipy.optimize").minimize(
            lambda u: self.judge(place.whole(u)[None])[0].goal,
            begin[~fixed],
            method="Nelder-Mead",
            bounds=place.bounds,
            options={"maxiter": self.iterations, "xatol": 1e-2, "fatol": GOAL_TOLERANCE},
        )
        return place.whole(solution.x)

    def tell(self, text: str, done: float) -> None:
        """Report the progress."""
        if self.watch is not None:
            self.watch(text, done)


class _SpentError(Exception):
    """Error at the end of the run budget of a descent."""


class _MovingPart:
    """View of a descent with some fixed parameters; a failed run has the worst goal and slacks."""

    def __init__(self, begin: Numbers, fixed: NDArray[np.bool_], search: BoxSearch) -> None:
        self._begin, self._moving, self._search = begin, ~fixed, search
        self.bounds = [(0.0, width) for width in search.objective.widths[~fixed]]
        self.last: Numbers = begin
        """Last point."""
        self._remaining_runs = 2 * search.iterations

    def whole(self, u: Numbers) -> Numbers:
        """Return all parameters from the moving ones."""
        parameters = self._begin.copy()
        parameters[self._moving] = u
        return np.clip(parameters, 0.0, self._search.objective.widths)

    def minimise(self, cost: Callable[[PointSlopes], tuple[float, Numbers]], given: dict[str, Any]) -> Numbers:
        """Minimise a cost by a method of SciPy, and return its end."""

        def value(u: Numbers) -> tuple[float, Numbers]:
            cost_value, slope = cost(self(u))
            return cost_value, slope[self._moving]

        options = given["options"] | {"maxiter": self._search.iterations}
        with suppress(_SpentError):
            import_module("scipy.optimize").minimize(
                value, self._begin[self._moving], jac=True, bounds=self.bounds, **(given | {"options": options})
            )
        return self.last

    def __call__(self, u: Any) -> PointSlopes:
        """Return the goal and slacks with derivatives."""
        z = self.whole(np.asarray(u, float))
        if not np.array_equal(z, self.last):
            self._remaining_runs -= 1
            self.last = z
        if self._remaining_runs < 0:
            raise _SpentError
        point = self._search.differentiate(z)
        if point is not None and point.goal < FAILED_GOAL:
            lost = point.slack < -NEARLY_FEASIBLE
            if lost.any() and not point.slack_slope[lost].any():
                self._remaining_runs -= STUCK_RUNS  # no free parameter moves
            return point
        first = self._search.differentiate(self._begin)
        count = 0 if first is None else len(first.slack)
        size = len(z)
        return PointSlopes(FAILED_GOAL, np.full(count, -LARGEST_SLACK), np.zeros(size), np.zeros((count, size)))
