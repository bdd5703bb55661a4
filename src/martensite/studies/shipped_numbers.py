"""Shipped computed numbers of a study, in its `results.json`.

The file holds the numbers of all parts, the version of the package and a fingerprint of the computing files; words and
verdicts are those of `claims.toml`, which can change without a computation.

    python -m martensite.studies.shipped_numbers NAME...             compute the numbers of studies, draw their figures
    python -m martensite.studies.shipped_numbers --figures NAME...   draw the figures only

The figure is shipped as `figure.svg`, so that pages show it without a computation. The usual compiler optimises;
compile without `MARTENSITE_CFLAGS`, because rounding can change the end of a search.

A test compares fingerprints. The tests of the claims recompute all parts that do not wander and compare their numbers.
Slow tests compute the others.
"""

from __future__ import annotations

import hashlib
import json
import os
import re
import sys
from collections.abc import Iterator, Mapping
from importlib.metadata import version
from numbers import Real
from pathlib import Path
from types import SimpleNamespace
from typing import Any

from martensite.base.files import write_file
from martensite.studies.base import Claim, StudyReport, load_study
from martensite.studies.tables import FIGURE, RESULTS, TableStudy, read_results

FOLDER = Path(__file__).parent
COMPUTING = (".py", ".toml", ".csv")
"""Endings of files with an effect on numbers."""
ABOUT_WORDS = re.compile(r"claims\.toml|__init__\.py|.*figure\.py|.*panels\.py")
"""Files of a study without an effect on numbers."""
OTHERS = re.compile(r"^from martensite\.studies\.(\w+)", re.MULTILINE)
SHARED = ("base", "tables", "claim_tables", "shipped_numbers", "figures", "result_cache")
"""Modules of all studies without an effect on numbers."""
DIGITS = 12
"""Stored significant digits."""
CLOSE, FAINT = 2e-3, 1e-9
"""Relative and absolute tolerance of a number between machines."""
LOOSE = 4.0
"""Relative tolerance of a number from a wandering search."""


def fingerprint_study(folder: Path) -> str:
    """Return a hash of the program behind the numbers of a study."""
    digest, folders = hashlib.sha256(), [folder]
    for place in folders:
        for path in sorted(place.iterdir()) if place.is_dir() else [place.with_suffix(".py")]:
            if path.suffix in COMPUTING and not ABOUT_WORDS.fullmatch(path.name):
                text = path.read_text("utf-8")
                digest.update(f"{path.relative_to(folder.parent)}\n{text}".encode())
                named = (FOLDER / name for name in sorted(set(OTHERS.findall(text))) if name not in SHARED)
                folders += [other for other in named if other not in folders]
    return digest.hexdigest()[:12]


def write_results(study: TableStudy, folder: Path) -> Path:
    """Compute all parts and write their numbers next to the tables."""
    numbers = {part: simplify_numbers(study.part_numbers(part)) for part in study.table["parts"]}
    origin = {"version": version("martensite"), "made_by": fingerprint_study(folder)}
    path = folder / RESULTS
    write_file(path, json.dumps({**origin, "numbers": numbers}, indent=1, ensure_ascii=False).encode() + b"\n")
    return path


def simplify_numbers(numbers: Mapping[str, Any]) -> dict[str, Any]:
    """Return the numbers of a part as JSON; of objects only numbers and texts."""
    return {name: _simplify(value) for name, value in numbers.items()}


def _simplify(value: Any) -> Any:
    match value:
        case bool() | str() | None:
            return value
        case int():
            return value
        case Real():
            return float(f"{float(value):.{DIGITS}g}")
        case Mapping():
            return {str(key): _simplify(one) for key, one in value.items()}
        case list() | tuple() if not hasattr(value, "_fields"):
            return [_simplify(one) for one in value]
        case _:
            return {name: _simplify(one) for name, one in _list_attributes(value)}


def _list_attributes(value: Any) -> Iterator[tuple[str, Any]]:
    """Yield public fields and properties of an object that are numbers, texts, or lists of them."""
    members = getattr(type(value), "__dict__", {})
    fields = getattr(value, "_fields", None) or vars(value)
    names = [*fields, *(name for name, one in members.items() if isinstance(one, property))]
    for name in names:
        attribute = getattr(value, name)
        if not name.startswith("_") and _is_plain(attribute):
            yield name, attribute


def _is_plain(value: Any) -> bool:
    if isinstance(value, (list, tuple)):
        return len(value) <= 16 and all(map(_is_plain, value))
    return isinstance(value, (Real, str, SimpleNamespace))


def find_figure(study: TableStudy) -> Path | None:
    """Return the shipped figure if it belongs to the present program, else None."""
    results = read_results(study.folder())
    return study.shipped_figure() if results and results["made_by"] == fingerprint_study(study.folder()) else None


def find_changes(study: TableStudy, *, wandering: bool = True) -> list[str]:
    """Return the differences of computed from shipped numbers of a study, one sentence each.

    Searches of wandering parts depend on the machine. Only claims of these parts are compared, with a loose tolerance,
    and only if `wandering` is true.
    """
    shipped = study.load_shipped_answer()
    if shipped is None:
        return [f"It has no `{RESULTS}`."]
    if study.lacks_compiler():
        return []
    shipped_numbers = _list_numbers([*shipped.claims, *shipped.reports])
    changes: list[str] = []
    for part in study.table["parts"]:
        wanders = part in study.table.get("wanders", ())
        if wanders and not wandering:
            continue
        answer = study.settle_part(part)
        share = LOOSE if wanders else CLOSE
        for id, new in _list_numbers([*answer.claims, *(() if wanders else answer.reports)]).items():
            old = shipped_numbers.get(id, new)
            if abs(new - old) > max(share * abs(old), FAINT):
                changes.append(f"`{id}` was shipped as {old:.6g} and is {new:.6g}.")
    return changes


def _list_numbers(rows: list[Claim | StudyReport]) -> dict[str, float]:
    """Return computed numbers and results of misprinted equations by name."""
    computed = {one.id: one.computed for one in rows}
    printed = {f"{one.id}, as printed": one.as_printed for one in rows if isinstance(one, Claim)}
    return {id: number for id, number in {**computed, **printed}.items() if number is not None}


def main(arguments: list[str]) -> None:
    """Write results and figures of studies of this package; with `--figures` only the figures."""
    for name in (one for one in arguments if one != "--figures"):
        study = load_study(name)
        if isinstance(study, TableStudy):
            study.full = True
            if "--figures" not in arguments:
                sys.stdout.write(f"{write_results(study, study.folder())}\n")
            study.figure(study.folder() / FIGURE)
            sys.stdout.write(f"{study.folder() / FIGURE}\n")


if __name__ == "__main__":
    os.environ["MARTENSITE_QUICK_C"] = "off"
    main(sys.argv[1:])
