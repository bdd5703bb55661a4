"""Static curves with one place for their offset, and their free numbers in two kinds.

    y = offset + c(r)      with an offset
    y = c(r) - c(r_0)      without: 0 at zero input

r is the input on the scale of its range, r_0 that of zero. `heights` are numbers that the curve
is linear in, as all outputs are times a factor if they are; `places` say where along the input
something happens, and how wide it is.
"""

from __future__ import annotations

from abc import abstractmethod

from martensite.identify.blocks.base import AbstractStatic, Column, Numbers
from martensite.kernels import floats
from martensite.kernels.namespace import Namespace, Scalar


class AbstractCurve(AbstractStatic):
    """A static block from a curve c(r), which is linear in its heights."""

    def heights(self) -> tuple[str, ...]:
        """Return the names of the numbers that scale with the output."""
        return ()

    def places(self) -> tuple[str, ...]:
        """Return the names of the numbers of positions and widths."""
        return ()

    @abstractmethod
    def curve(self, xp: Namespace, heights: Column, places: Column, r: Scalar) -> Scalar:
        """c(r)."""

    @property
    def first(self) -> int:
        """Return the place of the first height: 1 behind an offset, else 0."""
        return int(self.offset == "yes")

    def numbers(self) -> tuple[str, ...]:
        """Return the offset, if it is free, then heights, then places."""
        return (*("offset",)[: self.first], *self.heights(), *self.places())

    def value(self, xp: Namespace, theta: Column, x: Scalar) -> Scalar:
        """Return the curve, moved to its offset or to 0 at zero input."""
        last = self.first + len(self.heights())
        heights, places = theta[self.first : last], theta[last:]
        made = self.curve(xp, heights, places, self.unit(x))
        if self.offset == "yes":
            return theta[0] + made
        return made - self.curve(xp, heights, places, self.unit(0.0))

    def scale_departure(self, departure: Numbers, factor: float) -> Numbers:
        """Return the places stay."""
        made = departure * factor
        last = len(made) - len(self.places())
        made[last:] = departure[last:]
        return made

    def offset_shown(self, theta: Numbers) -> list[tuple[str, float, str]]:
        """Return a row with the output at zero input."""
        zero = self.value(floats, [float(v) for v in theta], 0.0)
        return [("output at zero", float(zero), "1")]
