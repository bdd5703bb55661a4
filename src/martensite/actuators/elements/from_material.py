"""Values of an element from a material: `Wire(material="flexinol-90", diameter="0.25 mm", …)`.

Given arguments take precedence. Omitted parameters come from the material under the same name. The default law is the
law of the material, else the typical one; the default resistance is the mixture. Values that the material lacks must be
given.
"""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from martensite.base.parameters import Parametrised
from martensite.base.registry import Registry
from martensite.physics.materials.base import Material, load_material

ASSUMED_KINDS = {"resistance": "mixture"}
"""Component -> default kind."""


def complete_from_material(
    cls: type[Parametrised], material: Material | str | Path, given: Mapping[str, Any]
) -> dict[str, Any]:
    """Return the arguments of a class: given values, and the rest from a material.

    Raises:
        InputError: the material or a named component does not exist.
    """
    source = material if isinstance(material, Material) else load_material(material)
    values = dict(given)
    for name, declared in cls.declarations.items():
        value = values.get(name)
        if declared.registry is not None and (value is None or isinstance(value, str)):
            part = _build_part(name, declared.registry, value, source)
            if part is not None:
                values[name] = part
        elif value is None and declared.registry is None and isinstance(declared.default, Parametrised):
            inner = type(declared.default)
            values[name] = inner(**complete_from_material(inner, source, {}))
        elif value is None and name in source.values:
            values[name] = source.values[name].text
    return values


def _build_part(name: str, registry: Registry[Any], kind: str | None, material: Material) -> Parametrised | None:
    """Return a component with values of a material; None if its default is sufficient."""
    own = material.law if name == "law" and material.law is not None else {}
    kind = kind or own.get("kind") or ASSUMED_KINDS.get(name)
    if name == "law":
        kind = kind or registry.typical
    if kind is None:
        return None
    cls = registry[kind]
    options = {key: value for key, value in own.items() if key in cls.declarations}
    return cls(**complete_from_material(cls, material, options))
