"""`RealtimeStep`: the controllers, observers and supervisor of a bench without its plant.

What was tuned on the bench goes to the laboratory: readings of real sensors in, signals of real sources out, once per
period, by the same kernels, traced into one function and compiled. In every sample, as on the bench:

    readings → observers, with the signals since the last sample → controllers → supervisor

Whoever calls it keeps the time: once per `period`. On floats where there is no compiler.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from martensite.base.errors import ParameterError, suggest_name
from martensite.base.parameters import values_at
from martensite.control.loop import period
from martensite.control.loop.bench import Bench
from martensite.control.loop.names import AGE
from martensite.control.loop.realtime_program import CompiledLoop, FloatLoop, LoopState, list_reads, trace_loop
from martensite.kernels.compiler import find_compiler


class RealtimeStep:
    """Controllers, observers and supervisor of a bench, one sample at a time."""

    def __init__(self, bench: Bench, native: bool | None = None) -> None:
        """The loop of a bench, before its first sample.

        Args:
            bench: the bench; its plant, its sensors and its faults are left out.
            native: whether to run in C; by default if there is a compiler.
        """
        self.bench, self.count = bench, 0
        self.readings = list_reads(bench)
        """Names of the readings that it needs, in the order of an array of them."""
        self.drives: tuple[str, ...] = tuple(drive.name for drive in bench.plant.drives())
        """Names of the signals that it gives, in their order."""
        self.free = tuple(n for n in self.drives if n not in bench.controllers.members())
        """Names of the signals that no controller has."""
        traced = trace_loop(bench)
        in_c = find_compiler() is not None if native is None else native
        made = CompiledLoop if in_c else FloatLoop
        self._engine: Any = made(traced, values_at(bench, traced.paths))
        self._waveforms = [one.reference for one in bench.controllers.members().values()]
        self._keys = [(name, name + AGE) for name in self.readings]
        self._shape, self._signals = traced.shape, -len(self.drives)

    def reset(self) -> None:
        """Back to before the first sample."""
        self.count = 0

    def step(
        self,
        readings: Mapping[str, float] | Sequence[float],
        *,
        references: Sequence[float] | None = None,
        free: Mapping[str, float] | None = None,
    ) -> tuple[float, ...]:
        """The signals of the period that begins, in the order of `drives`.

        Args:
            readings: by name, with `NAME.age` [s] if they are late, or as an array in the order of `readings`; in SI.
            references: what the controllers shall follow now, in their order; by default what
                their waveforms say, with the first sample at 0 s.
            free: signals that no controller has, by the name of the drive; else 0.

        Raises:
            ParameterError: a reading is missing, or there are too many or too few.
        """
        if references is None:
            time = self.count * self.bench.period
            references = [waveform.value(time) for waveform in self._waveforms]
        others = [free.get(name, 0.0) if free else 0.0 for name in self.free]
        inputs = [*self._order_readings(readings), *references, *others]
        found = self._engine.run("step" if self.count else "begin", inputs)
        self.count += 1
        return tuple(found[self._signals :])

    def _order_readings(self, readings: Mapping[str, float] | Sequence[float]) -> list[float]:
        """All readings, then their ages."""
        if not isinstance(readings, Mapping):
            if len(readings) != len(self.readings):
                raise ParameterError(
                    f"A step needs {len(self.readings)} readings ({', '.join(self.readings)}), but got {len(readings)}."
                )
            return [*map(float, readings), *(0.0 for _ in self.readings)]
        try:
            values = [readings[name] for name in self.readings]
        except KeyError as error:
            name = str(error.args[0])
            raise ParameterError(f"A step needs the reading `{name}`. {suggest_name(name, readings)}") from None
        return [*values, *(readings.get(age, 0.0) for _, age in self._keys)]

    @property
    def state(self) -> LoopState:
        """What the parts remember after the last step."""
        if not self.count:
            raise ParameterError("A loop has no state before its first step.")
        return self._shape.rebuild(self._engine.state())

    @property
    def estimates(self) -> dict[str, float]:
        """What the observers said in the last step, by name."""
        return period.collect_estimates(self.bench, self.state.observers)
