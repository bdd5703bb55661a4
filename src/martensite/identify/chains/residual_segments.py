"""A record in stretches of equal length: where the errors are."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from martensite.identify.blocks.base import Numbers

COUNT = 10
"""Stretches of a record."""


@dataclass(frozen=True)
class ErrorStretch:
    """Errors of one output from one time to another."""

    output: str
    begin: float
    """[s]"""
    end: float
    """[s]"""
    rms: float
    largest: float
    """Largest error, whatever its sign."""

    def to_dict(self) -> dict[str, Any]:
        """All fields by name, for JSON."""
        return asdict(self)


def summarise_segments(times: Numbers, residuals: Numbers, output: str, count: int = COUNT) -> list[ErrorStretch]:
    """Errors in stretches of equal length, without those in which nothing is known."""
    found: list[ErrorStretch] = []
    for t, e in zip(np.array_split(times, count), np.array_split(residuals, count), strict=True):
        known = e[np.isfinite(e)]
        if len(known):
            size, largest = float(np.sqrt(np.mean(known**2))), float(np.max(np.abs(known)))
            found.append(ErrorStretch(output, float(t[0]), float(t[-1]), size, largest))
    return found


def known_stretch(values: Numbers) -> slice:
    """The longest run of finite values."""
    known = np.concatenate([[False], np.isfinite(values), [False]]).astype(int)
    edges = np.flatnonzero(np.diff(known))
    begins, ends = edges[::2], edges[1::2]
    if not len(begins):
        return slice(0, 0)
    top = int(np.argmax(ends - begins))
    return slice(int(begins[top]), int(ends[top]))
