"""Logs for commands and fits: to the letter where their headings are `name [unit]`, else as files of instruments."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path

from martensite.base.errors import DataError, InputError
from martensite.base.files import tell_once
from martensite.scenario.container_files import KINDS
from martensite.scenario.lab_files import UntoldError, read_lab_file
from martensite.scenario.layout import Layout, read_headings
from martensite.scenario.sheets import is_number, read_sheet
from martensite.scenario.tables import PREFIX, read_table
from martensite.signals.records import Record


def parse_named(texts: Iterable[str]) -> dict[str, str]:
    """What columns are, from `2=stress[MPa]`.

    Raises:
        InputError: a text names no column.
    """
    parts = [text.rpartition("=") for text in texts]
    wrong = next((text for key, equals, text in parts if not (key.strip() and equals and text.strip())), None)
    if wrong is not None:
        raise InputError(f"`{wrong}` does not say which column it is; write for example `--as 2=stress[MPa]`.")
    return {key.strip(): text.strip() for key, _, text in parts}


def read_log_table(
    source: str | Path,
    columns: Sequence[str] | None = None,
    interval: float | None = None,
    named: Mapping[str, str] | None = None,
) -> Record:
    """A log with headings `name [unit]` as `read_table` reads it, with gaps; any other as `read_lab_file` does.

    How another was understood is said once on standard error. A fault below such headings is no reason to guess.

    Raises:
        DataError: neither can read it.
    """
    if not named:
        try:
            return read_table(source, columns, interval=interval, gaps=True)
        except DataError as error:
            ours = str(source).startswith(PREFIX) or Path(source).suffix.lower() == ".nc"
            if columns is not None or ours or not Path(source).is_file():
                raise
            refused = error
        try:
            found = read_lab_file(source)
        except UntoldError:
            raise
        except DataError:
            raise refused from None
        if _has_own_headings(Path(source)):
            raise DataError(f"{refused} `martensite data show {found.path.name} --save clean.csv` leaves it out.")
    else:
        found = read_lab_file(source, named)
    if interval is not None and not found.has_time:
        found = found.with_interval(interval)
    listed = "; ".join(f"{c.name} in {c.unit} is column {c.number}" for c in found.columns if c.si)
    tell_once(f"{found.path.name}: {found.format}; {listed}. {' '.join(found.notes)}".strip())
    return found.record


def _has_own_headings(path: Path) -> bool:
    """Whether a text file begins with headings that `read_table` reads."""
    if path.suffix.lower() in KINDS:
        return False
    try:
        first = read_sheet(path, Layout(())).rows[0]
        return len(first) > 1 and not any(map(is_number, first)) and bool(read_headings(first, path.name))
    except DataError:
        return False
