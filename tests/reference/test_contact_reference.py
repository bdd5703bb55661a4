"""Grips of a finger on a cylinder against statics of all sets of contacts: angles, forces and moments."""

from __future__ import annotations

import cmath
from typing import Any

import numpy as np
import pytest
from contact_reference import GrippingFinger
from elastic import kelvins, machine

from martensite.actuators.mechanisms.hand import Hand
from martensite.simulate.api import simulate

GEOMETRY: dict[str, Any] = {"offset": 5e-3, "bracket": 4e-3, "knuckle": 7e-3, "preload": 0.5}
SPRINGS: dict[str, Any] = {"torque": 1e-3, "stiffness": 0.02, "highest": 1.2, "contact": "cylinder"}
PORTS = [f"index_{joint}_{side}" for joint in ("proximal", "distal") for side in ("flexor", "extensor")]
SOFT = 5e-4
NEAR: dict[str, Any] = {"cylinder_depth": 0.025, "cylinder_aside": -5e-3}
WHAT = ("", "_contact_force", "_stop_moment", "_gap")


@pytest.mark.parametrize(
    ("drawn", "changes", "touching"),
    [
        ((0.0, 0.0, 9.0, 0.0), {"tendons": "passing", "cylinder_aside": -5e-3}, "distal"),
        ((9.0, -6.0, 9.0, -9.0), {"tendons": "passing", "cylinder_depth": 0.025}, "proximal distal"),
        ((6.0, 0.0, 0.0, 0.0), {"tendons": "passing", **NEAR}, "lower proximal"),
        ((6.0, -6.0, 9.0, -9.0), {"highest": 0.6, "cylinder_aside": 0.01}, "upper distal"),
    ],
)
def test_a_grip_is_that_of_statics(drawn: tuple[float, ...], changes: dict[str, Any], touching: str) -> None:
    hand = Hand(**(GEOMETRY | SPRINGS | {"cylinder_radius": 0.02, "span": 0.08} | changes))
    system = machine(hand, compliance=SOFT, contraction=1e-3)
    run = simulate(
        system, kelvins(system, **dict(zip(PORTS, drawn, strict=True))), 1.5, step=0.05, samples=4, runtime="floats"
    )
    reference = GrippingFinger(
        **{name: getattr(hand, name) for name in GEOMETRY},
        compliance=SOFT,
        drawn=(1e-3 * drawn[0], 1e-3 * drawn[1], 1e-3 * drawn[2], 1e-3 * drawn[3]),
        passing=hand.tendons == "passing",
        weights=(hand.gravity * hand.proximal_mass, hand.gravity * hand.distal_mass),
        centres=(hand.proximal_centre, hand.distal_centre),
        gravity=cmath.exp(1j * hand.tilt),
        range=(hand.lowest, hand.highest),
        centre=complex(hand.cylinder_depth, 0.5 * hand.span + hand.cylinder_aside),
        reach=hand.cylinder_radius + 0.5 * hand.thickness,
    )
    angles, pushed = reference.solve()
    found = {what: [run[f"index_{j}{what}"][-1] for j in ("proximal", "distal")] for what in WHAT}
    assert found[""] == pytest.approx(angles, abs=1e-7)
    assert found["_contact_force"] == pytest.approx(pushed[4:], rel=1e-6, abs=1e-9)
    assert found["_stop_moment"] == pytest.approx(pushed[:2] - pushed[2:4], rel=1e-6, abs=1e-10)
    assert found["_gap"] == pytest.approx(reference.gaps(angles)[4:], abs=1e-9)
    assert min(found["_gap"]) > -1e-12
    names = ("lower", "lower", "upper", "upper", "proximal", "distal")
    assert [names[k] for k in np.flatnonzero(pushed)] == touching.split()
