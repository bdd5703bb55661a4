"""Kernels are straight-line: every one traces, and one that branches on a value is refused."""

import builders
import pytest
from builders import REGISTRIES, SINE_A, example_system
from kernels import KERNELS, traced, xp_methods

from martensite.actuators.mechanisms.load_line import BiasSpring
from martensite.physics.laws.strip_laws import LiangRogers
from martensite.physics.thermal.films import ConstantCooling
from martensite.simulate.api import simulate
from martensite.simulate.compiled import compile_march

CLASSES = [cls for kind in ("law", "cooling", "element", "mechanism", "drive") for cls in builders.registered(kind)]


@pytest.mark.parametrize("cls", CLASSES, ids=lambda cls: cls.registered_name)
def test_every_part_traces_in_a_system(cls):
    thing = builders.variants(cls)[0]
    system = example_system(thing)
    assert thing in list(system.tree())
    functions = set(compile_march(system).program.functions)
    usual = ["init", "step", "solve", "ripple", "observe", "judge", "points", "forks", "flows", "entries"]
    higher = ["rosenbrock"] * system.exchanges() + ["surface", "events"] * system.has_surface()
    assert functions == {*usual, *higher}


@pytest.mark.parametrize("kind", KERNELS)
def test_every_method_with_a_namespace_is_covered(kind):
    """Run all kernels of a kind on recording subclasses and compare with the methods there are."""
    for cls in builders.registered(kind):
        called: set[str] = set()
        recorded = type(cls.__name__, (cls,), {n: recording(cls, n, called) for n in xp_methods(cls)})
        for thing in builders.variants(cls):
            twin = recorded(**{name: getattr(thing, name) for name in cls.declarations})
            for kernel in KERNELS[kind].values():
                traced(twin, kernel)
            if called == xp_methods(cls):
                break
        assert called == xp_methods(cls)


def recording(cls, name, called):
    """The method, noting that it was called."""
    original = getattr(cls, name)

    def method(self, xp, *inputs):
        called.add(name)
        return original(self, xp, *inputs)

    return method


def test_all_kinds_are_looked_at():
    assert set(KERNELS) | {"waveform"} == set(REGISTRIES)


# ---------------------------------------------------------------- the check can fail


class Branching(ConstantCooling):
    """Decides by a value."""

    def film(self, xp, temperature, ambient, shape):
        return self.h if temperature > ambient else 0.0


class Both(ConstantCooling):
    """Uses `and` between comparisons."""

    def film(self, xp, temperature, ambient, shape):
        warm = temperature > ambient and temperature < 400.0
        return xp.where(warm, self.h, 0.0)


class Builtin(ConstantCooling):
    """Uses the built-in max, which compares and decides."""

    def film(self, xp, temperature, ambient, shape):
        return max(self.h * (temperature - ambient), 1.0)


@pytest.mark.parametrize("cls", [Branching, Both, Builtin])
def test_a_kernel_that_branches_is_refused(cls):
    with pytest.raises(TypeError, match="must not branch on a value"):
        traced(cls(h=10.0), KERNELS["cooling"]["film"])


class Slack(BiasSpring):
    """A mechanism with a branch."""

    def force(self, xp, assembly, spring):
        force = super().force(xp, assembly, spring)
        return force if force > 0.1 else 0.0


class Loop(LiangRogers):
    """A law with a loop that ends by a value."""

    def follow(self, xp, move, stress, temperature, dt):
        while temperature > self.A_f:
            temperature = temperature - 1.0
        return super().follow(xp, move, stress, temperature, dt)


@pytest.mark.parametrize("thing", [Slack(stiffness=1000.0), builders.example(Loop)], ids=["mechanism", "law"])
def test_a_system_with_a_branching_part_is_refused(thing):
    with pytest.raises(TypeError, match="must not branch on a value"):
        simulate(example_system(thing), SINE_A, 1.0, step=0.1)
