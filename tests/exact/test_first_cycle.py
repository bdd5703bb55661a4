"""Where a trained wire starts, under every law: where its cycles end, or the run says that the first one drifts.

Source of truth: the second cycle of the same run, and the cosine of Brinson's diagram for what forms under a load.
"""

import math

import pytest
from builders import chamber, example, through

from martensite.actuators.elements.wire import Wire
from martensite.actuators.mechanisms.load_line import BiasSpring
from martensite.physics.laws.base import LAWS
from martensite.simulate.api import simulate

MPA = 1e6
SECTION = 0.25 * math.pi * 0.381e-3**2
CLOSED = ("elahinia", "lagoudas", "liang-rogers", "mas", "mas-hybrid", "mas-polycrystal", "tanaka")
"""Laws under which all martensite that forms under a load is oriented as the trained wire was."""


def run_cycles(system):
    """Two cycles of temperature in a chamber, at the ends of which the last column is sampled."""
    found = simulate(system, through([240.0, 500.0, 240.0, 500.0, 240.0], 100.0), 400.0, samples=401, runtime="c")
    return found, [found["strain"][k] for k in (0, 200, 400)], [found["oriented_fraction"][k] for k in (0, 200, 400)]


@pytest.mark.parametrize("name", CLOSED)
def test_a_trained_wire_starts_where_its_cycles_end(name):
    system = chamber(example(LAWS[name]), mass=50 * MPA * SECTION / 9.80665)
    found, strain, _ = run_cycles(system)
    assert strain[:2] == pytest.approx([strain[2]] * 2, abs=1e-6)
    assert found["strain"].min() < strain[0] - 0.01
    assert [one.kind for one in found.alarms] == []


@pytest.mark.parametrize("stress", [5 * MPA, 50 * MPA, 120 * MPA, 200 * MPA])
def test_brinson_loses_what_the_load_does_not_orient_and_says_so(stress):
    """Cooled under σ, the share sin²(π/2 · (σ - σ_s)/(σ_f - σ_s)) is detwinned; the rest of the start is lost."""
    law = example(LAWS["brinson"])
    found, _, oriented = run_cycles(chamber(law, mass=stress * SECTION / 9.80665))
    way = min(max((stress - law.sigma_s) / (law.sigma_f - law.sigma_s), 0.0), 1.0)
    assert oriented == pytest.approx([1.0, *[math.sin(0.5 * math.pi * way) ** 2] * 2], abs=1e-9)
    assert [one.kind for one in found.alarms] == (["drift"] if way < 1.0 else [])


@pytest.mark.parametrize("preload", [0.0, 20 * MPA])
def test_a_first_cycle_against_a_spring_is_judged_too(preload):
    """A wire that stays longer lets go of its spring: no stress is that of the start, because of the drift."""
    system = chamber(example(LAWS["brinson"]), mass=1.0)
    wire = system.element
    assert isinstance(wire, Wire)
    stiffness = 100 * MPA * SECTION / (0.05 * wire.length)
    spring = BiasSpring(stiffness=stiffness, preload=preload * SECTION)
    found, strain, oriented = run_cycles(system.with_parts(mechanism=spring))
    assert strain[0] > 3.0 * strain[1] and oriented[1] == pytest.approx(oriented[2], abs=1e-4)
    (drift,) = found.alarms
    assert drift.kind == "drift" and drift.worst == pytest.approx(oriented[1], abs=0.02)
    assert drift.sentence in found.warnings
