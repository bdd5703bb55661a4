"""Classes that a declared part may have, from its annotation."""

from __future__ import annotations

import sys
from functools import cache
from inspect import get_annotations
from types import UnionType
from typing import Any, Union, get_args, get_origin

from martensite.base.errors import ParameterError
from martensite.base.field_types import Given


@cache
def find_annotated(owner: type[Any], name: str) -> tuple[type[Any], ...]:
    """Return the classes that the annotation of a field names; empty if only type checkers know them."""
    home = next((base for base in owner.__mro__ if name in get_annotations(base)), owner)
    annotation: Any = get_annotations(home).get(name)
    try:  # a text with `from __future__ import annotations`
        if isinstance(annotation, str):
            annotation = eval(annotation, dict(vars(sys.modules[home.__module__])))
    except (NameError, TypeError):
        return ()
    return tuple(_list_classes(annotation))


def _list_classes(annotation: Any) -> list[type[Any]]:
    """Return the classes of a union or of `Given[AbstractLaw]`; the origin of a generic type such as a tuple."""
    origin: Any = get_origin(annotation)
    if origin in (Union, UnionType, Given):
        return [one for inner in get_args(annotation) for one in _list_classes(inner)]
    cls: Any = annotation if origin is None else origin
    return [cls] if isinstance(cls, type) else []


def require_part(owner: type[Any], title: str, name: str, value: Any, kind: type[Any]) -> None:
    """Raise `ParameterError` if a part is a class, or not an object of the declared classes of this `kind`."""
    if isinstance(value, type):
        label = value.__name__
        raise ParameterError(f"`{name}` of `{title}` is the class `{label}`; give an object, such as `{label}(...)`.")
    allowed = find_annotated(owner, name)
    parts = tuple(one for one in allowed if issubclass(one, kind))
    if not parts or isinstance(value, allowed):
        return
    wanted = " or ".join(f"`{one.__name__.removeprefix('Abstract')}`" for one in parts)
    given = f"the text `{value}`" if isinstance(value, str) else f"`{type(value).__name__}`"
    raise ParameterError(f"`{name}` of `{title}` must be an object of the class {wanted}, but is {given}.")


def refuse_unnamed(title: str, given: tuple[Any, ...], names: Any) -> None:
    """Raise `ParameterError` if values are given without names."""
    if given:
        example = ", ".join(f"{name}=..." for name in list(names)[:3])
        raise ParameterError(f"`{title}` takes its values by name; write `{title}({example})`.")
