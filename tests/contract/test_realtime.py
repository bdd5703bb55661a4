"""The loop of a bench without its plant does, sample by sample, what the bench does in a run.

Source of truth: runs of the bench itself, of which the loop gets the readings and nothing else.
"""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
import pytest
from builders import problem_a

from martensite.base.errors import ParameterError
from martensite.base.parameters import Number, param
from martensite.control.controllers.base import AbstractController, Readings
from martensite.control.controllers.conditioning import ManualMode, ReadingFilter, SignalSlew
from martensite.control.controllers.pid import Pid
from martensite.control.controllers.shaping import ReferenceShaping
from martensite.control.loop.bench import Bench
from martensite.control.loop.parts import (
    AbstractSupervisor,
    Column,
    Controllers,
    MountedSensor,
    Named,
    Observers,
    Sensors,
    SupervisorVerdict,
)
from martensite.control.loop.realtime import RealtimeStep
from martensite.control.loop.run import simulate_bench
from martensite.control.observers.extended import ExtendedKalman
from martensite.control.sensors.position import PositionSensor
from martensite.kernels.compiler import find_compiler
from martensite.kernels.namespace import Namespace, Scalar
from martensite.physics.electrical.switches import PwmVoltage
from martensite.signals.constant import Constant
from martensite.signals.sine import Sine
from martensite.simulate.result import Result

MM, PERIOD, DURATION = 1e-3, 0.05, 3.0
SYSTEM = problem_a().with_parts(source=PwmVoltage(supply=6.0))
COURSE = Sine(low=1 * MM, high=5 * MM, frequency=0.5)
NATIVE = [pytest.param(True, marks=pytest.mark.skipif(find_compiler() is None, reason="no C compiler")), False]


class Ceiling(AbstractSupervisor):
    """Cuts for good once a reading has been above a ceiling; the alarm counts periods since."""

    ceiling: Number = param("m", "what cuts")

    def reads(self) -> tuple[str, ...]:
        return ("position",)

    def rest(self, xp: Namespace, readings: Named) -> Column:
        return (0.0,)

    def judge(self, xp: Namespace, memory: Column, wanted: Named, readings: Named, dt: Scalar) -> SupervisorVerdict:
        over = xp.either(readings["position"] > self.ceiling, memory[0] > 0.0)
        count = xp.where(over, memory[0] + 1.0, 0.0)
        return SupervisorVerdict({n: xp.where(over, 0.0, u) for n, u in wanted.items()}, count, (count,))


class Older(AbstractController):
    """Answers with the age of its reading, and how often it was asked."""

    def rest(self, xp: Namespace, reference: Scalar, readings: Readings) -> Column:
        return (0.0,)

    def answer(
        self, xp: Namespace, memory: Column, reference: Scalar, readings: Readings, dt: Scalar
    ) -> tuple[Scalar, Column]:
        return readings["position.age"] + 0.001 * memory[0], (memory[0] + 1.0,)


def pid(measured: str = "position") -> Pid:
    return Pid(measured=measured, reference=COURSE, Kp=150.0, Ki=6.0 / PERIOD, Kd=20.0 * PERIOD)


def bench(controller: AbstractController, delay: float = 0.0, **parts: object) -> Bench:
    sensor = MountedSensor(sensor=PositionSensor(noise=0.02 * MM), delay=delay)
    return Bench(
        plant=SYSTEM,
        period=PERIOD,
        substeps=1,
        sensors=Sensors(position=sensor),
        controllers=Controllers(drive=controller),
        **parts,
    )


@cache
def loops() -> dict[str, Bench]:
    observers = Observers(ekf=ExtendedKalman(model=SYSTEM, measured=("position",), reading_deviation=0.02 * MM))
    around = {
        "reading_filter": ReadingFilter(time_constant=0.1, order="2", median="of-three"),
        "shaping": ReferenceShaping(rate=2 * MM, acceleration=8 * MM),
        "manual": ManualMode(signal=Constant(level=0.3), automatic_from=0.52, automatic_until=2.4),
        "slew": SignalSlew(rising=1.0),
    }
    return {
        "conditioned": bench(pid().with_parts(**around)),
        "pid": bench(pid()),
        "supervised": bench(pid(), supervisor=Ceiling(ceiling=4 * MM)),
        "observer": bench(pid("estimated.position"), observers=observers),
    }


@cache
def run(name: str) -> Result:
    return simulate_bench(loops()[name], DURATION, seed=3, runtime="floats")


def played(loop: RealtimeStep, readings: Any) -> np.ndarray:
    return np.array([loop.step({"position": y})[0] for y in readings])


