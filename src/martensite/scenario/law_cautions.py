"""Whether the numbers of a material meet the law that they hold for."""

from __future__ import annotations

from martensite.base.parameters import Parametrised
from martensite.physics.laws.base import AbstractLaw
from martensite.physics.materials.base import Material

KIND = "kind"


def law_words(law: AbstractLaw) -> dict[str, str]:
    """Name and options of a law, as a scenario writes them."""
    words = {n: getattr(law, n) for n, d in law.declarations.items() if d.kind == "option"}
    return {KIND: law.registered_name, **words}


def law_caution(material: Material | None, element: Parametrised) -> str | None:
    """A sentence if an element uses the numbers of a material in another law than theirs."""
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
    """A sentence if a scenario writes other numbers than those that were fitted for a material."""
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
