"""Readable outputs and units of steady states and response curves."""

from __future__ import annotations

from typing import Any

import numpy as np

from martensite.base import units
from martensite.signals.sampling.sampled import Numbers
from martensite.simulate.steady.rotations import ResponseCurve


def convert_speed(speed: Any, unit: str) -> Any:
    """Return the speed of a rotor [rad/s], a number or an array, in a unit."""
    return speed / (2.0 * np.pi) if unit == "Hz" else speed * (60.0 / (2.0 * np.pi) if unit == "rpm" else 1.0)


def choose_output(curve: ResponseCurve) -> str:
    """Return the first oscillating judged output, for a display of its amplitude."""
    judged = curve.motion.stretch.system.convergence_scales()
    swings = [name for name in judged if name in curve.amplitude and "speed" not in name and curve.units[name] != "K"]
    return swings[0] if swings else next(iter(curve.amplitude))


def list_readable(values: Numbers, unit: str) -> tuple[Numbers, str]:
    """Return the values in a readable unit, and the unit."""
    readable_unit = units.choose_readable_unit(unit)
    return np.array([units.from_si(float(v), readable_unit, unit) for v in values]), readable_unit
