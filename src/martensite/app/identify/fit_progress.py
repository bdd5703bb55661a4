"""A fit on the page: cost, values and curves during the search; its outcome at the end."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from threading import Event
from typing import Any

from martensite.app.identify.fit_judgement import describe_judgement
from martensite.app.identify.followed_columns import embed_log
from martensite.app.messages import JsonTable, Request
from martensite.app.views.columns import (
    MOST_CORNERS,
    choose_rows,
    describe_conversion,
    describe_difference,
    describe_display,
    round_digits,
)
from martensite.app.views.columns import MOST_CORNERS as FEW
from martensite.base import units
from martensite.fit.experiment import Experiment
from martensite.fit.experiment_kinds.base import Proposal
from martensite.fit.fit import ComparedOutput, Fit, list_compared
from martensite.fit.fit_verdicts import describe_predictions, list_fit_warnings
from martensite.fit.free_parameters import is_nuisance
from martensite.fit.problem import Problem
from martensite.fit.search_monitor import SearchNote
from martensite.scenario.exact_text import exact_text
from martensite.search.free_numbers import FreeNumber
from martensite.show.summaries.fit_tables import mark_parameter

EVERY = 0.4
"""Seconds between two notes."""
TIME_FRACTION = 0.1
"""Fraction of the time for displayed curves."""
DRAWN_ROWS = 800


@dataclass
class FitProgress:
    """Receiver of evaluations that sends notes, and stops the search on request."""

    problem: Problem
    """With the records that the search uses."""
    tell: Callable[[Request], None]
    stop: Event
    began: float = field(default_factory=time.monotonic)
    _next: float = 0.0
    _next_curves: float = 0.0
    _sent_values: tuple[float, ...] = ()

    def __call__(self, note: SearchNote) -> None:
        """Send a note, at intervals of `EVERY`."""
        if self.stop.is_set():
            raise KeyboardInterrupt
        now = time.monotonic()
        if now < self._next:
            return
        self._next = now + EVERY
        self.tell(
            {
                "stage": note.stage,
                "cost": note.cost,
                "simulations": note.simulations,
                "share": note.share,
                "seconds": now - self.began,
                "values": self.problem.numbers(note.values),
                **self._curves(note.values, now),
            }
        )

    def finish(self, fit: Fit) -> None:
        """Send the note on the end of the search."""
        pairs = zip(self.problem.experiments, fit.evaluation.fitted_records, strict=True)
        self.tell(
            {
                "stage": "looking at the result",
                "cost": fit.cost,
                "simulations": fit.simulations,
                "share": 1.0,
                "seconds": time.monotonic() - self.began,
                "values": fit.numbers,
                "curves": [model_curves(one, fitted.model) for one, fitted in pairs],
            }
        )

    def _curves(self, values: tuple[float, ...], now: float) -> JsonTable:
        """Return the curves of the best point so far; empty if already sent or too slow."""
        if now < self._next_curves or values == self._sent_values:
            return {}
        evaluation = self.problem.evaluate(values)
        self._next_curves = time.monotonic() + (time.monotonic() - now) / TIME_FRACTION
        if evaluation is None:
            return {}
        self._sent_values = values
        pairs = zip(self.problem.experiments, evaluation.fitted_records, strict=True)
        return {"curves": [model_curves(one, fitted.model) for one, fitted in pairs]}


def model_curves(one: Experiment, model: Any) -> list[list[float]]:
    """Return the modelled outputs of a record at the drawn rows."""
    rows = choose_rows(len(one.times), MOST_CORNERS)
    return [[round_digits(model[row, k]) for row in rows] for k in range(len(one.outputs))]


def describe_measured(one: Experiment) -> JsonTable:
    """Return a measured record at the drawn rows."""
    rows, outputs = choose_rows(len(one.times), MOST_CORNERS), one.system.outputs()
    return {
        "name": one.name,
        "times": [float(one.times[row]) for row in rows],
        "held": [bool(one.held_out_rows[row]) for row in rows],
        "outputs": [
            {
                "name": name,
                "long_name": outputs[name].long_name,
                "measured": [round_digits(one.measured[row, k]) for row in rows],
                **describe_display(name, outputs[name].unit),
            }
            for k, name in enumerate(one.outputs)
        ],
    }


def describe_parameter(free: FreeNumber) -> JsonTable:
    """Return a free parameter with start, bounds and display unit."""
    how = describe_conversion(free.unit, units.choose_familiar_unit(free.start, free.unit))
    if is_nuisance(free.path):
        how = describe_difference(free.path.removeprefix("offset."), free.unit)
    return {
        "name": free.name,
        "record": free.record,
        "start": free.start,
        "low": free.low,
        "high": free.high,
        "doc": free.doc,
        **how,
    }


def describe_outcome(fit: Fit, proposal: Proposal | None = None) -> JsonTable:
    """Return the displayed results of a fit in SI; `proposal` is its proposed scenario, if any."""
    return {
        "verdict": describe_judgement(fit, proposal),
        "title": fit.scenario.title if fit.scenario else "",
        "reason": fit.reason,
        "method": fit.method,
        "loss": fit.loss,
        "cost": fit.cost,
        "simulations": fit.simulations,
        "jacobians": fit.jacobians,
        "seconds": fit.seconds,
        "parameters": [_describe_found(fit, free) for free in fit.problem.free],
        "own": {name: value for one in fit.held_out_records for name, value in one.numbers.items()},
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
    """Return the warnings, except those about undetermined parameters, which the page displays separately."""
    members = {one.sentence for one in fit.identifiability.weak}
    return [sentence for sentence in list_fit_warnings(fit) if sentence not in members]


def _describe_found(fit: Fit, free: FreeNumber) -> JsonTable:
    low, high = fit.uncertainty.widen_interval(free.name)
    bounded = math.isfinite(low) and math.isfinite(high)
    return {
        **describe_parameter(free),
        "value": fit[free.name],
        "interval": [low, high] if bounded else None,
        "error": fit.uncertainty.errors[fit.problem.names.index(free.name)],
        "mark": mark_parameter(fit, free.name),
    }


def _list_curves(one: ComparedOutput) -> JsonTable:
    rows = choose_rows(len(one.times), DRAWN_ROWS)
    return {
        "record": one.record,
        "output": one.output,
        "long_name": one.description.long_name,
        "times": [float(one.times[row]) for row in rows],
        "measured": [round_digits(one.measured[row]) for row in rows],
        "model": [round_digits(one.model[row]) for row in rows],
        "held": [bool(one.held_out_rows[row]) for row in rows],
        "axis": _find_axis(one, rows),
        **describe_display(one.output, one.description.unit),
    }


def _find_axis(one: ComparedOutput, rows: list[int]) -> JsonTable | None:
    """Return the horizontal axis of a loop without times; None for a record with times."""
    record = one.experiment.record
    name = next((name for name in ("temperature", "strain") if name in record.columns and name != one.output), "")
    if record.interval is None or not name or len(record) != len(one.times):
        return None
    return {
        "name": name,
        "values": [round_digits(record[name][row], 7) for row in rows],
        **describe_display(name, record.units[name]),
    }


def fitted_text(fit: Fit) -> str:
    """Return the scenario of the first record with the fitted values and its log."""
    scenario, first = fit.scenario, fit.problem.experiments[0]
    if scenario is None:
        return ""
    numbers: Mapping[str, str] = {
        scenario.places.path(leaf.path): exact_text(fit[free.name], leaf.declared.unit, 9)
        for free in fit.problem.free
        if free.record in (None, *first.labels) and not is_nuisance(free.path)
        for leaf in scenario.system.leaves()
        if free.moves(leaf.path)
    }
    return embed_log(scenario, first.record, numbers)
