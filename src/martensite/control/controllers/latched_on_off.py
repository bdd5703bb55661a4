"""Latched on/off control: on from a threshold until an oscillation has decayed, then off.

    on   once y > r
    off  once on, and A < share · largest A since then; it stays off

r is the threshold and the reference. y and the oscillation are readings, such as `rotor_speed` and `displacement` of a
motor on a beam. The amplitude A is half the range in consecutive windows, which must be longer than a period of the
oscillation.

`replay_controller` applies a controller to a record. Up to its first switching a run does not depend on the answer, so
a run under the replayed signal is right up to the second switching. Repeated runs so close a loop with few switchings.

Source: ON/OFF controller of Kossoski (2018), section 5.2.1, which states "when the vibration amplitudes of the system
decrease" and no measure of the decrease.
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
    """1 after the threshold was passed, else 0."""
    off: Scalar
    """1 after the end, else 0."""
    elapsed: Scalar
    """Time since the start of the window [s]."""
    lowest: Scalar
    highest: Scalar
    peak: Scalar
    """Largest amplitude since the start."""


@CONTROLLERS.register("latched")
class LatchedOnOff(AbstractController):
    """A switch that acts once: from a threshold, its reference, until an amplitude has decayed."""

    cites = ("kossoski2018",)
    holds = False

    oscillation: str = text("name of the reading whose amplitude switches it off", typical="=measured")
    share: Number = param("1", "amplitude over the largest one below which it is off", low=0.0, high=1.0, default=0.3)
    window: Number = param("s", "length of the window of an amplitude", above=0.0, default=0.25)
    high: Number = param(DRIVE, "signal while it is on", typical=HIGH)
    low: Number = param(DRIVE, "signal while it is off", default=0.0)

    def reads(self) -> tuple[str, ...]:
        return self.measured, self.oscillation

    def rest(self, xp: Namespace, reference: Scalar, readings: Readings) -> Latch:
        value = readings[self.oscillation]
        return Latch(0.0, 0.0, 0.0, value, value, 0.0)

    def answer(self, xp: Namespace, memory: Column, reference: Scalar, readings: Readings, dt: Scalar) -> Answer:
        latch = self._add_value(xp, Latch(*memory), readings[self.oscillation], dt)
        on = xp.where(readings[self.measured] > reference, 1.0, latch.on)
        closed = xp.both(on > 0.5, latch.off < 0.5)
        return xp.where(closed, self.high, self.low), latch._replace(on=on)

    def _add_value(self, xp: Namespace, memory: Latch, value: Scalar, dt: Scalar) -> Latch:
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
    """Return the signals of a controller along a record.

    Args:
        drive: the controller.
        times: times of the samples [s].
        columns: readings by name, in SI.

    Returns:
        The signal of every sample.
    """
    memory, signals = drive.init(), list[float]()
    for k, time in enumerate(times):
        row = {name: column[k] for name, column in columns.items()}
        signal, memory = drive(time, row, memory)
        signals.append(signal)
    return signals
