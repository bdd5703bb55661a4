"""Every kernel of every kind of registered class, and ways to run one on every runtime.

A new class of a known kind is covered as it is; a new method with a namespace argument must be
called by one of the kernels below (a test in `meta` checks that).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from copy import copy
from dataclasses import dataclass
from functools import cache
from typing import Any

import builders
import numpy as np
import pytest
from elastic import REST, Elastic

from martensite.actuators.elements.base import Heating, Spring
from martensite.actuators.elements.lumped import AbstractLumped
from martensite.actuators.mechanics.motion import Motion, MotionHistory
from martensite.actuators.mechanisms.base import AbstractMechanism, Load
from martensite.actuators.mechanisms.load_line import AbstractLoadLine, LoadLineReference
from martensite.actuators.mechanisms.multibody import AbstractMultibody
from martensite.base.errors import ParameterError
from martensite.kernels import floats
from martensite.kernels.arrays import ArrayNamespace
from martensite.kernels.c99 import c_source
from martensite.kernels.c99_lanes import lanes_source
from martensite.kernels.compiler import call_compiled, load_library
from martensite.kernels.nested import flatten_numbers
from martensite.kernels.program import Program
from martensite.physics.electrical.base import AbstractSwitch, Conductor
from martensite.physics.electrical.sources import CurrentSource, PrescribedTemperature
from martensite.physics.electrical.switches import PwmVoltage
from martensite.physics.kinetics.exchange import AbstractExchange
from martensite.physics.kinetics.strips import AbstractStripLaw
from martensite.physics.laws.base import Fractions
from martensite.physics.laws.mas import MullerAchenbachSeelecke
from martensite.physics.laws.strip_laws import LiangRogers
from martensite.physics.thermal.base import Cylinder
from martensite.signals.moments import Moments
from martensite.testing.readings import find_range

LANES = 256


@dataclass(frozen=True)
class Kernel:
    """One kernel: ranges of its inputs, and a function (component, xp, *inputs) -> numbers."""

    ranges: Mapping[str, tuple[float, float]]
    function: Callable[..., Any]
    lanes: int = LANES

    def inputs(self) -> np.ndarray:
        """Random inputs (inputs, lanes); in every eighth lane all of them at an end of range."""
        rng = np.random.default_rng(len(self.ranges))
        low, high = (np.array([r[i] for r in self.ranges.values()])[:, None] for i in (0, 1))
        share = rng.random((len(self.ranges), self.lanes))
        share[:, ::8] = share[:, ::8].round()
        return low + share * (high - low)


# ---------------------------------------------------------------- kernels by kind


def law_path(law: Any, xp: Any, x: Any, s0: Any, t0: Any, s1: Any, t1: Any, s2: Any, t2: Any, dt: Any) -> Any:
    """Two legs; fractions and strain at their ends, memory at the end."""
    start = law.init(xp, Fractions(x, x), s0, t0)
    between, first = law.kinetics(xp, start, s1, t1, dt)
    end, second = law.kinetics(xp, between, s2, t2, dt)
    strains = law.strain(xp, first, s1, t1), law.strain(xp, second, s2, t2)
    return law.fractions(start), first, second, strains, end.stress, end.temperature


def law_step(law: Any, xp: Any, x: Any, s0: Any, t0: Any, s1: Any, t1: Any, dt: Any) -> Any:
    """The parts that a solver calls one by one."""
    start = law.init(xp, Fractions(x, x), s0, t0)
    move = law.select(xp, start, s1, t1)
    end = law.follow(xp, move, s1, t1, dt)
    after = law.commit(xp, start, move, end, s1, t1, dt)
    frozen = Fractions(x, x)
    spring = law.free_strain(xp, frozen, t1), law.compliance(xp, frozen)
    drive = law.drive(xp, move, s1, t1, dt)
    put = law.relocate(xp, after, Fractions(1.0 - x, 1.0 - x), s0, t0)
    others = law.heat(xp, 1e8, s1, t1), law.crossing(xp, start, move, s1, t1)
    others += (*law.kinks(xp, after), law.trained_share(xp, s1))
    others += tuple(x for one in law.forks(xp, after) for x in (*one[:4], xp.minimum(one.bound, 1.0)))
    if isinstance(law, AbstractStripLaw) and law.one_way:
        lasts = law.continue_process(xp, start, move)
        others += (lasts.direction, *law.follow(xp, lasts, s1, t1, dt))
    elif not isinstance(law, AbstractStripLaw):
        with pytest.raises(NotImplementedError):
            law.continue_process(xp, start, move)
    return end, law.fractions(after), spring, others, drive, law.fractions(put)


def law_extras(law: Any, xp: Any, strain: Any, stress: Any, temperature: Any) -> Any:
    """The start and the heat of every law, and what only some laws have, for people to look at."""
    start = law.warm_up(xp, Fractions(1.0, 1.0), 5e7, temperature)
    found = (law.heat(xp, 1e8, stress, temperature), *(1.0 + x for x in law.fractions(start)))
    if hasattr(law, "free_energy"):
        found += (law.free_energy(xp, strain, temperature), law.depth(xp, temperature))
    if hasattr(law, "jump_rates"):
        found += (law.jump_rates(xp, stress, temperature),)
    if isinstance(law, AbstractExchange):
        found += (law.jumps(xp, stress, temperature)(law.quantiles()[0]),)
    return found


def fluid_answers(fluid: Any, xp: Any, temperature: Any) -> Any:
    found = fluid.properties(xp, temperature)
    return (*found, found.diffusivity)


def element_answers(element: Any, xp: Any, x: Any, force: Any, temperature: Any, e: Any) -> Any:
    """What an element answers at a glance; more of one that is the same all over."""
    environment = builders.example_environment()
    found = element.heat_loss(xp, temperature, environment), element.heat_capacity_total()
    if not isinstance(element, AbstractLumped):
        return found
    fractions = Fractions(x, x)
    return (
        *found,
        element.spring(xp, fractions, temperature, force),
        element.stress(xp, force),
        element.strain(xp, e),
        element.ohms(xp, x, 0.02 * x, temperature),
        element.latent_heat_total(xp, force, temperature),
        element.elastic_energy_at(xp, fractions, temperature, force),
    )


def with_law(element: Any, law: type[Any]) -> Any:
    """A copy with an example of a law; it may have traced numbers, which a constructor would refuse."""
    found = copy(element)
    (name,) = {"law", "strand", "link"} & set(element.declarations)
    inner = builders.example(law) if name == "law" else with_law(getattr(found, name), law)
    object.__setattr__(found, name, inner)
    return found


def element_step(element: Any, xp: Any, force: Any, temperature: Any, amperes: Any, dt: Any) -> Any:
    """A step against a spring, and what is seen after it."""
    environment = builders.example_environment()
    state = element.init(xp, force, temperature)
    start = element.elongation(xp, state, force)

    def pull(xp: Any, spring: Spring) -> Any:
        meets = force + 300.0 * (start - spring.free)
        return xp.maximum(meets / (1.0 + 300.0 * spring.compliance), 0.0)

    heating = Heating(environment, CurrentSource(), amperes)
    after, report = element.advance(xp, state, heating, pull, dt)
    now = element.force(after)
    held = element.heat_content(xp, after)
    seen = (
        element.tangent(xp, after, now),
        element.condition(xp, after, now, environment),
        tuple(element.points(xp, after)),
        0.0 if held is None else held,
        element.stored_heat(xp, after),
        element.elastic_energy(xp, after),
    )
    there = Fractions(0.5, 0.5), temperature, force
    if not (isinstance(element, AbstractLumped) and element.uniform):
        with pytest.raises(ParameterError, match="not the same all over"):
            element.in_state(xp, after, *there)
        if not isinstance(element, AbstractLumped):
            with pytest.raises(NotImplementedError):
                element.advance_rosenbrock(xp, state, heating, pull, dt)
            with pytest.raises(NotImplementedError):
                element.advance_on_surface(xp, state, [heating, heating], pull, dt)
            with pytest.raises(NotImplementedError):
                element.find_events(xp, state, temperature, force)
        return after, report.crossing, seen
    put = element.in_state(xp, after, *there)
    layers = with_law(element, MullerAchenbachSeelecke)
    state = layers.init(xp, force, temperature)
    ends = layers.advance_rosenbrock(xp, state, heating, pull, dt + 1e-3)
    cosine = with_law(element, LiangRogers)
    state = cosine.init(xp, force, temperature)
    drive = Moments(amperes, amperes * amperes, amperes, amperes, 0.0, 0.0, 0.0)
    halves = [Heating(environment, CurrentSource(), drive)] * 2
    step = cosine.advance_on_surface(xp, state, halves, pull, 1e-3 * (dt + 1e-3))
    events = cosine.find_events(xp, step.begin, step.path.end[0], step.path.end[1])
    ends = *ends, step.end, step.middle, step.coarse
    return after, report.crossing, seen, put.force, tuple(end.force for end in ends), step.decay, tuple(events[:4])


def mechanism_answers(
    mechanism: AbstractMechanism, xp: Any, start: Any, free: Any, compliance: Any, x: Any, y: Any, z: Any
) -> Any:
    """All that a mechanism says by itself."""
    if isinstance(mechanism, AbstractMultibody):
        return multibody_answers(mechanism, xp, x, y, z)
    if not isinstance(mechanism, AbstractLoadLine):  # told by a signal: see its steps
        return tuple(mechanism.start_forces(xp))
    assembly = LoadLineReference(start)
    force = mechanism.force(xp, assembly, Spring(free, compliance))
    position = mechanism.position(xp, assembly, force, free + compliance * force)
    return mechanism.start_force(xp), force, position


def multibody_answers(mechanism: AbstractMultibody, xp: Any, x: Any, y: Any, z: Any) -> Any:
    """A mechanism somewhere near home, in motion and under some tensions."""
    coordinates, home = mechanism.coordinates(), mechanism.home(xp)
    many = list(enumerate(zip(coordinates, home, strict=True)))
    motion = Motion(
        tuple(q + 0.3 * c.size * xp.sin(3.0 * x + k) for k, (c, q) in many),
        tuple(c.size * xp.sin(5.0 * y + 2.0 * k) for k, (c, _) in many),
        tuple(10.0 * c.size * xp.sin(7.0 * z + 3.0 * k) for k, (c, _) in many),
    )
    ports, signals = range(len(mechanism.ports())), [x for _ in mechanism.signals()]
    forces = [3.0 + xp.sin(x + y + k) for k in ports]
    supply = mechanism.supply(xp, motion.position, forces, motion.velocity)
    own: Any = mechanism
    course = MotionHistory(*motion, motion.acceleration if mechanism.moves else ())
    found = (
        mechanism.contraction(xp, motion.position),
        mechanism.demand(xp, motion, signals),
        mechanism.transmission(xp, motion),
        supply,
        mechanism.start_forces(xp),
        home,
        mechanism.assembled_elongations(xp, [1e-3 * (x + k) for k in ports]),
        mechanism.release(xp, motion, supply, signals),
        mechanism.scheme(xp, course, 0.01 + 0.001 * y)(motion.velocity),
        tuple(own.energy(xp, motion) or ()),
    )
    return tuple(tuple(part) if isinstance(part, list) else part for part in found)


def mechanism_steps(mechanism: AbstractMechanism, xp: Any, x: Any, y: Any, dt: Any) -> Any:
    """Assembly, two steps with elastic elements that get shorter, and what is seen then."""
    signals = [y for _ in mechanism.signals()]
    forces = mechanism.first_forces(xp, signals)
    elements = [Elastic(compliance=2e-3 * (k + 1)) for k in range(len(forces))]
    states = [e.init(xp, force, REST) for e, force in zip(elements, forces, strict=True)]
    rows = zip(elements, states, forces, strict=True)
    elongations = [e.elongation(xp, state, force) for e, state, force in rows]
    memory, source = mechanism.init(xp, elements, elongations, signals), PrescribedTemperature()
    crossings: list[Any] = []
    for share in (0.5, 1.0):
        heated = [
            Heating(builders.example_environment(), source, REST + share * x * ((k + 1) % 2))
            for k in range(len(elements))
        ]
        loads = [Load(*row) for row in zip(elements, states, heated, strict=True)]
        memory, states, report = mechanism.advance(xp, memory, loads, signals, dt)
        crossings.append(report.crossing)
    loads = [Load(*row) for row in zip(elements, states, heated, strict=True)]
    tensions, seen = mechanism.observe(xp, memory, loads, signals)
    mechanics = mechanism.mechanics(xp, memory, loads, signals)
    if isinstance(mechanism, AbstractMultibody):  # a slope over almost nothing is rough
        memory = memory._replace(stiffness=())
    return memory, tuple(states), tuple(tensions), tuple(seen), tuple(crossings), mechanics


def source_current(source: Any, xp: Any, drive: Any, ohms: Any) -> Any:
    """Return the current, the power and, for a switch, its duty cycle."""
    shares = [source.share(xp, drive, 100.0)] if isinstance(source, AbstractSwitch) else []
    answers = (ask(xp, drive, ohms) for ask in (source.current, source.power, source.supply_current))
    return *answers, *shares


def source_heat(source: Any, xp: Any, low: Any, high: Any, share: Any, ohms: Any) -> Any:
    """The power of a drive that rises from one signal to another, slow at first."""
    mean, least = low + share * (high - low), xp.minimum(low, high)
    square = mean * mean + share * (1.0 - share) * (high - low) * (high - low) / 3.0
    change = Moments(mean, square, least, xp.maximum(low, high), 0.0, high - low, high * high)
    return source.heat(xp, change, ohms)


def sensor_readings(sensor: Any, xp: Any, x: Any, y: Any, noise: Any, dt: Any) -> Any:
    """Two readings after rest, whether there is anything to measure, and what is remembered."""
    first, second = (
        [low + share * (high - low) for share, (low, high) in zip(shares, ranges, strict=False)]
        for ranges in [[find_range(name) for name in sensor.sees]]
        for shares in ((x, y), (y, x))
    )
    state = sensor.rest(xp, first)
    one, state = sensor.reading(xp, state, second, noise, dt)
    two, state = sensor.reading(xp, state, first, -noise, dt)
    there = xp.where(sensor.valid(xp, first), 1.0, 0.0)
    return one, two, there + 0.0 * x, *state


def observer_course(observer: Any, xp: Any, u: Any, share: Any, age: Any, dt: Any) -> Any:
    """Estimates at rest and a sample later, with readings that are new or old, and the memory."""
    model, signals = observer.model, {drive.name: u for drive in observer.model.drives()}
    seen = dict(zip(model.outputs(), model.observe(xp, model.init(xp, u), u), strict=True))
    said = {name: share * seen[name] for name in observer.reads()}
    said |= {f"{name}.age": xp.maximum(age, 0.0) for name in observer.reads()}
    first, memory = observer.rest(xp, said, signals)
    guess, memory = observer.update(xp, memory, said, signals, dt, 1)
    return *first, *guess, *memory


def fault_effects(fault: Any, xp: Any, time: Any, u: Any, reading: Any, held: Any) -> Any:
    """What a fault makes of a plant, a signal, a reading and whether there is one."""
    active, name = fault.active(xp, time), "temperature"
    plant = fault.plant(xp, builders.problem_a(source=PwmVoltage(supply=6.0)), active)
    loss = plant.element.heat_loss(xp, 350.0, plant.environment)
    grown = fault.fault_at(xp, time)
    fresh = fault.fresh(xp, name, reading > held, active)
    memory = plant.mechanism.init(xp, [plant.element], [1e-3 * reading], [])
    return (
        plant.source.current(xp, u, 2.0),
        loss,
        plant.mechanism.position(xp, memory, u, 1e-3 * held),
        fault.signal(xp, "drive", u, active),
        grown.disturb(xp, name, grown.reading(xp, name, reading, held, active), 1.5, active),
        fault.travel(xp, name, 0.1, active),
        xp.where(fresh, 1.0, 0.0),
    )


KNOWN = {
    "temperature": (300.0, 380.0),
    "hottest": (300.0, 380.0),
    "temperature.age": (0.0, 0.6),
    "current": (0.0, 0.6),
    "current.age": (0.0, 0.6),
}
"""Ranges of what checks read."""


def check_course(check: Any, xp: Any, u: Any, v: Any, x: Any, y: Any, dt: Any) -> Any:
    """Two samples of a check after rest, and what it remembers."""
    found: list[Any] = []
    memory = check.rest(xp, known(x))
    for wanted, share in (({"drive": u}, x), ({"drive": v}, y)):
        looked = check.look(xp, memory, wanted, known(share), dt)
        found += [xp.where(looked.trips, 1.0, 0.0), xp.where(looked.clears, 1.0, 0.0)]
        found += [*check.find_most(xp, looked.memory, dt).values()]
        memory = check.remember_allowed(xp, looked.memory, wanted, dt)
    return *found, *memory, check.on(xp, {"drive": u}, 0.5)


def known(share: Any) -> dict[str, Any]:
    """Readings somewhere in their ranges."""
    return {name: low + share * (high - low) for name, (low, high) in KNOWN.items()}


def supervisor_course(supervisor: Any, xp: Any, u: Any, v: Any, x: Any, y: Any, dt: Any) -> Any:
    """Two verdicts of a supervisor after rest, and what it remembers."""
    memory, found = supervisor.rest(xp, known(x)), []
    for wanted, share in ((u, x), (v, y)):
        verdict = supervisor.judge(xp, memory, {"drive": wanted}, known(share), dt)
        memory = verdict.memory
        found += [verdict.signals["drive"], verdict.alarm]
    return *found, *memory


FRACTION, STRESS, TEMPERATURE = (0.0, 1.0), (0.0, 400e6), (275.0, 400.0)
POINTS = {f"{name}{i}": r for i in range(3) for name, r in (("s", STRESS), ("t", TEMPERATURE))}


def driven_cooling(cooling, xp, u, v, T, ambient):
    """Losses at rest, at a level of the signal, and over a step in which it changes."""
    shape, brought = Cylinder(2e-4, 0.2), Moments(u, u * u + 0.3 * v * v, u - v, u + v)
    models = [cooling, *(cooling.with_signals(xp, dict.fromkeys(cooling.signals(), given)) for given in (u, brought))]
    rows = [(one.film(xp, T, ambient, shape), one.pump_heat(xp, T, ambient, shape)) for one in models]
    return tuple(number for row in rows for number in row if number is not None)


START = {"x": FRACTION, "s0": STRESS, "t0": TEMPERATURE}
SAMPLES = {"u": (-1.0, 1.0), "v": (-1.0, 1.0), "x": FRACTION, "y": FRACTION, "dt": (0.0, 0.5)}

KERNELS: dict[str, dict[str, Kernel]] = {
    "law": {
        "path": Kernel({"x": FRACTION, **POINTS, "dt": (0.0, 1.0)}, law_path),
        "extras": Kernel({"e": (-0.08, 0.08), "s": (-400e6, 400e6), "t": TEMPERATURE}, law_extras),
        "step": Kernel({**START, "s1": STRESS, "t1": TEMPERATURE, "dt": (0.0, 1.0)}, law_step),
    },
    "cooling": {
        "film": Kernel(
            {"T": (250.0, 450.0), "ambient": (270.0, 310.0), "d": (5e-5, 1e-3), "l": (0.05, 1.0)},
            lambda cooling, xp, T, ambient, d, l: cooling.film(xp, T, ambient, Cylinder(d, l)),
        ),
        "driven": Kernel(
            {"u": (0.0, 3.0), "v": (0.0, 0.3), "T": (250.0, 450.0), "ambient": (270.0, 310.0)}, driven_cooling
        ),
    },
    "ends": {
        "conductance": Kernel(
            {"h": (0.0, 1e3), "d": (5e-5, 1e-3), "l": (1e-3, 1.0)},
            lambda ends, xp, h, d, l: ends.conductance(xp, h, Cylinder(d, l)),
        )
    },
    "fluid": {"properties": Kernel({"T": (200.0, 500.0)}, fluid_answers)},
    "resistance": {
        "resistance": Kernel(
            {"x": FRACTION, "strain": (-0.01, 0.08), "T": TEMPERATURE, "area": (1e-9, 1e-6), "length": (0.05, 1.0)},
            lambda resistance, xp, x, strain, T, area, length: (
                resistance.resistance(xp, x, strain, T, Conductor(area, length)),
                resistance.mix_phases(xp, x, 0.7 * (1.0 - x), strain, T, Conductor(area, length)),
            ),
        )
    },
    "drive": {
        "current": Kernel({"u": (-10.0, 10.0), "R": (0.5, 50.0)}, source_current),
        "heat": Kernel(
            {"low": (-10.0, 10.0), "high": (-10.0, 10.0), "share": (0.1, 0.9), "R": (0.5, 50.0)}, source_heat
        ),
    },
    "sensor": {
        "readings": Kernel({"x": FRACTION, "y": FRACTION, "noise": (-3.0, 3.0), "dt": (0.0, 0.5)}, sensor_readings)
    },
    "observer": {
        "course": Kernel(
            {"u": (0.0, 3.0), "share": (0.9, 1.1), "age": (-1.0, 1.0), "dt": (1e-3, 0.02)},
            observer_course,
            lanes=16,  # slow where it is not traced
        )
    },
    "fault": {
        "effects": Kernel(
            {"time": (0.0, 2.0), "u": FRACTION, "reading": (0.0, 9.0), "held": (0.0, 9.0)}, fault_effects, lanes=64
        )
    },
    "check": {"course": Kernel(SAMPLES, check_course)},
    "supervisor": {"course": Kernel(SAMPLES, supervisor_course)},
    "element": {
        "answers": Kernel({"x": FRACTION, "F": (0.0, 20.0), "T": TEMPERATURE, "e": (0.0, 0.02)}, element_answers),
        "step": Kernel(
            {"F": (1.0, 6.0), "T": (280.0, 360.0), "I": (0.0, 1.0), "dt": (0.0, 0.05)},
            element_step,
            lanes=32,  # slow where it is not traced
        ),
    },
    "mechanism": {
        "answers": Kernel(
            {
                "start": (0.0, 0.02),
                "free": (-0.01, 0.03),
                "compliance": (1e-6, 1e-3),
                "x": (-1.0, 1.0),
                "y": (-1.0, 1.0),
                "z": (-1.0, 1.0),
            },
            mechanism_answers,
            lanes=64,
        ),
        "steps": Kernel({"x": (0.0, 1.0), "y": (-1.0, 1.0), "dt": (1e-3, 0.02)}, mechanism_steps, lanes=16),
    },
}


# ---------------------------------------------------------------- the runtimes


def flat_numbers(nested: Any) -> list[Any]:
    """All numbers of nested tuples."""
    return flatten_numbers(nested if isinstance(nested, tuple) else (nested,))


def kept(function: Callable[..., Any]) -> Callable[..., Any]:
    """Its last answer again for the same component and kernel: runtimes are tried in turn."""
    last: list[Any] = [None, None, None, None]

    def answer(thing: Any, kernel: Kernel, *inputs: np.ndarray) -> Any:
        same = last[0] is thing and last[1] is kernel
        if not (same and all(map(np.array_equal, last[2], inputs))):
            last[:] = thing, kernel, inputs, function(thing, kernel, *inputs)
        return last[3]

    return answer


@kept
def traced(thing: Any, kernel: Kernel) -> Program:
    """The kernel as a program over the parameters of the component."""
    program = Program()
    twin = thing.rebuilt({leaf.path: program.parameter(leaf.path) for leaf in thing.leaves()})

    def flat(xp: Any, *inputs: Any) -> list[Any]:
        return flat_numbers(kernel.function(twin, xp, *inputs))

    program.add("kernel", list(kernel.ranges), flat)
    return program


def values(thing: Any) -> list[float]:
    return [leaf.value for leaf in thing.leaves()]


@kept
def on_kernel_itself(thing: Any, kernel: Kernel, inputs: np.ndarray) -> np.ndarray:
    """Untraced, on plain floats: the meaning."""
    rows = [flat_numbers(kernel.function(thing, floats, *lane)) for lane in inputs.T.tolist()]
    return np.array(rows, float).T


def on_floats(thing: Any, kernel: Kernel, inputs: np.ndarray) -> np.ndarray:
    function = traced(thing, kernel).bind_floats(*values(thing))["kernel"]
    return np.array([function(*lane) for lane in inputs.T.tolist()]).T


def on_numpy(thing: Any, kernel: Kernel, inputs: np.ndarray) -> np.ndarray:
    """The kernel itself, untraced, on arrays."""
    numbers = flat_numbers(kernel.function(thing, ArrayNamespace(np), *inputs))
    return np.array([np.broadcast_to(n, inputs.shape[1]) for n in numbers], float)


_ENTRY = """
void run(const double *p, const double *x, double *y) {{
    static double c[{constants} * {lanes}];
    k_prepare({lanes}, p, c);
    k_kernel({lanes}, c, x, y);
}}
"""


def on_c(thing: Any, kernel: Kernel, inputs: np.ndarray, write: Callable[..., str] = c_source) -> np.ndarray:
    program = traced(thing, kernel)
    lanes = inputs.shape[1]
    entry = _ENTRY.format(constants=program.constants, lanes=lanes)
    library = load_library(write(program, program.functions.values()) + entry)
    parameters = np.array([[v] * lanes for v in values(thing)] or [[0.0] * lanes])
    outputs = np.empty((len(program.functions["kernel"].outputs), lanes))
    arrays = (parameters, np.ascontiguousarray(inputs), outputs)
    call_compiled(library.run, *arrays)
    return outputs


def on_lanes(thing: Any, kernel: Kernel, inputs: np.ndarray) -> np.ndarray:
    return on_c(thing, kernel, inputs, lanes_source)


RUNTIMES = {"traced floats": on_floats, "numpy": on_numpy, "c": on_c}


def disagreement(a: np.ndarray, b: np.ndarray) -> float:
    """Largest difference as a share of the size of each output."""
    size = np.maximum(np.abs(a).max(axis=1), 1e-300)
    return float((np.abs(a - b).max(axis=1) / size).max())


def apart(thing: Any, kernel: Kernel, runtime: str) -> float:
    """Disagreement of a kernel on a runtime with the kernel itself, which gives numbers."""
    inputs = kernel.inputs()
    meant = on_kernel_itself(thing, kernel, inputs)
    assert np.isfinite(meant).all()
    return disagreement(meant, RUNTIMES[runtime](thing, kernel, inputs))


@cache
def xp_methods(cls: type) -> frozenset[str]:
    """Methods of a class whose first argument is the namespace."""
    found = set()
    for name in dir(cls):
        code = getattr(getattr(cls, name, None), "__code__", None)
        if code is not None and code.co_varnames[1:2] == ("xp",):
            found.add(name)
    return frozenset(found)
