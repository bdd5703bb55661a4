"""Every part of this package keeps what its interface promises, by the suites that it ships.

Each suite is shown to fail: on parts that are wrong on purpose.
"""

from __future__ import annotations

import json
import sys
from typing import Any

import builders
import pytest
from builders import examples, label
from command import Command

from martensite.actuators.elements.wire import Wire
from martensite.actuators.mechanics.motion import Motion
from martensite.actuators.mechanisms.base import Column
from martensite.actuators.mechanisms.bias_spring import BiasSpring
from martensite.actuators.mechanisms.hand import Hand
from martensite.actuators.mechanisms.multibody import AbstractMultibody
from martensite.actuators.mechanisms.pulley import AntagonisticPulley
from martensite.base.errors import ParameterError
from martensite.base.parameters import param
from martensite.base.registry import Registry
from martensite.kernels.namespace import Namespace, Scalar
from martensite.physics.electrical.current import CurrentSource
from martensite.physics.electrical.per_length import PerLengthResistance
from martensite.physics.laws.base import Fractions
from martensite.physics.laws.liang_rogers import LiangRogers
from martensite.physics.thermal.constant import ConstantCooling
from martensite.signals.pwm import PulseWidthModulation
from martensite.testing import build_example, check_conformance
from martensite.testing.conformance import SUITES, find_checks

SLOW = {"lagoudas-waisted", "mas-polycrystal-constant-15-internal-stress"}
"""Second forms of the laws that take longest."""
CASES = [
    pytest.param(part, check, marks=[pytest.mark.slow] if label(part) in SLOW else [],
                 id=f"{label(part)}-{check.__name__}")
    for kind in SUITES for part in examples(kind) for check in find_checks(kind)
]  # fmt: skip


@pytest.mark.parametrize(("part", "check"), CASES)
def test_every_part_keeps_its_promises(part: Any, check: Any) -> None:
    check(part)


# ---------------------------------------------------------------- the suites can fail


class Falling(ConstantCooling):
    """Loses less and less."""

    def film(self, xp: Any, temperature: Any, ambient: Any, shape: Any) -> Any:
        return self.h / (1.0 + (temperature - ambient) * (temperature - ambient))


class Heating(ConstantCooling):
    """Takes heat from the colder side."""

    def film(self, xp: Any, temperature: Any, ambient: Any, shape: Any) -> Any:
        return self.h * (temperature - ambient - 20.0) / (abs(temperature - ambient) + 20.0)


class Short(PerLengthResistance):
    """The same for any length."""

    def resistance(self, xp: Any, fraction: Any, strain: Any, temperature: Any, of: Any) -> Any:
        return self.r_A + 0.0 * fraction


class Leaking(CurrentSource):
    """Never off, and cuts out at a high signal."""

    def current(self, xp: Any, drive: Any, resistance: Any) -> Any:
        return xp.where(drive < 15.0, 0.1 + drive, 0.0)


class Lying(CurrentSource):
    """Heats twice as much as its current does, and has a unit that is none."""

    unit = "amps of some kind"

    def heat(self, xp: Any, change: Any, resistance: Any) -> Any:
        found = super().heat(xp, change, resistance)
        return found._replace(mean=2.0 * found.mean)


class Shortening(Wire):
    """Gets shorter under more force, and has no heat capacity."""

    def elongation(self, xp: Any, state: Any, force: Any) -> Any:
        return -super().elongation(xp, state, force)

    def heat_capacity_total(self) -> Any:
        return 0.0

    def heat_loss(self, xp: Any, temperature: Any, environment: Any) -> Any:
        return 1.0 - super().heat_loss(xp, temperature, environment)


class Pushing(BiasSpring):
    """Pushes, and moves the wrong way."""

    def force(self, xp: Any, assembly: Any, spring: Any) -> Any:
        return spring.free - 0.01

    def position(self, xp: Any, assembly: Any, force: Any, elongation: Any) -> Any:
        return elongation + 1.0


class Stuttering(PulseWidthModulation):
    """Forgets its edges or has too many, and puts its mean too high."""

    def edges(self, duration: float) -> list[float]:
        return [duration, 0.31 * duration]

    def moments(self, begin: float, end: float) -> Any:
        found = super().moments(begin, end)
        return found._replace(mean=found.mean + 0.01)

    def value(self, time: float) -> float:
        return super().value(time) + (10.0 if 0.31 < time / 6.0 < 0.310001 else 0.0)


