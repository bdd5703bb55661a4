"""Energies of a run for the bench: over time, and in all.

    E = ∫ P dt,   Q = ∫ Q̇ dt,   stored E − Q,   W = ∫ F dx where an element pulls

as `martensite.design.analysis.energy` has them. An element that is a straight wire, or several,
pulls by its own shortening L = −ε ℓ; others need a mechanism with one coordinate on a line.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from martensite.actuators.elements.base import AbstractElement
from martensite.actuators.elements.rows import AbstractRow
from martensite.actuators.elements.wire import Wire
from martensite.actuators.mechanisms.load_line import AbstractLoadLine
from martensite.app.messages import JsonTable
from martensite.app.views.columns import choose_rows
from martensite.design.analysis.energy import integrate_energies
from martensite.simulate.result import Result

PRESCRIBED = (
    "A drive that prescribes the temperature takes whatever energy it needs; there is no balance."
)
NO_ELEMENT = "Nothing is heated here, so there is no energy to be balanced."
NO_WORK = "The work is left out: this element does not say how far it pulls."


@dataclass(frozen=True)
class EnergyCourse:
    """One energy, over time."""

    key: str
    symbol: str
    long_name: str
    shown: str
    """Unit it is shown in."""
    factor: float
    values: list[float]
    """[J]"""


def describe_energy(result: Result) -> JsonTable:
    """Courses of the energies, efficiency over time, and what is not known, in a sentence."""
    actuators = result.system.actuators()
    if not actuators:
        return _describe_missing(NO_ELEMENT)
    if any(one.source.sets_temperature for one in actuators.values()):
        return _describe_missing(PRESCRIBED)
    ways = _list_ways(result)
    found = integrate_energies(result, ways or [])
    kept = choose_rows(len(result.times))
    stored = found.electrical - found.lost
    named: list[tuple[str, str, str, str, float, Any]] = [
        ("electrical", "E", "electrical energy in", "J", 1.0, found.electrical),
        ("lost", "Q", "heat to the surroundings", "J", 1.0, found.lost),
        ("stored", "E − Q", "stored in the elements", "J", 1.0, stored),
    ]
    if ways is not None:
        named += [
            ("work", "W", "work given while pulling", "mJ", 1e3, found.work),
            ("returned", "W_b", "work taken back while stretched", "mJ", 1e3, found.returned),
        ]
    courses = [
        EnergyCourse(key, symbol, words, unit, factor, [float(v) for v in values[kept]])
        for key, symbol, words, unit, factor, values in named
    ]
    share = np.divide(
        found.work, found.electrical, where=found.electrical > 0.0, out=np.full(len(stored), np.nan)
    )
    efficiency = None if ways is None else [float(v) for v in share[kept]]
    said = NO_WORK if ways is None else ""
    return {"courses": [vars(c) for c in courses], "efficiency": efficiency, "sentence": said}


def _describe_missing(sentence: str) -> JsonTable:
    return {"courses": [], "efficiency": None, "sentence": sentence}


def _list_ways(result: Result) -> list[tuple[Any, Any]] | None:
    """Force and way of every element; None if one is not known."""
    system, found = result.system, list[tuple[Any, Any]]()
    on_line = isinstance(system.mechanism, AbstractLoadLine)
    for port, actuator in system.actuators().items():
        force = np.asarray(result.columns[system.label(port, "force")])
        length = find_length(actuator.element)
        if on_line:
            found.append((force, np.asarray(result.columns[result.coordinate])))
        elif length is not None:
            strain = np.asarray(result.columns[system.label(port, "strain")])
            found.append((force, -length * strain))
        else:
            return None
    return found


def find_length(element: AbstractElement) -> float | None:
    """Elongation per strain [m] of straight wires; None for other elements."""
    if isinstance(element, AbstractRow):
        one = find_length(element.one)
        return None if one is None else one * float(element.behind())
    return float(element.length) if isinstance(element, Wire) else None
