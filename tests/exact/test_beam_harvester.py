"""Harvesting from the beam: the harmonic response in closed form, and where its energy goes."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from martensite.actuators.assembly import Machine
from martensite.actuators.mechanisms import BeamHarvester, BeamMotor
from martensite.kernels.compiler import find_compiler
from martensite.signals import Constant
from martensite.simulate.api import simulate

pytestmark = pytest.mark.skipif(find_compiler() is None, reason="there is no C compiler")

MASS, DAMPING, STIFFNESS, MOMENT = 0.1961, 2.0, 541.0, 0.012 * 0.02
COUPLING, CAPACITANCE = 2e-3, 1e-7
EVEN: dict[str, Any] = {
    "rotor_inertia": 10.0,
    "torque_constant": 1.0,
    "back_emf": 1.0,
    "resistance": 1e-3,
    "inductance": 1e-6,
}
"""A motor that nothing brakes: it turns at one rad/s per volt."""
SMALL: dict[str, Any] = {
    "rotor_inertia": 0.82e-4,
    "torque_constant": 0.0211,
    "back_emf": 0.0211,
    "resistance": 6.22,
    "inductance": 3.1e-3,
}
BEAM: dict[str, Any] = {
    "mass": MASS,
    "damping": DAMPING,
    "stiffness": STIFFNESS,
    "unbalance": 0.012,
    "eccentricity": 0.02,
}
PATCH: dict[str, Any] = {"piezo_coupling": COUPLING, "piezo_capacitance": CAPACITANCE}


def run(mechanism: BeamMotor, volts: float, duration: float = 4.0, tolerance: float = 1e-6) -> Any:
    samples = round(500 * duration) + 1
    return simulate(
        Machine(mechanism=mechanism), Constant(level=volts), duration, samples=samples, tolerance=tolerance, runtime="c"
    )


@pytest.mark.parametrize(("omega", "load"), [(40.0, 2e5), (54.0, 1e4)])
def test_harmonic_response(omega: float, load: float) -> None:
    """X = m r ω²/[k - M ω² + iω c + iω θ² R/(1 + iω R C)],  V = -iω θ R X/(1 + iω R C),  P = |V|²/(2 R)."""
    found = run(BeamHarvester(**BEAM, **EVEN, **PATCH, load_resistance=load), omega, 3.0, 1e-5)
    circuit = 1j * omega * load / (1.0 + 1j * omega * load * CAPACITANCE)
    x = MOMENT * omega**2 / (STIFFNESS - MASS * omega**2 + 1j * omega * DAMPING + COUPLING**2 * circuit)
    v = -COUPLING * circuit * x
    times = np.array(found.times)
    last = times > 2.2
    waves = np.column_stack([np.sin(omega * times[last]), np.cos(omega * times[last])])
    for name, wanted in (("displacement", abs(x)), ("piezo_voltage", abs(v))):
        parts = np.linalg.lstsq(waves, np.array(found[name])[last], rcond=None)[0]
        assert math.hypot(*parts) == pytest.approx(wanted, rel=2e-4), name
    power = np.array(found["harvested_power"])[last]
    swing = np.column_stack([np.ones(last.sum()), np.sin(2 * omega * times[last]), np.cos(2 * omega * times[last])])
    assert np.linalg.lstsq(swing, power, rcond=None)[0][0] == pytest.approx(abs(v) ** 2 / (2.0 * load), rel=5e-4)


def test_harvested_energy_is_what_the_balance_calls_dissipated() -> None:
    """Without other losses on the beam, what the resistor takes is all that is dissipated but for the winding."""
    beam: dict[str, Any] = {**BEAM, "damping": 0.0, "piezo_coupling": 0.01, "piezo_capacitance": CAPACITANCE}
    found = run(BeamHarvester(**beam, **SMALL, load_resistance=5e4), 2.0, 2.0)
    work, times = found.energy["work"], np.array(found.times)
    assert (work.residual or 1.0) < 1e-6
    harvested = np.trapezoid(np.array(found["harvested_power"]), times)
    winding = np.trapezoid(SMALL["resistance"] * np.array(found["motor_current"]) ** 2, times)
    assert harvested > 0.1 * winding
    assert work.dissipated == pytest.approx(harvested + winding, rel=1e-3)


def test_without_coupling_it_is_the_beam() -> None:
    alone = run(BeamMotor(**BEAM, **SMALL), 1.0, 1.0)
    uncoupled = PATCH | {"piezo_coupling": 0.0}
    beside = run(BeamHarvester(**BEAM, **SMALL, **uncoupled, load_resistance=1e4), 1.0, 1.0)
    apart = np.abs(np.array(beside["displacement"]) - np.array(alone["displacement"])).max()
    assert apart < 1e-5 * np.abs(alone["displacement"]).max()
    assert max(map(abs, beside["piezo_voltage"])) == 0.0
