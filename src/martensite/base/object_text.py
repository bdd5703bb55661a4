"""Objects as JSON and back: parts, dataclasses, named tuples, enumerations and arrays, by the name of their class.

Saved results hold in this form what was simulated. A file cannot name arbitrary code: only classes of these kinds are
made again, from this package, from installed plug-ins, and from modules that are imported already.
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
    """Return an object as lists, tables and plain values that JSON can hold.

    Raises:
        DataError: it holds an object of another kind, such as a function.
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
    if isinstance(value, list | tuple):
        rows = cast("Any", value)
        items = [encode(one) for one in rows]
        if hasattr(rows, "_fields"):
            return {"class": _name_class(value), "items": items}
        return items if isinstance(value, list) else {"tuple": items}
    raise DataError(f"An object of the class `{type(value).__name__}` cannot be written to a file.")


def decode(kept: Any) -> Any:
    """Return the object that `encode` wrote.

    Raises:
        DataError: a class is unknown here, or is of no kind that a file may name.
        InputError: a part refuses its values.
    """
    if isinstance(kept, list):
        return [decode(one) for one in cast("list[Any]", kept)]
    if not isinstance(kept, dict):
        return kept
    known = cast("dict[str, Any]", kept)
    if "table" in known:
        return {decode(key): decode(one) for key, one in known["table"]}
    if "array" in known:
        return import_module("numpy").array(known["array"])
    if "tuple" in known:
        return tuple(map(decode, known["tuple"]))
    found = _find_class(known["class"])
    if "member" in known:
        return found[known["member"]]
    if "items" in known:
        return found(*map(decode, known["items"]))
    if "named" in known:
        return found(**{name: decode(one) for name, one in known["named"].items()})
    return found


def _name_class(value: Any) -> str:
    named = value if isinstance(value, type) else type(value)
    return f"{named.__module__}:{named.__qualname__}"


def _find_class(name: str) -> Any:
    """Return the class of a name, `MODULE:CLASS`; `DataError` if it is not to be had, or is of no kind that is kept."""
    home, _, path = name.partition(":")
    if home not in sys.modules and home.partition(".")[0] in _list_packages():
        import_module(home)
    found: Any = sys.modules.get(home)
    for one in path.split("."):
        found = getattr(found, one, None)
    if found is None:
        raise DataError(f"Class `{path}` of module `{home}` is unknown here; import that module first.")
    made: Any = found
    if isinstance(found, type) and (issubclass(found, Parametrised | Enum) or is_dataclass(made)):
        return made
    if isinstance(made, type) and hasattr(made, "_fields"):
        return made
    raise DataError(f"`{name}` is no class of a part or of a record.")


def _list_packages() -> set[str]:
    """This package, and those that plug into it."""
    known: Any = entry_points()
    groups = [name for name in known.groups if name.startswith(f"{OWN}.")]
    return {OWN, *(str(one.module).partition(".")[0] for name in groups for one in known.select(group=name))}
