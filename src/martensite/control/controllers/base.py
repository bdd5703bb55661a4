"""The contract of a controller: a reference and readings in, the signal of a drive out.

A controller is a straight-line kernel with a memory of numbers: `rest` before the first sample, `answer` in every
sample. On a bench (`martensite.control.loop`) it is traced together with the plant, the sensors and the observers, so
that the whole loop runs in C, in batches and with derivatives. The same controller is a drive like any other
(`AbstractDrive`): called once per sample with the readings, it returns plain floats, in `simulate_controlled` or in
your own program.

Readings come by name: those of sensors, `estimated.NAME` of observers, and the age of each,
`NAME.age` [s]. Without sensors they are the outputs of the system themselves.

Filters of readings, the shaping of the reference, a manual mode and a slew limit stand around any controller
(`martensite.control.controllers.conditioning`). The caller uses `begin` and `proceed`.
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Collection, Mapping, Sequence
from typing import Any, ClassVar, NamedTuple, TypeAlias

from martensite.actuators.mechanisms.base import Output
from martensite.base.errors import ParameterError, suggest_name
from martensite.base.parameters import Number, Parametrised, param, part, text
from martensite.base.registry import Registry
from martensite.control.controllers.conditioning import (
    ManualInput,
    ManualMode,
    ReadingFilter,
    SignalSlew,
    begin_control,
    continue_control,
)
from martensite.control.controllers.shaping import ReferenceShaping
from martensite.kernels import floats
from martensite.kernels.namespace import Namespace, Scalar
from martensite.signals.base import DRIVE, WAVEFORMS, AbstractDrive, AbstractWaveform

CONTROLLERS: Registry[AbstractController] = Registry("controller", "martensite.control.controllers", typical="pid")
Column: TypeAlias = Sequence[Scalar]
Readings: TypeAlias = Mapping[str, Scalar]
Answer: TypeAlias = tuple[Scalar, Column]
"""The signal of a sample, and the memory for the next sample."""
AROUND = "reading_filter", "shaping", "manual", "slew"
"""Parts of any controller that stand around it."""
TIME_TOLERANCE = 1e-9
"""Difference of times that is rounding [s]."""
AHEAD = "ahead."
"""Prefix of the names of references among the readings: `ahead.DRIVE.0` is the present value, higher numbers lie ahead.
"""
PLANNED = "planned"
"""Name of the reading with the signal that another controller has planned for a drive."""


class Called(NamedTuple):
    """Memory of a controller that runs as a drive."""

    time: float
    """Time of the last call [s]."""
    memory: Column


class AbstractController(AbstractDrive):
    """Interface of a controller; a subclass adds `rest` and `answer`."""

    holds: ClassVar[bool] = True
    """False for one that does not keep its reading at the reference, so that a loop has no sign."""
    names_reading = ("measured",)

    measured: str = text("name of the reading that shall follow the reference", typical="position")
    reference: AbstractWaveform = part("what it shall follow, in its SI unit", WAVEFORMS)
    reading_filter: ReadingFilter | None = part("low pass of what it reads", default=None)
    shaping: ReferenceShaping | None = part("limits of the rate of the reference, by a confidence too", default=None)
    manual: ManualMode | None = part("a signal by hand, and when", default=None)
    slew: SignalSlew | None = part("largest rates of the signal", default=None)
    integrals: ClassVar[tuple[int, ...]] = ()
    """Places in its memory of integrals that a slew limit holds."""

    def reads(self) -> tuple[str, ...]:
        """Return the names of all readings it needs."""
        return (self.measured,)

    def needs(self) -> tuple[str, ...]:
        """Return the names of all readings that it or what stands around it needs."""
        confidence = (self.shaping.confidence,) if self.shaping is not None and self.shaping.confidence else ()
        return tuple(dict.fromkeys((*self.reads(), *self.filtered(), *confidence)))

    def filtered(self) -> tuple[str, ...]:
        """Return the names of the readings that are filtered."""
        return () if self.reading_filter is None else self.reading_filter.readings or (self.measured,)

    @property
    def follows_reading(self) -> bool:
        """Return whether the reading follows the reference."""
        return type(self).reference_unit is AbstractController.reference_unit

    def reference_unit(self, readings: Mapping[str, str], signal: str) -> str:
        """SI unit of the reference: that of the reading that shall follow it.

        Args:
            readings: SI units of all readings, by name.
            signal: SI unit of the signal.
        """
        return readings[self.measured]

    def describe(self, period: float) -> str:
        """Describe features such as the anti-windup, for `check` and summaries; the sample period is in seconds."""
        return ""

    def list_previews(self) -> dict[str, tuple[float, ...]]:
        """Return the times [s] by which the controller looks ahead at references, by drive, its own drive included.

        Their values are among the readings: `ahead.DRIVE.1`, `ahead.DRIVE.2`, … .
        """
        return {}

    def led_drives(self) -> tuple[str, ...]:
        """Return the drives whose controllers, of kind `follower`, get their signals from this one."""
        return ()

    def share_signals(self, memory: Column) -> dict[str, Scalar]:
        """Return the signals of the drives that it leads, from what it remembers after a sample."""
        return {}

    def rest(self, xp: Namespace, reference: Scalar, readings: Readings) -> Column:
        """Return the memory before the first sample."""
        return ()

    @abstractmethod
    def answer(self, xp: Namespace, memory: Column, reference: Scalar, readings: Readings, dt: Scalar) -> Answer:
        """Return the signal of this sample, and the memory for the next sample.

        Args:
            xp: namespace.
            memory: from the sample before, or from `rest`.
            reference: what the reading shall be now, in SI.
            readings: by name, in SI.
            dt: time since the sample before [s]; 0 for the first one.
        """

    def list_outputs(self, unit: str, signal: str) -> dict[str, Output]:
        """Return the outputs of the controller beside its signal, by name; empty by default.

        Args:
            unit: SI unit of its reference.
            signal: SI unit of its signal.
        """
        return {}

    def observe(self, xp: Namespace, memory: Column) -> Column:
        """Return their values after a sample, from what it remembers, in the order of `list_outputs`."""
        return ()

    def describe_doubts(self, last: Mapping[str, float]) -> list[str]:
        """Return the sentences about what it failed to do in a run, by the last values of its `list_outputs`."""
        return []

    def track(self, xp: Namespace, memory: Column, signal: Scalar, reference: Scalar, readings: Readings) -> Column:
        """Return the memory after a sample with a different signal; the integral is set to give that signal."""
        return memory

    def begin(self, xp: Namespace, reference: Scalar, readings: Readings, hand: ManualInput | None = None) -> Answer:
        """Return the signal of the first sample, and what is remembered, with what stands around the controller."""
        if not self.conditioned:
            return self.answer(xp, tuple(self.rest(xp, reference, readings)), reference, readings, 0.0)
        return begin_control(self, xp, reference, readings, hand)

    def proceed(
        self,
        xp: Namespace,
        memory: Column,
        reference: Scalar,
        readings: Readings,
        dt: Scalar,
        hand: ManualInput | None = None,
    ) -> Answer:
        """Return the signal of another sample, and what is remembered, with what stands around the controller."""
        if not self.conditioned:
            return self.answer(xp, memory, reference, readings, dt)
        return continue_control(self, xp, memory, reference, readings, dt, hand)

    @property
    def conditioned(self) -> bool:
        """Return whether filters, a manual mode, a shaped reference or a slew limit surround the controller."""
        return any(self.__dict__[name] is not None for name in AROUND)

    def init(self) -> Called | None:
        """Nothing measured."""
        return None

    def __call__(self, time: float, measurement: Mapping[str, float], memory: Any) -> tuple[float, Any]:
        """Return the signal at `time` [s] and the new memory; called once in every sample.

        Raises:
            ParameterError: something that it reads is not measured.
        """
        require_readings(self, measurement)
        wanted = self.reference.value(time)
        hand = None if self.manual is None else ManualInput(*(one.value(time) for one in self.manual.waveforms))
        if memory is None:
            signal, after = self.begin(floats, wanted, measurement, hand)
        else:
            signal, after = self.proceed(floats, memory.memory, wanted, measurement, time - memory.time, hand)
        return signal, Called(time, after)


class SignalLimits(Parametrised):
    """Lower and upper limit of the signal of a controller."""

    low: Number = param(DRIVE, "least signal", default=0.0)
    high: Number = param(DRIVE, "largest signal", default=1.0)

    def check(self) -> None:
        """Raise `ParameterError` if there is nothing between the limits."""
        if not self.low < self.high:
            raise ParameterError(
                "The least signal of a controller must be below the largest one, but they are "
                f"{self.low:g} and {self.high:g}."
            )

    @property
    def idle(self) -> float:
        """Return the signal nearest to 0 within the limits: that before anything is controlled."""
        return min(max(self.low, 0.0), self.high)

    def hold_integral(self, xp: Namespace, wanted: Scalar, push: Scalar, before: Scalar, after: Scalar) -> Scalar:
        """Return the integral, held at `before` where the signal is beyond a limit and its error pushes it further."""
        over, under = xp.both(wanted > self.high, push > 0.0), xp.both(wanted < self.low, push < 0.0)
        return xp.where(xp.either(over, under), before, after)


def require_readings(controller: AbstractController, known: Collection[str]) -> None:
    """Raise `ParameterError` if a controller reads what is not known."""
    for name in controller.needs():
        if name not in known:
            title = controller.registered_name or type(controller).__name__
            raise ParameterError(
                f"Controller `{title}` cannot measure `{name}`: there is no such reading. "
                f"{suggest_name(str(name), known)}"
            )
