"""Plateau stresses of a superelastic test, converted to the transformation temperatures of a law and back.

Datasheets and finite-element programs describe a superelastic material by the stresses at which the transformation
begins and ends in loading and in unloading at one temperature, and by the change of these stresses with temperature
(Auricchio, Taylor and Lubliner (1997), Comput. Methods Appl. Mech. Eng. 146, 281). A law has transformation
temperatures at zero stress. For straight lines in the phase diagram

    M_s = T - σ_start/C_M,    M_f = T - σ_end/C_M    (loading)
    A_s = T - σ_start/C_A,    A_f = T - σ_end/C_A    (unloading)

For other laws these values are the start of a search: stresses are read from the law itself.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from martensite.base.errors import InputError, SolveError
from martensite.kernels.arrays import ArrayNamespace
from martensite.kernels.nested import NestedShape, flatten_numbers
from martensite.physics.laws.base import AbstractLaw, Fractions

LIMIT = 10e9
"""Largest stress [Pa] at which a law is evaluated."""
PASSES, COUNT = 4, 257
"""Refinements of a stress, and stresses in each: 2 Pa remain of the largest stress."""
ROUNDING = 1e-13
"""Martensite fraction that counts as none."""
TAIL = 0.01
"""Remaining fraction at the end of an exponential transformation."""
ROUNDS = 40
CLOSE = 1e-6
"""Relative difference of stresses that agree."""
TEMPERATURES = ("M_s", "M_f", "A_s", "A_f", "C_M", "C_A")


@dataclass(frozen=True)
class Plateaus:
    """Stresses [Pa] at which a superelastic material transforms at one temperature."""

    temperature: float
    """Temperature of the test [K]."""
    loading: tuple[float, float]
    """Start and end of the transformation to martensite."""
    unloading: tuple[float, float]
    """Start and end of the transformation to austenite."""

    def __post_init__(self) -> None:
        (begin, end), (back, last) = self.loading, self.unloading
        numbers = self.temperature, begin, end, back, last
        if not all(math.isfinite(x) and x > 0.0 for x in numbers):
            raise InputError(
                "Temperature and plateau stresses must be positive: a material whose unloading plateau is below zero "
                "is not superelastic at this temperature."
            )
        if not (begin < end and last < back and back < end and last < begin):
            raise InputError(
                f"Plateaus must be in the order loading start < loading end, unloading end < unloading start, and "
                f"unloading below loading, but are {_in_megapascals(self.loading)} and "
                f"{_in_megapascals(self.unloading)} MPa."
            )

    def estimate_slopes(self, other: Plateaus) -> tuple[float, float]:
        """Return the Clausius–Clapeyron slopes C_M and C_A [Pa/K] from a test at another temperature.

        Raises:
            InputError: the temperatures differ by less than 1 K, or a plateau falls as the temperature rises.
        """
        warmer = other.temperature - self.temperature
        if abs(warmer) < 1.0:
            raise InputError(f"Two tests for the slopes must differ by 1 K or more, but differ by {abs(warmer):.3g} K.")
        pairs = (self.loading, other.loading), (self.unloading, other.unloading)
        forward, reverse = ((sum(b) - sum(a)) / 2.0 / warmer for a, b in pairs)
        if min(forward, reverse) <= 0.0:
            raise InputError("Plateau stresses must rise with temperature, but they fall between the two tests.")
        return forward, reverse


def find_plateaus(law: AbstractLaw, temperature: float) -> Plateaus:
    """Return the plateau stresses of a law that is loaded and unloaded at a constant temperature.

    Args:
        law: rate-independent law of austenite and martensite.
        temperature: temperature of the test [K].

    Raises:
        InputError: the law is not superelastic at this temperature, or has no such plateaus.
    """
    _require_lines(law)
    tail = TAIL if law.registered_name == "tanaka" else ROUNDING
    path = _IsothermalPath(law, temperature)
    if path.find_fractions(np.array([LIMIT]))[0] < 1.0 - tail:
        raise InputError(f"`{law.registered_name}` does not transform below {LIMIT / 1e9:.0f} GPa.")
    begin = path.find_stress(lambda fraction: fraction > ROUNDING, 0.0, LIMIT)
    end = path.find_stress(lambda fraction: fraction >= 1.0 - tail, begin, LIMIT)
    path.move_to(1.5 * end)
    whole, left = path.find_fractions(np.array([1.5 * end, 0.0]))
    if left > tail:
        raise InputError(
            f"At {temperature - 273.15:.4g} °C `{law.registered_name}` is not superelastic: martensite remains without "
            "stress. Take a temperature above A_f."
        )
    back = path.find_stress(lambda fraction: fraction >= whole, 0.0, 1.5 * end)
    last = path.find_stress(lambda fraction: fraction > tail, 0.0, back)
    return Plateaus(temperature, (begin, end), (back, last))


def convert_plateaus(law: AbstractLaw, plateaus: Plateaus) -> dict[str, float]:
    """Return the transformation temperatures [K] with which a law has given plateaus.

    Brinson's law ends loading at `sigma_f`, which is returned too; its M_f does not follow from a superelastic test and
    is M_s less the width of the loading plateau over C_M.

    Args:
        law: law with all other parameters; its transformation temperatures are not used.
        plateaus: measured stresses.

    Returns:
        Values by name of the parameter in SI.

    Raises:
        InputError: the law has no such plateaus.
        SolveError: no temperatures give these plateaus.
    """
    _require_lines(law)
    numbers = {leaf.path: leaf.value for leaf in law.leaves()}
    wanted = np.array([*plateaus.loading, *plateaus.unloading])
    lines = wanted - [numbers.get("sigma_s", 0.0), 0.0, 0.0, 0.0]
    for _ in range(ROUNDS):
        values = _place_lines(numbers, plateaus, lines.tolist())
        there = find_plateaus(law.with_values(values), plateaus.temperature)
        errors = wanted - [*there.loading, *there.unloading]
        if np.abs(errors).max() <= CLOSE * wanted.max():
            return values
        lines += errors
    raise SolveError(
        f"No transformation temperatures of `{law.registered_name}` give these plateaus at "
        f"{plateaus.temperature - 273.15:.4g} °C with C_M {numbers['C_M'] / 1e6:.3g} and C_A "
        f"{numbers['C_A'] / 1e6:.3g} MPa/K; check the slopes, or take another law."
    )


def _place_lines(numbers: dict[str, float], plateaus: Plateaus, stresses: list[float]) -> dict[str, float]:
    """Return the temperatures of straight lines through four stresses [Pa] at the temperature of a test."""
    kelvin, width = plateaus.temperature, plateaus.loading[1] - plateaus.loading[0]
    begin, end, back, last = stresses
    values = {
        "M_s": kelvin - begin / numbers["C_M"],
        "M_f": kelvin - end / numbers["C_M"],
        "A_s": kelvin - back / numbers["C_A"],
        "A_f": kelvin - last / numbers["C_A"],
    }
    if "sigma_f" in numbers:
        values["sigma_f"] = end - begin
        values["M_f"] = values["M_s"] - width / numbers["C_M"]
    return values


def _require_lines(law: AbstractLaw) -> None:
    names = {leaf.path for leaf in law.leaves()}
    if law.rate_dependent or not names.issuperset(TEMPERATURES):
        raise InputError(
            f"`{law.registered_name}` has no transformation temperatures with slopes; plateaus are converted for "
            "brinson, elahinia, lagoudas, liang-rogers, r-phase and tanaka."
        )


class _IsothermalPath:
    """A law at a constant temperature, evaluated at many stresses after its last point."""

    def __init__(self, law: AbstractLaw, temperature: float) -> None:
        self.law, self.temperature = law, temperature
        self.xp = ArrayNamespace(np)
        zero: Any = np.zeros(1)  # one lane
        self.memory = law.init(self.xp, Fractions(zero, zero), zero, zero + temperature)

    def _step(self, stresses: Any) -> Any:
        shape = stresses.shape
        lanes = [np.broadcast_to(number, shape) for number in flatten_numbers(self.memory)]
        memory: Any = NestedShape(self.memory).rebuild(lanes)
        kelvin: Any = np.full(shape, self.temperature)
        return self.law.kinetics(self.xp, memory, stresses, kelvin, 1.0)

    def move_to(self, stress: float) -> None:
        """Continue the path from a stress [Pa]."""
        self.memory = self._step(np.array([stress]))[0]

    def find_fractions(self, stresses: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the martensite fractions after one step to each stress [Pa]."""
        return np.broadcast_to(self._step(stresses)[1].martensite, stresses.shape)

    def find_stress(self, holds: Callable[[NDArray[np.float64]], NDArray[np.bool_]], low: float, high: float) -> float:
        """Return the lowest stress [Pa] at which a condition on the fraction holds, as it does at `high`."""
        for _ in range(PASSES):
            stresses = np.linspace(low, high, COUNT)
            place = max(int(np.argmax(holds(self.find_fractions(stresses)))), 1)
            low, high = stresses[place - 1], stresses[place]
        return float(high)


def _in_megapascals(stresses: tuple[float, float]) -> str:
    return " to ".join(f"{stress / 1e6:.4g}" for stress in stresses)
