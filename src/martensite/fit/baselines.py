"""Baseline predictions of held-out data without a model, which a useful model must beat.

    mean of training    the mean of the fitted samples, of the same record if possible
    last cycle          of a periodic record: the fitted samples one cycle earlier
    first-order lag     a + b x, where x is the drive (squared, for volts and amperes) behind a lag
    straight line       a + b x, where x is a prescribed strain, force or position
    nearest record      of temperatures: the loop under the nearest load; others of loops as in `loop_rivals`
    linear scaling      from the nearest record, or condition, in proportion to the drive

All use fitted rows only. Temperatures and times are copied from the nearest record, without scaling.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np

from martensite.fit.condition_runs import ConditionExperiment
from martensite.fit.drive_lag import LAGS, find_drive, fit_drive_lag, refine_period
from martensite.fit.experiment import Experiment
from martensite.fit.fit import Fit
from martensite.fit.loop_rivals import LoopColumns, average_neighbours, find_branches, has_reversals, repeat_branches
from martensite.fit.problem import Problem
from martensite.signals.records import Record
from martensite.simulate.drive_waveforms import arrange_waveforms

MEAN, CYCLE, LAG, LINE = "mean of training", "last cycle", "first-order lag", "straight line"
NEAREST, SCALING = "nearest record", "linear scaling"
NEIGHBOURS, MAJOR = "neighbouring loads", "scaled major loop"
DRIVE = "drive"
"""Column name of the drive in all records."""
HALF = 0.5
"""Least fraction of held-out rows with an earlier cycle."""
CYCLES = 2.0
"""Least number of periods of a periodic record."""


@dataclass(frozen=True)
class BaselineScore:
    """Error of a baseline in the held-out rows of one output of one record."""

    record: str
    output: str
    name: str
    """Name of the baseline, from the module table."""
    unit: str
    """SI unit of the output."""
    rms: float
    """[unit]"""
    samples: int

    def to_dict(self) -> dict[str, Any]:
        """Return all fields by name, for JSON."""
        return asdict(self)


def score_baselines(fit_or_problem: Fit | Problem) -> list[BaselineScore]:
    """Return the errors of all baselines in the held-out rows, by record and output.

    If each record was left out in turn, all others predict it.
    """
    if isinstance(fit_or_problem, Problem):
        return list(_score_all(fit_or_problem.experiments, fit_or_problem.experiments))
    fitted = fit_or_problem.problem.experiments
    scores = list(
        _score_all(
            fitted, (*fitted, *(held_out_record.experiment for held_out_record in fit_or_problem.held_out_records))
        )
    )
    for held_out_record in fit_or_problem.transfer:
        mine = held_out_record.experiment.groups or {"": held_out_record.experiment.name}
        others = [x for x in fitted if (x.groups or {"": x.name}) != mine]
        scores += _score_all(others, [held_out_record.experiment])
    return scores


def pool_baselines(scores: Sequence[BaselineScore], output: str) -> dict[str, float]:
    """Return the root-mean-square error [unit] over all records, for every common baseline of an output."""
    own = [one for one in scores if one.output == output]
    records = len({one.record for one in own})
    errors: dict[str, float] = {}
    for name in dict.fromkeys(one.name for one in own):
        same = [one for one in own if one.name == name]
        if len({one.record for one in same}) == records:
            errors[name] = math.sqrt(sum(one.rms**2 * one.samples for one in same) / sum(one.samples for one in same))
    return errors


def _score_all(fitted: Sequence[Experiment], targets: Sequence[Experiment]) -> Iterator[BaselineScore]:
    for one in targets:
        for k, output in enumerate(one.outputs):
            measured = one.measured[:, k]
            held_out_rows = np.isfinite(measured) & one.held_out_rows
            if held_out_rows.any():
                unit, count = one.describe_outputs()[output].unit, int(held_out_rows.sum())
                for name, guess in predict_naively(fitted, one, output).items():
                    rms = float(np.sqrt(np.mean((guess[held_out_rows] - measured[held_out_rows]) ** 2)))
                    yield BaselineScore(one.name, output, name, unit, rms, count)


def predict_naively(fitted: Sequence[Experiment], one: Experiment, output: str) -> dict[str, Any]:
    """Return the baselines of an output in every row, (rows,), by name, from the rows of fitted experiments."""
    experiments = {x.name: x for x in fitted if np.isfinite(_find_fitted(x, output)).any()}
    if not experiments:
        return {}
    own = np.isfinite(_find_fitted(one, output))
    pooled = np.concatenate([_find_fitted(x, output) for x in ([one] if own.any() else experiments.values())])
    mean = np.full(len(one.times), float(np.nanmean(pooled)))
    predictions = {name: x for name, x in _predict_all(experiments, one, output, own).items() if x is not None}
    return {MEAN: mean} | {name: np.where(np.isfinite(x), x, mean) for name, x in predictions.items()}


def _predict_all(experiments: Mapping[str, Experiment], one: Experiment, output: str, own: Any) -> dict[str, Any]:
    """Return the baselines other than the mean; `own` marks the fitted rows of the record."""
    k, unit = one.outputs.index(output), one.describe_outputs()[output].unit
    others = [x for x in experiments.values() if (x.name == one.name) == own.any()]
    if isinstance(one, ConditionExperiment):
        return {SCALING: _scale_conditions(others, one, output, unit)} if others else {}
    predictions = _predict_driven(experiments, one, output)
    if own.any():
        return predictions | {CYCLE: _repeat_cycle(one, k, own)}
    if others and NEAREST not in predictions:
        return predictions | {SCALING: _scale_record(others, one, output, unit)}
    return predictions


def _predict_driven(experiments: Mapping[str, Experiment], one: Experiment, output: str) -> dict[str, Any]:
    """Return the predictions from the drive: a lag, a straight line, or the same temperature of another loop."""
    driving = _find_unit(one)
    alike = [x for x in experiments.values() if _find_unit(x) == driving]
    if not driving or not alike:
        return {}
    mine = _show_fitted(one, output)
    predictions: dict[str, Any] = {}
    late = find_drive(one) in [x.name for x in one.system.drives() if x.at_end]
    if driving != "K":
        lag = fit_drive_lag([_show_fitted(x, output) for x in alike], DRIVE, output, 0 if late else LAGS, refined=2)
        predictions = {LINE if late else LAG: lag.predict(mine, DRIVE)[one.rows]}
    return predictions | (_predict_loop(one, [x for x in alike if x.name != one.name], output) if late else {})


def _predict_loop(one: Experiment, others: Sequence[Experiment], output: str) -> dict[str, Any]:
    """Return the predictions of a loop over a prescribed state, from other loops or from its own major loop."""
    mine = _show_loop(one, output)
    predictions: dict[str, Any] = {}
    if np.isfinite(mine.column).any() and has_reversals(mine):
        predictions = {MAJOR: repeat_branches(mine, find_branches(mine))}
    if others:
        loads = _find_loads([one, *others], output)
        mine = replace(mine, load=loads[0])
        loops = [replace(_show_loop(x, output), load=load) for x, load in zip(others, loads[1:], strict=True)]
        nearest = min(loops, key=lambda x: abs(x.load - mine.load))
        predictions |= {
            NEAREST: repeat_branches(mine, find_branches(nearest)),
            NEIGHBOURS: average_neighbours(mine, loops),
        }
    return {name: x[one.rows] for name, x in predictions.items() if x is not None and np.isfinite(x).any()}


def _show_loop(one: Experiment, output: str) -> LoopColumns:
    record = _show_fitted(one, output)
    kelvin = np.asarray(record[DRIVE], float)
    rows = np.arange(len(kelvin))
    finite_rows = np.isfinite(kelvin)
    return LoopColumns(np.interp(rows, rows[finite_rows], kelvin[finite_rows]), np.asarray(record[output], float))


def _find_unit(one: Experiment) -> str:
    """Return the unit of the drive; empty without a drive."""
    drive = find_drive(one)
    return one.record.units[one.follows[drive]] if drive else ""


def _show_fitted(one: Experiment, output: str) -> Record:
    """Return the drive and an output over time; NaN for held-out output samples."""
    column, output_column = one.follows[find_drive(one)], np.full(len(one.record), np.nan)
    output_column[one.rows] = _find_fitted(one, output)
    columns = {"time": one.record.times, DRIVE: one.record[column], output: output_column}
    return Record(one.name, columns, {"time": "s", DRIVE: one.record.units[column], output: "1"})


def _find_fitted(one: Experiment, output: str) -> Any:
    """Return the measured values of the fitted rows; NaN elsewhere, and for a record without the output."""
    if output not in one.outputs:
        return np.full(len(one.times), np.nan)
    return np.where(one.held_out_rows, np.nan, one.measured[:, one.outputs.index(output)])


# ---------------------------------------------------------------- earlier cycle


def _repeat_cycle(one: Experiment, k: int, own: Any) -> Any:
    """Return the fitted values whole periods earlier; None for a record without periods."""
    period = refine_period(one)
    length = float(one.times[-1] - one.times[0])
    if not 0.0 < period <= length / CYCLES:
        return None
    times, values = one.times[own], one.measured[own, k]
    near = 1.5 * float(np.median(np.diff(one.times)))
    prediction = np.full(len(one.times), np.nan)
    for back in range(1, int(length / period) + 1):
        at = one.times - back * period
        after = np.clip(np.searchsorted(times, at), 1, len(times) - 1)
        inside = (at >= times[0]) & (at <= times[-1]) & (times[after] - times[after - 1] <= near)
        prediction = np.where(np.isnan(prediction) & inside, np.interp(at, times, values), prediction)
    return prediction if np.isfinite(prediction[one.held_out_rows]).mean() > HALF else None


# ---------------------------------------------------------------- nearest record or condition


def _find_loads(ones: Sequence[Experiment], output: str) -> list[float]:
    """Return the mean loads of records; without prescribed loads, their mean temperatures or drives."""
    drives = [x.follows[find_drive(x)] for x in ones]
    load_columns = [n for n in ("stress", "force", "temperature") if n not in (output, *drives)]
    column = next((n for n in load_columns if all(n in x.record.columns for x in ones)), "")
    return [float(np.nanmean(x.record[column or own])) for x, own in zip(ones, drives, strict=True)]


def _scale_record(others: Sequence[Experiment], one: Experiment, output: str, unit: str) -> Any:
    """Return the record with the nearest drive, scaled about its start in proportion to the drive."""
    mine = _measure_drive(one)
    sizes = [_measure_drive(x) for x in others]
    apart = [abs(math.log(size / mine)) if size > 0.0 and mine > 0.0 else math.inf for size in sizes]
    nearest = others[int(np.argmin(apart))]
    values = _find_fitted(nearest, output)
    finite_rows = np.isfinite(values)
    ratio = mine / sizes[int(np.argmin(apart))] if _is_scaled(unit) and math.isfinite(min(apart)) else 1.0
    ratio = 1.0 if one.system.drives() and one.system.drives()[0].unit == "K" else ratio
    guess = np.interp(one.times - one.times[0], nearest.times[finite_rows] - nearest.times[0], values[finite_rows])
    return values[finite_rows][0] + ratio * (guess - values[finite_rows][0])


def _measure_drive(one: Experiment) -> float:
    """Return the root-mean-square of the first drive over the record, in its unit; 0 without a drive."""
    waves = arrange_waveforms(one.system, one.waveform)
    return math.sqrt(float(np.mean([waves[0].value(float(t)) ** 2 for t in one.times + one.lead]))) if waves else 0.0


def _scale_conditions(others: Sequence[Experiment], one: ConditionExperiment, output: str, unit: str) -> Any:
    """Return every row scaled from the nearest fitted condition, in proportion to the drive or the first difference."""
    rows = [(c.inputs, x) for e in others for c, x in _pair_rows(e, output) if math.isfinite(x)]
    paths = sorted(one.input_units, key=lambda path: path != one.level)
    table = np.array([[inputs.get(path, math.nan) for path in paths] for inputs, _ in rows])
    reach = np.nanmax(table, axis=0) - np.nanmin(table, axis=0) if len(paths) else np.zeros(0)
    predictions = list[float]()
    for c in one.conditions:
        mine = np.array([c.inputs[path] for path in paths])
        place = int(np.argmin(np.nansum(((table - mine) / np.where(reach > 0.0, reach, 1.0)) ** 2, axis=1)))
        pairs = [(a, b) for a, b in zip(mine, table[place], strict=True) if a != b and a * b > 0.0]
        ratio = pairs[0][0] / pairs[0][1] if pairs and _is_scaled(unit) else 1.0
        predictions.append(float(rows[place][1] * ratio))
    return np.array(predictions)


def _pair_rows(one: Experiment, output: str) -> Iterator[tuple[Any, float]]:
    if isinstance(one, ConditionExperiment):
        yield from zip(one.conditions, _find_fitted(one, output).tolist(), strict=True)


def _is_scaled(unit: str) -> bool:
    return unit not in ("K", "s")
