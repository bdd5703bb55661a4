"""What touches pushes and does not pull: closed forms of a finger, all subsets of constraints, and sentences.

Sources of truth: the balance of moments about the hinge, the angle of a tangent to a circle, enumeration of every set
of constraints, and differences of runs.
"""

from __future__ import annotations

import itertools
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from command import Command
from elastic import kelvins, machine
from finger import finger, finger_law, joint, trapezoid

from martensite.actuators.mechanics.complementarity import Constraints, meet_constraints
from martensite.actuators.mechanisms.finger import Finger
from martensite.actuators.mechanisms.hand import Hand
from martensite.base.errors import ParameterError
from martensite.kernels import floats
from martensite.simulate.api import simulate
from martensite.simulate.batch import compute_sensitivity

CYLINDER: dict[str, Any] = {"contact": "cylinder", "cylinder_along": 0.025, "cylinder_inwards": 0.03}
EXAMPLE = Path(__file__).parents[2] / "examples" / "finger.toml"


def test_a_finger_grips_at_the_tangent_without_chatter() -> None:
    """Angle and place of the tangent, moments about the hinge; one grip has one touch and one release."""
    system = finger(finger_law("mas-hybrid"), **CYLINDER, weight="given", tilt=-0.4)
    run = simulate(system, trapezoid(), 25.0, samples=501, tolerance=1e-3)
    force, gap, angle = (np.array(run[name]) for name in ("contact_force", "gap", "angle"))
    far, reach = math.hypot(0.025, 0.03), 0.015 + 0.005
    touching = math.atan2(0.03, 0.025) - math.asin(reach / far)
    closed = force > 0.0
    assert angle.max() == pytest.approx(touching, abs=1e-12)
    assert angle[closed] == pytest.approx(touching, abs=1e-12)
    assert np.array(run["contact_place"])[closed] == pytest.approx(math.sqrt(far**2 - reach**2), abs=1e-12)
    arm = 3.5e-3 * np.cos(0.5 * angle) + 10.6e-3 * np.sin(0.5 * angle)
    spring = 50.0 * 8e-3 * (1e-3 + 8e-3 * angle)
    weight = 0.01 * 9.80665 * 0.02 * np.sin(angle + 0.4)
    over = 2.0 * np.array(run["force"]) * arm - spring - weight
    assert force[closed] * math.sqrt(far**2 - reach**2) == pytest.approx(over[closed], rel=1e-7)
    assert gap.min() > -1e-12
    assert np.abs(force * gap).max() < 1e-12
    assert np.count_nonzero(np.diff(closed.astype(int))) == 2
    rising = np.diff(force)[1:-1]
    turns = np.count_nonzero(np.diff(np.sign(rising[np.abs(rising) > 1e-6 * force.max()])))
    assert turns == 1


def test_a_rigid_stop_is_the_limit_of_stiff_ones() -> None:
    kinds: list[dict[str, Any]] = [{"contact": "stops"}, {"stop": 2e3}]
    runs = [
        simulate(finger(finger_law("mas-hybrid"), highest=0.6, **changes), trapezoid(), 8.0, samples=33, tolerance=1e-3)
        for changes in kinds
    ]
    rigid, stiff = (np.array(run["angle"]) for run in runs)
    assert rigid.max() == pytest.approx(0.6, abs=1e-14)
    assert rigid == pytest.approx(stiff, abs=2e-5)
    moment, pushed = -np.array(runs[0]["stop_moment"]), 2e3 * np.maximum(stiff - 0.6, 0.0)
    assert moment == pytest.approx(pushed, rel=1e-3, abs=1e-3 * moment.max())
    assert moment.max() > 1e-3


def test_brackets_that_meet_are_a_rigid_stop() -> None:
    system = machine(joint(bracket=1e-3, lowest=-0.1, contact="stops"), compliance=1e-3)
    run = simulate(system, kelvins(system, **{system.drives()[0].name: 30.0}), 1.5, step=0.05, samples=4)
    assert run["angle"][-1] == pytest.approx(2.0 * math.atan2(1e-3, 3.5e-3), abs=1e-12)
    assert run["stop_moment"][-1] < 0.0


