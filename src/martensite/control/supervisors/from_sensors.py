"""Checks from the data of sensors: too hot, too much stress, lost, stuck.

`hot_NAME` and `stress_NAME`, for readings of a temperature or stress of an element: its own
limits, as far as it has some. They see what the sensor says, a lag and a badly attached bead
included; the bound without a sensor (`martensite.control.supervisors.from_plant`) does not wait.

`lost_NAME`: the oldest that a reading gets on a bench without faults is

    delay + 4 jitter + the time to the next one, and a period for rounding;

it is lost when `MISSED` readings in a row did not come.

`stuck_NAME`, for sensors with noise: with noise σ and steps q, a reading is the same as another one of the same truth
with the probability p = erf(q/(√8 σ)) at most (the truth in the middle of a step; Gaussian noise). It is stuck after n
readings that are all the same, p^n < `CHANCE`. The check is left out for n above `MOST_REPEATS`, without noise,
or for a sensor with a limited range, because its readings are constant at the end of the range.

Sensors that now and then have nothing to measure, such as the resistance without a current, are
rightly silent: there is neither check for them.
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
"""Readings that do not come before a sensor is lost."""
CHANCE = 1e-9
"""Probability of readings that are all the same, beyond which a sensor is stuck."""
LEAST_REPEATS, MOST_REPEATS = 5, 1000
"""Fewest and most readings that are all the same for a sensor to be stuck."""
TEMPERATURES = ("temperature", "hottest")


def checks_for(
    bench: Bench, *, noisy: bool = True, temperature_limit: float | None = None, band: float = 0.0
) -> dict[str, AbstractCheck]:
    """Checks of the sensors of a bench, by name.

    Args:
        bench: plant and sensors; its supervisor plays no part.
        noisy: whether it runs with noise; without, no reading is known to move.
        temperature_limit: highest temperature [K]; by default that of the limits of each element.
        band: how far below it signals come back [K], where the answer is `resume`.
    """
    found: dict[str, AbstractCheck] = {}
    for name, one in bench.sensors.members().items():
        for sort, check in _build_limit_checks(bench, name, one, temperature_limit, band):
            found[f"{sort}_{name}"] = check
        if type(one.sensor).valid is AbstractSensor.valid:
            found[f"lost_{name}"] = SensorLost(reading=name, timeout=lost_after(one, bench.period))
            longest = stuck_after(one, bench.period)
            if noisy and longest is not None:
                found[f"stuck_{name}"] = SensorStuck(reading=name, longest=longest)
    return found


def find_known_limit(bench: Bench, kind: str, check: Mapping[str, Any]) -> float | None:
    """Limit that the element of a check has, by the kind and the names of the check; None for none.

    That of the temperature for `thermal-bound` and `overheat`, of the stress for `over-stress`, of a reading or an
    estimate.
    """
    plant, several = bench.plant, len(bench.plant.actuators()) > 1
    reading = str(check.get("reading", ""))
    mounted = bench.sensors.members().get(reading)
    seen = reading.removeprefix(ESTIMATED) if mounted is None else mounted.sees()[0]
    for port, one in plant.actuators().items():
        limits, known = one.element.limits, None
        if kind == "overheat" and seen in {plant.label(port, output) for output in TEMPERATURES}:
            known = limits.temperature_limit
        if kind == "over-stress" and seen == plant.label(port, "stress"):
            known = limits.stress_limit
        if kind == "thermal-bound" and (not several or check.get("drive") == plant.drive_at(port)):
            known = limits.temperature_limit
        if known is not None and math.isfinite(known):
            return known
    return None


def lost_after(mounted: MountedSensor, period: float) -> float:
    """Return the age beyond which a reading is that of a lost sensor, on a bench with that period [s]."""
    late = mounted.delay + WORST * mounted.jitter
    return late + MISSED * _find_interval(mounted, period) + period


def stuck_after(mounted: MountedSensor, period: float) -> float | None:
    """Return the time after which a reading that stays the same is that of a stuck sensor [s], if any."""
    sensor = mounted.sensor
    if sensor.noise <= 0.0 or sensor.limits() is not None:
        return None
    same = math.erf(sensor.resolution / (math.sqrt(8.0) * sensor.noise))
    if same >= CHANCE ** (1.0 / MOST_REPEATS):
        return None
    count = math.ceil(math.log(CHANCE) / math.log(same)) if same > 0.0 else 0
    return max(count, LEAST_REPEATS) * _find_interval(mounted, period) + WORST * mounted.jitter


def _find_interval(mounted: MountedSensor, period: float) -> float:
    """Return the time from one reading to the next, a whole number of periods [s]."""
    return max(1, math.ceil(mounted.sample_time / period - 1e-9)) * period


def _build_limit_checks(
    bench: Bench, name: str, mounted: MountedSensor, limit: float | None, band: float
) -> Iterator[tuple[str, AbstractCheck]]:
    """Checks of a reading by the limits of the element that it is of."""
    plant, seen = bench.plant, mounted.sees()[0]
    several = len(plant.actuators()) > 1
    for port, one in plant.actuators().items():
        drives = (plant.drive_at(port),) if several else ()
        stress = one.element.limits
        hottest = stress.temperature_limit if limit is None else limit
        hot = mounted.sensor.unit in (None, "K") and math.isfinite(hottest)
        if hot and seen in {plant.label(port, output) for output in TEMPERATURES}:
            yield "hot", Overheat(reading=name, limit=hottest, band=band, drives=drives)
        strong = mounted.sensor.unit in (None, "Pa") and math.isfinite(stress.stress_limit)
        if strong and seen == plant.label(port, "stress"):
            yield "stress", OverStress(reading=name, limit=stress.stress_limit, drives=drives)
