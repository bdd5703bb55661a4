"""Constant power by pulses: demand and delivery, averaged and in the loop of every period.

Source of truth: P_max = (U/(R + R_s))² R, and what follows if it is measured at another R.
"""

import math
from typing import Any

import numpy as np
import pytest
from builders import hanging_wire

from martensite.base.errors import ParameterError
from martensite.control.controllers.constant_power import ConstantPower
from martensite.control.loop.bench import Bench
from martensite.control.loop.parts import Controllers
from martensite.control.loop.run import simulate_bench
from martensite.design.analysis.averaging import compare_averaging
from martensite.kernels import floats
from martensite.physics.electrical.switches import PowerPwm, PwmVoltage
from martensite.signals.base import AbstractWaveform
from martensite.signals.constant import Constant
from martensite.signals.ramp import Ramp
from martensite.simulate.api import simulate
from martensite.simulate.closed_loop import simulate_loop

COLD_OHMS = 8.3 * 1.15 * 0.25
RAMP = Ramp(high=3.2, start=1.0, end=3.0)
SWITCH: dict[str, Any] = {"supply": 5.0}


def wire(**source: Any):
    return hanging_wire(mass=1.0, source=PowerPwm(**(SWITCH | source)))


@pytest.mark.parametrize("ohms", [1.0, 3.0, 20.0])
@pytest.mark.parametrize("series", [0.0, 0.5])
def test_demand_is_delivered_up_to_the_closed_switch(ohms, series):
    source = PowerPwm(supply=5.0, series_resistance=series)
    most = (5.0 / (ohms + series)) ** 2 * ohms
    for demand in (-1.0, 0.0, 0.1, 1.0, 30.0):
        got = source.current(floats, demand, ohms) ** 2 * ohms
        assert got == pytest.approx(min(max(demand, 0.0), most), rel=1e-13, abs=0)
    assert source.reach(ohms) == (0.0, pytest.approx(most, rel=1e-14))


@pytest.mark.parametrize("ohms", [2.0, 2.5, 3.0])
def test_a_single_measurement_is_wrong_by_the_change_of_resistance(ohms):
    """R₀/R - 1 from a bare voltage, R/R₀ - 1 from a limited current."""
    once: dict[str, Any] = {"measured": "once", "reference_resistance": 2.5}
    bare = PowerPwm(supply=5.0, **once)
    assert bare.current(floats, 1.0, ohms) ** 2 * ohms == pytest.approx(2.5 / ohms, rel=1e-13)
    limited = PowerPwm(supply=50.0, current_limit=1.5, **once)
    assert limited.current(floats, 1.0, ohms) ** 2 * ohms == pytest.approx(ohms / 2.5, rel=1e-13)


def test_a_single_measurement_must_be_given():
    with pytest.raises(ParameterError, match="needs `reference_resistance`"):
        PowerPwm(supply=5.0, measured="once")


def test_averaged_power_follows_the_demand_through_the_transformation():
    run = simulate(wire(), RAMP, 8.0, samples=81)
    assert min(run["martensite_fraction"]) < 0.1
    assert run["power"] == pytest.approx([RAMP.value(t) for t in run.times], rel=1e-12)
    assert run.alarms == []


# ---------------------------------------------------------------- the loop


def loop(measured, frequency=100.0, demand: AbstractWaveform = RAMP, **switch):
    system = hanging_wire(mass=1.0, source=PwmVoltage(**(SWITCH | switch)))
    drive = ConstantPower(reference=demand, updated=measured)
    return simulate_loop(system, drive, 8.0, 1.0 / frequency, pulses=True)


def errors(found, demand: AbstractWaveform = RAMP):
    """Mean power of each period over its demand, less 1; and resistance over the first."""
    demands = np.array([demand.value(t) for t in found.result.times[:-1]])
    asked = demands > 0.0
    power = np.array(found.means["power"])[asked] / demands[asked] - 1.0
    ohms = np.array(found.result["resistance"][:-1])[asked] / found.result["resistance"][0]
    return power, ohms


