r"""Conditioning around any controller: filters before it, a mode, a shaped reference, a slew limit behind it.

    readings → filter → controller, which follows the shaped reference → by hand or safe → slew → signal

Each is a part of the controller that is left out unless it is given, and then the program is without it.

- A reading is the median of its last three, then a low pass by backward differences of first order, T y' + y = x, or
  of second order with a damping of 0.71, T² y''/2 + T y' + y = x.
- In manual mode the operator sets the signal, and the memory of the controller is set so that it would return the
  same signal (`track`). With an integral the change to automatic does not step the signal.
- Where the slew limit acts an integral does not go on in the direction of what is cut off.

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
    """1 while the controller has the signal, 0 while the hand has."""


class ReadingFilter(Parametrised):
    """A low pass for what a controller reads."""

    time_constant: Number = param("s", "time constant T", above=0.0, typical="50 ms")
    order: str = option("order of the low pass", "1", "2", default="1")
    median: str = option(
        "whether the median of three readings goes before it", "without", "of-three", default="without"
    )
    readings: tuple[str, ...] = text("readings that it filters; the controlled one if none", default=())

    @property
    def kept(self) -> int:
        """Return the numbers that it remembers of a reading."""
        return 1 + (self.order == "2") + 2 * (self.median == "of-three")

    def rest(self, reading: Scalar) -> Column:
        """Return the memory of a filter whose reading has been constant for a long time."""
        return (reading, *(0.0,) * (self.order == "2"), *(reading, reading) * (self.median == "of-three"))

    def filter(self, xp: Namespace, memory: Column, reading: Scalar, dt: Scalar) -> Column:
        """Return the memory, the filtered reading first, after a reading `dt` [s] after the last one."""
        T, value, found = self.time_constant, memory[0], reading
        past: Column = ()
        if self.median == "of-three":
            a, b = memory[-2:]
            found = xp.maximum(xp.minimum(a, b), xp.minimum(xp.maximum(a, b), reading))
            past = reading, a
        if self.order == "1":
            return (value + (found - value) * dt / (T + dt), *past)
        rate = (2.0 * dt * (found - value) + T * T * memory[1]) / (T * T + 2.0 * dt * T + 2.0 * dt * dt)
        return (value + dt * rate, rate, *past)


class SignalSlew(Parametrised):
    """Limit of the rate at which a signal changes; the signal begins at 0."""

    rising: Number = param(SIGNAL_RATE, "largest rate at which it rises", above=0.0, default=math.inf)
    falling: Number = param(SIGNAL_RATE, "largest rate at which it falls", above=0.0, default=math.inf)

    def check(self) -> None:
        """Raise `ParameterError` if nothing is limited."""
        if not (math.isfinite(self.rising) or math.isfinite(self.falling)):
            raise ParameterError("A slew limit needs a rate, `rising` or `falling`.")

        self.__dict__["_layout"] = math.isfinite(self.rising), math.isfinite(self.falling)

    def layout(self) -> tuple[int, ...]:
        """Which of the two there are."""
        return self.__dict__["_layout"]

    def limit(self, xp: Namespace, before: Scalar, wanted: Scalar, dt: Scalar) -> Scalar:
        """Return the allowed signal that is nearest to the wanted one, `dt` [s] after the last one."""
        up, down = self.layout()
        found = xp.minimum(wanted, before + self.rising * dt) if up else wanted
        return xp.maximum(found, before - self.falling * dt) if down else found


class ManualMode(Parametrised):
    """A signal by hand, and when the controller has it instead."""

    signal: AbstractWaveform = part("signal by hand", WAVEFORMS, default=Constant(level=0.0))
    automatic_from: Number = param("s", "time from which the controller has the signal", low=0.0, default=0.0)
    automatic_until: Number = param("s", "time until which it has", default=math.inf)

    def check(self) -> None:
        """Raise `ParameterError` if the controller never has the signal."""
        if not self.automatic_from < self.automatic_until:
            raise ParameterError("`automatic_from` must be before `automatic_until`.")

    @property
    def waveforms(self) -> tuple[AbstractWaveform, AbstractWaveform]:
        """Return the manual signal, and 1 while the controller sets the signal."""
        return self.signal, Step(low=0.0, high=1.0, at=self.automatic_from, until=self.automatic_until)


class Conditioned(NamedTuple):
    """Memory of a controller and of its filters, shaping and slew limit."""

    filters: tuple[Column, ...]
    shaped: ShapedReference | None
    signal: Scalar
    """The last one, if there is a slew limit."""
    inner: Column

    def flatten(self, one: AbstractController) -> Column:
        """Return all numbers."""
        last = () if one.slew is None else (self.signal,)
        return (*(number for row in self.filters for number in row), *(self.shaped or ()), *last, *self.inner)


def split_memory(one: AbstractController, memory: Column) -> Conditioned:
    """From all numbers of a controller."""
    rest, shaped = iter(memory), one.shaping is not None
    filters = tuple(tuple(islice(rest, one.reading_filter.kept)) for _ in one.filtered()) if one.reading_filter else ()
    found = ShapedReference(*islice(rest, len(ShapedReference._fields))) if shaped else None
    return Conditioned(filters, found, 0.0 if one.slew is None else next(rest), tuple(rest))


def begin_control(
    one: AbstractController, xp: Namespace, reference: Scalar, readings: Readings, hand: ManualInput | None
) -> tuple[Scalar, Column]:
    """Return the signal of the first sample, and all that is remembered: a shaped reference begins at the reading."""
    start = readings[one.measured] if one.follows_reading else reference
    filters = tuple(one.reading_filter.rest(readings[name]) for name in one.filtered()) if one.reading_filter else ()
    shaped = None if one.shaping is None else one.shaping.begin(start)
    inner = tuple(one.rest(xp, reference if shaped is None else start, readings))
    memory = Conditioned(filters, shaped, 0.0, inner).flatten(one)
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
    """Return the signal of another sample, `dt` [s] after the one before, and all that is remembered."""
    held = split_memory(one, memory)
    names, low_pass, filters = one.filtered(), one.reading_filter, held.filters
    if low_pass is not None:
        rows = zip(names, filters, strict=True)
        filters = tuple(tuple(low_pass.filter(xp, memory, readings[name], dt)) for name, memory in rows)
        readings = {**readings, **{name: row[0] for name, row in zip(names, filters, strict=True)}}
    shaped, target = held.shaped, reference
    if one.shaping is not None and shaped is not None:
        shaped = one.shaping.move(xp, shaped, reference, readings, dt)
        target = shaped.value
    wanted, after = one.answer(xp, held.inner, target, readings, dt)
    signal, taken = _override_signal(one, xp, wanted, readings, hand)
    if one.slew is not None:
        signal = one.slew.limit(xp, held.signal, signal, dt)
        after = _hold_integrals(one, xp, held.inner, after, wanted - signal)
    if taken is not None:
        tracked = one.track(xp, after, signal, target, readings)
        after = [xp.where(taken, new, old) for new, old in zip(tracked, after, strict=True)]
        if shaped is not None and one.follows_reading:
            resting = one.shaping.begin(readings[one.measured]) if one.shaping else shaped
            shaped = choose_tuple(xp, taken, resting, shaped)
    return signal, Conditioned(filters, shaped, signal, tuple(after)).flatten(one)


def _override_signal(
    one: AbstractController, xp: Namespace, wanted: Scalar, readings: Readings, hand: ManualInput | None
) -> tuple[Scalar, Flag | None]:
    """Return the signal, and whether it is one that the controller does not have; None if it always has."""
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
    """Return the memory without the growth of integrals in the direction of the part of the signal that is cut off."""
    found = list(after)
    for place in one.integrals:
        gained = after[place] - before[place]
        found[place] = xp.where(gained * beyond > 0.0, before[place], after[place])
    return found
