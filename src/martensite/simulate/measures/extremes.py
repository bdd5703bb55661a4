"""Largest and smallest values, their difference, and values at a time or at the end."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np

from martensite.base.errors import ParameterError
from martensite.base.parameters import Number, param
from martensite.base.units import DEGREES
from martensite.simulate.measures.base import MEASURES, AbstractMeasure
from martensite.simulate.measures.run_table import Numbers, RunTable


@MEASURES.register("max")
class Largest(AbstractMeasure):
    """Largest value, of all elements."""

    def unit(self, unit: str) -> str:
        """Return the unit of the output."""
        return unit

    def value(self, table: RunTable) -> Numbers:
        """Return max y."""
        return table.find_highest().max(axis=0)

    def derivatives(self, table: RunTable) -> Numbers:
        """Return 1 at the largest row."""
        return _mark_row(table.values, np.argmax)


@MEASURES.register("min")
class Smallest(Largest):
    """Smallest value, of all elements."""

    def value(self, table: RunTable) -> Numbers:
        """Return min y."""
        return table.find_lowest().min(axis=0)

    def derivatives(self, table: RunTable) -> Numbers:
        """Return 1 at the smallest row."""
        return _mark_row(table.values, np.argmin)


@MEASURES.register("stroke")
class Stroke(Largest):
    """Largest minus smallest value; without an output, of the first coordinate."""

    def unit(self, unit: str) -> str:
        """Return the unit of a difference."""
        return DEGREES if unit == "K" else unit

    def value(self, table: RunTable) -> Numbers:
        """Return max y − min y, the largest of several."""
        return (table.find_highest() - table.find_lowest()).max(axis=0)

    def derivatives(self, table: RunTable) -> Numbers:
        """Return 1 at the largest and −1 at the smallest row of the column that varies most."""
        values = table.values
        derivatives = np.zeros(values.shape)
        runs = np.arange(values.shape[2], dtype=np.intp)
        widest = np.ptp(values, axis=1).argmax(axis=0)
        column = values[widest, :, runs]
        derivatives[widest, column.argmax(axis=1), runs] += 1.0
        derivatives[widest, column.argmin(axis=1), runs] -= 1.0
        return derivatives


@MEASURES.register("change")
class Change(Stroke):
    """Largest change from the first value, with its sign; of several outputs the one that changes most."""

    def value(self, table: RunTable) -> Numbers:
        """Return y(t) − y(0) at its largest absolute value."""
        first = table.values[:, 0]
        both = np.stack([table.find_highest() - first, table.find_lowest() - first]).reshape(-1, first.shape[1])
        return both[np.abs(both).argmax(axis=0), np.arange(first.shape[1], dtype=np.intp)]

    def derivatives(self, table: RunTable) -> Numbers:
        """Return 1 at the farthest row and −1 at the first."""
        values = table.values
        derivatives, runs = np.zeros(values.shape), np.arange(values.shape[2], dtype=np.intp)
        most = np.abs(values - values[:, :1]).max(axis=1).argmax(axis=0)
        derivatives[most, np.abs(self._choose_column(values)).argmax(axis=0), runs] += 1.0
        derivatives[most, 0, runs] -= 1.0
        return derivatives

    def _choose_column(self, values: Numbers) -> Numbers:
        """Return the change of the column that changes most, (rows, runs)."""
        change = values - values[:, :1]
        return change[np.abs(change).max(axis=1).argmax(axis=0), :, np.arange(values.shape[2], dtype=np.intp)].T


def _mark_row(values: Numbers, place: Callable[..., Any]) -> Numbers:
    """Return 1 at one value of every run, else 0."""
    marks = np.zeros(values.shape).reshape(-1, values.shape[2])
    marks[place(values.reshape(marks.shape), axis=0), np.arange(values.shape[2])] = 1.0
    return marks.reshape(values.shape)


@MEASURES.register("at")
class At(AbstractMeasure):
    """Value at a time; of several elements the largest."""

    follows_curve = True

    time: Number = param("s", "when; the end if not given", low=0.0, default=math.inf)

    def unit(self, unit: str) -> str:
        """Return the unit of the output."""
        return unit

    def value(self, table: RunTable) -> Numbers:
        """Return y(t)."""
        return np.einsum("sr,csr->cr", self._weigh_rows(table), table.values).max(axis=0)

    def derivatives(self, table: RunTable) -> Numbers:
        """Return the weights of both neighbours, in the column with the largest value."""
        shares = self._weigh_rows(table)
        largest = np.einsum("sr,csr->cr", shares, table.values).argmax(axis=0)
        return shares * (np.arange(len(table.values))[:, None] == largest)[:, None, :]

    def _weigh_rows(self, table: RunTable) -> Numbers:
        """Return the weights of the rows on both sides of the time, (rows, runs); after a jump at that time."""
        times = table.times
        last = times[-1]
        when = np.where(math.isinf(self.time), last, self.time)
        if (when > last * (1.0 + 1e-12)).any() and not math.isinf(self.time):
            raise ParameterError(
                f"`{self.registered_name}` looks at {self.time:.6g} s, but the run ends at {last.min():.6g} s."
            )
        before = np.clip((times <= when).sum(axis=0) - 1, 0, len(times) - 2)
        runs = np.arange(times.shape[1], dtype=np.intp)
        begin, length = times[before, runs], np.diff(times, axis=0)[before, runs]
        share = np.clip(np.where(length > 0.0, (when - begin) / np.where(length > 0.0, length, 1.0), 1.0), 0.0, 1.0)
        weights = np.zeros(times.shape)
        weights[before, runs], weights[before + 1, runs] = 1.0 - share, share
        return weights


@MEASURES.register("final")
class Final(At):
    """Value at the end."""
