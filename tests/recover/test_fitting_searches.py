"""Searches without derivatives find what they can, and say where they stop.

Sources of truth: minima known in closed form; a ridge across the axes, on which a coordinate
search must stall, since along no axis is there an improvement of its step.
"""

import math
from collections.abc import Sequence
from itertools import pairwise

import numpy as np
import pytest

from martensite.base.errors import ParameterError, SolveError
from martensite.fit.coordinate_search import coordinate_search
from martensite.fit.multistart import evolve, multistart, sobol_points

LOW, HIGH = (15.0, 4.0, 0.5), (35.0, 7.0, 50.0)
BEST = (30.0, 5.2, 11.0)


def unit(point: Sequence[float]) -> np.ndarray:
    low = np.asarray(LOW)
    return (np.asarray(point) - low) / (np.asarray(HIGH) - low)


def bowl(point: Sequence[float]) -> float:
    return float(np.sum((unit(point) - unit(BEST)) ** 2))


def ridge(point: Sequence[float], width: float = 1e-3) -> float:
    """A valley along the diagonal of two parameters, falling gently towards its end."""
    u = unit(point)
    return float(((u[0] - u[1]) / width) ** 2 + (u[0] + u[1] - 1.8) ** 2)


def two_bowls(points: np.ndarray) -> np.ndarray:
    """The deeper of two minima is narrow."""
    u = np.asarray([unit(p) for p in points])
    wide = 0.4 + np.sum((u - 0.3) ** 2, axis=1)
    narrow = 6.0 * np.sum((u - 0.85) ** 2, axis=1)
    return np.minimum(wide, narrow)


# ---------------------------------------------------------------- coordinate search


def test_a_bowl_is_found_to_the_last_step():
    found = coordinate_search(bowl, (20.0, 4.5, 40.0), LOW, HIGH)
    assert found.reason == "stalled"
    assert np.abs(unit(found.values) - unit(BEST)).max() <= 1e-3
    assert found.step < 1e-3
    assert found.evaluations < 200
    assert found.cost == bowl(found.values)


def test_every_evaluation_counts_and_the_history_falls():
    seen: list[tuple[float, ...]] = []

    def counted(point: tuple[float, ...]) -> float:
        seen.append(point)
        return bowl(point)

    reported: list[int] = []
    found = coordinate_search(
        counted, (20.0, 4.5, 40.0), LOW, HIGH, progress=lambda best, cost, n: reported.append(n)
    )
    assert len(seen) == found.evaluations == reported[-1] == len(reported)
    assert (np.asarray(seen) >= LOW).all()
    assert (np.asarray(seen) <= HIGH).all()
    assert all(b[0] > a[0] and b[1] <= a[1] for a, b in pairwise(found.history))
    assert found.history[-1] == (found.evaluations, found.cost)


def test_the_steps_are_a_tenth_then_twice_or_half():
    """By hand, in one parameter from 0 to 1 with the minimum at 0.6 and the start at 0.2."""
    seen: list[float] = []

    def line(point: tuple[float, ...]) -> float:
        seen.append(point[0])
        return abs(point[0] - 0.6)

    coordinate_search(line, (0.2,), (0.0,), (1.0,), cap=8)
    # 0.1 up; 0.2 up; 0.4 up and down, neither better; halved to 0.2, then to 0.1
    assert seen == pytest.approx([0.2, 0.3, 0.5, 0.9, 0.1, 0.7, 0.3, 0.6])


def test_a_minimum_on_a_bound_is_found():
    found = coordinate_search(lambda p: p[0] - p[1], (20.0, 5.0), LOW[:2], HIGH[:2])
    assert found.values == (LOW[0], HIGH[1])


def test_a_narrow_ridge_across_the_axes_stalls():
    """It stops far from the minimum, while the cost still falls along the ridge."""
    start = (LOW[0] + 0.2 * 20.0, LOW[1] + 0.2 * 3.0)
    found = coordinate_search(lambda p: ridge((*p, 1.0)), start, LOW[:2], HIGH[:2])
    u = unit((*found.values, 1.0))
    assert found.reason == "stalled"
    assert u[0] < 0.5
    downhill = (LOW[0] + 20.0 * (u[0] + 0.01), LOW[1] + 3.0 * (u[1] + 0.01))
    assert ridge((*downhill, 1.0)) < found.cost
    wide = coordinate_search(lambda p: ridge((*p, 1.0), width=1.0), start, LOW[:2], HIGH[:2])
    assert unit((*wide.values, 1.0))[:2] == pytest.approx([0.9, 0.9], abs=5e-3)


def test_the_cap_is_kept_exactly():
    for cap in (1, 2, 17):
        found = coordinate_search(bowl, (20.0, 4.5, 40.0), LOW, HIGH, cap=cap)
        assert (found.evaluations, found.reason) == (cap, "cap")


@pytest.mark.parametrize("where", ["cost", "progress"])
def test_an_interrupted_search_keeps_the_best(where: str):
    def interrupt(n: int) -> None:
        if n == 30:
            raise KeyboardInterrupt

    calls: list[float] = []

    def cost(point: tuple[float, ...]) -> float:
        if where == "cost":
            interrupt(len(calls) + 1)
        calls.append(bowl(point))
        return calls[-1]

    found = coordinate_search(
        cost, (20.0, 4.5, 40.0), LOW, HIGH,
        progress=lambda best, c, n: interrupt(n) if where == "progress" else None,
    )  # fmt: skip
    assert found.reason == "interrupted"
    assert found.cost == min(calls) == bowl(found.values)


