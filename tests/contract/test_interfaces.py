"""A class that lacks a method of its kind is refused where it is registered, or made."""

from __future__ import annotations

import inspect
from pathlib import Path
from typing import Any

import pytest
from command import Command

from martensite.actuators.mechanisms.base import AbstractMechanism
from martensite.base.errors import InputError, MissingMethodError
from martensite.base.interfaces import require_methods
from martensite.base.parameters import Number, Parametrised, param
from martensite.base.registry import Registry
from martensite.design.sweep.backends.base import BACKENDS
from martensite.design.sweep.sampling.samples import DESIGNS
from martensite.physics.kinetics.strips import AbstractStripLaw
from martensite.physics.laws.base import LAWS
from martensite.scenario.catalogue import list_registries
from martensite.simulate.measures.base import MEASURES
from martensite.studies.base import STUDIES

EVERY: dict[str, Registry[Any]] = {
    **list_registries(blocks=True),
    **{registry.kind: registry for registry in (MEASURES, STUDIES, BACKENDS, DESIGNS)},
}


def asked(cls: type) -> dict[str, type]:
    """The methods that the bases of a class leave to it, and the base of each."""
    found: dict[str, type] = {}
    for base in cls.__mro__:
        for name, value in vars(base).items():
            flag = getattr(value, "require_where", None)
            if getattr(value, "__isabstractmethod__", False) or (flag and getattr(cls, flag)):
                found[name] = base
    return found


CASES = [
    (kind, cls, name)
    for kind, registry in EVERY.items()
    for cls in (registry[name] for name in registry.names())
    for name in asked(cls)
]


@pytest.mark.parametrize("wanted", EVERY)
def test_a_method_that_is_missing_is_named(wanted: str) -> None:
    for kind, cls, name in CASES:
        if kind == wanted:
            require_named(kind, cls, name)


def require_named(kind: str, cls: type, name: str) -> None:
    base = asked(cls)[name]
    lacking = type("Lacking", (cls,), {name: vars(base)[name], "__module__": "mine"})
    with pytest.raises(MissingMethodError) as caught:
        EVERY[kind].register(f"test-{kind}")(lacking)
    assert f"test-{kind}" not in EVERY[kind].names()
    sentence = str(caught.value)
    assert sentence.startswith("`Lacking` in mine must define `")
    purpose = (inspect.getdoc(vars(base)[name]) or "").partition("\n")[0].rstrip(".")
    assert purpose
    assert f"`{name}(" in sentence
    assert f": {purpose}" in sentence
    assert f"`{base.__qualname__}` in {base.__module__}" in sentence


def test_all_kinds_are_looked_at() -> None:
    assert {kind for kind, _, _ in CASES} == set(EVERY)


class Half(AbstractStripLaw):
    """A law of which half is written."""

    def remaining_fracton(self, xp: Any, distance: Any) -> Any:
        return distance


def test_several_methods_stand_in_one_sentence() -> None:
    with pytest.raises(MissingMethodError) as caught:
        LAWS.register("test-half")(Half)
    assert str(caught.value) == (
        f"`Half` in {__name__} must define `young(fractions)`: Return Young's modulus [Pa]; "
        "`remaining_fraction(xp, distance)`: Return the fraction that a process leaves at a distance from its finish "
        "line [-] "
        "(see `AbstractPhaseDiagram` in martensite.physics.kinetics.diagram and "
        "`AbstractStripLaw` in martensite.physics.kinetics.strips). "
        "Is `remaining_fracton` meant as `remaining_fraction`?"
    )


def test_a_class_that_is_not_registered_is_refused_when_it_is_made() -> None:
    with pytest.raises(InputError, match=rf"`Half` in {__name__} must define"):
        Half()  # pyrefly: ignore[missing-argument]


def test_a_method_that_a_flag_asks_for_is_missing_with_the_flag_alone() -> None:
    static = type("Static", (AbstractMechanism,), {"static": True})
    moving = type("Moving", (AbstractMechanism,), {})
    said = []
    for cls in (static, moving):
        with pytest.raises(MissingMethodError) as caught:
            require_methods(cls)
        said.append("`load_line(memory)`" in str(caught.value))
    assert said == [True, False]


def test_what_is_complete_is_made() -> None:
    class Whole(Parametrised):
        """Nothing is asked of it."""

        size: Number = param("m", "size", default=1.0)

    assert Whole().size == 1.0


def test_the_command_line_says_it_in_one_sentence(tmp_path: Path) -> None:
    (tmp_path / "half_a_wave.py").write_text(
        "from martensite.signals.base import WAVEFORMS, AbstractWaveform\n"
        "@WAVEFORMS.register('half-a-wave')\n"
        "class HalfAWave(AbstractWaveform):\n"
        "    'A waveform without values.'\n",
        encoding="utf-8",
    )
    sentence = Command("list", "waveform").refused("--import", str(tmp_path / "half_a_wave.py"))
    assert "`HalfAWave` in half_a_wave must define `value(time)`: Return the signal at `time` [s]" in sentence
