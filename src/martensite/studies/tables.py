"""Studies as tables: printed numbers and claims, in two TOML files.

`printed.toml` holds numbers by their place in the source,

    source = "key of the bibliography"
    ["Table 3"]
    stiffness = { value = 541.0, unit = "N/m" }

and tables of rows with named columns. Numbers under a place that begins with `not printed` were read off or chosen for
this project; no claim can have them as published. For `claims.toml` see `martensite.studies.claim_tables`, for
`results.json` `martensite.studies.shipped_numbers`.
"""

from __future__ import annotations

import json
import sys
import tomllib
from collections.abc import Callable, Mapping
from functools import cache
from importlib import import_module
from pathlib import Path
from types import ModuleType, SimpleNamespace
from typing import Any, ClassVar

from martensite.base.errors import DataError, suggest_name
from martensite.studies.base import AbstractStudy, Answer, Claim
from martensite.studies.claim_tables import check_keys, read_claims, settle_part, write_digest

FOLDER = Path(__file__).parent
ENTRY, TABLE = ("value", "unit", "what"), ("columns", "units", "rows")
"""Keys of a printed number, and of a printed table."""
RESULTS, FIGURE = "results.json", "figure.svg"
"""Shipped computed numbers, and their figure."""
OWN = "not printed"
"""Beginning of a place outside the source."""


class Printed(SimpleNamespace):
    """Numbers that a source prints, by name; read-only."""

    def __setattr__(self, name: str, value: Any) -> None:
        raise AttributeError(f"Printed numbers cannot be set; use `with_numbers({name}=…)`.")

    def __hash__(self) -> int:
        return hash(tuple(vars(self).items()))

    def with_numbers(self, **numbers: Any) -> Printed:
        """Return the printed numbers with replacements."""
        for name in numbers:
            if name not in vars(self):
                raise DataError(f"No printed number `{name}`. {suggest_name(name, vars(self))}")
        return Printed(**vars(self) | numbers)


class PrintedRows(tuple[Printed, ...]):
    """Rows of a printed table."""

    def column(self, name: str) -> tuple[Any, ...]:
        """Return a column by name."""
        return tuple(getattr(row, name) for row in self)


class TableStudy(AbstractStudy):
    """A study with tables in the folder of its class.

    The function `compute_wire(printed)` of the module `wire_numbers` computes a part `wire`; `draw_figure(printed)` of
    the module `figure` draws the figure.
    """

    table: ClassVar[Mapping[str, Any]] = {}
    """`claims.toml`."""

    def __init_subclass__(cls) -> None:
        """Read and check the tables."""
        super().__init_subclass__()
        if not hasattr(sys.modules.get(cls.__module__), "__file__"):
            return  # typed into a console: tables of its base class
        cls.table = table = read_claims(cls.folder() / "claims.toml")
        cls.title, cls.guide, cls.caption = table["title"], table["guide"], table["caption"]
        cls.cites, cls.data, cls.order = tuple(table["cites"]), tuple(table.get("data", ())), table["order"]
        cls.scenario_files = tuple(table.get("scenarios", cls.scenario_files))

    def __init__(self, printed: Printed | None = None, *, full: bool = False) -> None:
        """Use the printed numbers, or replacements; `full` computes slow parts."""
        self.full = full
        self.printed = printed or read_printed(self.folder() / "printed.toml")
        self._numbers: dict[str, Mapping[str, Any]] = {}

    @classmethod
    def folder(cls) -> Path:
        """Return the folder of the tables."""
        return Path(str(sys.modules[cls.__module__].__file__)).parent

    def compute_part(self, key: str) -> Mapping[str, Any]:
        """Return the numbers of a part, computed now."""
        return getattr(self._import_module(f"{key}_numbers"), f"compute_{key}")(self.printed)

    def part_numbers(self, key: str) -> Mapping[str, Any]:
        """Return the numbers of a part, computed once."""
        if key not in self._numbers:
            self._numbers[key] = self.compute_part(key)
        return self._numbers[key]

    def parts(self) -> dict[str, Callable[[], Answer]]:
        """Return the functions that compute claims and reports, by part."""
        if self.lacks_compiler():
            return {"a C compiler": lambda: Answer([self._without_compiler()])}
        named: dict[str, str] = self.table["parts"]
        return {words: lambda key=key: self.settle_part(key) for key, words in named.items()}

    def settle_part(self, key: str) -> Answer:
        """Return claims and reports of one part, computed now."""
        return settle_part(self.table, key, self.part_numbers(key), self.printed)

    def digest(self) -> Mapping[str, str]:
        """Return the summary of the study."""
        if self.lacks_compiler():
            return {}
        return self._write_digest({key: self.part_numbers(key) for key in self.table["parts"]})

    def load_shipped_answer(self) -> Answer | None:
        """Return digest, claims and reports from the shipped numbers."""
        results = read_results(self.folder())
        if results is None:
            return None
        numbers = {key: {**part, "shipped": True} for key, part in results["numbers"].items()}
        answers = [settle_part(self.table, key, numbers[key], self.printed) for key in self.table["parts"]]
        made_by = f"martensite {results['version']} ({results['made_by']})"
        return Answer.join(answers, self._write_digest(numbers), made_by)

    def shipped_figure(self) -> Path | None:
        """Return the path of the shipped figure, or None."""
        path = self.folder() / FIGURE
        return path if path.is_file() else None

    def figure(self, path: Path) -> None:
        """Write the figure (png, svg or pdf)."""
        from martensite.show.figures.style import write_figure

        write_figure(self._import_module("figure").draw_figure(self.printed), Path(path))

    def _write_digest(self, numbers: Mapping[str, Mapping[str, Any]]) -> dict[str, str]:
        together = {name: value for part in numbers.values() for name, value in part.items()}
        answers = [settle_part(self.table, key, part, self.printed) for key, part in numbers.items()]
        return write_digest(self.table, together, self.printed, answers)

    def lacks_compiler(self) -> bool:
        """Return whether a required C compiler is missing."""
        if "compiler" not in self.table:
            return False
        from martensite.kernels.compiler import find_compiler

        return find_compiler() is None

    def _without_compiler(self) -> Claim:
        """Return the claim that replaces all others without a C compiler."""
        place, why = (self.table["compiler"][key] for key in ("place", "why"))
        words = "compiler", "all of this study", f"{self.printed.source}, {place}"
        return Claim(*words, None, None, "1", None, "not comparable", why, differs="this machine has no C compiler")

    def _import_module(self, name: str) -> ModuleType:
        return import_module(f"{sys.modules[type(self).__module__].__package__}.{name}")


