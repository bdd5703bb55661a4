"""Files of a sweep."""

from __future__ import annotations

import csv
import math
import zipfile
from pathlib import Path

from martensite.app.messages import JsonTable, Request, require_entry
from martensite.app.sweeping.sweep_folder import SweepFolder
from martensite.app.uploads import UploadFolder
from martensite.app.worker import Desk
from martensite.base.errors import InputError, suggest_name
from martensite.base.files import replace_file
from martensite.base.status import Status
from martensite.design.sweep.reading import read_sweep
from martensite.design.sweep.table import NOT_MADE

FORMULA = ("=", "+", "-", "@", "\t", "\r")
"""What a text begins with that a spreadsheet would compute."""


def export_sweep(request: Request, desk: Desk) -> JsonTable:
    """Make a file of a sweep, to be taken away.

    {"key": …, "kind": "csv" or "zarr"} -> {"file": key of the file, "name": …, "bytes": …}
    """
    store = SweepFolder(desk.folder).path(require_entry(request, "key", str))
    kind = require_entry(request, "kind", str)
    if kind not in KINDS:
        raise InputError(f"There is no export `{kind}`. {suggest_name(kind, KINDS)}")
    ending, write = KINDS[kind]
    key, path = UploadFolder(desk.folder).place(f"{store.stem}{ending}")
    write(store, path)
    return {"file": key, "name": path.name, "bytes": path.stat().st_size}


def write_csv(store: Path, path: Path) -> None:
    """One row per run that is made, numbers in SI, units in the heads; failed ones are empty."""
    table = read_sweep(store)
    columns = {**table.varied, **table.measures}
    with replace_file(path) as part, part.open("w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file)
        heads = [f"{name} [{one.unit}]" for name, one in columns.items()]
        writer.writerow(["run", "status", *map(escape_formula, heads)])
        values = [one.values.tolist() for one in columns.values()]
        for row, status in enumerate(table.status.tolist()):
            if status != NOT_MADE:
                word = Status(status).name.lower()
                writer.writerow([row, word, *(_write_number(column[row]) for column in values)])


def _write_number(value: float) -> str:
    return "" if math.isnan(value) else repr(value)


def escape_formula(text: str) -> str:
    """A text that no spreadsheet takes for a formula."""
    return f"'{text}" if text.startswith(FORMULA) else text


def write_zip(store: Path, path: Path) -> None:
    """The store as it is, in a folder; its chunks are compressed already."""
    with replace_file(path) as part, zipfile.ZipFile(part, "w", zipfile.ZIP_STORED) as made:
        for one in sorted(store.rglob("*")):
            if one.is_file():
                made.write(one, f"{store.name}/{one.relative_to(store).as_posix()}")


KINDS = {"csv": (".csv", write_csv), "zarr": (".zarr.zip", write_zip)}
