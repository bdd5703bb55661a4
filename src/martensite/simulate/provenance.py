"""User-defined parts of a run with the results of their conformance tests.

The result of `martensite conform` is cached on this computer under the hash of the file. A changed file counts as
not tested.
"""

from __future__ import annotations

import hashlib
import inspect
import json
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any, cast

from martensite.base.caches import cache_folder, make_cache
from martensite.base.files import tell_once
from martensite.base.parameters import Parametrised

OWN = "martensite."
"""Prefix of the modules of this package."""
NOT_TRIED = "not tried"


def tell_conformance(things: Iterable[Any]) -> dict[str, str]:
    """Return each user-defined part with `conforms`, `does not conform` or `not tried`."""
    return {_name_part(cls): find_record(cls) for cls in dict.fromkeys(_list_foreign(things))}


def _list_foreign(things: Iterable[Any]) -> Iterator[type[Parametrised]]:
    """Yield the classes of user-defined parts, at any depth."""
    for thing in things:
        if isinstance(thing, Mapping):
            yield from _list_foreign(cast("Mapping[str, Any]", thing).values())
        elif isinstance(thing, Parametrised):
            classes = (type(part) for part in thing.tree())
            yield from (cls for cls in classes if not cls.__module__.startswith(OWN))


def _name_part(cls: type[Parametrised]) -> str:
    return cls.registered_name or cls.__name__


def find_record(cls: type[Parametrised]) -> str:
    """Return the cached result for the present file of a class."""
    path = _locate_record(cls)
    try:
        holds = path is not None and json.loads(path.read_text("utf-8"))["holds"]
    except (OSError, ValueError, KeyError, TypeError):  # no file or a damaged file
        return NOT_TRIED
    if path is None or not isinstance(holds, bool):
        return NOT_TRIED
    return "conforms" if holds else "does not conform"


def keep_record(cls: type[Parametrised], holds: bool, checks: int) -> None:
    """Cache the result of a user-defined class with a file."""
    path = None if cls.__module__.startswith(OWN) else _locate_record(cls)
    if path is None:
        return
    try:
        make_cache("conformance")
        path.write_text(json.dumps({"holds": holds, "checks": checks}), "utf-8")
    except OSError as error:
        tell_once(f"Warning: what was found of `{_name_part(cls)}` cannot be kept in the cache: {error.strerror}.")


def _locate_record(cls: type[Parametrised]) -> Path | None:
    """Return the path of a cached result; None without a file, as in a notebook."""
    try:
        source = Path(inspect.getsourcefile(cls) or "").read_bytes()
    except (OSError, TypeError):
        return None
    key = hashlib.sha256(source + cls.__qualname__.encode()).hexdigest()[:24]
    return cache_folder() / "conformance" / f"{key}.json"
