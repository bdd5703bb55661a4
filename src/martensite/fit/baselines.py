"""Predictions without a model, of what a fit keeps back: a model that does not beat them explains nothing.

    mean of training    the mean of what was fitted, of the same record where it has fitted rows
    last cycle          of a periodic record: what was fitted in the cycle before
    linear scaling      from the nearest record, or condition, in proportion to what drives

Temperatures and times are not scaled but taken over from the nearest.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from martensite.fit.condition_runs import ConditionExperiment
from martensite.fit.experiment import Experiment
from martensite.fit.fit import Fit
from martensite.fit.problem import Problem
from martensite.simulate.drive_waveforms import arrange_waveforms

MEAN, CYCLE, SCALING = "mean of training", "last cycle", "linear scaling"
CYCLES = 2.0
"""Periods from which on a record is periodic."""
TURNED = 0.1
"""How far the period is looked for about its mean, as a share."""


@dataclass(frozen=True)
class BaselineScore:
    """Error of a prediction without a model in what was kept back of one output of one record."""

    record: str
    output: str
    name: str
    """`mean of training`, `last cycle`, or `linear scaling`."""
    unit: str
    """SI unit of the output."""
    rms: float
    """[unit]"""
    samples: int

    def to_dict(self) -> dict[str, Any]:
        """All fields by name, for JSON."""
        return asdict(self)


def score_baselines(found: Fit | Problem) -> list[BaselineScore]:
    """Errors of all baselines in what is kept back, by record and output.

    Of a fit whose records were left out in turn, each is predicted from all others.
    """
    if isinstance(found, Problem):
        return list(_score_all(found.experiments, found.experiments))
    fitted = found.problem.experiments
    scores = list(_score_all(fitted, (*fitted, *(kept.experiment for kept in found.kept))))
    for kept in found.transfer:
        mine = kept.experiment.groups or {"": kept.experiment.name}
        others = [x for x in fitted if (x.groups or {"": x.name}) != mine]
        scores += _score_all(others, [kept.experiment])
    return scores


def pool_baselines(scores: Sequence[BaselineScore], output: str) -> dict[str, float]:
    """Root-mean-square error of every baseline of an output, over all records [unit]."""
    found: dict[str, float] = {}
    for name in dict.fromkeys(one.name for one in scores if one.output == output):
        own = [one for one in scores if (one.output, one.name) == (output, name)]
        found[name] = math.sqrt(sum(one.rms**2 * one.samples for one in own) / sum(one.samples for one in own))
    return found


def _score_all(fitted: Sequence[Experiment], targets: Sequence[Experiment]) -> Iterator[BaselineScore]:
    seen = [one for one in fitted if not one.held_out]
    for one in targets:
        for k, output in enumerate(one.outputs):
            measured = one.measured[:, k]
            held = np.isfinite(measured) & one.kept_back
            if held.any():
                unit, count = one.describe_outputs()[output].unit, int(held.sum())
                for name, guess in _predict_output(seen, one, k, unit).items():
                    rms = float(np.sqrt(np.mean((guess[held] - measured[held]) ** 2)))
                    yield BaselineScore(one.name, output, name, unit, rms, count)


def _predict_output(seen: Sequence[Experiment], one: Experiment, k: int, unit: str) -> dict[str, Any]:
    """Baseline -> what it says in every row."""
    output, own = one.outputs[k], np.isfinite(one.measured[:, k]) & ~one.kept_back
    known = {x.name: _find_fitted(x, output) for x in seen}
    known = {name: values for name, values in known.items() if np.isfinite(values).any()}
    if not known:
        return {}
    pooled = one.measured[own, k] if own.any() else np.concatenate([v[np.isfinite(v)] for v in known.values()])
    mean = np.full(len(one.times), float(np.mean(pooled)))
    found = {MEAN: mean, CYCLE: None, SCALING: None}
    others = [x for x in seen if x.name in known and (not own.any() or x.name == one.name)]
    if isinstance(one, ConditionExperiment):
        found[SCALING] = _scale_conditions(others, one, output, unit)
    elif own.any():
        found[CYCLE] = _repeat_cycle(one, k, own)
    else:
        found[SCALING] = _scale_record(others, one, output, unit)
    return {name: np.where(np.isfinite(x), x, mean) for name, x in found.items() if x is not None}


def _find_fitted(one: Experiment, output: str) -> Any:
    """What was measured where the fit sees it; NaN elsewhere, and of a record without the output."""
    if output not in one.outputs:
        return np.full(len(one.times), np.nan)
    return np.where(one.kept_back, np.nan, one.measured[:, one.outputs.index(output)])


def _repeat_cycle(one: Experiment, k: int, own: Any) -> Any:
    """What was fitted whole periods before; None where the record is not periodic."""
    period = refine_period(one)
    length = float(one.times[-1] - one.times[0])
    if not 0.0 < period <= length / CYCLES:
        return None
    times, values = one.times[own], one.measured[own, k]
    near = 1.5 * float(np.median(np.diff(one.times)))
    found = np.full(len(one.times), np.nan)
    for back in range(1, int(length / period) + 1):
        at = one.times - back * period
        after = np.clip(np.searchsorted(times, at), 1, len(times) - 1)
        inside = (at >= times[0]) & (at <= times[-1]) & (times[after] - times[after - 1] <= near)
        found = np.where(np.isnan(found) & inside, np.interp(at, times, values), found)
    return found if np.isfinite(found[one.kept_back]).any() else None


def find_period(experiment: Experiment) -> float:
    """Mean period [s] of the first column that an experiment follows; its length if it never returns, 0 for none.

    Counted are passages from below a quarter of its range to above three quarters, and back.
    """
    if not experiment.follows:
        return 0.0
    table = experiment.followed(next(iter(experiment.follows)))
    x, length = np.asarray(table.values), table.times[-1] - table.times[0]
    share = (x - x.min()) / (np.ptp(x) or 1.0)
    sides = np.sign(np.where(np.abs(share - 0.5) >= 0.25, share - 0.5, 0.0))
    passages = int(np.count_nonzero(np.diff(sides[sides != 0.0])))
    return 2.0 * length / passages if passages > 1 else length


def refine_period(one: Experiment) -> float:
    """The period [s] near the mean one after which what drives repeats itself best; 0 for none."""
    about = find_period(one)
    if about == 0.0:
        return 0.0
    table = one.followed(next(iter(one.follows)))
    times, values = np.asarray(table.times), np.asarray(table.values)
    tried = about * np.linspace(1.0 - TURNED, 1.0 + TURNED, 81)

    def misfit(period: float) -> float:
        late = times[times >= times[0] + period]
        return float(np.mean(np.abs(np.interp(late, times, values) - np.interp(late - period, times, values))))

    apart = [misfit(period) for period in tried if period < 0.9 * (times[-1] - times[0])]
    return float(tried[int(np.argmin(apart))]) if apart else about


def _scale_record(others: Sequence[Experiment], one: Experiment, output: str, unit: str) -> Any:
    """The record whose drive is nearest in size, as far as it goes from its start, in proportion."""
    mine = _measure_drive(one)
    sizes = [_measure_drive(x) for x in others]
    apart = [abs(math.log(size / mine)) if size > 0.0 and mine > 0.0 else math.inf for size in sizes]
    nearest = others[int(np.argmin(apart))]
    values = _find_fitted(nearest, output)
    known = np.isfinite(values)
    ratio = mine / sizes[int(np.argmin(apart))] if _is_scaled(unit) and math.isfinite(min(apart)) else 1.0
    ratio = 1.0 if one.system.drives() and one.system.drives()[0].unit == "K" else ratio
    guess = np.interp(one.times - one.times[0], nearest.times[known] - nearest.times[0], values[known])
    return values[known][0] + ratio * (guess - values[known][0])


def _measure_drive(one: Experiment) -> float:
    """Root-mean-square of the first drive over the record, in its unit; 0 where there is none."""
    waves = arrange_waveforms(one.system, one.waveform)
    return math.sqrt(float(np.mean([waves[0].value(float(t)) ** 2 for t in one.times + one.lead]))) if waves else 0.0


def _scale_conditions(others: Sequence[Experiment], one: ConditionExperiment, output: str, unit: str) -> Any:
    """Every row from the nearest condition that was fitted, in proportion to what drives, or else differs first."""
    rows = [(c.inputs, x) for e in others for c, x in _pair_rows(e, output) if math.isfinite(x)]
    paths = sorted(one.input_units, key=lambda path: path != one.level)
    table = np.array([[inputs.get(path, math.nan) for path in paths] for inputs, _ in rows])
    reach = np.nanmax(table, axis=0) - np.nanmin(table, axis=0) if len(paths) else np.zeros(0)
    found = list[float]()
    for c in one.conditions:
        mine = np.array([c.inputs[path] for path in paths])
        place = int(np.argmin(np.nansum(((table - mine) / np.where(reach > 0.0, reach, 1.0)) ** 2, axis=1)))
        pairs = [(a, b) for a, b in zip(mine, table[place], strict=True) if a != b and a * b > 0.0]
        ratio = pairs[0][0] / pairs[0][1] if pairs and _is_scaled(unit) else 1.0
        found.append(float(rows[place][1] * ratio))
    return np.array(found)


def _pair_rows(one: Experiment, output: str) -> Iterator[tuple[Any, float]]:
    if isinstance(one, ConditionExperiment):
        yield from zip(one.conditions, _find_fitted(one, output).tolist(), strict=True)


def _is_scaled(unit: str) -> bool:
    return unit not in ("K", "s")
