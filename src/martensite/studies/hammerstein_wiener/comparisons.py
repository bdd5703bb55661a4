"""Scores of models on records of the bench, for heating and cooling, in free simulation."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from statistics import median

import numpy as np

from martensite.control.sensors.base import Numbers
from martensite.identify.chains.chain import Chain
from martensite.identify.chains.scores import fit_percent
from martensite.signals.sampling.sampled import Sampled
from martensite.studies.hammerstein_wiener import models, records
from martensite.studies.hammerstein_wiener.bench import ReferenceBench, RunningBench
from martensite.studies.result_cache import cache_results

SMOOTH = 500
"""Samples over which the trend of a duty cycle is determined."""


@dataclass(frozen=True)
class RecordScore:
    """Score of one output on one record."""

    fit: float
    """NRMSE fit [%]."""
    heating: float
    """NRMSE fit of the heating and of the cooling samples [%]."""
    cooling: float
    worst_heating: float
    """Largest error on heating, in the unit of the output."""
    worst_cooling: float

    @property
    def worst(self) -> float:
        """Return the largest error."""
        return max(self.worst_heating, self.worst_cooling)


def compare_model(model: Chain, whole: Sampled, name: str) -> RecordScore:
    """Return the score of the last output of a model on a record."""
    signals = models.mapped_signals(name, whole)
    computed = model.simulate(signals)[:, -1]
    return score_record(signals.outputs[:, -1], computed, heating_rows(whole.inputs[:, 0]))


def score_record(measured: Numbers, computed: Numbers, hot: Numbers) -> RecordScore:
    """Return the fits and largest errors, where it heats (`hot`) and where it cools."""
    parts = (slice(None), hot, ~hot)
    whole, warm, cold = (nrmse_fit(measured[part], computed[part]) for part in parts)
    away = np.abs(measured - computed)
    return RecordScore(whole, warm, cold, float(away[hot].max()), float(away[~hot].max()))


def nrmse_fit(measured: Numbers, computed: Numbers) -> float:
    """Return the NRMSE fit of one signal [%]."""
    return float(fit_percent(measured[:, None], computed[:, None])[0])


def heating_rows(duty: Numbers) -> Numbers:
    """Return the rows at which pulses are on, or ramps rise."""
    if np.mean(duty == 0.0) > 0.3:
        return duty > 0.0
    ahead = np.roll(duty, -SMOOTH)
    ahead[-SMOOTH:] = duty[-1]
    return ahead >= duty


@cache
def compare_position(model: str, record: str) -> RecordScore:
    """Return the position score of a model on a record of the study."""
    return compare_model(models.estimate_recipe(model), models.read_record(record), model)


@cache
def in_series(second: str, record: str) -> RecordScore:
    """Return the position score of stage 1 and a second stage, from the duty cycle."""
    return compare_model(models.join_stages(second), models.read_record(record), "series")


@cache
def score_sealed(model: str, seeds: tuple[int, ...]) -> tuple[float, float]:
    """Return the median and smallest fit [%] on sealed records."""
    fits = [compare_position(model, f"sealed {seed}").fit for seed in seeds]
    return median(fits), min(fits)


VARIANTS = {
    "fan": ReferenceBench(fan=1.5),
    "5 K warmer": ReferenceBench(ambient=301.15),
    "5 K colder": ReferenceBench(ambient=291.15),
    "load +20 %": ReferenceBench(load=1.2),
    "load -20 %": ReferenceBench(load=0.8),
    "crimps": ReferenceBench(cells=4.0),
}
"""Benches that no model was fitted to."""


@cache_results
def other_bench_record(variant: str) -> Sampled:
    """Return the validation record of another bench; with a fan, at more power."""
    bench = VARIANTS[variant]
    return records.record_bench(records.validation_duty().scaled(bench.fan), bench)


@cache
def compare_elsewhere(model: str, variant: str) -> RecordScore:
    """Return the position score of a model on another bench."""
    return compare_model(models.estimate_recipe(model), other_bench_record(variant), model)


@cache
def rest_position(model: str) -> float:
    """Return the largest position of a model in a minute without power, from the steady state [m]."""
    ambient = RunningBench(ReferenceBench()).temperature
    signal = 0.0 if model in ("whole", "stage 1") or model.startswith("series") else ambient
    one = (
        models.join_stages(model.removeprefix("series "))
        if model.startswith("series")
        else (models.estimate_recipe(model))
    )
    still = np.full((30_000, 1), signal)
    return float(np.abs(one.simulate(still)[:, -1]).max())
