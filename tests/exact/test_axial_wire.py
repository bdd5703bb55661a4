"""Axial wire against the exact fin, its limits, its own heat balance and a finger's wire.

Sources of truth: the fin with a uniform source between two clamps in closed form; the lumped
wire, which the axial wire becomes without clamps; the first law over a whole cycle; finite
volumes written anew; and angles of a finger that a stiff solver found for this project.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from axial_cases import AMBIENT, IDEAL, K, L, axial, clamped, fin, finite_volumes, orders, thin_wire
from builders import law_a, wire_a
from finger import finger, finger_law, trapezoid

from martensite.actuators.assembly import System
from martensite.actuators.elements.axial_wire import AxialWire
from martensite.actuators.elements.wire import Wire
from martensite.actuators.mechanisms.base import AbstractMechanism
from martensite.actuators.mechanisms.load_line import BiasSpring, DeadWeight
from martensite.base.errors import ParameterError
from martensite.physics.electrical.resistances import PerLengthResistance
from martensite.physics.thermal.ends import ClampedEnds
from martensite.signals.constant import Constant
from martensite.signals.step import Step
from martensite.simulate.api import simulate
from martensite.simulate.result import Result

CELLS = ("5", "10", "20", "40", "80")
MILD = 1.0
"""Power per length [W/m] that leaves the wire far from its transformation."""
LOADS: dict[str, AbstractMechanism] = {
    "weight": DeadWeight(mass=0.05),
    "spring": BiasSpring(stiffness=1000.0, preload=0.5),
}
HEAVY = pytest.mark.slow
"""Repetitions of a test of which another case stays fast."""

# ---------------------------------------------------------------- the fin


def settled(watts: float, **numbers: Any) -> Result:
    """The steady state under a constant power."""
    element = axial(thin_wire(numbers.pop("length", L)), **numbers)
    return simulate(clamped(element), Constant(level=watts), 60.0, step=0.5, samples=2)


FINS: dict[str, dict[str, float]] = {
    "long, ideal": {"length": 20e-3, "contact": IDEAL, "grading": 3.0},
    "short, ideal": {"length": 4e-3, "contact": IDEAL, "grading": 1e-6},
    "long, finite": {"length": 20e-3, "contact": 1e-4, "grading": 3.0},
    "short, finite": {"length": 4e-3, "contact": 1e-5, "grading": 1e-6},
    "three spans": {"length": 60e-3, "contact": 1e-4, "spans": 3.0, "grading": 4.0},
}


@pytest.fixture(
    scope="module",
    params=[
        "short, finite",
        "three spans",
        pytest.param("long, ideal", marks=HEAVY),
        pytest.param("short, ideal", marks=HEAVY),
        pytest.param("long, finite", marks=HEAVY),
    ],
)
def ladder(request: pytest.FixtureRequest) -> tuple[tuple[float, float], list[Result]]:
    """Exact mean and highest overtemperature, and runs with more and more cells."""
    numbers = FINS[request.param]
    watts = MILD * numbers["length"]
    exact = fin(watts, **{name: n for name, n in numbers.items() if name != "grading"})
    return exact, [settled(watts, cells=cells, **numbers) for cells in CELLS]


def test_steady_state_tends_to_the_fin_at_second_order(ladder: tuple[tuple[float, float], list[Result]]) -> None:
    exact, runs = ladder
    for name, rise in zip(("temperature", "hottest"), exact, strict=True):
        errors = np.array([run[name][-1] - AMBIENT - rise for run in runs])
        assert np.abs(errors[-1]) < 1e-4 * rise
        found = orders(errors)[1:]
        assert ((found > 1.8) & (found < 2.2)).all()


@pytest.mark.parametrize("grading", [1.0, 3.0])
def test_cells_are_finite_volumes(grading: float) -> None:
    watts = MILD * L
    for cells in ("5", "20"):
        mean = settled(watts, cells=cells, grading=grading)["temperature"][-1] - AMBIENT
        assert mean == pytest.approx(finite_volumes(watts, int(cells), grading), rel=1e-9)


# ---------------------------------------------------------------- limits


def bench(element: Any, load: str, step: float = 0.02) -> Result:
    """The wire of problem A (two resistivities) through a whole cycle, against a load."""
    heavy: dict[str, AbstractMechanism] = {
        "weight": DeadWeight(mass=1.0),
        "spring": BiasSpring(stiffness=1000.0, preload=5.0),
    }
    pulse = Step(low=0.0, high=5.4, at=1.0, until=12.0)
    return simulate(clamped(element, heavy[load]), pulse, 24.0, step=step, samples=121)


@pytest.mark.parametrize("load", ["weight", pytest.param("spring", marks=HEAVY)])
def test_without_clamps_it_is_the_lumped_wire(load: str) -> None:
    """Through the transformation, to what the solver leaves in its steps."""
    wire = wire_a(law_a())
    lumped = bench(wire, load)
    assert (min(lumped["martensite_fraction"]), lumped["martensite_fraction"][-1]) == (0.0, 1.0)
    for allowed, numbers in (
        (2e-6, {"cells": "5", "thermal_conductivity": 18.0}),
        (2e-6, {"cells": "10", "thermal_conductivity": 18.0, "spans": 3.0, "grading": 4.0}),
        (2e-5, {"cells": "5", "thermal_conductivity": 1e6}),
    ):
        found = bench(axial(wire, contact=0.0, **numbers), load)
        for name in ("temperature", "hottest", "martensite_fraction", "position", "resistance"):
            apart = np.abs(np.array(found[name]) - np.array(lumped[name])).max()
            assert apart < allowed * lumped.range(name), (name, numbers)


@pytest.mark.parametrize("spans", [1.0, 3.0])
def test_a_perfect_conductor_loses_through_its_contacts(spans: float) -> None:
    contact, watts = 1e-4, MILD * L
    numbers = {"contact": contact, "spans": spans, "thermal_conductivity": 1e8}
    found = settled(watts, cells="5", **numbers)
    rise = watts / (200.0 * math.pi * 0.1e-3 * L + 2.0 * spans * contact)
    for name in ("temperature", "hottest"):
        assert found[name][-1] - AMBIENT == pytest.approx(rise, rel=1e-5)


# ---------------------------------------------------------------- energy, orders

PULSE = Step(low=0.0, high=0.15, at=0.1, until=2.5)


def cycle(load: str, step: float, contact: float = IDEAL) -> tuple[Result, np.ndarray, np.ndarray]:
    """A cycle of a 30 mm wire; energy brought and not lost, and stored enthalpy [J]."""
    resistance = PerLengthResistance(r_A=110.0, r_M=125.0)
    wire = thin_wire(30e-3, resistance=resistance)
    system = clamped(axial(wire, cells="10", contact=contact), LOADS[load])
    run = simulate(system, PULSE, 4.0, step=step, samples=round(4.0 / step) + 1)
    times, lost = np.array(run.times), np.array(run["heat_loss"])
    out = np.concatenate([[0.0], np.cumsum(0.5 * (lost[1:] + lost[:-1]) * np.diff(times))])
    brought = PULSE.high * np.clip(times - PULSE.at, 0.0, 2.4)
    warm, fraction = np.array(run["temperature"]) - AMBIENT, np.array(run["martensite_fraction"])
    latent = wire.latent_heat * wire.mass()
    return run, brought - out, wire.heat_capacity_total() * warm + latent * (1.0 - fraction)


@pytest.mark.parametrize("load", ["weight", pytest.param("spring", marks=HEAVY)])
def test_stroke_converges_in_the_cells_through_a_transformation(load: str) -> None:
    """Root mean square over a cycle; fronts pass from cell to cell, so orders scatter."""
    wire = thin_wire(10e-3, resistance=PerLengthResistance(r_A=110.0, r_M=125.0))
    loads = LOADS | {"spring": BiasSpring(stiffness=1800.0, preload=0.5)}
    pulse = Step(low=0.0, high=0.07, at=0.1, until=1.5)
    runs = [
        simulate(clamped(axial(wire, cells=cells, grading=1.0), loads[load]), pulse, 2.5, step=0.005, samples=126)
        for cells in CELLS
    ]
    paths = np.array([run["position"] for run in runs])
    errors = np.sqrt(((paths[:-1] - paths[-1]) ** 2).mean(axis=1)) / np.ptp(paths[-1])
    assert (np.diff(errors) < 0.0).all()
    assert errors[2] < 2e-3
    assert orders(errors).mean() > 1.5


# ---------------------------------------------------------------- a finger's wire

ANGLES = {(2.0, 1.4): 90.3, (2.0, 2.0): 91.9, (6.0, 1.4): 85.5, (6.0, 2.0): 90.1, (14.0, 1.4): 76.5, (14.0, 2.0): 86.5}
"""(spans, W) -> angle [deg] at 13 s, by a stiff solver on 0.3 mm and less; 92.75 without ends."""
GRADINGS = {2.0: 5.0, 6.0: 4.0, 14.0: 3.0}


def bent(spans: float, watts: float, even: bool = True, **options: str) -> float:
    """Angle [deg] at 13 s: two half wires as one, clamped at both ends of each."""
    whole = finger(finger_law("mas-hybrid"), offset=1.5e-3)
    wire: Any = whole.element
    parts = {name: getattr(wire, name) for name in wire.declarations}
    if even:
        parts["resistance"] = PerLengthResistance(r_A=125.0, r_M=125.0)
    cells, runtime = options.get("cells", "20"), options.get("runtime", "floats")
    element = axial(Wire(**parts), cells=cells, spans=spans, grading=GRADINGS[spans])
    system = System(element=element, environment=whole.environment, source=whole.source, mechanism=whole.mechanism)
    run = simulate(system, trapezoid(watts), 13.0, step=0.02, samples=14, runtime=runtime)
    return math.degrees(run["angle"][-1])


@pytest.mark.parametrize(
    ("mechanism", "grading"),
    [(DeadWeight(mass=0.05), 2.0), (BiasSpring(stiffness=1800.0, preload=0.5), 1.0)],
    ids=["weight", "spring"],
)
def test_coarse_steps_in_which_all_cells_cross_a_kink_are_solved(mechanism: AbstractMechanism, grading: float) -> None:
    """Usual sweeps go to and fro there; the stroke is that of short steps all the same."""
    wire = thin_wire(10e-3, resistance=PerLengthResistance(r_A=110.0, r_M=125.0))
    system = clamped(axial(wire, cells="5", grading=grading), mechanism)
    wave = Step(high=0.07, at=0.1, until=1.5)
    coarse, fine = (simulate(system, wave, 3.0, step=h, samples=61) for h in (0.02, 0.0025))
    assert not coarse.status.failed
    assert coarse.stroke == pytest.approx(fine.stroke, rel=1e-2)


@pytest.mark.slow
@pytest.mark.usefixtures("c_compiler")
def test_cold_ends_cost_a_finger_some_of_its_angle() -> None:
    """One test for all, since all run the same compiled program."""
    found = {case: bent(*case, runtime="c") for case in ANGLES}
    assert found == pytest.approx(ANGLES, abs=0.6)
    assert max(found.values()) < 92.75 - 0.6


# ---------------------------------------------------------------- what it refuses


@pytest.mark.parametrize(
    ("wire", "words"),
    [
        (axial, "axial-wire"),
        (lambda: thin_wire(ends=ClampedEnds(thermal_conductivity=K)), "`adiabatic` ends"),
        (lambda: thin_wire(law=finger_law("mas-polycrystal")), "try law `mas`"),
    ],
    ids=["axial-wire", "clamped", "groups"],
)
def test_what_cannot_be_cut_is_refused(wire: Any, words: str) -> None:
    with pytest.raises(ParameterError, match=words):
        AxialWire(wire=wire(), thermal_conductivity=K)
