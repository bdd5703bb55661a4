"""The one reader of measured files, for all commands, fits, boards and the web page.

`read_log` takes a file to the letter where its headings settle all meanings (`logs.exact_tables`), and finds meanings
and units where they do not (`logs.lab_files`). `read_table` is the strict form: nothing is found, all is given.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from itertools import chain
from pathlib import Path

from martensite.base.errors import DataError, InputError, ParameterError, suggest_name
from martensite.base.files import tell_once
from martensite.logs.binary_files import BINARY, head_column
from martensite.logs.container_files import KINDS, find_ending, list_sheets, read_container
from martensite.logs.exact_tables import (
    SIGNS,
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
from martensite.signals.records import Record

PREFIX = "data:"


def parse_named(texts: Iterable[str]) -> dict[str, str]:
    """Return the meanings of columns, by column, from texts such as `2=stress[MPa]`.

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
    """Return whether a log is a file of named arrays, and not of a published data set."""
    return not is_published(source) and Path(source).suffix.lower() in BINARY


def read_log(
    source: str | Path, named: Mapping[str, str] | None = None, interval: float | None = None, *, known: bool = False
) -> LabFile:
    """Read a log of any kind; a fault below headings that settle all meanings is an error.

    Args:
        source: a file, or `data:<data set>/<file>`.
        named: meaning of columns, by heading or number, as `read_lab_file` takes it.
        interval: time between rows [s] of a file without times.
        known: find the meaning of headings that settle their unit but are no known name, such as `Load [N]`.

    Returns:
        The record in SI, with NaN for missing samples, and how certain each of its columns is.

    Raises:
        DataError: it cannot be read, or `named` corrects a published data set.
    """
    if named and is_published(source):
        raise DataError(f"The columns of `{source}` are known; `--as` has no effect on it.")
    found = None if named else _try_exact(source, interval)
    exact = found is not None and found.exact
    if found is not None and exact and (is_published(source) or not known or is_all_known(found.record)):
        return found
    if found is None or exact:
        found = replace(read_lab_file(source, named), renamed=exact)
    return found.with_interval(interval) if interval is not None and not found.has_time else found


def read_parts(
    source: str | Path, named: Mapping[str, str] | None = None, interval: float | None = None, *, known: bool = False
) -> list[LabFile]:
    """Read all tables of a file: each sheet of a spreadsheet, and each of several equal tables side by side.

    Arguments and errors are those of `read_log`.
    """
    files = [read_log(part, named, interval, known=known) for part in list_sheets(source)]
    return [part for file in files for part in split_side_by_side(file)]


def _try_exact(source: str | Path, interval: float | None) -> LabFile | None:
    """Return a file to the letter, or as understood if cells need that; None if headings leave meanings open."""
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
    """Return a file that is understood without the loss of any cell: thousands, a counter that begins anew; or None."""
    try:
        found = read_lab_file(source)
    except DataError:
        return None
    columns = chain.from_iterable(found.record.columns.values())
    lost = found.dropped or found.record.dropped or not all(map(math.isfinite, columns))
    return None if lost else found


def read_log_table(source: str | Path, interval: float | None = None, named: Mapping[str, str] | None = None) -> Record:
    """Return the record of `read_log`; its guesses and omissions are printed once on standard error.

    Raises:
        DataError: it cannot be read.
    """
    return tell_guesses(read_log(source, named, interval)).record


def read_complete(source: str | Path, interval: float | None = None) -> Record:
    """Return the record of `read_log_table` for a computation that takes no missing samples.

    Raises:
        DataError: it cannot be read, or a sample is missing.
    """
    record = read_log_table(source, interval)
    for name, numbers in record.columns.items():
        row = next((k for k, number in enumerate(numbers, start=1) if math.isnan(number)), None)
        if row is not None:
            raise DataError(
                f"Column `{name}` of `{record.name}` has no number in row {row} of its table; none may be missing."
            )
    return record


