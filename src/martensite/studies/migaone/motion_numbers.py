"""Numbers of the motion: the response to the sine, and the actuation time.

The figures of the paper are unavailable and the amplitude is not stated, so the sine is only reported.
"""

from __future__ import annotations

from typing import Any

from martensite.studies.migaone import bench
from martensite.studies.tables import Printed

ROOM = 25.0
"""Ambient temperature of actuation times [°C]."""
TABLED_70 = {"A_s": 68.0, "A_f": 78.0, "M_s": 52.0, "M_f": 42.0}
"""Transformation temperatures of a 70 °C wire in the maker's table [°C]."""


def compute_motion(printed: Printed) -> dict[str, Any]:
    """Return sine, then actuation times."""
    responses = {key: bench.read_response(key, printed) for key in bench.VARIANTS}
    return {
        "sines": [row for key, response in responses.items() for row in _list_response(key, response)],
        "sine_late_return": responses["polynomial"].fall - responses["paper"].fall,
        "sine_early_return": responses["paper"].fall - responses["one-curve"].fall,
        "room": ROOM,
        "time_here": bench.actuation_time(printed, printed.ambient),
        "actuation_time_fastest": fastest_time(printed),
        "actuation_time_slowest": slowest_time(printed),
        "actuation_time_thin": thin_wire_time(printed, printed.ambient),
    }


def _list_response(key: str, response: bench.SineResponse) -> list[dict[str, Any]]:
    rows = (
        ("hottest", "highest temperature", response.hottest, "degC"),
        ("rise", "half of 8 mm reached on heating", response.rise, "s"),
        ("fall", "half of 8 mm passed on cooling", response.fall, "s"),
        ("stroke", "stroke", 1e3 * response.stroke, "mm"),
    )
    shared = {"key": key, "variant": bench.VARIANTS[key]}
    names = ("name", "words", "value", "unit")
    return [shared | dict(zip(names, row, strict=True)) for row in rows]


def fastest_time(printed: Printed) -> float:
    """Return the actuation time of a 70 °C wire at its tabled temperatures, with the paper's heat capacity [s]."""
    stress = bench.read_number("mass") * bench.read_number("gravity") / bench.base_wire().section()
    shift = stress / bench.read_number("C_A")
    at_zero_stress = {name: t + bench.ZERO - shift for name, t in TABLED_70.items()}
    values = {**at_zero_stress, "heat_capacity": printed.heat_capacity, "latent_heat": 0.0}
    return bench.actuation_time(printed, ROOM, tuple(values.items()))


def slowest_time(printed: Printed) -> float:
    """Return the actuation time of this study's wire at room temperature [s]."""
    return bench.actuation_time(printed, ROOM)


def thin_wire_time(printed: Printed, ambient: float) -> float:
    """Return the actuation time of the wire of Table 1, at the same stress [s]."""
    ratio = printed.diameter / bench.base_wire().diameter
    values = (("diameter", printed.diameter), ("mass", bench.read_number("mass") * ratio**2))
    return bench.actuation_time(printed, ambient, values, duration=0.05)
