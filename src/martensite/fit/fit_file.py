"""Fit files: TOML documents with the records, parameters and settings of a fit.

    scenario = "isobaric.toml"
    free = ["A_s", "A_f=60..120 degC", "C_A=5..12 MPa/K"]
    each = ["offset.strain"]          # separate for every record
    hold_out = "auto"                 # none, names of records, or "25 %"
    noise = { strain = "0.02 %" }
    set = { "element.diameter" = "0.381 mm" }

    [[record]]
    file = "log_100MPa.csv"           # relative to the fit file, or data:…
    set = { "mechanism.mass" = "1162.57 g" }

Further keys of the file are title, column, step, method, loss, starts and seed. Further keys of a record are name,
scenario, interval, weight and hold_out; `as`, the columns, such as `{ "2" = "stress[MPa]" }`; and `group`, such as
`{ specimen = "A" }`. Module `free_parameters` describes the separate parameters of groups.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any, cast

from martensite.base import units
from martensite.base.errors import DataError, ParameterError, UnitError
from martensite.base.files import read_text_file, toml_document
from martensite.fit.fit_task import FitSearch, FitTask
from martensite.fit.logs import AUTO, Log
from martensite.logs.reader import PREFIX
from martensite.scenario.build import as_table, refuse_unknown

KEYS = (
    "title",
    "scenario",
    "free",
    "each",
    "hold_out",
    "column",
    "noise",
    "step",
    "set",
    "method",
    "loss",
    "starts",
    "seed",
    "record",
)
RECORD = ("file", "name", "scenario", "as", "interval", "set", "weight", "hold_out", "group")


def is_fit_file(path: str | Path) -> bool:
    """Return whether a path has the form of a fit file, and not of a log."""
    return Path(path).suffix.lower() == ".toml" and not str(path).startswith(PREFIX)


def read_fit_file(path: str | Path) -> FitTask:
    """Return the task of a fit file.

    Raises:
        InputError: the file is missing or malformed, a key is unknown, or a value has no unit.
    """
    path = Path(path)
    where, text = f"Fit file `{path.name}`", read_text_file(path, "fit")
    document = toml_document(text, f"`{path}`")
    refuse_unknown(document, KEYS, where)
    for name in ("free", "record"):
        if not document.get(name):
            raise DataError(f"{where} needs `{name}`; none given.")
    records = document["record"]
    if not isinstance(records, list):
        raise DataError(f"{where}: write a separate section `[[record]]` for each record.")
    return FitTask(
        logs=tuple(_read_log(document, one, path) for one in cast("list[Any]", records)),
        free=_read_texts(document, "free", where),
        each=_read_texts(document, "each", where),
        hold_out=_read_hold_out(document.get("hold_out", AUTO)),
        columns=_read_texts(document, "column", where) or None,
        noise=as_table(document.get("noise", {}), "noise"),
        step=_read_seconds(document, "step", where),
        search=_read_search(document, where),
    )


def _read_log(document: Mapping[str, Any], entry: Any, path: Path) -> Log:
    table, where = as_table(entry, "record"), f"[[record]] of `{path.name}`"
    refuse_unknown(table, RECORD, where)
    file, scenario = (_read_text(table, "file", where), table.get("scenario", document.get("scenario")))
    if not isinstance(scenario, str):
        raise DataError(f"Fit file `{path.name}` needs `scenario`, the file of one; none given.")
    weight = table.get("weight", 1.0)
    if isinstance(weight, bool) or not isinstance(weight, (int, float)) or not weight > 0.0:
        raise ParameterError(f"{where}: `weight` must be a number above 0, but is {weight!r}.")
    return Log(
        source=file if file.startswith(PREFIX) else path.parent / file,
        scenario=path.parent / scenario,
        interval=_read_seconds(table, "interval", where),
        settings={**_read_settings(document, where), **_read_settings(table, where)},
        weight=float(weight),
        is_held_out=_read_flag(table, "hold_out", where),
        name=str(table.get("name", "")),
        new_headings={key: str(value) for key, value in as_table(table.get("as", {}), "as").items()},
        groups={key: str(value) for key, value in as_table(table.get("group", {}), "group").items()},
    )


def _read_search(document: Mapping[str, Any], where: str) -> FitSearch:
    usual = FitSearch()
    for name in ("starts", "seed"):
        if not isinstance(document.get(name, 0), int):
            raise ParameterError(f"{where}: `{name}` must be a whole number.")
    return FitSearch(
        str(document.get("method", usual.method)),
        str(document.get("loss", usual.loss)),
        int(document.get("starts", usual.starts)),
        int(document.get("seed", usual.seed)),
    )


def _read_hold_out(given: Any) -> str | list[str]:
    return [str(name) for name in cast("list[Any]", given)] if isinstance(given, list) else str(given)


def _read_settings(table: Mapping[str, Any], where: str) -> dict[str, Any]:
    given = table.get("set", {})
    if not isinstance(given, dict):
        raise ParameterError(
            f'{where}: `set` must be a table such as {{ "mechanism.mass" = "400 g" }}, but is {given!r}.'
        )
    return _flatten_table(cast("dict[str, Any]", given))


def _flatten_table(table: Mapping[str, Any], above: str = "") -> dict[str, Any]:
    """Return the values by dotted path, for quoted paths and for tables."""
    flat_table: dict[str, Any] = {}
    for key, value in table.items():
        path = f"{above}{key}"
        if isinstance(value, dict) and "kind" not in value:
            flat_table |= _flatten_table(cast("dict[str, Any]", value), f"{path}.")
        else:
            flat_table[path] = value
    return flat_table


def _read_flag(table: Mapping[str, Any], name: str, where: str) -> bool:
    given = table.get(name, False)
    if not isinstance(given, bool):
        raise ParameterError(f"{where}: `{name}` must be true or false, but is {given!r}.")
    return given


def _read_text(table: Mapping[str, Any], name: str, where: str) -> str:
    if not isinstance(table.get(name), str):
        raise DataError(f"{where} needs `{name}`, a text.")
    return str(table[name])


def _read_texts(table: Mapping[str, Any], name: str, where: str) -> list[str]:
    given = table.get(name, [])
    items = cast("list[Any]", given if isinstance(given, list) else [given])
    wrong = next((item for item in items if not isinstance(item, str)), None)
    if wrong is not None:
        raise ParameterError(f"{where}: `{name}` must hold texts, but holds {wrong!r}.")
    return [str(item) for item in items]


def _read_seconds(table: Mapping[str, Any], name: str, where: str) -> float | None:
    if name not in table:
        return None
    given = table[name]
    if not isinstance(given, str):
        raise UnitError(f"{where}: `{name}` must be text with a unit, such as `1 s`, but is {given!r}.")
    try:
        return units.parse_quantity(given, "s")
    except UnitError as error:
        raise UnitError(f"{where}: `{name}`: {error}") from None
