"""Two elements against each other on a pulley: balance, slack, weight, vibration, real wires.

Sources of truth: statics and vibration of a pulley between two springs in closed form, and what
the laws say by themselves about a wire that is stretched cold.
"""

from __future__ import annotations

import math
from itertools import pairwise
from typing import Any

import builders
import numpy as np
import pytest
from builders import wire_a
from elastic import REST, kelvins, machine

from martensite.actuators.assembly import Actuator, Group, Machine
from martensite.actuators.mechanics.motion import Motion
from martensite.actuators.mechanisms.base import Column
from martensite.actuators.mechanisms.pulley import AntagonisticPulley
from martensite.kernels.namespace import Namespace
from martensite.physics.electrical.sources import PowerSource, PrescribedTemperature
from martensite.physics.laws.brinson import Brinson
from martensite.physics.thermal.base import Environment
from martensite.physics.thermal.films import ConstantCooling
from martensite.signals.base import AbstractWaveform
from martensite.signals.constant import Constant
from martensite.signals.step import Step
from martensite.signals.table import Table
from martensite.simulate.api import simulate
from martensite.simulate.result import Result

R, PRELOAD, SOFT, SHORTER = 8e-3, 3.0, 4e-4, 1e-3
"""Radius [m], preload [N], compliance of an elastic element [m/N], its shortening per kelvin."""
RATE = 2.0 * R * R / SOFT
"""Stiffness of both elastic elements against rotation [N m/rad]."""


def pulley(**changes: Any) -> AntagonisticPulley:
    sizes: dict[str, Any] = {"radius": R, "preload": PRELOAD}
    return AntagonisticPulley(**(sizes | changes))


def pulled(protagonist: float, antagonist: float = 0.0, **changes: Any) -> Result:
    """A pulley between elastic elements that get shorter by so many millimetres within 1 s."""
    system = machine(pulley(**changes), compliance=SOFT, contraction=SHORTER)
    drives = kelvins(system, protagonist=protagonist, antagonist=antagonist)
    return simulate(system, drives, 2.0, step=0.05, samples=21)


# ---------------------------------------------------------------- elastic elements, closed forms


def test_equal_pulls_turn_nothing_and_add_force() -> None:
    result = pulled(2.0, 2.0, stiffness=0.01, moment=0.02)
    expected = PRELOAD + 2e-3 / SOFT
    assert np.abs(result["angle"]).max() < 1e-12
    for port in ("protagonist", "antagonist"):
        assert result[f"{port}.force"][-1] == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize("stiffness", [0.0, 0.05, 0.5])
def test_one_turns_it_against_the_other_and_the_joint(stiffness: float) -> None:
    x = 1.5e-3
    result = pulled(1.5, stiffness=stiffness)
    angle = R * x / SOFT / (stiffness + RATE)
    forces = PRELOAD + (x - R * angle) / SOFT, PRELOAD + R * angle / SOFT
    assert result["angle"][-1] == pytest.approx(angle, rel=1e-12)
    assert result["protagonist.force"][-1] == pytest.approx(forces[0], rel=1e-12)
    assert result["antagonist.force"][-1] == pytest.approx(forces[1], rel=1e-12)


def test_sides_are_mirror_images() -> None:
    one, other = pulled(1.5, 0.2, moment=0.1), pulled(0.2, 1.5, moment=0.1)
    assert one["angle"] == pytest.approx([-a for a in other["angle"]], abs=1e-14)
    assert one["protagonist.force"] == pytest.approx(other["antagonist.force"], rel=1e-12)


def test_a_slack_antagonist_does_not_push() -> None:
    """The joint alone holds the protagonist once the antagonist is 20 mm longer."""
    stiffness = 0.05
    result = pulled(0.0, -20.0, stiffness=stiffness)
    angle = R * PRELOAD / (stiffness + 0.5 * RATE)
    assert result["antagonist.force"][-1] == 0.0
    assert result["angle"][-1] == pytest.approx(angle, rel=1e-12)
    assert result["protagonist.force"][-1] == pytest.approx(stiffness * angle / R, rel=1e-12)


def test_both_slack_leave_it_to_the_joint() -> None:
    result = pulled(-20.0, -20.0, stiffness=0.05)
    assert result["angle"][-1] == pytest.approx(0.0, abs=1e-12)
    assert (result["protagonist.force"][-1], result["antagonist.force"][-1]) == (0.0, 0.0)