def printed_numbers(study: str) -> Printed:
    """Return the printed numbers of a study of this package, by its folder."""
    return read_printed(FOLDER / study / "printed.toml")


@cache
def read_printed(path: Path) -> Printed:
    """Return the printed numbers of a file."""
    table = tomllib.loads(path.read_text("utf-8"))
    numbers: dict[str, Any] = {"source": table.pop("source"), "unprinted": ()}
    for place, entries in table.items():
        if not isinstance(entries, dict):
            raise DataError(f"Number `{place}` of {path} needs a place in the source.")
        for name, entry in entries.items():
            if name in numbers:
                raise DataError(f"Number `{name}` of {path} must have one place, but has two.")
            numbers[name] = _read_entry(name, entry, path)
            if place.startswith(OWN):
                numbers["unprinted"] += (name,)
    return Printed(**numbers)


def _read_entry(name: str, entry: Mapping[str, Any], path: Path) -> Any:
    """Return a number, a tuple of numbers, or a tuple of rows."""
    if "rows" in entry:
        check_keys(entry, TABLE, TABLE, f"Table `{name}` of {path}")
        columns = entry["columns"]
        return PrintedRows(Printed(**dict(zip(columns, row, strict=True))) for row in entry["rows"])
    check_keys(entry, ENTRY, ("value", "unit"), f"Number `{name}` of {path}")
    return tuple(entry["value"]) if isinstance(entry["value"], list) else entry["value"]


def read_results(folder: Path) -> dict[str, Any] | None:
    """Return shipped version, fingerprint and numbers, or None."""
    path = folder / RESULTS
    if not path.is_file():
        return None
    results = json.loads(path.read_text("utf-8"))
    results["numbers"] = {part: _restore_part(numbers) for part, numbers in results["numbers"].items()}
    return results


def _restore_part(numbers: Mapping[str, Any]) -> dict[str, Any]:
    return {name: _restore(value) for name, value in numbers.items()}


def _restore(value: Any) -> Any:
    """Return objects with attributes, and rows with names."""
    match value:
        case dict():
            return SimpleNamespace(**_restore_part(value))
        case [dict(), *_]:
            return [_restore_part(row) for row in value]
        case _:
            return value
