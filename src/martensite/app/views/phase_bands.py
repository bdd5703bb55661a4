"""The phase diagram of the bench: transformation bands of every law that is run.

`{"diagrams": [{"bands": […], "highest": Pa, "sentence": ""}], "ports": {port: {diagram, x, y}}}`
with the number of the diagram of a port and the columns of its path.
"""

from __future__ import annotations

import math
from dataclasses import asdict
from functools import lru_cache

from martensite.app.messages import JsonTable
from martensite.base.errors import MartensiteError
from martensite.physics.laws.base import AbstractLaw
from martensite.show.figures.phase_diagram import LEAST_STRESS, Band, find_bands
from martensite.simulate.result import Result
from martensite.simulate.transformation_points import find_isobar

HEADROOM = 1.12
"""The diagram reaches so far beyond the highest stress of the run."""
STRESSES, TEMPERATURES = 100e6, 10.0
"""Limits are rounded outwards to multiples of these [Pa], [K]: a slider asks for the same ones."""
NO_LINES = "This law has no transformation lines in the plane of temperature and stress."


def describe_phase(result: Result) -> JsonTable:
    """Bands of the laws of a run; actuators with the same law share a diagram."""
    laws: dict[AbstractLaw, int] = {}
    ports: dict[str, JsonTable] = {}
    highest, coldest = _find_limits(result)
    for port, actuator in result.system.actuators().items():
        ports[port] = {
            "diagram": laws.setdefault(actuator.element.law, len(laws)),
            "x": result.system.label(port, "temperature"),
            "y": result.system.label(port, "stress"),
        }
    return {"diagrams": [_describe_diagram(law, highest, coldest) for law in laws], "ports": ports}


def _find_limits(result: Result) -> tuple[float, float]:
    """Highest stress [Pa] and lowest temperature [K] of the diagrams, rounded outwards."""
    system = result.system
    ports = list(system.actuators())
    stress = max((max(result[system.label(p, "stress")]) for p in ports), default=0.0)
    cold = min((min(result[system.label(p, "temperature")]) for p in ports), default=300.0)
    highest = STRESSES * math.ceil(max(LEAST_STRESS, HEADROOM * stress) / STRESSES)
    return highest, TEMPERATURES * math.floor((cold - 8.0) / TEMPERATURES)


def _describe_diagram(law: AbstractLaw, highest: float, coldest: float) -> JsonTable:
    try:
        found = _find_bands(law, highest, coldest)
    except MartensiteError as error:
        return {"bands": [], "highest": highest, "sentence": str(error)}
    said = "" if found else NO_LINES
    return {"bands": [asdict(band) for band in found], "highest": highest, "sentence": said}


@lru_cache(maxsize=64)
def _find_bands(law: AbstractLaw, highest: float, coldest: float) -> list[Band]:
    return find_bands(law, highest, min(coldest, find_isobar(law).M_f - 15.0))
