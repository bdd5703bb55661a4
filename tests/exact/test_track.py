"""Measures from accepted steps: closed forms of the drive, independence of stored samples, agreement of runtimes."""

from __future__ import annotations

import numpy as np
import pytest
from builders import problem_a

from martensite.actuators.mechanisms.load_line import DeadWeight
from martensite.physics.electrical.sources import PowerSource, PrescribedTemperature
from martensite.signals.base import AbstractWaveform
from martensite.signals.pwm import PulseWidthModulation
from martensite.signals.ramp import Ramp
from martensite.signals.sine import Sine
from martensite.signals.step import Step
from martensite.signals.triangle import Triangle
from martensite.simulate.api import simulate
from martensite.simulate.chords import bend_chords
from martensite.simulate.ensembles import Ensemble
from martensite.simulate.measures.base import parse_measure
from martensite.simulate.recorded_track import HIGH, LOW, MEAN, PER_DRIVE, SQUARE, spread_levels
from martensite.simulate.result import Result
from martensite.simulate.track import interpolate_nodes
from martensite.simulate.variants import VariantSetup

SYSTEM = problem_a().with_parts(source=PowerSource())
"""Its power is its drive, so energy, mean and extremes of the power are those of the waveform."""
DURATION = 20.0
TENT = Triangle(low=300.0, high=390.0, frequency=1.0 / DURATION)
FAST, SLOW = 20.0, 0.1
"""Frequencies [Hz] that a step passes, and that steps follow."""
WAVES: dict[str, tuple[AbstractWaveform, float, float, float]] = {
    "pulse": (Step(high=6.0, at=7.003, until=7.013), 0.06, 0.0, 6.0),
    "fast pwm": (PulseWidthModulation(high=5.0, frequency=FAST, duty=0.15), 15.0, 0.0, 5.0),
    "slow pwm": (PulseWidthModulation(high=2.0, frequency=SLOW, duty=0.25), 10.0, 0.0, 2.0),
    "fast sine": (Sine(low=0.5, high=1.5, frequency=FAST), 20.0, 0.5, 1.5),
    "slow sine": (Sine(low=1.0, high=5.0, frequency=SLOW), 60.0, 1.0, 5.0),
    "ramp": (Ramp(high=1.0, end=DURATION), 10.0, 0.0, 1.0),
}
"""Waveform, energy [J], lowest and highest power [W]."""
WORDS = ("energy", "min(power)", "max(power)", "max(temperature)", "stroke", "rise-time(position)", "mean(temperature)")


def measure_all(run: Result) -> np.ndarray:
    return np.array([run.measure(words) for words in WORDS])


@pytest.mark.parametrize(
    ("name", "runtime"), [("pulse", "floats"), ("slow sine", "floats"), *((name, "c") for name in WAVES)]
)
def test_power_and_energy_are_those_of_the_waveform(name: str, runtime: str, c_compiler: str) -> None:
    wave, energy, low, high = WAVES[name]
    run = simulate(SYSTEM, wave, DURATION, samples=21, runtime=runtime, tolerance=1e-3)
    assert run.measure("energy") == pytest.approx(energy, rel=1e-9)
    assert (run.measure("min(power)"), run.measure("max(power)")) == pytest.approx((low, high), rel=1e-6, abs=1e-9)
    assert run.extremes["power"] == pytest.approx((low, high), rel=1e-6, abs=1e-9)


@pytest.mark.parametrize("tolerance", [1e-4, 1e-7])
def test_a_sine_that_touches_zero_has_its_lowest_voltage(tolerance: float, c_compiler: str) -> None:
    """U = sqrt(P R), which has a corner at P = 0, where steps are short at a tight tolerance."""
    run = simulate(SYSTEM, Sine(high=4.0, frequency=0.15), DURATION, samples=11, runtime="c", tolerance=tolerance)
    assert run.measure("min(voltage)") == pytest.approx(0.0, abs=1e-6)


TIMES = (0.0, 4.0, 10.0, 16.0, DURATION)


@pytest.mark.parametrize("runtime", ["floats", "c"])
@pytest.mark.parametrize("wave", [Step(low=300.0, high=390.0, at=4.0, until=16.0), TENT], ids=["jumps", "ramps"])
def test_courses_of_prescribed_temperatures_are_resolved(wave: AbstractWaveform, runtime: str, c_compiler: str) -> None:
    """The truth: 2001 samples. Each sample ends a separate step."""
    system = SYSTEM.with_parts(source=PrescribedTemperature(), mechanism=DeadWeight(mass=1.0))
    run = simulate(system, wave, DURATION, samples=2001, runtime=runtime, tolerance=1e-3)
    range_of = np.ptp(run["position"])
    for time in np.linspace(0.3, 19.7, 41).tolist():
        meant = float(np.interp(time, run["time"], run["position"]))
        if min(abs(time - jump) for jump in TIMES) > 0.05:
            assert run.measure(f"at(position, time={time!r} s)") == pytest.approx(meant, abs=3e-3 * range_of)


