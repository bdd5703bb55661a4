"""The models of the study, all estimated on one record of the bench.

The paper does not print the degree of the polynomial and the delay; 2 and one sample are assumed. Searches use records
decimated to 50 Hz; their results are refined and scored at 500 Hz.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cache

from martensite.identify.chains.chain import Chain
from martensite.identify.chains.estimate import Options, estimate_chain, refine_chain
from martensite.signals.sampling.sampled import Sampled
from martensite.studies.hammerstein_wiener import records
from martensite.studies.result_cache import cache_results

FIRST = "poly2 | oe(3,3,1) | pwl10"
SECOND = "wavelet88 | oe(3,3,1) | sigmoid10"
SMALL = "wavelet12 | oe(3,3,1) | sigmoid10"
HYSTERESIS = "oe(2,2,0) | pi12 | sigmoid10 | oe(1,1,1)"
WHOLE = "heated"
THIN = 10
"""Decimation factor of searches."""
ANCHOR = 0.14
"""Weight of the steady state: 40 s at rest in a record of 283.5 s."""
RESTLESS, AFTER = "stage 2, not anchored", 22.0
"""A model of the record after this time [s], when the wire is warm throughout."""


@dataclass(frozen=True)
class Recipe:
    """Recipe of the search for a model."""

    text: str
    options: Options
    polish: int = 0
    """Maximum number of steps at the full rate."""


RECIPES = {
    "stage 1": Recipe(FIRST, Options(starts=12, anchor=ANCHOR, iterations=80), 20),
    "stage 2": Recipe(SECOND, Options(starts=2, refined=1, anchor=ANCHOR, ridge=1e-6, iterations=30), 3),
    "stage 2, 12 wavelets": Recipe(SMALL, Options(starts=4, refined=1, anchor=ANCHOR, ridge=1e-6, iterations=50), 6),
    "stage 2, not anchored": Recipe(SMALL, Options(starts=2, refined=1, iterations=50, start="estimate"), 0),
    "stage 2, hysteresis": Recipe(
        HYSTERESIS, Options(starts=8, refined=3, anchor=ANCHOR, ridge=1e-7, iterations=80), 20
    ),
    "whole": Recipe(WHOLE, Options(starts=1, sigma=(1.0, 1e-4), iterations=40), 0),
}


@cache_results
def read_record(name: str) -> Sampled:
    """Return a record of the reference bench: estimation, validation, slow, or sealed with a seed."""
    kind, _, seed = name.partition(" ")
    if kind == "sealed":
        return records.record_bench(records.sealed_duty(int(seed)))
    makers = {"estimation": records.estimation_duty, "validation": records.validation_duty, "slow": records.slow_duty}
    return records.record_bench(makers[kind]())


def mapped_signals(model: str, whole: Sampled) -> Sampled:
    """Return the signals of a model: of one stage, or from duty cycle to outputs."""
    if model in ("whole", "series"):
        return whole
    return records.split_stages(whole)[1 if model.startswith("stage 2") else 0]


@cache_results
def estimate_recipe(name: str) -> Chain:
    """Return a model estimated by its recipe."""
    recipe, full = RECIPES[name], mapped_signals(name, read_record("estimation"))
    if name == RESTLESS:
        full = full.rows(round(AFTER / full.interval))
    thin = replace(full, interval=THIN * full.interval, inputs=full.inputs[::THIN], outputs=full.outputs[::THIN])
    chain = replace(estimate_chain(recipe.text, thin, recipe.options).chain, interval=full.interval)
    if recipe.polish:
        polished = refine_chain(chain, [full], replace(recipe.options, iterations=recipe.polish))
        chain = chain.with_theta(polished.theta[: len(chain.theta)])
    return replace(chain, name=name)


@cache
def join_stages(second: str) -> Chain:
    """Return stage 1 and a second stage, from duty cycle to position."""
    return estimate_recipe("stage 1").then(estimate_recipe(second))
