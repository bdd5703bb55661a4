"""Largest and smallest samples and what lies between them; what is seen at a time, or at the end."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np

from martensite.base.errors import ParameterError
from martensite.base.parameters import param
from martensite.base.units import DEGREES
from martensite.kernels.namespace import Scalar
from martensite.simulate.measures.base import MEASURES, AbstractMeasure, Numbers


@MEASURES.register("max")
class Largest(AbstractMeasure):
    """Largest sample, of all elements."""

    def unit(self, unit: str) -> str:
        """That of the output."""
        return unit

    def value(self, times: Numbers, seen: Numbers) -> Numbers:
        """max y."""
        return seen.max(axis=(0, 1))

    def weights(self, times: Numbers, seen: Numbers) -> Numbers:
        """1 at the largest sample."""
        return _mark_sample(seen, np.argmax)


@MEASURES.register("min")
class Smallest(Largest):
    """Smallest sample, of all elements."""

    def value(self, times: Numbers, seen: Numbers) -> Numbers:
        """min y."""
        return seen.min(axis=(0, 1))

    def weights(self, times: Numbers, seen: Numbers) -> Numbers:
        """1 at the smallest sample."""
        return _mark_sample(seen, np.argmin)


@MEASURES.register("stroke")
class Stroke(Largest):
    """Largest less smallest sample; without an output, of the first coordinate."""

    def unit(self, unit: str) -> str:
        """That of a difference."""
        return DEGREES if unit == "K" else unit

    def value(self, times: Numbers, seen: Numbers) -> Numbers:
        """max y − min y, the widest of several."""
        return np.ptp(seen, axis=1).max(axis=0)

    def weights(self, times: Numbers, seen: Numbers) -> Numbers:
        """1 at the largest and −1 at the smallest sample of the column that goes furthest."""
        found = np.zeros(seen.shape)
        runs = np.arange(seen.shape[2], dtype=np.intp)
        widest = np.ptp(seen, axis=1).argmax(axis=0)
        column = seen[widest, :, runs]
        found[widest, column.argmax(axis=1), runs] += 1.0
        found[widest, column.argmin(axis=1), runs] -= 1.0
        return found


@MEASURES.register("change")
class Change(Stroke):
    """Sample furthest from the first, less the first, with its sign; of several outputs the one that changes most."""

    def value(self, times: Numbers, seen: Numbers) -> Numbers:
        """y(t) − y(0) where it is largest in size."""
        column = self._choose_column(seen)
        return column[np.abs(column).argmax(axis=0), np.arange(column.shape[1], dtype=np.intp)]

    def weights(self, times: Numbers, seen: Numbers) -> Numbers:
        """1 at that sample and −1 at the first."""
        found, runs = np.zeros(seen.shape), np.arange(seen.shape[2], dtype=np.intp)
        most = np.abs(seen - seen[:, :1]).max(axis=1).argmax(axis=0)
        found[most, np.abs(self._choose_column(seen)).argmax(axis=0), runs] += 1.0
        found[most, 0, runs] -= 1.0
        return found

    def _choose_column(self, seen: Numbers) -> Numbers:
        """What the column that changes most has gone from its start, (samples, runs)."""
        gone = seen - seen[:, :1]
        return gone[np.abs(gone).max(axis=1).argmax(axis=0), :, np.arange(seen.shape[2], dtype=np.intp)].T


def _mark_sample(seen: Numbers, place: Callable[..., Any]) -> Numbers:
    """1 at one sample of every run."""
    found = np.zeros(seen.shape).reshape(-1, seen.shape[2])
    found[place(seen.reshape(found.shape), axis=0), np.arange(seen.shape[2])] = 1.0
    return found.reshape(seen.shape)


@MEASURES.register("at")
class At(AbstractMeasure):
    """Value at a time, between samples on a straight line; of several elements the largest."""

    time: Scalar = param("s", "when; the end if not given", low=0.0, default=math.inf)

    def unit(self, unit: str) -> str:
        """That of the output."""
        return unit

    def value(self, times: Numbers, seen: Numbers) -> Numbers:
        """y(t)."""
        return np.einsum("csr,csr->cr", self._shares(times, seen), seen).max(axis=0)

    def weights(self, times: Numbers, seen: Numbers) -> Numbers:
        """The shares of both neighbours, in the column that is largest."""
        shares = self._shares(times, seen)
        largest = np.einsum("csr,csr->cr", shares, seen).argmax(axis=0)
        return shares * (np.arange(len(seen))[:, None] == largest)[:, None, :]

    def _shares(self, times: Numbers, seen: Numbers) -> Numbers:
        when = min(self.time, float(times[-1])) if math.isinf(self.time) else self.time
        if when > times[-1] * (1.0 + 1e-12):
            raise ParameterError(
                f"`{self.registered_name}` looks at {when:.6g} s, but the run ends at {times[-1]:.6g} s."
            )
        found = np.maximum(1.0 - np.abs(times - when) / _measure_gaps(times, when), 0.0)
        return np.broadcast_to(found[None, :, None], seen.shape)


@MEASURES.register("final")
class Final(At):
    """Value at the end."""


def _measure_gaps(times: Numbers, when: float) -> float:
    """Length of the interval in which a time is [s]."""
    last = len(times) - 1
    place = min(max(int(np.searchsorted(times, when, side="right")), 1), last)
    return float(times[place] - times[place - 1])
