"""Systems whose measures are tried: every law, element and kind of mechanism, each with what drives it well."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any

from builders import ZERO, example, example_environment, law_a, problem_a, wire_a

from martensite.actuators.assembly import AbstractSystem
from martensite.actuators.elements.base import ELEMENTS
from martensite.actuators.mechanisms.base import MECHANISMS
from martensite.actuators.mechanisms.load_line import BiasSpring, DeadWeight
from martensite.base.parameters import Parametrised
from martensite.physics.electrical.base import SOURCES
from martensite.physics.electrical.sources import PowerSource, PrescribedTemperature
from martensite.physics.laws.base import LAWS
from martensite.physics.laws.wear import Wear
from martensite.physics.thermal.base import COOLING
from martensite.scenario.scenario import load

ROOT = Path(__file__).parents[2]
VOLTS, SECONDS = 3.0, 30.0
"""Drive [V] and duration [s] of the wire of problem A."""


@dataclass(frozen=True)
class Structure:
    """A system, and what its drives and its runs are like."""

    group: str
    """Row of the table in which it is counted."""
    build: Callable[[], AbstractSystem]
    levels: Mapping[str, tuple[float, float]]
    """Lowest and highest level of every drive, in its unit."""
    seconds: float
    """Typical duration of a run [s]."""
    kinds: tuple[str, ...] = ()
    """Kinds of drives it is under; all if none are given."""
    closeness: float = 0.0
    """Tolerance of the reference as a fraction of the tolerance of the trial; 0 for the tightest."""

    @cached_property
    def system(self) -> AbstractSystem:
        """The system at its nominal numbers."""
        return self.build()


def list_parts(part: Any) -> Iterator[Any]:
    """Return a part and all parts in it."""
    if isinstance(part, Parametrised):
        yield part
        for one in vars(part).values():
            yield from list_parts(one)
    elif isinstance(part, tuple | list | dict):
        for one in part.values() if isinstance(part, dict) else part:
            yield from list_parts(one)


def _law(name: str, **choices: Any) -> Structure:
    """The wire of problem A with another law."""
    one = LAWS[name]

    def build() -> AbstractSystem:
        return problem_a(element=wire_a(example(one, **choices)))

    group = "R-phase" if name == "r-phase" else "rate laws" if name.startswith("mas") else "strip laws"
    if choices.get("history") == "return-point":
        group = "return points"
    if choices.get("compression", "none") != "none":
        group = "compression"
    return Structure(group, build, {"drive": (0.0, VOLTS)}, SECONDS)


def _element(group: str, name: str, **choices: Any) -> Structure:
    """An element of typical numbers in place of the wire of problem A."""

    def build() -> AbstractSystem:
        return problem_a(element=example(ELEMENTS[name], **choices), mechanism=BiasSpring(stiffness=100, preload=1.0))

    return Structure(group, build, {"drive": (0.0, 2.0)}, SECONDS)


def _file(
    group: str, name: str, levels: Mapping[str, tuple[float, float]], seconds: float, *kinds: str, **changes: Any
) -> Structure:
    """The system of an example; `changes` have `__` for dots."""
    words = {path.replace("__", "."): value for path, value in changes.items()}
    closeness = CLOSE if group == "inertia" else 0.0
    return Structure(
        group, lambda: load(ROOT / f"examples/{name}.toml", words).system, levels, seconds, kinds, closeness
    )


def _part(
    group: str, kind: str, part: type[Parametrised], high: float = VOLTS, **levels: tuple[float, float]
) -> Structure:
    """The wire of problem A with another source, cooling or mechanism."""

    def build() -> AbstractSystem:
        one = example(part)
        parts: dict[str, Any] = {kind: example_environment(one) if kind == "environment" else one}
        return problem_a(**parts)

    return Structure(group, build, {"drive": (0.0, high), **levels}, SECONDS)


def _worn() -> AbstractSystem:
    wear = Wear(settling_cycles=5.0, residual_strain=0.005, stroke_loss=0.1, temperature_shift=-5.0)
    return problem_a(element=wire_a(law_a(), wear=wear))


def _fibres() -> AbstractSystem:
    words: dict[str, Any] = {
        "element.material": "flexinol-90",
        "element.law": {
            "kind": "brinson",
            "sigma_s": "80 MPa",
            "sigma_f": "150 MPa",
            "compression": "symmetric",
            "Theta": "0 MPa/K",
        },
        "element.fibres": "10",
        "drive": {"kind": "voltage", "waveform": {"kind": "constant", "level": "0 V"}},
        "environment.temperature": "22 degC",
    }
    return load(ROOT / "examples/torsion_wire.toml", words).system


def _chamber() -> AbstractSystem:
    return problem_a(source=PrescribedTemperature(), mechanism=DeadWeight(mass=1.0))


CLOSE = 0.01
"""Closeness of systems with inertia, and of the lever: at the tightest tolerance they take millions of steps."""
SMOOTH = ("sine", "tones", "triangle", "table", "step")
MOTOR = ("table", "triangle", "step")
V = {"drive": (0.0, VOLTS)}
JOINTS = [f"{finger}_{joint}" for finger in ("thumb", "index", "middle") for joint in ("proximal", "distal")]
FLEXORS, EXTENSORS = ([f"{joint}_{muscle}" for joint in JOINTS] for muscle in ("flexor", "extensor"))
STRUCTURES: dict[str, Structure] = {
    "liang-rogers": Structure("strip laws", problem_a, V, SECONDS),
    "liang-rogers, stress": _law("liang-rogers", transformation="stress", modulus="mixture"),
    "liang-rogers, restart": _law("liang-rogers", history="restart", modulus="mixture"),
    "liang-rogers, waisted": _law("liang-rogers", hardening="waisted"),
    "liang-rogers, return-point": _law("liang-rogers", history="return-point", modulus="mixture"),
    "tanaka": _law("tanaka"),
    "tanaka, return-point": _law("tanaka", history="return-point"),
    "brinson, compression": _law("brinson", compression="symmetric"),
    "elahinia": _law("elahinia"),
    "elahinia, compression": _law("elahinia", compression="asymmetric"),
    "lagoudas": _law("lagoudas", hardening="waisted"),
    "lagoudas, compression": _law("lagoudas", compression="symmetric"),
    "mas": _law("mas", rates="barrier"),
    "mas, edge": _law("mas", rates="edge"),
    "mas-hybrid": _law("mas-hybrid"),
    "mas-polycrystal": _law("mas-polycrystal", groups="15"),
    "r-phase": _file("R-phase", "r_phase", {"drive": (0.0, 3.0)}, 100.0),
    "worn wire": Structure("wear", _worn, V, SECONDS),
    "wire, power": Structure("strip laws", lambda: problem_a(source=PowerSource()), {"drive": (0.0, 5.0)}, SECONDS),
    "wire, temperature": Structure(
        "prescribed temperature", _chamber, {"drive": (ZERO + 20, ZERO + 130)}, 60.0, SMOOTH
    ),
    "isobaric": _file(
        "prescribed temperature", "isobaric", {"drive": (ZERO + 30, ZERO + 150), "command": (1e8, 2e8)}, 100.0, *SMOOTH
    ),
    "wire, pwm of a supply": _file("strip laws", "constant_power", {"drive": (0.0, 0.5)}, 10.0),
    "wire, series resistance": _file("strip laws", "pwm_bias_spring", {"drive": (0.0, 3.0)}, 30.0),
    "torsion-wire": _file("fibres", "torsion_wire", {"drive": (0.0, 2.2)}, 30.0, element__fibres="10"),
    "torsion-wire, compression": Structure("fibres", _fibres, {"drive": (0.0, 0.35)}, 15.0),
    "coil-spring, fibres": _element("fibres", "coil-spring", section_model="fibres", fibres="5"),
    "bending-beam": _element("fibres", "bending-beam", fibres="5"),
    "coil-spring": _file("springs and bundles", "platform_spring", {"drive": (0.0, 2.4)}, 100.0),
    "bundle": _element("springs and bundles", "bundle"),
    "ribbon": _element("springs and bundles", "ribbon", wires="2"),
    "clamped wire": _file("springs and bundles", "clamped_wire", {"drive": (0.0, 0.22)}, 8.0, element__cells="10"),
    "finger": _file("mechanisms", "finger", {"drive": (0.0, 2.2)}, 20.0),
    "antagonists": _file(
        "mechanisms", "antagonistic_wires", {"protagonist": (0.0, 2.0), "antagonist": (0.0, 2.0)}, 30.0
    ),
    "rails on a supply": _file(
        "mechanisms", "three_rails", dict.fromkeys(("first", "second", "third"), (0.0, 0.5)), 8.0
    ),
    "platform": Structure(
        "mechanisms",
        lambda: load(ROOT / "examples/closed_loop_platform.toml").system,
        dict.fromkeys(("first", "second", "third"), (0.0, 5.0)),
        30.0,
    ),
    "finger, dynamic": _file(
        "inertia",
        "finger",
        {"drive": (0.0, 2.2)},
        1.0,
        *SMOOTH,
        mechanism__motion="dynamic",
        mechanism__damping="1e-4 N*m*s/rad",
    ),
    "beam and wire": _file("inertia", "beam_harvester", {"drive": (0.0, 1.2), "motor": (0.0, 2.0)}, 0.2, *MOTOR),
    "motor on a beam": _file("inertia", "sommerfeld_beam", {"motor": (0.0, 6.0)}, 0.6, *MOTOR),
    "two motors": _file(
        "inertia", "two_motors", {"drive": (0.0, 0.5), "motor": (0.0, 2.0), "motor_2": (0.0, 2.0)}, 0.6, *MOTOR
    ),
    "hand": _file("mechanisms", "hand", dict.fromkeys(FLEXORS, (0.0, 2.6)) | dict.fromkeys(EXTENSORS, (0.0, 1.0)), 8.0),
    "lever": replace(_part("mechanisms", "mechanism", MECHANISMS["lever"]), closeness=CLOSE),
    "chain": _element("springs and bundles", "chain"),
    "wire, h-bridge": _part("sources", "source", SOURCES["h-bridge"], 1.0),
    "wire, linear amplifier": _part("sources", "source", SOURCES["linear-amplifier"]),
    "wire, mosfet": _part("sources", "source", SOURCES["mosfet"], 1.0),
    "wire, churchill-bernstein": _part("cooling", "environment", COOLING["churchill-bernstein"]),
    "wire, lefevre-ede": _part("cooling", "environment", COOLING["lefevre-ede"]),
    "wire, morgan": _part("cooling", "environment", COOLING["morgan"]),
    "wire, peltier": _part("cooling", "environment", COOLING["peltier"], peltier=(0.0, 1.0)),
    "wire, fan": _file("cooling", "fan_cooled", {"drive": (0.0, 0.9), "fan": (0.5, 5.0)}, 12.0, *SMOOTH),
}
"""Structures by name."""
