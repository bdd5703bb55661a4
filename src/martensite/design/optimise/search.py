"""The search for the best design: a sample, descents from its best points, a look around.

A Sobol sample of the box is judged in one batch. From its best points, which must lie apart, and
from the design of the scenario, SLSQP (Kraft (1988); SciPy) descends with exact derivatives
through the march. Where it ends without keeping all constraints, the sum of squares of what they
miss is followed downhill first (L-BFGS-B), and then it is tried again. An end that misses a
constraint by a hair, as on a kink, is put onto it by Newton's method. Last, clouds of points around
the best end are judged: on kinks of the measures a descent may stop early.

Where a wire does not transform at all, derivatives are 0: no descent leaves such a place, but
a sample that reaches beyond it does. As long as no point of it keeps all constraints, more of the
box is sampled.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass
from importlib import import_module
from typing import Any, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from martensite.base.errors import SolveError
from martensite.design.optimise.design_scales import (
    FAILED_GOAL,
    LARGEST_SLACK,
    DesignGradient,
    DesignScales,
    JudgedDesigns,
)
from martensite.design.optimise.evaluate import DesignEvaluator
from martensite.search.starts import choose_apart, start_sobol

Numbers: TypeAlias = NDArray[np.float64]
Tell = Callable[[str, float], None]
CLOUD_POINTS, CLOUD_SPREAD = 16, 0.05
"""Points of a cloud around an end, and how far they are scattered, as a share of ranges."""
NEARLY_FEASIBLE = 1e-3
"""Slack below 0 with which a point is near enough to all constraints to descend from it."""
STUCK_RUNS = 10
"""For how many runs one counts from which no way leads towards the constraints it misses."""
PROJECTIONS, PROJECTION_MARGIN = 3, 1e-6
"""How often a point that misses constraints by little is put onto them, and how far beyond."""
GOAL_TOLERANCE = 1e-6
"""Change of the goal, as a share of its size, at which a descent ends."""


@dataclass(frozen=True)
class DesignSearch:
    """How designs are searched."""

    sample: int = 64
    """Points of the sample, a power of 2."""
    more: int = 3
    """How often the sample is doubled while none of its points keeps all constraints."""
    descents: int = 3
    """Points from which it is descended, beside the design of the scenario."""
    iterations: int = 50
    """Of each descent, and half of the runs with derivatives that it may make."""
    clouds: int = 2
    """How often the neighbourhood of the best end is tried."""
    seed: int = 0


class DesignPoint(NamedTuple):
    """A design that was judged."""

    z: Numbers
    goal: float
    """As the search sees it."""
    violation: float
    kept: bool

    def is_better_than(self, other: DesignPoint) -> bool:
        """Whether it is better than another."""
        if self.kept and other.kept:
            return self.goal < other.goal
        return self.kept or (not other.kept and self.violation < other.violation)


class SearchMark(NamedTuple):
    """How far a search was at some time."""

    runs: int
    """Runs so far, with derivatives and without."""
    goal: float
    """Of the best design so far, in SI; of the one that misses least while none keeps all."""
    violation: float


class DesignHunt:
    """One search: it remembers what it judged."""

    def __init__(
        self, designs: DesignEvaluator, search: DesignSearch, watch: Tell | None = None
    ) -> None:
        self.designs, self.search, self.watch = designs, search, watch
        self.scales = DesignScales(designs.question)
        self.history: list[SearchMark] = []
        self.best: DesignPoint | None = None
        self._memory: dict[bytes, DesignGradient | None] = {}
        self._rng = np.random.default_rng(search.seed)

    @property
    def size(self) -> int:
        """How many numbers are free."""
        return len(self.designs.question.free)

    # ---------------------------------------------------------------- judging

    def judge(self, z: Numbers) -> list[DesignPoint]:
        """Judge designs, (designs, free), in one batch."""
        return self._points(z, self.scales.convergence_scales(self.designs.values(z)))

    def _points(self, z: Numbers, judged: JudgedDesigns) -> list[DesignPoint]:
        rows = zip(z, judged.goal, judged.violation, judged.kept, strict=True)
        points = [DesignPoint(p, float(g), float(v), bool(k)) for p, g, v, k in rows]
        for point in points:
            self.note(point)
        return points

    def note(self, point: DesignPoint) -> None:
        """Remember the best."""
        if self.best is None or point.is_better_than(self.best):
            self.best = point
            counts, scales = self.designs.counts, self.scales
            runs = counts.simulations + counts.slopes
            self.history.append(
                SearchMark(runs, scales.sign * scales.goal * point.goal, point.violation)
            )

    def gradient(self, z: Numbers) -> DesignGradient | None:
        """Goal, slacks and derivatives at a point, computed once; None if the run fails."""
        key = z.tobytes()
        if key not in self._memory:
            found = self.designs.slopes(z)
            self._memory[key] = None if found is None else self.scales.gradient(found)
            one = self._memory[key]
            if one is not None:
                self._points(z[None], JudgedDesigns(np.array([one.goal]), one.slack[None]))
        return self._memory[key]

    # ---------------------------------------------------------------- the search

    def run(self, begin: Numbers) -> DesignPoint:
        """The best design found from a sample of the box and from one design.

        Raises:
            SolveError: no run of the sample can be made.
        """
        points = self._sample(begin)
        starts = self._starts(points)
        fixed = np.zeros(self.size, np.bool_)
        for k, start in enumerate(starts):
            self.tell(f"descent {k + 1} of {len(starts)}", 0.1 + 0.6 * k / len(starts))
            self.descend(start.z, fixed)
        self.clouds(fixed)
        return self.found

    @property
    def found(self) -> DesignPoint:
        """The best so far."""
        if self.best is None:
            raise SolveError("No design was judged.")
        return self.best

    def _sample(self, begin: Numbers) -> list[DesignPoint]:
        """The sample, until one of its points keeps all constraints; the scenario first."""
        sobol = start_sobol(self.size, self.search.seed)
        self.tell("sampling", 0.0)
        first = np.concatenate([begin[None], sobol.random(self.search.sample)])
        values = self.designs.values(first)
        self.scales.set_size(values)
        points = self._points(first, self.scales.convergence_scales(values))
        for k in range(self.search.more):
            if any(point.kept for point in points):
                break
            self.tell("sampling more", 0.03 * (k + 1))
            points += self.judge(sobol.random(len(points) - 1))
        if all(point.goal >= FAILED_GOAL for point in points):
            raise SolveError(
                f"None of {len(points)} designs in the box can be run and judged; narrow the "
                "bounds, or try the scenario by itself."
            )
        return points

    def _starts(self, points: Sequence[DesignPoint]) -> list[DesignPoint]:
        """The best points that lie apart, after the design of the scenario."""
        judged = JudgedDesigns(
            np.array([p.goal for p in points]), -np.array([[p.violation] for p in points])
        )
        places = np.stack([point.z for point in points])
        order = choose_apart(places, judged.order(), self.search.descents)
        chosen = [points[k] for k in order]
        own = points[0]
        return chosen if any(one is own for one in chosen) else [*chosen, own]

    def descend(self, begin: Numbers, fixed: NDArray[np.bool_]) -> None:
        """Descend from a point, without moving what is fixed; the best is remembered."""
        end = self._slsqp(begin, fixed)
        if not self._is_nearly_feasible(end) and not fixed.all():
            end = self._reduce_violation(begin, fixed)
            end = self._slsqp(end, fixed) if self._is_nearly_feasible(end) else end
        if self._is_nearly_feasible(end):
            self._project(end, fixed)

    def clouds(self, fixed: NDArray[np.bool_]) -> None:
        """Try the neighbourhood of the best point, and go on from there if it is better."""
        for k in range(self.search.clouds):
            before = self.found
            self.tell("looking around", 0.7 + 0.05 * k)
            spread = CLOUD_SPREAD * self._rng.standard_normal((CLOUD_POINTS, self.size))
            spread[:, fixed] = 0.0
            self.judge(np.clip(before.z + spread, 0.0, 1.0))
            if self.found is before:
                break
            self.descend(self.found.z, fixed)

    def _is_nearly_feasible(self, z: Numbers) -> bool:
        found = self.gradient(z)
        return found is not None and bool((found.slack >= -NEARLY_FEASIBLE).all())

    def _slsqp(self, begin: Numbers, fixed: NDArray[np.bool_]) -> Numbers:
        """Where SLSQP ends."""
        place = _Partial(begin, fixed, self)
        if not place.count:
            self.gradient(begin)
            return begin
        constraint = {
            "type": "ineq",
            "fun": lambda u: place(u).slack,
            "jac": lambda u: place(u).slack_slope[:, ~fixed],
        }
        with suppress(_Enough):
            import_module("scipy.optimize").minimize(
                lambda u: (place(u).goal, place(u).goal_slope[~fixed]),
                begin[~fixed],
                jac=True,
                method="SLSQP",
                bounds=[(0.0, 1.0)] * place.count,
                constraints=[constraint] if self.designs.question.subject else [],
                options={"maxiter": self.search.iterations, "ftol": GOAL_TOLERANCE},
            )
        return place.last

    def _project(self, z: Numbers, fixed: NDArray[np.bool_]) -> Numbers:
        """A point that nearly keeps all constraints, put onto those that it misses by a hair."""
        for _ in range(PROJECTIONS):
            one = self.gradient(z)
            lost = np.zeros(0, np.bool_) if one is None else one.slack < 0.0
            if one is None or not lost.any():
                break
            rows = one.slack_slope[lost][:, ~fixed]
            z = z.copy()
            z[~fixed] += np.linalg.lstsq(rows, PROJECTION_MARGIN - one.slack[lost], rcond=1e-6)[0]
            z = np.clip(z, 0.0, 1.0)
        return z

    def _reduce_violation(self, begin: Numbers, fixed: NDArray[np.bool_]) -> Numbers:
        """From a point downhill to where constraints are missed least."""
        place = _Partial(begin, fixed, self)

        def missed(u: Numbers) -> tuple[float, Numbers]:
            one = place(u)
            lost = np.maximum(-one.slack, 0.0)
            return float(0.5 * lost @ lost), -(lost @ one.slack_slope)[~fixed]

        with suppress(_Enough):
            import_module("scipy.optimize").minimize(
                missed,
                begin[~fixed],
                jac=True,
                method="L-BFGS-B",
                bounds=[(0.0, 1.0)] * place.count,
                options={"maxiter": self.search.iterations},
            )
        return place.last

    def tell(self, text: str, done: float) -> None:
        """Say how far it is."""
        if self.watch is not None:
            self.watch(text, done)


class _Enough(Exception):
    """A descent has made all the runs that it may."""


class _Partial:
    """What a search sees while some numbers are fixed; a failed run is far from everything."""

    def __init__(self, begin: Numbers, fixed: NDArray[np.bool_], hunt: DesignHunt) -> None:
        self._begin, self._fixed, self._hunt = begin, fixed, hunt
        self.count = int((~fixed).sum())
        self.last: Numbers = begin
        """Where it was last."""
        self._left = 2 * hunt.search.iterations

    def whole(self, u: Numbers) -> Numbers:
        """All numbers, from those that move."""
        found = self._begin.copy()
        found[~self._fixed] = np.clip(u, 0.0, 1.0)
        return found

    def __call__(self, u: Any) -> DesignGradient:
        """Goal and slacks with derivatives."""
        z = self.whole(np.asarray(u, float))
        if not np.array_equal(z, self.last):
            self._left -= 1
            self.last = z
        if self._left < 0:
            raise _Enough
        found = self._hunt.gradient(z)
        if found is not None and found.goal < FAILED_GOAL:
            lost = found.slack < -NEARLY_FEASIBLE
            if lost.any() and not found.slack_slope[lost].any():
                self._left -= STUCK_RUNS  # nothing moves here
            return found
        size, question = self._hunt.size, self._hunt.designs.question
        count = len(question.cases) * len(question.subject)
        return DesignGradient(
            FAILED_GOAL, np.full(count, -LARGEST_SLACK), np.zeros(size), np.zeros((count, size))
        )
