"""Frequency responses, speeds and energies against closed forms.

Sources of truth: the transfer functions of a model of first order, alone and in a loop; the heat
balance of a wire that does not transform, C dT/dt = P − h S (T − T_a); and the weight that a wire
lifts.
"""

from __future__ import annotations

import math
from functools import cache
from typing import Any

import numpy as np
import pytest
from builders import ZERO, hanging_wire
from tuning_cases import DELAY, DT, linear_bench

from martensite.actuators.assembly import System
from martensite.base.errors import InputError, ParameterError
from martensite.control.loop.bench import Bench
from martensite.design.analysis.frequency_response import measure_frequency_response
from martensite.design.analysis.speeds import compute_speeds
from martensite.show.figures.energy import plot_energy
from martensite.show.figures.responses import plot_frequency_response, plot_speeds
from martensite.signals.held import Held
from martensite.signals.sine import Sine
from martensite.simulate.api import simulate
from martensite.simulate.cycle_energies import compute_cycle_energies
from martensite.simulate.result import Result

GAIN, MASS, H = 2.0, 1.0, 100.0
WIRE: System = hanging_wire(mass=MASS, h=H)
AREA = math.pi * 0.381e-3 * 0.25
CAPACITY = 6450.0 * 400.0 * math.pi * 0.381e-3**2 / 4.0 * 0.25
TAU = CAPACITY / (H * AREA)
PEAK = H * AREA * 120.0
CYCLE = 24.0


def first_order(frequency: Any) -> Any:
    """The model of `linear_bench` as a transfer function: lag of 1 s, eight samples late."""
    delay, pole = np.exp(-2j * np.pi * np.asarray(frequency) * DT), math.exp(-DT)
    return GAIN * (1.0 - pole) * delay**DELAY / (1.0 - pole * delay)


# ---------------------------------------------------------------- frequency response


@pytest.mark.parametrize("native", [None, False])
def test_a_model_of_first_order_has_its_transfer_function(native: bool | None) -> None:
    plant = linear_bench().plant
    wanted = (0.02, 0.1, 0.15, 0.17, 0.5) if native is None else (0.5,)
    found = measure_frequency_response(plant, [0.3, 0.6], 0.1, wanted, native=native)
    exact = first_order(found.frequencies)
    np.testing.assert_allclose(found.response, [exact, exact], rtol=2e-4)
    assert np.abs(found.mean - (GAIN * found.biases[:, None] + 0.5)).max() < 1e-4
    assert found.settled.all()
    assert found.distortion.max() < 1e-3
    assert found.frequencies == pytest.approx(wanted, rel=0.02)
    if native is None:
        turns = 2.0 * math.pi * found.frequencies[0]
        falls = math.sqrt(2.0 * (1.0 + turns**2) - 1.0) / (2.0 * math.pi)
        assert found.bandwidth == pytest.approx([falls] * 2, rel=2e-3)


def test_a_closed_loop_has_that_of_its_loop() -> None:
    """The gain Kp = 1 around the model; limits are out of reach."""
    found = measure_frequency_response(linear_bench(), [1.5], 0.05, [0.05, 0.2, 0.4], drive="reference")
    loop = first_order(found.frequencies)
    np.testing.assert_allclose(found.response, [loop / (1.0 + loop)], rtol=1e-3)
    assert np.isnan(found.bandwidth[0])


def test_a_wire_that_does_not_transform_is_a_lag() -> None:
    wanted = np.array([0.1, 1.0, 4.0]) / (2.0 * math.pi * TAU)
    power = H * AREA * 10.0
    found = measure_frequency_response(WIRE, [power], 0.5 * power, wanted, output="temperature")
    exact = 1.0 / (H * AREA) / (1.0 + 2j * math.pi * wanted * TAU)
    np.testing.assert_allclose(found.frequencies, wanted, rtol=1e-12)
    np.testing.assert_allclose(found.response, [exact], rtol=1e-3)
    np.testing.assert_allclose(found.mean, 20.0 + ZERO + 10.0, rtol=1e-5)


def test_a_wire_remembers_from_where_it_came() -> None:
    """At one power, of which the cold wire is martensite and the one that was hot austenite."""
    middle, amplitude = 0.42 * PEAK, 0.02 * PEAK
    wanted: list[Any] = [WIRE, [middle], amplitude, [0.2 / TAU]]
    heated = measure_frequency_response(*wanted, output="martensite_fraction")
    cooled = measure_frequency_response(*wanted, output="martensite_fraction", high=PEAK)
    assert heated.mean[0, 0] > 0.95
    assert cooled.mean[0, 0] < 0.05


def test_frequencies_that_are_none() -> None:
    plant = linear_bench().plant
    with pytest.raises(InputError, match=r"fewer than 8 samples .* 2.5 Hz"):
        measure_frequency_response(plant, [0.5], 0.1, [9.0])
    with pytest.raises(InputError, match="amplitude"):
        measure_frequency_response(plant, [0.5], 0.0, [0.1])
    with pytest.raises(InputError, match="No drive named `refrence`"):
        measure_frequency_response(linear_bench(), [1.5], 0.1, [0.1], drive="refrence")
    with pytest.raises(InputError, match="No output named `yy`"):
        measure_frequency_response(plant, [0.5], 0.1, [0.1], output="yy")


# ---------------------------------------------------------------- speeds


