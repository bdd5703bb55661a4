"""Pulses and their average: powers in closed form, ripple of the linear problem, order in 1/f.

Sources of truth: Ohm's law; the periodic solution of C dT/dt = P(t) - h S (T - T_a), whose swing
is P_on/(h S) (1 - e^(-D p/τ)) (1 - e^(-(1-D) p/τ))/(1 - e^(-p/τ)) with p = 1/f and τ = C/(h S).
"""

import math

import numpy as np
import pytest
from builders import ZERO, hanging_wire

from martensite.base.errors import InputError
from martensite.design.analysis.averaging import compare_averaging, measure_ripples
from martensite.kernels import floats
from martensite.physics.electrical.sources import VoltageSource
from martensite.physics.electrical.switches import PwmVoltage
from martensite.signals.carrier import Carrier
from martensite.signals.constant import Constant
from martensite.signals.ramp import Ramp
from martensite.signals.sine import Sine
from martensite.simulate.api import simulate

DUTIES = [0.0, 0.1, 0.5, 1.0]
COLD = {"supply": 2.0, "series_resistance": 0.4}
"""A supply that does not bring the wire of 2.39 ohm to its transformation."""
OHMS = 8.3 * 1.15 * 0.25


def cold_wire(**changes):
    return hanging_wire(source=PwmVoltage(**(COLD | changes)))


def watts_on(supply=2.0, series=0.4):
    return (supply / (OHMS + series)) ** 2 * OHMS


@pytest.mark.parametrize("duty", DUTIES)
@pytest.mark.parametrize("ohms", [0.5, 4.0, 50.0])
def test_mean_power_is_duty_times_the_power_of_the_closed_switch(duty, ohms):
    source = PwmVoltage(supply=5.0, series_resistance=0.3, current_limit=1.2)
    current = source.current(floats, duty, ohms)
    closed = min(5.0 / (ohms + 0.3), 1.2)
    assert current**2 * ohms == pytest.approx(duty * closed**2 * ohms, rel=1e-14)
    assert source.largest_power(ohms) == pytest.approx(closed**2 * ohms, rel=1e-14)


@pytest.mark.parametrize(("asked", "given"), [(-0.5, 0.0), (1.7, 1.0)])
def test_duties_outside_are_limited(asked, given):
    source = PwmVoltage(supply=5.0)
    assert source.current(floats, asked, 4.0) == source.current(floats, given, 4.0)


def test_leads_take_their_share_of_the_supplied_power():
    """Of U I the element gets R/(R + R_s); the rest heats the leads."""
    run = simulate(cold_wire(), Constant(level=1.0), 1.0, step=0.1, samples=11)
    supplied = [2.0 * current for current in run["current"]]
    expected = [power * OHMS / (OHMS + 0.4) for power in supplied]
    assert run["power"] == pytest.approx(expected, rel=1e-12)


# ---------------------------------------------------------------- the linear problem


def time_constant(system):
    wire, area = system.element, math.pi * system.element.diameter * system.element.length
    return wire.heat_capacity_total() / (100.0 * area), 100.0 * area


def swing(duty, frequency, system):
    tau, loss = time_constant(system)
    p = 1.0 / frequency / tau
    on, off = -math.expm1(-duty * p), -math.expm1(-(1.0 - duty) * p)
    return watts_on() / loss * on * off / -math.expm1(-p)


@pytest.mark.parametrize(("duty", "frequency"), [(0.1, 20.0), (0.3, 2.0), (0.8, 0.5)])
def test_ripple_of_the_periodic_state(duty, frequency):
    system = cold_wire()
    tau, loss = time_constant(system)
    duration = math.ceil(12.0 * tau * frequency) / frequency
    found = compare_averaging(system, Constant(level=duty), duration, frequency, step=min(0.004, 0.02 / frequency))
    expected = swing(duty, frequency, system)
    assert max(found.pulsed.result["temperature"]) < 60.0 + ZERO
    assert measure_ripples(found.pulsed)[-1] == pytest.approx(expected, rel=1e-3)
    assert found.ripple >= 0.999 * expected  # the largest is on the way there
    mean = 20.0 + ZERO + duty * watts_on() / loss
    assert found.pulsed.means["temperature"][-1] == pytest.approx(mean, abs=1e-3)
    assert found.average["temperature"][-1] == pytest.approx(mean, abs=1e-3)


def test_estimate_of_the_ripple_holds_for_short_periods():
    system = cold_wire()
    found = compare_averaging(system, Constant(level=0.3), 10.0, 100.0)
    capacity = system.element.heat_capacity_total()
    assert found.estimate == pytest.approx(watts_on() * 0.3 * 0.7 / (100.0 * capacity), rel=1e-12)
    assert found.ripple == pytest.approx(found.estimate, rel=1e-3)


@pytest.mark.parametrize("supply", [2.0, 5.0])
def test_what_averaging_leaves_out_halves_with_the_period(supply):
    """Without transformation, and through it (5 V)."""
    system = hanging_wire(mass=1.0, source=PwmVoltage(supply=supply))
    found = [compare_averaging(system, Constant(level=0.2), 10.0, f) for f in (20, 40, 80, 160)]
    for name in ("temperature", "position"):
        errors = np.array([f.differences[name].rms for f in found])
        if name == "position" and supply == 2.0:
            continue  # it hardly moves
        assert errors[1:] / errors[:-1] == pytest.approx(0.5, abs=0.05)
    assert all(f.ripple <= 1.01 * f.estimate for f in found)


# ---------------------------------------------------------------- one carrier, two marches


@pytest.mark.parametrize("shortest", [0.0, 0.004])
@pytest.mark.parametrize("duty", [Sine(low=0.0, high=0.4, frequency=0.5), Ramp(high=1.25, end=3.0)])
def test_the_loop_plays_what_the_carrier_waveform_says(duty, shortest):
    system = hanging_wire(mass=1.0, source=PwmVoltage(supply=5.0))
    loop = compare_averaging(system, duty, 4.0, 20.0, shortest=shortest, step=1e-3).pulsed
    wave = Carrier(duty=duty, frequency=20.0, shortest=shortest)
    direct = simulate(system, wave, 4.0, step=1e-3, samples=81)
    played = simulate(system, loop.result.waveform, 4.0, step=1e-3, samples=81)
    assert loop.result["drive"][:-1].tolist() == direct["drive"][:-1].tolist()
    for name in ("temperature", "martensite_fraction", "position"):
        assert loop.result[name] == pytest.approx(direct[name], rel=1e-9, abs=1e-12), name
        assert played[name] == pytest.approx(direct[name], rel=1e-9, abs=1e-12), name


def test_a_drive_without_a_switch_is_refused():
    with pytest.raises(InputError, match=r"`pwm-voltage` or `power-pwm`, but it is `voltage`"):
        compare_averaging(hanging_wire(source=VoltageSource()), Constant(level=1.0), 1.0, 10.0)
    with pytest.raises(InputError, match=r"at least one period in 1 s, but its frequency is 0.5"):
        compare_averaging(cold_wire(), Constant(level=1.0), 1.0, 0.5)
