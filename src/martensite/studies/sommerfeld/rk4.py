"""The thesis's integrator with the package's equations of motion, and its step limit.

Classical Runge–Kutta of fourth order for [x, x', φ, φ', i], with the accelerations of the mechanism and V at the times
of the stages. The current has the pole -R/L, so the step must be below 2.785 L/R, the stability limit of the method on
the real axis.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from functools import cache
from typing import Any

from martensite.actuators.mechanics.motion import Motion
from martensite.actuators.mechanisms.beam_motor import BeamMotor
from martensite.kernels import floats
from martensite.kernels.program import Program
from martensite.studies.sommerfeld.machines import natural_frequency
from martensite.studies.sommerfeld.runs import CAPTURED, find_last

INTERVAL = 2.785293563
"""Root of 1 - z + z²/2 - z³/6 + z⁴/24 = 1 other than 0."""
DURATION = 10.0
"""Duration of a run [s]."""
FINE = 1e-4
"""Step [s]."""
STATES = ("x", "v", "a", "w", "i")
Advance = Callable[..., tuple[float, ...]]


@cache
def advance_step(motor: BeamMotor) -> Advance:
    """Return one step: (x, x', φ, φ', i, V at its beginning, middle and end [V], h [s]) -> the state."""
    program = Program()
    twin = motor.rebuilt({leaf.path: program.parameter(leaf.path) for leaf in motor.leaves()})

    def rates(xp: Any, state: Sequence[Any], volts: Any) -> list[Any]:
        x, v, a, w, i = state
        motion = Motion((x, a, 0.0), (v, w, i), (0.0, 0.0, 0.0))
        released = twin.release(xp, motion, [0.0, 0.0, 0.0], [volts])
        return [v, released[0], w, released[1], released[2]]

    def step(xp: Any, *arguments: Any) -> list[Any]:
        *state, begin, middle, end, h = arguments

        def moved(slope: Sequence[Any], share: float) -> list[Any]:
            return [q + share * h * d for q, d in zip(state, slope, strict=True)]

        k1 = rates(xp, state, begin)
        k2 = rates(xp, moved(k1, 0.5), middle)
        k3 = rates(xp, moved(k2, 0.5), middle)
        k4 = rates(xp, moved(k3, 1.0), end)
        rows = zip(k1, k2, k3, k4, strict=True)
        return moved([(a + 2.0 * (b + c) + d) / 6.0 for a, b, c, d in rows], 1.0)

    program.add("step", [*STATES, "begin", "middle", "end", "h"], step)
    return program.bind_floats(*(leaf.value for leaf in motor.leaves()))["step"]


def mean_speed(motor: BeamMotor, volts: float) -> float:
    """Return the mean speed [rad/s] over the last second of 10 s from rest, in steps of 0.1 ms."""
    step, state, total = advance_step(motor), (0.0,) * 5, 0.0
    steps, last = round(DURATION / FINE), round(1.0 / FINE)
    for k in range(steps):
        state = step(*state, volts, volts, volts, FINE)
        total += state[3] if k >= steps - last else 0.0
    return total / last


@cache
def last_captured(motor: BeamMotor, first: float) -> float:
    """Return the last captured voltage [V] of a grid of 0.1 V from `first` on."""
    limit = CAPTURED * natural_frequency(motor)
    return find_last(lambda volts: mean_speed(motor, volts) < limit, first)


def is_stable(motor: BeamMotor, h: float, volts: float = 5.0, steps: int = 4000) -> bool:
    """Return whether the current stays below twice V/R in `steps` steps of h [s] from rest."""
    step, state = advance_step(motor), (0.0,) * 5
    most = 2.0 * volts / motor.resistance
    for _ in range(steps):
        state = step(*state, volts, volts, volts, h)
        if not abs(state[4]) < most:
            return False
    return True


@cache
def step_limit(motor: BeamMotor) -> float:
    """Return the longest stable step [s], by bisection."""
    shortest = motor.inductance / motor.resistance
    low, high = 2.0 * shortest, 4.0 * shortest
    for _ in range(12):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if is_stable(motor, middle) else (low, middle)
    return low


def energy_drift(motor: BeamMotor) -> float:
    """Return the largest relative change of the energy of the isolated system over 5 s.

    It has no damping, friction or torque; rotor and tip move at the start.
    """
    losses = ("damping", "rotor_friction", "dry_friction", "torque_constant", "back_emf")
    alone = motor.with_values(dict.fromkeys(losses, 0.0))
    step = advance_step(alone)
    state: tuple[float, ...] = (0.02, 0.3, 0.2, 40.0, 0.0)
    energies = [_magnetic_energy(alone, state)]
    for k in range(round(5.0 / FINE)):
        state = step(*state, 0.0, 0.0, 0.0, FINE)
        if k % 100 == 99:
            energies.append(_magnetic_energy(alone, state))
    return (max(energies) - min(energies)) / energies[0]


def _magnetic_energy(motor: BeamMotor, state: Sequence[float]) -> float:
    x, v, a, w, i = state
    energy = math.fsum(motor.energy(floats, Motion((x, a, 0.0), (v, w, i), ())))
    return energy if math.isfinite(energy) else math.inf