@pytest.mark.parametrize("series", [0.0, 0.3])
def test_measured_in_every_period_the_power_is_right_within_a_percent(series):
    found = loop("every-period", series_resistance=series)
    power, ohms = errors(found)
    assert max(found.signals) < 1.0
    assert ohms.min() < 0.92
    assert np.abs(power).max() < 1e-2
    assert np.abs(power).max() < 1e-3  # what it takes is one period of change in resistance


def test_measured_once_the_power_is_off_by_the_resistance():
    power, ohms = errors(loop("once"))
    assert power == pytest.approx(1.0 / ohms - 1.0, abs=1e-3)
    assert power.max() > 0.08


def test_the_delay_of_the_measurement_shrinks_with_the_period():
    worst = [np.abs(errors(loop("every-period", f))[0]).max() for f in (25.0, 50.0, 100.0)]
    assert worst[1] / worst[0] == pytest.approx(0.5, abs=0.15)
    assert worst[2] / worst[1] == pytest.approx(0.5, abs=0.15)


def test_a_largest_power_measured_before_is_used():
    most = 25.0 / COLD_OHMS
    system = hanging_wire(mass=1.0, source=PwmVoltage(**SWITCH))
    drive = ConstantPower(reference=Constant(level=1.0), updated="once", largest=2.0 * most)
    found = simulate_loop(system, drive, 0.1, 0.01, pulses=True)
    assert found.signals == pytest.approx([0.5 / most] * 10, rel=1e-12)


def test_saturated_the_switch_stays_closed_and_says_so():
    found = loop("every-period", demand=Constant(level=13.0))
    assert found.signals[0] == pytest.approx(13.0 * COLD_OHMS / 25.0, rel=1e-9)
    assert found.means["drive"] == pytest.approx([1.0] * 800)
    (alarm,) = [a for a in found.result.alarms if a.kind == "supply"]
    assert (alarm.first, alarm.limit) == (0.0, 1.0)
    assert alarm.worst == pytest.approx(13.0 * COLD_OHMS / 25.0, rel=1e-9)


@pytest.mark.parametrize("measured", ["every-period", "once"])
def test_the_averaged_source_is_the_average_of_the_loop(measured):
    once: dict[str, Any] = {"measured": measured, "reference_resistance": COLD_OHMS}
    found = compare_averaging(wire(**once), RAMP, 8.0, 200.0)
    assert found.differences["temperature"].largest < 0.1
    assert found.differences["power"].rms < 3e-3
    assert 0.1 < found.ripple < 0.2


def test_under_an_averaged_duty_the_loop_begins_with_a_probe():
    """Of its own, for one period, or that of the loop."""
    system = hanging_wire(source=PwmVoltage(**SWITCH))
    drive = ConstantPower(reference=Constant(level=1.0), probe=0.02)
    begun = simulate_loop(system, drive, 0.1, 0.01)
    assert begun.signals[0] == 0.02
    assert begun.means["power"] == pytest.approx([0.02 * 25.0 / COLD_OHMS, *[1.0] * 9], rel=1e-12)
    found = simulate_loop(system, drive, 0.1, 0.01, probe=1.0)
    assert found.means["power"] == pytest.approx([1.0] * 10, rel=1e-12)
    assert math.isclose(found.signals[0], COLD_OHMS / 25.0, rel_tol=1e-12)


def test_a_bench_makes_the_same_pulses():
    """On a bench nothing is measured before the first pulse, which is the probe."""
    system = hanging_wire(mass=1.0, source=PwmVoltage(**SWITCH))
    drive = ConstantPower(reference=Constant(level=2.0))
    bench = Bench(plant=system, period=0.01, substeps=1, switching="pulses", controllers=Controllers(drive=drive))
    wanted = simulate_bench(bench, 2.0, runtime="floats")["wanted"]
    assert wanted[0] == drive.probe
    signals = simulate_loop(system, drive, 2.0, 0.01, pulses=True).signals
    assert wanted[20:-1] == pytest.approx(signals[20:], rel=1e-3)