def test_the_weight_of_a_lever_draws_it_back() -> None:
    moment, x = 0.4, 6e-3
    angle = pulled(6.0, moment=moment)["angle"][-1]
    assert R * x / SOFT == pytest.approx(moment * math.sin(angle) + RATE * angle, rel=1e-10)
    assert angle < 0.6 * x / (2.0 * R)


# ---------------------------------------------------------------- vibration


def vibrating(damping: float, step: float = 5e-4, **changes: Any) -> Result:
    """A pulley after a sudden shortening."""
    mechanism = pulley(motion="dynamic", inertia=4e-5, damping=damping, stiffness=0.05, **changes)
    system = machine(mechanism, compliance=SOFT, contraction=SHORTER)
    kick = Step(low=REST, high=REST + 0.5, at=0.01)
    drives = kelvins(system) | {"protagonist": kick}
    return simulate(system, drives, 0.41, step=step, samples=821)


def crossings(times: Any, values: np.ndarray) -> np.ndarray:
    """When a column passes zero upwards, by straight lines."""
    up = np.flatnonzero((values[:-1] < 0.0) & (values[1:] >= 0.0))
    t = np.asarray(times)
    return t[up] - values[up] * (t[up + 1] - t[up]) / (values[up + 1] - values[up])


def test_it_vibrates_with_the_frequency_of_stiffness_and_inertia() -> None:
    result = vibrating(0.0)
    still = R * 0.5e-3 / SOFT / (0.05 + RATE)
    ups = crossings(result.times, np.array(result["angle"]) - still)
    omega = 2.0 * math.pi / np.diff(ups).mean()
    assert len(ups) > 5
    assert omega == pytest.approx(math.sqrt((0.05 + RATE) / 4e-5), rel=1e-3)
    assert max(result["angle"]) == pytest.approx(2.0 * still, rel=1e-3)
    assert max(result["angle"][-140:]) == pytest.approx(2.0 * still, rel=0.01)


def test_damping_takes_the_amplitude_by_its_logarithmic_decrement() -> None:
    damping = 5e-4
    result = vibrating(damping, step=2.5e-4)
    still = R * 0.5e-3 / SOFT / (0.05 + RATE)
    swing = np.array(result["angle"]) - still
    ups = crossings(result.times, swing)
    peaks = [swing[(np.array(result.times) >= a) & (np.array(result.times) < b)].max() for a, b in pairwise(ups)]
    decrement = np.diff(np.log(peaks)).mean()
    period = np.diff(ups).mean()
    assert decrement == pytest.approx(-damping / (2.0 * 4e-5) * period, rel=0.01)


# ---------------------------------------------------------------- real wires

COLD = Environment(temperature=275.0, cooling=ConstantCooling(h=150.0))
"""Colder than the finish of martensite."""
HEATED, COOLED, BACK = 7.0, 15.0, 21.0
"""When the first pulse ends, when the second begins and when that ends [s]."""


def niti() -> Brinson:
    """A law with twinned martensite, by the published set of numbers."""
    return builders.example(Brinson)


def wires() -> Machine:
    """Two wires of 0.2 m, the antagonist twinned and therefore short."""
    long = wire_a(niti(), diameter=0.2e-3, length=0.2, latent_heat=0.0)
    short = long.with_parts(initial_oriented=0.0)
    members = {
        name: Actuator(element=element, environment=COLD, source=PowerSource())
        for name, element in (("protagonist", long), ("antagonist", short))
    }
    return Machine(mechanism=pulley(preload=0.2), group=Group(**members))


def pulse(begin: float) -> Table:
    """2 W for 6 s."""
    times = (0.0, begin, begin + 0.2, begin + 6.0, begin + 6.2, 100.0)
    return Table(times=times, values=(0.0, 0.0, 2.0, 2.0, 0.0, 0.0))


@pytest.fixture(scope="module")
def to_and_fro() -> Result:
    """First the one is heated and cooled, then the other."""
    drives = {"protagonist": pulse(1.0), "antagonist": pulse(COOLED)}
    return simulate(wires(), drives, 24.0, step=0.02, samples=481)


def at(result: Result, name: str, time: float) -> float:
    return result[name][result.times.tolist().index(time)]


