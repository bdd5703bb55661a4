"""Folds of steady rotations: the Sommerfeld effect.

Source of truth: the averaged equations (`martensite.studies.sommerfeld.averages`), which leave out that the speed
swings within a turn; and runs, which stay on one side of a fold and jump on the other.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy import optimize

import martensite as ms
from martensite.base.errors import InputError, ParameterError, SolveError
from martensite.simulate.api import longest_step
from martensite.studies.sommerfeld import averages, machines
from martensite.studies.tables import printed_numbers

BEAM = Path(__file__).parents[2] / "examples" / "sommerfeld_beam.toml"
MOTOR = machines.printed_motor(printed_numbers("sommerfeld"))
MACHINE = ms.Machine(mechanism=MOTOR)


@pytest.fixture(scope="module")
def curve() -> ms.simulate.ResponseCurve:
    """Table 3 of the thesis, from 1 to 90 V; 128 steps of a turn leave out up to 4e-4."""
    return ms.simulate.trace_response(MACHINE, "motor", 1.0, 90.0, steps=128)


def test_folds_are_those_of_the_averaged_equations(curve: ms.simulate.ResponseCurve) -> None:
    """81.54 V and 1.2614 V: averaging is wrong by 0.14 % where the tip swings by 16 cm, by 0.01 % where it does not."""
    upper, lower = averages.find_folds(MOTOR)
    assert (upper.voltage, lower.voltage) == pytest.approx((81.5359, 1.26138), rel=1e-5)
    assert curve.folds == pytest.approx([upper.voltage, lower.voltage], rel=2e-3)
    assert curve.folds[1] == pytest.approx(lower.voltage, rel=4e-4)
    assert curve.speed[curve.fold] == pytest.approx([upper.speed, lower.speed], rel=4e-4)
    swing = [averages.amplitude_at(MOTOR, one.speed) for one in (upper, lower)]
    assert curve.amplitude["displacement"][curve.fold] == pytest.approx(swing, rel=2e-3)


def test_stability_changes_at_the_folds_and_nowhere_else(curve: ms.simulate.ResponseCurve) -> None:
    first, second = np.flatnonzero(curve.fold)
    assert (curve.multiplier[:first] < 1.0).all() and (curve.multiplier[second + 1 :] < 1.0).all()
    assert (curve.multiplier[first + 1 : second] > 1.0).all()
    assert curve.stable.sum() == len(curve.fold) - (second - first + 1)
    assert (curve.neutral[~curve.fold] == 1).all()  # the charge only counts up
    assert curve.parameter[[0, -1]] == pytest.approx([1.0, 90.0], rel=1e-9)


def stays(curve: ms.simulate.ResponseCurve, place: int, volts: float, seconds: float) -> bool:
    """Whether a run from a point of the curve, under another voltage, is still near it after some time."""
    lanes = ms.simulate.Lanes(MACHINE, 1)
    lanes.reset(volts)
    lanes.state = curve.points[place].unknowns[: lanes.state.shape[0], None].copy()
    dt = longest_step(MACHINE) / 16.0
    lanes.advance(np.full((round(seconds / dt), 1, 1), volts), dt, shown=False)
    speed = lanes.observe(volts)[lanes.names.index("rotor_speed"), 0]
    return bool(abs(speed / curve.speed[place] - 1.0) < 0.05)


def test_runs_jump_where_the_curve_turns_back(curve: ms.simulate.ResponseCurve) -> None:
    first, second = np.flatnonzero(curve.fold).tolist()
    up, down = curve.folds
    assert stays(curve, first, 0.995 * up, 30.0) and not stays(curve, first, 1.005 * up, 30.0)
    assert stays(curve, second, 1.02 * down, 30.0) and not stays(curve, second, 0.98 * down, 30.0)


def test_a_fold_moves_with_the_damping(curve: ms.simulate.ResponseCurve) -> None:
    for place, off in ((0, 3e-3), (1, 6e-4)):
        found = ms.simulate.trace_folds(curve, place, "damping", 0.066, 0.076)
        assert found.second[[0, -1]] == pytest.approx([0.066, 0.076], rel=1e-9)
        assert not found.cusp.any()
        for k in (0, -1):
            motor = MOTOR.with_values({"damping": float(found.second[k])})
            assert found.first[k] == pytest.approx(averages.find_folds(motor)[place].voltage, rel=off)


def test_another_number_is_followed_from_a_point(curve: ms.simulate.ResponseCurve) -> None:
    """Captured at about 20 V, with more damping: where the averaged equations have it."""
    place = int(np.flatnonzero(curve.parameter > 20.0)[0])
    volts = float(curve.parameter[place])
    found = ms.simulate.continue_response(curve, place, "damping", 0.06, 0.1)
    assert found.parameter[[0, -1]] == pytest.approx([0.06, 0.1], rel=1e-9)
    for k in (0, -1):
        motor, peak = MOTOR.with_values({"damping": float(found.parameter[k])}), machines.natural_frequency(MOTOR)
        speed: Any = optimize.brentq(lambda w, m=motor: averages.voltage_at(m, w) - volts, 0.9 * peak, peak)
        assert found.speed[k] == pytest.approx(speed, rel=4e-4)
        assert found.amplitude["displacement"][k] == pytest.approx(averages.amplitude_at(motor, speed), rel=2e-3)


def test_a_curve_does_not_leap_over_transformations() -> None:
    """A martensitic wire is heated by 66 K: as a curve it would stay martensite all the way."""
    cold = ms.simulate.trace_response(machines.load_scenario(), "motor", 0.6, 0.7, drive={"drive": 0.0}, steps=64)
    with pytest.raises(SolveError, match="depends on the path"):
        ms.simulate.continue_response(cold, 0, "drive", 0.0, 1.1)


def test_a_curve_needs_something_that_turns_and_bounds_that_rise() -> None:
    wire = ms.load(BEAM.with_name("pwm_bias_spring.toml"))
    with pytest.raises(InputError, match="Nothing turns"):
        ms.simulate.trace_response(wire, "drive", 1.0, 2.0)
    with pytest.raises(ParameterError, match="must rise"):
        ms.simulate.trace_response(MACHINE, "motor", 2.0, 1.0)
    with pytest.raises(InputError, match="changes in time"):
        ms.simulate.trace_response(ms.load(BEAM), "damping", 0.1, 0.2)


@pytest.mark.slow
def test_a_hot_wire_moves_the_jump_as_in_the_ramp() -> None:
    """Study `sommerfeld`: a slow ramp jumps at 5.22 V from 30.97 mm with the wire hot; without it at 6.38 V, 54 mm."""
    found = [
        ms.simulate.trace_response(machines.load_scenario(), "motor", 1.5, 9.0, drive={"drive": ampere}, steps=256)
        for ampere in (0.0, 1.1)
    ]
    folds = [float(one.folds[0]) for one in found]
    swing = [1e3 * float(one.amplitude["displacement"][one.fold][0]) for one in found]
    assert folds == pytest.approx([averages.find_folds(machines.calibrated_motor())[0].voltage, 5.16], abs=0.06)
    assert folds[1] < 5.22  # a ramp of 0.2 V/s jumps late
    assert swing == pytest.approx([54.0, 30.97], abs=0.5)
