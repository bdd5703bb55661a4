"""What mechanisms say they hold: its slope is the force that they demand, and nothing leaks."""

import builders
import numpy as np
import pytest
from builders import label, problem_a

from martensite.elements.base import Spring
from martensite.mechanisms.base import Energy
from martensite.mechanisms.beam_motor import BeamMotor
from martensite.mechanisms.bias_spring import BiasSpring
from martensite.mechanisms.load_line import AbstractLoadLine, Assembly
from martensite.mechanisms.multibody import AbstractMultibody
from martensite.mechanisms.shared.motion import Motion
from martensite.runtimes import floats
from martensite.runtimes.dual import jacobian
from martensite.signals.constant import Constant
from martensite.simulate.api import simulate

MULTIBODIES = [m for m in builders.examples("mechanism") if isinstance(m, AbstractMultibody)]
LOAD_LINES = [m for m in builders.examples("mechanism") if isinstance(m, AbstractLoadLine)]
SILENT = {"printed"}
"""Couplings of a beam that conserve nothing."""


def somewhere(mechanism, seed):
    """A motion, beyond the stops now and then."""
    rng = np.random.default_rng(seed)
    sizes = np.array([c.size for c in mechanism.coordinates()])
    home = np.array(mechanism.home(floats))
    place, rate, change = (sizes * rng.uniform(-1.0, 1.0, (3, len(sizes)))).tolist()
    return Motion(tuple(home + 0.9 * np.array(place)), tuple(rate), tuple(change))


@pytest.mark.parametrize("mechanism", MULTIBODIES, ids=label)
def test_the_slope_of_the_potential_is_the_force_that_holds(mechanism):
    if getattr(mechanism, "coupling", "") in SILENT:
        assert mechanism.potential(floats, mechanism.home(floats)) is None
        return
    signals = [0.0] * len(mechanism.signals())
    for seed in range(8):
        motion = somewhere(mechanism, seed)
        rest = (0.0,) * len(motion.position)
        held = mechanism.demand(floats, Motion(motion.position, rest, rest), signals)
        _, (springs, gravity) = jacobian(floats, mechanism.potential, motion.position)
        found = np.add(springs, gravity)
        assert found == pytest.approx(held, rel=1e-9, abs=1e-9 * np.abs(held).max())


@pytest.mark.parametrize("mechanism", [m for m in MULTIBODIES if m.moves], ids=label)
def test_what_is_spent_is_spent_by_the_rate(mechanism):
    """Reversed rates cost as much, and none costs nothing; there are no motors without voltage."""
    if getattr(mechanism, "coupling", "") in SILENT:
        return
    if isinstance(mechanism, BeamMotor):
        mechanism = mechanism.with_values({"back_emf": mechanism.torque_constant})
    signals = [0.0] * len(mechanism.signals())
    for seed in range(4):
        motion = somewhere(mechanism, seed)
        there = motion._replace(acceleration=(0.0,) * len(motion.position))
        back = there._replace(velocity=tuple(-v for v in there.velocity))
        spent = []
        for one in (there, back):
            power = float(np.dot(mechanism.demand(floats, one, signals), one.velocity))
            spent.append(power - mechanism.gain(floats, one))
        size = np.abs(spent).max() + 1e-12
        assert spent[0] == pytest.approx(spent[1], abs=1e-6 * size)
        assert spent[0] >= -1e-9


@pytest.mark.parametrize("count", ["1", "3"])
def test_the_energy_of_a_beam_is_that_of_its_equations(count):
    motor = next(
        m for m in MULTIBODIES
        if isinstance(m, BeamMotor) and (m.modes, m.wire, m.coupling) == (count, "none", "lagrange")
    )  # fmt: skip
    for seed in range(4):
        motion = somewhere(motor, seed)
        held = motor.potential(floats, motion.position)
        assert held is not None
        whole = sum(held) + motor.kinetic(floats, motion)
        assert whole == pytest.approx(motor.total_energy(floats, motion), rel=1e-12)


@pytest.mark.parametrize("mechanism", LOAD_LINES, ids=label)
def test_a_load_line_holds_what_is_done_on_it(mechanism):
    """While an element of some compliance gets shorter."""
    assembly, compliance = Assembly(1e-3), 1e-3

    def at(free):
        spring = Spring(free, compliance)
        force = mechanism.force(floats, assembly, spring)
        long = free + compliance * force
        held = mechanism.energy_at(floats, force, mechanism.position(floats, assembly, force, long))
        return force, long, held.springs + held.gravity

    (f0, e0, h0), (f1, e1, h1) = at(0.5e-3), at(0.2e-3)
    assert f0 > 0.0
    assert h1 - h0 == pytest.approx(0.5 * (f0 + f1) * (e0 - e1), rel=1e-12)


# ---------------------------------------------------------------- the check can fail


class Leaky(BiasSpring):
    """A spring that says it holds 1 % less than it does."""

    def energy_at(self, xp, force, position):
        return Energy(0.99 * super().energy_at(xp, force, position).springs, 0.0, 0.0, 0.0)


@pytest.mark.parametrize("runtime", ["floats", "c"])
def test_work_that_is_lost_on_the_way_is_noticed(runtime, c_compiler):
    for cls, leaks in ((BiasSpring, False), (Leaky, True)):
        system = problem_a(mechanism=cls(stiffness=1000.0, preload=5.0))
        found = simulate(system, Constant(level=2.2), 8.0, runtime=runtime, samples=41)
        assert found.work is not None
        assert found.work.by_elements > 1e-3
        assert (found.work.residual > 1e-3) == leaks
        assert any("of the mechanical work is not" in text for text in found.warnings) == leaks
