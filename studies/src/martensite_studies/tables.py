"""Studies as tables: what a source prints and what is claimed of it, in two TOML files.

`printed.toml` holds numbers by the place where the source prints them,

    source = "key of the bibliography"
    ["Table 3"]
    stiffness = { value = 541.0, unit = "N/m" }

and tables of rows with named columns. `claims.toml` holds title, guide and, part by part, tables of
claims. Keys of a table hold for all its rows; `-` in a row leaves a column out.

    [[beam]]
    place = "Table 5"
    unit = "N/m"
    columns = ["id", "what", "published", "tolerance", "tolerance_reason", "why"]
    rows = [
      ["stiffness", "stiffness of the beam", "computed_stiffness", 0.1, "last digit", "3 E I/l³"],
    ]

key                 meaning
id, what, why       name of the claim, its statement, what its verdict rests on
place, source       where the source makes it; the source, if it is not that of the printed numbers
published           a printed number by its name, or the number itself
computed            a computed number by its name, such as `a.rms`; the id if left out
scale, unit         factor on both numbers, and the unit that they then have
tolerance           largest difference that counts as agreement: a number or the name of one
tolerance_reason    why so large
kind                `calibrated` for a number that was made to meet the published one, `open` where
                    none can be computed
each                a list of computed rows, for each of which there are the claims of the table;
                    their columns come before all other names
needs               files of measured data without which there is no number, by their name in
                    `files`; `absent` says why

A claim with a tolerance is checked, one that is neither checked nor calibrated is reported. Words
in braces in `id`, `what`, `unit` and `why` are replaced by numbers, in the manner of `str.format`.
"""

from __future__ import annotations

import sys
import tomllib
from collections.abc import Callable, Iterator, Mapping
from functools import cache, reduce
from importlib import import_module
from pathlib import Path
from types import ModuleType, SimpleNamespace
from typing import Any, ClassVar

from martensite.base.errors import DataError, suggest_name
from martensite.kernels.compiler import find_compiler
from martensite.studies.base import AbstractStudy, Claim

FOLDER = Path(__file__).parent
HEADER = (
    *("title", "cites", "guide", "caption", "scenarios", "parts"),
    *("data", "absent", "files", "texts", "compiler"),
)
"""Keys of `claims.toml` beside the parts."""
NEEDED = ("id", "what", "place", "unit", "why")
KEYS = (
    *NEEDED,
    *("published", "computed", "scale", "tolerance", "tolerance_reason", "kind"),
    *("source", "each", "needs"),
)
ENTRY, TABLE = ("value", "unit", "what"), ("columns", "units", "rows")
"""Keys of a printed number, and of a printed table."""
OMITTED = "-"


class Printed(SimpleNamespace):
    """Numbers that a source prints, by their names; they are read, not written."""

    def __setattr__(self, name: str, value: Any) -> None:
        raise AttributeError(f"Printed numbers cannot be set; use `with_numbers({name}=…)`.")

    def __hash__(self) -> int:
        return hash(tuple(vars(self).items()))

    def with_numbers(self, **numbers: Any) -> Printed:
        """The same with some numbers in the place of those printed.

        Raises:
            DataError: there is no number of that name.
        """
        for name in numbers:
            if name not in vars(self):
                raise DataError(f"No printed number `{name}`. {suggest_name(name, vars(self))}")
        return Printed(**vars(self) | numbers)


class PrintedRows(tuple[Printed, ...]):
    """Rows of a printed table."""

    def column(self, name: str) -> tuple[Any, ...]:
        """A column by its name."""
        return tuple(getattr(row, name) for row in self)


