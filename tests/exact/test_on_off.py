"""ON/OFF control: when it switches, what the band and a late reading do, what it refuses.

Sources of truth: the switching rule applied by hand to ramps, and in a loop the time constant of a
wire that is heated and left to cool.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import pytest
from builders import ZERO, hanging_wire

from martensite.base.errors import ParameterError
from martensite.control.controllers.relay import OnOff
from martensite.control.loop.bench import Bench
from martensite.control.loop.parts import Controllers, MountedSensor, Sensors
from martensite.control.loop.run import simulate_bench
from martensite.control.sensors.position import IdealSensor
from martensite.physics.electrical.sources import PowerSource
from martensite.signals.constant import Constant
from martensite.signals.ramp import Ramp
from martensite.simulate.controlled_run import simulate_controlled
from martensite.simulate.result import Result

PERIOD = 0.1


def played(controller: OnOff, values: Sequence[float], period: float = PERIOD) -> list[float]:
    """Signals for what is measured at the starts of periods."""
    memory, found = controller.init(), list[float]()
    for k, value in enumerate(values):
        signal, memory = controller(k * period, {"angle": value}, memory)
        found.append(signal)
    return found


def on_off(**changes: Any) -> OnOff:
    numbers: dict[str, Any] = {"high": 5.0} | changes
    return OnOff(measured="angle", reference=Constant(level=10.0), **numbers)


# ---------------------------------------------------------------- the rule


def test_it_switches_at_target_and_below_the_band() -> None:
    values = [0.0, 9.9, 10.0, 10.5, 9.5, 9.0, 8.99, 9.5, 9.99, 10.0, 9.0]
    expected = [5.0, 5.0, 0.0, 0.0, 0.0, 0.0, 5.0, 5.0, 5.0, 0.0, 0.0]
    assert played(on_off(band=1.0), values) == expected


def test_without_band_it_compares_only() -> None:
    assert played(on_off(low=1.0), [9.9, 10.0, 9.9, 10.1]) == [5.0, 1.0, 5.0, 1.0]


def test_it_rests_inside_the_band_at_first() -> None:
    assert played(on_off(band=1.0), [9.5, 9.2, 8.0, 9.5]) == [0.0, 0.0, 5.0, 5.0]


def test_the_target_may_move() -> None:
    controller = on_off(band=1.0).with_parts(reference=Ramp(high=20.0, end=1.0))
    assert played(controller, [5.5] * 8) == [0.0, 0.0, 0.0, 0.0, 5.0, 5.0, 5.0, 5.0]


def test_a_signal_that_lowers_the_measured() -> None:
    """A heater whose wire shortens: `high` below `low`."""
    assert played(on_off(high=0.0, low=2.0), [9.0, 11.0]) == [0.0, 2.0]


# ---------------------------------------------------------------- in a loop

TARGET, WATTS, BAND = 40.0 + ZERO, 2.0, 2.0
"""Below the transformation: the wire only warms up, with one time constant."""
PERIOD_IN_LOOP = 0.01


def controller(band: float = BAND) -> OnOff:
    return OnOff(measured="temperature", reference=Constant(level=TARGET), band=band, high=WATTS)


def heated(band: float = BAND) -> Result:
    """In a loop of plain floats, without a sensor."""
    system = hanging_wire(source=PowerSource())
    return simulate_controlled(system, {"drive": controller(band)}, 10.0, PERIOD_IN_LOOP)


def benched(delay: float, duration: float = 10.0) -> Result:
    """On a bench whose thermometer is late."""
    late = MountedSensor(sensor=IdealSensor(), of=("temperature",), delay=delay)
    bench = Bench(
        plant=hanging_wire(source=PowerSource()),
        period=PERIOD_IN_LOOP,
        substeps=1,
        sensors=Sensors(temperature=late),
        controllers=Controllers(drive=controller()),
    )
    return simulate_bench(bench, duration, runtime="floats")


def switched(result: Result) -> list[float]:
    """Times at which the drive changes [s]."""
    drive = result["drive"]
    return [result.times[k] for k in range(1, len(drive)) if drive[k] != drive[k - 1]]


def test_a_wire_in_the_loop_cycles_as_its_time_constant_says() -> None:
    result = heated()
    wire, surroundings = result.system.element, result.system.environment
    capacity = wire.heat_capacity_total()
    conductance = surroundings.cooling.h * wire.surface()
    constant, final = capacity / conductance, WATTS / conductance
    above = TARGET - surroundings.temperature
    first = -constant * math.log(1.0 - above / final)
    cool = constant * math.log(above / (above - BAND))
    warm = constant * math.log((final - above + BAND) / (final - above))
    times = switched(result)
    assert times[0] == pytest.approx(first, abs=0.011)
    for begin, end in zip(times[::2], times[1::2], strict=False):
        assert end - begin == pytest.approx(cool, abs=0.025)
    for begin, end in zip(times[1::2], times[2::2], strict=False):
        assert end - begin == pytest.approx(warm, abs=0.025)
    assert len(times) > 4


def test_on_a_bench_it_does_the_same() -> None:
    """Bit by bit up to the last sample, at which a loop still shows the signal before."""
    assert benched(0.0)["drive"][:-1] == pytest.approx(heated()["drive"][:-1], abs=0.0)


@pytest.mark.parametrize("late", [1, 7])
def test_a_late_sensor_shifts_the_first_switching(late: int) -> None:
    """Until then the course is the same, so that it comes later by the age of the reading."""
    prompt, delayed = (switched(benched(d * PERIOD_IN_LOOP, 5.0))[0] for d in (0, late))
    assert delayed - prompt == pytest.approx(late * PERIOD_IN_LOOP, abs=1e-9)


def test_overshoot_is_rate_times_delay() -> None:
    prompt, late = (max(benched(delay, 5.0)["temperature"]) for delay in (0.0, 0.2))
    result = heated()
    k = round(switched(result)[0] / PERIOD_IN_LOOP)
    rate = (result["temperature"][k] - result["temperature"][k - 1]) / PERIOD_IN_LOOP
    assert late - prompt == pytest.approx(0.2 * rate, rel=0.05)


# ---------------------------------------------------------------- refusals


def test_what_cannot_be_is_refused() -> None:
    lost = OnOff(measured="temprature", reference=Constant(level=300.0), high=1.0)
    with pytest.raises(ParameterError, match=r"cannot measure `temprature`.*`temperature`"):
        simulate_controlled(hanging_wire(), lost, 1.0, 0.5)
    with pytest.raises(ParameterError, match="`band`"):
        on_off(band=-1.0)
    with pytest.raises(ParameterError, match="has no parameter `delay`"):
        on_off(delay=0.1)
    with pytest.raises(ParameterError, match="needs `high`"):
        OnOff(measured="angle", reference=Constant(level=1.0))  # pyrefly: ignore[missing-argument]
