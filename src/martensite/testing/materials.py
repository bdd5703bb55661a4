"""Suite for materials: ordered temperatures, allowed values, a law that passes its checks."""

from typing import Any

from martensite.base.errors import ParameterError
from martensite.base.parameters import REQUIRED
from martensite.physics.laws.base import LAWS, AbstractLaw
from martensite.physics.materials.base import Material
from martensite.scenario.catalogue import list_registries
from martensite.scenario.citations import read_bibliography
from martensite.testing.conformance import require_condition
from martensite.testing.laws import check_bounds, check_direction, check_stiffness

ASCENDING = (("M_f", "M_s"), ("A_s", "A_f"), ("M_s", "A_f"), ("sigma_s", "sigma_f"))
"""Pairs of parameters whose first is smaller."""


def build_laws(material: Material) -> list[AbstractLaw]:
    """Return the law of a material, else every law for which its values suffice."""
    values = {name: number.value for name, number in material.values.items()}
    options: dict[str, Any] = dict(material.law or {})
    names = [options.pop("kind")] if options else LAWS.names()
    laws: list[AbstractLaw] = []
    for cls in (LAWS[name] for name in names):
        given = {n: values[n] for n in cls.declarations if n in values} | options
        needed = [n for n, d in cls.declarations.items() if d.default is REQUIRED]
        if all(n in given or cls.declarations[n].kind == "option" for n in needed):
            usual = {n: cls.declarations[n].choices[0] for n in needed if n not in given}
            laws.append(cls(**usual | given))
    return laws


def check_order(material: Material) -> None:
    """Start and finish values are in order."""
    for first, second in ASCENDING:
        if first in material.values and second in material.values:
            one, other = material.values[first], material.values[second]
            require_condition(
                one.value < other.value,
                f"`{first}` is {one.text}, and `{second}` {other.text}; the first must be smaller.",
            )


def check_bounds_of_parts(material: Material) -> None:
    """Every value is allowed by each part that uses it."""
    for registry in list_registries().values():
        for cls in (registry[name] for name in registry.names()):
            for name in set(cls.declarations) & set(material.values):
                declared, number = cls.declarations[name], material.values[name]
                if declared.kind == "parameter" and declared.unit == number.unit:
                    _require_allowed(cls.registered_name, declared, name, number.value)


def _require_allowed(part: str, declared: Any, name: str, value: float) -> None:
    try:
        declared.convert(part, name, value)
    except ParameterError as error:
        require_condition(False, str(error))


def check_sources(material: Material) -> None:
    """A material describes its contents and its limits, and every source is in the bibliography."""
    require_condition(material.summary.strip(), "It has no `summary`.")
    require_condition(material.limits.strip(), "It does not say its `limits`.")
    bibliography = read_bibliography()
    unknown = [source.cite for source in material.sources.values() if source.cite not in bibliography]
    require_condition(not unknown, f"{', '.join(unknown)} is not in the bibliography; see `martensite cite`.")


def check_laws(material: Material) -> None:
    """Its values suffice for a law, which passes the main checks."""
    laws = build_laws(material)
    require_condition(laws, "Its numbers are not enough for any law.")
    for law in laws:
        for check in (check_bounds, check_direction, check_stiffness):
            check(law)
