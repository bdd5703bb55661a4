"""JSON form of parts, dataclasses, named tuples, enumerations and arrays, by class name.

Saved results contain the simulated objects in this form. A file cannot name arbitrary code: only classes of these kinds
are created, from this package, installed plug-ins, and modules that are already imported.
"""

from __future__ import annotations

import sys
from collections.abc import Mapping
from dataclasses import fields, is_dataclass
from enum import Enum
from importlib import import_module
from importlib.metadata import entry_points
from typing import Any, cast

from martensite.base.errors import DataError
from martensite.base.parameters import Parametrised

OWN = __name__.partition(".")[0]
PLAIN = (type(None), bool, int, float, str)


def encode(value: Any) -> Any:
    """Return an object as lists, tables and plain values for JSON.

    Raises:
        DataError: the object has another kind, such as a function.
    """
    if type(value) in PLAIN:
        return value
    if isinstance(value, Mapping):
        table = cast("Mapping[Any, Any]", value)
        return {"table": [[encode(key), encode(one)] for key, one in table.items()]}
    if hasattr(value, "tolist"):  # an array or a number of NumPy
        listed: Any = value.tolist()
        return {"array": listed} if value.ndim else listed
    if isinstance(value, type):
        return {"class": _name_class(value)}
    if isinstance(value, Enum):
        return {"class": _name_class(value), "member": value.name}
    if isinstance(value, Parametrised):
        return {"class": _name_class(value), "named": {n: encode(one) for n, one in value.arguments().items()}}
    if is_dataclass(value):
        return {"class": _name_class(value), "named": {f.name: encode(getattr(value, f.name)) for f in fields(value)}}
    if isinstance(value, (list, tuple)):
        return _encode_items(cast("list[Any]", value))
    raise DataError(f"An object of the class `{type(value).__name__}` cannot be written to a file.")


def _encode_items(values: Any) -> Any:
    items = [encode(one) for one in values]
    if hasattr(values, "_fields"):
        return {"class": _name_class(values), "items": items}
    return items if isinstance(values, list) else {"tuple": items}


def decode(data: Any) -> Any:
    """Return the object that `encode` wrote.

    Raises:
        DataError: a class is unknown or not allowed.
        InputError: a part refuses its values.
    """
    if isinstance(data, list):
        return [decode(one) for one in cast("list[Any]", data)]
    if not isinstance(data, dict):
        return data
    table = cast("dict[str, Any]", data)
    if "table" in table:
        return {decode(key): decode(one) for key, one in table["table"]}
    if "array" in table:
        return import_module("numpy").array(table["array"])
    if "tuple" in table:
        return tuple(map(decode, table["tuple"]))
    cls = _find_class(table["class"])
    if "member" in table:
        return cls[table["member"]]
    if "items" in table:
        return cls(*map(decode, table["items"]))
    if "named" in table:
        return cls(**{name: decode(one) for name, one in table["named"].items()})
    return cls


def _name_class(value: Any) -> str:
    cls = value if isinstance(value, type) else type(value)
    return f"{cls.__module__}:{cls.__qualname__}"


def _find_class(name: str) -> Any:
    home, _, path = name.partition(":")
    if home not in sys.modules and home.partition(".")[0] in _list_packages():
        import_module(home)
    cls: Any = sys.modules.get(home)
    for one in path.split("."):
        cls = getattr(cls, one, None)
    if cls is None:
        raise DataError(f"Class `{path}` of module `{home}` is unknown here; import that module first.")
    any_class: Any = cls
    if isinstance(cls, type) and (
        issubclass(cls, Parametrised | Enum) or is_dataclass(any_class) or hasattr(any_class, "_fields")
    ):
        return any_class
    raise DataError(f"`{name}` is no class of a part or of a record.")


def _list_packages() -> set[str]:
    """Return this package and its plug-ins."""
    points: Any = entry_points()
    groups = [name for name in points.groups if name.startswith(f"{OWN}.")]
    return {OWN, *(str(one.module).partition(".")[0] for name in groups for one in points.select(group=name))}
