"""Order constraints of parameters, such as M_f below M_s and A_s below A_f, kept by construction.

A search runs over places v from 0 to 1. The value u, as a fraction of its range, is

    u_i = a_i + v_i (b_i - a_i),   a_i = max(low_i, x_k + gap),   b_i = min(high_i, b_k - gap)

The ends a and b leave space for the parameters below and above. Without an order, u is v.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from martensite.base.errors import ParameterError
from martensite.fit.experiment import Experiment
from martensite.physics.laws.base import AbstractLaw
from martensite.search.free_numbers import FreeNumber
from martensite.search.quantity_text import format_quantity

if TYPE_CHECKING:
    from martensite.fit.evaluation import Evaluation

INSIDE = 0.1
"""Fraction of the allowed interval by which a start out of order is moved inside."""
GAP = 1e-4
"""Least distance of two ordered parameters, as a fraction of the range of the upper parameter."""


class NumberOrder(NamedTuple):
    """Order of two parameters; a fixed parameter is given by its value."""

    below: int | float
    """Index of the free parameter, or a value [SI]."""
    above: int | float


def list_orders(free: Sequence[FreeNumber], experiments: Sequence[Experiment]) -> list[NumberOrder]:
    """Return the orders that the laws of all experiments declare and that involve a free parameter."""
    orders: dict[NumberOrder, None] = {}
    for one in experiments:
        values = {leaf.path: float(leaf.value) for leaf in one.system.leaves()}
        acting = [(i, x) for i, x in enumerate(free) if x.record in (None, *one.labels)]
        for places in _list_ordered(one, values):
            if not any(x.base and any(map(x.moves, places)) for _, x in acting):  # else in order by itself
                movers = [_find_mover(acting, path, values[path]) for path in places]
                if any(isinstance(end, int) for end in movers):
                    orders[NumberOrder(*movers)] = None
    return list(orders)


def _list_ordered(one: Experiment, values: Mapping[str, float]) -> Iterator[tuple[str, str]]:
    """Yield the paths of two values of an experiment, the smaller value first."""
    laws = [part for part in one.system.tree() if isinstance(part, AbstractLaw)]
    for low, high in dict.fromkeys(pair for law in laws for pair in law.orders):
        for path in values:
            other = path.removesuffix(low) + high
            if path.rpartition(".")[2] == low and other in values:
                yield path, other


def _find_mover(acting: Sequence[tuple[int, FreeNumber]], path: str, value: float) -> int | float:
    """Return the free parameter that moves a path, a separate before a common parameter; otherwise its value."""
    movers = sorted((i for i, x in acting if x.moves(path)), key=lambda i: dict(acting)[i].record is None)
    return movers[0] if movers else value


class OrderedNumbers:
    """Map from places to fractions of ranges, and its inverse."""

    def __init__(self, free: Sequence[FreeNumber], orders: Sequence[NumberOrder]) -> None:
        """Find the space that each parameter must leave for others.

        Raises:
            ParameterError: the bounds leave no space.
        """
        self.free, count = free, len(free)
        self.below: list[list[int]] = [[] for _ in range(count)]
        self.lowest, self.highest = [one.low for one in free], [one.high for one in free]
        for low, high in orders:
            if isinstance(low, int) and isinstance(high, int):
                self.below[high].append(low)
            elif isinstance(high, int):
                self.lowest[high] = max(self.lowest[high], low + self._gap(high))
            elif isinstance(low, int):
                self.highest[low] = min(self.highest[low], high - self._gap(low))
        self.sequence = sorted(range(count), key=self._count_below)
        for i in reversed(self.sequence):
            for k in self.below[i]:
                self.highest[k] = min(self.highest[k], self.highest[i] - self._gap(i))
        for i in range(count):
            if self.active and not self.lowest[i] < self.highest[i]:
                name, end = free[i].name, format_quantity(self.highest[i], free[i].unit)
                raise ParameterError(
                    f"Bounds leave no room for `{name}`: it must be below {end}, for what its law wants above it; "
                    "move the bounds."
                )

    @property
    def active(self) -> bool:
        """Return whether any order concerns the free parameters."""
        ends = [(one.low, one.high) for one in self.free]
        return any(self.below) or ends != list(zip(self.lowest, self.highest, strict=True))

    def find_shares(self, places: Any) -> Any:
        """Return the fractions u (free,) of places v (free,)."""
        return self._walk(np.asarray(places, float))[0]

    def find_slopes(self, places: Any) -> Any:
        """Return the derivatives du/dv (free, free)."""
        return self._walk(np.asarray(places, float))[1]

    def find_places(self, shares: Any, inside: float = 0.0) -> Any:
        """Return the places v of fractions u.

        A value out of order moves to the nearest end, or by the fraction `inside` of the interval from it.
        """
        places = np.asarray(shares, float).copy()
        if not self.active:
            return places
        ordered_shares = np.zeros(len(places))
        for i in self.sequence:
            low, high, _ = self._find_ends(i, ordered_shares)
            place = (shares[i] - low) / (high - low) if high > low else 0.0
            places[i] = place if 0.0 <= place <= 1.0 else inside if place < 0.0 else 1.0 - inside
            ordered_shares[i] = low + places[i] * (high - low)
        return places

    def repair(self, shares: Any) -> Any:
        """Return the fractions in order; values out of order move inside by a tenth of their interval."""
        return self.find_shares(self.find_places(shares, INSIDE)) if self.active else np.asarray(shares, float)

    def turn_slopes(self, evaluation: Evaluation, places: Any) -> Evaluation:
        """Return an evaluation with derivatives with respect to places."""
        return (
            replace(evaluation, jacobian=evaluation.jacobian @ self.find_slopes(places)) if self.active else evaluation
        )

    def _walk(self, places: Any) -> tuple[Any, Any]:
        if not self.active:
            return places, np.eye(len(places))
        shares, slopes = np.zeros(len(places)), np.zeros((len(places), len(places)))
        for i in self.sequence:
            low, high, lower = self._find_ends(i, shares)
            shares[i] = low + places[i] * (high - low)
            slopes[i, i] = high - low
            if lower is not None:
                ratio = self.free[lower].slope(float(shares[lower])) / self.free[i].slope(low)
                slopes[i] += (1.0 - places[i]) * ratio * slopes[lower]
        return shares, slopes

    def _find_ends(self, i: int, shares: Any) -> tuple[float, float, int | None]:
        """Return the ends of a parameter as fractions, and the parameter below that sets its lower end."""
        free, least, lower = self.free[i], self.lowest[i], None
        for k in self.below[i]:
            value = self.free[k].value(float(shares[k])) + self._gap(i)
            if value > least:
                least, lower = value, k
        return free.share(least), free.share(max(self.highest[i], least)), lower

    def _gap(self, i: int) -> float:
        return GAP * (self.free[i].high - self.free[i].low)

    def _count_below(self, i: int) -> float:
        """Return the length of the longest chain of parameters below a parameter."""
        return max((1.0 + self._count_below(k) for k in self.below[i]), default=0.0)
