"""Energies of a run for the bench: over time, and in all.

    E = ∫ P dt,   Q = ∫ Q̇ dt,   stored E − Q,   W = ∫ F dx where an element pulls

as `martensite.design.analysis.energy` has them.
"""

from __future__ import annotations

from typing import Any

from martensite.app.messages import JsonTable
from martensite.app.views.columns import choose_rows
from martensite.design.analysis.energy import find_ways, integrate_energies
from martensite.simulate.result import Result

PRESCRIBED = "A drive that prescribes the temperature takes whatever energy it needs; there is no balance."
NO_ELEMENT = "Nothing is heated here, so there is no energy to be balanced."
NO_WORK = "The work is left out: this element does not say how far it pulls."


def describe_energy(result: Result) -> JsonTable:
    """Courses of the energies, efficiency over time, and what is not known, in a sentence."""
    actuators = result.system.actuators()
    if not actuators:
        return _describe_missing(NO_ELEMENT)
    if any(one.source.sets_temperature for one in actuators.values()):
        return _describe_missing(PRESCRIBED)
    ways = find_ways(result)
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
        {
            "key": key,
            "symbol": symbol,
            "long_name": words,
            "shown": unit,
            "factor": factor,
            "values": values[kept].tolist(),
        }
        for key, symbol, words, unit, factor, values in named
    ]
    efficiency = None if ways is None else found.efficiency[kept].tolist()
    return {"courses": courses, "efficiency": efficiency, "sentence": NO_WORK if ways is None else ""}


def _describe_missing(sentence: str) -> JsonTable:
    return {"courses": [], "efficiency": None, "sentence": sentence}
