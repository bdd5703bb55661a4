"""Components without a registry: of a declared class, members by name, whole numbers and rows of numbers.

The default or the annotation of a declaration such as `law: PidLaw = part(...)` gives the class of the component. A
component with members by name, such as the points of a schedule, is a table of tables.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from copy import deepcopy
from inspect import formatannotation, get_annotations
from typing import Any, cast

from martensite.actuators.assembly import Members
from martensite.base.errors import ParameterError
from martensite.base.parameters import FieldDeclaration, Parametrised
from martensite.base.part_kinds import find_annotated

PLAIN = ("Any", "int")
"""Annotations of parts that are plain values."""


def component_class(owner: type[Parametrised], name: str) -> type[Parametrised] | None:
    """Return the class of a component that no registry provides, or None."""
    declared = owner.declarations[name]
    if declared.kind != "part" or declared.registry is not None:
        return None
    if isinstance(declared.default, Parametrised):
        return type(declared.default)
    cls = next((one for one in find_annotated(owner, name) if issubclass(one, Parametrised)), None)
    return None if cls is None or cls.__name__.startswith("Abstract") else cls


def is_members(cls: type[Parametrised] | None) -> bool:
    """Return true for a class with components by names of the user."""
    return cls is not None and issubclass(cls, Members)


def list_nested(owner: type[Parametrised], path: str = "") -> Iterator[tuple[str, str]]:
    """Yield name and path of every value in components of a declared class, at any depth."""
    for part in owner.declarations:
        inner = component_class(owner, part)
        if inner is None or is_members(inner) or not isinstance(inner.declarations, dict):
            continue
        for name, declared in inner.declarations.items():
            if declared.kind != "part" or is_plain(inner, name):
                yield name, f"{path}{part}.{name}"
        yield from list_nested(inner, f"{path}{part}.")


def gather_nested(cls: type[Parametrised], table: Mapping[str, Any]) -> tuple[dict[str, Any], dict[str, str]]:
    """Return a table with parameters moved into the nested tables of their components, and the moved paths.

    A number of a component, such as the `law` of a PID controller, may stand beside those of the whole if its name is
    unique.

    Raises:
        ParameterError: a number is given twice.
    """
    owners: dict[str, list[str]] = {}
    for name, inner in list_nested(cls):
        owners.setdefault(name, []).append(inner)
    nested, moved = deepcopy(dict(table)), dict[str, str]()
    for name in [n for n in table if n not in cls.declarations and len(owners.get(n, ())) == 1]:
        (inner,) = owners[name]
        below = nested
        for part in inner.split(".")[:-1]:
            below = below.setdefault(part, {})
        if name in below:
            raise ParameterError(f"`{name}` and `{inner}` are the same; leave one out.")
        below[name] = nested.pop(name)
        moved[inner] = name
    return nested, moved


def is_plain(owner: type[Parametrised], name: str) -> bool:
    """Return true for a part that is a whole number or a row of numbers."""
    declared = owner.declarations[name]
    return declared.kind == "part" and declared.registry is None and _read_annotation(owner, name) in PLAIN


def convert_plain(declared: FieldDeclaration, name: str, value: Any, path: str) -> Any:
    """Return a whole number or a list of numbers as the value of a part.

    Raises:
        ParameterError: the value is of another type.
    """
    if isinstance(declared.default, int):
        if isinstance(value, bool) or not isinstance(value, int):
            raise ParameterError(f"[{path}] `{name}` must be a whole number, but is {value!r}.")
        return value
    rows = cast("list[Any]", value) if isinstance(value, list) else [None]
    numbers = [one for one in rows if isinstance(one, int | float) and not isinstance(one, bool)]
    if len(numbers) < len(rows):
        raise ParameterError(f"[{path}] `{name}` must be a list of numbers, but is {value!r}.")
    return [float(one) for one in numbers]


def _read_annotation(owner: type[Parametrised], name: str) -> str:
    """Return the annotation of a declaration as text."""
    home = next((base for base in owner.__mro__ if name in get_annotations(base)), owner)
    annotation: Any = get_annotations(home).get(name, "")
    return annotation if isinstance(annotation, str) else formatannotation(annotation)
