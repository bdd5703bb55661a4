"""Every registered sensor keeps the promises of its interface, and each check can fail.

Sources of truth: the equations of the docstrings for a truth that has been the same for long, the
closed form of a lag, and the statistics of normal numbers. That kernels mean the same on floats,
arrays, JAX and in C is checked with those of all other parts (`test_runtimes_agree`).
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import builders
import numpy as np
import pytest
from builders import label
from hypothesis import given, settings
from hypothesis import strategies as st
from kernels import TRUTHS

from martensite.base import units
from martensite.control.sensors.base import SENSORS, simulate_readings
from martensite.control.sensors.current import CurrentSensor
from martensite.kernels import floats

EXAMPLES: list[Any] = builders.examples("sensor")
MANY = 4000
NOISES = ("noise", "relative_noise")
NUMBERS: dict[str, float] = {
    "gain_error": 0.03, "offset": 0.02, "bias": -0.3, "backlash": 0.0, "emissivity": 0.8,
    "setting": 0.9, "attachment": 0.7, "nonlinearity": 0.05, "lowest": 255.0, "highest": 400.0,
}  # fmt: skip
"""What makes every term of an equation count."""
STEADY: dict[str, Callable[[Any, list[float]], float]] = {
    "current": lambda s, y: (1.0 + s.gain_error) * y[0] + s.offset,
    "voltage": lambda s, y: (1.0 + s.gain_error) * y[0] + s.offset,
    "tilt": lambda s, y: (1.0 + s.gain_error) * y[0] + s.offset,
    "force": lambda s, y: (
        (1.0 + s.gain_error) * y[0] + s.offset
        + 4.0 * s.nonlinearity * y[0] * (1.0 - abs(y[0]) / s.range)
    ),
    "gyroscope": lambda s, y: s.bias,
    "ideal": lambda s, y: y[0],
    "position": lambda s, y: y[0] + s.offset,
    "encoder": lambda s, y: y[0] if s.zero == "mark" else 0.0,
    "resistance": lambda s, y: y[0] / y[1],
    "thermocouple": lambda s, y: y[1] + s.attachment * (y[0] - y[1]) + s.offset,
    "infrared": lambda s, y: infrared(s, y, s.factor * s.emissivity / s.setting),
}  # fmt: skip
"""Reading of what has been the same for long."""


def infrared(sensor: Any, truth: list[float], share: float) -> float:
    power = 1 if sensor.mixing == "linear" else 4
    return float(
        (truth[1] ** power + share * (truth[0] ** power - truth[1] ** power)) ** (1 / power)
    )


def changed(sensor: Any, **numbers: float) -> Any:
    """A sensor with those of the numbers that it has."""
    return sensor.with_parts(**{n: v for n, v in numbers.items() if n in sensor.declarations})


def quiet(sensor: Any, **numbers: float) -> Any:
    """Without noise, and without rounding where that is declared."""
    return changed(sensor, **dict.fromkeys((*NOISES, "resolution"), 0.0), **numbers)


def usual(sensor: Any, share: float = 0.6) -> list[float]:
    """A truth well within its range."""
    return [low + share * (high - low) for low, high in (TRUTHS[name] for name in sensor.sees)]


def record(sensor: Any, truth: list[float], count: int, dt: float = 0.01) -> np.ndarray:
    return simulate_readings(sensor, np.tile(truth, (count, 1)), dt, np.random.default_rng(7))


def size(sensor: Any, truth: list[float]) -> float:
    """Standard deviation that it declares."""
    share = getattr(sensor, "relative_noise", 0.0)
    return math.hypot(sensor.noise, share * truth[0] / truth[1] if share else 0.0)


# ---------------------------------------------------------------- the checks


def check_rest(sensor: Any) -> None:
    """Of what does not change it says the same, from the first reading on."""
    still = quiet(sensor)
    found = record(still, usual(sensor), 50)
    np.testing.assert_allclose(found, found[0], rtol=1e-13, atol=1e-15)
    if type(sensor).registered_name in STEADY:
        detailed = changed(still, **NUMBERS)
        expected = STEADY[sensor.registered_name](detailed, usual(sensor))
        least = detailed.resolution
        assert record(detailed, usual(sensor), 2)[-1] == pytest.approx(
            expected, rel=1e-12, abs=0.5 * least + 1e-15
        )


def check_shape(sensor: Any) -> None:
    """What it remembers is a column of numbers, as many at every time."""
    state = sensor.rest(floats, usual(sensor))
    count = len(state)
    for k in range(5):
        assert len(state) == count
        assert all(isinstance(number, float) for number in state)
        _, state = sensor.step(floats, state, usual(sensor, 0.2 * k), 0.1 * k, 0.01 * k)


def check_extremes(sensor: Any, truth: list[list[float]], dt: float = 1e-3) -> None:
    """Whatever the truth, a reading is a number, of whole steps, within the range."""
    state = sensor.rest(floats, truth[0])
    for seen in truth:
        value, state = sensor.reading(floats, state, seen, 5.0, dt)
        assert all(math.isfinite(number) for number in (value, *state))
        low, high = sensor.limits() or (-math.inf, math.inf)
        assert low <= value <= high
        if sensor.resolution > 0.0 and value not in (low, high):
            steps = value / sensor.resolution
            assert steps == pytest.approx(round(steps), rel=1e-15, abs=1e-9)


def check_no_time(sensor: Any) -> None:
    """In no time nothing changes."""
    still, truth = quiet(sensor), usual(sensor)
    state = still.rest(floats, usual(sensor, 0.3))
    first, state = still.step(floats, state, truth, 0.0, 0.01)
    again, after = still.step(floats, state, truth, 0.0, 0.0)
    assert math.isfinite(first)
    assert again == pytest.approx(first, rel=1e-14, abs=1e-15)
    assert after == pytest.approx(state, rel=1e-14, abs=1e-15)


def check_lag(sensor: Any, lag: float = 0.3) -> None:
    """After a step it follows exp(-t/lag), in whatever steps time goes."""
    slow = quiet(sensor, lag=lag)
    start, end = usual(sensor, 0.2), usual(sensor, 0.7)
    before, after = (record(slow, truth, 1)[0] for truth in (start, end))
    assert before != after
    for count in (5, 50):
        state = slow.rest(floats, start)
        value = 0.0
        for _ in range(count):
            value, state = slow.step(floats, state, end, 0.0, 0.4 / count)
        assert value == pytest.approx(after + (before - after) * math.exp(-0.4 / lag), rel=1e-12)


def check_limits(sensor: Any) -> None:
    """It stops at the ends of its range."""
    low, high = changed(sensor, lowest=280.0, highest=290.0).limits()
    ranged = quiet(changed(sensor, lowest=280.0, highest=290.0))
    for share, end in ((-1e4, low), (1e4, high)):
        truth = usual(sensor, share)
        if sensor.unit == "K":
            truth = [max(kelvin, 1.0) for kelvin in truth]
        value, _ = ranged.reading(floats, ranged.rest(floats, usual(sensor)), truth, 0.0, 9.0)
        assert value == end


def check_noise(sensor: Any) -> None:
    """Mean, standard deviation and independence of readings."""
    fine = changed(sensor, resolution=0.0)
    truth = usual(sensor)
    found = record(fine, truth, MANY) - record(quiet(sensor), truth, 1)[0]
    declared = size(fine, truth)
    assert abs(found.mean()) < 4.0 * declared / math.sqrt(MANY)
    assert abs(found.std() / declared - 1.0) < 4.0 / math.sqrt(2.0 * MANY)
    neighbours = float(np.mean(found[1:] * found[:-1])) / declared**2
    assert abs(neighbours) < 4.0 / math.sqrt(MANY)


LAGGING = [s for s in EXAMPLES if "lag" in s.declarations and s.registered_name != "gyroscope"]
RANGED = [s for s in EXAMPLES if s.limits() is not None]
NOISY = [s for s in EXAMPLES if size(s, usual(s)) > 0.0]
CHECKS = [
    *((check, sensor) for check in (check_rest, check_shape, check_no_time) for sensor in EXAMPLES),
    *((check_lag, sensor) for sensor in LAGGING),
    *((check_limits, sensor) for sensor in RANGED),
    *((check_noise, sensor) for sensor in NOISY),
]


@pytest.mark.parametrize(
    ("check", "sensor"), CHECKS, ids=lambda x: x.__name__ if callable(x) else label(x)
)
def test_promise(check: Callable[[Any], None], sensor: Any) -> None:
    check(sensor)


WIDE = st.one_of(st.floats(-1e12, 1e12), st.floats(-1e-3, 1e-3), st.just(0.0))
STEPS = st.one_of(st.just(0.0), st.floats(1e-6, 1e3))


@pytest.mark.parametrize("sensor", EXAMPLES, ids=label)
@settings(max_examples=30)
@given(data=st.data())
def test_any_truth_gives_a_reading(sensor: Any, data: st.DataObject) -> None:
    row = st.lists(WIDE, min_size=len(sensor.sees), max_size=len(sensor.sees))
    check_extremes(sensor, data.draw(st.lists(row, min_size=2, max_size=4)), data.draw(STEPS))


@pytest.mark.parametrize("sensor", EXAMPLES, ids=label)
def test_what_is_declared_is_in_its_own_unit(sensor: Any) -> None:
    for name in ("noise", "resolution", "offset", "bias", "lowest", "highest", "range", "first"):
        declared = sensor.declarations.get(name)
        if declared is not None:
            assert sensor.unit is not None
            assert units.find_conversion(declared.unit, sensor.unit) == (1.0, 0.0)


def test_every_steady_reading_is_known_and_most_sensors_lag_or_are_noisy() -> None:
    assert {s.registered_name for s in EXAMPLES} == set(SENSORS.names())
    assert set(STEADY) <= set(SENSORS.names())
    for some in (LAGGING, RANGED, NOISY):
        assert len({s.registered_name for s in some}) >= 5


# ---------------------------------------------------------------- the checks can fail


class Careless(CurrentSensor):
    """Lags by a share of a step, however long it is."""

    def step(self, xp: Any, state: Any, truth: Any, noise: Any, dt: Any) -> Any:
        felt = state[0] + 0.1 * (truth[0] - state[0])
        return self.curve(xp, felt) + self.offset + self.noise * noise, (felt,)


class Creeping(CurrentSensor):
    """Never rests."""

    def step(self, xp: Any, state: Any, truth: Any, noise: Any, dt: Any) -> Any:
        value, after = super().step(xp, state, truth, noise, dt)
        return value + after[0] * dt, after


class Loud(CurrentSensor):
    """Has a tenth more noise than it declares."""

    def step(self, xp: Any, state: Any, truth: Any, noise: Any, dt: Any) -> Any:
        return super().step(xp, state, truth, 1.1 * noise, dt)


class Growing(CurrentSensor):
    """Remembers more and more."""

    def step(self, xp: Any, state: Any, truth: Any, noise: Any, dt: Any) -> Any:
        value, after = super().step(xp, state, truth, noise, dt)
        return value, (*after, *state)


class Boundless(CurrentSensor):
    """Knows no range."""

    def digits(self, xp: Any, value: Any) -> Any:
        return value


class Coarse(CurrentSensor):
    """Rounds to other steps than it declares."""

    def digits(self, xp: Any, value: Any) -> Any:
        return super().digits(xp, 0.7 * value) / 0.7


class Dividing(CurrentSensor):
    """Divides by the time that has gone by."""

    def step(self, xp: Any, state: Any, truth: Any, noise: Any, dt: Any) -> Any:
        value, after = super().step(xp, state, truth, noise, dt)
        return value + 0.0 / dt, after


def check_one(sensor: Any) -> None:
    check_extremes(sensor, [[1.2345], [-0.3]])


@pytest.mark.parametrize(
    ("check", "cls", "error"),
    [
        (check_rest, Creeping, AssertionError),
        (check_lag, Careless, AssertionError),
        (check_no_time, Dividing, ZeroDivisionError),
        (check_no_time, Careless, AssertionError),
        (check_noise, Loud, AssertionError),
        (check_shape, Growing, AssertionError),
        (check_limits, Boundless, AssertionError),
        (check_one, Coarse, AssertionError),
    ],
)
def test_a_broken_sensor_is_caught(
    check: Callable[[Any], None], cls: type[Any], error: type[Exception]
) -> None:
    check(CurrentSensor())
    with pytest.raises(error):
        check(cls())
