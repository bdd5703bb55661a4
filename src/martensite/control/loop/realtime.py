"""Real-time loop: controllers of a bench on real sensors and sources.

The loop takes readings and returns signals once per period, by the kernels of the bench, traced into one function and
compiled; without a compiler it runs on floats. In every sample:

    readings → observers, with the signals since the last sample → controllers → supervisor

The caller keeps the time and calls it once per `period`.
"""

from __future__ import annotations

import ctypes
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from martensite.base.errors import ParameterError, suggest_name
from martensite.base.parameters import StructureKey, values_at
from martensite.control.controllers.base import PLANNED, AbstractController
from martensite.control.loop import period
from martensite.control.loop.bench import Bench
from martensite.control.loop.names import AGE, hand_drives, list_hands, list_previews, list_references
from martensite.control.loop.parts import ControllerState, Inputs, Numbers, ObserverState
from martensite.control.loop.run import reference_waveforms
from martensite.control.observers.base import ESTIMATED
from martensite.kernels import floats
from martensite.kernels.compiled_program import CompiledProgram
from martensite.kernels.compiler import find_compiler
from martensite.kernels.compute_once import cache_answers
from martensite.kernels.namespace import Namespace, Scalar
from martensite.kernels.nested import NestedShape, flatten_numbers
from martensite.kernels.program import Program


class RealtimeStep:
    """Controllers, observers and supervisor of a bench, one sample at a time."""

    def __init__(self, bench: Bench, native: bool | None = None) -> None:
        """Create the loop of a bench before its first sample.

        Args:
            bench: bench; its plant, sensors and faults are ignored.
            native: whether to run in C; default: if there is a compiler.

        Raises:
            ParameterError: the bench has no controller.
        """
        _require_controllers(bench)
        self.bench, self.count = bench, 0
        self.readings = list_reads(bench)
        """Names of the readings that it needs, in the order of an array of them."""
        self.drives: tuple[str, ...] = tuple(drive.name for drive in bench.plant.drives())
        """Names of the signals that it gives, in their order."""
        self.free = tuple(n for n in self.drives if n not in bench.controllers.members())
        """Names of the signals that no controller has."""
        traced = trace_loop(bench)
        in_c = find_compiler() is not None if native is None else native
        engine = CompiledLoop if in_c else FloatLoop
        self._engine: Any = engine(traced, values_at(bench, traced.paths))
        hands = [name for pair in list_hands(bench).values() for name in pair]
        self._waveforms = [one for name, one in reference_waveforms(bench).items() if name not in hands]
        self._previews = [list(bench.controllers.members()).index(one.drive) for one in list_previews(bench)]
        modes = ((name, one.manual) for name, one in bench.controllers.members().items())
        self._modes = {name: mode.waveforms for name, mode in modes if mode is not None}
        self._hands: dict[str, float | None] = {}
        self._keys = [(name, name + AGE) for name in self.readings]
        self._shape, self._signals = traced.shape, -len(self.drives)

    def reset(self) -> None:
        """Return to the state before the first sample."""
        self.count = 0
        self._hands.clear()

    def set_manual(self, value: float | None = None, drive: str | None = None) -> None:
        """Set the signal of a drive manually from the next sample on.

        Args:
            value: signal in SI; default: the last signal.
            drive: drive of the controller; required for several controllers.

        Raises:
            ParameterError: the controller has no manual mode, or there is no last signal.
        """
        name = self._find_mode(drive)
        if value is None:
            value = self.state.signals[self.drives.index(name)]
        self._hands[name] = float(value)

    def set_automatic(self, drive: str | None = None) -> None:
        """Return a controller to automatic mode from the next sample on.

        Raises:
            ParameterError: it has no manual mode.
        """
        self._hands[self._find_mode(drive)] = None

    def _find_mode(self, drive: str | None) -> str:
        name = next(iter(self._modes)) if drive is None and len(self._modes) == 1 else drive
        if name not in self._modes:
            raise ParameterError(
                "A controller needs a `manual` part to be set by hand, such as `manual = ManualMode()`; "
                f"there is none of `{name or 'this loop'}`. {suggest_name(str(name), self._modes)}"
            )
        return name

    def _set_by_hand(self) -> list[float]:
        inputs: list[float] = []
        for name, waveforms in self._modes.items():
            signal, automatic = (wave.value(self.count * self.bench.period) for wave in waveforms)
            if name in self._hands:
                value = self._hands[name]
                signal, automatic = (signal, 1.0) if value is None else (value, 0.0)
            inputs += (signal, automatic)
        return inputs

    def step(
        self,
        readings: Mapping[str, float] | Sequence[float],
        *,
        references: Sequence[float] | None = None,
        free: Mapping[str, float] | None = None,
    ) -> tuple[float, ...]:
        """Return the signals of the next period, in the order of `drives`.

        Args:
            readings: readings by name, with `NAME.age` [s] if late, or an array in the order of `readings`; in SI.
            references: references in the order of the controllers, followed by references ahead (`list_previews`),
                which default to the present; default: the waveforms, with the first sample at 0 s.
            free: signals without a controller, by drive.

        Raises:
            ParameterError: a reading, reference or free signal is missing, or the number of values is wrong.
        """
        if references is None:
            time = self.count * self.bench.period
            references = [waveform.value(time) for waveform in self._waveforms]
        elif len(references) == len(self._waveforms) - len(self._previews):
            references = [*references, *(references[k] for k in self._previews)]
        if len(references) != len(self._waveforms):
            now = len(self._waveforms) - len(self._previews)
            raise ParameterError(
                f"A step needs {now} references, or {len(self._waveforms)} with those ahead, but got {len(references)}."
            )
        others = self._order_free(free or {})
        inputs = [*self._order_readings(readings), *references, *self._set_by_hand(), *others]
        state = self._engine.run("step" if self.count else "begin", inputs)
        self.count += 1
        return tuple(state[self._signals :])

    def _order_readings(self, readings: Mapping[str, float] | Sequence[float]) -> list[float]:
        """Return all readings, then their ages."""
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

    def _order_free(self, given: Mapping[str, float]) -> list[float]:
        for name in self.free:
            if name not in given:
                raise ParameterError(
                    f"A step needs the signal of `{name}`, which no controller of the bench has: write "
                    f'`free={{"{name}": 0.0}}` with its value. {suggest_name(name, given)}'
                )
        return [given[name] for name in self.free]

    @property
    def state(self) -> LoopState:
        """Return the memories of the parts after the last step."""
        if not self.count:
            raise ParameterError("A loop has no state before its first step.")
        return self._shape.rebuild(self._engine.state())

    @property
    def estimates(self) -> dict[str, float]:
        """Return the estimates of the last step by name."""
        return period.collect_estimates(self.bench, self.state.observers)

    @property
    def outputs(self) -> dict[str, float]:
        """Return the outputs of the controllers in the last step, by their names on a bench: `controller.NAME`."""
        return period.collect_controller_outputs(self.bench, floats, self.state.controllers)


