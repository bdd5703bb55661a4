"""Every registered controller keeps the promises of its interface.

Traced on a bench it does what it does as a drive on plain floats beside that bench; C agrees;
its memory keeps its shape; nothing breaks without time between samples; signals stay within
limits; at rest with nothing to do it does nothing; what it lacks it says. The plant is the wire
of problem A under a switched voltage.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
import pytest
from builders import problem_a

from martensite.actuators.assembly import System
from martensite.base.errors import ParameterError
from martensite.control.controllers.base import CONTROLLERS, AbstractController
from martensite.control.controllers.cascade import Cascade
from martensite.control.controllers.constant_power import ConstantPower
from martensite.control.controllers.correction import Correction
from martensite.control.controllers.direct import Direct
from martensite.control.controllers.feedforward import Feedforward
from martensite.control.controllers.inverse_play import InversePlay
from martensite.control.controllers.latched import LatchedOnOff
from martensite.control.controllers.mpc import Mpc
from martensite.control.controllers.on_off import OnOff
from martensite.control.controllers.pid import Pid, PidGains, PidLaw
from martensite.control.controllers.planning import Price, Search
from martensite.control.controllers.scheduled_pid import GainsAt, Schedule, ScheduledPid
from martensite.control.controllers.sliding_mode import SlidingMode
from martensite.control.controllers.state_feedback import StateFeedback
from martensite.control.controllers.two_level import TwoLevel
from martensite.control.loop.bench import Bench
from martensite.control.loop.parts import Controllers
from martensite.control.loop.run import open_loop, simulate_bench
from martensite.kernels import floats
from martensite.kernels.dual import value_and_slope
from martensite.kernels.nested import flatten_numbers
from martensite.physics.electrical.pwm import PwmVoltage
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
    still: Callable[[dict[str, float]], float] = lambda rest: rest["position"]
    """Reference at which a plant at rest needs nothing."""


def position(cls: Any, **given: Any) -> Callable[[AbstractWaveform], AbstractController]:
    """A controller of the position, but for its reference."""
    return lambda reference: cls(measured="position", reference=reference, **given)


UP = Schedule(
    low=GainsAt(at=290.0, Kp=400.0, Ki=4.0, Kd=90.0), high=GainsAt(at=HOT, Kp=250.0, Ki=2.0)
)
DOWN = Schedule(all=GainsAt(at=0.0, Kp=800.0, Ki=1.0))
OUTER = PidGains(Kp=2e4, Ki=50.0, law=PidLaw(low=0.0, high=80.0))
INNER = PidGains(Kp=0.05, Ki=0.4, gains_are="in-seconds")
CASES: dict[str, Case] = {
    "cascade": Case(position(Cascade, start=293.15, outer=OUTER, inner=INNER)),
    "constant-power": Case(
        lambda reference: ConstantPower(reference=reference),
        course(2.0, 6.0, 0.0, 3.0),
        still=lambda rest: rest["power"],
    ),
    "direct": Case(
        lambda reference: Direct(reference=reference, gain=0.1),
        course(0.0, 4.0, 1.0, 2.5),
        still=lambda rest: rest["drive"],
    ),
    "feedforward": Case(
        position(Feedforward, model=plant(), lookahead=0.5, slope_weight=0.0, iterations=2),
        samples=40,
    ),
    "inverse-play": Case(position(
        InversePlay, thresholds=(0.05, 0.1), weights=(0.6, 0.3, 0.1), knots=(0.0, 1.0),
        outputs=(0.0, 5.0 * MM), feedback=Correction(Kp=100.0, Ki=50.0, law=PidLaw()),
    )),
    "latched": Case(
        position(LatchedOnOff, oscillation="temperature", share=0.5, window=0.2, high=0.8),
        Constant(level=-1.0),
    ),
    "mpc": Case(position(
        Mpc, model=plant(), period=PERIOD, horizon=0.2, blocks=2, price=Price(error=MM),
        search=Search(plans=24, rounds=1),
    )),
    "on-off": Case(position(OnOff, band=0.2 * MM, high=0.9, low=0.1), limits=(0.1, 0.9)),
    "pid": Case(position(Pid, Kp=400.0, Ki=4.0, Kd=90.0, law=PidLaw(filter=2.0, weight=0.8))),
    "scheduled-pid": Case(position(ScheduledPid, over="temperature", rising=UP, falling=DOWN)),
    "sliding-mode": Case(position(
        SlidingMode, gain=1.0, slope=2.0, layer=20.0 * MM, integral="with", equivalent="filtered",
        boundary="tanh",
    )),
    "state-feedback": Case(position(
        StateFeedback, states=("temperature", "position"), gains=(0.005, 100.0), at=(293.15, 0.0),
        prefilter=250.0, Ki=100.0,
    )),
    "two-level": Case(position(TwoLevel, far=1.0 * MM, high=0.9, near=0.4), limits=(0.0, 0.9)),
}  # fmt: skip
NAMES = sorted(CASES)
KERNELS = [name for name in NAMES if CONTROLLERS[name].kernel]


def bench(controller: AbstractController) -> Bench:
    return Bench(
        plant=plant(), period=PERIOD, substeps=1, controllers=Controllers(drive=controller)
    )


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


@cache
def at_rest() -> dict[str, float]:
    """Readings of the plant at rest, and some more at which a memory can be looked at."""
    system = plant()
    seen = system.observe(floats, system.init(floats, 0.0), 0.0)
    return dict(zip(system.outputs(), seen, strict=False))


def resting(name: str) -> tuple[AbstractController, float]:
    """A controller with nothing to do, and its reference."""
    level = CASES[name].still(at_rest())
    return CASES[name].make(Constant(level=level)), level


# ---------------------------------------------------------------- the contract


def test_all_controllers_are_looked_at() -> None:
    ours = [name for name in CONTROLLERS.names() if "martensite." in CONTROLLERS[name].__module__]
    assert ours == NAMES


@pytest.mark.parametrize("name", KERNELS)
def test_on_a_bench_it_does_what_it_does_as_a_drive(name: str) -> None:
    agree(run(name, "floats"), run(name, "outside"))


LARGE = {"feedforward"}
"""Controllers whose programs take long to compile."""


@pytest.mark.parametrize(
    "name", [pytest.param(n, marks=pytest.mark.slow if n in LARGE else ()) for n in KERNELS]
)
def test_c_agrees(name: str) -> None:
    agree(run(name, "floats"), run(name, "c"))


@pytest.mark.parametrize("name", KERNELS)
def test_signals_stay_within_their_limits(name: str) -> None:
    low, high = CASES[name].limits
    signals = run(name, "floats")["drive"]
    assert low <= signals.min() < signals.max() <= high


@pytest.mark.parametrize("name", KERNELS)
def test_its_memory_keeps_its_shape(name: str) -> None:
    keeps_its_shape(made(name))


def keeps_its_shape(controller: AbstractController) -> None:
    """Raise unless what is remembered are so many numbers, whatever is measured."""
    readings = at_rest()
    memory = tuple(flatten_numbers(tuple(controller.rest(floats, MM, readings))))
    for k in range(5):
        found = {name: value * (1.0 + 0.01 * k) for name, value in readings.items()}
        _, after = controller.answer(floats, memory, (k - 2) * MM, found, PERIOD)
        assert len(after) == len(memory)
        assert all(isinstance(value, float | int) for value in after)
        memory = after


@pytest.mark.parametrize("name", KERNELS)
def test_without_time_between_samples_it_answers(name: str) -> None:
    """With finite derivatives with respect to the reference, too."""
    controller, readings = made(name), at_rest()

    def second(xp: Any, reference: Any) -> Any:
        memory = controller.rest(xp, reference, readings)
        for _ in range(2):
            signal, memory = controller.answer(xp, memory, reference, readings, 0.0)
        return signal

    value, slope = value_and_slope(floats, second, 2.0 * MM)
    assert math.isfinite(value)
    assert slope is None or math.isfinite(slope)


@pytest.mark.parametrize("name", KERNELS)
def test_with_nothing_to_do_it_does_nothing(name: str) -> None:
    controller, _ = resting(name)
    memory, signals = controller.init(), list[float]()
    for k in range(20):
        signal, memory = controller(k * PERIOD, at_rest(), memory)
        signals.append(signal)
    assert signals == pytest.approx([CASES[name].limits[0]] * 20, abs=1e-12)


@pytest.mark.parametrize("name", NAMES)
def test_a_missing_reading_is_named_with_the_nearest(name: str) -> None:
    controller = made(name)
    for reading in controller.reads():
        known = {(f"{n}s" if n == reading else n): value for n, value in at_rest().items()}
        sentence = f"cannot measure `{reading}`.*Did you mean `{reading}s`"
        with pytest.raises(ParameterError, match=sentence):
            controller(0.0, known, controller.init())


@pytest.mark.parametrize("name", NAMES)
def test_it_is_documented(name: str) -> None:
    cls = CONTROLLERS[name]
    assert (cls.__doc__ or "").strip()
    assert all(declared.doc.strip() for declared in cls.declarations.values())
    assert set(cls.cites) <= set(read_bibliography())


def test_what_is_no_kernel_stays_off_the_bench() -> None:
    others = sorted(set(NAMES) - set(KERNELS))
    assert others
    for name in others:
        with pytest.raises(ParameterError, match="is no kernel"):
            bench(made(name))


# ---------------------------------------------------------------- the suite can fail


class Timed(Pid):
    """Another controller outside than on the bench."""

    def __call__(self, time: float, measurement: Any, memory: Any) -> tuple[float, Any]:
        signal, memory = super().__call__(time, measurement, memory)
        return signal * (1.0 + 1e-6 * (time > 1.0)), memory


class Growing(Pid):
    """Remembers ever more."""

    def answer(self, xp: Any, memory: Any, *given: Any) -> tuple[Any, Any]:
        signal, after = super().answer(xp, tuple(memory)[:3], *given)
        return signal, (*memory, after[0])


def test_broken_controllers_are_noticed() -> None:
    pid = made("pid")
    given = {name: getattr(pid, name) for name in pid.declarations}
    rest, broken = open_loop(bench(Timed(**given)), "drive")
    found = simulate_bench(rest, SAMPLES * PERIOD, outside={"drive": broken})
    columns = {column: np.array(found[column])[:-1] for column in run("pid", "floats")}
    with pytest.raises(AssertionError, match="Not equal to tolerance"):
        agree(run("pid", "floats"), columns)
    with pytest.raises((AssertionError, TypeError)):
        keeps_its_shape(Growing(**given))
