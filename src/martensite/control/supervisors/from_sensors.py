"""Checks of sensors from their data: too hot, too much stress, lost, stuck.

`hot_NAME` and `stress_NAME` check a temperature or stress of an element against the limits of the element. They act on
readings with their lag and attachment error; the bound without a sensor (`martensite.control.supervisors.from_plant`)
has no delay.

`lost_NAME`: the greatest age of a reading without faults is

    delay + 4 jitter + the time to the next reading, and a period for rounding;

the sensor is lost if `MISSED` successive readings did not come.

`stuck_NAME`, for sensors with noise: with Gaussian noise σ and resolution q, two readings of the same true value are
equal with a probability p ≤ erf(q/(√8 σ)). The sensor is stuck after n equal readings, p^n < `CHANCE`. There is no
check if n is above `MOST_REPEATS`, without noise, or with a limited range, at whose end readings are constant.

Sensors that have gaps by design, such as the resistance without a current, have neither check.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any

from martensite.control.checks.base import AbstractCheck
from martensite.control.checks.reading import Overheat, OverStress, SensorLost, SensorStuck
from martensite.control.loop.parts import WORST, MountedSensor
from martensite.control.observers.base import ESTIMATED
from martensite.control.sensors.base import AbstractSensor

if TYPE_CHECKING:
    from martensite.control.loop.bench import Bench

MISSED = 3
"""Number of missing readings after which a sensor is lost."""
CHANCE = 1e-9
"""Probability of equal readings below which a sensor is stuck."""
LEAST_REPEATS, MOST_REPEATS = 5, 1000
"""Fewest and most equal readings of a stuck sensor."""
TEMPERATURES = ("temperature", "hottest")


def build_sensor_checks(
    bench: Bench, *, noisy: bool = True, temperature_limit: float | None = None, band: float = 0.0
) -> dict[str, AbstractCheck]:
    """Return checks of the sensors of a bench, by name.

    Args:
        bench: plant and sensors; its supervisor is ignored.
        noisy: whether the bench runs with noise; `stuck_NAME` needs noise.
        temperature_limit: highest temperature [K]; default: the limit of each element.
        band: distance below the limit at which signals come back [K], for the answer `resume`.
    """
    checks: dict[str, AbstractCheck] = {}
    for name, one in bench.sensors.members().items():
        for prefix, check in _build_limit_checks(bench, name, one, temperature_limit, band):
            checks[f"{prefix}_{name}"] = check
        if type(one.sensor).valid is AbstractSensor.valid:
            checks[f"lost_{name}"] = SensorLost(reading=name, timeout=lost_after(one, bench.period))
            longest = stuck_after(one, bench.period)
            if noisy and longest is not None:
                checks[f"stuck_{name}"] = SensorStuck(reading=name, longest=longest)
    return checks


def find_known_limit(bench: Bench, kind: str, check: Mapping[str, Any]) -> float | None:
    """Return the limit of the element for a check, or None.

    The limit is a temperature for `thermal-bound` and `overheat`, a stress for `over-stress`.

    Args:
        bench: the bench.
        kind: registered name of the check.
        check: names of reading and drive of the check.
    """
    plant, several = bench.plant, len(bench.plant.actuators()) > 1
    reading = str(check.get("reading", ""))
    mounted = bench.sensors.members().get(reading)
    quantity = reading.removeprefix(ESTIMATED) if mounted is None else mounted.sees()[0]
    for port, one in plant.actuators().items():
        limits, limit = one.element.limits, None
        if kind == "overheat" and quantity in {plant.label(port, output) for output in TEMPERATURES}:
            limit = limits.temperature_limit
        if kind == "over-stress" and quantity == plant.label(port, "stress"):
            limit = limits.stress_limit
        if kind == "thermal-bound" and (not several or check.get("drive") == plant.drive_at(port)):
            limit = limits.temperature_limit
        if limit is not None and math.isfinite(limit):
            return limit
    return None


def lost_after(mounted: MountedSensor, period: float) -> float:
    """Return the age beyond which a sensor is lost, for a sample period [s]."""
    late = mounted.delay + WORST * mounted.jitter
    return late + MISSED * _find_interval(mounted, period) + period


def stuck_after(mounted: MountedSensor, period: float) -> float | None:
    """Return the time after which a sensor with a constant reading is stuck [s]; None without such a check."""
    sensor = mounted.sensor
    if sensor.noise <= 0.0 or sensor.limits() is not None:
        return None
    same = math.erf(sensor.resolution / (math.sqrt(8.0) * sensor.noise))
    if same >= CHANCE ** (1.0 / MOST_REPEATS):
        return None
    count = math.ceil(math.log(CHANCE) / math.log(same)) if same > 0.0 else 0
    return max(count, LEAST_REPEATS) * _find_interval(mounted, period) + WORST * mounted.jitter


def _find_interval(mounted: MountedSensor, period: float) -> float:
    """Return the time between readings, a whole number of periods [s]."""
    return max(1, math.ceil(mounted.sample_time / period - 1e-9)) * period


def _build_limit_checks(
    bench: Bench, name: str, mounted: MountedSensor, limit: float | None, band: float
) -> Iterator[tuple[str, AbstractCheck]]:
    plant, quantity = bench.plant, mounted.sees()[0]
    several = len(plant.actuators()) > 1
    for port, one in plant.actuators().items():
        drives = (plant.drive_at(port),) if several else ()
        stress = one.element.limits
        hottest = stress.temperature_limit if limit is None else limit
        hot = mounted.sensor.unit in (None, "K") and math.isfinite(hottest)
        if hot and quantity in {plant.label(port, output) for output in TEMPERATURES}:
            yield "hot", Overheat(reading=name, limit=hottest, band=band, drives=drives)
        strong = mounted.sensor.unit in (None, "Pa") and math.isfinite(stress.stress_limit)
        if strong and quantity == plant.label(port, "stress"):
            yield "stress", OverStress(reading=name, limit=stress.stress_limit, drives=drives)
