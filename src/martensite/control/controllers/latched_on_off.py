"""Latched ON/OFF control: on from a threshold until an oscillation has died down, then off.

    on   once y > r
    off  once on, and A < share · largest A since then; it stays off

with the threshold r, the reference. y and the oscillation are readings by name, such as `rotor_speed` and
`displacement` of a motor on a beam. A is half the distance of the extremes in a window, measured in consecutive
windows; windows must be longer than a period of the oscillation.

`replayed` says what a controller would have done along a record. Up to its first switching a run
does not depend on the answer, so a run under it is right up to the second one, and so on: with
few switchings, repeated runs close the loop without a controller in the march.

Source: the ON/OFF controller of Kossoski (2018), section 5.2.1, which says "when the vibration
amplitudes of the system decrease" and leaves the measure of that open.
"""

from collections.abc import Mapping, Sequence
from typing import NamedTuple

from martensite.base.parameters import Number, param, text
from martensite.control.controllers.base import (
    CONTROLLERS,
    TIME_TOLERANCE,
    AbstractController,
    Answer,
    Column,
    Readings,
)
from martensite.kernels.namespace import Namespace, Scalar
from martensite.signals.base import DRIVE, AbstractDrive
from martensite.signals.levels import HIGH
from martensite.signals.sampling.sampled import Numbers


class Latch(NamedTuple):
    """Memory of a latched controller."""

    on: Scalar
    """1 from the threshold on, else 0."""
    off: Scalar
    """1 from the end on, else 0."""
    elapsed: Scalar
    """Time since the window began [s]."""
    lowest: Scalar
    highest: Scalar
    """Extremes in the window so far."""
    peak: Scalar
    """Largest amplitude since it was switched on."""


@CONTROLLERS.register("latched")
class LatchedOnOff(AbstractController):
    """A switch that acts once: from a threshold, its reference, until an amplitude has fallen."""

    cites = ("kossoski2018",)
    holds = False

    oscillation: str = text("name of the reading whose amplitude switches it off", typical="=measured")
    share: Number = param("1", "share of the largest amplitude below which it is off", low=0.0, high=1.0, default=0.3)
    window: Number = param("s", "length of the window of an amplitude", above=0.0, default=0.25)
    high: Number = param(DRIVE, "signal while it is on", typical=HIGH)
    low: Number = param(DRIVE, "signal while it is off", default=0.0)

    def reads(self) -> tuple[str, ...]:
        """Return the readings that switch it on and off."""
        return self.measured, self.oscillation

    def rest(self, xp: Namespace, reference: Scalar, readings: Readings) -> Latch:
        """Return the memory of a controller that is off, at the beginning of a window."""
        value = readings[self.oscillation]
        return Latch(0.0, 0.0, 0.0, value, value, 0.0)

    def answer(self, xp: Namespace, memory: Column, reference: Scalar, readings: Readings, dt: Scalar) -> Answer:
        """Return the signal of this sample, and the memory for the next sample."""
        seen = self._add_value(xp, Latch(*memory), readings[self.oscillation], dt)
        on = xp.where(readings[self.measured] > reference, 1.0, seen.on)
        closed = xp.both(on > 0.5, seen.off < 0.5)
        return xp.where(closed, self.high, self.low), seen._replace(on=on)

    def _add_value(self, xp: Namespace, memory: Latch, value: Scalar, dt: Scalar) -> Latch:
        """Return the memory with one more value; at the end of a window its amplitude is judged."""
        low, high = xp.minimum(value, memory.lowest), xp.maximum(value, memory.highest)
        elapsed = memory.elapsed + dt
        over = elapsed >= self.window - TIME_TOLERANCE
        amplitude = 0.5 * (high - low)
        peak = xp.where(memory.on > 0.5, xp.maximum(memory.peak, amplitude), 0.0)
        off = xp.where(amplitude < self.share * peak, 1.0, memory.off)
        return Latch(
            memory.on,
            xp.where(over, off, memory.off),
            xp.where(over, 0.0, elapsed),
            xp.where(over, value, low),
            xp.where(over, value, high),
            xp.where(over, peak, memory.peak),
        )


def replay_controller(
    drive: AbstractDrive, times: Sequence[float] | Numbers, columns: Mapping[str, Sequence[float] | Numbers]
) -> list[float]:
    """Return the signal that a controller gives at every sample [s] of a record, its readings in SI."""
    memory, signals = drive.init(), list[float]()
    for k, time in enumerate(times):
        row = {name: column[k] for name, column in columns.items()}
        signal, memory = drive(time, row, memory)
        signals.append(signal)
    return signals
