"""Wear settles exponentially, may go on with the logarithm of cycles, and changes no bit where it is nothing.

Source of truth: the closed form, ε_r = (σ/σ_r)(ε_∞ (1 - exp(-N/N₀)) + ε_d log10(1 + N/N₀)) under a dead weight, and
the same wire without wear.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

import martensite as ms
from martensite.base.errors import ParameterError
from martensite.kernels import floats
from martensite.parts import LAWS
from martensite.physics.laws.wear import Wear
from martensite.simulate.api import simulate
from martensite.testing.examples import build_example

ZERO, COLD, HOT = 273.15, 283.15, 413.15
CYCLES = ms.signals.Triangle(low=COLD, high=HOT, frequency=0.01)
DRIFT = {"residual_strain": 0.005, "reference_stress": 100e6, "stroke_loss": 0.3, "temperature_shift": -6.0}
SLOW = {"residual_strain_per_decade": 0.002, "stroke_loss_per_decade": 0.05, "temperature_shift_per_decade": -1.0}


def build_wire(wear: Wear | None, law: str = "liang-rogers", material: str = "flexinol-90", **options: str) -> ms.Wire:
    numbers = {name: number.value for name, number in ms.load_material(material).values.items()}
    taken: dict[str, Any] = {n: numbers[n] for n in LAWS[law].declarations if n in numbers}
    ohms = ms.electrical.PerLengthResistance(r_A=30.0, r_M=33.0)
    shape = {"diameter": 0.2e-3, "length": 0.2, "density": 6450.0, "heat_capacity": 500.0, "latent_heat": 24e3}
    return ms.Wire(law=LAWS[law](**taken, **options), resistance=ohms, wear=wear, **shape)


def build_system(wear: Wear | None, *, heated: bool = False, spring: bool = False, **law: str) -> ms.System:
    return ms.System(
        element=build_wire(wear, **law),
        source=ms.CurrentSource() if heated else ms.electrical.PrescribedTemperature(),
        mechanism=ms.BiasSpring(stiffness=200.0, preload=3.0) if spring else ms.DeadWeight(mass=0.32),
        environment=ms.Environment(temperature=293.15, cooling=ms.thermal.ConstantCooling(h=100.0)),
    )


@pytest.mark.parametrize("slow", [{}, SLOW], ids=["settles", "goes on"])
def test_it_follows_the_closed_form(slow: dict[str, float]) -> None:
    wear = Wear(settling_cycles=3.0, cycles=2.0, **DRIFT, **slow)
    worn, new = (simulate(build_system(w), CYCLES, 1000.0, step=0.5, samples=21) for w in (wear, None))
    hot, cold = worn["strain"][1::2], worn["strain"][2::2]
    stress = worn["stress"][0]
    for k, (less, more) in enumerate(zip(hot, cold, strict=True)):
        for strain, done, martensite in ((less, 2.5 + k, 0.0), (more, 3.0 + k, 1.0)):
            w, decades = 1.0 - math.exp(-done / 3.0), math.log10(1.0 + done / 3.0) if slow else 0.0
            residual = (0.005 * w + 0.002 * decades) * stress / 100e6
            lost = (0.3 * w + 0.05 * decades) * 0.041 * martensite
            fresh = new["strain"][1] if martensite == 0.0 else new["strain"][2]
            assert strain == pytest.approx(fresh + residual - lost, abs=1e-12)


def test_temperatures_shift_by_what_is_done() -> None:
    """A wire after many cycles transforms as one with other temperatures, at every sample."""
    wear = Wear(settling_cycles=1e6, cycles=99e6, temperature_shift=-4.0, temperature_shift_per_decade=-1.0)
    worn = simulate(build_system(wear), CYCLES, 200.0, step=0.5, samples=201)
    system = build_system(None)
    names = ("A_s", "A_f", "M_s", "M_f")
    other = system.with_values({f"element.law.{n}": getattr(system.element.law, n) - 6.0 for n in names})
    assert np.allclose(worn["strain"], simulate(other, CYCLES, 200.0, step=0.5, samples=201)["strain"], atol=1e-12)


@pytest.mark.parametrize("law", [{}, {"law": "lagoudas", "material": "niti-lagoudas"}], ids=["strips", "surfaces"])
def test_wear_that_is_nothing_changes_no_bit(law: dict[str, str]) -> None:
    wave = ms.Sine(low=0.0, high=0.7, frequency=0.1)
    systems = [build_system(w, heated=True, spring=True, **law) for w in (None, Wear(settling_cycles=10.0))]
    plain, worn = (simulate(system, wave, 20.0, step=0.1, samples=41, runtime="floats") for system in systems)
    assert all(np.array_equal(plain[name], worn[name]) for name in plain.columns)
    assert not any("wear" in leaf.path for leaf in systems[0].leaves())


def test_heat_above_a_temperature_wears_too() -> None:
    heat = {"overheat_temperature": HOT - 60.0, "overheat_rate": 0.01}
    wear = Wear(settling_cycles=50.0, residual_strain=0.01, **heat)
    constant = ms.Constant(level=HOT)
    worn, new = (simulate(build_system(w), constant, 50.0, step=0.5, samples=11) for w in (wear, None))
    assert np.ptp(new["martensite_fraction"]) == 0.0
    aim = 0.01 * worn["stress"][0] / 100e6
    left = 1.0 - (np.array(worn["strain"]) - new["strain"]) / aim
    assert left[1:] / left[1] == pytest.approx(
        np.exp(-0.6 * (np.array(worn.times) - worn.times[1])[1:] / 50.0), abs=1e-12
    )


def test_strands_of_a_bundle_wear_as_one_wire() -> None:
    alone = build_system(Wear(settling_cycles=3.0, **DRIFT))
    bundle = ms.elements.Bundle(strand=alone.element, count=2.0)
    both = alone.with_parts(element=bundle, mechanism=ms.DeadWeight(mass=0.64))
    one, two = (simulate(system, CYCLES, 300.0, step=0.5, samples=31) for system in (alone, both))
    assert np.allclose(one["strain"], two["strain"], atol=1e-13)


def test_an_observer_that_corrects_the_state_makes_no_cycles() -> None:
    wire = build_wire(Wear(settling_cycles=4.0, **DRIFT))
    state = wire.init(floats, 3.0, 300.0)
    moved = wire.in_state(floats, state, ms.parts.Fractions(0.2, 0.2), 350.0, 3.0)
    assert (moved.worn.cycles, moved.worn.martensite) == (0.0, 0.2)


def test_strain_that_is_kept_at_its_least_is_reported() -> None:
    loss = {"stroke_loss": 0.8, "stroke_loss_per_decade": 0.1}
    little, much = (Wear(settling_cycles=10.0, cycles=cycles, **loss) for cycles in (50.0, 1000.0))
    assert not any("keeps" in text for text in little.cautions())
    assert "wear would take 100% of the transformation strain; the model keeps 5% of it" in much.cautions()[-1]


def test_what_cannot_wear_is_refused() -> None:
    with pytest.raises(ParameterError, match="more than a tenth of the transformation strain"):
        build_wire(Wear(settling_cycles=1.0, residual_strain=0.05))
    with pytest.raises(ParameterError, match="too steep"):
        build_wire(Wear(settling_cycles=9.0, **DRIFT), law="mas-hybrid", material="finger-mas")
    with pytest.raises(ParameterError, match="must have no `wear`"):
        build_example(ms.elements.AxialWire, wire=build_wire(Wear(settling_cycles=9.0)))