class LoopState(NamedTuple):
    """State of a loop without its plant."""

    observers: tuple[ObserverState, ...]
    controllers: tuple[ControllerState, ...]
    supervisor: tuple[Scalar, ...]
    alarm: Scalar
    signals: tuple[Scalar, ...]
    """Allowed signals of all drives of the plant."""


def _require_controllers(bench: Bench) -> None:
    if not bench.controllers.members():
        raise ParameterError(
            "The bench has no controller, so that its loop would give no signal. One that runs outside of the bench "
            "cannot be compiled: call it in every period, as `simulate_bench` does with `outside`."
        )


def list_reads(bench: Bench) -> tuple[str, ...]:
    """Return the names of the readings that the parts of a bench need from sensors."""
    parts: list[Any] = [*bench.observers.members().values(), *bench.controllers.members().values()]
    parts += [] if bench.supervisor is None else [bench.supervisor]
    names = [n for one in parts for n in (one.needs() if isinstance(one, AbstractController) else one.reads())]
    measured = [name for name in names if name != PLANNED and not name.startswith(ESTIMATED)]
    return tuple(dict.fromkeys(name.removesuffix(AGE) for name in measured))


def _begin_sample(bench: Bench, xp: Namespace, readings: Numbers, inputs: Inputs) -> LoopState:
    observers, controllers, memory, readings = period.begin_loop(bench, xp, readings, inputs)
    return _judge_sample(bench, xp, LoopState(observers, controllers, memory, 0.0, ()), readings, inputs)


def _continue_sample(bench: Bench, xp: Namespace, before: LoopState, readings: Numbers, inputs: Inputs) -> LoopState:
    signals = dict(zip(_list_drives(bench), before.signals, strict=True))
    observers = period.update_observers(bench, xp, before.observers, readings, signals)
    readings = readings | period.collect_estimates(bench, observers)
    controllers = period.update_controllers(bench, xp, before.controllers, readings, inputs)
    after = before._replace(observers=observers, controllers=controllers)
    return _judge_sample(bench, xp, after, readings, inputs)


