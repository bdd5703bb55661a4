"""Scheduled gains, sliding mode, two levels, cascade, direct: what their equations say.

Sources of truth: interpolation and switching rules by hand, and closed forms on a mass without
friction, ÿ = u + d, which a sliding mode must bring along e' = -λ e to the error Φ d/(K λ).
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import pytest
from builders import problem_a

from martensite.base.errors import ParameterError
from martensite.control.controllers.base import AbstractController
from martensite.control.controllers.cascade import Cascade, InnerPid, OuterPid
from martensite.control.controllers.pid import Pid, PidLaw
from martensite.control.controllers.relay import Direct, TwoLevel
from martensite.control.controllers.scheduled_pid import GainsAt, GainSchedule, ScheduledPid
from martensite.control.controllers.sliding_mode import SlidingMode
from martensite.kernels import floats
from martensite.physics.electrical.sources import PowerSource
from martensite.signals.base import AbstractWaveform
from martensite.signals.constant import Constant
from martensite.signals.held import Held
from martensite.simulate.controlled_run import simulate_controlled

DT = 0.01
WIDE = PidLaw(low=-1e6, high=1e6)


def played(controller: AbstractController, values: Sequence[float], **others: Sequence[float]) -> list[float]:
    """Signals for readings `y`, and others by name, at the starts of periods of 10 ms."""
    memory, found = controller.init(), list[float]()
    for k, value in enumerate(values):
        readings = {"y": value} | {name: column[k] for name, column in others.items()}
        signal, memory = controller(k * DT, readings, memory)
        found.append(signal)
    return found


def held(*values: float) -> AbstractWaveform:
    """One value per period."""
    return Held(values=values, frequency=1.0 / DT)


ZERO = Constant(level=0.0)

# ---------------------------------------------------------------- scheduled gains

TABLE = GainSchedule(
    a=GainsAt(at=0.0, Kp=1.0, Ki=0.0, Kd=8.0),
    b=GainsAt(at=10.0, Kp=3.0, Ki=2.0, Kd=4.0),
    c=GainsAt(at=30.0, Kp=2.0, Ki=6.0, Kd=4.0),
)


@pytest.mark.parametrize(
    ("at", "expected"),
    [
        (-5.0, (1.0, 0.0, 8.0)),
        (0.0, (1.0, 0.0, 8.0)),
        (2.5, (1.5, 0.5, 7.0)),
        (10.0, (3.0, 2.0, 4.0)),
        (20.0, (2.5, 4.0, 4.0)),
        (30.0, (2.0, 6.0, 4.0)),
        (99.0, (2.0, 6.0, 4.0)),
    ],
)
def test_gains_are_straight_between_points_and_level_beyond(at: float, expected: tuple[float, ...]) -> None:
    assert TABLE.gains(floats, at) == pytest.approx(expected, abs=1e-14)


@pytest.mark.parametrize("kind", ["per-sample", "in-seconds"])
def test_with_one_point_it_is_a_pid_controller(kind: str) -> None:
    values = np.random.default_rng(3).standard_normal(60).cumsum().tolist()
    rest: dict[str, Any] = {
        "measured": "y",
        "reference": held(*reversed(values)),
        "gains_are": kind,
        "law": PidLaw(low=-9.0, high=9.0, filter=DT),
    }
    one = GainSchedule(all=GainsAt(at=0.0, Kp=2.0, Ki=0.3, Kd=0.4))
    scheduled = ScheduledPid(rising=one, **rest)
    assert played(scheduled, values) == played(Pid(Kp=2.0, Ki=0.3, Kd=0.4, **rest), values)


def test_a_reading_decides_about_the_gains() -> None:
    controller = ScheduledPid(
        measured="y",
        reference=Constant(level=1.0),
        over="z",
        law=WIDE,
        rising=GainSchedule(a=GainsAt(at=0.0, Kp=1.0), b=GainsAt(at=10.0, Kp=3.0)),
    )
    assert controller.reads() == ("y", "z")
    assert played(controller, [0.0] * 4, z=[-1.0, 0.0, 5.0, 20.0]) == [1.0, 1.0, 2.0, 3.0]


def test_rising_and_falling_follow_the_reference_not_the_error() -> None:
    """Falling gains from the first fall on, through the hold, until it rises again."""
    controller = ScheduledPid(
        measured="y",
        reference=held(5.0, 6.0, 6.0, 4.0, 4.0, 4.5, 4.5),
        law=WIDE,
        rising=GainSchedule(all=GainsAt(at=0.0, Kp=1.0)),
        falling=GainSchedule(all=GainsAt(at=0.0, Kp=10.0)),
    )
    assert played(controller, [7.0] * 7) == [-20.0, -1.0, -1.0, -30.0, -30.0, -2.5, -2.5]


def test_a_schedule_must_ascend() -> None:
    with pytest.raises(ParameterError, match="must ascend, but 1 comes after 2"):
        GainSchedule(a=GainsAt(at=2.0, Kp=1.0), b=GainsAt(at=1.0, Kp=1.0))
    with pytest.raises(ParameterError, match="at least one point"):
        GainSchedule()


# ---------------------------------------------------------------- sliding mode

GAIN, SLOPE, LAYER, PUSH = 20.0, 3.0, 0.5, 4.0


def sliding(**changes: Any) -> SlidingMode:
    numbers: dict[str, Any] = {"gain": GAIN, "slope": SLOPE, "layer": LAYER, "low": -50.0, "high": 50.0, "filter": 0.0}
    return SlidingMode(measured="y", reference=Constant(level=1.0), **(numbers | changes))


def on_a_mass(controller: AbstractController, push: float, time: float = 12.0) -> np.ndarray:
    """Errors of ÿ = u + push from rest, solved exactly from sample to sample of 1 ms."""
    dt, y, v, memory = 1e-3, 0.0, 0.0, controller.init()
    errors = []
    for k in range(round(time / dt)):
        errors.append(1.0 - y)
        u, memory = controller(k * dt, {"y": y}, memory)
        y, v = y + v * dt + 0.5 * (u + push) * dt**2, v + (u + push) * dt
    return np.array(errors)


@pytest.mark.parametrize("boundary", ["saturation", "tanh"])
def test_along_the_surface_the_error_decays_with_its_slope(boundary: str) -> None:
    errors = on_a_mass(sliding(boundary=boundary, layer=0.01), 0.0, 2.0)
    at = np.array([600, 1000, 1400])
    rates = -np.diff(np.log(errors[at])) / 0.4
    assert rates == pytest.approx([SLOPE, SLOPE], rel=0.02)


def test_a_disturbance_leaves_the_error_of_the_boundary_layer() -> None:
    assert on_a_mass(sliding(), -PUSH)[-1] == pytest.approx(LAYER * PUSH / (GAIN * SLOPE), rel=1e-3)


@pytest.mark.parametrize(
    "change",
    [
        {"integral": "with"},
        {"equivalent": "filtered", "lag": 0.5},
        {"offset": PUSH},
        {"offset": 1.0, "per_reference": PUSH - 1.0},
    ],
)
def test_integral_and_equivalent_signal_take_it_away(change: dict[str, Any]) -> None:
    """To less than a thousandth of what it is without."""
    assert abs(on_a_mass(sliding(**change), -PUSH)[-1]) < 1e-3 * LAYER * PUSH / (GAIN * SLOPE)


def test_it_cannot_hold_what_is_stronger() -> None:
    assert abs(on_a_mass(sliding(), -1.5 * GAIN, 2.0)[-1]) > 1.0


def test_the_integral_rests_at_a_limit() -> None:
    controller = sliding(integral="with", low=0.0, high=1.0)
    memory = controller.rest(floats, 1.0, {"y": 0.0})
    after: Any = controller.answer(floats, memory, 1.0, {"y": 0.0}, DT)[1]
    assert after.integral == 0.0
    free: Any = sliding(integral="with").answer(floats, memory, 1.0, {"y": 0.0}, DT)[1]
    assert free.integral == DT


# ---------------------------------------------------------------- two levels, direct


def test_two_levels() -> None:
    controller = TwoLevel(measured="y", reference=Constant(level=10.0), far=2.0, high=5.0, near=1.0)
    values = [0.0, 8.0, 8.01, 9.99, 10.0, 12.0, 9.0]
    assert played(controller, values) == [5.0, 5.0, 1.0, 1.0, 0.0, 0.0, 1.0]
    other = controller.with_parts(sign="-1")
    assert played(other, [8.0, 10.0, 11.0, 12.0]) == [0.0, 0.0, 1.0, 5.0]


def test_the_level_near_the_target_lies_between() -> None:
    with pytest.raises(ParameterError, match="must be between 0 and 5, but is 6"):
        TwoLevel(measured="y", reference=ZERO, far=1.0, high=5.0, near=6.0)


def test_direct_is_a_straight_line() -> None:
    controller = Direct(reference=held(0.0, 1.0, -2.0), gain=3.0, offset=0.5)
    assert played(controller, [7.0] * 3) == [0.5, 3.5, -5.5]


# ---------------------------------------------------------------- cascade


def cascade(start: float = 300.0, most: float = 60.0, **inner: Any) -> Cascade:
    numbers: dict[str, Any] = {"Kp": 0.5, "Ki": 0.4, "law": PidLaw(high=12.0)}
    return Cascade(
        measured="position",
        reference=Constant(level=0.002),
        start=start,
        outer=OuterPid(Kp=2e4, Ki=3e4, law=PidLaw(high=most)),
        inner=InnerPid(**numbers | inner),
    )


def test_a_cascade_is_one_pid_behind_another() -> None:
    """Until the inner one is at a limit; by two controllers of their own."""
    rng = np.random.default_rng(5)
    y, T = 1e-3 * rng.random(40), 300.0 + rng.random(40)
    whole = cascade(law=WIDE)
    found = []
    memory = whole.init()
    for k in range(40):
        signal, memory = whole(k * DT, {"position": y[k], "temperature": T[k]}, memory)
        found.append(signal)
    outer = Pid(measured="y", reference=whole.reference, Kp=2e4, Ki=3e4, law=PidLaw(high=60.0))
    target = held(*(300.0 + added for added in played(outer, y.tolist())))
    inner = Pid(measured="y", reference=target, Kp=0.5, Ki=0.4, law=WIDE)
    assert found == pytest.approx(played(inner, T.tolist()), rel=1e-12)


@pytest.mark.parametrize(("temperature", "moves"), [(339.0, True), (200.0, False)])
def test_the_outer_integral_waits_for_the_inner_signal(temperature: float, moves: bool) -> None:
    controller, readings = cascade(), {"position": 0.0, "temperature": temperature}
    memory = controller.rest(floats, 0.002, readings)
    signal, after = controller.answer(floats, memory, 0.002, readings, DT)
    assert (signal < 12.0) == moves
    assert (after[0] > 0.0) == moves


def test_a_cascade_moves_a_wire_and_keeps_it_from_getting_hot() -> None:
    """A position within reach is reached; one out of reach ends at the largest temperature."""
    system = problem_a(source=PowerSource())
    near = simulate_controlled(system, {"drive": cascade()}, 12.0, 0.02)
    assert near["position"][-1] == pytest.approx(0.002, rel=1e-3)
    far = cascade().with_parts(reference=Constant(level=0.05))
    found = simulate_controlled(system, {"drive": far}, 12.0, 0.02)
    assert found["temperature"][-1] == pytest.approx(360.0, abs=0.5)
    assert max(found["temperature"]) < 370.0
