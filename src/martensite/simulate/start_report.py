"""Description of the start of a run: temperature, load, phases and assumed history."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import chain
from typing import TYPE_CHECKING, Any

import numpy as np

from martensite.actuators.elements.base import AbstractElement
from martensite.base.formats import typeset_unit, write_quantity
from martensite.kernels import floats
from martensite.physics.laws.base import SHELF_TIME, Fractions
from martensite.simulate.restarts import Restart

if TYPE_CHECKING:
    from martensite.simulate.result import Result

HOT = 1500.0
"""Temperature [K] above all transformation temperatures, for a comparison by cooling."""
APART = 0.005
"""Smallest reported difference of two martensite fractions [-]."""
SHOWN = ("temperature", "stress", "martensite_fraction")


def describe_start(begin: Restart, result: Result) -> str:
    """Describe the start of a single run; empty without shape-memory elements.

    Args:
        begin: initial state; `HOME` if the run found its start.
        result: the run.
    """
    names = _name_shown(result)
    if not names:
        return ""
    temperatures, stresses, fractions = ([float(result[name][0]) for name in row] for row in names)
    where = f"{_write_range(temperatures, 'K')} and {_write_range(stresses, 'Pa')}"
    phases = f"martensite fraction {_write_fractions(fractions)}"
    if begin.passes:
        origin = f"kept by an earlier run at {begin.time:.6g} s" if begin.time else "given, or found, as the start"
        return f"Start: the state {origin}, at {where} ({phases})."
    elements = _list_elements(result)
    given = [min(_list_numbers(one, "initial_fraction"), default=1.0) for one in elements]
    if max(given) < 1.0 and given == fractions:
        return f"Start: as given, at {where} ({phases})."
    cooled = list(_cool_elements(elements, stresses, temperatures)) if max(fractions) > 0.0 else []
    if cooled and max(abs(a - b) for a, b in zip(cooled, fractions, strict=True)) > APART:
        phases = f"{phases}; {_write_fractions(cooled)} if cooled from austenite"
    return f"Start: in equilibrium at {where}, {_name_history(elements)} ({phases})."


def describe_batch_start(result: Result) -> str:
    """Describe the starts of a batch as ranges; empty without shape-memory elements."""
    names, variants = _name_shown(result), result.variants
    if not names or variants is None:
        return ""
    count = len(variants)
    temperatures, stresses, fractions = (
        np.ravel([np.broadcast_to(result[name], (count, len(result.times)))[:, 0] for name in row]).tolist()
        for row in names
    )
    where = f"{_write_range(temperatures, 'K')} and {_write_range(stresses, 'Pa')}"
    elements = _list_elements(result)
    given = any(path.endswith("initial_fraction") for path in variants.over)
    given = given or any(share < 1.0 for one in elements for share in _list_numbers(one, "initial_fraction"))
    how = "as given" if given else f"in equilibrium, {_name_history(elements)}"
    return f"Start of {len(variants)} variants: {how}, at {where} (martensite fraction {_write_fractions(fractions)})."


def _name_shown(result: Result) -> list[list[str]]:
    """Return the columns that describe a start, by quantity and element; empty if there are none or one is missing."""
    system = result.system
    names = [[system.label(port, name) for port in system.actuators()] for name in SHOWN]
    return names if all(names) and result.columns.keys() >= set(chain.from_iterable(names)) else []


def _list_elements(result: Result) -> list[AbstractElement]:
    return [one.element for one in result.system.actuators().values()]


def _name_history(elements: Sequence[AbstractElement]) -> str:
    """Return the history that a start in equilibrium assumes."""
    oriented = all(share == 1.0 for one in elements for share in _list_numbers(one, "initial_oriented"))
    return "warmed from trained martensite" if oriented else "warmed from martensite"


def _list_numbers(element: AbstractElement, name: str) -> list[float]:
    """Return all values of a parameter in an element."""
    return [leaf.value for leaf in element.leaves() if leaf.path.rpartition(".")[2] == name]


def _cool_elements(
    elements: Sequence[AbstractElement], stresses: Sequence[float], temperatures: Sequence[float]
) -> Iterator[float]:
    """Return martensite fractions after cooling from austenite, for elements with one phase state."""
    if not all(getattr(one, "uniform", True) and getattr(one, "wear", None) is None for one in elements):
        return
    for one, stress, temperature in zip(elements, stresses, temperatures, strict=True):
        law: Any = one.law
        hot = law.init(floats, Fractions(0.0, 0.0), stress, temperature if law.rate_dependent else HOT)
        yield law.kinetics(floats, hot, stress, temperature, SHELF_TIME)[1].martensite


def _write_range(values: Sequence[float], unit: str) -> str:
    """Return a value, or the range of several, in a readable unit."""
    ends = [write_quantity(end, unit, 4).partition(" ") for end in (min(values), max(values))]
    (low, _, label), (high, _, same) = ends
    if label != same:
        return " to ".join(f"{number} {typeset_unit(name)}" for number, _, name in ends)
    return f"{low if low == high else f'{low} to {high}'} {typeset_unit(label)}"


def _write_fractions(values: Sequence[float]) -> str:
    """Return a martensite fraction, or the range of several."""
    low, high = f"{min(values):.3f}", f"{max(values):.3f}"
    return low if low == high else f"{low} to {high}"
