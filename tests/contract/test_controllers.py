"""Every registered controller closes a loop in C as on plain floats, within its limits.

What a controller promises is in `martensite.testing.controllers`; here each one is tuned so that
the wire of problem A moves under it.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
import pytest
from builders import problem_a

from martensite.actuators.assembly import System
from martensite.control.controllers.base import CONTROLLERS, AbstractController
from martensite.control.controllers.cascade import Cascade, InnerPid, OuterPid
from martensite.control.controllers.constant_power import ConstantPower
from martensite.control.controllers.disturbance_observer import DisturbanceObserver
from martensite.control.controllers.feedforward import Feedforward
from martensite.control.controllers.inverse_play import InversePlay
from martensite.control.controllers.iterative_learning import IterativeLearning
from martensite.control.controllers.latched_on_off import LatchedOnOff
from martensite.control.controllers.mpc import Mpc
from martensite.control.controllers.pid import Correction, Pid, PidLaw
from martensite.control.controllers.planning import Price
from martensite.control.controllers.relay import Direct, OnOff, TwoLevel
from martensite.control.controllers.relay_tuning import RelayTuning
from martensite.control.controllers.repetitive import Repetitive
from martensite.control.controllers.scheduled_pid import GainsAt, GainSchedule, ScheduledPid
from martensite.control.controllers.sliding_mode import SlidingMode
from martensite.control.controllers.state_feedback import StateFeedback
from martensite.control.loop.bench import Bench
from martensite.control.loop.parts import Controllers
from martensite.control.loop.run import open_loop, simulate_bench
from martensite.physics.electrical.switches import PwmVoltage
from martensite.scenario.citations import read_bibliography
from martensite.signals.base import AbstractWaveform
from martensite.signals.constant import Constant
from martensite.signals.held import Held

PERIOD, SAMPLES = 0.02, 200
MM, HOT = 1e-3, 330.0


def course(*levels: float) -> Held:
    """A reference that goes straight from level to level, held for a period.

    Held, because a bench reads a reference a hair after a sample, and a drive at it.
    """
    times = PERIOD * np.arange(SAMPLES + 1)
    values = np.interp(times, [0.1, 0.5, 2.5, 4.0], levels)
    return Held(values=tuple(values.tolist()), frequency=1.0 / PERIOD)


COURSE = course(0.0, 4.0 * MM, 1.0 * MM, 2.5 * MM)
"""Position, up and down [m]."""


@cache
def plant() -> System:
    return problem_a(source=PwmVoltage(supply=6.0))


@dataclass(frozen=True)
class Case:
    """A controller to try: how it is made for a reference, that, and limits of its signal."""

    make: Callable[[AbstractWaveform], AbstractController]
    course: AbstractWaveform = COURSE
    limits: tuple[float, float] = (0.0, 1.0)
    samples: int = SAMPLES


def position(cls: Any, **given: Any) -> Callable[[AbstractWaveform], AbstractController]:
    """A controller of the position, but for its reference."""
    return lambda reference: cls(measured="position", reference=reference, **given)


UP = GainSchedule(low=GainsAt(at=290.0, Kp=400.0, Ki=200.0, Kd=1.8), high=GainsAt(at=HOT, Kp=250.0, Ki=100.0))
DOWN = GainSchedule(all=GainsAt(at=0.0, Kp=800.0, Ki=50.0))
OUTER = OuterPid(Kp=2e4, Ki=2500.0, law=PidLaw(low=0.0, high=80.0))
INNER = InnerPid(Kp=0.05, Ki=0.4)
TASK: dict[str, Any] = {"Kp": 400.0, "Ki": 200.0, "period": PERIOD, "task": 0.7, "points": 20, "lead": 0.1}
CASES: dict[str, Case] = {
    "cascade": Case(position(Cascade, start=293.15, outer=OUTER, inner=INNER)),
    "constant-power": Case(lambda reference: ConstantPower(reference=reference), course(2.0, 6.0, 0.0, 3.0)),
    "direct": Case(lambda reference: Direct(reference=reference, gain=0.1), course(0.0, 4.0, 1.0, 2.5)),
    "disturbance-observer": Case(
        position(
            DisturbanceObserver,
            period=PERIOD,
            model_gain=0.02,
            time_constant=1.0,
            dead_time=0.1,
            filter_time=0.3,
            Kp=300.0,
        )
    ),
    "feedforward": Case(
        position(Feedforward, model=plant(), lookahead=0.5, slope_weight=0.0, iterations=2), samples=40
    ),
    "inverse-play": Case(
        position(
            InversePlay,
            thresholds=(0.05, 0.1),
            weights=(0.6, 0.3, 0.1),
            knots=(0.0, 1.0),
            outputs=(0.0, 5.0 * MM),
            feedback=Correction(Kp=100.0, Ki=50.0, law=PidLaw()),
        )
    ),
    "iterative-learning": Case(position(IterativeLearning, **TASK, learning_gain=400.0, between="reset")),
    "latched": Case(
        position(LatchedOnOff, oscillation="temperature", share=0.5, window=0.2, high=0.8), Constant(level=-1.0)
    ),
    "mpc": Case(position(Mpc, model=plant(), period=PERIOD, horizon=0.2, blocks=2, price=Price(error=MM)), samples=20),
    "on-off": Case(position(OnOff, band=0.2 * MM, high=0.9, low=0.1), limits=(0.1, 0.9)),
    "pid": Case(position(Pid, Kp=400.0, Ki=200.0, Kd=1.8, law=PidLaw(filter=0.04, weight=0.8))),
    "relay-tuning": Case(position(RelayTuning, level=2.0 * MM, skipped=1.0, cycles=1.0, form="pid")),
    "repetitive": Case(position(Repetitive, **TASK)),
    "scheduled-pid": Case(position(ScheduledPid, over="temperature", rising=UP, falling=DOWN)),
    "sliding-mode": Case(
        position(
            SlidingMode, gain=1.0, slope=2.0, layer=20.0 * MM, integral="with", equivalent="filtered", boundary="tanh"
        )
    ),
    "state-feedback": Case(
        position(
            StateFeedback,
            states=("temperature", "position"),
            gains=(0.005, 100.0),
            at=(293.15, 0.0),
            prefilter=250.0,
            Ki=100.0,
        )
    ),
    "two-level": Case(position(TwoLevel, far=1.0 * MM, high=0.9, near=0.4), limits=(0.0, 0.9)),
}
NAMES = sorted(CASES)


def bench(controller: AbstractController) -> Bench:
    return Bench(plant=plant(), period=PERIOD, substeps=1, controllers=Controllers(drive=controller))


@cache
def made(name: str) -> AbstractController:
    return CASES[name].make(CASES[name].course)


@cache
def run(name: str, runtime: str) -> dict[str, np.ndarray]:
    """Columns of a run, without the last sample, at which a drive outside still holds its signal.

    `outside` is the controller on plain floats, beside a bench that is open at its drive.
    """
    whole, duration = bench(made(name)), CASES[name].samples * PERIOD
    if runtime == "outside":
        rest, controller = open_loop(whole, "drive")
        found = simulate_bench(rest, duration, outside={"drive": controller})
    else:
        found = simulate_bench(whole, duration, runtime=runtime)
    names = ("drive", "temperature", "position")
    return {column: np.array(found[column])[:-1] for column in names}


def agree(one: dict[str, np.ndarray], other: dict[str, np.ndarray]) -> None:
    """Raise unless two runs are one, to 1e-9 of the range of each column."""
    for column, values in one.items():
        span = np.ptp(values)
        assert span > 0.0, f"nothing happens to {column}"
        np.testing.assert_allclose(values, other[column], rtol=0.0, atol=1e-9 * span)


# ---------------------------------------------------------------- the contract


@pytest.mark.parametrize("name", NAMES)
def test_on_a_bench_it_does_what_it_does_as_a_drive(name: str) -> None:
    agree(run(name, "floats"), run(name, "outside"))


LARGE = {"feedforward"}
"""Controllers whose programs take long to compile."""


@pytest.mark.parametrize("name", [pytest.param(n, marks=pytest.mark.slow if n in LARGE else ()) for n in NAMES])
def test_c_agrees(name: str) -> None:
    agree(run(name, "floats"), run(name, "c"))


@pytest.mark.parametrize("name", NAMES)
def test_signals_stay_within_their_limits(name: str) -> None:
    low, high = CASES[name].limits
    signals = run(name, "floats")["drive"]
    assert low <= signals.min() < signals.max() <= high


@pytest.mark.parametrize("name", NAMES)
def test_it_is_documented(name: str) -> None:
    cls = CONTROLLERS[name]
    assert (cls.__doc__ or "").strip()
    assert all(declared.doc.strip() for declared in cls.declarations.values())
    assert set(cls.cites) <= set(read_bibliography())
