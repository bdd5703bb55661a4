"""What every design of a sweep keeps to: any part of it is that part of the whole.

Sources of truth: the definitions; a Latin hypercube meets every stratum once, a Sobol' sequence of
2^k points every dyadic interval of length 2^-k once (Sobol' 1967, a property of (t, m, s)-nets),
and quantiles of a normal distribution by the standard library.
"""

from __future__ import annotations

from statistics import NormalDist

import numpy as np
import pytest
from scipy.stats import qmc

from martensite.base.errors import InputError
from martensite.design.sweep.axes import parse_axis
from martensite.design.sweep.sampling.samples import DESIGNS, AbstractSample, parse_sampling
from martensite.search.free_numbers import FreeNumber, Target

COUNT = 60
TARGETS = {
    name: Target(name, name, unit, nominal)
    for name, unit, nominal in (("length", "m", 0.25), ("h", "W/m^2/K", 50.0), ("A_s", "K", 340.0))
}
RANGES = [
    parse_axis(words, TARGETS) for words in ("length=0.1..0.5 m:5", "h=10..1000 W/m^2/K:4 log", "A_s=60, 70, 90 degC")
]
SIZES = {"saltelli": COUNT * (len(RANGES) + 2)}
"""Of designs that make several runs of a point."""
SAMPLES = [n for n in DESIGNS.names() if issubclass(DESIGNS[n], AbstractSample)]


def words(name: str) -> str:
    return f"{name}:{COUNT}" if name in SAMPLES else name


def every(name: str, axes: list[FreeNumber] = RANGES, seed: int = 3) -> np.ndarray:
    found = parse_sampling(words(name), seed)
    return found.values(axes, 0, found.size(axes))


@pytest.mark.parametrize("name", DESIGNS.names())
class TestDesigns:
    def test_it_has_as_many_runs_as_it_says(self, name: str) -> None:
        size = SIZES.get(name, COUNT)
        assert parse_sampling(words(name)).size(RANGES) == size
        assert every(name).shape == (size, len(RANGES))

    @pytest.mark.parametrize(("first", "count"), [(0, 7), (7, 1), (13, 47), (59, 1)])
    def test_any_stretch_is_that_of_the_whole(self, name: str, first: int, count: int) -> None:
        part = parse_sampling(words(name), 3).values(RANGES, first, count)
        assert np.array_equal(part, every(name)[first : first + count])

    def test_the_seed_decides(self, name: str) -> None:
        assert np.array_equal(every(name), every(name))
        assert np.array_equal(every(name, seed=4), every(name)) is (name not in SAMPLES)

    def test_a_seed_is_no_negative_number(self, name: str) -> None:
        with pytest.raises(InputError, match="seed"):
            parse_sampling(words(name), -1)

    def test_numbers_are_within_the_axes(self, name: str) -> None:
        for one, column in zip(RANGES, every(name).T, strict=True):
            ends = one.extremes()
            assert min(ends) <= column.min()
            assert column.max() <= max(ends)


@pytest.mark.parametrize(("parts", "wound"), [(1, 0), (4, 3 * 1024)])
def test_a_late_chunk_of_a_sequence_costs_no_more_than_an_early_one(
    monkeypatch: pytest.MonkeyPatch, parts: int, wound: int
) -> None:
    """Whoever makes all chunks, or every fourth, passes each point once."""
    forward, steps = qmc.Sobol.fast_forward, list[int]()
    monkeypatch.setattr(qmc.Sobol, "fast_forward", lambda one, n: steps.append(n) or forward(one, n))
    for first in range((parts - 1) * 64, 4096, parts * 64):
        parse_sampling("sobol:4096", 11 + parts).values(RANGES, first, 64)
    assert sum(steps) == wound


@pytest.mark.parametrize("name", SAMPLES)
class TestSamples:
    def test_medians_are_those_of_the_axes(self, name: str) -> None:
        axes = [*RANGES[:2], parse_axis("length=250 mm +- 10 mm", TARGETS)]
        middle = np.median(parse_sampling(f"{name}:4096", 1).values(axes, 0, 4096), axis=0)
        assert middle == pytest.approx([0.3, 100.0, 0.25], rel=0.1)

    def test_points_are_inside_of_the_cube(self, name: str) -> None:
        cube = parse_sampling(words(name), 0).cube(3, 0, COUNT)  # type: ignore[attr-defined]
        assert (cube > 0.0).all()
        assert (cube < 1.0).all()

    @pytest.mark.parametrize("wrong", ["", ":0", ":x", ":-3"])
    def test_it_needs_a_number(self, name: str, wrong: str) -> None:
        with pytest.raises(InputError, match="1024"):
            parse_sampling(name + wrong)


@pytest.mark.parametrize("name", ["latin-hypercube", "sobol"])
def test_every_stratum_is_met_once(name: str) -> None:
    cube = parse_sampling(f"{name}:64", 5).cube(3, 0, 64)  # type: ignore[attr-defined]
    strata = np.sort((64 * cube).astype(int), axis=0)
    assert np.array_equal(strata, np.repeat(np.arange(64)[:, None], 3, axis=1))


def test_strata_that_are_met_twice_are_noticed() -> None:
    cube = parse_sampling("monte-carlo:64", 5).cube(3, 0, 64)  # type: ignore[attr-defined]
    strata = np.sort((64 * cube).astype(int), axis=0)
    assert not np.array_equal(strata, np.repeat(np.arange(64)[:, None], 3, axis=1))


def test_a_grid_is_every_combination_and_the_last_axis_is_fastest() -> None:
    levels = [one.levels().tolist() for one in RANGES]
    combined = [(a, b, c) for a in levels[0] for b in levels[1] for c in levels[2]]
    assert list(map(tuple, every("grid").tolist())) == combined


def test_quantiles_are_those_of_the_distribution() -> None:
    shares = np.array([0.01, 0.25, 0.5, 0.9])
    normal = parse_axis("length=+- 4 %", TARGETS)
    known = NormalDist(0.25, 0.01)
    assert normal.quantile(shares) == pytest.approx([known.inv_cdf(s) for s in shares], rel=1e-12)
    assert RANGES[0].quantile(shares) == pytest.approx(0.1 + 0.4 * shares, rel=1e-12)
    assert RANGES[1].quantile(shares) == pytest.approx(10.0 * 100.0**shares, rel=1e-12)
    thirds = RANGES[2].quantile(np.array([0.3, 0.34, 0.66, 0.67]))
    assert thirds == pytest.approx([333.15, 343.15, 343.15, 363.15])


@pytest.mark.parametrize(
    ("name", "sentence"),
    [("sobl:64", "Did you mean `sobol`"), ("grid:64", "levels"), ("latin-hypercube:30000000", "s")],
)
def test_wrong_words_are_refused(name: str, sentence: str) -> None:
    with pytest.raises(InputError, match=sentence):
        parse_sampling(name)


def test_a_grid_needs_levels_and_must_not_be_endless() -> None:
    with pytest.raises(InputError, match=r"no levels.*:9"):
        parse_sampling("grid").size([parse_axis("length=0.1..0.5 m", TARGETS)])
    with pytest.raises(InputError, match="at most"):
        parse_sampling("grid").size([parse_axis("length=0.1..0.5 m:100000", TARGETS)] * 2)