@pytest.mark.parametrize("native", NATIVE)
@pytest.mark.parametrize("name", ["pid", "supervised", "observer", "conditioned"])
def test_it_does_what_the_bench_does(name: str, native: bool) -> None:
    found = run(name)
    signals = played(RealtimeStep(loops()[name], native), found["measured.position"])
    wanted = np.array(found["drive"])
    assert np.ptp(wanted) > 0.1
    np.testing.assert_allclose(signals, wanted, rtol=0.0, atol=1e-7)


def test_what_stands_around_a_controller_runs_in_c_as_on_floats() -> None:
    """By hand, then shaped and slewed, then by hand again; `shaped` is what is followed."""
    one, other = run("conditioned"), simulate_bench(loops()["conditioned"], DURATION, seed=3, runtime="c")
    for name in ("position", "drive", "shaped"):
        span = np.ptp(one[name])
        assert span > 0.0
        np.testing.assert_allclose(one[name], other[name], rtol=0.0, atol=1e-9 * span)
    signals = np.array(one["drive"])
    assert signals[8:10].tolist() == signals[-3:].tolist()[:2] == [0.3, 0.3]
    assert abs(signals[11] - 0.3) < 0.02 and np.diff(signals).max() <= PERIOD * (1.0 + 1e-9)


@pytest.mark.parametrize("native", NATIVE)
def test_a_hand_takes_the_signal_and_gives_it_back_without_a_bump(native: bool) -> None:
    loop = RealtimeStep(bench(pid().with_parts(manual=ManualMode())), native)
    found = [loop.step([1 * MM], references=[2 * MM])[0] for _ in range(5)]
    loop.set_manual()
    assert [loop.step([1 * MM], references=[2 * MM])[0] for _ in range(3)] == [found[-1]] * 3
    loop.set_manual(0.05)
    assert [loop.step([1 * MM], references=[2 * MM])[0] for _ in range(3)] == [0.05] * 3
    loop.set_automatic()
    after = [loop.step([1 * MM], references=[2 * MM])[0] for _ in range(2)]
    assert after == pytest.approx([0.05 + k * 6.0 * MM for k in (1, 2)]), "Ki h e a sample, from the signal by hand"
    with pytest.raises(ParameterError, match="`manual` part"):
        RealtimeStep(loops()["pid"], native).set_manual(0.1)


def test_readings_of_another_run_give_other_signals() -> None:
    found = run("pid")
    other = np.array(found["measured.position"]) + 0.1 * MM
    signals = played(RealtimeStep(loops()["pid"]), other.tolist())
    assert np.max(np.abs(signals - np.array(found["drive"]))) > 1e-3


def test_the_supervisor_cuts_and_tells() -> None:
    loop, found = RealtimeStep(loops()["supervised"]), run("supervised")
    played(loop, found["measured.position"])
    assert loop.state.alarm == found["alarm"][-1] > 1.0
    assert loop.state.signals == (0.0,)
    assert loop.state.controllers[0].wanted == pytest.approx(found["wanted"][-1])


def test_estimates_are_those_of_the_bench() -> None:
    loop, found = RealtimeStep(loops()["observer"]), run("observer")
    played(loop, found["measured.position"])
    for name in ("estimated.temperature", "estimated.martensite_fraction"):
        assert loop.estimates[name] == pytest.approx(found[name][-1], rel=1e-7)


def test_reset_begins_anew() -> None:
    loop, readings = RealtimeStep(loops()["pid"]), run("pid")["measured.position"]
    first = played(loop, readings)
    loop.reset()
    assert np.array_equal(played(loop, readings), first)


@pytest.mark.parametrize("native", NATIVE)
def test_late_readings_are_told_their_age(native: bool) -> None:
    loop = RealtimeStep(bench(Older(measured="position", reference=COURSE), delay=0.1), native)
    ages = [0.0, 0.05, 0.1, 0.1]
    found = [loop.step({"position": 0.0, "position.age": age})[0] for age in ages]
    assert found == pytest.approx([0.0, 0.051, 0.102, 0.103])


def test_references_may_be_given() -> None:
    loop = RealtimeStep(loops()["pid"])
    assert loop.step([0.0], references=[0.0]) == (0.0,)
    loop.reset()
    assert loop.step([0.0], references=[1 * MM])[0] == pytest.approx(150.0 * MM)
    assert (loop.readings, loop.drives, loop.free) == (("position",), ("drive",), ())


# ---------------------------------------------------------------- errors


def test_a_missing_reading_is_named_with_the_nearest() -> None:
    with pytest.raises(ParameterError, match=r"`position`.*`postion`"):
        RealtimeStep(loops()["pid"]).step({"postion": 0.0})


def test_readings_in_order_must_be_all() -> None:
    with pytest.raises(ParameterError, match="needs 1 readings"):
        RealtimeStep(loops()["pid"]).step([0.0, 1.0])


def test_before_its_first_step_it_has_no_state() -> None:
    with pytest.raises(ParameterError, match="before its first step"):
        _ = RealtimeStep(loops()["pid"]).state
