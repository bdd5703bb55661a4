"""Systems and parts that the tests build: the benchmark wire, simple wires, examples of anything.

Problem A is a Liang–Rogers wire of 0.381 mm x 250 mm under a two-tone voltage against a bias
spring; its reference numbers were computed for this project by solvers that share no code with
the package (see benchmarks/problem_a.py).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from typing import Any

from martensite.actuators.assembly import AbstractSystem, Actuator, Group, Machine, System
from martensite.actuators.elements.base import ELEMENTS, AbstractElement
from martensite.actuators.elements.wire import Wire
from martensite.actuators.mechanisms.base import MECHANISMS, AbstractMechanism
from martensite.actuators.mechanisms.load_line import BiasSpring, DeadWeight
from martensite.base.parameters import Parametrised, part
from martensite.base.registry import Registry
from martensite.control.checks.base import CHECKS
from martensite.control.faults.base import FAULTS
from martensite.control.loop.parts import SUPERVISORS
from martensite.control.observers.base import OBSERVERS
from martensite.control.sensors.base import SENSORS
from martensite.physics.electrical.base import RESISTANCES, SOURCES, AbstractSource
from martensite.physics.electrical.resistances import PerLengthResistance
from martensite.physics.electrical.sources import PowerSource, PrescribedTemperature, VoltageSource
from martensite.physics.fluids.base import FLUIDS
from martensite.physics.laws.base import LAWS, AbstractLaw
from martensite.physics.laws.brinson import Brinson
from martensite.physics.laws.strip_laws import LiangRogers
from martensite.physics.materials.base import load_material
from martensite.physics.thermal.base import COOLING, AbstractCooling, Environment
from martensite.physics.thermal.ends import ENDS
from martensite.physics.thermal.films import ConstantCooling, PolynomialCooling
from martensite.signals.base import WAVEFORMS, AbstractWaveform
from martensite.signals.moments import Segment, Tone
from martensite.testing.examples import build_example, label_part, list_variants
from martensite.testing.laws import find_strain, follow_path, trace_kinetics

ZERO = 273.15
REGISTRIES: dict[str, Registry[Any]] = {
    registry.kind: registry
    for registry in (
        LAWS,
        COOLING,
        FLUIDS,
        ENDS,
        RESISTANCES,
        SOURCES,
        ELEMENTS,
        MECHANISMS,
        WAVEFORMS,
        SENSORS,
        OBSERVERS,
        FAULTS,
        CHECKS,
        SUPERVISORS,
    )
}

# ---------------------------------------------------------------- problem A

LAW_A: dict[str, Any] = {
    "E_A": 75e9,
    "E_M": 28e9,
    "eps_L": 0.04,
    "Theta": 0.055e6,
    "T_ref": 293.15,
    "A_s": 68 + ZERO,
    "A_f": 78 + ZERO,
    "M_s": 52 + ZERO,
    "M_f": 42 + ZERO,
    "C_A": 10e6,
    "C_M": 8e6,
}


PLAIN_LAW: dict[str, Any] = {
    "E_A": 75e9,
    "E_M": 28e9,
    "eps_L": 0.04,
    "C_A": 10e6,
    "C_M": 8e6,
    "A_s": 341.15,
    "A_f": 351.15,
    "M_s": 325.15,
    "M_f": 315.15,
}


class FunctionWaveform(AbstractWaveform):
    """A waveform from a plain function of time, with the times at which it jumps or bends."""

    function: Callable[[float], float] = part("signal as a function of time [s]")
    kinks: tuple[float, ...] = part("times of jumps and bends [s]", default=())

    def value(self, time: float) -> float:
        return self.function(time)

    def edges(self, duration: float) -> list[float]:
        return [t for t in self.kinks if 0.0 < t < duration]


class Swings(AbstractWaveform):
    """A level and what swings about it, known to the last digit at all times."""

    level: float = part("mean", default=0.0)
    swings: tuple[Tone, ...] = part("tones")

    def value(self, time: float) -> float:
        return self.level + sum(tone.value(time) for tone in self.swings)

    def segments(self, begin: float) -> Iterator[Segment]:
        yield Segment(0.0, self.level)

    def tones(self) -> tuple[Tone, ...]:
        return self.swings


def raised_cosine(high: float, period: float, rest: float = 0.0) -> Swings:
    """From `rest` up to `high` above it and back: half of one minus a cosine."""
    return Swings(level=rest + 0.5 * high, swings=(Tone(-0.5 * high, 2.0 * math.pi / period),))


def volts_a(t: float) -> float:
    """The two-tone drive of problem A [V]."""
    tau = 2.0 * math.pi * t
    return 2.8 * (0.66 - 0.34 * math.cos(0.1 * tau) - 0.2 * math.cos(0.023 * tau))


SINE_A = Swings(level=2.8 * 0.66, swings=(Tone(-2.8 * 0.34, 0.2 * math.pi), Tone(-2.8 * 0.2, 0.046 * math.pi)))


def law_a(history: str = "resume", modulus: str = "mixture", **changes: Any) -> LiangRogers:
    return LiangRogers(**(LAW_A | changes), history=history, modulus=modulus)


def wire_a(law: AbstractLaw | None = None, **changes: Any) -> Wire:
    numbers: dict[str, Any] = {
        "diameter": 0.381e-3,
        "length": 0.25,
        "density": 6450.0,
        "heat_capacity": 400.0,
        "latent_heat": 24e3,
    }
    resistance = PerLengthResistance(r_A=8.3, r_M=8.3 * 1.15)
    return Wire(law=law or law_a(), resistance=resistance, **(numbers | changes))


def problem_a(history: str = "resume", **changes: Any) -> System:
    """Problem A; keyword arguments replace whole parts of the system."""
    parts: dict[str, Any] = {
        "element": wire_a(law_a(history)),
        "environment": Environment(
            temperature=20 + ZERO, cooling=PolynomialCooling(h0=100, h1=0.15, reference=20 + ZERO)
        ),
        "source": VoltageSource(),
        "mechanism": BiasSpring(stiffness=1000, preload=5),
    }
    return System(**(parts | changes))


def plain_system(law: AbstractLaw | None = None, source: AbstractSource | None = None) -> System:
    """Another, simpler wire under 1 kg, without latent heat or thermal strain."""
    wire = Wire(
        diameter=0.4e-3,
        length=0.25,
        density=6450.0,
        heat_capacity=400.0,
        law=law or plain_law(),
        resistance=PerLengthResistance(r_A=8.0, r_M=9.0),
    )
    return System(
        element=wire,
        source=source or VoltageSource(),
        mechanism=DeadWeight(mass=1.0),
        environment=Environment(temperature=293.15, cooling=PolynomialCooling(h0=100.0)),
    )


def plain_law(cls: type[LiangRogers] = LiangRogers, **changed: Any) -> LiangRogers:
    """The law of `plain_system`."""
    return cls(**(PLAIN_LAW | changed))


class PrintedFormula(LiangRogers):
    """Wrong on purpose: the printed cosines with ξ₀ refreshed at every increment."""

    def select(self, xp: Any, memory: Any, stress: Any, temperature: Any) -> Any:
        move = super().select(xp, memory, stress, temperature)
        left = xp.where(move.direction > 0.0, 1.0 - memory.fraction, memory.fraction)
        return move._replace(scale=left)


# ---------------------------------------------------------------- simpler wires


def hanging_wire(
    *,
    mass: float = 0.0,
    source: AbstractSource | None = None,
    h: float = 100.0,
    law: AbstractLaw | None = None,
    **changes: Any,
) -> System:
    """The wire of problem A under a dead weight, with a constant film coefficient."""
    return problem_a(
        element=wire_a(law, **changes),
        environment=Environment(temperature=20 + ZERO, cooling=ConstantCooling(h=h)),
        source=source or PowerSource(),
        mechanism=DeadWeight(mass=mass),
    )


def chamber(law: AbstractLaw, mass: float = 0.0, **changes: Any) -> System:
    """A hanging wire whose temperature is prescribed."""
    return hanging_wire(mass=mass, source=PrescribedTemperature(), law=law, **changes)


def through(points: list[float], seconds: float = 1.0) -> FunctionWaveform:
    """Straight lines through points that are `seconds` apart, with exact values at the points."""

    def value(t: float) -> float:
        k = min(int(t / seconds), len(points) - 2)
        share = min(t / seconds - k, 1.0)
        return points[k] * (1.0 - share) + points[k + 1] * share

    kinks = tuple(seconds * k for k in range(1, len(points) - 1))
    return FunctionWaveform(function=value, kinks=kinks)


# ---------------------------------------------------------------- a bare law along a path


stepper, along, strain_of = trace_kinetics, follow_path, find_strain


def fraction_after(law: Any, points: list[tuple[float, float]], fraction: float, substeps: int = 1) -> float:
    """ξ at the last point."""
    return law.fractions(along(law, points, fraction, substeps)[-1]).martensite


def isobar(*celsius: float, stress: float = 0.0) -> list[tuple[float, float]]:
    """A path at constant stress [Pa] through temperatures [degC]."""
    return [(stress, t + ZERO) for t in celsius]


def isotherm(celsius: float, *mpa: float) -> list[tuple[float, float]]:
    """A path at constant temperature [degC] through stresses [MPa]."""
    return [(s * 1e6, celsius + ZERO) for s in mpa]


# ---------------------------------------------------------------- examples of registered things

# Options that an example leaves at their default: tried in other laws, and slow in these.
UNTRIED: dict[str, dict[str, Any]] = {
    "mpc": {"blocks": 1, "horizon": "0.1 s"},
    "mas-polycrystal": {"heat_model": "constant", "groups": "15"},
    "axial-wire": {"cells": "5"},
    "ribbon": {"wires": "2"},
    **{name: {"fibres": "5"} for name in ("coil-spring", "torsion-wire", "bending-beam")},
}


COLD = load_material("niti-brinson-1993").values
"""Numbers of laws in the examples: these transform at less power than typical ones."""


def example(cls: type[Parametrised], **choices: Any) -> Any:
    """An instance of any registered class, with a law that a little heat transforms."""
    return build_example(cls, **_chosen(cls, choices))


def _chosen(cls: type[Parametrised], choices: dict[str, Any]) -> dict[str, Any]:
    """Choices for the examples of the tests, and those given."""
    if issubclass(cls, AbstractLaw):
        choices = {n: COLD[n].value for n in cls.declarations if n in COLD} | choices
    for name, declared in cls.declarations.items():
        if name == "model":
            choices.setdefault(name, problem_a())
        elif declared.registry in (LAWS, ELEMENTS) and name not in choices:
            choices[name] = example(Brinson if declared.registry is LAWS else Wire)
    return choices


def variants(cls: type[Parametrised]) -> list[Any]:
    """An example of a class, and one for every other choice of each of its options."""
    return list_variants(cls, **_chosen(cls, dict(UNTRIED.get(cls.registered_name, {}))))


label = label_part


def registered(kind: str | None = None) -> list[type[Parametrised]]:
    """All registered classes, or those of one kind."""
    chosen = [REGISTRIES[kind]] if kind else list(REGISTRIES.values())
    return [registry[name] for registry in chosen for name in registry.names()]


def examples(kind: str) -> list[Any]:
    """Examples of all registered classes of one kind, one per combination of options."""
    return [thing for cls in registered(kind) for thing in variants(cls)]


def example_environment(cooling: AbstractCooling | None = None) -> Environment:
    return Environment(temperature=295.0, cooling=cooling or ConstantCooling(h=80.0))


def example_system(thing: Parametrised) -> AbstractSystem:
    """Problem A with one part exchanged: a law, cooling, element, mechanism or source."""
    if isinstance(thing, AbstractLaw):
        return problem_a(element=wire_a(thing))
    if isinstance(thing, AbstractCooling):
        return problem_a(environment=example_environment(thing))
    if isinstance(thing, AbstractMechanism) and len(thing.ports()) != 1:
        plain = problem_a()
        one = Actuator(**{name: getattr(plain, name) for name in Actuator.declarations})
        return Machine(mechanism=thing, group=Group(**dict.fromkeys(thing.ports(), one)))
    kinds = {"element": AbstractElement, "mechanism": AbstractMechanism, "source": AbstractSource}
    exchanged: dict[str, Any] = {s: thing for s, kind in kinds.items() if isinstance(thing, kind)}
    return problem_a(**exchanged)
