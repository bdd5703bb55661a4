"""Steady states: folds of closed forms, rest, heat balance, limit cycles.

Source of truth: closed forms and SciPy's roots of the same balance; for cycles and rest, long runs.
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from builders import problem_a
from scipy import optimize

import martensite as ms
from martensite.base.errors import InputError, SolveError
from martensite.control.loop.switched_cycles import SwitchedMotion
from martensite.signals.constant import Constant
from martensite.signals.pwm import PulseWidthModulation
from martensite.simulate.steady.periodic_motion import judge_stability
from martensite.studies.platform import bench, loop
from martensite.studies.tables import printed_numbers

EXAMPLES = Path(__file__).parents[2] / "examples"
ZERO = 273.15
HALF_WAY = 2.1
"""A voltage at which the wire of problem A is between its phases [V]."""


# ---------------------------------------------------------------- curves and folds


def test_folds_of_a_cusp_and_their_curve() -> None:
    """x³ - a x = b turns back at b = ±2 (a/3)^{3/2}; its folds meet at a = b = 0."""
    curve = ms.simulate.trace_curve(lambda z: z[0] ** 3 - 2.0 * z[0] - z[1], [-2.0, -4.0], -4.0, 4.0)
    edge = 2.0 * (2.0 / 3.0) ** 1.5
    assert curve.folds[:, 1] == pytest.approx([edge, -edge], rel=1e-10)
    assert curve.folds[:, 0] == pytest.approx([-math.sqrt(2.0 / 3.0), math.sqrt(2.0 / 3.0)], rel=1e-8)
    assert curve.parameter[[0, -1]] == pytest.approx([-4.0, 4.0], rel=1e-12)
    found = ms.simulate.trace_fold_curve(
        lambda z: z[0] ** 3 - z[2] * z[0] - z[1], [*curve.folds[0], 2.0], -1.0, 3.0, sizes=[1.0, 1.0, 1.0]
    )
    _, b, a = found.unknowns.T
    assert np.abs(27.0 * b**2 - 4.0 * a**3).max() < 1e-10
    assert np.abs(found.folds).max() < 1e-9 and len(found.folds) == 1
    assert b.min() < -1.9 and b.max() > 1.9


def test_folds_of_a_duffing_oscillator() -> None:
    """First harmonic, A² [(1 - ω² + ¾ A²)² + (d ω)²] = F²: folds are double roots in A."""
    damped, force = 0.1, 0.3

    def missing(z: np.ndarray) -> float:
        return z[0] ** 2 * ((1.0 - z[1] ** 2 + 0.75 * z[0] ** 2) ** 2 + (damped * z[1]) ** 2) - force**2

    def at_fold(z: np.ndarray) -> list[float]:
        off = 1.0 - z[1] ** 2 + 0.75 * z[0] ** 2
        return [missing(z), off * off + (damped * z[1]) ** 2 + 1.5 * z[0] ** 2 * off]

    curve = ms.simulate.trace_curve(missing, [0.3, 0.2], 0.2, 3.0)
    assert len(curve.folds) == 2
    for fold in curve.folds:
        exact = optimize.root(at_fold, fold, tol=1e-14).x
        assert fold[1] == pytest.approx(exact[1], abs=1e-10)
    plain = ms.simulate.trace_curve(lambda z: missing(z) + 0.999 * force**2, [0.003, 0.2], 0.2, 3.0)
    assert not len(plain.folds)


# ---------------------------------------------------------------- rest


def test_a_wire_rests_where_its_heat_is_lost() -> None:
    """Constant power: T = T_a + P/(h S), which is left at the rate h S/(m c)."""
    scenario = ms.load(EXAMPLES / "pwm_bias_spring.toml", {"drive.kind": "power", "drive.waveform.high": "1 W"})
    wire: Any = scenario.single_system.element
    around = scenario.single_system.environment
    conductance = 60.0 * wire.surface()
    found = ms.simulate.find_steady_state(scenario, 3.0)
    assert found.outputs["temperature"] == pytest.approx(around.temperature + 3.0 / conductance, abs=1e-6)
    assert found.stable and found.outputs["martensite_fraction"] == pytest.approx(0.0, abs=1e-12)
    assert found.time_constant == pytest.approx(wire.heat_capacity_total() / conductance, rel=1e-3)
    assert ms.simulate.find_steady_temperature(scenario, 3.0) == pytest.approx(found.outputs["temperature"], abs=1e-6)


def test_hysteresis_has_two_branches_and_what_lies_between() -> None:
    system = problem_a()
    cold = ms.simulate.find_steady_state(system, 1.9)
    hot = ms.simulate.find_steady_state(system, 1.9, start="hot", high=4.0)
    same = ms.simulate.find_operating_point(system, 1.9, direction="cooling", high=4.0)
    assert hot.outputs["position"] == pytest.approx(same.outputs["position"], abs=1e-9)
    assert hot.outputs["position"] > cold.outputs["position"] + 1e-3
    assert cold.stability.neutral > 0 and cold.stable and hot.stable
    half = ms.simulate.find_steady_state(system, HALF_WAY, start=cold)
    back = ms.simulate.find_steady_state(system, 1.9, start=half)
    assert cold.outputs["position"] < back.outputs["position"] <= half.outputs["position"]


def test_temperature_and_film_coefficient_at_a_power() -> None:
    """Against SciPy's root of the balance, written with the correlation alone."""
    cooling = ms.thermal.CombinedCooling(
        convection=ms.thermal.ChurchillChu(), radiation=ms.thermal.Radiation(emissivity=0.5)
    )
    around = ms.thermal.Environment(temperature="22 degC", cooling=cooling)
    shape, ambient = ms.thermal.Cylinder(0.381e-3, 0.25), 22.0 + ZERO
    surface = math.pi * 0.381e-3 * 0.25

    def film(temperature: float) -> float:
        return float(cooling.film(ms.parts.floats, temperature, ambient, shape))

    for power in (-0.05, 0.2, 2.0):
        exact: Any = optimize.brentq(
            lambda t, p=power: film(t) * surface * (t - ambient) - p, 200.0, 1500.0, xtol=1e-12
        )
        found = ms.simulate.find_steady_temperature(shape, power, environment=around)
        assert found == pytest.approx(exact, abs=1e-9)
        h = ms.simulate.find_film_coefficient(shape, power, environment=around)
        assert h == pytest.approx(film(exact), rel=1e-10)
    assert ms.simulate.find_steady_temperature(shape, 0.0, environment=around) == ambient
    given: list[dict[str, Any]] = [{}, {"power": 1.0, "temperature": 300.0}]
    for wrong in given:
        with pytest.raises(InputError, match="belongs to a power or to a temperature"):
            ms.simulate.find_film_coefficient(shape, environment=around, **wrong)
    with pytest.raises(InputError, match="`environment`"):
        ms.simulate.find_steady_temperature(shape, 1.0)


