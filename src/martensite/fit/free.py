"""Free parameters: what may move, between which bounds, on which scale.

A search runs over numbers from 0 to 1, one per free parameter:

    linear        p = low + u (high - low)
    logarithmic   p = low (high/low)^u

The bounds are those asked for, else a box around the start inside what the declaration of the
parameter allows: 50 K to both sides of a temperature, the fifth to the fivefold of what has a
fixed sign, all that is declared where this is finite and holds a zero.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from martensite.actuators.assembly import AbstractSystem
from martensite.base import units
from martensite.base.errors import ParameterError, suggest_name
from martensite.base.parameters import Leaf

WARMER = 50.0
"""Half the width of a box of temperatures [K]."""
TIMES = 5.0
"""Box of a number of one sign: start / TIMES to start * TIMES."""
DECADES = 4.0
"""Ratio of bounds from which a positive number is searched on its logarithm."""


@dataclass(frozen=True)
class Wish:
    """A parameter that is asked to be free, by its path or an ending of it."""

    name: str
    low: float | None = None
    """Lower bound in SI; chosen if None."""
    high: float | None = None
    start: float | None = None
    """Where to begin, in SI; the value in the scenario if None."""


@dataclass(frozen=True)
class Free:
    """A number to be found."""

    name: str
    """As asked for, unique in a problem."""
    ending: str
    """Path, or ending of the paths of all parameters that take its value."""
    unit: str
    start: float
    low: float
    high: float
    logarithmic: bool = False
    record: str | None = None
    """The one experiment that has it for itself; None if it is common to all."""
    doc: str = ""

    def value(self, u: float) -> float:
        """The number [SI] at a share u of its range."""
        if self.logarithmic:
            return self.low * (self.high / self.low) ** u
        return self.low + u * (self.high - self.low)

    def share(self, value: float) -> float:
        """The inverse of `value`, limited to [0, 1]."""
        if self.logarithmic:
            u = math.log(value / self.low) / math.log(self.high / self.low)
        else:
            u = (value - self.low) / (self.high - self.low)
        return min(max(u, 0.0), 1.0)

    def slope(self, u: float) -> float:
        """d(value)/du [SI]."""
        if self.logarithmic:
            return self.value(u) * math.log(self.high / self.low)
        return self.high - self.low

    def moves(self, path: str) -> bool:
        """Whether a parameter of this path takes the value."""
        return path == self.ending or path.endswith("." + self.ending)


def free_parameters(
    wishes: Sequence[Wish], systems: Sequence[AbstractSystem], record: str | None = None
) -> list[Free]:
    """Free parameters of systems.

    Args:
        wishes: names with optional bounds and starts. A name may end several paths: they then
            move together, as one material of several wires does.
        systems: those in which the parameters are looked for; the first gives the start.
        record: the experiment that has these parameters for itself.

    Raises:
        ParameterError: an unknown name, bounds that are none, a start outside of them.
    """
    leaves = [leaf for system in systems for leaf in system.leaves()]
    return [_free(wish, leaves, record) for wish in wishes]


def _free(wish: Wish, leaves: Sequence[Leaf], record: str | None) -> Free:
    found = [x for x in leaves if x.path == wish.name or x.path.endswith("." + wish.name)]
    if not found:
        names = list(dict.fromkeys(x.path.rpartition(".")[2] for x in leaves))
        raise ParameterError(
            f"There is no parameter `{wish.name}` to be fitted. {suggest_name(wish.name, names)}"
        )
    first = found[0]
    start = first.value if wish.start is None else wish.start
    low, high = _bounds(wish, first, start)
    name = wish.name if record is None else f"{wish.name}@{record}"
    positive = low > 0.0 and high / low >= DECADES and first.declared.unit != "K"
    return Free(
        name, wish.name, first.declared.unit, start, low, high, positive, record,
        first.declared.doc,
    )  # fmt: skip


def _bounds(wish: Wish, leaf: Leaf, start: float) -> tuple[float, float]:
    low, high = _box(wish, leaf, start)
    least, most = leaf.declared.bounds
    low = low if wish.low is None else wish.low
    high = high if wish.high is None else wish.high
    if not (low < high and least <= low and high <= most):
        raise ParameterError(
            f"Bounds of the free parameter `{wish.name}` must rise and lie within what is "
            f"allowed ({leaf.declared.allowed()}), but are {_shown(low, leaf)} and "
            f"{_shown(high, leaf)}."
        )
    if not low <= start <= high:
        raise ParameterError(
            f"The fit starts with `{wish.name}` = {_shown(start, leaf)}, outside of its bounds "
            f"{_shown(low, leaf)} to {_shown(high, leaf)}; move the bounds or the start."
        )
    return low, high


def _box(wish: Wish, leaf: Leaf, start: float) -> tuple[float, float]:
    """Bounds where none are asked for."""
    if wish.low is not None and wish.high is not None:
        return wish.low, wish.high
    least, most = leaf.declared.bounds
    if leaf.declared.unit == "K":
        return max(start - WARMER, least), min(start + WARMER, most)
    if start != 0.0:
        ends = sorted((start / TIMES, start * TIMES))
        return max(ends[0], least), min(ends[1], most)
    if not (math.isfinite(least) and math.isfinite(most)):
        raise ParameterError(
            f"The free parameter `{wish.name}` is 0 and its declaration sets no bounds; "
            f"write them, such as `{wish.name}=low..high`."
        )
    return least, most


def _shown(value: float, leaf: Leaf) -> str:
    unit = units.choose_readable_unit(leaf.declared.unit)
    number = f"{units.from_si(value, unit, leaf.declared.unit):.6g}"
    return number if unit == "1" else f"{number} {unit}"
