"""The parts of a period on a bench: kernels that `Bench` puts in order."""

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
    Controlling,
    Disturbed,
    Inputs,
    Numbers,
    ObserverState,
    Sensed,
    SupervisorVerdict,
)
from martensite.control.observers.base import ESTIMATED
from martensite.kernels.namespace import Namespace, Scalar
from martensite.physics.electrical.base import AbstractSwitch

if TYPE_CHECKING:
    from martensite.control.loop.bench import Bench

Signals = Mapping[str, Scalar]
SLIGHT = 1e-9
"""Least share of a period, so that no step has length 0."""


def sorted_inputs(bench: Bench, drives: Sequence[Scalar]) -> Inputs:
    """Return the inputs of the bench, by destination."""
    taken, rest = bench.controllers.members(), iter(drives)
    references = tuple(next(rest) for _ in taken)
    previews = tuple(next(rest) for _ in list_previews(bench))
    hands = sort_hands(bench, rest)
    free = {d.name: next(rest) for d in bench.plant.drives() if d.name not in taken}
    numbers = tuple((next(rest), next(rest)) for _ in bench.sensors.members())
    return Inputs(references, previews, hands, free, numbers)


def sort_hands(bench: Bench, rest: Iterator[Scalar]) -> tuple[ManualInput | None, ...]:
    """Return the manual inputs by controller, from the next drives."""
    members = bench.controllers.members().values()
    return tuple(None if one.manual is None else ManualInput(next(rest), next(rest)) for one in members)


def apply_supervisor(bench: Bench, xp: Namespace, state: BenchState, given: Inputs) -> SupervisorVerdict:
    """Return the signals by drive of the plant, as the supervisor lets them pass."""
    ordered, known = collect_wanted(bench, state.controllers, given), Numbers()
    if bench.supervisor is not None:
        if not state.sensors:
            known = collect_truth(bench, xp, apply_faults(bench, xp, state.time), state.plant, ordered)
        known = collect_readings(bench, state.sensors, known) | collect_estimates(bench, state.observers)
    return judge_signals(bench, xp, state.supervisor, ordered, known)


def collect_wanted(bench: Bench, controllers: Sequence[Controlling], given: Inputs) -> Numbers:
    """Return the signals of controllers and those that no controller has, in the order of the drives."""
    taken = zip(bench.controllers.members(), controllers, strict=True)
    found = given.free | {name: held.wanted for name, held in taken}
    return {drive.name: found[drive.name] for drive in bench.plant.drives()}


def collect_idle(bench: Bench, given: Inputs) -> Numbers:
    """Return the signals before the first control action, in the order of the drives."""
    return {drive.name: given.free.get(drive.name, 0.0) for drive in bench.plant.drives()}


def judge_signals(
    bench: Bench, xp: Namespace, memory: Sequence[Scalar], signals: Numbers, known: Numbers
) -> SupervisorVerdict:
    """Return the verdict of the supervisor on signals; without a supervisor the signals pass."""
    if bench.supervisor is None:
        return SupervisorVerdict(signals, 0.0, ())
    return bench.supervisor.judge(xp, memory, signals, known, bench.period)


def begin_loop(
    bench: Bench, xp: Namespace, known: Numbers, given: Inputs
) -> tuple[tuple[ObserverState, ...], tuple[Controlling, ...], tuple[Scalar, ...], Numbers]:
    """Return the observers, controllers and supervisor in the first sample, and all that is read there."""
    first = [one.rest(xp, known, collect_idle(bench, given)) for one in bench.observers.members().values()]
    observers = tuple(ObserverState(tuple(guess), tuple(memory)) for guess, memory in first)
    known = known | collect_estimates(bench, observers)
    controllers = answer_all(bench, xp, None, known | look_ahead(bench, given), given)
    held = () if bench.supervisor is None else tuple(bench.supervisor.rest(xp, known))
    return observers, controllers, held, known


