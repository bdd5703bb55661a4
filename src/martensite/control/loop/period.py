"""Kernels of the parts of a period, in the order of `Bench`."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from martensite.actuators.assembly import AbstractSystem
from martensite.actuators.assembly.systems import Piece
from martensite.control.controllers.base import AHEAD, PLANNED
from martensite.control.controllers.conditioning import ManualInput, split_memory
from martensite.control.loop.names import AGE, AMBIENT, list_controller_outputs, list_previews
from martensite.control.loop.parts import (
    BenchState,
    ControllerState,
    Inputs,
    Numbers,
    ObserverState,
    SensorFaults,
    SensorState,
    SupervisorVerdict,
)
from martensite.control.observers.base import ESTIMATED
from martensite.kernels.namespace import Namespace, Scalar
from martensite.physics.electrical.base import AbstractSwitch

if TYPE_CHECKING:
    from martensite.control.loop.bench import Bench

Signals = Mapping[str, Scalar]
SLIGHT = 1e-9
"""Least fraction of a period, so that no step has length 0."""


def sorted_inputs(bench: Bench, drives: Sequence[Scalar]) -> Inputs:
    """Return the inputs of the bench, by destination."""
    controlled, rest = bench.controllers.members(), iter(drives)
    references = tuple(next(rest) for _ in controlled)
    previews = tuple(next(rest) for _ in list_previews(bench))
    hands = sort_hands(bench, rest)
    free = {d.name: next(rest) for d in bench.plant.drives() if d.name not in controlled}
    numbers = tuple((next(rest), next(rest)) for _ in bench.sensors.members())
    return Inputs(references, previews, hands, free, numbers)


def sort_hands(bench: Bench, rest: Iterator[Scalar]) -> tuple[ManualInput | None, ...]:
    """Return the manual inputs by controller from the next drives."""
    members = bench.controllers.members().values()
    return tuple(None if one.manual is None else ManualInput(next(rest), next(rest)) for one in members)


def apply_supervisor(bench: Bench, xp: Namespace, state: BenchState, inputs: Inputs) -> SupervisorVerdict:
    """Return the signals of the plant that the supervisor allows."""
    ordered, readings = collect_wanted(bench, state.controllers, inputs), Numbers()
    if bench.supervisor is not None:
        if not state.sensors:
            readings = collect_truth(bench, xp, apply_faults(bench, xp, state.time), state.plant, ordered)
        readings = collect_readings(bench, state.sensors, readings) | collect_estimates(bench, state.observers)
    return judge_signals(bench, xp, state.supervisor, ordered, readings)


def collect_wanted(bench: Bench, controllers: Sequence[ControllerState], inputs: Inputs) -> Numbers:
    """Return the signals of controllers and the free signals, in the order of the drives."""
    rows = zip(bench.controllers.members(), controllers, strict=True)
    signals = inputs.free | {name: state.wanted for name, state in rows}
    return {drive.name: signals[drive.name] for drive in bench.plant.drives()}


def collect_idle(bench: Bench, inputs: Inputs) -> Numbers:
    """Return the signals before the first sample, in the order of the drives."""
    return {drive.name: inputs.free.get(drive.name, 0.0) for drive in bench.plant.drives()}


def judge_signals(
    bench: Bench, xp: Namespace, memory: Sequence[Scalar], signals: Numbers, readings: Numbers
) -> SupervisorVerdict:
    """Return the verdict of the supervisor; all signals pass without a supervisor."""
    if bench.supervisor is None:
        return SupervisorVerdict(signals, 0.0, ())
    return bench.supervisor.judge(xp, memory, signals, readings, bench.period)


def begin_loop(
    bench: Bench, xp: Namespace, readings: Numbers, inputs: Inputs
) -> tuple[tuple[ObserverState, ...], tuple[ControllerState, ...], tuple[Scalar, ...], Numbers]:
    """Return observers, controllers and supervisor in the first sample, and all readings."""
    first = [one.rest(xp, readings, collect_idle(bench, inputs)) for one in bench.observers.members().values()]
    observers = tuple(ObserverState(tuple(estimates), tuple(memory)) for estimates, memory in first)
    readings = readings | collect_estimates(bench, observers)
    controllers = answer_all(bench, xp, None, readings | look_ahead(bench, inputs), inputs)
    memory = () if bench.supervisor is None else tuple(bench.supervisor.rest(xp, readings))
    return observers, controllers, memory, readings


def collect_shaped(bench: Bench, controllers: Sequence[ControllerState]) -> list[Scalar]:
    """Return the shaped references that controllers follow."""
    rows = zip(bench.controllers.members().values(), controllers, strict=True)
    references = [split_memory(one, state.memory).shaped for one, state in rows]
    return [shaped.value for shaped in references if shaped is not None]


def apply_faults(bench: Bench, xp: Namespace, time: Scalar) -> AbstractSystem:
    """Return the plant with all faults at a time [s]."""
    plant = bench.plant
    for fault in bench.faults.members().values():
        plant = fault.plant(xp, plant, fault.active(xp, time))
    return plant


def deliver_signals(bench: Bench, xp: Namespace, time: Scalar, signals: Signals) -> Numbers:
    """Return the signals that arrive at the sources."""
    arriving = dict(signals)
    for fault in bench.faults.members().values():
        active = fault.active(xp, time)
        arriving = {name: fault.signal(xp, name, u, active) for name, u in arriving.items()}
    return arriving


def split_period(bench: Bench, xp: Namespace, signals: Signals) -> list[Piece]:
    """Return signals and lengths of the pieces of a step."""
    length = bench.period / bench.turns
    if bench.switching == "averaged":
        return [(list(signals.values()), length)]
    ((duty, closed),) = _switch_signals(bench, xp, signals)
    on, off = (close_switch(xp, duty, closed), xp.where(closed < 1.0, 0.0, close_switch(xp, duty, closed)))
    closed = xp.clip(closed, SLIGHT, 1.0 - SLIGHT)
    return [([on], closed * length), ([off], (1.0 - closed) * length)]


def _switch_signals(bench: Bench, xp: Namespace, signals: Signals) -> list[tuple[Scalar, Scalar]]:
    """Return the signal of every switch, and the fraction of time for which it is closed."""
    sources = [one.source for one in bench.plant.actuators().values()]
    frequency = bench.turns / bench.period
    rows = zip(sources, signals.values(), strict=True)
    return [(u, one.share(xp, u, frequency)) for one, u in rows if isinstance(one, AbstractSwitch)]


def close_switch(xp: Namespace, duty: Scalar, closed: Scalar) -> Scalar:
    """Return the signal of a switch in its pulse: 1, -1 for a negative duty cycle, or 0 without a pulse."""
    return xp.where(closed > 0.0, xp.where(duty < 0.0, -1.0, 1.0), 0.0)


def collect_truth(bench: Bench, xp: Namespace, plant: AbstractSystem, state: Any, signals: Signals) -> Numbers:
    """Return the outputs that sensors may measure; electrical outputs apply to the closed switch."""
    applied = list(signals.values())
    if bench.switching == "pulses":
        applied = [close_switch(xp, u, closed) for u, closed in _switch_signals(bench, xp, signals)]
    outputs: Numbers = dict(zip(plant.outputs(), plant.observe(xp, state, *applied), strict=True))
    for port, one in plant.actuators().items():
        outputs[plant.label(port, AMBIENT)] = one.environment.temperature
    return outputs


def update_sensors(
    bench: Bench, xp: Namespace, before: Sequence[SensorState], truth: Numbers, inputs: Inputs, time: Scalar
) -> tuple[SensorState, ...]:
    """Return all sensors after a period."""
    rows = zip(bench.sensors.members().items(), before, inputs.numbers, strict=True)
    every = bench.faults.members().values()
    faults = [(one.fault_at(xp, time), one.active(xp, time)) for one in every]
    return tuple(
        mounted.step(xp, state, truth, numbers, bench.period, SensorFaults(name, faults))
        for (name, mounted), state, numbers in rows
    )


def update_observers(
    bench: Bench, xp: Namespace, before: Sequence[ObserverState], readings: Numbers, signals: Numbers
) -> tuple[ObserverState, ...]:
    """Return all observers after a period."""
    rows = zip(bench.observers.members().values(), before, strict=True)
    updates = [one.update(xp, state.memory, readings, signals, bench.period, bench.turns) for one, state in rows]
    return tuple(ObserverState(tuple(estimates), tuple(memory)) for estimates, memory in updates)


def update_controllers(
    bench: Bench, xp: Namespace, before: Sequence[ControllerState], readings: Numbers, inputs: Inputs
) -> tuple[ControllerState, ...]:
    """Return all controllers after a period."""
    memories = [state.memory for state in before]
    return answer_all(bench, xp, memories, readings | look_ahead(bench, inputs), inputs)


def look_ahead(bench: Bench, inputs: Inputs) -> Numbers:
    """Return the references now and ahead, if a controller reads them."""
    rows = zip(list_previews(bench), inputs.previews, strict=True)
    references = {f"{AHEAD}{one.drive}.{one.number}": value for one, value in rows}
    if references:
        rows = zip(bench.controllers.members(), inputs.references, strict=True)
        references |= {f"{AHEAD}{drive}.0": value for drive, value in rows}
    return references


def answer_all(
    bench: Bench, xp: Namespace, memories: Sequence[Sequence[Scalar]] | None, readings: Numbers, inputs: Inputs
) -> tuple[ControllerState, ...]:
    """Return all controllers after a sample, leaders first; the first sample has no memories."""
    members, planned = bench.controllers.members(), Numbers()
    befores = [None] * len(members) if memories is None else memories
    rows = zip(members.items(), befores, inputs.references, inputs.hands, strict=True)
    states: dict[str, ControllerState] = {}
    for (drive, one), before, reference, hand in sorted(rows, key=lambda row: not row[0][1].led_drives()):
        own = readings | ({PLANNED: planned[drive]} if drive in planned else {})
        commanded = find_commands(bench, drive)
        rest = one.begin(xp, reference, own, hand) if before is None or commanded else (0.0, ())
        signal, after = rest if before is None else one.proceed(xp, before, reference, own, bench.period, hand)
        answer = ControllerState(signal, tuple(after))
        if commanded:
            answer = obey_commands(bench, xp, drive, answer, tuple(rest[1]), readings)
        planned |= one.share_signals(split_memory(one, answer.memory).inner)
        states[drive] = answer
    return tuple(states[drive] for drive in members)


def find_commands(bench: Bench, drive: str) -> list[tuple[str, str]]:
    """Return the names of the estimates (active, signal) by which observers command a drive."""
    rows = [(one.commands(), [own.name for own in one.model.drives()]) for one in bench.observers.members().values()]
    return [names for names, drives in rows if names is not None and drive in drives]


def obey_commands(
    bench: Bench, xp: Namespace, drive: str, answer: ControllerState, rest: tuple[Scalar, ...], readings: Numbers
) -> ControllerState:
    """Return the answer of a controller, or the command of an observer with the initial memory of the controller."""
    for names in find_commands(bench, drive):
        lasts, signal = (readings[ESTIMATED + name] for name in names)
        memory = tuple(xp.where(lasts > 0.5, x, y) for x, y in zip(rest, answer.memory, strict=True))
        answer = ControllerState(xp.where(lasts > 0.5, signal, answer.wanted), memory)
    return answer


def collect_readings(bench: Bench, sensors: Sequence[SensorState], truth: Signals) -> Numbers:
    """Return the readings and their ages, or without sensors the true outputs."""
    readings: Numbers = {}
    for name, state in zip(bench.sensors.members(), sensors, strict=True):
        readings |= {name: state.reading, name + AGE: state.age}
    return readings or {**truth, **dict.fromkeys((name + AGE for name in truth), 0.0)}


def collect_estimates(bench: Bench, observers: Sequence[ObserverState]) -> Numbers:
    """Return the estimates by name."""
    rows = zip(bench.observers.members().values(), observers, strict=True)
    return {
        ESTIMATED + name: value
        for one, state in rows
        for name, value in zip(one.estimates(), state.estimates, strict=True)
    }


def collect_controller_outputs(bench: Bench, xp: Namespace, controllers: Sequence[ControllerState]) -> Numbers:
    """Return the outputs of controllers by name."""
    rows = zip(bench.controllers.members().values(), controllers, strict=True)
    values = [value for one, state in rows for value in one.observe(xp, split_memory(one, state.memory).inner)]
    return dict(zip(list_controller_outputs(bench), values, strict=True))
