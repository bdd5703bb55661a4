"""Waveforms: values, edges, and sentences for bad input."""

from __future__ import annotations

import math

import pytest
from grids import over

from martensite.base.errors import ParameterError
from martensite.signals.ahead import Ahead
from martensite.signals.base import MANY
from martensite.signals.carrier import Carrier
from martensite.signals.constant import Constant
from martensite.signals.held import Held
from martensite.signals.pwm import PulseWidthModulation
from martensite.signals.ramp import Ramp
from martensite.signals.sine import Sine
from martensite.signals.staircase import Staircase
from martensite.signals.step import Step
from martensite.signals.table import Table
from martensite.signals.triangle import Triangle


def values(waveform, times):
    return [waveform.value(time) for time in times]


@pytest.mark.parametrize("count", [7, MANY])
@pytest.mark.parametrize(
    "waveform",
    [
        Constant(level=2.5),
        PulseWidthModulation(high=2.0, frequency=0.7, duty=0.3),
        Ramp(low=0.1, high=0.7, start=2.0, end=5.3),
        Ramp(low=0.7, high=0.1, start=0.0, end=9.1),
        Sine(low=0.1, high=0.7, frequency=0.3),
        Step(low=1.0, high=3.0, at=2.0, until=5.0),
        Table(times=(1.0, 1.3, 4.7), values=(0.1, 0.7, 0.2), factor=0.3, stretch=1.7),
        Triangle(low=0.1, high=0.7, frequency=0.3),
        Staircase(first=0.3, increment=0.7, hold=1.1, count=4, direction="up-down"),
        Held(values=(0.3, 0.7, 0.1), frequency=0.3),
        Carrier(duty=Ramp(low=-0.1, high=1.1, start=0.0, end=9.0), frequency=0.9, shortest=0.1),
        Ahead(waveform=Staircase(increment=0.7, hold=1.1, count=9), lead=0.3),
    ],
    ids=lambda one: one.registered_name,
)
def test_signals_at_many_times_are_the_same_numbers_as_one_by_one(waveform, count):
    times = [11.0 * k / (count - 1) for k in range(count)]
    times += [1.0, 2.0, 5.0, 5.3, math.nextafter(5.3, 0.0)]
    times += [time for edge in waveform.edges(11.0) for time in (edge, math.nextafter(edge, 0.0))]
    assert waveform.signals(times) == values(waveform, times)


def test_constant_has_no_edges():
    assert values(Constant(level=2.5), (0.0, 1e9)) == [2.5, 2.5]
    assert Constant(level=2.5).edges(1e9) == []


def test_a_waveform_is_a_drive_without_memory():
    waveform = Constant(level=2.5)
    assert waveform(3.0, {"position": 1.0}, waveform.init()) == (2.5, None)


def test_step_is_right_continuous():
    pulse = Step(low=1.0, high=3.0, at=2.0, until=5.0)
    before = math.nextafter(2.0, 0.0)
    assert values(pulse, (0.0, before, 2.0, 4.9, 5.0, 9.0)) == [1.0, 1.0, 3.0, 3.0, 1.0, 1.0]
    assert pulse.edges(10.0) == [2.0, 5.0]
    assert pulse.edges(5.0) == [2.0]


def test_step_without_until_stays_and_a_step_at_zero_is_no_edge():
    step = Step(high=3.0)
    assert values(step, (0.0, 1e9)) == [3.0, 3.0]
    assert step.edges(10.0) == []


def test_step_refuses_until_before_at():
    with pytest.raises(ParameterError, match=r"`until` of `step` must be above `at` = 2 s, but is"):
        Step(high=1.0, at=2.0, until=2.0)


def test_ramp_is_linear_and_holds():
    ramp = Ramp(low=1.0, high=3.0, start=2.0, end=4.0)
    assert values(ramp, (0.0, 2.0, 2.5, 3.0, 4.0, 9.0)) == [1.0, 1.0, 1.5, 2.0, 3.0, 3.0]
    assert ramp.edges(10.0) == [2.0, 4.0]


