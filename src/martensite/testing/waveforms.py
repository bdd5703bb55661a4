"""Suite for waveforms, edges and means, and for measures: one value per run, with its derivatives."""

from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from martensite.base import units
from martensite.base.errors import MartensiteError, UnitError
from martensite.signals.base import AbstractWaveform
from martensite.simulate.measures.base import AbstractMeasure
from martensite.simulate.measures.run_table import tabulate_samples
from martensite.testing.conformance import require_condition
from martensite.testing.examples import build_plant

DURATION = 6.0
"""Duration of the tested signals [s]."""
CUTS = 60
"""Number of intervals whose mean is compared."""


def check_levels(wave: AbstractWaveform) -> None:
    """Levels are finite, and stay between `low` and `high` where these are declared."""
    levels = [wave.value(t) for t in np.linspace(0.0, 2.0 * DURATION, 6001).tolist()]
    require_condition(np.isfinite(levels).all(), "A level is not finite.")
    if {"low", "high"} <= set(wave.declarations):
        inside = wave.low <= min(levels) and max(levels) <= wave.high  # type: ignore[attr-defined]
        require_condition(inside, f"Levels go from {min(levels):g} to {max(levels):g}, beyond `low`, `high`.")


def check_edges(wave: AbstractWaveform) -> None:
    """Edges ascend, and lie within the requested duration."""
    edges = wave.edges(DURATION)
    require_condition(edges == sorted(set(edges)), "The edges do not ascend.")
    inside = all(0.0 < t < DURATION for t in edges)
    require_condition(inside, f"An edge is not between 0 and {DURATION} s, the duration that is asked for.")


def check_kinks(wave: AbstractWaveform) -> None:
    """Every jump and bend is an edge: between edges second differences shrink with the step."""
    for a, b in pairwise([0.0, *wave.edges(DURATION), DURATION]):
        inner = np.linspace(a, b, 403)[1:-1]
        levels = np.array([wave.value(t) for t in inner.tolist()])
        fine = np.abs(np.diff(levels, 2))
        coarse = np.abs(np.diff(levels[::2], 2)).max()
        require_condition(
            fine.max() <= 0.3 * coarse + 1e-12 * (1.0 + np.abs(levels).max()),
            f"There is a jump or bend near {inner[int(np.argmax(fine))]:.4g} s that is no edge.",
        )


def check_right_limits(wave: AbstractWaveform) -> None:
    """The value at an edge is the value after it."""
    for edge in wave.edges(DURATION):
        at, after = wave.value(edge), wave.value(edge + 1e-9)
        require_condition(
            abs(at - after) <= 1e-6 * (1.0 + abs(after)),
            f"At its edge at {edge:.6g} s the value is {at:g}, just after it {after:g}.",
        )


def check_means(wave: AbstractWaveform) -> None:
    """Between edges, mean and mean square are those of the values."""
    nodes, weights = np.polynomial.legendre.leggauss(24)
    for a, b in list(pairwise([0.0, *wave.edges(DURATION), DURATION]))[:CUTS]:
        pieces = np.linspace(a, b, 9)
        half = 0.5 * (b - a) / 8.0
        middles = 0.5 * (pieces[1:] + pieces[:-1])
        times = (middles[:, None] + half * nodes).ravel()
        levels = np.array([wave.value(t) for t in times.tolist()]).reshape(8, -1)
        moments = wave.moments(a, b)
        size = np.abs(levels).max()
        mean, square = ((x * weights).sum() / 16.0 for x in (levels, levels * levels))
        equal = abs(moments.mean - mean) <= 1e-6 * size and abs(moments.square - square) <= (1e-6 * size * size)
        require_condition(equal, f"Between {a:.4g} and {b:.4g} s `moments` are not those of the values.")


RUNS = 7
TIMES = np.cumsum(np.append(0.0, np.random.default_rng(1).uniform(0.05, 0.2, 40)))
"""Times of the samples [s]."""
Array = NDArray[np.float64]


def make_samples(columns: int = 2) -> Array:
    """Return smooth round trips with ripples, shape (columns, samples, runs)."""
    rng = np.random.default_rng(2)
    out = np.sin(np.pi * TIMES / TIMES[-1]) ** 2
    ripple = 0.02 * rng.standard_normal((columns, len(TIMES), RUNS))
    return out[None, :, None] * rng.uniform(0.5, 2.0, (columns, 1, RUNS)) + ripple


def _value(measure: AbstractMeasure, samples: Array) -> Array:
    return measure.value(tabulate_samples(TIMES, samples))


def find_differences(measure: AbstractMeasure, samples: Array) -> Array:
    """Return central differences by each sample."""
    differences = np.zeros(samples.shape)
    for place in np.ndindex(samples.shape[:2]):
        step = np.zeros(samples.shape)
        step[place] = 1e-6
        up, down = _value(measure, samples + step), _value(measure, samples - step)
        differences[place] = (up - down) / 2e-6
    return differences


def check_unit(measure: AbstractMeasure) -> None:
    """Its value has a unit, for any unit of the output."""
    for unit in ("m", "W", "Pa", "1"):
        try:
            units.require_unit(measure.unit(unit))
        except UnitError as error:
            require_condition(False, f"Of an output in `{unit}`: {error}")


def check_runs(measure: AbstractMeasure) -> None:
    """A measure of one run does not depend on the other runs, even broken ones."""
    samples = make_samples()
    together = _value(measure, samples)
    require_condition(together.shape == (RUNS,), f"Of {RUNS} runs it gives numbers of shape {together.shape}.")
    order = np.array([3, 0, 6, 2, 5, 1, 4])
    broken = samples.copy()
    broken[:, :, 2] = np.nan
    with np.errstate(all="ignore"):
        with_broken, others = _value(measure, broken), np.arange(RUNS) != 2
    alone = [_value(measure, samples[:, :, k : k + 1])[0] for k in range(RUNS)]
    same = (
        np.array_equal(alone, together)
        and np.array_equal(_value(measure, samples[:, :, order]), together[order])
        and np.array_equal(with_broken[others], together[others])
    )
    require_condition(same, "The number of a run depends on the runs beside it.")


def check_weights(measure: AbstractMeasure) -> None:
    """Its weights are its derivatives by each sample."""
    samples = make_samples()
    weights = measure.derivatives(tabulate_samples(TIMES, samples))
    require_condition(weights.shape == samples.shape, f"Its weights have the shape {weights.shape}.")
    require_condition(np.abs(weights).max() > 0.0, "It depends on no sample.")
    differences = find_differences(measure, samples)
    equal = np.allclose(weights, differences, rtol=1e-6, atol=1e-8)
    apart = np.abs(weights - differences).max()
    require_condition(equal, f"A weight is {apart:.3g} away from the difference.")


def check_still_weights(measure: AbstractMeasure) -> None:
    """The weights of a constant run are finite."""
    still = measure.derivatives(tabulate_samples(TIMES, np.zeros((1, len(TIMES), 2))))
    require_condition(np.isfinite(still).all(), "A weight of a run that stays at 0 is not finite.")


def check_unknown_output(measure: AbstractMeasure) -> None:
    """An unknown output is refused with the nearest name."""
    try:
        measure.with_parts(of="powr").columns(build_plant())
    except MartensiteError as error:
        suggested = "Did you mean `power`" in str(error)
    else:
        suggested = False
    require_condition(suggested, "It takes the output `powr`, which is not there.")
