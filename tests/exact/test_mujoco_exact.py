"""The MuJoCo bridge against closed forms, and against a run without inertia.

Source of truth: the recurrence of a linear oscillator in MuJoCo's own time step, statics of
springs in parallel, and `simulate` with a dead weight.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

pytest.importorskip("mujoco", reason="MuJoCo is not installed (pip install mujoco)")

from mujoco_cases import (
    GRAVITY,
    LAGGED,
    actuator,
    hanging,
    lever,
    recurrence,
    root_mean_square,
    stiffness,
    weighed,
    with_lagged_stress,
)

from martensite.actuators.assembly import System
from martensite.actuators.mechanisms.load_line import DeadWeight
from martensite.export.mujoco_bridge import COUPLINGS, MujocoBridge
from martensite.signals.sine import Sine
from martensite.signals.table import Table
from martensite.simulate.api import simulate


def pushed(bridge: MujocoBridge, joint: str, speed: float, steps: int) -> np.ndarray:
    """Positions of a joint in every step after a push."""
    bridge.data.joint(joint).qvel[0] = speed
    signals = {strand.name: 0.0 for strand in bridge.strands}
    result = bridge.run(steps * bridge.plant.dt, signals, samples=steps + 1)
    assert result.error < 1e-6
    return np.array(result[joint])


@pytest.mark.parametrize("coupling", COUPLINGS)
@pytest.mark.parametrize("share", [0.05, 4.0])
def test_a_mass_on_a_wire_is_the_recurrence(coupling: str, share: float) -> None:
    """Exact, at steps that resolve the oscillation (ω dt = 0.05) and at steps that do not."""
    mass = 0.5
    frequency = math.sqrt(stiffness(actuator(elastic=True)) / mass)
    dt, speed = share / frequency, 1e-2 / (1.0 + share)
    found = pushed(weighed(mass, dt, coupling), "x", speed, 200)
    expected = recurrence(frequency, dt, COUPLINGS[coupling], speed, 200)
    np.testing.assert_allclose(found, expected, atol=1e-9 * max(map(abs, expected)))


def test_the_recurrence_is_not_indifferent() -> None:
    """A wire softer by a thousandth is told apart."""
    frequency, dt = 250.0, 2e-4
    one, other = (recurrence(f, dt, COUPLINGS["end"], 1e-2, 200) for f in (frequency, 1.0005 * frequency))
    assert max(abs(a - b) for a, b in zip(one, other, strict=True)) > 1e-3 * max(one)


def test_centred_frequency_is_that_of_the_spring() -> None:
    """ω = √(k/m), to (ω dt)²/6 of it, and no amplitude is lost."""
    mass, dt = 0.5, 1e-4
    frequency = math.sqrt(stiffness(actuator(elastic=True)) / mass)
    found = pushed(weighed(mass, dt, "centred"), "x", 1e-2, 4000)
    rising = np.flatnonzero((found[:-1] < 0.0) & (found[1:] >= 0.0))
    crossings = rising + found[rising] / (found[rising] - found[rising + 1])
    period = dt * (crossings[-1] - crossings[0]) / (len(crossings) - 1)
    assert 2.0 * math.pi / period == pytest.approx(frequency, rel=(frequency * dt) ** 2 / 6.0)
    assert max(found[-500:]) == pytest.approx(1e-2 / frequency, rel=1e-3)


def test_a_lagged_force_throws_the_mass_off() -> None:
    """With ω dt = 2.2 the force of the step before drives the mass away; f₁ holds it."""
    mass = 0.5
    dt = 2.2 / math.sqrt(stiffness(actuator(elastic=True)) / mass)
    held, lagged = weighed(mass, dt), weighed(mass, dt)
    lagged.weights = LAGGED
    amplitude = 1e-3 * dt / 2.2  # speed over frequency
    assert max(abs(pushed(held, "x", 1e-3, 60))) < amplitude
    assert max(abs(pushed(lagged, "x", 1e-3, 60))) > 1e3 * amplitude


def test_a_lagged_stress_is_wrong_where_the_bridge_is_right() -> None:
    """The same lever in the same step of 1 ms: at least 100 times the error."""
    wave = Table(times=(0.0, 0.1, 0.3, 1.0, 1.1, 2.0), values=(0.0, 0.0, 4.0, 4.0, 0.0, 0.0))
    rate, start, radius = 0.06, 3.0, 0.004
    more = {"stiffness": rate, "springref": math.degrees(start * radius / rate)}

    def bridge(dt: float, coupling: str = "end") -> MujocoBridge:
        one = actuator(diameter=0.15e-3, start_force=start)
        return MujocoBridge(lever(dt, radius=radius, **more), [one], coupling=coupling)

    fine = bridge(2e-4, "centred").run(2.0, {"wire": wave}, samples=2001)
    truth = np.degrees(fine["hinge"])
    solved = np.degrees(bridge(1e-3).run(2.0, {"wire": wave}, samples=2001)["hinge"])
    lagged = np.degrees(with_lagged_stress(bridge(1e-3), wave, "hinge", 2000))
    assert max(abs(truth)) > 45.0
    assert root_mean_square(solved - truth) < 0.1
    assert root_mean_square(lagged - truth) > 100.0 * root_mean_square(solved - truth)


def antagonists(dt: float, preload: float, **changes: float) -> MujocoBridge:
    """Two elastic wires of different diameters on one pulley."""
    pair = [
        actuator("wire", elastic=True, start_force=preload, diameter=0.2e-3),
        actuator("other", elastic=True, start_force=preload, diameter=0.3e-3),
    ]
    return MujocoBridge(lever(dt, **changes), pair)


@pytest.mark.parametrize("share", [0.05, 4.0])
def test_antagonists_act_as_one_spring(share: float) -> None:
    """The recurrence with ω² = (k₁ + k₂) r²/I; both yield to each other within the step."""
    sizes = [actuator(elastic=True, diameter=d) for d in (0.2e-3, 0.3e-3)]
    radius, inertia = 0.004, 1.8e-5
    frequency = math.sqrt(sum(map(stiffness, sizes)) * radius**2 / inertia)
    dt, speed = share / frequency, 0.1
    bridge = antagonists(dt, 5.0, damping=0.0)
    found = pushed(bridge, "hinge", speed, 100)
    expected = recurrence(frequency, dt, COUPLINGS["end"], speed, 100)
    np.testing.assert_allclose(found, expected, atol=1e-5 * max(map(abs, expected)))


@pytest.mark.parametrize("torque", [0.01, pytest.param(0.05, marks=pytest.mark.slow)])
def test_antagonists_under_a_torque(torque: float) -> None:
    """q = M/((k₁ + k₂) r²) while both are taut, and by the taut one alone after that."""
    preload, radius = 4.0, 0.004
    taut, slack = (stiffness(actuator(elastic=True, diameter=d)) for d in (0.2e-3, 0.3e-3))
    bridge = antagonists(1e-3, preload, damping=0.02)
    bridge.data.qfrc_applied[0] = torque
    result = bridge.run(2.0, {"wire": 0.0, "other": 0.0}, samples=11)
    angle = torque / ((taut + slack) * radius**2)
    if slack * angle * radius > preload:
        angle = (torque / radius - preload) / (taut * radius)
    assert result["hinge"][-1] == pytest.approx(angle, rel=1e-6)
    assert result["wire.force"][-1] == pytest.approx(preload + taut * radius * angle, rel=1e-6)
    left = max(preload - slack * radius * angle, 0.0)
    assert result["other.force"][-1] == pytest.approx(left, abs=1e-6)
    assert [alarm.port for alarm in result.alarms] == (["other"] if left == 0.0 else [])


@pytest.mark.parametrize(("duration", "dt", "close"), [(8.0, 2e-3, 2e-3), (32.0, 8e-3, 5e-4)])
def test_slow_heating_is_a_dead_weight(duration: float, dt: float, close: float) -> None:
    """A hanging mass is where `simulate` has it without inertia; the closer, the slower."""
    mass = 0.5
    wave = Sine(low=0.0, high=5.0, frequency=1.0 / duration)
    one = actuator(start_force=mass * GRAVITY)
    weight = DeadWeight(mass=mass, gravity=GRAVITY)
    quasi = System(element=one.element, environment=one.environment, source=one.source, mechanism=weight)
    still = simulate(quasi, wave, duration, tolerance=1e-5, samples=401)
    moving = MujocoBridge(hanging(dt, mass), [one]).run(duration, {"wire": wave}, samples=401)
    assert still.stroke > 5e-3
    assert apart(moving["x"], still["position"]) < close * still.stroke
    warm = apart(moving["wire.temperature"], still["temperature"])
    assert warm < close * still.range("temperature")


def apart(one: Any, other: Any) -> float:
    """Largest difference of two columns."""
    return max(abs(a - b) for a, b in zip(one, other, strict=True))