class TableStudy(AbstractStudy):
    """A study with tables beside it, in the folder of its class.

    The numbers of a part `wire` are computed by `compute_wire(printed)` of the module
    `wire_numbers`, and the figure is drawn by `draw_figure(printed)` of the module `figure`.
    """

    table: ClassVar[Mapping[str, Any]] = {}
    """`claims.toml`."""

    def __init_subclass__(cls) -> None:
        """Read the tables, and check them."""
        super().__init_subclass__()
        if not hasattr(sys.modules.get(cls.__module__), "__file__"):
            return  # typed into a console: the tables are those of its base
        cls.table = table = read_claims(cls._folder() / "claims.toml")
        cls.title, cls.guide, cls.caption = table["title"], table["guide"], table["caption"]
        cls.cites, cls.data = tuple(table["cites"]), tuple(table.get("data", ()))
        cls.scenario_files = tuple(table.get("scenarios", cls.scenario_files))

    def __init__(self, printed: Printed | None = None, *, full: bool = False) -> None:
        """Take the numbers as printed, or others in their place.

        With `full` a study that leaves out what takes long does not.
        """
        self.full = full
        self.printed = printed or read_printed(self._folder() / "printed.toml")

    def compute_part(self, key: str) -> Mapping[str, Any]:
        """The numbers of a part, computed now."""
        return getattr(self._import_module(f"{key}_numbers"), f"compute_{key}")(self.printed)

    def parts(self) -> dict[str, Callable[[], list[Claim]]]:
        """Every claim with its verdict, part by part."""
        if "compiler" in self.table and find_compiler() is None:
            return {"a C compiler": lambda: [self._without_compiler()]}
        named: dict[str, str] = self.table["parts"]
        return {words: lambda key=key: self.part_claims(key) for key, words in named.items()}

    def part_claims(self, key: str) -> list[Claim]:
        """The claims of one part, computed now."""
        return list(settle_claims(self.table, key, self.compute_part(key), self.printed))

    def figure(self, path: Path) -> None:
        """Write the figure that a reader of the source recognises (png, svg or pdf)."""
        from martensite.show.figures.style import write_figure

        write_figure(self._import_module("figure").draw_figure(self.printed), Path(path))

    def _without_compiler(self) -> Claim:
        """What takes the place of all claims where they cannot be computed."""
        place, why = (self.table["compiler"][key] for key in ("place", "why"))
        source = f"{self.printed.source}, {place}"
        words = "compiler", "all of this study", source
        return Claim(*words, None, None, "1", None, "not checkable", why)

    @classmethod
    def _folder(cls) -> Path:
        return Path(str(sys.modules[cls.__module__].__file__)).parent

    def _import_module(self, name: str) -> ModuleType:
        """A module beside that of the class."""
        return import_module(f"{sys.modules[type(self).__module__].__package__}.{name}")


# ---------------------------------------------------------------- printed numbers


def printed_numbers(study: str) -> Printed:
    """The numbers that the source of a study of this package prints, by the folder of the study."""
    return read_printed(FOLDER / study / "printed.toml")


@cache
def read_printed(path: Path) -> Printed:
    """A file of printed numbers.

    Raises:
        DataError: a number stands at no place, or its keys are not those of one.
    """
    table = tomllib.loads(path.read_text("utf-8"))
    numbers: dict[str, Any] = {"source": table.pop("source")}
    for place, entries in table.items():
        if not isinstance(entries, dict):
            raise DataError(f"Number `{place}` of {path} must stand under a place in the source.")
        for name, entry in entries.items():
            if name in numbers:
                raise DataError(f"Number `{name}` of {path} must have one place, but has two.")
            numbers[name] = _read_entry(name, entry, path)
    return Printed(**numbers)


def _read_entry(name: str, entry: Mapping[str, Any], path: Path) -> Any:
    """A number, a tuple of numbers, or a tuple of rows."""
    if "rows" in entry:
        _check_keys(entry, TABLE, TABLE, f"Table `{name}` of {path}")
        columns = entry["columns"]
        return PrintedRows(Printed(**dict(zip(columns, row, strict=True))) for row in entry["rows"])
    _check_keys(entry, ENTRY, ("value", "unit"), f"Number `{name}` of {path}")
    return tuple(entry["value"]) if isinstance(entry["value"], list) else entry["value"]


# ---------------------------------------------------------------- claims


def read_claims(path: Path) -> dict[str, Any]:
    """A file of claims, checked.

    Raises:
        DataError: a key is unknown, missing or taken, or a tolerance has no reason.
    """
    table = tomllib.loads(path.read_text("utf-8"))
    parts = table.get("parts", {})
    _check_keys(table, (*HEADER, *parts), ("title", "cites", "guide", "caption", *parts), str(path))
    for part in parts:
        if part in HEADER:
            raise DataError(f"A part of {path} must not be called `{part}`: the word is taken.")
        table[part] = [list(_expand_block(block)) for block in table[part]]
        for claim in (claim for block in table[part] for claim in block):
            _check_claim(claim, f"Claim `{claim.get('id', '')}` of {path}")
    return table