def collect_shaped(bench: Bench, controllers: Sequence[Controlling]) -> list[Scalar]:
    """Return the shaped references that controllers follow."""
    rows = zip(bench.controllers.members().values(), controllers, strict=True)
    found = [split_memory(one, held.memory).shaped for one, held in rows]
    return [shaped.value for shaped in found if shaped is not None]


def apply_faults(bench: Bench, xp: Namespace, time: Scalar) -> AbstractSystem:
    """Return the plant as it is at a time [s]."""
    plant = bench.plant
    for fault in bench.faults.members().values():
        plant = fault.plant(xp, plant, fault.active(xp, time))
    return plant


def deliver_signals(bench: Bench, xp: Namespace, time: Scalar, signals: Signals) -> Numbers:
    """Return the signals as they arrive at the sources."""
    found = dict(signals)
    for fault in bench.faults.members().values():
        active = fault.active(xp, time)
        found = {name: fault.signal(xp, name, u, active) for name, u in found.items()}
    return found


def split_period(bench: Bench, xp: Namespace, signals: Signals) -> list[Piece]:
    """Return the signals and lengths of what is repeated in a period."""
    length = bench.period / bench.turns
    if bench.switching == "averaged":
        return [(list(signals.values()), length)]
    ((duty, share),) = _switch_signals(bench, xp, signals)
    on, off = (close_switch(xp, duty, share), xp.where(share < 1.0, 0.0, close_switch(xp, duty, share)))
    share = xp.clip(share, SLIGHT, 1.0 - SLIGHT)
    return [([on], share * length), ([off], (1.0 - share) * length)]


def _switch_signals(bench: Bench, xp: Namespace, signals: Signals) -> list[tuple[Scalar, Scalar]]:
    """Return the signal of every switch, and the share of the time for which it is closed."""
    sources = [one.source for one in bench.plant.actuators().values()]
    frequency = bench.turns / bench.period
    rows = zip(sources, signals.values(), strict=True)
    return [(u, one.share(xp, u, frequency)) for one, u in rows if isinstance(one, AbstractSwitch)]


def close_switch(xp: Namespace, duty: Scalar, share: Scalar) -> Scalar:
    """Return the signal of a switch in its pulse: 1, or -1 for a negative duty; 0 if none comes."""
    return xp.where(share > 0.0, xp.where(duty < 0.0, -1.0, 1.0), 0.0)


def collect_truth(bench: Bench, xp: Namespace, plant: AbstractSystem, state: Any, signals: Signals) -> Numbers:
    """Return the outputs that sensors may measure; electrical outputs are those while the switch is closed."""
    applied = list(signals.values())
    if bench.switching == "pulses":
        applied = [close_switch(xp, u, share) for u, share in _switch_signals(bench, xp, signals)]
    found: Numbers = dict(zip(plant.outputs(), plant.observe(xp, state, *applied), strict=True))
    for port, one in plant.actuators().items():
        found[plant.label(port, AMBIENT)] = one.environment.temperature
    return found


def update_sensors(
    bench: Bench, xp: Namespace, before: Sequence[Sensed], known: Numbers, given: Inputs, time: Scalar
) -> tuple[Sensed, ...]:
    """Return all sensors a period later."""
    rows = zip(bench.sensors.members().items(), before, given.numbers, strict=True)
    every = bench.faults.members().values()
    faults = [(one.fault_at(xp, time), one.active(xp, time)) for one in every]
    return tuple(
        mounted.step(xp, held, known, numbers, bench.period, Disturbed(name, faults))
        for (name, mounted), held, numbers in rows
    )


def update_observers(
    bench: Bench, xp: Namespace, before: Sequence[ObserverState], known: Numbers, signals: Numbers
) -> tuple[ObserverState, ...]:
    """Return all observers a period later."""
    rows = zip(bench.observers.members().values(), before, strict=True)
    found = [one.update(xp, held.memory, known, signals, bench.period, bench.turns) for one, held in rows]
    return tuple(ObserverState(tuple(guess), tuple(memory)) for guess, memory in found)


