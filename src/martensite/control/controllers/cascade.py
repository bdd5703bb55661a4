"""Cascade: the controller of a position commands the temperature of a second controller.

    T_r = T_0 + C_o(r - y)        within [T_0 + low, T_0 + high] of the outer limits
    u   = C_i(T_r - T)            within the inner limits

Both are PID controllers (`martensite.control.controllers.pid`). The inner loop is fast and has no hysteresis; the
limits of the outer controller keep the element between two temperatures at any position. y and T are readings, for
example the estimate `estimated.temperature`.

Where the inner signal is at a limit and the outer error drives it further, the outer integral is held. A higher
temperature must mean more signal and a larger reading; otherwise choose the signs of the gains accordingly.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from martensite.base.parameters import Number, param, part, text
from martensite.base.units import DEGREES
from martensite.control.controllers.base import CONTROLLERS, AbstractController, Answer, Column, Readings
from martensite.control.controllers.pid import PidGains, PidMemory
from martensite.kernels.namespace import Namespace, Scalar


class CascadeMemory(NamedTuple):
    """Memory of the outer, then of the inner controller."""

    outer: PidMemory
    inner: PidMemory

    @classmethod
    def of(cls, memory: Column) -> CascadeMemory:
        """Return the memory from a flat column."""
        return cls(PidMemory(*memory[:3]), PidMemory(*memory[3:]))

    def flat(self) -> Sequence[Scalar]:
        """Return the memory as a flat column."""
        return (*self.outer, *self.inner)


class OuterPid(PidGains):
    """PID controller whose signal is a temperature difference."""

    unit_of_signal = DEGREES


class InnerPid(PidGains):
    """PID controller of a temperature."""

    unit_of_reading = "K"


@CONTROLLERS.register("cascade")
class Cascade(AbstractController):
    """PID control of a position by PID control of a temperature."""

    cites = ("copaci2019",)
    integrals = (0, 3)

    temperature: str = text("name of the reading of the temperature", default="temperature")
    start: Number = param("K", "temperature T_0 to which the outer controller adds", typical="60 degC")
    outer: OuterPid = part("of the position: gains in kelvin per SI unit, limits in kelvin")
    inner: InnerPid = part("of the temperature: gains in signal per kelvin, limits of the signal")

    def describe(self, period: float) -> str:
        return f"outer: {self.outer.describe(period)}; inner: {self.inner.describe(period)}"

    def reads(self) -> tuple[str, ...]:
        return self.measured, self.temperature

    def rest(self, xp: Namespace, reference: Scalar, readings: Readings) -> Column:
        outer = self.outer.law.rest(xp, reference, readings[self.measured])
        inner = self.inner.law.rest(xp, self.start, readings[self.temperature])
        return CascadeMemory(outer, inner).flat()

    def answer(self, xp: Namespace, memory: Column, reference: Scalar, readings: Readings, dt: Scalar) -> Answer:
        before, position = CascadeMemory.of(memory), readings[self.measured]
        added, outer = self.outer.respond(xp, before.outer, reference, position, dt)
        signal, inner = self.inner.respond(xp, before.inner, self.start + added, readings[self.temperature], dt)
        old, new = before.outer.integral, outer.integral
        integral = self.inner.law.hold_at_limit(xp, signal, new - old, old, new)
        return signal, CascadeMemory(outer._replace(integral=integral), inner).flat()

    def track(self, xp: Namespace, memory: Column, signal: Scalar, reference: Scalar, readings: Readings) -> Column:
        before, position, T = CascadeMemory.of(memory), readings[self.measured], readings[self.temperature]
        outer, inner = self.outer, self.inner
        above = xp.clip(T - self.start, outer.law.low, outer.law.high)
        outer_memory = outer.law.track(xp, outer.gains, before.outer, above, reference, position)
        inner_memory = inner.law.track(xp, inner.gains, before.inner, signal, self.start + above, T)
        return CascadeMemory(outer_memory, inner_memory).flat()