def test_a_lag_rises_and_falls_alike_for_every_load() -> None:
    """Of the coefficient h as a load the lag follows; of the signal nothing does."""
    signals, films = H * AREA * np.array([5.0, 10.0]), (H, 2.0 * H)
    found = compute_speeds(WIRE, signals.tolist(), 12.0 * TAU, output="temperature", load="cooling.h", loads=films)
    lags = TAU * np.array([[1.0, 1.0], [0.5, 0.5]])
    heights = np.array([[5.0, 10.0], [2.5, 5.0]])
    np.testing.assert_allclose(found.rise, math.log(10.0) * lags, rtol=1e-3)
    np.testing.assert_allclose(found.fall, math.log(10.0) * lags, rtol=1e-3)
    np.testing.assert_allclose(found.stroke, heights, rtol=1e-4)
    np.testing.assert_allclose(found.fastest_up, heights / lags, rtol=0.05)
    np.testing.assert_allclose(found.fastest_down, found.fastest_up, rtol=0.01)
    np.testing.assert_allclose(found.ratio, 1.0, rtol=1e-3)
    assert found.load == "environment.cooling.h"


def test_a_model_steps_after_its_delay() -> None:
    found = compute_speeds(linear_bench().plant, [0.5], 10.0)
    late = DT * (DELAY - 1.0)
    assert found.rise[0, 0] == pytest.approx(late + math.log(10.0), abs=0.1 * DT)
    assert found.load == "" and math.isnan(found.loads[0])


def test_more_power_heats_faster_and_cools_no_faster() -> None:
    found = compute_speeds(WIRE, [PEAK, 2.0 * PEAK], 4.0 * TAU, back=8.0 * TAU)
    assert found.rise[0, 1] < 0.6 * found.rise[0, 0]
    assert found.fall[0, 1] > found.fall[0, 0]


def test_speeds_that_are_none() -> None:
    with pytest.raises(InputError, match="both its name and its values"):
        compute_speeds(WIRE, [1.0], 1.0, load="mechanism.mass")
    with pytest.raises(ParameterError, match=r"`mechanism\.mas`"):
        compute_speeds(WIRE, [1.0], 1.0, load="mechanism.mas", loads=[1.0])
    with pytest.raises(InputError, match="hold"):
        compute_speeds(WIRE, [1.0], 0.0)


# ---------------------------------------------------------------- energies


@cache
def cycles() -> Result:
    wave = Sine(high=PEAK, frequency=1.0 / CYCLE)
    return simulate(WIRE, wave, 2.5 * CYCLE, step=0.01, samples=6001)


def test_the_heat_of_a_cycle_that_repeats_is_what_was_put_in() -> None:
    found = compute_cycle_energies(cycles(), CYCLE)
    assert len(found.electrical) == 2
    assert found.electrical == pytest.approx(0.5 * PEAK * CYCLE, rel=1e-6)
    assert abs(found.stored_energy[1] / found.electrical[1]) < 1e-3  # and the first does not repeat:
    assert found.stored_energy[0] / found.electrical[0] > 1e-2


def test_the_work_is_the_lifted_weight() -> None:
    run = cycles()
    found = compute_cycle_energies(run, CYCLE)
    second = np.array(run["position"])[2400:4801]
    lifted = MASS * 9.80665 * (second.max() - second.min())
    assert lifted > 0.05
    assert found.work[1] == pytest.approx(lifted, rel=1e-3)
    assert found.net_work[1] == pytest.approx(0.0, abs=1e-3 * lifted)
    assert found.efficiency[1] == pytest.approx(lifted / (0.5 * PEAK * CYCLE), rel=1e-3)


def test_a_bench_holds_its_power_for_a_period() -> None:
    """Pulses of a period are counted as they are; trapezoids would see half of them twice."""
    bench = Bench(plant=WIRE, period=0.5)
    levels = (0.0, 3.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    run = simulate(bench, {"drive": Held(values=levels, frequency=2.0)}, 4.0, samples=9)
    found = compute_cycle_energies(run, 1.0)
    assert found.electrical == pytest.approx([1.5, 0.5, 0.0, 0.0])
    assert math.isnan(found.efficiency[2])


def test_what_has_no_cycle_or_no_columns() -> None:
    with pytest.raises(InputError, match="no whole cycle"):
        compute_cycle_energies(cycles(), 100.0)
    with pytest.raises(InputError, match="No column named `torqe`"):
        compute_cycle_energies(cycles(), CYCLE, pairs=[("torqe", "position")])
    named = compute_cycle_energies(cycles(), CYCLE, pairs=[("force", "position")])
    assert named.work.tolist() == compute_cycle_energies(cycles(), CYCLE).work.tolist()


# ---------------------------------------------------------------- pictures


def test_pictures_have_what_was_found() -> None:
    found = measure_frequency_response(linear_bench().plant, [0.3, 0.6], 0.1, [0.05, 0.5])
    gain, phase = plot_frequency_response(found).axes[:2]
    np.testing.assert_allclose(line(gain, "0.6"), found.gain[1], rtol=1e-9)
    np.testing.assert_allclose(line(phase, "0.3"), np.degrees(found.phase[0]))
    quick = compute_speeds(WIRE, [PEAK, 2.0 * PEAK], 4.0 * TAU, back=8.0 * TAU)
    course, times = plot_speeds(quick).axes[:2]
    assert len(course.get_lines()) == 3
    np.testing.assert_allclose(line(times, "heating"), quick.rise[0])
    energies = compute_cycle_energies(cycles(), CYCLE)
    bars: list[Any] = list(plot_energy(energies).axes[0].patches)
    assert max(bar.get_height() for bar in bars) == pytest.approx(energies.electrical.max())


def line(axes: Any, label: str) -> Any:
    """What a line shows."""
    (found,) = [one.get_ydata() for one in axes.get_lines() if one.get_label() == label]
    return found