def _expand_block(block: Mapping[str, Any]) -> Iterator[dict[str, Any]]:
    """The claims of a table: keys for all, and those of each row."""
    shared = {key: value for key, value in block.items() if key not in ("columns", "rows")}
    columns = block.get("columns", ())
    for row in block.get("rows", ((),)):
        cells = zip(columns, row, strict=True)
        yield shared | {key: value for key, value in cells if value != OMITTED}


def _check_claim(claim: Mapping[str, Any], where: str) -> None:
    _check_keys(claim, KEYS, NEEDED, where)
    if ("tolerance" in claim) != ("tolerance_reason" in claim):
        raise DataError(f"{where} must have a tolerance and the reason for it, or neither.")
    if "tolerance" in claim and "published" not in claim:
        raise DataError(f"{where} has a tolerance and must have a published number.")


def _check_keys(table: Mapping[str, Any], known: tuple[str, ...], needed: tuple[str, ...], where: str) -> None:
    for key in table:
        if key not in known:
            raise DataError(f"{where} has no key `{key}`. {suggest_name(key, known)}")
    for key in needed:
        if key not in table:
            raise DataError(f"{where} must have `{key}`.")


def settle_claims(table: Mapping[str, Any], part: str, numbers: Mapping[str, Any], printed: Printed) -> Iterator[Claim]:
    """The claims of a part, with computed numbers and verdicts.

    Args:
        table: what `read_claims` gave.
        part: key of the part.
        numbers: computed numbers by their names; lists of rows for claims with `each`.
        printed: the printed numbers.
    """
    from martensite.scenario.datasets import is_here

    texts = table.get("texts", {})
    for block in table[part]:
        for row in numbers[block[0]["each"]] if "each" in block[0] else ({},):
            names = {**vars(printed), **numbers, **row}
            for claim in block:
                files = table["files"][claim["needs"]] if "needs" in claim else ()
                absent = "" if all(map(is_here, files)) else table["absent"]
                yield _settle_claim(claim, names, printed, texts, absent)


def _settle_claim(
    claim: Mapping[str, Any], names: Mapping[str, Any], printed: Printed, texts: Mapping[str, str], absent: str
) -> Claim:
    """A claim with its number and its verdict; without them for the reason `absent`, if any."""
    words = {**texts, **names}
    id, what, unit, why = (claim[key].format_map(words) for key in ("id", "what", "unit", "why"))
    source = f"{claim.get('source', printed.source)}, {claim['place']}"
    published = _published_number(claim, names, printed, id)
    kind = claim.get("kind", "")
    if absent or kind == "open":
        verdict, why = "not checkable", absent or why
        return Claim(id, what, source, published, None, unit, None, verdict, why)
    computed = find_number(claim.get("computed", id.replace("-", "_")), names, id)
    if "scale" in claim:
        computed = claim["scale"] * computed
    if published is not None and "tolerance" in claim:
        tolerance = find_number(claim["tolerance"], names, id)
        return Claim.checked(id, what, source, published, computed, unit, tolerance, why)
    if kind == "calibrated":
        return Claim.calibrated(id, what, source, published, computed, unit, why)
    return Claim.reported(id, what, source, computed, unit, why)


def _published_number(claim: Mapping[str, Any], names: Mapping[str, Any], printed: Printed, id: str) -> Any:
    """The published number; a printed one comes before a computed one of the same name."""
    if "published" not in claim:
        return None
    own = vars(printed) if "each" not in claim else {}
    return claim.get("scale", 1.0) * find_number(claim["published"], {**names, **own}, id)


def find_number(name: str | float, known: Mapping[str, Any], claim: str) -> Any:
    """A number by its dotted name, such as `a.rms`; a number stands for itself.

    Raises:
        DataError: there is none of that name.
    """
    if not isinstance(name, str):
        return name
    if name in known:
        return known[name]
    first, *rest = name.split(".")
    if first not in known:
        raise DataError(f"Claim `{claim}` names no number: `{name}`. {suggest_name(first, known)}")
    return reduce(getattr, rest, known[first])
