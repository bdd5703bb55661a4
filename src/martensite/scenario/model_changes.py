"""Differences of a model from the plant: parameters, or parts of another kind.

    [observer.model]
    "element.diameter" = "0.37 mm"
    "element.law" = { kind = "r-phase", R_s = "56 degC", … }

A part of another kind keeps the parameters of the plant that both kinds have, unless the table changes them.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any, cast

from martensite.actuators.elements.base import ELEMENTS
from martensite.actuators.mechanisms.base import MECHANISMS
from martensite.base.errors import ParameterError
from martensite.base.registry import Registry
from martensite.physics.electrical.base import RESISTANCES, SOURCES
from martensite.physics.laws.base import LAWS
from martensite.physics.thermal.base import COOLING
from martensite.scenario.build import Table, as_table
from martensite.scenario.overrides import change_document

KIND = "kind"
KINDS: dict[str, Registry[Any]] = {
    "element": ELEMENTS,
    "law": LAWS,
    "resistance": RESISTANCES,
    "cooling": COOLING,
    "mechanism": MECHANISMS,
    "drive": SOURCES,
    "driver": SOURCES,
}
"""Registries by the last word of the path of a part."""


def change_parts(document: Table, table: Any) -> dict[str, Any]:
    """Return a copy of a scenario with the changes of a model.

    Raises:
        InputError: the change is not a table, or the kind of a part is unknown.
    """
    changed = dict(document)
    for path, value in list_changes(table):
        if path.rpartition(".")[2] in KINDS:
            value = _exchange_part(_find_table(changed, path), as_table(value, path), path)
        changed = change_document(changed, {path: value})
    return changed


def list_changes(table: Any, prefix: str = "") -> Iterator[tuple[str, Any]]:
    """Yield the dotted paths of changed parameters and parts, with their new values.

    Raises:
        ParameterError: the change is not a table.
    """
    if not isinstance(table, dict):
        raise ParameterError(
            f'A model is a table of changed values, such as `{{ "element.diameter" = "0.37 mm" }}`, but is {table!r}.'
        )
    for key, value in cast("dict[str, Any]", table).items():
        if isinstance(value, dict) and KIND not in value:
            yield from list_changes(value, f"{prefix}{key}.")
        else:
            yield f"{prefix}{key}", value


def _find_table(document: Mapping[str, Any], path: str) -> dict[str, Any]:
    """Return the table of a part; empty if a material or a default describes it."""
    table: Any = document
    for key in path.split("."):
        table = table.get(key, {}) if isinstance(table, dict) else {}
    return as_table(table, path)


def _exchange_part(before: Mapping[str, Any], after: dict[str, Any], path: str) -> dict[str, Any]:
    """Return the table of a part that may be of another kind."""
    if after.get(KIND) in (None, before.get(KIND)):
        return {**before, **after}
    kinds = KINDS[path.rpartition(".")[2]]
    old, new = (kinds[str(one[KIND])].declarations if KIND in one else {} for one in (before, after))
    both = [name for name in before if name in old and name in new and old[name].kind == new[name].kind != "option"]
    return {**{name: before[name] for name in both if old[name].unit == new[name].unit}, **after}
