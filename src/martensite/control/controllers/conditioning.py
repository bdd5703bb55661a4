"""Conditioning of any controller: reading filter, manual mode, shaped reference and slew limit.

    readings → filter → controller with shaped reference → manual or safe signal → slew limit → signal

Each part is optional; a missing part is not in the program.

- The filter takes the median of three readings, then a low pass by backward differences of first order,
  T y' + y = x, or of second order with a damping of 0.71, T² y''/2 + T y' + y = x.
- In manual mode the operator sets the signal, and the memory of the controller tracks it (`track`). With an integral
  the change to automatic does not step the signal.
- Where the slew limit acts, integrals do not grow in the direction of the limited part.

Source: Åström and Hägglund (1995), chapter 3.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from itertools import islice
from typing import TYPE_CHECKING, NamedTuple

from martensite.base.errors import ParameterError
from martensite.base.parameters import Number, Parametrised, option, param, part, text
from martensite.base.units import SIGNAL_RATE
from martensite.control.controllers.shaping import ShapedReference
from martensite.kernels.namespace import Flag, Namespace, Scalar
from martensite.kernels.nested import choose_tuple
from martensite.signals.base import WAVEFORMS, AbstractWaveform
from martensite.signals.constant import Constant
from martensite.signals.step import Step

if TYPE_CHECKING:
    from martensite.control.controllers.base import AbstractController

Column = Sequence[Scalar]
Readings = Mapping[str, Scalar]


class ManualInput(NamedTuple):
    """Manual input of one sample."""

    signal: Scalar
    automatic: Scalar
    """1 in automatic, 0 in manual mode."""


class ReadingFilter(Parametrised):
    """A low pass of readings."""

    time_constant: Number = param("s", "time constant T", above=0.0, typical="50 ms")
    order: str = option("order of the low pass", "1", "2", default="1")
    median: str = option("median of three readings before the low pass", "without", "of-three", default="without")
    readings: tuple[str, ...] = text("filtered readings; default: the controlled reading", default=())

    @property
    def memory_length(self) -> int:
        """Return the length of the memory of a reading."""
        return 1 + (self.order == "2") + 2 * (self.median == "of-three")

    def rest(self, reading: Scalar) -> Column:
        """Return the steady-state memory at a constant reading."""
        return (reading, *(0.0,) * (self.order == "2"), *(reading, reading) * (self.median == "of-three"))

    def filter(self, xp: Namespace, memory: Column, reading: Scalar, dt: Scalar) -> Column:
        """Return the memory after a reading `dt` [s] after the last one; its first value is the filtered reading."""
        T, before, value = self.time_constant, memory[0], reading
        past: Column = ()
        if self.median == "of-three":
            a, b = memory[-2:]
            value = xp.maximum(xp.minimum(a, b), xp.minimum(xp.maximum(a, b), reading))
            past = reading, a
        if self.order == "1":
            return (before + (value - before) * dt / (T + dt), *past)
        rate = (2.0 * dt * (value - before) + T * T * memory[1]) / (T * T + 2.0 * dt * T + 2.0 * dt * dt)
        return (before + dt * rate, rate, *past)


class SignalSlew(Parametrised):
    """Limits of the rate of a signal that begins at 0."""

    rising: Number = param(SIGNAL_RATE, "largest rate at which it rises", above=0.0, default=math.inf)
    falling: Number = param(SIGNAL_RATE, "largest rate at which it falls", above=0.0, default=math.inf)

    def check(self) -> None:
        if not (math.isfinite(self.rising) or math.isfinite(self.falling)):
            raise ParameterError("A slew limit needs a rate, `rising` or `falling`.")

        self.__dict__["_layout"] = math.isfinite(self.rising), math.isfinite(self.falling)

    def limit(self, xp: Namespace, before: Scalar, wanted: Scalar, dt: Scalar) -> Scalar:
        """Return the allowed signal nearest to the wanted one, `dt` [s] after the last one."""
        up, down = self.layout()
        limited = xp.minimum(wanted, before + self.rising * dt) if up else wanted
        return xp.maximum(limited, before - self.falling * dt) if down else limited


class ManualMode(Parametrised):
    """A manual signal, and the time in which the controller has the signal instead."""

    signal: AbstractWaveform = part("manual signal", WAVEFORMS, default=Constant(level=0.0))
    automatic_from: Number = param("s", "time from which the controller has the signal", low=0.0, default=0.0)
    automatic_until: Number = param("s", "time until which the controller has the signal", default=math.inf)

    def check(self) -> None:
        if not self.automatic_from < self.automatic_until:
            raise ParameterError("`automatic_from` must be before `automatic_until`.")

    @property
    def waveforms(self) -> tuple[AbstractWaveform, AbstractWaveform]:
        """Return the manual signal, and a waveform that is 1 in automatic mode."""
        return self.signal, Step(low=0.0, high=1.0, at=self.automatic_from, until=self.automatic_until)


class ControllerMemory(NamedTuple):
    """Memory of a controller and of its optional parts."""

    filters: tuple[Column, ...]
    shaped: ShapedReference | None
    signal: Scalar
    """Last signal, if there is a slew limit."""
    inner: Column

    def flatten(self, one: AbstractController) -> Column:
        """Return the memory as a flat column."""
        last = () if one.slew is None else (self.signal,)
        return (*(number for row in self.filters for number in row), *(self.shaped or ()), *last, *self.inner)


def split_memory(one: AbstractController, memory: Column) -> ControllerMemory:
    """Return the named memory of a controller from a flat column."""
    rest, shaped = iter(memory), one.shaping is not None
    filters = (
        tuple(tuple(islice(rest, one.reading_filter.memory_length)) for _ in one.filtered_readings())
        if one.reading_filter
        else ()
    )
    reference = ShapedReference(*islice(rest, len(ShapedReference._fields))) if shaped else None
    return ControllerMemory(filters, reference, 0.0 if one.slew is None else next(rest), tuple(rest))


def begin_control(
    one: AbstractController, xp: Namespace, reference: Scalar, readings: Readings, hand: ManualInput | None
) -> tuple[Scalar, Column]:
    """Return signal and memory of the first sample; a shaped reference begins at the reading."""
    start = readings[one.measured] if one.follows_reading else reference
    filters = (
        tuple(one.reading_filter.rest(readings[name]) for name in one.filtered_readings()) if one.reading_filter else ()
    )
    shaped = None if one.shaping is None else one.shaping.begin(start)
    inner = tuple(one.rest(xp, reference if shaped is None else start, readings))
    memory = ControllerMemory(filters, shaped, 0.0, inner).flatten(one)
    return continue_control(one, xp, memory, reference, readings, 0.0, hand)


def continue_control(
    one: AbstractController,
    xp: Namespace,
    memory: Column,
    reference: Scalar,
    readings: Readings,
    dt: Scalar,
    hand: ManualInput | None,
) -> tuple[Scalar, Column]:
    """Return signal and memory of a sample `dt` [s] after the last one."""
    before = split_memory(one, memory)
    names, low_pass, filters = one.filtered_readings(), one.reading_filter, before.filters
    if low_pass is not None:
        rows = zip(names, filters, strict=True)
        filters = tuple(tuple(low_pass.filter(xp, memory, readings[name], dt)) for name, memory in rows)
        readings = {**readings, **{name: row[0] for name, row in zip(names, filters, strict=True)}}
    shaped, target = before.shaped, reference
    if one.shaping is not None and shaped is not None:
        shaped = one.shaping.move(xp, shaped, reference, readings, dt)
        target = shaped.value
    wanted, after = one.answer(xp, before.inner, target, readings, dt)
    signal, taken = _override_signal(one, xp, wanted, readings, hand)
    if one.slew is not None:
        signal = one.slew.limit(xp, before.signal, signal, dt)
        after = _hold_integrals(one, xp, before.inner, after, wanted - signal)
    if taken is not None:
        tracked = one.track(xp, after, signal, target, readings)
        after = [xp.where(taken, new, old) for new, old in zip(tracked, after, strict=True)]
        if shaped is not None and one.follows_reading:
            resting = one.shaping.begin(readings[one.measured]) if one.shaping else shaped
            shaped = choose_tuple(xp, taken, resting, shaped)
    return signal, ControllerMemory(filters, shaped, signal, tuple(after)).flatten(one)


def _override_signal(
    one: AbstractController, xp: Namespace, wanted: Scalar, readings: Readings, hand: ManualInput | None
) -> tuple[Scalar, Flag | None]:
    """Return the signal, and whether it overrides the controller; None if it never does."""
    signal, taken = wanted, None
    if one.shaping is not None and one.shaping.below == "safe":
        taken = one.shaping.is_safe(xp, readings)
        signal = xp.where(taken, one.shaping.safe, signal)
    if one.manual is not None and hand is not None:
        by_hand = hand.automatic < 0.5
        signal = xp.where(by_hand, hand.signal, signal)
        taken = by_hand if taken is None else xp.either(by_hand, taken)
    return signal, taken


def _hold_integrals(one: AbstractController, xp: Namespace, before: Column, after: Column, beyond: Scalar) -> Column:
    """Return the memory without the growth of integrals in the direction of the limited part `beyond`."""
    memory = list(after)
    for place in one.integrals:
        gained = after[place] - before[place]
        memory[place] = xp.where(gained * beyond > 0.0, before[place], after[place])
    return memory
