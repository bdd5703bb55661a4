"""What every sensor says of a truth that has been the same for long, by its own equation.

Source of truth: the equations of the docstrings, written again.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import builders
import pytest
from builders import label

from martensite.control.sensors.base import SENSORS
from martensite.testing.sensors import change_sensor, choose_truth, find_deviation, record_readings, silence_sensor

EXAMPLES: list[Any] = builders.examples("sensor")
NUMBERS: dict[str, float] = {
    "gain_error": 0.03,
    "offset": 0.02,
    "bias": -0.3,
    "backlash": 0.0,
    "emissivity": 0.8,
    "setting": 0.9,
    "attachment": 0.7,
    "nonlinearity": 0.05,
    "lowest": 255.0,
    "highest": 410.0,
}
"""What makes every term of an equation count."""
STEADY: dict[str, Callable[[Any, list[float]], float]] = {
    "current": lambda s, y: (1.0 + s.gain_error) * y[0] + s.offset,
    "voltage": lambda s, y: (1.0 + s.gain_error) * y[0] + s.offset,
    "tilt": lambda s, y: (1.0 + s.gain_error) * y[0] + s.offset,
    "force": lambda s, y: (
        (1.0 + s.gain_error) * y[0] + s.offset + 4.0 * s.nonlinearity * y[0] * (1.0 - abs(y[0]) / s.range)
    ),
    "gyroscope": lambda s, y: s.bias,
    "ideal": lambda s, y: y[0],
    "position": lambda s, y: y[0] + s.offset,
    "encoder": lambda s, y: y[0] if s.zero == "mark" else 0.0,
    "resistance": lambda s, y: y[0] / y[1],
    "thermocouple": lambda s, y: y[1] + s.attachment * (y[0] - y[1]) + s.offset,
    "infrared": lambda s, y: infrared(s, y, s.factor * s.emissivity / s.setting),
}
"""Reading of what has been the same for long."""


def infrared(sensor: Any, truth: list[float], share: float) -> float:
    power = 1 if sensor.mixing == "linear" else 4
    return float((truth[1] ** power + share * (truth[0] ** power - truth[1] ** power)) ** (1 / power))


@pytest.mark.parametrize("sensor", EXAMPLES, ids=label)
def test_a_steady_reading_is_that_of_its_equation(sensor: Any) -> None:
    detailed = change_sensor(silence_sensor(sensor), **NUMBERS)
    expected = STEADY[sensor.registered_name](detailed, choose_truth(sensor))
    found = record_readings(detailed, choose_truth(sensor), 2)[-1]
    assert found == pytest.approx(expected, rel=1e-12, abs=0.5 * detailed.resolution + 1e-15)


def test_most_sensors_have_a_lag_a_range_and_noise() -> None:
    assert set(STEADY) == set(SENSORS.names())
    lagging = [s for s in EXAMPLES if "lag" in s.declarations]
    ranged = [s for s in EXAMPLES if s.limits() is not None]
    noisy = [s for s in EXAMPLES if find_deviation(s, choose_truth(s)) > 0.0]
    for some in (lagging, ranged, noisy):
        assert len({s.registered_name for s in some}) >= 5
