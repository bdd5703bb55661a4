"""Constants of a DC motor from tests with a supply, an ammeter and a tachometer.

    V = R i + L i' + K_B ω,    J ω' = K_T i - b ω - F_c sign(ω),    K_T = K_B = K in SI

test                  result
locked rotor          V = R i, a line through zero: resistance R; V = V₀ + R i should have V₀ = 0
locked rotor, V step  i rises with τ_e = L/R: inductance L
steady running        V - R i = K ω, a line through zero: constant K
                      i = s ω + i₀ with K i = b ω + F_c: friction
run-up                ω rises with τ_m: inertia J = τ_m [b + K²/(R - L/τ_m)]

Voltage, current and speed have one sign if the motor drives. The signs of backward rotation are reversed, so that
friction has one sign. Errors of equal size are assumed in the voltages of the locked rotor, and in V - R i and i of the
running rotor.

The formula of J is exact for the slower time constant; without inductance the bracket is b + K²/R. Dry friction
lowers the speed but does not change τ_m. An unbalance m at radius r is part of the inertia: J + m r².

K, b, F_c and J all depend on R, and J on K twice. Their errors are propagated from R, τ_e, τ_m and the lines of steady
running.

Source: Kossoski (2018), Appendix B, with dry friction kept and the formula of J corrected.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

from martensite.base.confidence import LEVEL, interval_contains
from martensite.base.errors import DataError, ParameterError
from martensite.characterise.estimate import MeasuredValue, check_columns, propagate_errors
from martensite.characterise.regression import LinearFit, fit_powers
from martensite.characterise.time_constant import Rise


@dataclass(frozen=True)
class Winding:
    """Resistance of the winding."""

    resistance: MeasuredValue
    """R [ohm] of the line through zero."""
    offset: MeasuredValue | None = None
    """V₀ [V] of a line with intercept; None if not tested."""


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
        """Return the line i = i₀ + s ω through currents over speeds."""
        return fit_powers(self.speeds, self.currents, (0, 1))

    @property
    def drop(self) -> float:
        """Return the decrease of the fitted K per ohm of R, Σ i ω/Σ ω² [A s/rad]."""
        pairs = zip(self.currents, self.speeds, strict=True)
        return sum(i * w for i, w in pairs) / sum(w * w for w in self.speeds)

    def constant(self, resistance: float) -> MeasuredValue:
        """Return K [V s/rad] of the line V - R i = K ω, for a resistance [ohm] taken as exact.

        Raises:
            DataError: K is not above 0.
        """
        pairs = zip(self.voltages, self.currents, strict=True)
        behind = [voltage - resistance * current for voltage, current in pairs]
        constant = fit_powers(self.speeds, behind, (1,)).coefficient(1)
        if constant.value <= 0.0:
            raise DataError(
                f"With R = {resistance:.4g} ohm the motor constant K is {constant.value:.3g} V s/rad, but must be "
                "above 0. Check R and the signs of the columns."
            )
        return constant


def winding_resistance(voltages: Sequence[float], currents: Sequence[float]) -> Winding:
    """Return the resistance of a locked rotor, from several currents and rotor positions.

    Args:
        voltages: voltages [V].
        currents: currents [A].

    Raises:
        DataError: there are fewer than two pairs, values are not finite, or R is not above 0.
    """
    check_columns("a motor", "states", 2, voltages=voltages, currents=currents)
    if not any(currents):
        raise DataError("All currents of the held rotor are 0 A. Measure the resistance with a current.")
    resistance = fit_powers(currents, voltages, (1,)).coefficient(1)
    if resistance.value <= 0.0:
        raise DataError(
            f"The resistance must be above 0 ohm, but {resistance.value:.4g} ohm fits the held "
            "rotor best; check the signs of voltages and currents."
        )
    if len(voltages) < 3 or len(set(currents)) < 2:
        return Winding(resistance)
    return Winding(resistance, fit_powers(currents, voltages, (0, 1)).coefficient(0))


def collect_steady_states(
    voltages: Sequence[float], currents: Sequence[float], speeds: Sequence[float]
) -> SteadyRunning:
    """Return the steady states, with reversed signs for backward rotation.

    Args:
        voltages: voltages [V].
        currents: currents [A].
        speeds: speeds [rad/s], at least two different values, all nonzero.

    Raises:
        DataError: there are fewer than two states, or values are not finite, of zero speed, or all of one speed.
    """
    check_columns("a motor", "states", 2, voltages=voltages, currents=currents, speeds=speeds)
    if 0.0 in speeds:
        raise DataError("Steady speeds must not be 0 rad/s: a stopped motor has no back-EMF.")
    signs = [math.copysign(1.0, speed) for speed in speeds]
    columns = [
        tuple(sign * number for sign, number in zip(signs, numbers, strict=True))
        for numbers in (voltages, currents, speeds)
    ]
    states = SteadyRunning(*columns)
    if len(set(states.speeds)) < 2:
        raise DataError(
            f"All steady states run at {states.speeds[0]:.4g} rad/s, but the friction needs at least two speeds."
        )
    return states


Formula = Callable[..., float]

LONG = 2.0
"""R J/(K_T K_B) [s] above which J or R of a small motor is doubtful."""
UNITS = {
    "resistance": "ohm",
    "inductance": "H",
    "constant": "N*m/A",
    "friction": "N*m*s/rad",
    "dry_friction": "N*m",
    "inertia": "kg*m^2",
}
"""Name of a constant -> its SI unit."""


@dataclass(frozen=True)
class MotorConstants:
    """Results of the tests of a DC motor."""

    resistance: MeasuredValue
    """R [ohm]"""
    constant: MeasuredValue
    """K = K_T [N m/A] = K_B [V s/rad]"""
    friction: MeasuredValue
    """b [N m s/rad], viscous"""
    dry_friction: MeasuredValue
    """F_c [N m]"""
    inductance: MeasuredValue | None = None
    """L [H]; None if unknown."""
    inertia: MeasuredValue | None = None
    """J [kg m²], with the mounted parts; None without a run-up."""
    remarks: tuple[str, ...] = ()
    """Remarks on doubtful or unsupported results."""

    @property
    def run_up_time(self) -> float | None:
        """Return R J/(K_T K_B) [s]: the time constant without friction and inductance."""
        if self.inertia is None:
            return None
        return self.resistance.value * self.inertia.value / self.constant.value**2

    def to_dict(self, level: float = LEVEL) -> dict[str, Any]:
        """Return all values by name, for JSON."""
        estimates = {name: getattr(self, name) for name in UNITS}
        numbers = {n: None if e is None else e.to_dict(level) for n, e in estimates.items()}
        return numbers | {"run_up_time": self.run_up_time, "remarks": list(self.remarks)}


def estimate_motor_constants(
    states: SteadyRunning,
    winding: Winding,
    *,
    current_rise: Rise | None = None,
    inductance: float | None = None,
    run_up: Rise | None = None,
) -> MotorConstants:
    """Estimate the constants of a motor from its tests.

    Args:
        states: steady running at several speeds.
        winding: resistance, measured or given.
        current_rise: rise of the current after a voltage step, with a locked rotor.
        inductance: L [H], if known otherwise.
        run_up: rise of the speed [rad/s] after a voltage step, from any speed.

    Raises:
        ParameterError: both `current_rise` and `inductance` are given.
        DataError: steady running contradicts R, or the run-up is not slower than the current.
    """
    if current_rise is not None and inductance is not None:
        raise ParameterError("Give `current_rise` or `inductance`, not both: each determines L.")
    ohms = winding.resistance
    coil = MeasuredValue(inductance or 0.0) if current_rise is None else current_rise.tau
    inputs = (
        ohms,
        states.constant(ohms.value),
        states.friction_line.coefficient(1),
        states.friction_line.coefficient(0),
        coil,
        MeasuredValue(math.inf) if run_up is None else run_up.tau,
    )
    formulas = _constant_formulas(states.drop, ohms.value, current_rise is not None)
    if run_up is not None:
        _refuse_fast(run_up, formulas["inductance"](*(one.value for one in inputs)) / ohms.value)
    numbers = {name: propagate_errors(formula, *inputs) for name, formula in formulas.items()}
    coil_known = current_rise is not None or inductance is not None
    constants = MotorConstants(
        resistance=ohms,
        constant=numbers["constant"],
        friction=numbers["friction"],
        dry_friction=numbers["dry_friction"],
        inductance=numbers["inductance"] if coil_known else None,
        inertia=numbers["inertia"] if run_up is not None else None,
    )
    return replace(constants, remarks=tuple(_list_remarks(constants, winding, current_rise, run_up)))


def _constant_formulas(drop: float, centre: float, measured: bool) -> dict[str, Formula]:
    """Return the formulas of all constants from R, K at the best R (`centre` [ohm]), s, i₀, τ_e or L, and τ_m.

    K falls by `drop` per ohm of R; if `measured`, the fifth value is τ_e, not L.
    """

    def constant(r: float, k: float, *_: float) -> float:
        return k - drop * (r - centre)

    def inductance(r: float, k: float, s: float, i: float, coil: float, *_: float) -> float:
        return r * coil if measured else coil

    def inertia(r: float, k: float, s: float, i: float, coil: float, tau: float) -> float:
        both = constant(r, k)
        impedance = r - inductance(r, k, s, i, coil) / tau
        return tau * both * (s + both / impedance)

    return {
        "constant": constant,
        "friction": lambda r, k, s, *_: s * constant(r, k),
        "dry_friction": lambda r, k, s, i, *_: i * constant(r, k),
        "inductance": inductance,
        "inertia": inertia,
    }


def _refuse_fast(run_up: Rise, tau_e: float) -> None:
    if run_up.tau.value <= tau_e:
        raise DataError(
            f"The speed must rise more slowly than the current, but has a time constant of "
            f"{run_up.tau.value:.4g} s against {tau_e:.4g} s; check units, and that the rotor "
            "was held while the current rose."
        )


def _list_remarks(
    constants: MotorConstants, winding: Winding, current_rise: Rise | None, run_up: Rise | None
) -> Iterator[str]:
    """Yield remarks on doubtful or unsupported results."""
    time, offset = constants.run_up_time, winding.offset
    if time is not None and time > LONG:
        yield (
            f"R J/(K_T K_B) = {time:.3g} s is long for a small motor: doubt J and R before anything is built on them."
        )
    if offset is not None and not interval_contains(offset.interval()):
        yield (
            f"The line through the held rotor has {offset.value:.3g} V at no current (brushes or "
            "supply): R, which takes it to go through zero, is wrong by that."
        )
    for name, estimate in (("b", constants.friction), ("F_c", constants.dry_friction)):
        low, high = estimate.interval()
        if high < 0.0:
            yield f"{name} = {estimate.value:.3g} is below 0, as no friction is: check the columns."
        elif low <= 0.0:
            share = f"{100 * LEVEL:g} % interval"
            yield f"{name} above 0 is not supported: {share} {low:.3g} to {high:.3g}."
    for name, rise in (("current", current_rise), ("speed", run_up)):
        if rise is not None and not rise.follows:
            yield (
                f"The {name} does not rise as one exponential (residuals {rise.deviation:.3g}, "
                f"correlation {rise.correlation:.2f}): begin the record after the step."
            )