def tell_guesses(file: LabFile) -> LabFile:
    """Return a file, and print once on standard error how it was understood, unless all of it was given."""
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
    """Read a file whose headings settle all meanings: text, or Parquet, MAT and netCDF files.

    Args:
        source: a file, of a result too, or `data:<data set>/<file>` for one of the published data sets.
        columns: headings such as `temperature [degC]`, for files that have none; they
            replace the headings of a file that has some. `-` passes a column over.
        interval: time between rows [s] of a file without a time column; 1 s if left out.
        separator: `auto`, `comma`, `semicolon`, `tab` or `whitespace`.
        drop: leave out rows that cannot be read or that repeat the time before, and count
            them in `Record.dropped`. A number that was cut short cannot be told from one
            that was not. Some of the published data sets are read so anyway.
        gaps: read missing samples (cells that are empty or hold NaN) as NaN; a time is never missing.

    Returns:
        The record in SI.

    Raises:
        DataError: the file is missing, empty or malformed; the sentence says where.
        UnknownNameError: the data set or the file in it does not exist.
    """
    if interval is not None and not 0.0 < interval < math.inf:
        raise ParameterError(f"Argument `interval` must be above 0 s, but is {interval} s.")
    if separator not in ("auto", *SIGNS):
        raise ParameterError(f"Argument `separator` is `{separator}`. {suggest_name(separator, ('auto', *SIGNS))}")
    layout = _find_origin(source)[1]
    given = {"columns": None if columns is None else tuple(columns), "separator": separator, "drop": drop}
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
    """Read a file to the letter.

    Args:
        source: a file, or `data:<data set>/<file>`.
        layout: layout of a text file; that of a published file by default.
        interval: time between rows [s] of a file without times.
        gaps: whether samples may be missing.
        names: columns of arrays that are read beside the time; all by default.
        units: units of arrays that have none in the file, by name.

    Raises:
        InexactError: a heading leaves its meaning or unit open.
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
    """Return the path of a source, the layout that is on record, and a name."""
    if not is_published(source):
        return Path(source), Layout(()), Path(source).stem
    from martensite.logs import datasets

    key = str(source).removeprefix(PREFIX)
    return datasets.locate_file(key), datasets.describe_layout(key), key


def _read_exact_arrays(
    raw: RawTable, layout: Layout, gaps: bool, names: Sequence[str] | None, units: Mapping[str, str]
) -> tuple[RawTable, list[FileColumn]]:
    """Return arrays with the meanings of their headings, each completed by its unit if that is given."""
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
    """Return the headings of arrays; `-` for one that is not asked for."""
    missing = next((name for name in names or () if name not in plain), None)
    if missing is not None:
        raise DataError(f"`{raw.name}` has no column `{missing}`. {suggest_name(missing, plain)}")
    own = {"time": "s", **units}
    found = [head_column(c.heading, c.unit or own.get(n, "")) for c, n in zip(raw.columns, plain, strict=True)]
    if names is not None:
        return [head if n in (*names, "time") else IGNORED for head, n in zip(found, plain, strict=True)]
    unknown = [head for head in found if "[" not in head and CANONICAL.get(head.rpartition(".")[2], "1") != "1"]
    if unknown:
        raise InexactError(
            f"`{raw.name}` does not say in which unit {_list(unknown)} is; name all its columns with units, such "
            f'as "temperature [degC]", in this order: {_list(plain)}.'
        )
    return found


def _refuse_left_out(raw: RawTable) -> None:
    left = next((one for one in raw.left_out if one.count), None)
    if left is not None:
        raise DataError(f"`{raw.name}`, row {left.rows[0]} cannot be read: {left.reason}.")


def _mark_gaps(column: RawColumn, refused: bool) -> RawColumn:
    """Return a column of an array whose missing samples are wrong cells, if they are refused."""
    rows = () if not refused else tuple(WrongCell(k + 1, "nan") for k, x in enumerate(column.numbers) if math.isnan(x))
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
