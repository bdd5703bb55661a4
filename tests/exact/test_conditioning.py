"""What stands around a controller: filters, mode, shaped reference, slew limit.

Sources of truth: SciPy's continuous systems in the limit of short samples, geometry of ramps, and the signal by hand.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import pytest
from builders import problem_a
from scipy.signal import lti, step

from martensite.base.errors import ParameterError
from martensite.control.controllers.base import AbstractController
from martensite.control.controllers.cascade import Cascade, InnerPid, OuterPid
from martensite.control.controllers.conditioning import ManualMode, ReadingFilter, SignalSlew
from martensite.control.controllers.feedforward import Feedforward
from martensite.control.controllers.inverse_play import InversePlay
from martensite.control.controllers.pid import Correction, Pid, PidLaw
from martensite.control.controllers.scheduled_pid import GainsAt, GainSchedule, ScheduledPid
from martensite.control.controllers.shaping import ReferenceShaping
from martensite.kernels import floats
from martensite.physics.electrical.sources import PowerSource
from martensite.signals.constant import Constant
from martensite.signals.held import Held

DT = 0.02
WIDE = PidLaw(low=-1e9, high=1e9)
SCHEDULE = GainSchedule(a=GainsAt(at=0.0, Kp=2.0, Ki=1.0, Kd=0.1), b=GainsAt(at=1.0, Kp=9.0, Ki=2.0))
PID: dict[str, Any] = {"Kp": 2.0, "Ki": 3.0, "Kd": 0.1, "law": WIDE}
CASCADE = {"start": 300.0, "outer": OuterPid(Kp=20.0, Ki=4.0, law=WIDE), "inner": InnerPid(Kp=0.3, Ki=0.2, law=WIDE)}


def held(*values: float) -> Held:
    """One value per sample."""
    return Held(values=tuple(values), frequency=1.0 / DT)


def played(controller: AbstractController, rows: Sequence[Mapping[str, float]]) -> np.ndarray:
    """Signals for readings, one row per sample."""
    memory, found = controller.init(), []
    for k, row in enumerate(rows):
        signal, memory = controller(k * DT + 1e-9, row, memory)
        found.append(signal)
    return np.array(found)


def shaped(shaping: ReferenceShaping, goals: np.ndarray, dt: float = DT, **readings: Any) -> np.ndarray:
    """What is followed on the way from 0 to goals, one per sample."""
    held, found = shaping.begin(0.0), []
    for k, goal in enumerate(goals.tolist()):
        held = shaping.move(floats, held, goal, {name: row[k] for name, row in readings.items()}, dt)
        found.append(float(held.value))
    return np.array(found)


# ---------------------------------------------------------------- manual and automatic


def rows(count: int) -> list[dict[str, float]]:
    """Readings that move a little, so that every part of a controller does something."""
    k = np.arange(count)
    y, T = 0.2 + 0.05 * np.sin(0.3 * k), 310.0 + 3.0 * np.sin(0.2 * k)
    return [{"y": float(a), "temperature": float(b)} for a, b in zip(y, T, strict=True)]


@pytest.mark.parametrize(
    ("kind", "numbers"),
    [
        (Pid, PID),
        (Pid, PID | {"gains_are": "per-sample"}),
        (ScheduledPid, {"rising": SCHEDULE, "over": "y", "law": WIDE}),
        (Cascade, CASCADE),
        (
            InversePlay,
            {
                "thresholds": (0.5,),
                "weights": (1.0, 0.5),
                "knots": (0.0, 1.0),
                "outputs": (0.0, 1.0),
                "feedback": Correction(**PID),
            },
        ),
    ],
)
def test_a_controller_goes_on_from_the_signal_by_hand(kind: type[Any], numbers: Any) -> None:
    """Readings and reference stand still about the change, and there is no error: nothing moves at all."""
    still = [*rows(12), *[rows(12)[11]] * 60]
    made = kind(measured="y", reference=Constant(level=still[-1]["y"]), **numbers)
    hand = ManualMode(signal=Constant(level=0.37), automatic_from=50 * DT)
    found = played(made.with_parts(manual=hand), still)
    assert abs(played(made, still)[49] - 0.37) > 0.01, "it would have been there by itself"
    np.testing.assert_allclose(found, 0.37, rtol=0.0, atol=1e-9)


def test_a_model_run_beside_the_plant_goes_on_from_the_signal_by_hand() -> None:
    """The feed-forward is what it is, the feedback takes the rest."""
    plant = problem_a(source=PowerSource())
    gains = Correction(Kp=100.0, Ki=50.0, law=PidLaw(high=6.0))
    made = Feedforward(model=plant, measured="position", reference=Constant(level=1e-3), lookahead=0.5, feedback=gains)
    hand = ManualMode(signal=Constant(level=0.8), automatic_from=9.5 * DT)
    found = played(made.with_parts(manual=hand), [{"position": 1e-3}] * 11)
    without = played(made, [{"position": 1e-3}] * 11)
    assert abs(found[10] - 0.8) < 0.1 < abs(without[10] - 0.8)


def test_gains_that_change_do_not_step_the_signal() -> None:
    """The schedule jumps from Kp = 2 to 9 as the reference turns; without Ki nothing could take the step."""
    up, down = (GainSchedule(all=GainsAt(at=0.0, Kp=Kp, Ki=1.0)) for Kp in (2.0, 9.0))
    values: dict[str, Any] = {"measured": "y", "reference": held(*[0.5] * 5, *[0.49] * 5), "law": WIDE}
    direct = ScheduledPid(rising=up, falling=down, **values)
    bumpless = direct.with_parts(gain_change="bumpless")
    readings = [{"y": 0.2}] * 10
    one, other = played(direct, readings), played(bumpless, readings)
    assert one[5] - one[4] > 2.0
    assert other[5] - other[4] == pytest.approx(-9.0 * 0.01 + 0.29 * DT, abs=1e-12)
    np.testing.assert_allclose(other[:5], one[:5], rtol=1e-14)
    proportional = (ScheduledPid(rising=GainSchedule(all=GainsAt(at=0.0, Kp=2.0)), falling=down, **values)).with_parts(
        gain_change="bumpless", falling=GainSchedule(all=GainsAt(at=0.0, Kp=9.0))
    )
    assert played(proportional, readings)[-1] == pytest.approx(9.0 * 0.29)


# ---------------------------------------------------------------- slew


def test_a_slew_limit_cuts_the_signal_and_holds_the_integral() -> None:
    """A step of 1 with Kp = 1: 2 per second up, as fast as it wants down; what was cut off is not made up for."""
    reference = held(0.0, *[1.0] * 30, *[0.0] * 10)
    pid = Pid(measured="y", reference=reference, Kp=1.0, Ki=1.0, law=WIDE, slew=SignalSlew(rising=2.0))
    found = played(pid, [{"y": 0.0}] * 41)
    assert np.diff(found)[:25] == pytest.approx(np.full(25, 2.0 * DT))
    assert np.diff(found)[25:30] == pytest.approx(np.full(5, DT)), "then as the integral does"
    assert found[31] == pytest.approx(5 * DT)
    slow = pid.with_parts(slew=SignalSlew(falling=3.0))
    assert np.diff(played(slow, [{"y": 0.0}] * 41))[30:33] == pytest.approx(np.full(3, -3.0 * DT))


# ---------------------------------------------------------------- filters


@pytest.mark.parametrize(("order", "system"), [("1", ([1.0], [0.3, 1.0])), ("2", ([1.0], [0.045, 0.3, 1.0]))])
def test_a_filter_is_its_low_pass_as_samples_get_short(order: str, system: Any) -> None:
    one, errors = ReadingFilter(time_constant=0.3, order=order), []
    times, expected = step(lti(*system), T=np.linspace(0.0, 1.5, 601))
    for every in (4, 1):
        dt, memory, found = 0.0025 * every, one.rest(0.0), [0.0]
        for _ in times[every::every]:
            memory = one.filter(floats, memory, 1.0, dt)
            found.append(memory[0])
        errors.append(np.abs(np.array(found) - expected[::every]).max())
    assert errors[1] < 0.01
    assert errors[0] / errors[1] == pytest.approx(4.0, rel=0.15)


def test_a_median_leaves_single_spikes_out_and_the_controller_sees_what_is_filtered() -> None:
    spiky = ReadingFilter(time_constant=1e-9, median="of-three")
    pid = Pid(measured="y", reference=Constant(level=0.0), Kp=-1.0, law=WIDE, reading_filter=spiky)
    assert pid.needs() == ("y",)
    values = [1.0, 1.0, 50.0, 1.0, 1.0, 2.0, 2.0, 2.0]
    assert played(pid, [{"y": v} for v in values]) == pytest.approx([1, 1, 1, 1, 1, 1, 2, 2], abs=1e-6)


# ---------------------------------------------------------------- shaped references


def test_a_reference_goes_at_its_rate_and_brakes_in_time() -> None:
    """A trapezium: 1 at 0.5 per second, with 2 per second squared; its time is d/V + V/A."""
    found = shaped(ReferenceShaping(rate=0.5, acceleration=2.0), np.ones(140))
    rate = np.diff(found, prepend=0.0) / DT
    assert rate.max() == pytest.approx(0.5)
    assert found.max() <= 1.0 and found[-1] == pytest.approx(1.0, abs=1e-12)
    assert np.abs(np.diff(rate, prepend=0.0)).max() <= 1.126 * 2.0 * DT
    assert DT * np.argmax(found > 1.0 - 1e-9) == pytest.approx(1.0 / 0.5 + 0.5 / 2.0, abs=3 * DT)
    back = shaped(ReferenceShaping(rate=0.5, acceleration=2.0), np.repeat([1.0, -0.2], [50, 150]))
    assert back[-1] == pytest.approx(-0.2, abs=1e-12) and back.min() >= -0.2 - 1e-12
    ramp = shaped(ReferenceShaping(rate=0.5), np.ones(110))
    assert ramp[:99] == pytest.approx(0.5 * DT * np.arange(1, 100))


def test_a_lag_is_a_prefilter() -> None:
    found = shaped(ReferenceShaping(lag=0.5), np.ones(2000), dt=1e-3)
    np.testing.assert_allclose(found, 1.0 - np.exp(-1e-3 * np.arange(1, 2001) / 0.5), atol=5e-4)


def test_a_controller_that_is_unsure_goes_slower_and_then_stops() -> None:
    """Its rate is that of κ: 1 from 0.8 on, half at 0.55, none below 0.3."""
    sure = np.repeat([0.9, 0.55, 0.2, 1.0], 20)
    shaping = ReferenceShaping(rate=0.5, confidence="estimated.confidence")
    found = shaped(shaping, np.full(80, 9.0), **{"estimated.confidence": sure})
    rate = np.diff(found, prepend=0.0) / DT
    assert rate == pytest.approx(np.repeat([0.5, 0.25, 0.0, 0.5], 20))
    pid = Pid(measured="y", reference=Constant(level=9.0), Kp=1.0, Ki=1.0, law=WIDE, shaping=shaping)
    assert pid.needs() == ("y", "estimated.confidence")
    safe = pid.with_parts(shaping=shaping.with_parts(below="safe", safe=0.05))
    readings = [{"y": 0.0, "estimated.confidence": one} for one in sure.tolist()]
    signals = played(safe, readings)
    assert signals[40:60].tolist() == [0.05] * 20, "the safe signal, below `stop`"
    assert abs(signals[60] - 0.05) < 0.02, "and on from there"
    with pytest.raises(ParameterError, match=r"`estimated\.confidence`"):
        played(pid, [{"y": 0.0}])


@pytest.mark.parametrize(
    ("make", "said"),
    [
        (lambda: ReferenceShaping(confidence="c"), "give one"),
        (lambda: ReferenceShaping(rate=1.0, below="safe"), "needs the name"),
        (lambda: ReferenceShaping(rate=1.0, stop=0.9), "must be below `full`"),
        (lambda: SignalSlew(), "needs a rate"),
        (lambda: ManualMode(automatic_from=2.0, automatic_until=1.0), "must be before"),
        (lambda: Pid(measured="y", reference=Constant(level=0.0), Kp=1.0, Ki=1.0, Ti=1.0), "not both"),
        (lambda: Pid(measured="y", reference=Constant(level=0.0), Kp=1.0, Ti=1.0, gains_are="per-sample"), "seconds"),
    ],
)
def test_what_contradicts_itself_is_refused(make: Any, said: str) -> None:
    with pytest.raises(ParameterError, match=said):
        make()