class Tangled(AbstractMultibody):
    """Two angles, and everything wrong."""

    def ports(self) -> tuple[str, ...]:
        return ("a", "b")

    def coordinates(self) -> Any:
        return Hand(offset=1.0, bracket=1.0, knuckle=1.0, preload=1.0).coordinates()[:2]

    def contraction(self, xp: Namespace, position: Column) -> Column:
        first, second = position
        return [first * xp.detach(first) + 0.1, second]  # a path whose slope is hidden

    def demand(self, xp: Namespace, motion: Motion, signals: Column) -> Column:
        (q, p), (v, w), (a, b) = motion
        grows: Scalar = q * (w * w + v * v)
        return [0.3 + p - v + a + 2.0 * b + grows, -p - w + 2.0 * a + b + grows]

    def start_forces(self, xp: Namespace) -> Column:
        return [0.0, 0.0]


class Forgetful(AntagonisticPulley):
    """Says that its joint holds less than it does."""

    def energy(self, xp: Namespace, motion: Motion) -> Any:
        found = super().energy(xp, motion)
        return found._replace(springs=0.7 * found.springs)


class Growing(LiangRogers):
    """Has more than all of its martensite, and tells the wrong memory."""

    def fractions(self, memory: Any) -> Fractions:
        return Fractions(1.5 * memory.fraction, memory.fraction)


class Careless(LiangRogers):
    """0/0 at the finish lines."""

    def follow(self, xp: Any, move: Any, stress: Any, temperature: Any, dt: Any) -> Fractions:
        found = super().follow(xp, move, stress, temperature, dt)
        return Fractions(*(x * move.scale / move.scale for x in found))


class Hurried(LiangRogers):
    """A history rule, and yet more happens in more time."""

    def follow(self, xp: Any, move: Any, stress: Any, temperature: Any, dt: Any) -> Fractions:
        found = super().follow(xp, move, stress, temperature, dt)
        return Fractions(*(x * (1.0 - 0.01 * xp.minimum(dt, 1.0)) for x in found))


class Softening(LiangRogers):
    """Gets shorter under more stress."""

    def compliance(self, xp: Any, fractions: Any) -> Any:
        return -super().compliance(xp, fractions)


class Backwards(LiangRogers):
    """Says what is left of austenite for martensite."""

    def fractions(self, memory: Any) -> Fractions:
        return Fractions(1.0 - memory.fraction, 0.0)


WRONG: dict[str, list[Any]] = {
    "cooling": [Falling(h=10.0), Heating(h=10.0)],
    "resistance": [build_example(Short)],
    "drive": [build_example(Leaking), build_example(Lying), CurrentSource(current_limit=0.3)],
    "element": [build_example(Shortening)],
    "mechanism": [build_example(Pushing), Tangled(), build_example(Forgetful)],
    "waveform": [build_example(Stuttering)],
    "law": [
        build_example(Growing), build_example(Careless), build_example(Hurried),
        build_example(Softening), build_example(Backwards),
        build_example(builders.PrintedFormula, history="restart"),
        build_example(LiangRogers, C_A=20e6, C_M=5e6),
    ],
}  # fmt: skip
HELD_BY_ALL = {"check_limits", "check_levels"}
"""Checks of what only some parts have."""


@pytest.mark.parametrize("kind", SUITES)
def test_every_check_notices_a_wrong_part(kind: str) -> None:
    noticed = {
        one.check
        for part in WRONG[kind]
        for one in check_conformance(type(part), kind, [part]).faults
    }
    assert {check.__name__ for check in find_checks(kind)} - HELD_BY_ALL <= noticed


def test_a_wrong_level_and_a_limit_that_is_passed_are_noticed() -> None:
    class Unlimited(CurrentSource):
        """Does not keep its limit."""

        def current(self, xp: Any, drive: Any, resistance: Any) -> Any:
            return drive

    class Loud(PulseWidthModulation):
        """Goes beyond its levels."""

        def value(self, time: float) -> float:
            return 2.0 * super().value(time)

    for kind, part in (
        ("drive", Unlimited(current_limit=0.3)), ("waveform", build_example(Loud)),
    ):  # fmt: skip
        found = check_conformance(type(part), kind, [part])
        assert HELD_BY_ALL & {one.check for one in found.faults}