def update_controllers(
    bench: Bench, xp: Namespace, before: Sequence[Controlling], known: Numbers, given: Inputs
) -> tuple[Controlling, ...]:
    """Return all controllers a period later."""
    memories = [held.memory for held in before]
    return answer_all(bench, xp, memories, known | look_ahead(bench, given), given)


def look_ahead(bench: Bench, given: Inputs) -> Numbers:
    """Return the references now and ahead, as controllers read them that want to know what lies ahead."""
    rows = zip(list_previews(bench), given.previews, strict=True)
    found = {f"{AHEAD}{one.drive}.{one.number}": value for one, value in rows}
    if found:
        rows = zip(bench.controllers.members(), given.references, strict=True)
        found |= {f"{AHEAD}{drive}.0": value for drive, value in rows}
    return found


def answer_all(
    bench: Bench, xp: Namespace, memories: Sequence[Sequence[Scalar]] | None, known: Numbers, given: Inputs
) -> tuple[Controlling, ...]:
    """Return all controllers in a sample, those that lead others first; without memories it is the first one."""
    members, planned = bench.controllers.members(), Numbers()
    befores = [None] * len(members) if memories is None else memories
    rows = zip(members.items(), befores, given.references, given.hands, strict=True)
    found: dict[str, Controlling] = {}
    for (drive, one), before, reference, hand in sorted(rows, key=lambda row: not row[0][1].led_drives()):
        own = known | ({PLANNED: planned[drive]} if drive in planned else {})
        commanded = find_commands(bench, drive)
        rest = one.begin(xp, reference, own, hand) if before is None or commanded else (0.0, ())
        signal, after = rest if before is None else one.proceed(xp, before, reference, own, bench.period, hand)
        answer = Controlling(signal, tuple(after))
        if commanded:
            answer = obey_commands(bench, xp, drive, answer, tuple(rest[1]), known)
        planned |= one.share_signals(split_memory(one, answer.memory).inner)
        found[drive] = answer
    return tuple(found[drive] for drive in members)


def find_commands(bench: Bench, drive: str) -> list[tuple[str, str]]:
    """Return the names of the estimates by which observers command a drive: whether they do, and the signal."""
    rows = [(one.commands(), [own.name for own in one.model.drives()]) for one in bench.observers.members().values()]
    return [names for names, drives in rows if names is not None and drive in drives]


def obey_commands(
    bench: Bench, xp: Namespace, drive: str, answer: Controlling, rest: tuple[Scalar, ...], known: Numbers
) -> Controlling:
    """Return the answer of a controller, or the command of an observer; then the controller keeps its initial state."""
    for names in find_commands(bench, drive):
        lasts, signal = (known[ESTIMATED + name] for name in names)
        kept = tuple(xp.where(lasts > 0.5, x, y) for x, y in zip(rest, answer.memory, strict=True))
        answer = Controlling(xp.where(lasts > 0.5, signal, answer.wanted), kept)
    return answer


def collect_readings(bench: Bench, sensors: Sequence[Sensed], known: Signals) -> Numbers:
    """Return the readings of controllers with their ages, or without sensors the true outputs."""
    found: Numbers = {}
    for name, held in zip(bench.sensors.members(), sensors, strict=True):
        found |= {name: held.reading, name + AGE: held.age}
    return found or {**known, **dict.fromkeys((name + AGE for name in known), 0.0)}


def collect_estimates(bench: Bench, observers: Sequence[ObserverState]) -> Numbers:
    """Return the estimates by name."""
    rows = zip(bench.observers.members().values(), observers, strict=True)
    return {
        ESTIMATED + name: value
        for one, held in rows
        for name, value in zip(one.estimates(), held.estimates, strict=True)
    }


def collect_controller_outputs(bench: Bench, xp: Namespace, controllers: Sequence[Controlling]) -> Numbers:
    """Return the outputs of the controllers, by name."""
    rows = zip(bench.controllers.members().values(), controllers, strict=True)
    values = [value for one, held in rows for value in one.observe(xp, split_memory(one, held.memory).inner)]
    return dict(zip(list_controller_outputs(bench), values, strict=True))