def test_ramp_goes_down_too():
    assert Ramp(low=3.0, high=1.0, end=2.0).value(1.0) == 2.0


def test_ramp_refuses_no_length():
    with pytest.raises(ParameterError, match=r"`end` of `ramp` must be above `start` = 2 s"):
        Ramp(high=1.0, start=2.0, end=2.0)


def test_staircase_up_holds_the_last_level():
    stairs = Staircase(first=1.0, increment=0.5, hold=10.0, count=3)
    assert values(stairs, (0.0, 9.9, 10.0, 20.0, 30.0, 1e6)) == [1.0, 1.0, 1.5, 2.0, 2.0, 2.0]
    assert stairs.edges(1e6) == [10.0, 20.0]


def test_staircase_up_down_returns_to_the_first_level():
    stairs = Staircase(first=1.0, increment=0.5, hold=10.0, count=3, direction="up-down")
    middles = [5.0 + 10.0 * k for k in range(7)]
    assert values(stairs, middles) == [1.0, 1.5, 2.0, 1.5, 1.0, 1.0, 1.0]
    assert stairs.edges(1e6) == [10.0, 20.0, 30.0, 40.0]
    assert stairs.edges(30.0) == [10.0, 20.0]


def test_staircase_of_one_level_is_constant():
    stairs = Staircase(first=1.0, increment=0.5, hold=10.0, count=1, direction="up-down")
    assert values(stairs, (0.0, 15.0, 99.0)) == [1.0, 1.0, 1.0]
    assert stairs.edges(100.0) == []


@pytest.mark.parametrize(
    ("count", "sentence"), [(2.5, "must be a whole number, but is 2.5"), (0, "must be between 1 and 1e")]
)
def test_staircase_refuses_a_number_of_levels(count, sentence):
    with pytest.raises(ParameterError, match=sentence):
        Staircase(increment=1.0, hold=1.0, count=count)


def test_staircase_refuses_another_direction():
    with pytest.raises(ParameterError, match=r"`direction` .* is `updown`. Did you mean `up-down`"):
        Staircase(increment=1.0, hold=1.0, count=2, direction="updown")


def test_sine_starts_low_as_a_raised_cosine():
    sine = Sine(low=0.5, high=2.5, frequency=0.005)
    for time in (0.0, 13.0, 50.0, 100.0, 137.0, 200.0, 1234.5):
        expected = 0.5 + (2.5 - 0.5) / 2 * (1 - math.cos(2 * math.pi * 0.005 * time))
        assert sine.value(time) == pytest.approx(expected, abs=1e-12)
    assert sine.value(0.0) == 0.5
    assert sine.value(100.0) == 2.5
    assert sine.edges(1e6) == []


@pytest.mark.parametrize(("phase", "start", "soon"), [("low", 0.0, 0.5), ("middle", 0.5, 1.0), ("high", 1.0, 0.5)])
def test_sine_phase(phase, start, soon):
    sine = Sine(high=1.0, frequency=1.0, phase=phase)
    assert values(sine, (0.0, 0.25)) == pytest.approx([start, soon])


def test_sine_keeps_its_phase_after_many_periods():
    sine = Sine(high=1.0, frequency=4.0)
    assert sine.value(1e9 + 0.125) == pytest.approx(1.0, abs=1e-6)


def test_triangle_starts_low():
    triangle = Triangle(low=1.0, high=3.0, frequency=0.5)
    times = (0.0, 0.5, 1.0, 1.5, 2.0, 3.0)
    assert values(triangle, times) == pytest.approx([1.0, 2.0, 3.0, 2.0, 1.0, 3.0])
    assert triangle.edges(4.0) == [1.0, 2.0, 3.0]


def test_pwm_is_on_first():
    pwm = PulseWidthModulation(high=5.0, frequency=10.0, duty=0.25)
    assert values(pwm, (0.0, 0.02, 0.025, 0.09, 0.1, 0.12)) == [5.0, 5.0, 0.0, 0.0, 5.0, 5.0]
    assert pwm.edges(0.2) == pytest.approx([0.025, 0.1, 0.125])


