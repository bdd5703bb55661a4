"""Heat-loss correlations in scenario files: by name, with a fluid, combined, and refused."""

from __future__ import annotations

from typing import Any

import pytest
from one_wire import hang, write_wire

import martensite as ms
from martensite.base.errors import InputError
from martensite.physics.thermal.base import AbstractCooling
from martensite.scenario.citations import list_citations
from martensite.scenario.overrides import change_document
from martensite.scenario.scenario import Scenario, read_scenario

SCENARIO = write_wire(
    law='"liang-rogers"',
    diameter="0.381 mm",
    length="273 mm",
    ambient="25 degC",
    cooling="COOLING",
    mechanism=hang("400 g"),
    drive='kind = "power"\nwaveform = { kind = "step", high = "0.5 W", at = "1 s" }',
    run='duration = "100 s"\ntolerance = 1e-3',
)


def scenario(cooling: str) -> Scenario:
    return read_scenario(SCENARIO.replace("COOLING", cooling))


def cooling_of(text: str) -> AbstractCooling:
    return scenario(text).single_system.environment.cooling


def sentence(cooling: str) -> str:
    """The sentence with which a scenario is refused."""
    with pytest.raises(InputError) as caught:
        scenario(cooling)
    return str(caught.value)


COMBINED = (
    '{ kind = "combined", convection = { kind = "lefevre-ede", fluid = "water" }, '
    'radiation = { kind = "radiation", emissivity = 0.5 } }'
)
BUILT: list[tuple[str, AbstractCooling]] = [
    ('"churchill-chu"', ms.thermal.ChurchillChu()),
    ('{ kind = "churchill-chu" }', ms.thermal.ChurchillChu(fluid=ms.thermal.Air())),
    ('{ kind = "morgan", fluid = "oil" }', ms.thermal.Morgan(fluid=ms.thermal.Oil())),
    (
        '{ kind = "morgan", fluid = { kind = "air", pressure = "60 kPa" } }',
        ms.thermal.Morgan(fluid=ms.thermal.Air(pressure=60e3)),
    ),
    ('{ kind = "morgan", fluid = { pressure = "60 kPa" } }', ms.thermal.Morgan(fluid=ms.thermal.Air(pressure=60e3))),
    (
        '{ kind = "lefevre-ede", gravity = "9.81 m/s^2", fluid = { kind = "air-table", rows = "kossoski" } }',
        ms.thermal.LeFevreEde(gravity=9.81, fluid=ms.thermal.AirTable(rows="kossoski")),
    ),
    ('{ kind = "churchill-bernstein", speed = "1.5 m/s" }', ms.thermal.ChurchillBernstein(speed=1.5)),
    (
        COMBINED,
        ms.thermal.CombinedCooling(
            convection=ms.thermal.LeFevreEde(fluid=ms.thermal.Water()), radiation=ms.thermal.Radiation(emissivity=0.5)
        ),
    ),
]


@pytest.mark.parametrize(("text", "built"), BUILT, ids=[text for text, _ in BUILT])
def test_what_is_written_is_built(text: str, built: AbstractCooling) -> None:
    assert cooling_of(text) == built


def test_a_subsection_means_the_same_as_an_inline_table() -> None:
    split = SCENARIO.replace("cooling = COOLING\n", "") + (
        '\n[environment.cooling]\nkind = "combined"\nradiation = { kind = "radiation", '
        'emissivity = 0.5 }\n\n[environment.cooling.convection]\nkind = "lefevre-ede"\n'
        'fluid = "water"\n'
    )
    assert read_scenario(split).system == scenario(COMBINED).system


def test_a_fluid_that_is_not_named_can_be_changed() -> None:
    found: Any = change_document(
        {"environment": {"cooling": {"kind": "churchill-chu"}}}, {"environment.cooling.fluid.pressure": "50 kPa"}
    )
    assert found["environment"]["cooling"]["fluid"] == {"pressure": "50 kPa"}
    assert "environment.cooling.fluid.pressure" in {leaf.path for leaf in scenario('"churchill-chu"').system.leaves()}


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ('"churchil-chu"', "Did you mean `churchill-chu`"),
        ('{ kind = "morgan", fluid = "watr" }', "Did you mean `water`"),
        ('{ kind = "morgan", fluid = { kind = "air", presure = "1 Pa" } }', "mean `pressure`"),
        ('{ kind = "morgan", pressure = "60 kPa" }', "`morgan` has no `pressure`"),
        ('"radiation"', "`radiation` needs `emissivity`"),
        ('{ kind = "radiation", emissivity = 1.2 }', "must be between 0 and 1, but is 1.2"),
        ('"churchill-bernstein"', "`churchill-bernstein` needs `speed` [m/s]"),
        ('{ kind = "churchill-bernstein", speed = "-1 m/s" }', "must be above 0 m/s"),
        ('{ kind = "combined", convection = "morgan" }', "needs `radiation`"),
    ],
)
def test_what_cannot_be_meant_is_refused(text: str, words: str) -> None:
    assert words in sentence(text)


def test_a_wire_in_still_air_settles_where_the_film_coefficient_says() -> None:
    found = scenario('"churchill-chu"')
    run = found.run()
    wire, environment = found.single_system.element, found.single_system.environment
    final = run["temperature"][-1]
    from martensite.kernels import floats

    assert wire.heat_loss(floats, final, environment) == pytest.approx(0.5, rel=2e-3)
    assert 45.0 < final - 273.15 < 75.0


def test_water_cools_far_more_than_air() -> None:
    air, water = (
        scenario(f'{{ kind = "churchill-chu", fluid = "{fluid}" }}').run()["temperature"][-1]
        for fluid in ("air", "water")
    )
    assert water - 298.15 < 0.05 * (air - 298.15)


def test_a_cold_ambient_in_water_is_cautioned() -> None:
    calm = scenario('{ kind = "morgan", fluid = "water" }').single_system.environment
    assert calm.cautions() == []
    cold = calm.with_values({"temperature": 275.0})
    assert ["`water` is known" in caution for caution in cold.cautions()] == [True]
    assert "275.00 K lies outside the 283.15 K to 373.15 K" in cold.cautions()[0]


def test_the_sources_are_cited() -> None:
    keys = list_citations(scenario(COMBINED).system)
    assert {"lefevre-ede", "kossoski2018", "iapws-sr6-08"} <= set(keys)
