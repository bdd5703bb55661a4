"""Everything registered is documented and can be built."""

import re

import builders
import pytest
from builders import REGISTRIES, registered

from martensite.actuators.assembly import System
from martensite.actuators.elements.limits import ElementLimits
from martensite.base import units
from martensite.base.errors import UnitError
from martensite.base.parameters import Number, Parametrised, param
from martensite.physics.thermal.base import Environment
from martensite.scenario.citations import read_bibliography
from martensite.signals.base import DRIVE

CLASSES = [*registered(), System, Environment, ElementLimits]


def undocumented(cls: type[Parametrised]) -> list[str]:
    """What a class leaves unsaid."""
    missing = [] if cls.__dict__.get("__doc__") else ["the class"]
    for name, declared in cls.declarations.items():
        if not declared.doc.strip():
            missing.append(f"`{name}`")
        if declared.kind == "parameter" and not declared.unit:
            missing.append(f"unit of `{name}`")
    return missing


@pytest.mark.parametrize("cls", CLASSES, ids=lambda cls: cls.__name__)
def test_declarations_are_documented_allowed_and_cited(cls):
    assert undocumented(cls) == []
    assert set(cls.cites) <= set(read_bibliography())
    for name, declared in cls.declarations.items():
        if declared.kind == "parameter" and declared.unit != DRIVE:
            units.require_unit(declared.unit)
        if declared.kind == "parameter" and isinstance(declared.default, float):
            assert declared.convert(cls.__name__, name, declared.default) == declared.default


@pytest.mark.parametrize("kind", REGISTRIES)
def test_names_are_lower_case_words(kind):
    names = REGISTRIES[kind].names()
    assert names
    for name in names:
        assert re.fullmatch(r"[a-z][a-z0-9]*(-[a-z0-9]+)*", name)
        assert REGISTRIES[kind][name].registered_name == name


@pytest.mark.parametrize("cls", registered(), ids=lambda cls: cls.__name__)
def test_examples_survive_a_round_trip_through_their_values(cls):
    thing = builders.example(cls)
    changed = {leaf.path: leaf.value for leaf in thing.leaves()}
    assert thing.with_values(changed) == thing


def test_a_unit_that_is_none_is_noticed():
    with pytest.raises(UnitError):
        units.require_unit("amps of some kind")


def test_silence_is_noticed():
    class Silent(Parametrised):
        size: Number = param("", " ")

    assert undocumented(Silent) == ["the class", "`size`", "unit of `size`"]
