"""Start values of the forms: assumed, for kinds that are chosen anew; see `starts.toml`."""

from __future__ import annotations

import tomllib
from functools import cache
from pathlib import Path
from typing import Any, cast

from martensite.materials.names import NAMES
from martensite.parameters import Declared
from martensite.signals.base import DRIVE
from martensite.units import OF_READINGS

FILE = Path(__file__).parents[1] / "starts.toml"
SAMPLES = "=samples"
"""Stands for samples of a signal, up and down again."""
Table = dict[str, Any]


@cache
def starts() -> Table:
    """The whole file."""
    return tomllib.loads(FILE.read_text("utf-8"))


def of_kind(registry: str, kind: str) -> Table:
    """What stands there of a registered kind."""
    return cast("Table", starts().get(registry, {}).get(kind, {}))


def start(registry: str, kind: str, name: str, declared: Declared, unit: str) -> Any:
    """Start value of an entry of a kind, as a scenario writes it; None if there is none.

    Args:
        registry: word for the entries of the registry, such as `law`.
        kind: name of the entry, or of the class of a component that no registry names.
        name: of the number, option or component.
        declared: its declaration.
        unit: SI unit that it has in its place.
    """
    own = of_kind(registry, kind)
    if name in own:
        return own[name]
    if declared.unit == DRIVE or declared.unit in OF_READINGS:
        levels = cast("Table", starts()["levels"].get(unit, {}))
        return levels.get(name, levels.get("high"))
    if name in NAMES and NAMES[name][0] == declared.unit:
        return starts()["material"].get(name)
    return None


def samples(unit: str) -> list[str]:
    """Four samples of a signal in an SI unit: low, high, high, low."""
    levels = cast("Table", starts()["levels"].get(unit, {}))
    high = str(levels.get("high", f"1 {unit}"))
    low = str(levels.get("low", " ".join(["0", *high.split()[1:]])))
    return [low, high, high, low]


def is_start(registry: str, kind: str, name: str, declared: Declared, unit: str, raw: Any) -> bool:
    """Whether what a document holds is a start value, that nobody has changed since."""
    if declared.kind != "parameter" or isinstance(raw, (dict, list)):
        return False
    return raw is not None and start(registry, kind, name, declared, unit) == raw
