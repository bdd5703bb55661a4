"""Laws with numbers from materials, and checks that a material fits a law."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from martensite.base.errors import ParameterError, suggest_name
from martensite.base.parameters import REQUIRED, Parametrised
from martensite.physics.electrical.base import AbstractResistance
from martensite.physics.laws.base import LAWS, AbstractLaw
from martensite.physics.materials.base import Material, load_material, material_names
from martensite.scenario.build import Builder

KIND = "kind"


@dataclass(frozen=True)
class ConfiguredLaw:
    """Law with its numbers and their material."""

    law: AbstractLaw
    material: Material | None
    """None if every number was set."""

    @property
    def cautions(self) -> list[str]:
        """Return sentences about numbers that are probably wrong."""
        other = law_caution(self.material, self.law)
        return [*([other] if other else []), *self.law.cautions()]


def configure_laws(names: Sequence[str], material: str | None, settings: Mapping[str, Any]) -> list[ConfiguredLaw]:
    """Return laws with numbers from settings, then a material, then the defaults.

    Args:
        names: names of registered laws.
        material: name or file of a material. By default the first shipped material with all numbers of all laws, else
            the first one for each law.
        settings: values by parameter, or by law and parameter (`brinson.sigma_s`).

    Raises:
        InputError: a name is unknown, a number is missing or a setting reaches no law.
    """
    classes = {name: LAWS[name] for name in names}
    tables = {name: _select_settings(name, settings, classes) for name in classes}
    _refuse_idle(settings, tables)
    needs = {name: _list_needs(classes[name], tables[name]) for name in classes}
    if material is not None:
        sources = {name: load_material(material) for name in classes}
    else:
        common = _find_first(sorted(set().union(*needs.values())))
        sources = {name: common or _own_material(name, needs[name]) for name in classes}
    return [
        ConfiguredLaw(
            Builder(sources[name]).choose(LAWS, _build_table(name, tables[name], sources[name]), name, draws=True),
            sources[name] if needs[name] or material else None,
        )
        for name in classes
    ]


def _build_table(name: str, own: Mapping[str, Any], material: Material | None) -> dict[str, Any]:
    """Return the table of a law, with the options that its material requires."""
    meant = material.law if material else None
    given = meant if meant and meant["kind"] == name else {}
    return {"kind": name, **given, **own}


def _select_settings(
    name: str, settings: Mapping[str, Any], classes: Mapping[str, type[AbstractLaw]]
) -> dict[str, Any]:
    cut = {key.removeprefix(f"{name}."): v for key, v in settings.items() if key.startswith(f"{name}.")}
    shared = {key: v for key, v in settings.items() if "." not in key}
    single = len(classes) == 1
    declared = classes[name].declarations
    return {**{key: v for key, v in shared.items() if single or key in declared}, **cut}


def _refuse_idle(settings: Mapping[str, Any], tables: Mapping[str, Mapping[str, Any]]) -> None:
    for key in settings:
        if not any(key in table or key.startswith(f"{n}.") for n, table in tables.items()):
            valid = {p for name in tables for p in LAWS[name].declarations}
            raise ParameterError(
                f"The setting `{key}` reaches none of the laws. {suggest_name(key.rpartition('.')[2], valid)}"
            )


def _list_needs(cls: type[AbstractLaw], table: Mapping[str, Any]) -> list[str]:
    return [
        name
        for name, declared in cls.declarations.items()
        if declared.kind == "parameter" and declared.default is REQUIRED and name not in table
    ]


def _find_first(needed: Sequence[str]) -> Material | None:
    """Return the first shipped material with all needed numbers that is not bound to a law."""
    for name in material_names():
        material = load_material(name)
        if material.law is None and all(number in material.values for number in needed):
            return material
    return None


def _own_material(law: str, needed: Sequence[str]) -> Material:
    first = _find_first(needed)
    if first is not None:
        return first
    nearest = max(map(load_material, material_names()), key=lambda m: sum(n in m.values for n in needed))
    missing = ", ".join(f"`{name}`" for name in needed if name not in nearest.values)
    raise ParameterError(
        f"No shipped material holds all numbers of the law `{law}`; `{nearest.name}` comes nearest "
        f"and lacks {missing}: choose it as the material and set the rest."
    )


# ---------------------------------------------------------------- does a material fit a law?


def law_words(law: AbstractLaw) -> dict[str, str]:
    """Return the kind and options of a law as a scenario writes them."""
    words = {n: getattr(law, n) for n, d in law.declarations.items() if d.kind == "option"}
    return {KIND: law.registered_name, **words}


def law_caution(material: Material | None, element: Parametrised) -> str | None:
    """Return a sentence if an element uses a material in another law than its own, else None."""
    if material is None or material.law is None:
        return None
    for part in element.tree():
        if isinstance(part, AbstractLaw):
            used = law_words(part)
            meant = {name: word for name, word in material.law.items() if name in (KIND, *used)}
            if any(used.get(name) != word for name, word in meant.items()):
                return _describe_mismatch(material.name, meant, used)
    return None


def override_caution(material: Material | None, element: Parametrised) -> str | None:
    """Return a sentence if a scenario overrides fitted numbers of a material, else None."""
    if material is None:
        return None
    fitted = {name: number.value for name, number in material.values.items() if number.kind == "fitted"}
    laws = [part for part in element.tree() if isinstance(part, AbstractLaw)]
    names = [n for law in laws for n in law.declarations if n in fitted and getattr(law, n) != fitted[n]]
    if not names:
        return None
    listed = ", ".join(f"`{name}`" for name in dict.fromkeys(names))
    return (
        f"Fitted numbers of material `{material.name}` are overridden by the scenario: {listed}. Its errors and "
        "intervals do not count; leave them out of [element.law] to use what was fitted."
    )


def rphase_caution(material: Material | None, element: Parametrised) -> str | None:
    """Return a sentence if the law or the resistance ignores an R-phase, else None."""
    parts = list(element.tree())
    law = next((part for part in parts if isinstance(part, AbstractLaw)), None)
    model = next((part for part in parts if isinstance(part, AbstractResistance)), None)
    start, name = (material.values.get("R_s"), material.name) if material else (None, "")
    if law is None or model is None or not (law.has_rphase or start):
        return None
    blind = [] if law.has_rphase else [f"law `{law.registered_name}`"]
    blind += [] if model.three_phases else [f"resistance `{model.registered_name}`"]
    where = f"Material `{name}` has an R-phase (from {start.text} on cooling)" if start else "The law has an R-phase"
    sentence = (
        f"{where}, which {' and '.join(blind)} {'do' if len(blind) > 1 else 'does'} not know: resistance on cooling, "
        "and what is sensed by it, may be far off. Take law `r-phase` with resistance `three-phase`."
    )
    return sentence if blind else None


def _describe_mismatch(name: str, meant: dict[str, str], used: dict[str, str]) -> str:
    if meant[KIND] != used[KIND]:
        here = f"law `{used[KIND]}`"
    else:
        other = {key: used[key] for key, word in meant.items() if used[key] != word}
        here = " and ".join(f"`{key} = {word}`" for key, word in other.items())
    options = ", ".join(f"`{key} = {word}`" for key, word in meant.items() if key != KIND)
    return (
        f"The numbers of material `{name}` hold for law `{meant[KIND]}`"
        f"{f' with {options}' if options else ''}, but {here} is used here: its errors and "
        "intervals do not count. A scenario that leaves the law out takes that of the material."
    )
