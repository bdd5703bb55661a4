"""A finished fit as the page shows it: numbers, errors, what the data leave open, curves, files."""

from __future__ import annotations

import math
from collections.abc import Mapping

from martensite.app.identify.fit_progress import describe_parameter
from martensite.app.identify.followed_columns import embed_log
from martensite.app.identify.thinning import MOST_CORNERS as FEW
from martensite.app.messages import JsonTable
from martensite.app.views.columns import choose_rows, describe_difference, describe_display, round_digits
from martensite.fit.fit import ComparedOutput, Fit, list_compared
from martensite.fit.fit_verdicts import describe_predictions, list_fit_warnings
from martensite.fit.free_parameters import is_nuisance
from martensite.scenario.exact_text import exact_text
from martensite.search.free_numbers import FreeNumber
from martensite.show.summaries.fit_tables import mark_parameter

DRAWN_ROWS = 800


def describe_outcome(fit: Fit) -> JsonTable:
    """All that is shown of a fit; numbers in SI."""
    return {
        "title": fit.scenario.title if fit.scenario else "",
        "reason": fit.reason,
        "method": fit.method,
        "loss": fit.loss,
        "cost": fit.cost,
        "simulations": fit.simulations,
        "jacobians": fit.jacobians,
        "seconds": fit.seconds,
        "parameters": [_describe_parameter(fit, free) for free in fit.problem.free],
        "own": {name: value for one in fit.kept for name, value in one.numbers.items()},
        "scores": [{**score.to_dict(), **describe_difference(score.output, score.unit)} for score in fit.scores],
        "determined": fit.identifiability.determined,
        "open": list(fit.identifiability.sentences),
        "weak": [one.to_dict() for one in fit.identifiability.weak],
        "uncertainty": list(fit.uncertainty.sentences),
        "correlation": [list(row) for row in fit.uncertainty.correlation],
        "whiteness": [one.sentence for one in fit.whiteness],
        "predictions": describe_predictions(fit),
        "warnings": list(dict.fromkeys([*fit.cautions, *_list_warnings(fit)])),
        "notes": list(fit.notes),
        "history": [list(fit.history[row]) for row in choose_rows(len(fit.history), FEW)],
        "rows": [_list_curves(one) for one in list_compared(fit)],
        "scenario": fitted_text(fit),
    }


def _list_warnings(fit: Fit) -> list[str]:
    """Warnings but those that say what the data leave open, which is told by itself."""
    told = {one.sentence for one in fit.identifiability.weak}
    return [sentence for sentence in list_fit_warnings(fit) if sentence not in told]


def _describe_parameter(fit: Fit, free: FreeNumber) -> JsonTable:
    low, high = fit.uncertainty.widened(free.name)
    known = math.isfinite(low) and math.isfinite(high)
    return {
        **describe_parameter(free),
        "value": fit[free.name],
        "interval": [low, high] if known else None,
        "error": fit.uncertainty.errors[fit.problem.names.index(free.name)],
        "mark": mark_parameter(fit, free.name),
    }


def _list_curves(one: ComparedOutput) -> JsonTable:
    """A record and output, measured and modelled; what was kept back is flagged."""
    rows = choose_rows(len(one.times), DRAWN_ROWS)
    return {
        "record": one.record,
        "output": one.output,
        "long_name": one.description.long_name,
        "times": [float(one.times[row]) for row in rows],
        "measured": [round_digits(one.measured[row]) for row in rows],
        "model": [round_digits(one.model[row]) for row in rows],
        "held": [bool(one.held[row]) for row in rows],
        **describe_display(one.output, one.description.unit),
    }


def fitted_text(fit: Fit) -> str:
    """The scenario of the first record with the fitted numbers, and with its log in it."""
    scenario, first = fit.scenario, fit.problem.experiments[0]
    if scenario is None:
        return ""
    numbers: Mapping[str, str] = {
        scenario.places.path(leaf.path): exact_text(fit[free.name], leaf.declared.unit, 9)
        for free in fit.problem.free
        if free.record in (None, first.name) and not is_nuisance(free.path)
        for leaf in scenario.system.leaves()
        if free.moves(leaf.path)
    }
    return embed_log(scenario, first.record, numbers)
