"""Every registered mechanism with coordinates keeps the promises of its interface.

Sources of truth: differences of what it says itself, mechanics (an energy behind every force at
rest, an inertia that is positive and keeps its energy, damping that takes some), and runs with
elastic elements that a given temperature shortens.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from builders import Swings, examples, label, problem_a, raised_cosine
from elastic import REST, actuator, kelvins, machine

from martensite.errors import InputError, ParameterError
from martensite.mechanisms.base import Column
from martensite.mechanisms.hand import Hand
from martensite.mechanisms.multibody import AbstractMultibody
from martensite.mechanisms.pulley import AntagonisticPulley
from martensite.mechanisms.shared.motion import Motion
from martensite.runtimes import floats
from martensite.runtimes.dual import jacobian
from martensite.runtimes.namespace import Namespace, Scalar
from martensite.simulate.api import simulate
from martensite.simulate.result import Result
from martensite.system import Group, Machine

MULTIBODY = [m for m in examples("mechanism") if isinstance(m, AbstractMultibody)]
PULLED = [m for m in MULTIBODY if m.ports()]
MOVING = [m for m in MULTIBODY if m.moves]
every = pytest.mark.parametrize("mechanism", MULTIBODY, ids=label)
Numbers = tuple[float, ...]
COMPLIANCE = 5e-4
"""Of elastic elements [m/N]."""


def consistent(mechanism: AbstractMultibody) -> bool:
    """False for what is kept for comparison though it is known to be wrong."""
    return getattr(mechanism, "coupling", "lagrange") == "lagrange"


def places(mechanism: AbstractMultibody, share: float = 0.2) -> list[Numbers]:
    """Some positions near home."""
    rng = np.random.default_rng(3)
    sizes = np.array([c.size for c in mechanism.coordinates()])
    home = np.array(mechanism.home(floats))
    return [tuple(home + share * sizes * rng.uniform(-1, 1, len(sizes))) for _ in range(4)]


def rates(mechanism: AbstractMultibody) -> list[Numbers]:
    """Some velocities."""
    sizes = [c.size for c in mechanism.coordinates()]
    return [tuple(s * math.sin(1 + i + 3 * k) for k, s in enumerate(sizes)) for i in range(4)]


def demanded(mechanism: AbstractMultibody, *motion: Column) -> np.ndarray:
    """Demand for position, velocity, acceleration (zero if not given), without signals."""
    rest = (0.0,) * len(mechanism.coordinates())
    numbers = (tuple(motion[k]) if k < len(motion) else rest for k in range(3))
    signals = [0.0] * len(mechanism.signals())
    return np.array(mechanism.demand(floats, Motion(*numbers), signals))


def inertia(mechanism: AbstractMultibody, position: Column) -> np.ndarray:
    """Slope of the demand in the acceleration."""
    rest = demanded(mechanism, position)
    still, unit = [0.0] * len(rest), np.eye(len(rest)).tolist()
    return np.array([demanded(mechanism, position, still, e) - rest for e in unit]).T


# ---------------------------------------------------------------- what it says at one moment


def starts_in_equilibrium(mechanism: AbstractMultibody) -> None:
    """At home under the start forces nothing is missing."""
    home, forces = mechanism.home(floats), mechanism.start_forces(floats)
    supplied = mechanism.supply(floats, home, forces, [0.0] * len(home))
    assert min(forces, default=0.0) >= 0.0
    assert demanded(mechanism, home) == pytest.approx(supplied, rel=1e-9, abs=1e-15)


def lever_is_a_slope(mechanism: AbstractMultibody) -> None:
    """The Jacobian by dual numbers is that by differences."""
    for place in places(mechanism):
        paths, exact = jacobian(floats, mechanism.contraction, place)
        assert paths == mechanism.contraction(floats, place)
        for k, coordinate in enumerate(mechanism.coordinates()):
            h = 1e-5 * coordinate.size
            moved = ([*place[:k], place[k] + s * h, *place[k + 1 :]] for s in (1.0, -1.0))
            up, down = (np.array(mechanism.contraction(floats, q)) for q in moved)
            slopes = np.array([row[k] for row in exact])
            assert slopes == pytest.approx((up - down) / (2.0 * h), rel=1e-7, abs=1e-9)


def rests_on_an_energy(mechanism: AbstractMultibody) -> None:
    """At rest ∂D_i/∂q_k is symmetric: what is put in on any way round comes out again."""

    def held(xp: Namespace, position: Column) -> Column:
        rest = (0.0,) * len(position)
        signals = [0.0] * len(mechanism.signals())
        return mechanism.demand(xp, Motion(tuple(position), rest, rest), signals)

    for place in places(mechanism):
        stiffness = np.array(jacobian(floats, held, place)[1])
        assert stiffness == pytest.approx(stiffness.T, abs=1e-12 * np.abs(stiffness).max())


def inertia_is_positive(mechanism: AbstractMultibody) -> None:
    """Whatever accelerates needs a force; and inertia is symmetric. None where it is left out."""
    if not mechanism.moves and not inertia(mechanism, places(mechanism)[0]).any():
        return
    for place in places(mechanism):
        found = inertia(mechanism, place)
        assert np.linalg.eigvalsh(found + found.T).min() > 0.0
        if consistent(mechanism):
            assert found == pytest.approx(found.T, abs=1e-12 * np.abs(found).max())


def motion_keeps_its_energy(mechanism: AbstractMultibody) -> None:
    """Of what depends on velocity, the even part moves energy only: v·c = ½ v·(dM/dt) v."""
    if not consistent(mechanism):
        return
    for place, rate in zip(places(mechanism), rates(mechanism), strict=True):
        back = [-v for v in rate]
        both = demanded(mechanism, place, rate) + demanded(mechanism, place, back)
        even = 0.5 * both - demanded(mechanism, place)
        ahead, behind = (
            inertia(mechanism, [q + s * v for q, v in zip(place, rate, strict=True)])
            for s in (1e-5, -1e-5)
        )
        change = (ahead - behind) / 2e-5
        v = np.array(rate)
        size = np.abs(v) @ np.abs(inertia(mechanism, place)) @ np.abs(v)
        rounding = np.abs(v) @ np.abs(demanded(mechanism, place))
        allowed = 1e-8 * size + 1e-12 * rounding
        assert v @ even == pytest.approx(0.5 * v @ change @ v, abs=float(allowed))


def damping_takes_energy(mechanism: AbstractMultibody) -> None:
    """The odd part of what depends on velocity resists it."""
    for place, rate in zip(places(mechanism), rates(mechanism), strict=True):
        back = [-v for v in rate]
        odd = 0.5 * (demanded(mechanism, place, rate) - demanded(mechanism, place, back))
        assert np.array(rate) @ odd > 0.0


def power_is_accounted_for(mechanism: AbstractMultibody) -> None:
    """What a motion demands changes its energy, is dissipated, or comes from outside."""
    if not consistent(mechanism):
        return
    signals = [3.0 + k for k in range(len(mechanism.signals()))]
    near_and_far = [*places(mechanism), *places(mechanism, 3.3)]  # beyond end stops as well
    for place, rate in zip(near_and_far, 2 * rates(mechanism), strict=True):
        gain = [1.7 * v + 0.3 * c.size for v, c in zip(rate, mechanism.coordinates(), strict=True)]
        gain = gain if mechanism.moves else [0.0] * len(rate)
        motion = Motion(place, rate, tuple(gain))
        taken = np.array(mechanism.dissipative(floats, motion))
        given = np.array(mechanism.imposed(floats, motion, signals))
        needs = np.array(mechanism.demand(floats, motion, signals))
        change = rate_of_energy(mechanism, motion)
        size = float(np.abs(rate) @ np.abs(needs))
        assert np.array(rate) @ (needs - taken + given) == pytest.approx(change, abs=1e-9 * size)
        assert np.array(rate) @ taken >= 0.0


def rate_of_energy(mechanism: AbstractMultibody, motion: Motion) -> float:
    """Change of what it holds [W]; without inertia, kinetic energy does not count."""

    def held(xp: Namespace, time: Column) -> Column:
        (q, v, a), (t,) = motion, time
        place = tuple(x + t * (y + 0.5 * t * z) for x, y, z in zip(q, v, a, strict=True))
        speed = tuple(y + t * z for y, z in zip(v, a, strict=True))
        energy = mechanism.energy(xp, Motion(place, speed, a))
        assert energy is not None
        kinetic = energy.kinetic if mechanism.moves else 0.0
        return [energy.springs + energy.gravity + energy.magnetic + kinetic]

    return float(jacobian(floats, held, [0.0])[1][0][0])


CHECKS: list[Callable[[AbstractMultibody], None]] = [
    starts_in_equilibrium, lever_is_a_slope, rests_on_an_energy, inertia_is_positive,
    motion_keeps_its_energy, damping_takes_energy, power_is_accounted_for,
]  # fmt: skip


@pytest.mark.parametrize("check", CHECKS, ids=lambda check: check.__name__)
@every
def test_mechanics(mechanism: AbstractMultibody, check: Callable[..., None]) -> None:
    check(mechanism)


@every
def test_it_says_what_it_has(mechanism: AbstractMultibody) -> None:
    coordinates, ports = mechanism.coordinates(), mechanism.ports()
    home = mechanism.home(floats)
    rest = Motion(tuple(home), (0.0,) * len(home), (0.0,) * len(home))
    assert len(home) == len(coordinates) == len({c.name for c in coordinates})
    assert len(mechanism.contraction(floats, home)) == len(ports) == len(set(ports))
    assert len(mechanism.start_forces(floats)) == len(mechanism.transmission(floats, rest))
    assert mechanism.contraction(floats, home) == pytest.approx([0.0] * len(ports), abs=1e-15)
    assert set(mechanism.judged()) <= set(mechanism.outputs())
    assert all(c.size > 0.0 for c in coordinates)
    assert not any("." in name for name in (*ports, *mechanism.outputs(), *mechanism.signals()))


# ---------------------------------------------------------------- runs


def seen(result: Result, mechanism: AbstractMultibody) -> np.ndarray:
    """Coordinates that can be observed, in their sizes, (samples, coordinates)."""
    known = [c for c in mechanism.coordinates() if c.name in result.columns]
    assert known
    return np.array([[q / c.size for q in result[c.name]] for c in known]).T


def run(mechanism: AbstractMultibody, drives: dict[str, Any], duration: float, step: float,
        **options: Any) -> Result:  # fmt: skip
    """A machine of elastic elements."""
    system = machine(mechanism, compliance=COMPLIANCE)
    return simulate(system, drives, duration, step=step, samples=11, **options)


@every
def test_without_power_it_stays_at_home(mechanism: AbstractMultibody) -> None:
    drives = kelvins(machine(mechanism))
    moved = seen(run(mechanism, drives, 0.2, 0.002), mechanism)
    assert np.abs(moved - moved[0]).max() < 1e-9


@pytest.mark.parametrize("kelvin", [(-250.0, -250.0), (100.0, -200.0)], ids=["all", "half"])
@pytest.mark.parametrize("mechanism", PULLED, ids=label)
def test_no_element_pushes(mechanism: AbstractMultibody, kelvin: tuple[float, float]) -> None:
    """All elements get longer, until they hang slack; or half of them, as the others pull."""
    system = machine(mechanism)
    drives = {system.drive_at(p): kelvin[k % 2] for k, p in enumerate(mechanism.ports())}
    result = run(mechanism, kelvins(system, **drives), 0.3, 0.001)
    forces = np.array([result[f"{port}.force"] for port in mechanism.ports()])
    assert not result.status.failed
    assert forces.min() >= 0.0
    if max(kelvin) < 0.0:
        assert forces[:, -1].tolist() == [0.0] * len(mechanism.ports())
    else:
        assert forces[::2].max() > max(mechanism.start_forces(floats))


def wave(high: float, rest: float = REST) -> Swings:
    """Smooth at the start: half of one minus a cosine, over 0.1 s."""
    return raised_cosine(high, 0.1, rest)


def smooth(mechanism: AbstractMultibody) -> dict[str, Any]:
    """Drives without a kink that move everything and leave every element taut."""
    system = machine(mechanism)
    elements = {p: wave(1.0 if k % 2 == 0 else 0.0) for k, p in enumerate(mechanism.ports())}
    return {system.drive_at(p): w for p, w in elements.items()} | {
        name: wave(1.0, rest=0.0) for name in mechanism.signals()
    }


def order(mechanism: AbstractMultibody) -> float:
    """Observed order of the coordinates at the end of a run."""
    ends = [seen(run(mechanism, smooth(mechanism), 0.06, dt), mechanism)[-1]
            for dt in (2e-4, 1e-4, 5e-5)]  # fmt: skip
    first, second = (np.abs(b - a).max() for a, b in itertools.pairwise(ends))
    assert np.abs(ends[-1]).max() > 1e-3
    return float(np.log2(first / second))


@pytest.mark.parametrize("mechanism", MOVING, ids=label)
def test_halving_the_step_quarters_the_error(mechanism: AbstractMultibody) -> None:
    assert order(mechanism) == pytest.approx(2.0, abs=0.2)


@every
def test_a_run_to_a_tolerance_says_how_accurate_it_is(mechanism: AbstractMultibody) -> None:
    system = machine(mechanism, compliance=COMPLIANCE)
    result = simulate(system, smooth(mechanism), 0.06, tolerance=1e-2, samples=7)
    assert result.accuracy is not None
    assert 0.0 <= result.accuracy <= 1e-2
    assert not result.status.failed
    assert np.abs(np.ptp(seen(result, mechanism), axis=0)).max() > 1e-3


@every
@pytest.mark.parametrize("tolerance", [1e-3, 1e-4])
def test_the_work_of_a_run_is_accounted_for(
    mechanism: AbstractMultibody, tolerance: float, c_compiler: None
) -> None:
    system = machine(mechanism, compliance=COMPLIANCE)
    result = simulate(system, smooth(mechanism), 0.06, tolerance=tolerance, runtime="c")
    assert result.work is not None and result.work.residual is not None
    assert result.work.exchanged > 0.0
    print(f"{label(mechanism)}: {result.work}")  # noqa: T201
    if consistent(mechanism):
        assert result.work.residual <= tolerance


# ---------------------------------------------------------------- sentences


def pulley() -> AntagonisticPulley:
    return AntagonisticPulley(radius=0.01, preload=1.0)


def test_an_unknown_port_is_named_with_the_nearest() -> None:
    members = {"protagonist": actuator(), "antagonits": actuator()}
    with pytest.raises(ParameterError, match=r"no port `antagonits`.*`antagonist`"):
        Machine(mechanism=pulley(), group=Group(**members))


def test_a_missing_actuator_is_named() -> None:
    with pytest.raises(ParameterError, match="none given for antagonist"):
        Machine(mechanism=pulley(), group=Group(protagonist=actuator()))


def test_a_system_is_of_one_element() -> None:
    with pytest.raises(ParameterError, match=r"takes 2 elements .* use `Machine`"):
        problem_a(mechanism=pulley())


def test_a_waveform_needs_a_name_where_there_are_several_drives() -> None:
    with pytest.raises(InputError, match="has 2 drives"):
        simulate(machine(pulley()), wave(1.0), 1.0, step=0.1)
    with pytest.raises(InputError, match=r"`protagonists`.*`protagonist`"):
        simulate(machine(pulley()), {"protagonists": wave(1.0)}, 1.0, step=0.1)


def test_what_is_no_actuator_is_refused() -> None:
    wrong: Any = 3.0
    with pytest.raises(ParameterError, match="must be an `Actuator`"):
        Group(protagonist=wrong)


def test_machines_of_other_numbers_share_a_program_and_of_other_parts_do_not() -> None:
    """The numbers of actuators are parameters of a machine like all others."""
    one, other = (machine(pulley(), compliance=c) for c in (1e-3, 2e-3))
    paths = [leaf.path for leaf in one.leaves()]
    assert "group.protagonist.element.compliance" in paths
    assert one.value_of("antagonist.element.compliance") == 1e-3
    drives = kelvins(one, protagonist=5.0)
    angles = [simulate(m, drives, 2.0, step=0.5, samples=5)["angle"][-1] for m in (one, other)]
    assert angles[0] == pytest.approx(angles[1], rel=1e-12)  # closed form: x/(2 r)
    stiffer = one.with_values({"antagonist.element.compliance": 1e-4})
    assert simulate(stiffer, drives, 2.0, step=0.5, samples=5)["angle"][-1] < 0.2 * angles[0]


# ---------------------------------------------------------------- the checks can fail


class Broken(AbstractMultibody):
    """Two angles, and everything wrong. Deliberately not registered."""

    def ports(self) -> tuple[str, ...]:
        return ("a", "b")

    def coordinates(self) -> Any:
        return Hand(offset=1.0, bracket=1.0, knuckle=1.0, preload=1.0).coordinates()[:2]

    def contraction(self, xp: Namespace, position: Column) -> Column:
        first, second = position
        return [first * xp.detach(first), second]  # a path whose slope is hidden

    def demand(self, xp: Namespace, motion: Motion, signals: Column) -> Column:
        (q, p), (v, w), (a, b) = motion
        grows: Scalar = q * (w * w + v * v)
        return [0.3 + p - v + a + 2.0 * b + grows, -p - w + 2.0 * a + b + grows]

    def start_forces(self, xp: Namespace) -> Column:
        return [0.0, 0.0]


@pytest.mark.parametrize("check", CHECKS, ids=lambda check: check.__name__)
def test_a_broken_mechanism_is_noticed(check: Callable[..., None]) -> None:
    with pytest.raises(AssertionError):
        check(Broken())


class Late(AntagonisticPulley):
    """Moves with a damping that is taken from the beginning of the step."""

    motion: str = "dynamic"

    def scheme(self, xp: Namespace, course: Any, dt: Scalar) -> Any:
        """Implicit Euler instead of generalised-α."""

        def after(position: Any) -> Any:
            rows = zip(position, course.position, course.velocity, strict=True)
            velocity = [(q - q0) * (1.0 / dt) for q, q0, _ in rows]
            rows = zip(velocity, course.velocity, strict=True)
            acceleration = tuple((v - v0) * (1.0 / dt) for v, v0 in rows)
            return type(course)(position, tuple(velocity), acceleration, acceleration)

        return after


def test_a_first_order_scheme_is_noticed() -> None:
    late = Late(
        radius=0.01, preload=3.0, stiffness=0.01, damping=1e-3, inertia=1e-4, motion="dynamic"
    )
    assert order(late) == pytest.approx(1.0, abs=0.3)
