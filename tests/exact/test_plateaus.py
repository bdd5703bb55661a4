"""Plateau stresses of superelastic tests and transformation temperatures of laws.

Source of truth: straight lines in the phase diagram, and each law itself, followed in small steps.
"""

from __future__ import annotations

import json
from typing import Any

import numpy as np
import pytest
from builders import stepper, variants
from command import Command

from martensite.base.errors import InputError
from martensite.characterise.plateaus import Plateaus, convert_plateaus, find_plateaus
from martensite.kernels import floats
from martensite.physics.laws.base import LAWS, Fractions
from martensite.scenario.scenario import read_scenario

TEST = Plateaus(295.15, (400e6, 450e6), (200e6, 150e6))
CONVERTED = ("brinson", "elahinia", "lagoudas", "liang-rogers", "r-phase", "tanaka")


def test_straight_lines_pass_through_the_stresses() -> None:
    law = variants(LAWS["liang-rogers"])[0].with_values({"C_M": 8e6, "C_A": 13.8e6})
    values = convert_plateaus(law, TEST)
    assert values["M_s"] == pytest.approx(295.15 - 400 / 8.0, abs=1e-4)
    assert values["M_f"] == pytest.approx(295.15 - 450 / 8.0, abs=1e-4)
    assert values["A_s"] == pytest.approx(295.15 - 200 / 13.8, abs=1e-4)
    assert values["A_f"] == pytest.approx(295.15 - 150 / 13.8, abs=1e-4)


@pytest.mark.parametrize("name", CONVERTED)
def test_laws_have_the_plateaus_in_small_steps(name: str) -> None:
    """Austenite remains up to the start of loading, martensite down to the start of unloading."""
    law = variants(LAWS[name])[0]
    law = law.with_values(convert_plateaus(law, TEST))
    memory: Any = law.init(floats, Fractions(0.0, 0.0), 0.0, TEST.temperature)
    fractions, step = {}, stepper(law)
    for stress in (*range(0, 500, 2), *range(500, -1, -2)):
        memory = step(memory, 1e6 * stress, TEST.temperature, 1.0)
        fractions[stress, len(fractions) > 250] = law.fractions(memory).martensite
    assert fractions[398, False] == 0.0 < fractions[404, False]
    assert fractions[446, False] < fractions[452, False]
    assert fractions[452, False] == pytest.approx(1.0, abs=0.011)  # tanaka completes 99 %
    assert fractions[202, True] == pytest.approx(fractions[498, True])
    assert fractions[196, True] < fractions[202, True]
    assert fractions[148, True] == pytest.approx(0.0, abs=0.011)


def test_a_scenario_takes_plateaus_and_a_second_test(c_compiler: str) -> None:
    law = 'kind = "liang-rogers"\nmodulus = "mixture"\nE_A = "60 GPa"\nE_M = "30 GPa"\neps_L = "4.8 %"'
    text = SCENARIO.replace("LAW", law)
    scenario = read_scenario(text)
    system: Any = scenario.system
    numbers = {leaf.path: leaf.value for leaf in system.element.law.leaves()}
    assert (numbers["C_M"], numbers["C_A"]) == pytest.approx((7e6, 7e6))
    assert find_plateaus(system.element.law, 310.15).loading == pytest.approx((505e6, 555e6), rel=1e-6)
    run = scenario.run()
    begins = np.argmax(run["martensite_fraction"] > 1e-3)
    assert run["stress"][begins] == pytest.approx(400e6, rel=0.02)
    with pytest.raises(InputError, match=r"plateaus\] The plateaus determine `A_s`"):
        read_scenario(text.replace("modulus", 'A_s = "300 K"\nmodulus'))
    with pytest.raises(InputError, match=r"plateaus\] needs `temperature`.* but lacks `loading_end`"):
        read_scenario(text.replace('loading_end = "450 MPa"\n', "", 1))
    with pytest.raises(InputError, match="Plateaus must be in the order"):
        read_scenario(text.replace('"450 MPa"', '"350 MPa"'))


def test_a_material_lists_its_plateaus() -> None:
    shown = json.loads(Command("materials", "niti-brinson-1993", "--plateaus", "60 degC", "--json")().stdout)
    assert shown["loading_start"] == pytest.approx(8e6 * (60 - 18.4), rel=1e-6)
    assert shown["unloading_end"] == pytest.approx(13.8e6 * (60 - 49), rel=1e-6)
    assert shown["unloading_slope"] == pytest.approx(13.8e6, rel=1e-4)
    assert "is not superelastic" in Command("materials").refused("niti-brinson-1993", "--plateaus", "20 degC")
    with pytest.raises(InputError, match="`mas` has no transformation temperatures"):
        find_plateaus(variants(LAWS["mas"])[0], 300.0)


SCENARIO = """
[element]
kind = "wire"
diameter = "0.5 mm"
length = "100 mm"
density = "6450 kg/m^3"
heat_capacity = "500 J/kg/K"
initial_fraction = 0.0
resistance = { kind = "mixture", rho_A = "8e-7 ohm*m", rho_M = "9e-7 ohm*m" }

[element.law]
LAW

[element.law.plateaus]
temperature = "22 degC"
loading_start = "400 MPa"
loading_end = "450 MPa"
unloading_start = "200 MPa"
unloading_end = "150 MPa"

[element.law.plateaus.second]
temperature = "37 degC"
loading_start = "505 MPa"
loading_end = "555 MPa"
unloading_start = "305 MPa"
unloading_end = "255 MPa"

[mechanism]
kind = "testing-machine"
control = "strain"
gauge_length = "100 mm"

[signals.command]
kind = "triangle"
high = "6 %"
frequency = "0.01 Hz"

[drive]
kind = "temperature"
waveform = { kind = "constant", level = "22 degC" }

[run]
duration = "100 s"
"""