def test_corners_between_steps_are_within_the_bound() -> None:
    """A tent whose tip lies between two nodes is bent exactly to its tip; a parabola by about four times its height."""
    nodes, tip = np.arange(5.0)[None, :], 2.4
    shares = np.array([[0.7]])  # of the step from node 1 to node 3
    joined = np.ones((1, 2), np.bool_)
    tent = -np.abs(nodes - tip)[:, :, None]
    line = np.interp(tip, nodes[0], tent[0, :, 0])
    assert line + bend_chords(nodes, tent, joined, shares)[0, 0, 0] == pytest.approx(0.0)
    bent = bend_chords(nodes, (nodes**2)[:, :, None], joined, np.array([[0.75]]))[0, 0, 0]
    assert bent == pytest.approx(4.0 * (2.5**2 - 0.5 * (4.0 + 9.0)))
    alone = bend_chords(nodes, (nodes**2)[:, :, None], ~joined, np.array([[0.75]]))[0, 0, 0]
    assert alone == pytest.approx(2.0 * (2.5**2 - 0.5 * (4.0 + 9.0)))


@pytest.mark.parametrize("name", WAVES)
def test_measures_do_not_depend_on_stored_samples(name: str, c_compiler: str) -> None:
    wave = WAVES[name][0]
    few, many = (simulate(SYSTEM, wave, DURATION, samples=n, runtime="c") for n in (11, 2001))
    assert measure_all(few) == pytest.approx(measure_all(many), rel=2e-4)
    assert [alarm.kind for alarm in few.alarms] == [alarm.kind for alarm in many.alarms]


@pytest.mark.parametrize("name", WAVES)
def test_measures_are_those_of_a_fine_run(name: str, c_compiler: str) -> None:
    """The reference reads 40,001 stored samples of a run to a much smaller tolerance."""
    wave = WAVES[name][0]
    run = simulate(SYSTEM, wave, DURATION, samples=11, runtime="c")
    fine = simulate(SYSTEM, wave, DURATION, samples=40_001, runtime="c", tolerance=1e-7)
    for column in ("temperature", "stress", "position"):
        extent = np.ptp(fine[column])
        meant = fine[column].max()
        assert run.measure(f"max({column})") == pytest.approx(meant, abs=3e-4 * extent)


@pytest.mark.parametrize(
    ("name", "runtime"), [("pulse", "floats"), ("slow sine", "floats"), ("pulse", "c"), ("fast pwm", "c")]
)
def test_rows_of_a_batch_are_measured_like_single_runs(name: str, runtime: str, c_compiler: str) -> None:
    wave, measures = WAVES[name][0], tuple(map(parse_measure, WORDS))
    outputs = ("power", "temperature", "position")
    setup = VariantSetup(SYSTEM, {"drive": wave}, DURATION, 11, None, outputs, runtime, measures=measures)
    diameters = np.array([0.3e-3, 0.381e-3, 0.5e-3])
    found: Ensemble = setup.run({"element.diameter": diameters})
    for k, diameter in enumerate(diameters):
        run = simulate(SYSTEM.with_values({"element.diameter": diameter}), wave, DURATION, samples=11, runtime=runtime)
        assert found.numbers[:, k] == pytest.approx(measure_all(run), rel=3e-4)


def test_given_steps_are_measured_at_their_ends(c_compiler: str) -> None:
    wave, measures = WAVES["pulse"][0], tuple(map(parse_measure, ("energy", "max(power)")))
    for runtime in ("floats", "c"):
        setup = VariantSetup(SYSTEM, {"drive": wave}, DURATION, 11, 0.05, ("power",), runtime, measures=measures)
        found = setup.run({"element.diameter": np.array([0.381e-3])})
        assert found.columns["power"].shape == (1, 11)
        assert found.numbers[:, 0] == pytest.approx([0.06, 6.0], rel=1e-5)


def test_levels_have_the_moments_of_their_drive() -> None:
    """Two levels, a sine, and a signal that rests between its extremes: mean, mean square and extremes are kept."""
    two = (
        np.array([0.0] * 3 + [2.0]),
        np.sin(np.linspace(0.0, 2.0 * np.pi, 1001)[:-1]),
        np.array([0.0, 4.0, *[1.0] * 98]),
    )
    for signal in two:
        moments = np.zeros((1, 1, PER_DRIVE))
        moments[0, 0, [MEAN, SQUARE, LOW, HIGH]] = signal.mean(), (signal**2).mean(), signal.min(), signal.max()
        levels, shares = (one[0, 0] for one in spread_levels(moments))
        assert (shares >= 0.0).all() and shares.sum() == pytest.approx(1.0)
        assert shares @ levels == pytest.approx(signal.mean(), abs=1e-12)
        assert shares @ levels**2 == pytest.approx((signal**2).mean(), rel=1e-12)
        assert (levels[0], levels[-1]) == (signal.min(), signal.max())


def test_interpolation_is_exact_for_a_quartic() -> None:
    nodes, at = np.array([[0.0, 0.4, 1.0, 1.7, 2.0]]), np.array([[1.2, 1.9]])
    values = (nodes**4 - 2.0 * nodes)[:, :, None]
    found, fourth = interpolate_nodes(nodes, values, at, np.array([[1.0, 1.7, 2.0]]))
    assert found[0, :, 0] == pytest.approx((at**4 - 2.0 * at)[0], rel=1e-12)
    assert fourth[0, 0] > 0.0
