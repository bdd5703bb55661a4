"""Suite for sensors: steady state, lag, resolution, range, noise."""

import math

import numpy as np

from martensite.base import units
from martensite.base.errors import UnitError
from martensite.control.sensors.base import AbstractSensor, simulate_readings
from martensite.kernels import floats
from martensite.kernels.namespace import Namespace, Scalar
from martensite.testing.conformance import require_condition
from martensite.testing.readings import find_range, require_same_traced

MANY = 4000
"""Number of readings in a test of noise."""
WILD = (0.0, -0.0, 1e-300, 1e-3, -1e-3, 0.7, 1.2345, -0.3, 3.3, 300.0, 1e12, -1e12)
OWN_UNIT = ("noise", "resolution", "offset", "bias", "lowest", "highest", "range", "first")
"""Parameters of a sensor in the unit of its readings."""


def change_sensor(sensor: AbstractSensor, **numbers: float) -> AbstractSensor:
    """Return a sensor with changed values of the parameters that it has."""
    return sensor.with_parts(**{n: v for n, v in numbers.items() if n in sensor.declarations})


def silence_sensor(sensor: AbstractSensor, **numbers: float) -> AbstractSensor:
    """Return a sensor without noise and rounding."""
    none = dict.fromkeys(("noise", "relative_noise", "resolution"), 0.0)
    return change_sensor(sensor, **none, **numbers)


def choose_truth(sensor: AbstractSensor, share: float = 0.6) -> list[float]:
    """Return true signals at this fraction of their usual ranges."""
    return [low + share * (high - low) for low, high in map(find_range, sensor.sees)]


def record_readings(sensor: AbstractSensor, truth: list[float], count: int) -> np.ndarray:
    """Return readings of constant signals."""
    rng = np.random.default_rng(7)
    return simulate_readings(sensor, np.tile(truth, (count, 1)), 0.01, rng)


def find_deviation(sensor: AbstractSensor, truth: list[float]) -> float:
    """Return the declared standard deviation of a reading."""
    share = getattr(sensor, "relative_noise", 0.0)
    return math.hypot(sensor.noise, share * truth[0] / truth[1] if share else 0.0)


def check_units(sensor: AbstractSensor) -> None:
    """Its reading has a unit, and its parameters in that unit declare the same."""
    if sensor.unit is None:
        return
    for name in OWN_UNIT:
        declared = sensor.declarations.get(name)
        if declared is None:
            continue
        try:
            same = units.find_conversion(declared.unit, sensor.unit) == (1.0, 0.0)
        except UnitError:
            same = False
        require_condition(same, f"`{name}` is in `{declared.unit}`, but a reading is in `{sensor.unit}`.")


def check_rest(sensor: AbstractSensor) -> None:
    """A sensor gives a constant reading for a constant input, from the first reading on."""
    readings = record_readings(silence_sensor(sensor), choose_truth(sensor), 50)
    constant = np.allclose(readings, readings[0], rtol=1e-13, atol=1e-15)
    require_condition(constant, f"Its readings of the same go from {readings[0]:.6g} to {readings[-1]:.6g}.")


def check_memory(sensor: AbstractSensor) -> None:
    """The memory of a sensor is a constant number of floats."""
    state = sensor.rest(floats, choose_truth(sensor))
    count = len(state)
    for k in range(5):
        numeric = len(state) == count and all(isinstance(x, float) for x in state)
        require_condition(numeric, f"After {k} readings it remembers {list(state)}.")
        truth = choose_truth(sensor, 0.2 * k)
        _, state = sensor.step(floats, state, truth, 0.1 * k, 0.01 * k)


def check_no_time(sensor: AbstractSensor) -> None:
    """In zero time a reading does not change."""
    still, truth = silence_sensor(sensor), choose_truth(sensor)
    state = still.rest(floats, choose_truth(sensor, 0.3))
    first, state = still.step(floats, state, truth, 0.0, 0.01)
    again, after = still.step(floats, state, truth, 0.0, 0.0)
    same = np.allclose([again, *after], [first, *state], rtol=1e-13, atol=1e-15)
    require_condition(same, f"A reading of {first:.6g} is {again:.6g} at the same time.")


