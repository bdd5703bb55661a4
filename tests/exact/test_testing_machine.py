"""The testing machine against a dead weight, material points, springs in series and its reports.

Sources of truth: the mechanism `dead-weight`, laws driven by themselves (`material_point`), and
closed forms of an elastic element. Where a law is compared to rounding, every step is solved to
rounding as well (`marched`).
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from builders import Swings, chamber, example, examples, label, law_a, problem_a, through, wire_a
from elastic import REST, actuator, kelvins, machine

from martensite.actuators.assembly import AbstractSystem, System
from martensite.actuators.mechanisms.testing_machine import TensileTestingMachine
from martensite.base.errors import ParameterError
from martensite.kernels import floats
from martensite.physics.electrical.sources import PrescribedTemperature
from martensite.physics.laws.base import LAWS, AbstractLaw, Fractions
from martensite.physics.thermal.base import Environment
from martensite.physics.thermal.films import ConstantCooling
from martensite.scenario.scenario import read_scenario
from martensite.signals.base import AbstractWaveform
from martensite.signals.constant import Constant
from martensite.signals.moments import Tone
from martensite.simulate.api import simulate
from martensite.simulate.compiled import compile_march
from martensite.simulate.drive_waveforms import grid_of
from martensite.simulate.march import march_floats
from martensite.simulate.point import PathLeg, PointResult, material_point

SECTION = 0.25 * math.pi * 0.381e-3**2
LENGTH = 0.25
HOT, WARM, COLD = 345.0, 330.0, 300.0
"""[K]; superelastic, stays stretched, and below all transformations."""
AUSTENITE, MARTENSITE = Fractions(0.0, 0.0), Fractions(1.0, 1.0)
STEEP = {"mas-hybrid": 4e-9}
"""Signals are read 1e-9 of a step before its end: in this law, which jumps
within hundredths of a kelvin, that shows."""
NAMES = ("liang-rogers", "brinson", "lagoudas", "tanaka", "mas", "mas-hybrid")


def rig(law: AbstractLaw, machine: TensileTestingMachine, **changes: Any) -> System:
    """The wire of problem A in a chamber and in a testing machine."""
    return problem_a(
        element=wire_a(law, **changes),
        mechanism=machine,
        source=PrescribedTemperature(),
        environment=Environment(temperature=COLD, cooling=ConstantCooling(h=0.0)),
    )


def strained(law: AbstractLaw, **changes: Any) -> System:
    """Austenite under a prescribed strain."""
    one = TensileTestingMachine(control="strain", gauge_length=LENGTH, **changes)
    return rig(law, one, initial_fraction=0.0)


def stressed(law: AbstractLaw, stress: float, **changes: Any) -> System:
    """Under a prescribed stress, mounted under a first one [Pa]."""
    one = TensileTestingMachine(control="stress", section=SECTION, preload=stress * SECTION)
    return rig(law, one, **changes)


def marched(
    system: AbstractSystem, waves: Mapping[str, AbstractWaveform], legs: int, steps: int
) -> dict[str, np.ndarray]:
    """All outputs after every step of legs of 1 s, each step solved to rounding."""
    compiled = compile_march(system)
    functions = compiled.program.bind_floats(*compiled.values(system))
    grid = grid_of(system, waves, float(legs), legs * steps + 1, 1.0 / steps)
    track = march_floats(functions, compiled.size, grid)
    assert not track.status.failed
    return dict(zip(compiled.outputs, np.array(track.rows).T, strict=True))


def point(
    law: AbstractLaw, legs: list[PathLeg], start: tuple[float, float], fractions: Fractions, steps: int
) -> PointResult:
    """The law by itself in exactly so many steps per leg."""
    return material_point(law, legs, start=start, fractions=fractions, steps=steps, tolerance=None)


def share(found: Any, expected: Any) -> float:
    """Largest difference as a share of range."""
    return float(np.abs(np.subtract(found, expected)).max() / np.ptp(expected))


# ---------------------------------------------------------------- a force is prescribed


def test_a_constant_force_is_a_dead_weight() -> None:
    mass, gravity = 1.2, 9.80665
    force = mass * gravity
    heated = through([300.0, 380.0, 300.0], 40.0)
    control = TensileTestingMachine(control="force", preload=force)
    weight = simulate(chamber(law_a(), mass=mass), heated, 80.0, step=0.5, samples=81)
    drives = {"drive": heated, "command": Constant(level=force)}
    held = simulate(rig(law_a(), control), drives, 80.0, step=0.5, samples=81)
    assert weight.stroke > 8e-3
    for name in ("temperature", "martensite_fraction", "stress", "strain", "force", "position"):
        assert held[name] == pytest.approx(weight[name], rel=1e-12, abs=1e-15)
    assert held["crosshead"] == pytest.approx([-x for x in weight["position"]], abs=1e-15)


@pytest.mark.parametrize("name", NAMES)
def test_an_isobaric_cycle_is_that_of_the_law(name: str) -> None:
    law, stress = example(LAWS[name]), 150e6
    legs = [PathLeg(temperature=400.0), PathLeg(temperature=COLD)]
    alone = point(law, legs, (stress, COLD), MARTENSITE, 80)
    waves = {"drive": through([COLD, 400.0, COLD]), "command": Constant(level=stress)}
    cycle = marched(stressed(law, stress), waves, 2, 80)
    assert np.ptp(alone.strain) > 0.04
    assert cycle["stress"] == pytest.approx(np.full(161, stress), rel=1e-14)
    assert np.abs(cycle["strain"] - alone.strain).max() < STEEP.get(name, 1e-9)


def test_a_force_is_followed_and_never_pushes() -> None:
    """Elastic: the crosshead travels by compliance · (F - F₀), frame included."""
    control = TensileTestingMachine(control="force", stiffness=5e3)
    wave = Swings(level=3.0, swings=(Tone(5.0, 3.0, 0.5 * math.pi),))
    system = machine(control, compliance=1e-4)
    run = simulate(system, {**kelvins(system), "command": wave}, 2.0, step=0.1, samples=21)
    forces = np.maximum([wave.value(t) for t in run.times], 0.0)
    assert run["element.force"] == pytest.approx(forces, rel=1e-14)
    assert forces.min() == 0.0
    assert run["position"] == pytest.approx(1e-4 * (3.0 - forces), abs=1e-16)
    assert run["crosshead"] == pytest.approx(3e-4 * (forces - 3.0), abs=1e-16)


@pytest.mark.parametrize(
    ("control", "size", "plain"),
    [("stress", {"section": 2e-6}, "force"), ("strain", {"gauge_length": 2e-6}, "elongation")],
)
def test_section_and_gauge_length_are_factors(control: str, size: dict[str, float], plain: str) -> None:
    seen = []
    for one, factor in (
        (TensileTestingMachine(control=control, preload=2.0, **size), 1.0),
        (TensileTestingMachine(control=plain, preload=2.0), 2e-6),
    ):
        system = machine(one)
        waves = {**kelvins(system, element=0.2), "command": through([0.0, factor * 700.0])}
        seen.append(simulate(system, waves, 1.0, step=0.1, samples=11))
    first, second = seen
    assert np.ptp(first["element.force"]) > 1e-3
    for name in ("element.force", "position", "crosshead"):
        assert first[name] == pytest.approx(second[name], rel=1e-14, abs=1e-18)


# ---------------------------------------------------------------- a travel is prescribed


def pull(law: AbstractLaw, zero: float, *more: float) -> dict[str, AbstractWaveform]:
    """Strains to 5 %, and further ones, of which the law counts `zero` as mounted."""
    strains = [zero, 0.05, *more]
    return {"drive": Constant(level=HOT), "command": through([e - zero for e in strains])}


@pytest.mark.parametrize("name", NAMES)
def test_a_pull_is_that_of_the_law(name: str) -> None:
    """To 5 %, half back, up again, and to none: the stress of a strain-driven material point."""
    law = example(LAWS[name])
    strains = [0.05, 0.025, 0.04, 0.0]
    alone = point(law, [PathLeg(strain=e) for e in strains], (0.0, HOT), AUSTENITE, 60)
    test = marched(strained(law), pull(law, alone.strain[0], *strains[1:]), 4, 60)
    assert max(alone.martensite) > 0.3
    assert max(alone.stress) > 250e6
    assert share(test["stress"], alone.stress) < 1e-9
    assert np.abs(test["martensite_fraction"] - alone.martensite).max() < 1e-9


def test_constrained_recovery_is_that_of_the_law() -> None:
    """Stretched, released until it is slack, held there and heated: stress builds up."""
    law, (far, slack, hot) = law_a(), (0.045, 0.035, 380.0)
    legs = [PathLeg(strain=far), PathLeg(strain=slack), PathLeg(strain=slack, temperature=hot)]
    alone = point(law, legs, (0.0, WARM), AUSTENITE, 200)
    zero = alone.strain[0]
    waves = {
        "drive": through([WARM, WARM, WARM, hot]),
        "command": through([0.0, far - zero, slack - zero, slack - zero]),
    }
    test = marched(strained(law), waves, 3, 200)
    assert test["stress"][400] == 0.0
    assert max(alone.stress[400:]) > 200e6
    assert share(test["stress"], alone.stress) < 1e-9


@pytest.mark.parametrize("stiffness", [math.inf, 2e4])
@pytest.mark.parametrize("preload", [0.0, 3.0])
def test_an_elastic_element_and_the_frame_are_springs_in_series(stiffness: float, preload: float) -> None:
    """F = F₀ + (u + contraction)/(c + 1/k) while positive; position is where the element ends."""
    control = TensileTestingMachine(control="elongation", preload=preload, stiffness=stiffness)
    system = machine(control, compliance=2e-4, contraction=1e-3)
    travels = through([0.0, 2e-3, -3e-3, 1e-3])
    waves = {**kelvins(system, element=0.7), "command": travels}
    run = simulate(system, waves, 3.0, step=0.1, samples=31)
    u = np.array([travels.value(t) for t in run.times])
    shorter = 1e-3 * np.minimum(0.7 * np.array(run.times), 0.7)
    forces = np.maximum(preload + (u + shorter) / (2e-4 + 1.0 / stiffness), 0.0)
    assert forces.min() == 0.0
    assert np.sum(forces == 0.0) < 20
    assert run["element.force"] == pytest.approx(forces, rel=1e-9, abs=1e-9)
    assert run["crosshead"] == pytest.approx(u, abs=1e-15)
    give = (forces - preload) / stiffness
    assert run["position"] == pytest.approx(give - u, abs=1e-12)
    taut = forces > 0.0
    own = 2e-4 * (forces - preload) - shorter
    assert np.array(run["position"])[taut] == pytest.approx(-own[taut], abs=1e-12)


def test_a_stretched_wire_goes_slack_and_is_taut_again_at_the_same_travel() -> None:
    """What martensite keeps hangs loose until the crosshead has come that far again."""
    law, strains = law_a(), (0.045, 0.0, 0.045)
    alone = point(law, [PathLeg(strain=e) for e in strains], (0.0, WARM), AUSTENITE, 100)
    zero, kept = alone.strain[0], alone.strain[200]
    waves: dict[str, AbstractWaveform] = {
        "drive": Constant(level=WARM),
        "command": through([0.0, *(e - zero for e in strains)]),
    }
    test = marched(strained(law), waves, 3, 100)
    slack = test["stress"] == 0.0
    slack[0] = False
    assert kept > 0.039
    assert share(test["stress"], alone.stress) < 1e-9
    assert not slack[:101].any()
    assert 0.5 < slack[101:].mean() < 0.95
    assert test["strain"][slack] == pytest.approx(np.full(slack.sum(), kept), abs=1e-12)
    assert test["position"][slack] == pytest.approx(-test["crosshead"][slack], abs=1e-15)
    again = slice(201, None)
    assert (slack[again] == (test["command"][again] < kept - zero)).all()


ELEMENTS = [e for e in examples("element") if getattr(e, "deflection", "large") == "large"]
"""Without coil springs of small deflection, which are linear in force as a wire is."""


@pytest.mark.parametrize("element", ELEMENTS, ids=label)
def test_every_element_follows_a_rigid_machine(element: Any) -> None:
    """Where it is taut it is exactly as long as is prescribed, also if it is not linear."""
    control = TensileTestingMachine(control="elongation", preload=0.5)
    system = rig(law_a(), control).with_parts(element=element)
    state = system.init(floats, COLD, 0.0)
    start = element.elongation(floats, state.elements[0], 0.5)
    taut = 0
    for k in range(1, 9):
        travel, temperature = 2e-3 * math.sin(0.6 * k), COLD + 2.0 * k
        state, _ = system.step(floats, state, temperature, travel, dt=0.1)
        force = element.force(state.elements[0])
        seen = system.observe(floats, state, temperature, travel)
        row = dict(zip(system.outputs(), seen, strict=True))
        assert row["force"] == pytest.approx(force, rel=1e-9)
        taut += force > 0.0
        if force > 0.0:
            length = element.elongation(floats, state.elements[0], force)
            assert length - start == pytest.approx(travel, abs=1e-12)
    assert taut > 4


# ---------------------------------------------------------------- order, runtimes


def order(system: System, late: float) -> float:
    """Observed order of the stress along a smooth pull that comes late by a share of a step."""

    def pulled(dt: float) -> Any:
        wave = Swings(level=0.02, swings=(Tone(-0.02, 1.0, -late * dt),))
        return simulate(system, {"command": wave}, 3.0, step=dt, samples=31)["stress"]

    runs = [pulled(dt) for dt in (0.02, 0.01, 0.005, 0.0025)]
    first, _, last = (np.abs(np.subtract(a, b)).mean() for a, b in itertools.pairwise(runs))
    return 0.5 * float(np.log2(first / last))


# ---------------------------------------------------------------- reports and sentences

REPORT = """time [s],temperature [degC],stress [MPa],strain [%]
0,90,0,0
2,90,200,0.3
4,91,330,1.5
6,89,120,0.8
8,90,10,0.0
"""
SCENARIO = """
[element]
kind = "wire"
material = "flexinol-90"
law = "liang-rogers"
diameter = "0.381 mm"
length = "250 mm"
initial_fraction = 0.0