def test_what_turns_or_swings_has_no_rest() -> None:
    with pytest.raises(InputError, match="changes in time"):
        ms.simulate.find_steady_state(ms.load(EXAMPLES / "pwm_bias_spring.toml"))
    with pytest.raises(SolveError, match="does not reach a steady state"):
        ms.simulate.find_steady_state(ms.load(EXAMPLES / "sommerfeld_beam.toml"), 2.0)


# ---------------------------------------------------------------- cycles


@pytest.mark.parametrize(("duty", "rule"), [(0.16, "resume"), (0.17, "restart")])
def test_a_cycle_is_where_a_long_run_ends(duty: float, rule: str) -> None:
    """A leap over a transformation would end elsewhere: under `resume` it waits, under `restart` it ratchets on."""
    wave = PulseWidthModulation(high=5.0, frequency=10.0, duty=duty)
    found = ms.simulate.find_cycle(problem_a(rule), wave, step=1e-3)
    run = ms.run(problem_a(rule), wave, 200.0, step=1e-3, samples=2001)
    for name, least in (("temperature", 2e-5), ("martensite_fraction", 1e-6), ("position", 1e-8)):
        assert found.outputs[name][[0, -1]] == pytest.approx([run[name][-1]] * 2, abs=least), name
    assert found.stable and found.period == pytest.approx(0.1)


def test_neutral_directions_are_not_called_unstable() -> None:
    """Of a diagonal map: 1 is neutral, what is above is unstable, and a memory that is only read is neutral too."""
    held = np.array([[1.0, 0.0, 0.0], [0.3, 0.5, 0.0], [0.0, 0.0, 1.0]])
    found = judge_stability(held)
    assert found.neutral == 2 and found.stable and found.largest == pytest.approx(0.5)
    held[1, 1] = 1.01
    assert not judge_stability(held).stable


def test_drives_without_a_period_are_refused() -> None:
    ramp = ms.signals.Ramp(high=2.0, end=1.0)
    with pytest.raises(InputError, match="has no period"):
        ms.simulate.find_cycle(problem_a(), ramp)
    with pytest.raises(InputError, match="constant"):
        ms.simulate.find_cycle(problem_a(), Constant(level=1.0))


def test_the_cycle_of_an_on_off_loop_is_that_of_the_run() -> None:
    """Set A of study `platform`: sampled every 20 ms the loop locks, which the run shows after four periods."""
    printed = printed_numbers("platform")
    plant = bench.build_machine(bench.CASES["A"], printed, printed.high)
    target, band = math.radians(printed.target), math.radians(loop.BAND)
    sampled = ms.control.Switch("alpha", target, band, printed.high, drive=bench.HOT, sampling=0.02)
    found = ms.control.find_switched_cycle(plant, sampled, step=0.02)
    times = loop.switching_times(loop.run_controlled(bench.CASES["A"], printed, loop.Sampling(130.0, 0.02)))
    off, on = np.diff(times)[-4:-2]
    assert (found.period, found.on_time) == pytest.approx((off + on, max(off, on)), abs=1e-9)
    always = ms.control.Switch("alpha", target, band, printed.high, drive=bench.HOT)
    exact = ms.control.find_switched_cycle(plant, always, step=0.02)
    assert found.period - 0.08 < exact.period < found.period
    assert exact.stable and exact.outputs["alpha"].max() == pytest.approx(target, abs=1e-12)
    assert exact.outputs["alpha"].min() == pytest.approx(target - band, abs=2e-5)


def test_the_slope_of_an_on_off_cycle_is_that_of_its_map() -> None:
    """The multiplier is what is left, after a period, of a change of temperature at switching off."""
    scenario = ms.load(EXAMPLES / "pwm_bias_spring.toml")
    switch = ms.control.Switch("temperature", 400.0, 5.0, 4.0, delay=0.013)
    motion = SwitchedMotion(scenario.system, switch, 2e-3)
    state = motion.go_on(motion.heat_up())
    _, slopes = motion.march(state)
    (place,) = motion.stretch.place(lambda one: [one.elements[0].memory.temperature])
    nudge = np.zeros(len(state))
    nudge[place] = 1e-3
    change = (motion.go_on(state + nudge) - motion.go_on(state - nudge)) / 2e-3
    assert change == pytest.approx(slopes[:, place], rel=1e-6, abs=1e-6)
