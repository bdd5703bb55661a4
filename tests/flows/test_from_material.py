"""An element from a material is the one that a scenario with this material builds."""

from __future__ import annotations

from typing import Any

import pytest

import martensite as ms
from martensite.base.errors import ParameterError, UnknownNameError

TEXT = """\
[element]
kind = "{kind}"
material = "flexinol-90"
law = "{law}"
{more}
[environment]
temperature = "22 degC"
cooling = {{ kind = "constant", h = "70 W/m^2/K" }}
[mechanism]
kind = "dead-weight"
mass = "500 g"
[drive]
kind = "current"
waveform = {{ kind = "step", high = "0.4 A", at = "1 s" }}
[run]
duration = "3 s"
"""
WIRE = {"diameter": "0.25 mm", "length": "200 mm"}


def build_in_scenario(kind: str, law: str, numbers: dict[str, str]) -> object:
    more = "\n".join(f'{name} = "{value}"' for name, value in numbers.items())
    return ms.data.read_scenario(TEXT.format(kind=kind, law=law, more=more)).single_system.element


def test_the_material_gives_numbers_law_resistance_and_limits() -> None:
    expected = build_in_scenario("wire", "liang-rogers", WIRE)
    assert ms.Wire(material="flexinol-90", **WIRE) == expected
    assert ms.Wire(material=ms.load_material("flexinol-90"), **WIRE) == expected
    coil: dict[str, Any] = {"diameter": "0.25 mm", "coil_diameter": "2.5 mm", "turns": "20"}
    coil |= {"coil_measure": "mean", "free_length": "20 mm"}
    assert ms.CoilSpring(material="flexinol-90", **coil) == build_in_scenario("coil-spring", "liang-rogers", coil)


def test_what_is_given_wins() -> None:
    wire = ms.Wire(material="flexinol-90", law="tanaka", latent_heat="20 J/g", **WIRE)
    assert wire.law.registered_name == "tanaka" and wire.latent_heat == 2e4
    warmer = ms.Wire(material="flexinol-90", law=wire.law.with_values({"A_f": 400.0}), **WIRE)
    assert warmer.value_of("A_f") == 400.0


def test_what_is_missing_is_said() -> None:
    with pytest.raises(UnknownNameError, match="Did you mean `flexinol-90`"):
        ms.Wire(material="flexinol-9", **WIRE)
    with pytest.raises(ParameterError, match="`wire` needs `length`"):
        ms.Wire(material="flexinol-90", diameter="0.25 mm")  # pyrefly: ignore[missing-argument]
    with pytest.raises(ParameterError, match="`lagoudas` needs `sigma_cal`"):
        ms.Wire(material="flexinol-90", law="lagoudas", **WIRE)
