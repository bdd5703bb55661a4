"""Searches without derivatives find what they can, and say where they stop.

Sources of truth: minima known in closed form; a ridge across the axes, on which a coordinate
search must stall, since along no axis is there an improvement of its step.
"""

import math
from collections.abc import Sequence

import numpy as np
import pytest

from martensite.base.errors import ParameterError, SolveError
from martensite.search.coordinate_search import search_coordinates
from martensite.search.starts import draw_points, evolve_start, find_starts

BEGIN, BEST = (0.25, 1.0 / 6.0, 0.8), (0.75, 0.4, 0.21)


def bowl(point: Sequence[float]) -> float:
    return float(np.sum((np.asarray(point) - BEST) ** 2))


def ridge(point: Sequence[float], width: float = 1e-3) -> float:
    """A valley along the diagonal of two parameters, falling gently towards its end."""
    u = point
    return float(((u[0] - u[1]) / width) ** 2 + (u[0] + u[1] - 1.8) ** 2)


def two_bowls(points: np.ndarray) -> np.ndarray:
    """The deeper of two minima is narrow."""
    u = points
    wide = 0.4 + np.sum((u - 0.3) ** 2, axis=1)
    narrow = 6.0 * np.sum((u - 0.85) ** 2, axis=1)
    return np.minimum(wide, narrow)


# ---------------------------------------------------------------- coordinate search


def test_a_bowl_is_found_to_the_last_step():
    found, reason = search_coordinates(bowl, BEGIN)
    assert reason == "stalled"
    assert np.abs(np.asarray(found.best) - BEST).max() <= 1e-3
    assert found.step < 1e-3
    assert found.evaluations < 200
    assert found.cost == bowl(found.best)


def test_every_evaluation_counts_and_lies_in_the_box():
    seen: list[tuple[float, ...]] = []

    def counted(point: tuple[float, ...]) -> float:
        seen.append(point)
        return bowl(point)

    found, _ = search_coordinates(counted, BEGIN)
    assert len(seen) == found.evaluations
    assert (np.asarray(seen) >= 0.0).all()
    assert (np.asarray(seen) <= 1.0).all()
    assert found.cost == min(map(bowl, seen))


def test_the_steps_are_a_tenth_then_twice_or_half():
    """By hand, in one parameter from 0 to 1 with the minimum at 0.6 and the start at 0.2."""
    seen: list[float] = []

    def line(point: tuple[float, ...]) -> float:
        seen.append(point[0])
        return abs(point[0] - 0.6)

    search_coordinates(line, (0.2,), limit=8)
    # 0.1 up; 0.2 up; 0.4 up and down, neither better; halved to 0.2, then to 0.1
    assert seen == pytest.approx([0.2, 0.3, 0.5, 0.9, 0.1, 0.7, 0.3, 0.6])


def test_a_minimum_on_a_bound_is_found():
    found, _ = search_coordinates(lambda p: p[0] - p[1], BEGIN[:2])
    assert found.best == (0.0, 1.0)


def test_a_narrow_ridge_across_the_axes_stalls():
    """It stops far from the minimum, while the cost still falls along the ridge."""
    found, reason = search_coordinates(lambda p: ridge((*p, 1.0)), (0.2, 0.2))
    u = found.best
    assert reason == "stalled"
    assert u[0] < 0.5
    assert ridge((u[0] + 0.01, u[1] + 0.01, 1.0)) < found.cost
    wide, _ = search_coordinates(lambda p: ridge((*p, 1.0), width=1.0), (0.2, 0.2))
    assert wide.best == pytest.approx((0.9, 0.9), abs=5e-3)


def test_the_cap_is_kept_exactly():
    for cap in (1, 2, 17):
        found, reason = search_coordinates(bowl, BEGIN, limit=cap)
        assert (found.evaluations, reason) == (cap, "cap")


