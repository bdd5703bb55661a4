"""Logs for commands and fits: to the letter where their headings are `name [unit]`, else as files of instruments."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from pathlib import Path

from martensite.base.errors import DataError, InputError
from martensite.base.files import tell_once
from martensite.logs.container_files import KINDS
from martensite.logs.lab_files import LabFile, UntoldError, read_lab_file
from martensite.logs.layout import CANONICAL, Layout, read_headings
from martensite.logs.sheets import is_number, read_sheet
from martensite.logs.tables import PREFIX, read_table
from martensite.signals.records import Record


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


def read_log_table(source: str | Path, interval: float | None = None, named: Mapping[str, str] | None = None) -> Record:
    """Return the record of a log, as `read_log` reads it; what was guessed or left out is said once on standard error.

    Raises:
        DataError: it cannot be read.
    """
    record, file = read_log(source, interval, named)
    if file is not None and not file.is_given:
        listed = "; ".join(f"{c.name} in {c.unit} is column {c.number}" for c in file.columns if c.si)
        tell_once(f"{file.path.name}: {file.format}; {listed}. {' '.join(file.notes)}".strip())
    return record


def read_log(
    source: str | Path, interval: float | None = None, named: Mapping[str, str] | None = None, known: bool = False
) -> tuple[Record, LabFile | None]:
    """Read a log; headings `name [unit]` select `read_table`, with gaps, and other headings `read_lab_file`.

    A fault below headings `name [unit]` is an error, without a guess.

    Args:
        source: a file, or `data:<data set>/<file>`.
        interval: time between rows [s] of a file without times.
        named: what columns are, by heading or number, as `read_lab_file` takes it.
        known: whether unknown headings are guessed as well, such as `Load [N]`.

    Returns:
        The record, with NaN for missing samples, and how the file was understood where it was not to the letter.

    Raises:
        DataError: neither can read it, or `named` corrects a published data set.
    """
    ours = str(source).startswith(PREFIX)
    if named and ours:
        raise DataError(f"The columns of `{source}` are known; `--as` has no effect on it.")
    refused: DataError | None = None
    if not named:
        try:
            record = read_table(source, interval=interval, gaps=True)
            if ours or not known or all(name.rpartition(".")[2] in CANONICAL for name in record.columns):
                return record, None
        except DataError as error:
            if ours or Path(source).suffix.lower() == ".nc" or not Path(source).is_file():
                raise
            refused = error
    try:
        found = read_lab_file(source, named)
    except UntoldError:
        raise
    except DataError:
        if refused is None:
            raise
        raise refused from None
    if refused is not None and has_own_headings(Path(source)):
        raise DataError(f"{refused} `martensite data show {found.path.name} --out clean.csv` leaves it out.")
    if interval is not None and not found.has_time:
        found = found.with_interval(interval)
    return found.record, found


def has_own_headings(path: Path) -> bool:
    """Return whether a text file begins with headings that are read to the letter."""
    if path.suffix.lower() in KINDS:
        return False
    try:
        first = read_sheet(path, Layout(())).rows[0]
        return len(first) > 1 and not any(map(is_number, first)) and bool(read_headings(first, path.name))
    except DataError:
        return False
