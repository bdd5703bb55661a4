"""Tables of the sections of a bench: one or several, flat or nested, and their kinds."""

from __future__ import annotations

from collections.abc import Iterator
from copy import deepcopy
from typing import Any, cast

from martensite.base.errors import ParameterError, suggest_name
from martensite.base.parameters import Parametrised
from martensite.base.registry import Registry
from martensite.scenario.assemble import section_of
from martensite.scenario.build import Table, as_table, choose_class
from martensite.scenario.components import list_nested

PAIRS = {
    "sensor": "sensors",
    "observer": "observers",
    "controller": "controllers",
    "reference": "references",
}
"""Section of a single one -> section of several."""
BENCH, SUPERVISOR, FAULTS, RUN = "bench", "supervisor", "faults", "run"
SECTIONS = (*PAIRS, *PAIRS.values(), SUPERVISOR, FAULTS, BENCH)
PERIOD, NAME, MODEL, REFERENCE = "period", "name", "model", "reference"
Row = tuple[str, dict[str, Any], str]
"""Name, table and path of a component."""


def list_rows(document: Table, one: str) -> Iterator[Row]:
    """Every component of a kind; the name of a single one is ''."""
    if one in document:
        yield "", section_of(document, one), one
    yield from list_named(document, PAIRS[one])


def list_named(document: Table, several: str) -> Iterator[Row]:
    """Every component of a section of several."""
    for name, table in section_of(document, several, {}).items():
        yield name, as_table(table, f"{several}.{name}"), f"{several}.{name}"


def kind_of(registry: Registry[Any], table: Table, path: str) -> type[Parametrised]:
    """The class of a table.

    Raises:
        InputError: it names no kind, or none that there is.
    """
    if "kind" not in table:
        raise ParameterError(f"[{path}] needs `kind`. {suggest_name('', registry.names())}")
    return choose_class(registry, table, path)


def add_period(cls: type[Parametrised], table: Table, period: float) -> Table:
    """A table with the period, for a controller that must know it."""
    return {**table, PERIOD: f"{period!r} s"} if PERIOD in cls.declarations else table


def gather_numbers(cls: type[Parametrised], table: Table) -> tuple[dict[str, Any], dict[str, str]]:
    """A table with numbers of its components in tables of their own, and what was moved.

    A component whose class is known, such as the `law` of a PID controller, may have its numbers
    beside those of the whole where only one of them has the name.
    """
    owners: dict[str, list[str]] = {}
    for name, inner in list_nested(cls):
        owners.setdefault(name, []).append(inner)
    found, moved = deepcopy(dict(table)), dict[str, str]()
    for name in [n for n in table if n not in cls.declarations and len(owners.get(n, ())) == 1]:
        (inner,) = owners[name]
        below = found
        for part in inner.split(".")[:-1]:
            below = below.setdefault(part, {})
        if name in below:
            raise ParameterError(f"`{name}` and `{inner}` are the same; leave one out.")
        below[name] = found.pop(name)
        moved[inner] = name
    return found, moved


def flatten_table(table: Any, prefix: str) -> Iterator[tuple[str, Any]]:
    """Dotted paths and values of a table of tables."""
    if not isinstance(table, dict):
        raise ParameterError(
            f"A model is a table of what is different, such as "
            f'`{{ "element.diameter" = "0.37 mm" }}`, but is {table!r}.'
        )
    for key, value in cast("dict[str, Any]", table).items():
        path = f"{prefix}{key}"
        if isinstance(value, dict):
            yield from flatten_table(value, f"{path}.")
        else:
            yield path, value


def list_texts(given: Any) -> list[str]:
    """A text, or texts, as a list."""
    if isinstance(given, str):
        return [given]
    return [str(one) for one in cast("list[Any]", given)] if isinstance(given, list) else []


def check_name(name: str, path: str) -> None:
    """Raise `ParameterError` for a name that no column can carry."""
    if not name.isidentifier():
        raise ParameterError(
            f"[{path}] A name consists of letters, digits and underscores, but is `{name}`."
        )
