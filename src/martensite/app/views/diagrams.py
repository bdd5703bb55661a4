"""The phase diagram of a run, and its energies over time.

`{"diagrams": [{"bands": […], "highest": Pa, "sentence": ""}], "ports": {port: {diagram, x, y}}}` with the index of the
diagram of a port and the columns of its path. Energies are those of `martensite.simulate.energy`:

    E = ∫ P dt,   Q = ∫ Q̇ dt,   stored E − Q,   W = ∫ F dx where an element pulls
"""

from __future__ import annotations

import math
from dataclasses import asdict
from functools import lru_cache
from typing import Any

from martensite.actuators.assembly import AbstractSystem
from martensite.app.messages import JsonTable
from martensite.app.views.columns import choose_curve_rows
from martensite.app.views.formulas import Formulas, rebuild_recorded
from martensite.base.errors import MartensiteError
from martensite.base.parameters import describe_structure
from martensite.physics.laws.base import AbstractLaw
from martensite.show.figures.phase_diagram import CRITICAL, LEAST_STRESS, SHIFTED, Band, confirm_lines, find_bands
from martensite.show.summaries.run import ENERGIES
from martensite.simulate.curve_rows import add_step_rows
from martensite.simulate.energy import find_ways, integrate_energies
from martensite.simulate.result import Result
from martensite.simulate.transformation_points import find_isobar

PRESCRIBED = "A prescribed temperature has no energy balance."
NO_ELEMENT = "No element is heated, so there is no energy balance."
NO_WORK = "The work is unknown: this element does not report its elongation."
HEADROOM = 1.12
"""Upper end of the diagram, relative to the highest stress of the run."""
STRESSES, TEMPERATURES = 100e6, 10.0
"""Steps of the rounded limits [Pa], [K], so that a slider reuses diagrams."""
COLDER = 15.0
"""Margin of a diagram below the finish of the transformation [K]."""
COURSE = "symbol", "long_name", "display_unit", "factor"
NO_LINES = "This law has no transformation lines in the plane of temperature and stress."


def describe_energy(result: Result) -> JsonTable:
    """Return energies and efficiency over time, or a sentence without them."""
    actuators = result.system.actuators()
    if not actuators:
        return _describe_missing(NO_ELEMENT)
    if any(one.source.sets_temperature for one in actuators.values()):
        return _describe_missing(PRESCRIBED)
    result = add_step_rows(result)
    ways = find_ways(result)
    energies = integrate_energies(result, ways or [])
    rows = choose_curve_rows(result)
    values = {"electrical": energies.electrical, "lost": energies.lost, "stored": energies.electrical - energies.lost}
    if ways is not None:
        values |= {"work": energies.work, "returned": energies.returned}
    courses = [
        {"key": key, **dict(zip(COURSE, ENERGIES[key], strict=True)), "values": one[rows].tolist()}
        for key, one in values.items()
    ]
    efficiency = None if ways is None else energies.efficiency[rows].tolist()
    return {"courses": courses, "efficiency": efficiency, "sentence": NO_WORK if ways is None else ""}


def _describe_missing(sentence: str) -> JsonTable:
    return {"courses": [], "efficiency": None, "sentence": sentence}


def _find_limits(result: Result) -> tuple[float, float]:
    """Return the highest stress [Pa] and lowest temperature [K] of the diagrams, rounded outwards."""
    system = result.system
    ports = list(system.actuators())
    stress = max((result.find_range(system.label(p, "stress"))[1] for p in ports), default=0.0)
    cold = min((result.find_range(system.label(p, "temperature"))[0] for p in ports), default=300.0)
    highest = STRESSES * math.ceil(max(LEAST_STRESS, HEADROOM * stress) / STRESSES)
    return highest, TEMPERATURES * math.floor((cold - 8.0) / TEMPERATURES)


def _describe_diagram(law: AbstractLaw, highest: float, coldest: float) -> JsonTable:
    try:
        bands = _find_bands(law, highest, coldest)
    except MartensiteError as error:
        return {"bands": [], "highest": highest, "sentence": str(error)}
    remark = "" if bands else NO_LINES
    return {"bands": [asdict(band) for band in bands], "highest": highest, "sentence": remark}


@lru_cache(maxsize=64)
def _find_bands(law: AbstractLaw, highest: float, coldest: float) -> list[Band]:
    return find_bands(law, highest, min(coldest, _find_finish(law) - COLDER))


def _find_finish(law: AbstractLaw) -> float:
    """Return M_f [K], a parameter or from an isobar."""
    leaves = {leaf.path: leaf.value for leaf in law.leaves()}
    return leaves["M_f"] if "M_f" in leaves else find_isobar(law).M_f


def describe_lines(whole: AbstractSystem, result: Result) -> JsonTable:
    """Return the description of the lines of the law at each port.

    `numbers` are formulas of the parameters of the law, by name. For the `kind` strips or detwinning they give the
    lines; other lines come from simulated isobars for the given `values`.
    """
    table = Formulas()
    recorded = rebuild_recorded(whole, table).actuators()
    limits, structures = _find_limits(result), dict[Any, int]()
    ports: list[JsonTable] = []
    numbers: dict[str, JsonTable] = {}
    for port, actuator in result.system.actuators().items():
        law: AbstractLaw = actuator.element.law
        values = {leaf.path: leaf.value for leaf in law.leaves()}
        numbers[port] = {leaf.path: leaf.value for leaf in recorded[port].element.law.leaves()}
        kind = _find_kind(law, values)
        ports.append(
            {
                "port": port,
                "x": result.system.label(port, "temperature"),
                "y": result.system.label(port, "stress"),
                "structure": structures.setdefault(describe_structure(law), len(structures)),
                "kind": kind,
                "driven": {**_describe_diagram(law, *limits), "values": values} if kind == "driven" else None,
            }
        )
    return table.collect(numbers=numbers) | {"ports": ports}


def _find_kind(law: AbstractLaw, values: dict[str, float]) -> str:
    try:
        if all(name in values for name in SHIFTED) and confirm_lines(law, values):
            return "detwinning" if all(name in values for name in CRITICAL) else "strips"
    except MartensiteError:  # the diagram shows it
        pass
    return "driven"
