"""Bundles and chains: n times the force or the stroke of one, whatever the one is.

Source of truth: one element alone under the n-th part of the load, or one as long as all.
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from axial_cases import axial
from builders import law_a, wire_a
from coil_cases import platform_spring
from typer.testing import CliRunner

from martensite.actuators.assembly import System
from martensite.actuators.elements.base import AbstractElement
from martensite.actuators.elements.rows import Bundle, LinkChain
from martensite.actuators.mechanisms.base import AbstractMechanism
from martensite.actuators.mechanisms.load_line import BiasSpring, DeadWeight
from martensite.base.errors import InputError, ParameterError
from martensite.cli import app
from martensite.kernels import floats
from martensite.physics.electrical.base import AbstractSource
from martensite.physics.electrical.sources import PowerSource, VoltageSource
from martensite.physics.thermal.base import Environment
from martensite.physics.thermal.ends import ClampedEnds
from martensite.physics.thermal.films import ConstantCooling
from martensite.scenario.scenario import read_scenario
from martensite.signals.step import Step
from martensite.simulate.api import simulate
from martensite.simulate.result import Result

N = 3
ENVIRONMENT = Environment(temperature=295.0, cooling=ConstantCooling(h=100.0))
SAME = ("temperature", "hottest", "martensite_fraction", "stress", "strain")
"""Columns that do not know how many there are."""
LOADS = ("weight", "spring")


def load(kind: str, force: float = 1.0, stroke: float = 1.0) -> AbstractMechanism:
    """A load for a wire of problem A, so many times as strong or as far."""
    if kind == "weight":
        return DeadWeight(mass=1.0 * force)
    return BiasSpring(stiffness=1000.0 * force / stroke, preload=5.0 * force)


def run(
    element: AbstractElement,
    mechanism: AbstractMechanism,
    high: float,
    source: AbstractSource | None = None,
    **options: Any,
) -> Result:
    """A whole cycle."""
    system = System(element=element, environment=ENVIRONMENT, source=source or PowerSource(), mechanism=mechanism)
    pulse = Step(low=0.0, high=high, at=1.0, until=14.0)
    usual: dict[str, Any] = {"step": 0.1, "samples": 151}
    return simulate(system, pulse, 30.0, **(usual | options))


def agree(many: Result, one: Result, **factors: float) -> None:
    """All columns are those of one, times a factor."""
    for name in (*SAME, *factors):
        expected = factors.get(name, 1.0) * np.array(one[name])
        assert np.array(many[name]) == pytest.approx(expected, rel=1e-9, abs=1e-12), name


@pytest.fixture(scope="module", params=LOADS)
def alone(request: pytest.FixtureRequest) -> tuple[str, Result]:
    """One wire at 5 W."""
    found = run(wire_a(law_a()), load(request.param), 5.0)
    assert (min(found["martensite_fraction"]), found["martensite_fraction"][-1]) == (0.0, 1.0)
    return request.param, found


@pytest.mark.parametrize("wiring", ["series", "parallel"])
def test_a_bundle_is_so_many_times_as_strong(alone: tuple[str, Result], wiring: str) -> None:
    kind, one = alone
    many = run(Bundle(strand=wire_a(law_a()), count=N, wiring=wiring), load(kind, force=N), N * 5.0)
    series = wiring == "series"
    agree(
        many,
        one,
        force=N,
        position=1.0,
        power=N,
        heat_loss=N,
        resistance=N if series else 1.0 / N,
        current=1.0 if series else N,
        voltage=N if series else 1.0,
    )


@pytest.mark.parametrize("wiring", ["series", "parallel"])
def test_a_chain_goes_so_many_times_as_far(alone: tuple[str, Result], wiring: str) -> None:
    kind, one = alone
    many = run(LinkChain(link=wire_a(law_a()), count=N, wiring=wiring), load(kind, stroke=N), N * 5.0)
    agree(many, one, force=1.0, position=N, power=N, heat_loss=N, resistance=N if wiring == "series" else 1.0 / N)


@pytest.mark.parametrize("kind", LOADS)
def test_a_chain_is_a_longer_wire(kind: str) -> None:
    wire = wire_a(law_a())
    long = wire.rebuilt({"length": N * wire.length})
    source = VoltageSource(series_resistance=0.2)
    chain, whole = (run(e, load(kind), 3.0 * N, source) for e in (LinkChain(link=wire, count=N), long))
    agree(chain, whole, force=1.0, position=1.0, resistance=1.0, current=1.0, heat_loss=1.0)


def test_a_chain_of_bundles_is_both() -> None:
    wire = wire_a(law_a())
    one = run(wire, load("spring"), 5.0)
    strands = Bundle(strand=wire, count=2, wiring="parallel")
    many = run(LinkChain(link=strands, count=N), load("spring", force=2, stroke=N), 2 * N * 5.0)
    agree(many, one, force=2.0, position=N, power=2.0 * N, resistance=N / 2)


@pytest.mark.parametrize("deflection", ["small", "large"])
def test_springs_side_by_side_and_behind_each_other(deflection: str) -> None:
    """Large deflection is not linear in the force: each has to be fitted at its own."""
    spring = platform_spring(deflection=deflection)
    watts = 130.0 * 100.0 * spring.surface()  # would warm it by 130 K

    def moved(element: AbstractElement, force: float, stroke: float, count: float) -> Result:
        mechanism = BiasSpring(stiffness=100.0 * force / stroke, preload=3.0 * force)
        return run(element, mechanism, watts * count)

    one = moved(spring, 1.0, 1.0, 1.0)
    assert one.stroke > 0.01
    agree(moved(Bundle(strand=spring, count=N), N, 1.0, N), one, force=N, position=1.0)
    agree(moved(LinkChain(link=spring, count=N), 1.0, N, N), one, force=1.0, position=N)


def test_time_constant_is_that_of_one() -> None:
    wire = wire_a(law_a())
    for many in (Bundle(strand=wire, count=N), LinkChain(link=wire, count=N, wiring="parallel")):
        ratios = [e.heat_capacity_total() / e.heat_loss(floats, 296.0, ENVIRONMENT) for e in (many, wire)]
        assert ratios[0] == pytest.approx(ratios[1], rel=1e-12)
        assert many.heat_capacity_total() == pytest.approx(N * wire.heat_capacity_total())


def test_every_strand_has_its_own_ends() -> None:
    wire = wire_a(law_a(), ends=ClampedEnds(thermal_conductivity=18.0), length=0.02)
    lost = [e.heat_loss(floats, 340.0, ENVIRONMENT) for e in (Bundle(strand=wire, count=N), wire)]
    assert lost[0] == pytest.approx(N * lost[1], rel=1e-12)
    long = wire.rebuilt({"length": N * wire.length})
    assert lost[0] > 1.1 * long.heat_loss(floats, 340.0, ENVIRONMENT)


# ---------------------------------------------------------------- what is refused


@pytest.mark.parametrize(
    ("build", "words"),
    [
        (lambda: Bundle(strand=wire_a(law_a()), count=2.5), "`count` of `bundle` must be a whole"),
        (lambda: LinkChain(link=wire_a(law_a()), count=0.0), "must be between 1 and 10000, but is 0"),
        (lambda: Bundle(strand=axial(), count=2), "`axial-wire` has many"),
        (lambda: LinkChain(link=axial(), count=2), "takes elements of one phase state, such as `wire`"),
        (lambda: Bundle(strand=wire_a(law_a()), count=2, wiring="star"), "Valid: `parallel`, `series`"),
    ],
    ids=["half", "none", "bundle of axial wires", "chain of axial wires", "wiring"],
)
def test_what_cannot_be_meant_is_one_sentence(build: Any, words: str) -> None:
    with pytest.raises(ParameterError) as caught:
        build()
    sentence = str(caught.value)
    assert words in sentence
    assert "\n" not in sentence


# ---------------------------------------------------------------- scenario files

SCENARIO = """\
[element]
kind = "bundle"
material = "flexinol-90"
count = 3
strand = { kind = "wire", law = "liang-rogers", diameter = "0.25 mm", length = "200 mm" }
[environment]
temperature = "22 degC"
cooling = { kind = "constant", h = "80 W/m^2/K" }
[mechanism]
kind = "dead-weight"
mass = "1.5 kg"
[drive]
kind = "power"
waveform = { kind = "step", high = "6 W", until = "10 s" }
[run]
duration = "20 s"
tolerance = 1e-3
samples = 51
"""


def element(text: str = SCENARIO, **changes: Any) -> Any:
    """The element that a scenario builds."""
    named = {key.replace("__", "."): value for key, value in changes.items()}
    return read_scenario(text, overrides=named or None).single_system.element


def sentence(**changes: Any) -> str:
    """The sentence with which a changed scenario is refused."""
    with pytest.raises(InputError) as caught:
        element(**changes)
    return str(caught.value)


def test_a_bundle_is_built_from_a_scenario() -> None:
    """The material of the element fills the strand; the rest is written there."""
    found = element()
    assert (type(found), found.count, found.wiring) == (Bundle, 3.0, "series")
    assert found.strand.density == pytest.approx(6450.0)
    assert found.strand.diameter == pytest.approx(0.25e-3)
    assert read_scenario(SCENARIO).origins["element.strand.diameter"] == "scenario"
    assert "flexinol-90" in read_scenario(SCENARIO).origins["element.strand.density"]
    assert math.isclose(found.heat_capacity_total(), 3 * found.strand.heat_capacity_total())


def test_a_strand_can_be_changed_from_outside() -> None:
    assert element(element__strand__diameter="0.15 mm").strand.diameter == pytest.approx(0.15e-3)
    assert element(element__count=5).count == 5.0


def test_a_chain_of_bundles_is_built_from_a_scenario() -> None:
    nested = SCENARIO.replace("strand =", 'wiring = "parallel"\nstrand =').replace(
        '[element]\nkind = "bundle"\nmaterial = "flexinol-90"\n',
        '[element]\nkind = "chain"\nmaterial = "flexinol-90"\ncount = 2\n[element.link]\nkind = "bundle"\n',
    )
    found = element(nested)
    assert (type(found), type(found.link), found.link.wiring) == (LinkChain, Bundle, "parallel")


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"element__strand__diamter": "1 mm"}, "Did you mean `diameter`"),
        ({"element__diameter": "1 mm"}, "write `element.strand.diameter`"),
        ({"element__strand__kind": "wyre"}, "Did you mean `wire`"),
        ({"element__kind": "bundel"}, "Did you mean `bundle`"),
        ({"element__count": 2.5}, "must be a whole number, but is 2.5"),
        ({"element__wiring": "seris"}, "Did you mean `series`"),
    ],
)
def test_unknown_names_are_refused_with_the_nearest(changes: dict[str, Any], words: str) -> None:
    assert words in sentence(**changes)


def test_the_command_line_sets_the_strand(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    file = tmp_path / "bundle.toml"
    file.write_text(SCENARIO, encoding="utf-8")
    arguments = ["run", str(file), "--set", "element.strand.diameter=0.2 mm"]
    fine = CliRunner().invoke(app, [*arguments, "--set", "drive.waveform.high=4 W"])
    assert fine.exit_code == 0, fine.output
    wrong = CliRunner().invoke(app, ["run", str(file), "--set", "element.strand.diametre=0.2 mm"])
    assert wrong.exit_code == 2
    assert "`diameter`" in wrong.output