# ---------------------------------------------------------------- parts of one's own


WRONG_LAW = """
from martensite.physics.laws.base import LAWS, Fractions
from martensite.physics.laws.liang_rogers import LiangRogers


@LAWS.register("wrong-way")
class WrongWay(LiangRogers):
    '''Its martensite fraction grows as it is heated.'''

    def fractions(self, memory):
        return Fractions(1.0 - memory.fraction, 0.0)
"""


OWN_LAW = """
from martensite.physics.laws.base import LAWS
from martensite.physics.laws.liang_rogers import LiangRogers


@LAWS.register("own-law")
class OwnLaw(LiangRogers):
    '''Liang-Rogers, by another name.'''
"""


@pytest.fixture
def folder(tmp_path: Any, monkeypatch: Any) -> Any:
    """With two laws of somebody's own, and a cache of its own."""
    from martensite.physics.laws.base import LAWS

    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    files = {"wrong-way": ("wrong_way_law", WRONG_LAW), "own-law": ("an_own_law", OWN_LAW)}
    for module, text in files.values():
        (tmp_path / f"{module}.py").write_text(text)
    yield tmp_path
    for name, (module, _) in files.items():
        LAWS._entries.pop(name, None)
        sys.modules.pop(module, None)


def test_a_law_whose_fraction_moves_the_wrong_way_is_refused(folder: Any) -> None:
    found = Command("conform", str(folder / "wrong_way_law.py"))()
    assert found.exit_code == 1
    assert "law `wrong-way` does not conform" in found.stdout
    assert "the martensite fraction goes the wrong way at" in " ".join(found.stdout.split())


SCENARIO = """
[element]
kind = "wire"
material = "flexinol-90"
law = { kind = "own-law", modulus = "mixture" }
diameter = "0.25 mm"
length = "200 mm"

[environment]
temperature = "22 degC"
cooling = { kind = "constant", h = "70 W/m^2/K" }

[mechanism]
kind = "dead-weight"
mass = "500 g"

[drive]
kind = "current"
waveform = { kind = "step", high = "0.1 A" }

[run]
duration = "1 s"
"""


def test_a_run_says_whether_a_foreign_part_was_tried(folder: Any) -> None:
    scenario, law = folder / "own.toml", str(folder / "an_own_law.py")
    scenario.write_text(SCENARIO)
    out = ["--json", "--force", "--no-figure", "--out", str(folder / "own.nc")]
    call = Command("run", str(scenario), "--import", law, *out)
    assert json.loads(call().stdout)["conformance"] == {"own-law": "not tried"}
    assert Command("conform", law)().exit_code == 0
    assert json.loads(call().stdout)["conformance"] == {"own-law": "conforms"}
    (folder / "an_own_law.py").write_text(OWN_LAW + "# another\n")
    assert json.loads(call().stdout)["conformance"] == {"own-law": "not tried"}
    plain = json.loads(Command("run", "examples/pwm_bias_spring.toml", *out)().stdout)
    assert plain["conformance"] == {}


def test_conformance_is_there_as_json() -> None:
    (found,) = json.loads(Command("conform", "dead-weight", "--json")().stdout)
    assert (found["name"], found["kind"], found["holds"]) == ("dead-weight", "mechanism", True)
    assert {one["check"] for one in found["findings"]} == {
        check.__name__ for check in find_checks("mechanism")
    }


def test_an_unknown_part_is_named_with_the_nearest(tmp_path: Any) -> None:
    found = Command("conform", "tanaki")()
    assert found.exit_code == 2
    assert "Did you mean `tanaka`?" in found.stderr
    empty = tmp_path / "without_parts.py"
    empty.write_text("x = 1\n")
    assert "registers no part" in Command("conform", str(empty))().stderr


def test_a_part_without_typical_values_is_told_what_to_declare() -> None:
    class Bare(ConstantCooling):
        """Needs a number of no typical size."""

        more: Scalar = param("1", "something")

    with pytest.raises(ParameterError, match=r"`more` of `Bare` has neither a default nor a"):
        check_conformance(Bare, "cooling")


def test_a_registry_of_no_suite_is_said() -> None:
    kinds: Registry[Any] = Registry("toy", "martensite.physics.laws")
    with pytest.raises(Exception, match="There is no suite for the kind `toy`"):
        check_conformance(LiangRogers, kinds.kind)
