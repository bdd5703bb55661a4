"""Every registered mechanism with coordinates moves as its interface promises.

What it says at one moment is tried by `martensite.testing`; here are runs, with elastic elements
that a given temperature shortens.
"""

from __future__ import annotations

import itertools
from typing import Any

import numpy as np
import pytest
from builders import Swings, examples, label, problem_a, raised_cosine
from elastic import REST, actuator, kelvins, machine

from martensite.actuators.assembly import Group, Machine
from martensite.actuators.mechanisms.multibody import AbstractMultibody
from martensite.actuators.mechanisms.pulley import AntagonisticPulley
from martensite.base.errors import InputError, ParameterError
from martensite.kernels import floats
from martensite.kernels.namespace import Namespace, Scalar
from martensite.simulate.api import simulate
from martensite.simulate.result import Result
from martensite.testing.mechanisms import is_consistent

LIKE_OTHERS = {"hand-quasi-static-separate-given-springs", "hand-quasi-static-separate-hanging-stops"}
"""Forms of many elements whose options others of them or of the finger try."""
MULTIBODY = [m for m in examples("mechanism") if isinstance(m, AbstractMultibody) and label(m) not in LIKE_OTHERS]
PULLED = [m for m in MULTIBODY if m.ports()]
MOVING = [m for m in MULTIBODY if m.moves]
every = pytest.mark.parametrize("mechanism", MULTIBODY, ids=label)
COMPLIANCE = 5e-4
"""Of elastic elements [m/N]."""


# ---------------------------------------------------------------- runs


def seen(result: Result, mechanism: AbstractMultibody) -> np.ndarray:
    """Coordinates that can be observed, in their sizes, (samples, coordinates)."""
    known = [c for c in mechanism.coordinates() if c.name in result.columns]
    assert known
    return np.array([[q / c.size for q in result[c.name]] for c in known]).T


def run(mechanism: AbstractMultibody, drives: dict[str, Any], duration: float, step: float, **options: Any) -> Result:
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
    """All elements get longer, or half of them, as the others pull."""
    system = machine(mechanism)
    drives = {system.drive_at(p): kelvin[k % 2] for k, p in enumerate(mechanism.ports())}
    result = run(mechanism, kelvins(system, **drives), 0.3, 0.001)
    forces = np.array([result[f"{port}.force"] for port in mechanism.ports()])
    assert not result.status.failed
    assert forces.min() >= 0.0
    if max(kelvin) < 0.0:
        assert (forces[:, -1] <= mechanism.start_forces(floats)).all()
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
    ends = [seen(run(mechanism, smooth(mechanism), 0.06, dt), mechanism)[-1] for dt in (2e-4, 1e-4, 5e-5)]
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
def test_the_work_of_a_run_is_accounted_for(mechanism: AbstractMultibody, c_compiler: None) -> None:
    system = machine(mechanism, compliance=COMPLIANCE)
    result = simulate(system, smooth(mechanism), 0.06, tolerance=1e-4, runtime="c")
    assert result.work is not None and result.work.residual is not None
    assert result.work.exchanged > 0.0
    if is_consistent(mechanism):
        assert result.work.residual <= 1e-4


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
    late = Late(radius=0.01, preload=3.0, stiffness=0.01, damping=1e-3, inertia=1e-4, motion="dynamic")
    assert order(late) == pytest.approx(1.0, abs=0.3)
