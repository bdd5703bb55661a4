"""Static curves with an optional offset, and two kinds of free numbers.

    y = offset + c(r)      with an offset
    y = c(r) - c(r_0)      without: 0 at zero input

r is the input on the scale of its range, r_0 is r at zero input. The curve is linear in its `heights`; `places` are
positions and widths along the input.
"""

from __future__ import annotations

from abc import abstractmethod
from typing import Any

import numpy as np

from martensite.identify.blocks.base import AbstractStatic, Column, Numbers
from martensite.kernels import floats
from martensite.kernels.namespace import Namespace, Scalar


class AbstractCurve(AbstractStatic):
    """A static block of a curve c(r) that is linear in its heights."""

    def heights(self) -> tuple[str, ...]:
        """Return the names of the numbers that scale with the output."""
        return ()

    def places(self) -> tuple[str, ...]:
        """Return the names of positions and widths."""
        return ()

    @abstractmethod
    def curve(self, xp: Namespace, heights: Column, places: Column, r: Scalar) -> Scalar:
        """Return c(r)."""

    @property
    def first(self) -> int:
        """Return the place of the first height."""
        return int(self.offset == "yes")

    def numbers(self) -> tuple[str, ...]:
        return (*("offset",)[: self.first], *self.heights(), *self.places())

    def value(self, xp: Namespace, theta: Column, x: Scalar) -> Scalar:
        last = self.first + len(self.heights())
        heights, places = theta[self.first : last], theta[last:]
        output = self.curve(xp, heights, places, self.unit(x))
        if self.offset == "yes":
            return theta[0] + output
        return output - self.curve(xp, heights, places, self.unit(0.0))

    def scale_departure(self, departure: Numbers, factor: float) -> Numbers:
        scaled = departure * factor
        last = len(scaled) - len(self.places())
        scaled[last:] = departure[last:]
        return scaled

    def join_numbers(self, level: float, *others: Any) -> Numbers:
        """Return free numbers with the first one, if there is an offset, and the others."""
        return np.concatenate([[level][: self.first], *others])

    def describe_knots(self, theta: Numbers, knots: Numbers) -> list[tuple[str, float, str]]:
        """Return rows with the inputs at knots and the outputs there."""
        numbers, rows = [float(v) for v in theta], list[tuple[str, float, str]]()
        for i, knot in enumerate(map(float, knots), start=1):
            rows += [(f"knot{i}", knot, "1"), (f"output{i}", float(self.value(floats, numbers, knot)), "1")]
        return rows

    def offset_shown(self, theta: Numbers) -> list[tuple[str, float, str]]:
        """Return a row with the output at zero input."""
        zero = self.value(floats, [float(v) for v in theta], 0.0)
        return [("output at zero", float(zero), "1")]
