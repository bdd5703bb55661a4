"""A sized wire in a loop for a board: transistor, position sensor, PID control."""

from __future__ import annotations

import math

from martensite.app.messages import JsonTable
from martensite.base.files import toml_document
from martensite.base.toml_text import as_toml
from martensite.design.sizing.candidates import Candidate
from martensite.design.sizing.request import WireRequest

BAND = 0.1
"""Error with full voltage, as a fraction of the stroke."""
PERIODS = 200
"""Control periods in the heating time."""
STROKE_FRACTION = 0.9
"""Fraction of the requested stroke that a loop can hold from both sides."""


def format_loop(request: WireRequest, candidate: Candidate, text: str) -> str | None:
    """Return a candidate with its drive in a loop over most of the stroke; None without a cycle.

    The duty cycle is limited to the power of the pulse, (V/V_supply)², so the loop heats no faster than the sizing.
    Gains are a first guess: full duty cycle at an error of a tenth of the stroke, and the heating time as reset time.
    """
    cycle, drive = candidate.cycle, candidate.drive
    if cycle is None or drive is None or cycle.cooling is None:
        return None
    document: JsonTable = toml_document(text)
    del document["drive"]
    high = min(1.0, (drive.voltage / request.supply) ** 2)
    gain = high / (BAND * request.stroke)
    period = max(1e-3, round(cycle.heating / PERIODS, 3))
    cycles = 2.0 * (cycle.heating + cycle.cooling)
    document |= {
        "title": f"{document['title']}, in a loop",
        "driver": {"kind": "mosfet", "supply": f"{request.supply:.9g} V", "frequency": "1 kHz"},
        "sensor": {"kind": "position"},
        "controller": {
            "kind": "pid",
            "measured": "position",
            "period": f"{period:.4g} s",
            "Kp": round(gain, 3),
            "Ti": f"{cycle.heating:.4g} s",
            "high": round(high, 4),
        },
        "reference": {
            "kind": "pwm",
            "high": f"{1e3 * STROKE_FRACTION * request.stroke:.6g} mm",
            "frequency": f"{1.0 / cycles:.6g} Hz",
            "duty": 0.5,
        },
        "run": {"duration": f"{period * math.ceil(2.0 * cycles / period):.9g} s", "samples": 1001},
    }
    return as_toml(document)
