"""What every measure promises: one number per run, whatever runs are beside it, with its slopes."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from martensite.base import units
from martensite.base.errors import MartensiteError, UnitError
from martensite.simulate.measures.base import AbstractMeasure
from martensite.testing.conformance import require_condition
from martensite.testing.examples import build_plant

RUNS = 7
TIMES = np.cumsum(np.append(0.0, np.random.default_rng(1).uniform(0.05, 0.2, 40)))
"""Of the samples [s]."""
Array = NDArray[np.float64]


def make_samples(columns: int = 2) -> Array:
    """Smooth ways out and back, with ripples; (columns, samples, runs)."""
    rng = np.random.default_rng(2)
    out = np.sin(np.pi * TIMES / TIMES[-1]) ** 2
    ripple = 0.02 * rng.standard_normal((columns, len(TIMES), RUNS))
    return out[None, :, None] * rng.uniform(0.5, 2.0, (columns, 1, RUNS)) + ripple


def find_differences(measure: AbstractMeasure, samples: Array) -> Array:
    """Central differences by every sample."""
    found = np.zeros(samples.shape)
    for place in np.ndindex(samples.shape[:2]):
        step = np.zeros(samples.shape)
        step[place] = 1e-6
        up, down = measure.value(TIMES, samples + step), measure.value(TIMES, samples - step)
        found[place] = (up - down) / 2e-6
    return found


def check_unit(measure: AbstractMeasure) -> None:
    """Its number has a unit, whatever the unit of the output."""
    for unit in ("m", "W", "Pa", "1"):
        try:
            units.require_unit(measure.unit(unit))
        except UnitError as error:
            require_condition(False, f"Of an output in `{unit}`: {error}")


def check_runs(measure: AbstractMeasure) -> None:
    """It is one number per run, the same whatever runs are beside it, broken ones too."""
    samples = make_samples()
    together = measure.value(TIMES, samples)
    require_condition(together.shape == (RUNS,), f"Of {RUNS} runs it gives numbers of shape {together.shape}.")
    order = np.array([3, 0, 6, 2, 5, 1, 4])
    broken = samples.copy()
    broken[:, :, 2] = np.nan
    with np.errstate(all="ignore"):
        found, others = measure.value(TIMES, broken), np.arange(RUNS) != 2
    alone = [measure.value(TIMES, samples[:, :, k : k + 1])[0] for k in range(RUNS)]
    same = (
        np.array_equal(alone, together)
        and np.array_equal(measure.value(TIMES, samples[:, :, order]), together[order])
        and np.array_equal(found[others], together[others])
    )
    require_condition(same, "The number of a run depends on the runs beside it.")


def check_weights(measure: AbstractMeasure) -> None:
    """Its weights are its derivatives by every sample."""
    samples = make_samples()
    weights = measure.weights(TIMES, samples)
    require_condition(weights.shape == samples.shape, f"Its weights have the shape {weights.shape}.")
    require_condition(np.abs(weights).max() > 0.0, "It depends on no sample.")
    meant = find_differences(measure, samples)
    near = np.allclose(weights, meant, rtol=1e-6, atol=1e-8)
    apart = np.abs(weights - meant).max()
    require_condition(near, f"A weight is {apart:.3g} away from the difference.")


def check_still_weights(measure: AbstractMeasure) -> None:
    """The weights of a run in which nothing happens are finite."""
    still = measure.weights(TIMES, np.zeros((1, len(TIMES), 2)))
    require_condition(np.isfinite(still).all(), "A weight of a run that stays at 0 is not finite.")


def check_unknown_output(measure: AbstractMeasure) -> None:
    """An output that is not there is refused, with the nearest."""
    try:
        measure.with_parts(of="powr").columns(build_plant())
    except MartensiteError as error:
        said = "Did you mean `power`" in str(error)
    else:
        said = False
    require_condition(said, "It takes the output `powr`, which is not there.")