def _judge_sample(bench: Bench, xp: Namespace, loop: LoopState, readings: Numbers, inputs: Inputs) -> LoopState:
    ordered = period.collect_wanted(bench, loop.controllers, inputs)
    verdict = period.judge_signals(bench, xp, loop.supervisor, ordered, readings)
    signals = tuple(verdict.signals[name] for name in ordered)
    return loop._replace(supervisor=tuple(verdict.memory), alarm=verdict.alarm, signals=signals)


def _list_drives(bench: Bench) -> list[str]:
    return [drive.name for drive in bench.plant.drives()]


@dataclass(frozen=True, eq=False)
class TracedLoop:
    """A traced loop with functions `begin` and `step` over flat states."""

    program: Program
    paths: tuple[str, ...]
    """Parameter paths in the order of the program."""
    shape: NestedShape
    size: int
    inputs: int
    """Number of readings, ages, references, manual inputs and free signals."""


def trace_loop(bench: Bench) -> TracedLoop:
    """Return the traced loop of a bench, cached by its structure."""
    return _trace_keyed(StructureKey(bench))


@cache_answers(32)
def _trace_keyed(keyed: StructureKey[Bench]) -> TracedLoop:
    """Return the first and later samples of a loop as a program over flat states."""
    program = Program()
    paths = tuple(leaf.path for leaf in keyed.part.leaves())
    bench = keyed.part.rebuilt({path: program.parameter(path) for path in paths})
    names, free = list_reads(bench), [n for n in _list_drives(bench) if n not in bench.controllers.members()]
    references, hands = list_references(bench), [drive.name for drive in hand_drives(bench)]
    ahead = [one.name for one in list_previews(bench)]
    signals = [*names, *(name + AGE for name in names), *references, *ahead, *hands, *free]
    labels = [f"i{i}" for i in range(len(signals))]
    shapes: list[NestedShape] = []

    def sorted_out(numbers: Sequence[Scalar]) -> tuple[Numbers, Inputs]:
        split, end = 2 * len(names), len(signals) - len(free)
        after = split + len(references)
        others = dict(zip(free, numbers[end:], strict=True))
        readings = dict(zip(signals[:split], numbers[:split], strict=True))
        middle = end - len(hands)
        by_hand = period.sort_hands(bench, iter(numbers[middle:end]))
        return readings, Inputs(tuple(numbers[split:after]), tuple(numbers[after:middle]), by_hand, others, ())

    def begin(xp: Any, *numbers: Any) -> list[Any]:
        loop = _begin_sample(bench, xp, *sorted_out(numbers))
        shapes.append(NestedShape(loop))
        return flatten_numbers(loop)

    def step(xp: Any, *numbers: Any) -> list[Any]:
        before = shapes[0].rebuild(numbers[:size])
        return flatten_numbers(_continue_sample(bench, xp, before, *sorted_out(numbers[size:])))

    program.add("begin", labels, begin)
    size = len(flatten_numbers(shapes[0].example))
    program.add("step", [*(f"s{i}" for i in range(size)), *labels], step)
    return TracedLoop(program, paths, shapes[0], size, len(labels))


class CompiledLoop:
    """One loop in C."""

    def __init__(self, traced: TracedLoop, values: Sequence[float]) -> None:
        self.size, number = traced.size, ctypes.c_double
        table = np.array([*values, 0.0], float)[:, None]
        program = CompiledProgram(traced.program, ("begin", "step"), table)
        one, other = np.zeros((2, traced.size + traced.inputs))
        self.rooms = [(number * len(room)).from_buffer(room.data) for room in (one, other)]
        """A sample goes from the state in one, with the inputs behind it, to that in the other."""
        pairs = (one, other), (other, one)
        self.functions = {
            "begin": [program.bind("begin", x[traced.size :], y) for x, y in pairs],
            "step": [program.bind("step", x, y) for x, y in pairs],
        }
        self.now = 0

    def run(self, name: str, inputs: Sequence[float]) -> list[float]:
        """Return the state after a sample."""
        now = self.now
        self.rooms[now][self.size :] = inputs
        self.functions[name][now]()
        self.now = 1 - now
        return self.rooms[1 - now][: self.size]

    def state(self) -> list[float]:
        """Return the state after the last sample."""
        return self.rooms[self.now][: self.size]


class FloatLoop:
    """One loop on floats."""

    def __init__(self, traced: TracedLoop, values: Sequence[float]) -> None:
        self.functions = traced.program.bind_floats(*values)
        self.now: tuple[float, ...] = ()

    def run(self, name: str, inputs: Sequence[float]) -> Sequence[float]:
        """Return the state after a sample."""
        before = self.now if name == "step" else ()
        self.now = self.functions[name](*before, *inputs)
        return self.now

    def state(self) -> Sequence[float]:
        """Return the state after the last sample."""
        return self.now
