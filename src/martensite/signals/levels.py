"""Typical levels of signals and readings, by SI unit.

All are assumed values for a small actuator, used in forms and to try parts.
"""

from martensite.base.parameters import ByUnit

HIGH = ByUnit(
    {
        "V": "2 V",
        "A": "0.5 A",
        "W": "1 W",
        "K": "120 degC",
        "K/s": "5 K/s",
        "1": 0.2,
        "m": "2 mm",
        "m/s": "5 mm/s",
        "rad": "10 deg",
        "rad/s": "20 deg/s",
        "N": "2 N",
        "Pa": "100 MPa",
        "ohm": "0.2 ohm",
        "delta_degC": "5 K",
    }
)
"""Upper level."""
INCREMENT = ByUnit(HIGH | {"V": "0.5 V", "A": "0.1 A", "W": "0.25 W", "K": "10 K", "1": 0.05, "m": "1 mm"})
"""Step of a staircase."""
TARGET_LEVEL = ByUnit(HIGH | {"V": "1 V", "A": "0.25 A", "W": "0.5 W", "1": 0.1})
"""Levels that bring an actuator near its target."""
MARGIN = ByUnit(HIGH | {"K": "5 K"})
"""Significant differences."""
SAMPLES = ByUnit(
    {unit: (zero, high, high, zero) for unit, high in HIGH.items() for zero in [0.0 if unit == "1" else f"0 {unit}"]}
    | {"K": ("30 degC", "120 degC", "120 degC", "30 degC")}
)
"""Four samples: low, high, high, low."""