def test_failed_runs_are_passed_over():
    def holes(point: tuple[float, ...]) -> float:
        return math.nan if 0.35 < point[0] < 0.45 else bowl(point)

    found, _ = search_coordinates(holes, BEGIN)
    assert found.best[0] == pytest.approx(BEST[0], abs=2.5e-3)
    nothing, _ = search_coordinates(lambda p: math.nan, BEGIN)
    assert (nothing.best, nothing.cost) == (BEGIN, math.inf)


def test_a_search_refuses_starts_and_steps_that_are_none():
    for start in ((1.1,), (-0.1, 0.5), ()):
        with pytest.raises(ParameterError, match="within its bounds"):
            search_coordinates(lambda p: 0.0, start)
    for step, stop, limit in ((0.0, 0.0, 9), (0.1, 0.2, 9), (0.1, 1e-3, 0)):
        with pytest.raises(ParameterError, match="Steps"):
            search_coordinates(bowl, BEST, step=step, stop=stop, limit=limit)


# ---------------------------------------------------------------- many starts


def test_points_fill_the_bounds_evenly():
    """Of 64 points of a Sobol' sequence every eighth of a range holds 8; of random ones not."""

    def even(points: np.ndarray) -> bool:
        eighths = (points * 8).astype(int)
        return all((np.bincount(column, minlength=8) == 8).all() for column in eighths.T)

    assert even(draw_points(3, 64))
    assert not even(np.random.default_rng(0).uniform(0.0, 1.0, (64, 3)))


def test_points_are_fixed_by_their_seed():
    first, same, other = (draw_points(3, 10, seed) for seed in (1, 1, 2))
    assert first.shape == (10, 3)
    assert np.array_equal(first, same)
    assert not np.array_equal(first, other)


def test_starts_are_the_best_and_apart():
    tried = draw_points(3, 128)
    found = find_starts(two_bowls, 3, count=128, keep=3, apart=0.3)
    assert len(found) == 3
    assert found[0].cost == two_bowls(tried).min()
    assert [s.cost for s in found] == sorted(s.cost for s in found)
    places = [np.asarray(s.values) for s in found]
    gaps = [np.linalg.norm(a - b) / math.sqrt(3.0) for i, a in enumerate(places) for b in places[:i]]
    assert min(gaps) >= 0.3
    near = find_starts(two_bowls, 3, count=128, keep=3, apart=0.0)
    assert near[2].cost < found[2].cost
    assert len(find_starts(two_bowls, 3, keep=9, apart=1.0)) == 1


def test_failed_points_are_no_starts():
    def half(points: np.ndarray) -> np.ndarray:
        return np.where(points[:, 0] < 0.5, math.nan, two_bowls(points))

    found = find_starts(half, 3, keep=5, apart=0.1)
    assert all(start.values[0] >= 0.5 for start in found)
    for search in (find_starts, evolve_start):
        with pytest.raises(SolveError, match="narrow the bounds"):
            search(lambda points: np.full(len(points), math.inf), 3)


def test_evolution_finds_the_narrow_minimum_that_a_local_search_misses():
    found = [evolve_start(two_bowls, 3, population=16, seed=seed) for seed in range(5)]
    for one in found:
        assert one.values == pytest.approx([0.85] * 3, abs=0.05)
    local, _ = search_coordinates(lambda p: float(two_bowls(np.asarray([p]))[0]), (0.2,) * 3)
    assert local.best == pytest.approx([0.3] * 3, abs=5e-3)
    assert max(one.cost for one in found) < 0.1 * local.cost


def test_evolution_is_fixed_by_its_seed():
    first, same, other = (evolve_start(two_bowls, 3, generations=3, seed=s) for s in (1, 1, 2))
    assert first == same
    assert first.values != other.values
    assert first.cost == two_bowls(np.asarray([first.values]))[0]


def test_no_points_are_refused():
    with pytest.raises(ParameterError, match="count"):
        draw_points(3, 0)