def test_sets_of_constraints_are_found_among_all() -> None:
    """Of random stiff mechanisms with more constraints than coordinates, against every subset."""
    rng = np.random.default_rng(5)
    for _ in range(60):
        n, m = int(rng.integers(1, 4)), int(rng.integers(1, 6))
        root, slopes, gaps = rng.normal(size=(n, n)), rng.normal(size=(m, n)), rng.uniform(0.0, 1.0, m)
        stiffness, side = root @ root.T + 0.1 * np.eye(n), rng.normal(size=n)
        given = Constraints(gaps.tolist(), slopes.tolist(), [np.zeros((n, n)).tolist()] * m, [0.0] * m)
        motion, reactions, _ = meet_constraints(floats, given, stiffness.tolist(), side.tolist())
        found = []
        for count in range(min(n, m) + 1):
            for chosen in map(list, itertools.combinations(range(m), count)):
                held = slopes[chosen]
                whole = np.block([[stiffness, -held.T], [held, np.zeros((count, count))]])
                answer = np.linalg.solve(whole, np.concatenate([side, -gaps[chosen]]))
                if (gaps + slopes @ answer[:n]).min() > -1e-9 and answer[n:].min(initial=0.0) >= 0.0:
                    found.append(answer[:n])
        assert motion == pytest.approx(found[0], abs=1e-6)
        assert min(reactions) >= 0.0


def test_slopes_of_a_grip_are_those_of_differences(c_compiler: None) -> None:
    """Of the force, by the cylinder and the spring; runs that touch at other samples are left out."""
    system, options = finger(finger_law("mas-hybrid"), **CYLINDER), {"step": 0.05, "samples": 26}
    changed = {"mechanism.cylinder_radius": 1e-6, "mechanism.stiffness": 1e-2}

    def compute(system: Any) -> Any:
        return compute_sensitivity(system, trapezoid(), 25.0, list(changed), output="contact_force", **options)

    found = compute(system)
    for path, change in changed.items():
        value = next(leaf.value for leaf in system.leaves() if leaf.path == path)
        up, down = (compute(system.with_values({path: value + s * change})).column for s in (1.0, -1.0))
        slopes, kept = (up - down) / (2.0 * change), (up > 0.0) == (down > 0.0)
        assert np.count_nonzero(slopes) > 8
        assert found.slopes[path][kept] == pytest.approx(slopes[kept], rel=1e-4, abs=1e-5 * np.abs(slopes).max())


def test_an_impact_does_not_rebound() -> None:
    """A phalanx that is drawn against its stop stands still there, from the second step on."""
    system = machine(joint(motion="dynamic", contact="stops", highest=0.3, inertia=2e-5), compliance=1e-3)
    drives = kelvins(system, **{system.drives()[0].name: 6.0})
    run = simulate(system, drives, 1.5, step=1e-3, samples=1501)
    angle, rate, moment = (np.array(run[name]) for name in ("angle", "angle_rate", "stop_moment"))
    first = int(np.flatnonzero(moment)[0])
    assert angle.max() <= 0.3 + 1e-12
    assert (moment[first:] < 0.0).all()
    assert np.abs(rate[first + 2 :]).max() < 1e-9
    assert rate[first - 1] > 0.1


@pytest.mark.parametrize(
    ("make", "said"),
    [
        (
            lambda: joint(**CYLINDER | {"cylinder_inwards": 0.018}),
            "overlaps the phalanx of `finger` that `angle` turns by 2 mm",
        ),
        (
            lambda: joint(**CYLINDER | {"cylinder_along": -0.02, "cylinder_inwards": 0.018}),
            "overlaps the fixed phalanx",
        ),
        (lambda: joint(contact="stops", lowest=0.0, highest=0.0), "`highest` must be above `lowest`"),
        (lambda: joint(weight="given", tilt=1.5), "the wire would have to push"),
        (lambda: joint(weight="given", motion="dynamic", inertia=1e-6), "must be at least .* 4e-06 kg m"),
        (lambda: Hand(offset=5e-3, bracket=4e-3, knuckle=7e-3, preload=0.5, contact="cylinder", span=0.03), "thumb"),
    ],
)
def test_what_cannot_be_assembled_is_refused(make: Any, said: str) -> None:
    with pytest.raises(ParameterError, match=said):
        make()


def test_an_overlap_is_one_sentence_of_the_command_line() -> None:
    changes = ("--set", "mechanism.contact=cylinder", "--set", "mechanism.cylinder_inwards=15 mm")
    assert "overlaps" in Command("run").refused(str(EXAMPLE), *changes)


def test_a_cylinder_out_of_reach_is_a_caution() -> None:
    assert joint(**CYLINDER).cautions() == []
    assert "cannot be touched" in joint(**CYLINDER | {"cylinder_along": 0.08}).cautions()[0]
    assert isinstance(joint(), Finger)