def test_failed_runs_are_passed_over():
    def holes(point: tuple[float, ...]) -> float:
        return math.nan if 22.0 < point[0] < 24.0 else bowl(point)

    found = coordinate_search(holes, (20.0, 4.5, 40.0), LOW, HIGH)
    assert found.values[0] == pytest.approx(30.0, abs=0.05)
    nothing = coordinate_search(lambda p: math.nan, (20.0, 4.5, 40.0), LOW, HIGH)
    assert (nothing.values, nothing.cost) == ((20.0, 4.5, 40.0), math.inf)


def test_a_search_refuses_bad_bounds():
    for start, low, high in (((1.0,), (2.0,), (3.0,)), ((1.0,), (1.0,), (1.0,)), ((), (), ())):
        with pytest.raises(ParameterError):
            coordinate_search(lambda p: 0.0, start, low, high)
    for step, stop, cap in ((0.0, 0.0, 9), (0.1, 0.2, 9), (0.1, 1e-3, 0)):
        with pytest.raises(ParameterError, match="Steps"):
            coordinate_search(bowl, BEST, LOW, HIGH, step=step, stop=stop, cap=cap)


# ---------------------------------------------------------------- many starts


def test_points_fill_the_bounds_evenly():
    """Of 64 points of a Sobol' sequence every eighth of a range holds 8; of random ones not."""

    def even(points: np.ndarray) -> bool:
        eighths = (np.asarray([unit(p) for p in points]) * 8).astype(int)
        return all((np.bincount(column, minlength=8) == 8).all() for column in eighths.T)

    assert even(sobol_points(LOW, HIGH, 64))
    assert not even(np.random.default_rng(0).uniform(LOW, HIGH, (64, 3)))


def test_points_are_fixed_by_their_seed():
    first, same, other = (sobol_points(LOW, HIGH, 10, seed) for seed in (1, 1, 2))
    assert first.shape == (10, 3)
    assert np.array_equal(first, same)
    assert not np.array_equal(first, other)


def test_starts_are_the_best_and_apart():
    tried = sobol_points(LOW, HIGH, 128)
    found = multistart(two_bowls, LOW, HIGH, count=128, keep=3, apart=0.3)
    assert len(found) == 3
    assert found[0].cost == two_bowls(tried).min()
    assert [s.cost for s in found] == sorted(s.cost for s in found)
    places = [unit(s.values) for s in found]
    gaps = [np.abs(a - b).max() for i, a in enumerate(places) for b in places[:i]]
    assert min(gaps) >= 0.3
    near = multistart(two_bowls, LOW, HIGH, count=128, keep=3, apart=0.0)
    assert near[2].cost < found[2].cost
    assert len(multistart(two_bowls, LOW, HIGH, keep=9, apart=1.0)) == 1


def test_failed_points_are_no_starts():
    def half(points: np.ndarray) -> np.ndarray:
        return np.where(points[:, 0] < 25.0, math.nan, two_bowls(points))

    found = multistart(half, LOW, HIGH, keep=5, apart=0.1)
    assert all(start.values[0] >= 25.0 for start in found)
    for search in (multistart, evolve):
        with pytest.raises(SolveError, match="narrow the bounds"):
            search(lambda points: np.full(len(points), math.inf), LOW, HIGH)


def test_evolution_finds_the_narrow_minimum_that_a_local_search_misses():
    found = [evolve(two_bowls, LOW, HIGH, population=16, seed=seed) for seed in range(5)]
    for one in found:
        assert unit(one.values) == pytest.approx([0.85] * 3, abs=0.05)
    start = tuple(LOW[k] + 0.2 * (HIGH[k] - LOW[k]) for k in range(3))
    local = coordinate_search(lambda p: float(two_bowls(np.asarray([p]))[0]), start, LOW, HIGH)
    assert unit(local.values) == pytest.approx([0.3] * 3, abs=5e-3)
    assert max(one.cost for one in found) < 0.1 * local.cost


def test_evolution_is_fixed_by_its_seed_and_keeps_the_best_when_interrupted():
    first, same, other = (evolve(two_bowls, LOW, HIGH, generations=3, seed=s) for s in (1, 1, 2))
    assert first == same
    assert first.values != other.values
    assert first.evaluations == 4 * 24
    assert first.cost == first.history[-1][1] == two_bowls(np.asarray([first.values]))[0]

    def stop(best: tuple[float, ...], cost: float, count: int) -> None:
        if count > 40:
            raise KeyboardInterrupt

    cut = evolve(two_bowls, LOW, HIGH, seed=1, progress=stop)
    assert cut.interrupted
    assert cut.evaluations == 48
    assert not first.interrupted


def test_bad_bounds_are_refused():
    for low, high in (((1.0,), (0.0,)), ((0.0,), (math.inf,)), ((), ()), ((0.0,), (1.0, 2.0))):
        with pytest.raises(ParameterError, match="ounds"):
            sobol_points(low, high)
    with pytest.raises(ParameterError, match="count"):
        sobol_points(LOW, HIGH, 0)
