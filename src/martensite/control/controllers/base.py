"""Interface of a controller: a reference and readings in, the signal of a drive out.

A controller is a straight-line kernel with a memory: `rest` before the first sample, `answer` in every sample. A bench
(`martensite.control.loop`) traces it together with plant, sensors and observers, so that the whole loop runs in C, in
batches and with derivatives. A controller is also a drive (`AbstractDrive`) for `simulate_controlled` or your own
program: called once per sample with the readings, it returns floats.

Readings have names: sensors, estimates `estimated.NAME` of observers, and the age of each reading, `NAME.age` [s].
Without sensors the readings are the outputs of the system.

Any controller can have a filter of its readings, a shaped reference, a manual mode and a slew limit
(`martensite.control.controllers.conditioning`). Callers use `begin` and `proceed`, which include them.
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
AROUND = "reading_filter", "shaping", "manual", "slew"
"""Optional parts that surround any controller."""
TIME_TOLERANCE = 1e-9
"""Rounding error of times [s]."""
AHEAD = "ahead."
"""Prefix of readings with references: `ahead.DRIVE.0` is the present reference, higher numbers lie ahead."""
PLANNED = "planned"
"""Name of the reading with the signal that another controller has planned."""


class DriveMemory(NamedTuple):
    """Memory of a controller that runs as a drive."""

    time: float
    """Time of the last call [s]."""
    memory: Column


class AbstractController(AbstractDrive):
    """Interface of a controller; a subclass adds `rest` and `answer`."""

    holds: ClassVar[bool] = True
    """False for a controller that does not keep its reading at the reference; its loop has no sign."""
    names_reading = ("measured",)

    measured: str = text("name of the reading that must follow the reference", typical="position")
    reference: AbstractWaveform = part("reference of the reading, in its SI unit", WAVEFORMS)
    reading_filter: ReadingFilter | None = part("low pass of the readings", default=None)
    shaping: ReferenceShaping | None = part("limits of the rate of the reference, also by a confidence", default=None)
    manual: ManualMode | None = part("manual signal, and its times", default=None)
    slew: SignalSlew | None = part("largest rates of the signal", default=None)
    integrals: ClassVar[tuple[int, ...]] = ()
    """Places of integrals in the memory, which a slew limit holds."""

    def reads(self) -> tuple[str, ...]:
        """Return the names of the readings that the controller needs."""
        return (self.measured,)

    def needs(self) -> tuple[str, ...]:
        """Return the names of the readings that the controller and its optional parts need."""
        confidence = (self.shaping.confidence,) if self.shaping is not None and self.shaping.confidence else ()
        return tuple(dict.fromkeys((*self.reads(), *self.filtered_readings(), *confidence)))

    def filtered_readings(self) -> tuple[str, ...]:
        """Return the names of the readings that are filtered."""
        return () if self.reading_filter is None else self.reading_filter.readings or (self.measured,)

    @property
    def follows_reading(self) -> bool:
        """Return whether the reading follows the reference."""
        return type(self).reference_unit is AbstractController.reference_unit

    def reference_unit(self, readings: Mapping[str, str], signal: str) -> str:
        """Return the SI unit of the reference, by default the unit of the measured reading.

        Args:
            readings: SI units of all readings, by name.
            signal: SI unit of the signal.
        """
        return readings[self.measured]

    def describe(self, period: float) -> str:
        """Describe features such as the anti-windup for a sample period [s]."""
        return ""

    def list_previews(self) -> dict[str, tuple[float, ...]]:
        """Return the times ahead at which the controller reads references [s], by drive.

        The readings `ahead.DRIVE.1`, `ahead.DRIVE.2`, … hold their values.
        """
        return {}

    def led_drives(self) -> tuple[str, ...]:
        """Return the drives whose `follower` gets its signal from this controller."""
        return ()

    def share_signals(self, memory: Column) -> dict[str, Scalar]:
        """Return the signals of the led drives from the memory after a sample."""
        return {}

    def rest(self, xp: Namespace, reference: Scalar, readings: Readings) -> Column:
        """Return the memory before the first sample."""
        return ()

    @abstractmethod
    def answer(self, xp: Namespace, memory: Column, reference: Scalar, readings: Readings, dt: Scalar) -> Answer:
        """Return the signal and the new memory of a sample.

        Args:
            xp: namespace.
            memory: memory after the last sample, or from `rest`.
            reference: set-point of the reading now, in SI.
            readings: readings by name, in SI.
            dt: time since the last sample [s]; 0 for the first.
        """

    def list_outputs(self, unit: str, signal: str) -> dict[str, Output]:
        """Return the outputs of the controller in addition to its signal, by name.

        Args:
            unit: SI unit of its reference.
            signal: SI unit of its signal.
        """
        return {}

    def observe(self, xp: Namespace, memory: Column) -> Column:
        """Return the values of `list_outputs` from the memory after a sample."""
        return ()

    def describe_doubts(self, last: Mapping[str, float]) -> list[str]:
        """Return warnings about a run from the last values of `list_outputs`."""
        return []

    def track(self, xp: Namespace, memory: Column, signal: Scalar, reference: Scalar, readings: Readings) -> Column:
        """Return the memory with an integral that gives the applied signal."""
        return memory

    def begin(self, xp: Namespace, reference: Scalar, readings: Readings, hand: ManualInput | None = None) -> Answer:
        """Return signal and memory of the first sample, with all optional parts."""
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
        """Return signal and memory of a later sample, with all optional parts."""
        if not self.conditioned:
            return self.answer(xp, memory, reference, readings, dt)
        return continue_control(self, xp, memory, reference, readings, dt, hand)

    @property
    def conditioned(self) -> bool:
        """Return whether the controller has a filter, shaped reference, manual mode or slew limit."""
        return any(self.__dict__[name] is not None for name in AROUND)

    def init(self) -> DriveMemory | None:
        return None

    def __call__(self, time: float, measurement: Mapping[str, float], memory: Any) -> tuple[float, Any]:
        """Return the signal at `time` [s] and the new memory; called once per sample.

        Raises:
            ParameterError: a required reading is not measured.
        """
        require_readings(self, measurement)
        wanted = self.reference.value(time)
        hand = None if self.manual is None else ManualInput(*(one.value(time) for one in self.manual.waveforms))
        if memory is None:
            signal, after = self.begin(floats, wanted, measurement, hand)
        else:
            signal, after = self.proceed(floats, memory.memory, wanted, measurement, time - memory.time, hand)
        return signal, DriveMemory(time, after)


class SignalLimits(Parametrised):
    """Lower and upper limit of the signal of a controller."""

    low: Number = param(DRIVE, "least signal", default=0.0)
    high: Number = param(DRIVE, "largest signal", default=1.0)

    def check(self) -> None:
        if not self.low < self.high:
            raise ParameterError(
                "The least signal of a controller must be below the largest one, but they are "
                f"{self.low:g} and {self.high:g}."
            )

    @property
    def idle(self) -> float:
        """Return the signal within the limits that is nearest to 0."""
        return min(max(self.low, 0.0), self.high)

    def hold_integral(self, xp: Namespace, wanted: Scalar, push: Scalar, before: Scalar, after: Scalar) -> Scalar:
        """Return `before` where the unlimited signal is beyond a limit and `push` drives it further, else `after`."""
        over, under = xp.both(wanted > self.high, push > 0.0), xp.both(wanted < self.low, push < 0.0)
        return xp.where(xp.either(over, under), before, after)

    def hold_at_limit(self, xp: Namespace, signal: Scalar, push: Scalar, before: Scalar, after: Scalar) -> Scalar:
        """Return `before` where a limited signal is at a limit and `push` drives it further, else `after`."""
        over, under = xp.both(signal >= self.high, push > 0.0), xp.both(signal <= self.low, push < 0.0)
        return xp.where(xp.either(over, under), before, after)


def require_readings(controller: AbstractController, readings: Collection[str]) -> None:
    """Raise `ParameterError` if a controller needs a reading that does not exist."""
    for name in controller.needs():
        if name not in readings:
            title = controller.registered_name or type(controller).__name__
            raise ParameterError(
                f"Controller `{title}` cannot measure `{name}`: there is no such reading. "
                f"{suggest_name(str(name), readings)}"
            )
