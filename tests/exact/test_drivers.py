"""Drivers against Ohm's law and a pulse train that is integrated numerically: powers, limits.

Sources of truth: Ohm's law while a switch is closed, and means over a finely sampled train.
"""

import math

import numpy as np
import pytest
from builders import hanging_wire, problem_a

from martensite.base.errors import ParameterError
from martensite.control.loop.bench import Bench
from martensite.control.loop.run import simulate_bench
from martensite.kernels import floats
from martensite.physics.electrical.sources import LinearAmplifier
from martensite.physics.electrical.switches import HBridge, Mosfet
from martensite.signals.constant import Constant
from martensite.signals.ramp import Ramp
from martensite.simulate.api import simulate

OHMS = [0.5, 2.5, 20.0]
DUTIES = [0.0, 0.003, 0.1, 0.5, 0.97, 1.0]
LOW_SIDE = Mosfet(
    supply=6.0,
    supply_resistance=0.2,
    on_resistance=0.05,
    series_resistance=0.1,
    frequency=2e3,
    dead_time=4e-6,
    smallest_pulse=10e-6,
    current_limit=5.0,
)
BRIDGE = HBridge(
    supply=6.0, high_resistance=0.08, low_resistance=0.04, series_resistance=0.1, frequency=2e3, dead_time=4e-6
)


def train(duty: float, frequency: float, lost: float, shortest: float, samples: int = 200_000):
    """Whether a switch is closed, over one period: late by what is lost, then until D/f."""
    time = (np.arange(samples) + 0.5) / samples / frequency
    if duty >= 1.0:
        return np.ones(samples)
    closed = (time >= lost) & (time < duty / frequency)
    return closed * (duty / frequency - lost >= shortest)


@pytest.mark.parametrize("ohms", OHMS)
@pytest.mark.parametrize("duty", DUTIES)
def test_a_low_side_switch_is_its_pulse_train(duty, ohms):
    closed = min(6.0 / (ohms + 0.35), 5.0)
    current = closed * train(duty, 2e3, 4e-6, 10e-6)
    rms = math.sqrt(float(np.mean(current**2)))
    assert LOW_SIDE.current(floats, duty, ohms) == pytest.approx(rms, rel=1e-3)
    assert LOW_SIDE.current(floats, duty, ohms) ** 2 * ohms == pytest.approx(
        float(np.mean(current**2 * ohms)), rel=1e-3
    )


@pytest.mark.parametrize("ohms", OHMS)
@pytest.mark.parametrize("duty", [-1.0, -0.4, *DUTIES])
def test_a_bridge_is_its_pulse_train(duty, ohms):
    """Both edges lose their time: the pulse begins 4 µs late and ends 4 µs early."""
    current = 6.0 / (ohms + 0.22) * train(abs(duty), 2e3, 8e-6, 0.0)
    rms = math.copysign(math.sqrt(float(np.mean(current**2))), duty)
    assert BRIDGE.current(floats, duty, ohms) == pytest.approx(rms, rel=2e-3)


def test_duties_outside_are_limited():
    for source, pairs in ((LOW_SIDE, [(-0.5, 0.0), (1.7, 1.0)]), (BRIDGE, [(-1.7, -1.0), (1.7, 1.0)])):
        for asked, given in pairs:
            assert source.current(floats, asked, 4.0) == source.current(floats, given, 4.0)
    assert (LOW_SIDE.reach(4.0), BRIDGE.reach(4.0)) == ((0.0, 1.0), (-1.0, 1.0))


def test_diodes_share_a_bridge_between_two_wires():
    up, down = (BRIDGE.with_parts(conducts=way, diode_voltage=0.7) for way in ("positive", "negative"))
    size = math.sqrt(0.4 - 0.016) * 5.3 / 2.72
    for duty, currents in ((0.4, (size, 0.0)), (-0.4, (0.0, -size)), (0.0, (0.0, 0.0))):
        found = up.current(floats, duty, 2.5), down.current(floats, duty, 2.5)
        assert found == pytest.approx(currents, rel=1e-14)
    assert (up.reach(2.5), down.reach(2.5)) == ((0.0, 1.0), (-1.0, 0.0))
    assert BRIDGE.with_parts(conducts="positive", supply=0.5, diode_voltage=0.7).closed_current(floats, 2.5) == 0.0


def test_limits_of_an_amplifier():
    """5 V less 1.2 V of headroom, over 2.5 Ω and 0.3 Ω of its own; up to 3 A; nothing below 0."""
    one = LinearAmplifier(
        voltage_limit=5.0, headroom=1.2, current_limit=3.0, output_resistance=0.3, gain=2.0, offset=0.1
    )
    for signal, volts in ((-1.0, 0.0), (0.0, 0.1), (1.0, 2.1), (1.85, 3.8), (9.0, 3.8)):
        assert one.current(floats, signal, 2.5) == pytest.approx(volts / 2.8, rel=1e-14)
    assert one.current(floats, 9.0, 0.5) == 3.0
    assert one.reach(2.5) == pytest.approx((-0.05, 1.85))
    assert one.reach(0.5).most == pytest.approx((3.0 * 0.8 - 0.1) / 2.0)
    both = one.with_parts(lowest=-3.8)
    assert both.current(floats, -9.0, 2.5) == pytest.approx(-3.8 / 2.8)


def test_an_amplifier_needs_room():
    with pytest.raises(ParameterError, match="`headroom` of `linear-amplifier` must be below"):
        LinearAmplifier(voltage_limit=1.0, headroom=1.2)


@pytest.mark.parametrize(
    ("source", "most"), [(LOW_SIDE, 1.0), (BRIDGE, 1.0), (LinearAmplifier(voltage_limit=3.0, headroom=1.0), 2.0)]
)
def test_a_run_says_what_was_not_delivered(source, most):
    run = simulate(hanging_wire(mass=1.0, source=source), Ramp(high=2.5 * most, end=0.1), 0.1, step=1e-3, samples=8)
    (alarm,) = [one for one in run.alarms if one.kind == "supply"]
    assert (alarm.first, alarm.limit) == (pytest.approx(0.04, rel=1e-8), most)


# ---------------------------------------------------------------- pulse by pulse on a bench


@pytest.mark.parametrize(
    ("source", "duty"), [(LOW_SIDE, 0.06), (BRIDGE.with_parts(conducts="negative"), -0.08)], ids=["mosfet", "h-bridge"]
)
def test_pulses_on_a_bench_heat_as_their_average(source, duty):
    """A carrier of 200 Hz, so slow that it loses a hundredth of a pulse or more."""
    slow = source.with_values({"frequency": 200.0, "dead_time": 50e-6})
    plain = Bench(plant=problem_a(source=slow), period=0.005, substeps=1)
    found = [
        simulate_bench(one, 1.0, waveforms={"drive": Constant(level=duty)}, runtime="floats")
        for one in (plain, plain.with_parts(switching="pulses"))
    ]
    average, pulsed = ([T - 293.15 for T in run["temperature"][40::40]] for run in found)
    assert pulsed == pytest.approx(average, rel=6e-3)
    unlost = plain.with_values({"plant.source.dead_time": 0.0})
    more = simulate_bench(unlost, 1.0, waveforms={"drive": Constant(level=duty)}, runtime="floats")
    assert pulsed[-1] != pytest.approx(more["temperature"][-1] - 293.15, rel=6e-3)


def test_pulses_need_a_duty():
    with pytest.raises(ParameterError, match="a switch with a duty cycle"):
        Bench(plant=problem_a(source=LinearAmplifier()), period=0.005, switching="pulses")
