"""Verdicts on a fit, as sentences to read before its values are used.

The sentences compare the results of the fit with fixed limits, without new computations.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from martensite.base import units
from martensite.fit.baselines import BaselineScore, pool_baselines, score_baselines
from martensite.fit.drive_lag import find_period
from martensite.fit.fit import HELD_OUT, TRAINING, ComparedOutput, Fit, compute_rms, list_compared, list_held_out
from martensite.search.quantity_text import format_change, format_number, format_quantity, join_phrases, list_names
from martensite.search.rivals import EXPLAINED, FAILS, RIVALLED, Prediction

WORSE = 1.5
"""Ratio of held-out to training error above which predictions are reported as worse than the fit."""
POOR = 50.0
"""Explained fraction of the variation [%] below which a model is reported as poor."""
OTHER_CADENCE = 1.5
"""Ratio of periods above which the period of a record counts as different."""
NOTABLE = 0.05
"""Error as a fraction of the range of an output, below which no misfit is reported."""


def format_error(output: str, value: float, unit: str, digits: int = 3) -> str:
    """Return an error of an output in everyday units: `0.17 %` of strain, `1.2 K`."""
    if units.of_column(output, unit) == "%":
        return f"{format_number(100.0 * value, digits)} %"
    return format_change(value, unit, digits)


def describe_predictions(fit: Fit) -> list[str]:
    """Return one sentence per output: its error in the fitted and in the held-out rows."""
    rows = list_compared(fit)
    names = dict.fromkeys(one.output for one in rows)
    return [
        *(_describe_prediction([one for one in rows if one.output == name]) for name in names),
        *_describe_transfer(fit),
        *_describe_baselines(fit),
        *_describe_own_numbers(fit),
        *_describe_spreads(fit),
        *_describe_input_noise(fit),
        *_describe_one_cadence(fit),
    ]


def list_fit_warnings(fit: Fit) -> list[str]:
    """Return the reasons against trusting the fitted values; empty if none apply."""
    return [
        *warn_of_search(fit),
        *warn_of_predictions(fit),
        *warn_of_misses(fit),
        *warn_of_baselines(fit),
        *warn_of_rivals(fit),
        *_warn_of_cadence(fit),
        *warn_of_directions(fit),
        *_warn_of_residuals(fit),
    ]


def _describe_prediction(rows: list[ComparedOutput]) -> str:
    name, unit = rows[0].output, rows[0].description.unit
    training_rms, held_out_rms = (compute_rms(rows, part) for part in (TRAINING, HELD_OUT))
    fitted = f"`{name}`: rms error {format_error(name, training_rms, unit)} in the fitted rows"
    if math.isnan(training_rms):
        error = format_error(name, held_out_rms, unit)
        return f"`{name}`: rms error {error} in the held-out rows; no row was fitted."
    if math.isnan(held_out_rms):
        return f"{fitted}; no rows were held out."
    times = f" (ratio {format_number(held_out_rms / training_rms, 3)})" if training_rms > 0.0 else ""
    return f"{fitted}, {format_error(name, held_out_rms, unit)} in the held-out rows{times}."


def _list_predicted(fit: Fit) -> list[ComparedOutput]:
    """Return all held-out outputs, including records left out in turn."""
    turns = [one for held_out_record in fit.transfer for one in list_held_out(held_out_record)]
    return [*turns, *(one for one in list_compared(fit) if one.held_out_rows.any())]


def _describe_transfer(fit: Fit) -> Iterator[str]:
    rows = [one for held_out_record in fit.transfer for one in list_held_out(held_out_record)]
    names = join_phrases(list(dict.fromkeys(one.record for one in rows)))
    for name in dict.fromkeys(one.output for one in rows):
        own = [one for one in rows if one.output == name]
        unit = own[0].description.unit
        error = format_error(name, compute_rms(own, HELD_OUT), unit)
        alone = dict.fromkeys(
            path.partition("@")[0] for held_out_record in fit.transfer for path in held_out_record.numbers
        )
        what = "all other parameters fixed" if alone else "no parameter fitted to them"
        bare = [one.residuals if one.raw is None else one.raw - one.measured for one in own]
        raw = format_error(name, math.sqrt(float(np.nanmean(np.concatenate(bare) ** 2))), unit)
        but = f" ({list_names(list(alone))} fitted to each, {raw} without)" if alone else ""
        yield f"`{name}`: rms error {error}{but} in logs that were held out in turn ({names}), {what}."


def _describe_baselines(fit: Fit) -> Iterator[str]:
    """Describe the errors of predictions without a model in the held-out rows."""
    scores = score_baselines(fit)
    parts = [
        f"`{name}` {_list_baselines(scores, name, unit)}"
        for name, unit in dict.fromkeys((one.output, one.unit) for one in scores)
    ]
    if parts:
        yield f"Held-out errors without a model: {'; '.join(parts)}."


def _list_baselines(scores: Sequence[BaselineScore], output: str, unit: str) -> str:
    errors = pool_baselines(scores, output)
    return ", ".join(f"{format_error(output, rms, unit)} ({name})" for name, rms in errors.items())


def list_predictions(fit: Fit) -> dict[str, tuple[Prediction, str]]:
    """Return the held-out error of every output beside its baselines, and its unit."""
    scores, rows = score_baselines(fit), _list_predicted(fit)
    predictions: dict[str, tuple[Prediction, str]] = {}
    for name, unit in dict.fromkeys((one.output, one.unit) for one in scores):
        own = [one for one in rows if one.output == name]
        squares = np.concatenate(
            [(one.measured[one.held_out_rows] - np.mean(one.measured[one.held_out_rows])) ** 2 for one in own]
        )
        spread = math.sqrt(float(np.mean(squares)))
        predictions[name] = Prediction(compute_rms(own, HELD_OUT), spread, pool_baselines(scores, name)), unit
    return predictions


def warn_of_baselines(fit: Fit) -> Iterator[str]:
    """Yield the outputs that are not predicted, by the rule of `martensite.search.rivals`."""
    for name, (one, unit) in list_predictions(fit).items():
        if one.verdict == FAILS and not one.beats_rivals:
            yield (
                f"`{name}` of the held-out data is not predicted better than without a model: "
                f"{_compare_errors(name, one, unit)}. Do not use the fit for predictions."
            )
        elif one.verdict == FAILS:
            yield (
                f"The model explains {one.fit_percent:.0f} % of the variation of `{name}` in the held-out data, less "
                f"than {100.0 * EXPLAINED:.0f} %. Do not use the fit for predictions."
            )


def warn_of_rivals(fit: Fit) -> Iterator[str]:
    """Yield the outputs that are predicted well, but as well or better by a baseline."""
    for name, (one, unit) in list_predictions(fit).items():
        if one.verdict == RIVALLED:
            yield (
                f"The model explains {one.fit_percent:.0f} % of the variation of `{name}` in the held-out data and is "
                f"usable, but a baseline is as good or better: {_compare_errors(name, one, unit)}. Between "
                "your records, prefer this baseline."
            )


def _compare_errors(name: str, one: Prediction, unit: str) -> str:
    rival = format_error(name, one.rivals[one.best_rival], unit)
    return f"rms error {format_error(name, one.rms, unit)}, and {rival} for the naive baseline ({one.best_rival})"


def _describe_spreads(fit: Fit) -> Iterator[str]:
    problem = fit.problem
    for path in dict.fromkeys(problem.free[i].path for i, _ in problem.spreads):
        own = [(problem.free[i], centre) for i, centre in problem.spreads if problem.free[i].path == path]
        free, centre = own[0]
        size = f"{format_number(100.0 * free.spread, 3)} %" if free.relative else format_change(free.spread, free.unit)
        at = fit.numbers[problem.free[centre].name] if centre is not None else free.start
        about = f"{format_quantity(at, free.unit)}, {'as fitted' if centre is not None else 'as declared'}"
        noise_text = "as declared" if problem.knows_noise else f"{format_number(problem.prior_scale, 2)} of the range"
        yield (
            f"`{path}` of {join_phrases([str(x.record) for x, _ in own])} has a prior of ± {size} around {about}, "
            f"which counts as {len(own)} of {len(fit.evaluation.residuals)} data. The noise is {noise_text}. "
            "Held-out data use the centre."
        )


def _describe_own_numbers(fit: Fit) -> Iterator[str]:
    raw = [
        f"{format_error(one.output, one.raw_rms, one.description.unit)} (`{one.output}` of {one.record})"
        for one in list_compared(fit)
        if one.raw is not None
    ]
    own = dict.fromkeys(
        name.partition("@")[0] for held_out_record in fit.held_out_records for name in held_out_record.numbers
    )
    if own:
        yield (
            f"The parameters of each log ({list_names(list(own))}) were also fitted to the held-out logs. All other "
            f"parameters were fixed. Without this fit the held-out error is {join_phrases(raw)}."
        )


def _describe_input_noise(fit: Fit) -> Iterator[str]:
    if fit.input_noise:
        units = {c: one.record.units[c] for one in fit.problem.experiments for c in one.follows.values()}
        phrases = {
            one.column: f"{format_change(one.sigma, units[one.column], 2)} in `{one.column}` "
            f"({'declared' if one.is_declared else 'estimated from neighbouring rows'})"
            for one in fit.input_noise
        }
        yield f"Values and intervals include the input noise: {join_phrases(list(phrases.values()))}."


def _describe_one_cadence(fit: Fit) -> Iterator[str]:
    """Yield a warning if the period matters but was not varied."""
    rows = list_compared(fit)
    periods = {one.record: find_period(one.experiment) for one in rows}
    drives = fit.system().actuators().values()
    if all(one.source.sets_temperature for one in drives) or not all(periods.values()):
        return
    if max(periods.values()) < OTHER_CADENCE * min(periods.values()):
        period = format_number(min(periods.values()), 2)
        yield (
            f"All logs have one period (about {period} s), so the error for a faster or slower drive is unknown. "
            "Record a log with a period of one third of it, or of three times."
        )


def _warn_of_cadence(fit: Fit) -> Iterator[str]:
    """Yield the held-out records with a different period and worse predictions."""
    rows = list_compared(fit)
    fitted = [find_period(one) for one in fit.problem.experiments]
    for one in rows:
        period = find_period(one.experiment)
        apart = [max(period / p, p / period) for p in fitted if p and period]
        if one.training_rows.any() or not apart or min(apart) < OTHER_CADENCE:
            continue
        shares = [_compute_share(x, x.training_rows) for x in rows if x.output == one.output and x.training_rows.any()]
        worse = _compute_share(one, one.held_out_rows) / max(shares, default=math.nan)
        if worse > WORSE:
            speed = "slower" if period > max(fitted) else "faster" if period < min(fitted) else "different in speed"
            yield (
                f"`{one.record}` (period of about {format_number(period, 2)} s) is {speed} compared with the fitted "
                f"logs. The relative error of `{one.output}` is {format_number(worse, 2)} times its error on these: "
                "they do not determine cooling, heat capacity or delay. Add a log of that period to the fit."
            )


def _compute_share(one: ComparedOutput, rows: Any) -> float:
    """Return the error of some rows as a fraction of their measured variation."""
    return float(np.std(one.residuals[rows]) + abs(np.mean(one.residuals[rows]))) / (
        float(np.std(one.measured[rows])) or math.inf
    )


def warn_of_search(fit: Fit) -> Iterator[str]:
    """Yield warnings about a search without a minimum, or with an end at a bound."""
    if fit.reason not in ("converged", "stopped at bounds"):
        yield (f"The search did not converge: {fit.reason}. The values are the best of the search.")
    for free, u in zip(fit.problem.free, fit.values, strict=True):
        if free.name in fit.at_bound():
            side, bound = ("lower", free.low) if u < 0.5 else ("upper", free.high)
            clause = f"`{free.name}` ended on its {side} bound, {format_quantity(bound, free.unit)}"
            yield f"{clause}, so the data did not set it. Widen the bound or fix the parameter."


def warn_of_predictions(fit: Fit) -> Iterator[str]:
    """Yield warnings about missing held-out data, and about predictions worse than the fit."""
    rows = list_compared(fit)
    if not _list_predicted(fit):
        yield "No data were held out, so the error of predictions is unknown. Use `--hold-out auto`."
    for name in dict.fromkeys(one.output for one in rows):
        own = [one for one in rows if one.output == name]
        training_rms, held_out_rms = (compute_rms(own, part) for part in (TRAINING, HELD_OUT))
        if held_out_rms > WORSE * training_rms:
            yield (
                f"`{name}` is predicted worse than it is fitted: the held-out error is "
                f"{format_number(held_out_rms / training_rms, 3)} times the error of the fitted rows."
                if training_rms > 0.0
                else f"`{name}` has no error in the fitted rows but errors in the held-out rows."
            )


def warn_of_misses(fit: Fit) -> Iterator[str]:
    """Yield a warning about outputs with mostly unexplained variation."""
    rows, scores = list_compared(fit), fit.scores
    poor = [x for x in scores if x.fit_percent < POOR and x.rms > NOTABLE * _measure_range(rows, x.output)]
    if poor:
        met = (f"`{one.output}` of {one.record} ({format_number(one.fit_percent, 3)} %)" for one in poor)
        yield f"The model explains less than half of the variation: {join_phrases(list(met))}."


def _measure_range(rows: list[ComparedOutput], output: str) -> float:
    values = [one.measured for one in rows if one.output == output]
    ends = [(float(np.nanmin(column)), float(np.nanmax(column))) for column in values]
    return max(high for _, high in ends) - min(low for low, _ in ends)


def warn_of_directions(fit: Fit) -> Iterator[str]:
    """Yield the parameters that the records do not determine or separate."""
    yield from (one.sentence for one in fit.identifiability.weak)
    weak = {name for one in fit.identifiability.weak for name in one.names} | set(fit.at_bound())
    yield from (f"`{name}` is not determined: {why}." for name, why in fit.undetermined.items() if name not in weak)
    pairs = fit.uncertainty.list_confounded()
    for group in _group_pairs([{one, other} for one, other, _ in pairs]):
        names = [name for name in fit.problem.names if name in group]
        most = max(abs(value) for one, _, value in pairs if one in group)
        yield (
            f"{list_names(names)} are strongly correlated ({'up to ' if names[2:] else ''}{most:.3f}): their intervals "
            "do not hold for all of them together. Fix one of them, or record data that separate them."
        )


def _group_pairs(pairs: Sequence[set[str]]) -> list[set[str]]:
    """Return the sets of names that are connected by pairs."""
    groups: list[set[str]] = []
    for pair in pairs:
        whole = pair.union(*(group for group in groups if group & pair))
        groups = [group for group in groups if not group & pair] + [whole]
    return groups


def _warn_of_residuals(fit: Fit) -> Iterator[str]:
    rows = {f"{one.record}, {one.output}": one for one in list_compared(fit)}
    outputs = [rows[one.record] for one in fit.whiteness if not one.white]
    names = [f"`{one.output}` of {one.record}" for one in outputs]
    if names:
        yield (
            f"Residuals are autocorrelated ({join_phrases(names)}): the model is incomplete or the noise is coloured. "
            "Use the widened intervals. They do not include the error of the model."
        )
