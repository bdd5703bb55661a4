"""Two tests of a DC motor: the rotor held still, and steady running at several speeds.

    rotor held        V = R i, a line through zero; V = V₀ + R i should have V₀ = 0
    steady running    V - R i = K ω, a line through zero;  i = s ω + i₀ with K i = b ω + F_c

Voltage, current and speed have one sign where the motor drives. States of backward rotation are
turned forward, so that friction has one sign. Errors are taken to be in the voltages of the held
rotor, and in V - R i and i of the running one, of equal size.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

from martensite.base.errors import DataError
from martensite.characterise.columns import check_columns
from martensite.characterise.estimate import MeasuredValue
from martensite.characterise.polynomial_regression import LinearFit, fit_powers


@dataclass(frozen=True)
class Winding:
    """Resistance of the winding."""

    resistance: MeasuredValue
    """R [ohm] of the line through zero."""
    offset: MeasuredValue | None = None
    """V₀ [V] of a line that need not go through zero; None where it was not tested."""


@dataclass(frozen=True)
class SteadyRunning:
    """Steady states of a motor, all in one direction of rotation."""

    voltages: tuple[float, ...]
    """[V]"""
    currents: tuple[float, ...]
    """[A]"""
    speeds: tuple[float, ...]
    """[rad/s]"""

    @cached_property
    def friction_line(self) -> LinearFit:
        """The line i = i₀ + s ω through currents over speeds."""
        return fit_powers(self.speeds, self.currents, (0, 1))

    @property
    def drop(self) -> float:
        """By how much the fitted K falls per ohm of R, Σ i ω/Σ ω² [A s/rad]."""
        pairs = zip(self.currents, self.speeds, strict=True)
        return sum(i * w for i, w in pairs) / sum(w * w for w in self.speeds)

    def constant(self, resistance: float) -> MeasuredValue:
        """K [V s/rad] of the line V - R i = K ω, for a resistance [ohm] taken as exact.

        Raises:
            DataError: K is not above 0.
        """
        pairs = zip(self.voltages, self.currents, strict=True)
        behind = [voltage - resistance * current for voltage, current in pairs]
        found = fit_powers(self.speeds, behind, (1,)).coefficient(1)
        if found.value <= 0.0:
            raise DataError(
                f"With R = {resistance:.4g} ohm steady running leaves no voltage behind R i: K is "
                f"{found.value:.3g} V s/rad, not above 0; check R and the signs of the columns."
            )
        return found


def winding_resistance(voltages: Sequence[float], currents: Sequence[float]) -> Winding:
    """Resistance from a rotor held still, at several currents and rotor positions.

    Args:
        voltages: [V]
        currents: [A]

    Raises:
        DataError: the pairs are fewer than two, not finite, or do not give an R above 0.
    """
    check_columns("a motor", "states", 2, voltages=voltages, currents=currents)
    if not any(currents):
        raise DataError("All currents of the held rotor are 0 A: they hold no resistance.")
    resistance = fit_powers(currents, voltages, (1,)).coefficient(1)
    if resistance.value <= 0.0:
        raise DataError(
            f"The resistance must be above 0 ohm, but {resistance.value:.4g} ohm fits the held "
            "rotor best; check the signs of voltages and currents."
        )
    if len(voltages) < 3 or len(set(currents)) < 2:
        return Winding(resistance)
    return Winding(resistance, fit_powers(currents, voltages, (0, 1)).coefficient(0))


def steady_running(voltages: Sequence[float], currents: Sequence[float], speeds: Sequence[float]) -> SteadyRunning:
    """Steady states, those of backward rotation turned forward.

    Args:
        voltages: [V]
        currents: [A]
        speeds: [rad/s], at least two different ones, none of them zero.

    Raises:
        DataError: the states are fewer than two, not finite, at rest, or all of one speed.
    """
    check_columns("a motor", "states", 2, voltages=voltages, currents=currents, speeds=speeds)
    if 0.0 in speeds:
        raise DataError("Steady speeds must not be 0 rad/s: a motor at rest shows no constant.")
    signs = [math.copysign(1.0, speed) for speed in speeds]
    columns = [
        tuple(sign * number for sign, number in zip(signs, numbers, strict=True))
        for numbers in (voltages, currents, speeds)
    ]
    states = SteadyRunning(*columns)
    if len(set(states.speeds)) < 2:
        raise DataError(
            f"All steady states run at {states.speeds[0]:.4g} rad/s, but a line of friction takes at least two speeds."
        )
    return states
