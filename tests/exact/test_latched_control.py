"""Latched ON/OFF control along made-up records, and in the loop with a motor on a beam."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from martensite.actuators.assembly import Machine
from martensite.actuators.mechanisms.beam_motor import BeamMotor
from martensite.base.errors import ParameterError
from martensite.control.controllers.latched_on_off import LatchedOnOff, replay_controller
from martensite.signals.constant import Constant
from martensite.simulate.controlled_run import simulate_controlled

TIMES = [k / 200.0 for k in range(2001)]


def record(envelope: Any) -> dict[str, list[float]]:
    """A speed that rises by 1 per second, and an oscillation of 8 Hz."""
    wave = [envelope(t) * math.sin(2.0 * math.pi * 8.0 * t) + 0.3 for t in TIMES]
    return {"speed": TIMES, "x": wave}


def controller(threshold: float = 2.0, **changes: Any) -> LatchedOnOff:
    numbers: dict[str, Any] = {"measured": "speed", "oscillation": "x", "share": 0.3, "high": 1.1}
    return LatchedOnOff(reference=Constant(level=threshold), **(numbers | changes))


def switched(signals: list[float]) -> list[float]:
    """Times at which the signal changes."""
    pairs = zip(TIMES[1:], signals, signals[1:], strict=False)
    return [t for t, before, after in pairs if before != after]


def test_on_from_the_threshold_and_off_when_the_oscillation_dies() -> None:
    """The amplitude passes 30 % of its peak at 5 + ln(1/0.3) = 6.2 s, judged every 0.25 s."""
    signals = replay_controller(controller(), TIMES, record(lambda t: min(math.exp(5.0 - t), 1.0)))
    on, off = switched(signals)
    assert on == pytest.approx(2.0, abs=0.006)
    assert 6.2 < off < 6.76
    assert set(signals) == {0.0, 1.1}


def test_it_stays_off() -> None:
    signals = replay_controller(controller(), TIMES, record(lambda t: 0.1 if 4.0 < t < 6.0 else 1.0))
    assert len(switched(signals)) == 2
    assert signals[-1] == 0.0


def test_what_was_before_the_threshold_does_not_count() -> None:
    signals = replay_controller(controller(), TIMES, record(lambda t: 5.0 if t < 1.0 else 1.0))
    assert len(switched(signals)) == 1
    assert signals[-1] == 1.1


def test_a_larger_share_switches_off_earlier() -> None:
    fading = record(lambda t: min(math.exp(5.0 - t), 1.0))
    offs = [switched(replay_controller(controller(share=s), TIMES, fading))[1] for s in (0.1, 0.3, 0.8)]
    assert offs == sorted(offs, reverse=True)
    assert offs[0] > offs[2]


def test_unknown_outputs_are_refused() -> None:
    with pytest.raises(ParameterError, match="Did you mean `speed`"):
        replay_controller(controller(measured="sped"), TIMES, record(lambda t: 1.0))


class Brake(LatchedOnOff):
    """Takes the motor's voltage away when it runs faster than the threshold."""

    def __call__(self, time: float, measurement: Any, memory: Any) -> tuple[float, Any]:
        signal, memory = super().__call__(time, measurement, memory)
        return 4.0 - signal, memory


def test_in_the_loop() -> None:
    """The same switching times as in a replay of the run that it made itself."""
    motor = BeamMotor(
        mass=0.2,
        stiffness=541.0,
        damping=2.0,
        unbalance=0.012,
        eccentricity=0.02,
        rotor_inertia=0.82e-4,
        torque_constant=0.0211,
        back_emf=0.0211,
        resistance=6.22,
        inductance=3.1e-3,
    )
    brake = Brake(
        measured="rotor_speed", reference=Constant(level=30.0), oscillation="displacement", share=0.5, high=3.75
    )
    run = simulate_controlled(Machine(mechanism=motor), {"motor": brake}, 6.0, 0.01, step=1e-3, every=1)
    volts = np.array(run["motor"])
    changes = np.flatnonzero(np.diff(volts))
    assert volts[[0, changes[0] + 1, -1]].tolist() == [4.0, 0.25, 4.0]
    again = replay_controller(brake, run.times, run.columns)
    assert np.array(again)[:-1] == pytest.approx(volts[:-1])


def test_constant_drives_replay_themselves() -> None:
    assert replay_controller(Constant(level=2.0), [0.0, 1.0], {}) == [2.0, 2.0]