def check_lag(sensor: AbstractSensor) -> None:
    """With a lag, it follows a step by exp(-t/lag), for any step size."""
    if "lag" not in sensor.declarations:
        return
    slow = silence_sensor(sensor, lag=0.3)
    start, end = choose_truth(sensor, 0.2), choose_truth(sensor, 0.7)
    before, after = (float(record_readings(slow, truth, 1)[0]) for truth in (start, end))
    if before == after:  # it measures rates
        return
    expected = after + (before - after) * math.exp(-0.4 / 0.3)
    for count in (5, 50):
        state, value = slow.rest(floats, start), 0.0
        for _ in range(count):
            value, state = slow.step(floats, state, end, 0.0, 0.4 / count)
        require_condition(
            abs(value - expected) <= 1e-11 * (abs(expected) + abs(after - before)),
            f"With a lag of 0.3 s it says {value:.6g} 0.4 s after a step, in {count} readings; "
            f"{expected:.6g} is expected.",
        )


def check_digits(sensor: AbstractSensor) -> None:
    """For any input, a reading is finite, within the range, and a multiple of the resolution."""
    rng = np.random.default_rng(5)
    for dt in (0.0, 1e-6, 1e-3, 1e3):
        state = sensor.rest(floats, rng.choice(WILD, len(sensor.sees)).tolist())
        for _ in range(20):
            truth = rng.choice(WILD, len(sensor.sees)).tolist()
            value, state = sensor.reading(floats, state, truth, 5.0, dt)
            finite = all(math.isfinite(number) for number in (value, *state))
            require_condition(finite, f"Of the truth {truth} it says {value}.")
            _require_digits(sensor, value)


def _require_digits(sensor: AbstractSensor, value: float) -> None:
    low, high = sensor.limits() or (-math.inf, math.inf)
    require_condition(low <= value <= high, f"It says {value:.6g}, beyond its range of {low:.6g} to {high:.6g}.")
    if sensor.resolution > 0.0 and value not in (low, high):
        steps = value / sensor.resolution
        whole = abs(steps - round(steps)) <= max(1e-9, 1e-15 * abs(steps))
        require_condition(whole, f"It says {value:.9g}, which is not a whole step.")


def check_noise(sensor: AbstractSensor) -> None:
    """Its noise has zero mean and the declared deviation, and is independent from reading to reading."""
    fine, truth = change_sensor(sensor, resolution=0.0), choose_truth(sensor)
    declared = find_deviation(fine, truth)
    if declared == 0.0:
        return
    quiet = record_readings(silence_sensor(sensor), truth, 1)[0]
    errors = record_readings(fine, truth, MANY) - quiet
    mean, spread = abs(errors.mean()) / declared, errors.std() / declared
    require_condition(mean < 4.0 / math.sqrt(MANY), f"The mean of its noise is {mean:.2g} standard deviations.")
    require_condition(
        abs(spread - 1.0) < 4.0 / math.sqrt(2.0 * MANY), f"Its noise is {spread:.3g} times as large as it declares."
    )
    together = abs(float(np.mean(errors[1:] * errors[:-1]))) / declared**2
    require_condition(together < 4.0 / math.sqrt(MANY), "The noise of a reading depends on the one before.")


def check_traced(sensor: AbstractSensor) -> None:
    """Its readings are a straight-line kernel."""
    count = len(sensor.sees)
    ranges = {f"y{i}": find_range(name) for i, name in enumerate(sensor.sees)}
    again = {f"z{i}": find_range(name) for i, name in enumerate(sensor.sees)}

    def read(one: AbstractSensor, xp: Namespace, dt: Scalar, noise: Scalar, *truth: Scalar) -> tuple[object, ...]:
        first, second = truth[:count], truth[count:]
        value, state = one.reading(xp, one.rest(xp, first), second, noise, dt)
        there = xp.where(one.valid(xp, first), 1.0, 0.0)
        return value, tuple(state), there + 0.0 * noise

    require_same_traced(sensor, read, {"dt": (0.0, 0.5), "noise": (-3.0, 3.0), **ranges, **again})
