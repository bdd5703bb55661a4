"""Reader of measured files, for all commands, fits, boards and the web page.

`read_log` reads a file exactly if its headings are complete (`logs.exact_tables`), and otherwise finds meanings and
units (`logs.lab_files`). `read_table` is the strict form without guesses.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from martensite.base.errors import DataError, InputError, ParameterError, suggest_name
from martensite.base.files import tell_once
from martensite.logs.binary_files import BINARY, head_column
from martensite.logs.container_files import KINDS, find_ending, list_sheets, read_container
from martensite.logs.exact_rows import SIGNS
from martensite.logs.exact_tables import (
    InexactError,
    build_exact,
    is_all_known,
    read_exact_headings,
    read_exact_text,
    refuse_mistaken,
)
from martensite.logs.lab_files import LabFile, read_lab_file, split_side_by_side
from martensite.logs.layout import CANONICAL, IGNORED, FileColumn, Layout, name_column
from martensite.logs.raw_table import RawColumn, RawTable, WrongCell
from martensite.signals.records import Record, not_finite

PREFIX = "data:"


def parse_new_headings(texts: Iterable[str]) -> dict[str, str]:
    """Return column -> meaning from texts such as `2=stress[MPa]`.

    Raises:
        InputError: a text names no column.
    """
    parts = [text.rpartition("=") for text in texts]
    wrong = next((text for key, equals, text in parts if not (key.strip() and equals and text.strip())), None)
    if wrong is not None:
        raise InputError(f"`{wrong}` does not say which column it is; write for example `--as 2=stress[MPa]`.")
    return {key.strip(): text.strip() for key, _, text in parts}


def is_published(source: object) -> bool:
    """Return whether a source is a file of a published data set, `data:SET/FILE`."""
    return str(source).startswith(PREFIX)


def is_columnar(source: str | Path) -> bool:
    """Return whether a log is an unpublished file of named arrays."""
    return not is_published(source) and Path(source).suffix.lower() in BINARY


def read_log(
    source: str | Path,
    new_headings: Mapping[str, str] | None = None,
    interval: float | None = None,
    *,
    known: bool = False,
) -> LabFile:
    """Return a log of any kind; a fault below complete headings is an error.

    Args:
        source: file, or `data:<data set>/<file>`.
        new_headings: meaning of columns, by heading or number, as for `read_lab_file`.
        interval: time between rows [s] of a file without times.
        known: find the meaning of complete headings with unknown names, such as `Load [N]`.

    Returns:
        The record in SI, with NaN for missing samples, and the certainty of each column.

    Raises:
        DataError: the log cannot be read, or `new_headings` corrects a published data set.
    """
    if new_headings and is_published(source):
        raise DataError(f"The columns of `{source}` are known; `--as` has no effect on it.")
    file = None if new_headings else _try_exact(source, interval)
    exact = file is not None and file.exact
    if file is not None and exact and (is_published(source) or not known or is_all_known(file.record)):
        return file
    if file is None or exact:
        file = replace(read_lab_file(source, new_headings), has_renamed_columns=exact)
    return file.with_interval(interval) if interval is not None and not file.has_time else file


def read_parts(
    source: str | Path,
    new_headings: Mapping[str, str] | None = None,
    interval: float | None = None,
    *,
    known: bool = False,
) -> list[LabFile]:
    """Return all tables of a file: each sheet, and equal tables side by side; arguments and errors as `read_log`.

    `FILE:LABEL` is the table with this label above its headings.
    """
    whole, label = part_label(source)
    files = [read_log(part, new_headings, interval, known=known) for part in list_sheets(whole)]
    return choose_tables(files, whole, label)


def choose_tables(files: Sequence[LabFile], whole: str | Path, label: str) -> list[LabFile]:
    """Return the tables side by side in the sheets of a file: all, or the table with a label.

    Raises:
        DataError: there is no such label.
    """
    parts = [part for file in files for part in split_side_by_side(file)]
    if not label:
        return parts
    chosen = [part for part in parts if len(parts) > 1 and part.labels == (label,)]
    if not chosen:
        listed = [part.labels[0] for part in parts if part.labels] if len(parts) > 1 else []
        raise DataError(f"`{whole}` has no table `{label}`. {suggest_name(label, listed)}")
    return chosen


def read_one(
    source: str | Path, new_headings: Mapping[str, str] | None = None, interval: float | None = None
) -> LabFile:
    """Return the only table of a file, or the table named after it (`FILE:LABEL`); arguments as `read_log`.

    Raises:
        DataError: the file cannot be read, or it has several labelled tables side by side.
    """
    if part_label(source)[1]:
        return read_parts(source, new_headings, interval)[0]
    file = read_log(source, new_headings, interval)
    parts = split_side_by_side(file) if file.labels else [file]
    if len(parts) > 1:
        labels = [part.labels[0] for part in parts]
        raise DataError(
            f"`{file.path.name}` has {len(parts)} tables side by side, {_list(labels)}: write for example "
            f"`{file.path.name}:{labels[0]}`."
        )
    return file


def part_label(source: str | Path) -> tuple[str | Path, str]:
    """Return a file, and the label of one of its tables; may be empty."""
    whole, colon, label = str(source).rpartition(":")
    if colon and not is_published(source) and find_ending(source) not in KINDS and Path(whole).is_file():
        return whole, label.strip()
    return source, ""


def _try_exact(source: str | Path, interval: float | None) -> LabFile | None:
    """Return a file read exactly, or interpreted if cells need it; None if headings are incomplete."""
    if not (is_published(source) or is_columnar(source) or _is_text(source)):
        return None
    try:
        return read_exact(source, interval=interval, gaps=True)
    except InexactError:
        if Path(source).suffix.lower() == ".nc":
            raise
        return None
    except DataError as error:
        whole = None if is_published(source) or not _is_text(source) else _read_whole(source)
        if whole is None:
            raise _advise(error, source) from None
        return whole


def _read_whole(source: str | Path) -> LabFile | None:
    """Return an interpreted file without loss of any cell; else None."""
    try:
        file = read_lab_file(source)
    except DataError:
        return None
    whole = all(not_finite(column) is None for column in file.record.columns.values())
    lost = file.dropped or file.record.dropped or not whole
    return None if lost else file


def read_log_table(
    source: str | Path, interval: float | None = None, new_headings: Mapping[str, str] | None = None
) -> Record:
    """Return the record of `read_one`; guesses and omissions are printed once on standard error.

    Raises:
        DataError: the log cannot be read.
    """
    return tell_guesses(read_one(source, new_headings, interval)).record


def read_complete(source: str | Path, interval: float | None = None) -> Record:
    """Return the record of `read_log_table` without missing samples.

    Raises:
        DataError: the log cannot be read, or a sample is missing.
    """
    record = read_log_table(source, interval)
    for name, numbers in record.columns.items():
        row = not_finite(numbers)
        if row is not None:
            raise DataError(
                f"Column `{name}` of `{record.name}` has no number in row {row + 1} of its table; none may be missing."
            )
    return record


def tell_guesses(file: LabFile) -> LabFile:
    """Return a file, and print its interpretation once on standard error, unless all of it was given."""
    if not file.is_given:
        listed = "; ".join(f"{c.name} in {c.unit} is column {c.number}" for c in file.columns if c.si)
        tell_once(f"{file.path.name}: {file.format}; {listed}. {' '.join(file.notes)}".strip())
    return file


def read_table(
    source: str | Path,
    columns: Sequence[str] | None = None,
    *,
    interval: float | None = None,
    separator: str = "auto",
    drop: bool = False,
    gaps: bool = False,
) -> Record:
    """Return the record of a file with complete headings: text, Parquet, MAT or netCDF.

    Args:
        source: file, also of a result, or `data:<data set>/<file>`.
        columns: headings such as `temperature [degC]`, which replace those of the file; `-` skips a column.
        interval: time between rows [s] of a file without a time column, by default 1 s.
        separator: `auto`, `comma`, `semicolon`, `tab` or `whitespace`.
        drop: leave out rows that are unreadable or repeat the time before, and count them in `Record.dropped`. A
            truncated number is not detected. Some published data sets are read this way by default.
        gaps: read missing samples (empty or NaN cells) as NaN; a time must not be missing.

    Returns:
        The record in SI.

    Raises:
        DataError: the file is missing, empty or malformed; the sentence names the place.
        UnknownNameError: the data set or the file in it does not exist.
    """
    if interval is not None and not 0.0 < interval < math.inf:
        raise ParameterError(f"Argument `interval` must be above 0 s, but is {interval} s.")
    if separator not in ("auto", *SIGNS):
        raise ParameterError(f"Argument `separator` is `{separator}`. {suggest_name(separator, ('auto', *SIGNS))}")
    layout = _find_origin(source)[1]
    given: dict[str, Any] = {"separator": separator, "drop": drop}
    given["columns"] = None if columns is None else tuple(columns)
    layout = replace(layout, **{key: value for key, value in given.items() if value not in (None, "auto", False)})
    return read_exact(source, layout, interval=interval, gaps=gaps).record


def read_exact(
    source: str | Path,
    layout: Layout | None = None,
    *,
    interval: float | None = None,
    gaps: bool = False,
    names: Sequence[str] | None = None,
    units: Mapping[str, str] | None = None,
) -> LabFile:
    """Return a file with complete headings.

    Args:
        source: file, or `data:<data set>/<file>`.
        layout: layout of a text file, by default that of a published file.
        interval: time between rows [s] of a file without times.
        gaps: whether samples may be missing.
        names: arrays to read besides the time, by default all.
        units: units of arrays without a unit in the file, by name.

    Raises:
        InexactError: a heading is incomplete.
        DataError: the file is missing or malformed.
    """
    path, own, name = _find_origin(source)
    layout = layout or own
    if find_ending(path) in KINDS:
        raw, headings = _read_exact_arrays(read_container(path), layout, gaps, names, units or {})
        _refuse_left_out(raw)
    else:
        raw, headings = read_exact_text(path, layout, gaps)
    return build_exact(raw, headings, path, name, interval, layout.drop)


def _find_origin(source: str | Path) -> tuple[Path, Layout, str]:
    """Return the path of a source, its recorded layout, and a name."""
    if not is_published(source):
        return Path(source), Layout(()), Path(source).stem
    from martensite.logs import datasets

    key = str(source).removeprefix(PREFIX)
    return datasets.locate_file(key), datasets.describe_layout(key), key


def _read_exact_arrays(
    raw: RawTable, layout: Layout, gaps: bool, names: Sequence[str] | None, units: Mapping[str, str]
) -> tuple[RawTable, list[FileColumn]]:
    """Return arrays with the meanings of their headings, completed by given units."""
    plain = [name_column(column.heading) for column in raw.columns]
    if layout.columns and len(layout.columns) != len(plain):
        count = len(layout.columns)
        raise DataError(f"`{raw.name}` holds {len(plain)} columns, but {count} are named: {_list(plain)}.")
    given = list(layout.columns) or _head_arrays(raw, plain, names, units)
    headings = read_exact_headings(given, f"`{raw.name}`")
    refuse_mistaken(given, headings, f"`{raw.name}`")
    marked = [_mark_gaps(c, not gaps or h.name == "time") for c, h in zip(raw.columns, headings, strict=True)]
    return replace(raw, columns=tuple(marked)), headings


def _head_arrays(
    raw: RawTable, plain: Sequence[str], names: Sequence[str] | None, units: Mapping[str, str]
) -> list[str]:
    """Return the headings of arrays; `-` for skipped arrays."""
    missing = next((name for name in names or () if name not in plain), None)
    if missing is not None:
        raise DataError(f"`{raw.name}` has no column `{missing}`. {suggest_name(missing, plain)}")
    own = {"time": "s", **units}
    heads = [head_column(c.heading, c.unit or own.get(n, "")) for c, n in zip(raw.columns, plain, strict=True)]
    if names is not None:
        return [head if n in (*names, "time") else IGNORED for head, n in zip(heads, plain, strict=True)]
    unknown = [head for head in heads if "[" not in head and CANONICAL.get(head.rpartition(".")[2], "1") != "1"]
    if unknown:
        raise InexactError(
            f"`{raw.name}` does not say in which unit {_list(unknown)} is; name all its columns with units, such "
            f'as "temperature [degC]", in this order: {_list(plain)}.'
        )
    return heads


def _refuse_left_out(raw: RawTable) -> None:
    left = next((one for one in raw.left_out if one.count), None)
    if left is not None:
        raise DataError(f"`{raw.name}`, row {left.rows[0]} cannot be read: {left.reason}.")


def _mark_gaps(column: RawColumn, refused: bool) -> RawColumn:
    """Return a column of an array; refused missing samples become wrong cells."""
    places = np.flatnonzero(np.isnan(column.numbers)).tolist() if refused else ()
    rows = tuple(WrongCell(k + 1, "nan") for k in places)
    return replace(column, wrong=column.wrong or rows)


def _is_text(source: str | Path) -> bool:
    return find_ending(source) not in KINDS


def _list(names: Iterable[str]) -> str:
    return ", ".join(f"`{name}`" for name in names)


def _advise(error: DataError, source: str | Path) -> DataError:
    """Return the error with the command that repairs its file."""
    if is_published(source) or not _is_text(source) or ", row " not in str(error):
        return error
    return DataError(f"{error} `martensite data show {Path(source).name} --out clean.csv` leaves it out.")