def test_a_cold_antagonist_is_detwinned_along_its_strip(to_and_fro: Result) -> None:
    """ξ_S = ½ [1 - cos π(σ - σ_s)/(σ_f - σ_s)] between the critical stresses."""
    law, result = niti(), to_and_fro
    until = result.times.tolist().index(HEATED)
    stress = np.array(result["antagonist.stress"][:until])
    share = np.clip((stress - law.sigma_s) / (law.sigma_f - law.sigma_s), 0.0, 1.0)
    expected = 0.5 * (1.0 - np.cos(math.pi * share))
    assert result["antagonist.oriented_fraction"][:until] == pytest.approx(expected, abs=1e-6)
    assert at(result, "antagonist.oriented_fraction", HEATED) > 0.8
    assert max(result["antagonist.temperature"][:until]) == pytest.approx(275.0, abs=1e-9)


def test_stroke_and_stretch_are_one_geometry(to_and_fro: Result) -> None:
    for port, sign in (("antagonist", 1.0), ("protagonist", -1.0)):
        longer = sign * 0.2 * (np.array(to_and_fro[f"{port}.strain"]) - to_and_fro[f"{port}.strain"][0])
        assert longer == pytest.approx(R * np.array(to_and_fro["angle"]), abs=1e-7)
    assert to_and_fro["protagonist.force"] == pytest.approx(to_and_fro["antagonist.force"], rel=1e-4)
    assert at(to_and_fro, "angle", HEATED) > 1.5


def test_it_stays_when_cooled_and_the_antagonist_brings_it_back(to_and_fro: Result) -> None:
    """Nothing but the other wire draws it back: cold it keeps its place but for elasticity."""
    hot, cold, back = (at(to_and_fro, "angle", t) for t in (HEATED, COOLED, BACK))
    assert 0.9 * hot < cold < hot
    assert abs(back) < 0.05 * hot
    assert at(to_and_fro, "protagonist.oriented_fraction", COOLED) < 0.05
    assert at(to_and_fro, "protagonist.oriented_fraction", BACK) > 0.8


class Loaded(AntagonisticPulley):
    """A pulley that something turns from outside. Deliberately not registered."""

    def signals(self) -> dict[str, str]:
        return {"torque": "N*m"}

    def demand(self, xp: Namespace, motion: Motion, signals: Column) -> Column:
        (held,) = super().demand(xp, motion, signals)
        return [held - signals[0]]


def stiffness(kelvin: float) -> float:
    """Torque per angle [N m/rad] of two wires, a little stretched cold, at a temperature."""
    wire = wire_a(niti(), diameter=0.2e-3, length=0.2, initial_oriented=0.05)
    one = Actuator(element=wire, environment=COLD, source=PrescribedTemperature())
    system = Machine(mechanism=Loaded(radius=R, preload=1.0), group=Group(protagonist=one, antagonist=one))
    heat = Table(times=(0.0, 1.0, 100.0), values=(275.0, kelvin, kelvin))
    drives: dict[str, AbstractWaveform] = {"protagonist": heat, "antagonist": heat}
    torque = 1e-3
    drives["torque"] = Table(times=(0.0, 2.0, 2.5, 100.0), values=(0.0, 0.0, torque, torque))
    angle = simulate(system, drives, 3.0, step=0.02, samples=31)["angle"]
    assert np.abs(angle[:20]).max() < 1e-9
    return torque / (angle[-1] - angle[0])


def test_co_contraction_stiffens_the_joint() -> None:
    """Cold it has the modulus of martensite, hot that of austenite: nothing moved in between."""
    wire = 2.0 * R * R * 0.25 * math.pi * 0.2e-3**2 / 0.2
    assert stiffness(275.0) == pytest.approx(wire * niti().E_M, rel=1e-6)
    assert stiffness(390.0) == pytest.approx(wire * niti().E_A, rel=1e-6)


def test_a_torque_from_outside_needs_a_signal() -> None:
    """The loaded pulley is one: what turns it from outside is seen, and nothing else is."""
    system = machine(Loaded(radius=R, preload=PRELOAD), compliance=SOFT)
    drives = kelvins(system) | {"torque": Constant(level=0.01)}
    result = simulate(system, drives, 1.0, step=0.1, samples=3)
    assert result["angle"][-1] == pytest.approx(0.01 / RATE, rel=1e-12)
