"""What the page is told while a fit runs: cost, numbers, and now and then the curves."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, field
from threading import Event
from typing import Any

from martensite.app.identify.thinning import MOST_CORNERS
from martensite.app.messages import JsonTable, Request
from martensite.app.views.columns import (
    choose_rows,
    describe_conversion,
    describe_difference,
    describe_display,
    round_digits,
)
from martensite.base import units
from martensite.fit.experiment import Experiment
from martensite.fit.fit import Fit
from martensite.fit.free_parameters import is_nuisance
from martensite.fit.problem import Problem
from martensite.fit.search_monitor import SearchNote
from martensite.search.free_numbers import FreeNumber

EVERY = 0.4
"""Seconds between two notes."""
SHARE = 0.1
"""Of the time that may go into curves that are only shown."""


@dataclass
class FitProgress:
    """Told of every evaluation of a search, it tells the page, and ends the search if asked."""

    problem: Problem
    """With the records that the search sees."""
    tell: Callable[[Request], None]
    stop: Event
    began: float = field(default_factory=time.monotonic)
    _next: float = 0.0
    _next_curves: float = 0.0
    _drawn: tuple[float, ...] = ()

    def __call__(self, note: SearchNote) -> None:
        """Tell, at most every so often.

        Raises:
            KeyboardInterrupt: the search shall end; it keeps the best so far.
        """
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
        """Tell of the end of the search."""
        pairs = zip(self.problem.experiments, fit.evaluation.fitted, strict=True)
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
        """What the best so far gives, unless that was shown already, or takes too long."""
        if now < self._next_curves or values == self._drawn:
            return {}
        found = self.problem.evaluate(values)
        self._next_curves = time.monotonic() + (time.monotonic() - now) / SHARE
        if found is None:
            return {}
        self._drawn = values
        pairs = zip(self.problem.experiments, found.fitted, strict=True)
        return {"curves": [model_curves(one, fitted.model) for one, fitted in pairs]}


def model_curves(one: Experiment, model: Any) -> list[list[float]]:
    """Modelled outputs of a record at the rows that are drawn."""
    rows = choose_rows(len(one.times), MOST_CORNERS)
    return [[round_digits(model[row, k]) for row in rows] for k in range(len(one.outputs))]


def describe_measured(one: Experiment) -> JsonTable:
    """A record as it was measured, at the rows that are drawn."""
    rows, known = choose_rows(len(one.times), MOST_CORNERS), one.system.outputs()
    return {
        "name": one.name,
        "times": [float(one.times[row]) for row in rows],
        "held": [bool(one.kept_back[row]) for row in rows],
        "outputs": [
            {
                "name": name,
                "long_name": known[name].long_name,
                "measured": [round_digits(one.measured[row, k]) for row in rows],
                **describe_display(name, known[name].unit),
            }
            for k, name in enumerate(one.outputs)
        ],
    }


def describe_parameter(free: FreeNumber) -> JsonTable:
    """A parameter that is searched: where from, between which bounds, shown in which unit."""
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
