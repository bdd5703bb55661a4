"""Largest and smallest samples, and what lies between them."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from martensite.base.units import DEGREES
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


def _mark_sample(seen: Numbers, place: Callable[..., Any]) -> Numbers:
    """1 at one sample of every run."""
    found = np.zeros(seen.shape).reshape(-1, seen.shape[2])
    found[place(seen.reshape(found.shape), axis=0), np.arange(seen.shape[2])] = 1.0
    return found.reshape(seen.shape)
