"""The energy of runs is accounted for, and a leak is noticed.

What is entered comes from quadratures that share nothing with the step, so a residual measures the
step; the residuals of all examples and elements are printed (`pytest -s`).
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import pytest
from builders import SINE_A, examples, label, problem_a, raised_cosine, through, wire_a
from elastic import machine

from martensite.actuators.assembly import Machine
from martensite.actuators.mechanisms.beam_motor import BeamMotor
from martensite.actuators.mechanisms.lever import Lever
from martensite.actuators.mechanisms.load_line import BiasSpring
from martensite.actuators.mechanisms.testing_machine import TensileTestingMachine
from martensite.physics.electrical.sources import PowerSource
from martensite.physics.thermal.base import Environment
from martensite.physics.thermal.films import ConstantCooling
from martensite.scenario.running import run
from martensite.scenario.scenario import load
from martensite.signals.constant import Constant
from martensite.simulate.api import simulate
from martensite.simulate.result import Result

ROOT = Path(__file__).parents[2]
needs_c = pytest.mark.usefixtures("c_compiler")

HEATED = (
    "antagonistic_wires",
    "clamped_wire",
    "constant_power",
    "finger",
    "finger_design",
    "flexinol_staircase",
    "hand",
    "platform_spring",
    "pwm_bias_spring",
    "torsion_wire",
)
"""Examples that are runs, without a log or a bench."""
PRESCRIBED = ("isobaric", "tensile-test")
"""Likewise, of wires whose temperature is prescribed."""


def run_example(name: str) -> Result:
    found = load(ROOT / f"examples/{name}.toml").run(runtime="c", tolerance=1e-4)
    for line in found.balances():
        print(f"{name}: {line}")  # noqa: T201
    return found


@needs_c
def test_the_energy_of_every_example_is_accounted_for() -> None:
    """By quadratures that share nothing with the step."""
    worst = 0.0
    for name in (*HEATED, *PRESCRIBED):
        found = run_example(name)
        kept = (found.heat, found.work) if name in HEATED else (found.work,)
        for balance in kept:
            assert balance is not None
            if balance.residual is None:  # a wire that pulls nothing
                assert name == "flexinol_staircase" and balance is found.work
                continue
            assert balance.residual <= 1e-4
            worst = max(worst, balance.residual)
        assert not any("not accounted for" in text for text in found.warnings)
        assert len(found.unbalanced) == (name in PRESCRIBED)
    assert worst > 0.0


ELEMENTS = {label(one): one for one in examples("element")}


@needs_c
@pytest.mark.parametrize("name", ELEMENTS)
def test_the_energy_of_every_element_is_accounted_for(name: str) -> None:
    """Coils with all corrections, bundles, chains, ribbons, wires that clamps cool."""
    found = simulate(problem_a(element=ELEMENTS[name]), SINE_A, 20.0, tolerance=1e-4, runtime="c")
    for balance in (found.heat, found.work):
        print(f"{name}: {balance}")  # noqa: T201
        assert balance is not None and balance.residual is not None
        assert balance.residual <= 1e-4
    assert found.work is not None and found.work.elastic is not None


VARIABLE = {label(law): law for law in examples("law") if not law.constant_heat}


@needs_c
@pytest.mark.parametrize("name", VARIABLE)
def test_heat_that_depends_on_stress_or_temperature_is_accounted_for(name: str) -> None:
    law = VARIABLE[name]
    found = simulate(problem_a(element=wire_a(law)), SINE_A, 20.0, tolerance=1e-4, runtime="c")
    assert found.heat is not None and found.heat.residual is not None
    print(f"{name}: {found.heat}")  # noqa: T201
    assert min(found["martensite_fraction"]) < 0.5
    assert found.heat.residual <= 1e-4


@pytest.mark.parametrize("runtime", ["floats", "c"])
def test_heat_that_is_lost_on_the_way_is_noticed(runtime: str, c_compiler: None) -> None:
    """Of a wire that loses more than it is told to."""

    class Leaky(type(problem_a())):
        def entries(self, xp: Any, state: Any, *drives: Any) -> Any:
            found = super().entries(xp, state, *drives)
            found.lost = 1.01 * found.lost
            return found

    runs = [simulate(one, SINE_A, 20.0, runtime=runtime) for one in both_of(problem_a(), Leaky)]
    honest, leaks = (one.heat for one in runs)
    assert honest is not None and leaks is not None
    assert (honest.residual or 0.0) < 1e-5 < 1e-3 < (leaks.residual or 0.0)
    assert any("of the heat is not accounted for" in text for text in runs[1].warnings)
    assert not any("of the heat is not accounted for" in text for text in runs[0].warnings)


@pytest.mark.parametrize("runtime", ["floats", "c"])
def test_work_that_is_lost_on_the_way_is_noticed(runtime: str, c_compiler: None) -> None:
    """Of a spring that is softer than it says."""

    class Leaky(BiasSpring):
        def force(self, xp: Any, assembly: Any, spring: Any) -> Any:
            return 0.99 * super().force(xp, assembly, spring)

    spring = problem_a().mechanism
    soft = both_of(spring, Leaky)[1]
    runs = [simulate(problem_a(mechanism=one), SINE_A, 20.0, runtime=runtime) for one in (spring, soft)]
    honest, leaks = (one.work for one in runs)
    assert honest is not None and leaks is not None
    assert (honest.residual or 0.0) < 1e-12 < 1e-3 < (leaks.residual or 0.0)
    assert any("of the work is not accounted for" in text for text in runs[1].warnings)


def both_of(honest: Any, kind: type[Any]) -> tuple[Any, Any]:
    """A part, and one of another class with the same numbers."""
    return honest, kind(**{name: getattr(honest, name) for name in honest.declarations})


@pytest.mark.parametrize("runtime", ["floats", "c"])
def test_a_mechanism_that_does_not_say_what_it_holds_has_no_balance(runtime: str, c_compiler: None) -> None:
    class Silent(BiasSpring):
        def energy(self, xp: Any, shortening: Any) -> Any:
            return None

    silent = both_of(problem_a().mechanism, Silent)[1]
    found = simulate(problem_a(mechanism=silent), SINE_A, 5.0, runtime=runtime)
    assert found.work is None and found.heat is not None
    (words,) = found.unbalanced
    assert words == "work: not balanced, since `bias-spring` does not say what it holds"
    assert words in str(found)


@pytest.mark.parametrize("runtime", ["floats", "c"])
def test_the_heat_of_a_superelastic_cycle_that_closes_is_balanced(runtime: str, c_compiler: None) -> None:
    """Stretched and let go without a drive: all that is stored and lost comes back, and every sum of it cancels."""
    rig = problem_a(
        element=wire_a(initial_fraction=0.0),
        mechanism=TensileTestingMachine(control="strain", gauge_length=0.25),
        source=PowerSource(),
        environment=Environment(temperature=365.0, cooling=ConstantCooling(h=100.0)),
    )
    strain = through([0.0, 0.03, *[0.0] * 9], 5.0)
    found = simulate(rig, {"drive": Constant(level=0.0), "command": strain}, 50.0, runtime=runtime)
    assert max(found["martensite_fraction"]) > 0.5
    assert found.heat is not None and abs(found.heat.stored) < 1e-4 * found.heat.exchanged
    assert found.heat.residual is not None and found.heat.residual < 1e-4
    assert not any("not accounted for" in text for text in found.warnings)


@pytest.mark.parametrize("runtime", ["floats", "c"])
def test_the_work_of_a_free_oscillation_is_balanced(runtime: str, c_compiler: None) -> None:
    """Two periods of a beam that nothing damps: the energy swings between spring and mass and ends where it began."""
    still = dict.fromkeys(("damping", "unbalance", "eccentricity", "torque_constant", "back_emf"), 0.0)
    rest: dict[str, Any] = still | {"rotor_inertia": 1e-4, "resistance": 6.0, "inductance": 3e-3}
    beam = BeamMotor(mass=0.2, stiffness=500.0, **rest)
    periods = 4.0 * math.pi * math.sqrt(0.2 / 500.0)
    drive, start = {"motor": Constant(level=0.0)}, {"displacement": 0.01}
    found = run(Machine(mechanism=beam), drive, periods, samples=101, runtime=runtime, initial=start)
    assert found.work is not None and found.work.residual is not None
    assert found.work.exchanged == pytest.approx(8 * 0.5 * 500.0 * 0.01**2, rel=0.01)
    assert abs(found.work.springs) < 1e-2 * found.work.exchanged and found.work.residual < 1e-4
    assert not any("not accounted for" in text for text in found.warnings)


def test_both_runtimes_keep_the_same_ledger(c_compiler: None) -> None:
    floats, c = (simulate(problem_a(), SINE_A, 20.0, runtime=runtime) for runtime in ("floats", "c"))
    for name in ("heat", "work"):
        one, other = (getattr(run, name).as_dict() for run in (floats, c))
        del one["residual"], other["residual"]
        assert one.pop("exchanged") == pytest.approx(other.pop("exchanged"), rel=1e-2)  # no turns within steps
        assert one == pytest.approx(other, rel=1e-4, abs=1e-9)


def test_runs_on_given_steps_have_no_balance() -> None:
    found = simulate(problem_a(), SINE_A, 1.0, step=0.01, runtime="floats")
    assert found.heat is None and found.work is None and found.unbalanced == []


# ---------------------------------------------------------------- slack, and multibody mechanisms


@pytest.mark.parametrize("runtime", ["floats", "c"])
def test_the_work_of_a_wire_that_hangs_slack_for_a_while_is_accounted_for(runtime: str, c_compiler: None) -> None:
    """A slack element has an end of its own, which does no work."""
    system = machine(BiasSpring(stiffness=500.0, preload=2.0), compliance=5e-4)
    longer = raised_cosine(-20.0, 0.1, 300.0)
    found = simulate(system, {"element": longer}, 0.2, tolerance=1e-4, runtime=runtime)
    assert min(found["element.force"]) == 0.0
    assert found.work is not None and found.work.residual is not None
    assert found.work.residual < 1e-12


class WrongLever(Lever):
    """A lever whose springs hold less than they do."""

    def energy(self, xp: Any, motion: Any) -> Any:
        held = super().energy(xp, motion)
        return held._replace(springs=0.7 * held.springs)


def test_a_mechanism_that_says_the_wrong_thing_is_noticed(c_compiler: None) -> None:
    """It has no more friction than it says, but a residual."""
    lever = next(one for one in examples("mechanism") if type(one) is Lever and one.moves)
    for one, wrong in zip(both_of(lever, WrongLever), (False, True), strict=True):
        system = machine(one, compliance=5e-4)
        drives = {"element": raised_cosine(1.0, 0.1, 300.0)}
        found = simulate(system, drives, 0.06, tolerance=1e-4, runtime="c")
        assert found.work is not None and found.work.residual is not None
        assert (found.work.residual > 1e-2) == wrong
        assert any("of the work is not" in text for text in found.warnings) == wrong