@over("frequency", [0.3, 1.0 / 3.0, 7.0, 10.0, 49.9, 1234.5])
@over("duty", [0.1, 1.0 / 3.0, 0.7, 0.999])
def test_pwm_jumps_exactly_at_its_edges(frequency, duty):
    pwm = PulseWidthModulation(low=0.0, high=1.0, frequency=frequency, duty=duty)
    edges = pwm.edges(1000.0 / frequency)
    assert len(edges) in (1999, 2000)
    assert values(pwm, edges) == [float(i % 2) for i in range(len(edges))]
    before = [math.nextafter(edge, 0.0) for edge in edges]
    assert values(pwm, before) == [1.0 - i % 2 for i in range(len(edges))]


@pytest.mark.parametrize(("duty", "level"), [(0.0, 1.0), (1.0, 4.0)])
def test_pwm_fully_off_and_on(duty, level):
    pwm = PulseWidthModulation(low=1.0, high=4.0, frequency=3.0, duty=duty)
    assert {pwm.value(k / 7.0) for k in range(100)} == {level}
    assert pwm.edges(100.0) == []


def test_pwm_refuses_a_duty_above_one():
    with pytest.raises(ParameterError, match=r"`duty` of `pwm` must be between 0 and 1, but is 50"):
        PulseWidthModulation(high=1.0, frequency=1.0, duty=50.0)


@pytest.mark.parametrize(
    "waveform", [PulseWidthModulation(high=1.0, frequency=1e6, duty=0.5), Triangle(high=1.0, frequency=1e6)]
)
def test_too_many_edges_are_refused(waveform):
    with pytest.raises(ParameterError, match=r"has about 1.2e\+08 edges in 60 s.* 5,000,000 are"):
        waveform.edges(60.0)


@pytest.mark.parametrize(
    "make",
    [
        lambda: Sine(low=2.0, high=1.0, frequency=1.0),
        lambda: Triangle(low=2.0, high=1.0, frequency=1.0),
        lambda: PulseWidthModulation(low=2.0, high=1.0, frequency=1.0, duty=0.5),
    ],
)
def test_oscillations_need_levels_in_order(make):
    with pytest.raises(ParameterError, match="must be at most `high`, but low = 2 and high = 1"):
        make()


def test_table_is_linear_and_holds_outside():
    table = Table(times=(1.0, 2.0, 4.0), values=(0.0, 2.0, 1.0))
    times = (0.0, 1.0, 1.5, 2.0, 3.0, 4.0, 9.0)
    assert values(table, times) == [0.0, 0.0, 1.0, 2.0, 1.5, 1.0, 1.0]
    assert table.edges(10.0) == [1.0, 2.0, 4.0]
    assert table.edges(4.0) == [1.0, 2.0]


def test_table_has_no_edges_where_it_stays_level():
    table = Table(times=(0.0, 1.0, 2.0, 3.0, 4.0), values=(1.0, 1.0, 1.0, 2.0, 2.0))
    assert table.edges(10.0) == [2.0, 3.0]


@pytest.mark.parametrize(
    ("times", "levels", "sentence"),
    [
        ((), (), "needs at least 2 rows, but has 0"),
        ((1.0,), (1.0,), "needs at least 2 rows, but has 1"),
        ((1.0, 2.0), (1.0,), "must be equally long, but hold 2 and 1 numbers"),
        ((0.0, 3.2, 3.1), (1.0, 1.0, 1.0), "but row 3 goes from 3.2 s to 3.1 s"),
        ((0.0, 3.2, 3.2), (1.0, 1.0, 1.0), "but row 3 goes from 3.2 s to 3.2 s"),
        ((0.0, math.nan), (1.0, 1.0), "must be finite, but row 2 holds nan and 1.0"),
        ((0.0, 1.0), (math.inf, 1.0), "must be finite, but row 1 holds 0.0 and inf"),
    ],
)
def test_table_refuses_bad_rows(times, levels, sentence):
    with pytest.raises(ParameterError, match=sentence):
        Table(times=times, values=levels)