[mechanism]
kind = "testing-machine"
control = "{control}"
section = "0.1140092 mm^2"
gauge_length = "250 mm"

[signals.command]
kind = "table"
file = "report.csv"
column = "{control}"

[drive]
kind = "temperature"
waveform = {{ kind = "table", file = "report.csv", column = "temperature" }}

[run]
tolerance = 1e-3
samples = 9
"""


@pytest.mark.parametrize("control", ["stress", "strain"])
def test_the_columns_of_a_report_make_a_scenario(control: str, tmp_path: Path) -> None:
    (tmp_path / "report.csv").write_text(REPORT, encoding="utf-8")
    scenario = read_scenario(SCENARIO.format(control=control), tmp_path / "pull.toml")
    run = scenario.run()
    rows = [[float(x) for x in line.split(",")] for line in REPORT.splitlines()[1:]]
    given = np.array([row[2] * 1e6 if control == "stress" else row[3] * 1e-2 for row in rows])
    found = np.array(run[control][::2])
    assert found - (found[0] if control == "strain" else 0.0) == pytest.approx(given, rel=1e-6, abs=1e-9)
    assert run["temperature"][::2] == pytest.approx([273.15 + row[1] for row in rows], rel=1e-9)
    assert run["command"][::2] == pytest.approx(given, rel=1e-12)


@pytest.mark.parametrize(("control", "name", "unit"), [("stress", "section", "m^2"), ("strain", "gauge_length", "m")])
def test_what_a_stress_or_strain_needs_is_named(control: str, name: str, unit: str) -> None:
    expected = rf'control = "{control}" needs `{name}` \[{unit.replace("^", ".")}\]; none given'
    with pytest.raises(ParameterError, match=expected):
        TensileTestingMachine(control=control)
    wrong: Any = TensileTestingMachine
    with pytest.raises(ParameterError, match="needs `control`"):
        wrong()
    with pytest.raises(ParameterError, match=r"`strains`.*`strain`"):
        TensileTestingMachine(control="strains")


def test_the_command_has_the_unit_of_its_control() -> None:
    one = actuator()
    for control, unit in (("force", "N"), ("stress", "Pa"), ("elongation", "m"), ("strain", "1")):
        made = TensileTestingMachine(control=control, section=1e-6, gauge_length=0.1)
        parts = {name: getattr(one, name) for name in ("element", "environment", "source")}
        system = System(mechanism=made, **parts)
        assert system.drives()[-1][:3] == ("command", unit, True)
        assert system.outputs()["command"].unit == unit


def test_without_a_command_it_holds_what_is_mounted() -> None:
    """A travel of zero; heating tightens the element from its preload."""
    control = TensileTestingMachine(control="elongation", preload=2.0)
    system = machine(control, compliance=1e-4)
    run = simulate(system, kelvins(system, element=0.1), 1.0, step=0.1, samples=11)
    assert run["element.force"][0] == pytest.approx(2.0, rel=1e-14)
    assert run["element.force"][-1] == pytest.approx(3.0, rel=1e-9)
    assert run["element.temperature"][-1] == pytest.approx(REST + 0.1, rel=1e-12)
