"""Files of laboratory instruments, read without a description.

`read_lab_file` finds the table (`logs.raw_table`), the columns by heading, unit and values (`logs.heading_guess`,
`logs.value_guess`), and the times (`logs.table_times`). It reports format, columns with ranges, and omitted rows with
the reason. Notes mark uncertain assignments; an undecidable meaning is an error with the option to set it.
`new_headings` corrects: a heading or the number of a column -> `stress[MPa]`, or `-` to skip it.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from martensite.base import units
from martensite.base.errors import DataError, ParameterError, suggest_name
from martensite.base.files import write_file
from martensite.logs.cells import Numbers
from martensite.logs.column_meanings import AMBIGUOUS, HEAT_FLOW, Meaning, guess_meanings, write_unit
from martensite.logs.container_files import KINDS, find_ending, part_sheet, read_container
from martensite.logs.layout import CANONICAL, CLOCK, IGNORED, read_headings
from martensite.logs.raw_table import LeftOut, RawColumn, RawTable, count_rows
from martensite.logs.record_text import format_record
from martensite.logs.table_headings import SEPARATORS
from martensite.logs.table_times import TableTimes, build_times, count_blocks, find_interval, find_start, find_step
from martensite.logs.text_tables import read_text_table
from martensite.logs.value_guess import is_rising, mend_fall
from martensite.signals.records import Record


@dataclass(frozen=True)
class ReadColumn:
    """Assigned meaning of a column of a file."""

    number: int
    """Number of the column in the file, from 1."""
    heading: str
    """Heading in the file."""
    name: str
    """Column of the record; `-` if skipped."""
    file_unit: str
    """Unit in the file; may be empty."""
    unit: str
    """Assigned unit."""
    si: str
    """SI unit of the record."""
    low: float
    """Minimum in SI."""
    high: float
    """Maximum in SI."""
    source: str
    """Source: `heading`, `unit`, `values`, or `given`."""
    certainty: str = ""
    """`given` by the file or the user, `inferred` with evidence, or `ambiguous`."""


@dataclass(frozen=True)
class LabFile:
    """File of an instrument, and its interpretation."""

    path: Path
    format: str
    """Format of the file, in one sentence."""
    record: Record
    """In SI; without times its rows are one second apart (`has_time`)."""
    columns: tuple[ReadColumn, ...]
    dropped: tuple[LeftOut, ...]
    """Omitted rows, by reason."""
    notes: tuple[str, ...]
    """Uncertain assignments and corrections."""
    has_time: bool
    start: float | None = None
    """Absolute time of the record's zero [s] since the first day of the calendar; below 86 400 the time of day."""
    has_preamble: bool = False
    """True if lines precede the table."""
    has_renamed_columns: bool = False
    """True if complete headings were read by their meaning, such as `Load [N]` as `force`."""
    labels: tuple[str, ...] = ()
    """Cells above the headings, one per column."""
    header_entries: Mapping[str, str] = field(default_factory=dict[str, str])
    """Entries in the lines above the table: lower-case word -> text next to it."""
    exact: bool = False
    """True if all headings are complete and the file was read exactly."""

    @property
    def is_given(self) -> bool:
        """Return whether nothing was guessed, omitted or corrected."""
        guessed = any(one.si and one.source != "given" for one in self.columns)
        return not (self.notes or self.dropped or self.has_preamble or guessed)

    def with_interval(self, interval: float) -> LabFile:
        """Return the file with a time between rows [s]."""
        times = interval * np.arange(float(len(self.record)))
        record = replace(self.record, columns=self.record.columns | {"time": times}, interval=interval)
        return replace(self, record=record, has_time=True)

    def to_csv(self) -> str:
        """Return the record as text with headings that `read_table` reads; missing samples are empty."""
        return format_record(self.record, [name for name in self.record.columns if name != "time" or self.has_time])

    def save(self, path: str | Path) -> None:
        """Write `to_csv` to a file.

        Raises:
            DataError: the file cannot be written.
        """
        write_file(Path(path), self.to_csv())


class UntoldError(DataError):
    """Error for columns of unknown meaning; the sentence names the option to give."""


def read_lab_file(path: str | Path, new_headings: Mapping[str, str] | None = None) -> LabFile:
    """Return a file of a laboratory instrument: text of any layout, .xlsx, .mat, .parquet, .nc, .tdms or .mcap.

    Args:
        path: file to read.
        new_headings: meanings of columns, by heading or number: `{"2": "stress[MPa]", "Comment": "-"}`.

    Raises:
        DataError: there is no table of numbers, time runs back, or the meaning of columns is undecidable.
        InputError: a required extra is not installed.
    """
    raw = read_raw(Path(path))
    return interpret_table(raw, Path(path), new_headings or {})


def split_side_by_side(file: LabFile) -> list[LabFile]:
    """Return one file for each of several equal tables side by side; a file with one table unchanged."""
    used = [one for one in file.columns if one.si]
    names = [one.name.removesuffix(f"_{one.number}") for one in used]
    width = next((k for k in range(2, len(names)) if names[:k] * (len(names) // k) == names), 0)
    if not width or "time" in names:
        return [file]
    files: list[LabFile] = []
    for first in range(0, len(used), width):
        part = used[first : first + width]
        label = file.labels[part[0].number - 1] if file.labels else str(first // width + 1)
        columns = {name: file.record[one.name] for name, one in zip(names, part, strict=False)}
        si_units = {name: one.si for name, one in zip(names, part, strict=False)}
        rows = _drop_empty(columns)
        columns = {name: column[rows] for name, column in columns.items()}
        columns = {"time": file.record.times[: len(rows)]} | columns
        name = f"{file.record.name} {label}"
        record = replace(file.record, name=name, columns=columns, units={"time": "s"} | si_units)
        own = tuple(replace(one, name=name) for name, one in zip(names, part, strict=False))
        files.append(replace(file, record=record, columns=own, labels=(label,)))
    return files


def read_raw(path: Path, separator: str = "auto") -> RawTable:
    """Return the table of a file of any kind, without meanings; errors as `read_lab_file`."""
    if separator not in ("auto", *SEPARATORS):
        raise ParameterError(f"There is no separator `{separator}`. {suggest_name(separator, SEPARATORS)}")
    return read_container(path) if find_ending(path) in KINDS else read_text_table(path, separator)


def interpret_table(raw: RawTable, path: Path, new_headings: Mapping[str, str]) -> LabFile:
    """Return a table with the meaning of its columns; arguments and errors as `read_lab_file`."""
    meant = guess_meanings(raw, new_headings)
    blocks = leave_blocks(raw, meant)
    file_times, clock = _find_times(raw, meant)
    times, timed = (file_times, True) if file_times else _assume_times(raw, bool(blocks))
    columns, si_units, listed = _convert_columns(raw, meant, times, clock)
    notes = [*raw.notes, *blocks, *times.notes, *_list_doubts(raw, meant, clock), *_mend_columns(columns, meant)]
    if columns.keys() <= {"time"}:
        raise UntoldError(_explain_unknown(raw, meant))
    left, kept_rows = raw.left_out + times.left_out, _drop_empty(columns)
    if len(kept_rows) < len(times.times):
        left += count_rows("no number but the time", raw.numbers[np.delete(times.rows, kept_rows)])
        columns = {name: column[kept_rows] for name, column in columns.items()}
    count = sum(one.count for one in left if one.reason != "below the table")
    file, sheet = part_sheet(path)
    record = Record(f"{file.stem} {sheet}".strip(), columns, si_units, file, count, None if timed else 1.0)
    titled = len(raw.numbers) > 0 and int(raw.numbers[0]) > 1 + int(raw.has_headings)
    parts = tuple(listed), left, tuple(notes)
    return LabFile(
        path, raw.form, record, *parts, timed, times.start, titled, labels=raw.labels, header_entries=raw.header_entries
    )


def _convert_columns(
    raw: RawTable, meant: list[Meaning], times: TableTimes, clock: int
) -> tuple[dict[str, Numbers], dict[str, str], list[ReadColumn]]:
    """Return the columns in SI with the times, their units, and descriptions of all columns."""
    columns, si_units = ({}, {}) if clock >= 0 else ({"time": times.times}, {"time": "s"})
    listed: list[ReadColumn] = []
    for place, (column, one) in enumerate(zip(raw.columns, meant, strict=True)):
        if place == clock:
            listed.append(describe_column(place, column, replace(one, name="time"), "s", times.times))
            columns["time"], si_units["time"] = times.times, "s"
        elif one.name in ("", IGNORED, "time") or one.unit == CLOCK:
            listed.append(describe_column(place, column, one, "", np.array([math.nan])))
        else:
            (head,) = read_headings([f"{one.name} [{one.unit}]"], f"`{raw.name}`")
            factor, offset = units.find_conversion(head.spelling, head.unit)
            numbers = (column.numbers[times.rows] * one.factor + one.offset) * factor + offset
            columns[head.name], si_units[head.name] = numbers, head.unit
            listed.append(describe_column(place, column, replace(one, name=head.name), head.unit, numbers))
    return columns, si_units, listed


def _assume_times(raw: RawTable, separate: bool) -> tuple[TableTimes, bool]:
    """Return times of a table without a time column, and whether the file gives their interval; else it is 1 s."""
    given = [(column.heading, column.unit, column.numbers) for column in raw.columns]
    interval = None if separate else find_interval(raw.header_entries) or find_step(given)
    notes = (f"The file has no times: it says that its samples are {interval:g} s apart.",) if interval else ()
    rows = np.arange(raw.rows)
    return TableTimes((interval or 1.0) * rows.astype(float), rows, None, (), notes), interval is not None


def _drop_empty(columns: Mapping[str, Numbers]) -> NDArray[np.intp]:
    """Return the rows with a number besides their time."""
    rows = np.flatnonzero(np.any([np.isfinite(column) for name, column in columns.items() if name != "time"], axis=0))
    if not rows.size:
        raise DataError(f"No column but the time holds a number: {', '.join(columns)} are empty.")
    return rows


def describe_column(place: int, column: RawColumn, meaning: Meaning, si: str, numbers: Numbers) -> ReadColumn:
    """Return the meaning of a column with its range in SI; `si` is empty for an unused column."""
    finite = numbers[np.isfinite(numbers)]
    low, high = (float(finite.min()), float(finite.max())) if finite.size else (math.nan, math.nan)
    name, written, by = meaning.name if si else IGNORED, write_unit(column), meaning.source if si else ""
    certainty = meaning.certainty if si else ""
    return ReadColumn(place + 1, column.heading, name, written, meaning.unit, si, low, high, by, certainty)


def choose_time(raw: RawTable, meant: list[Meaning]) -> int:
    """Return the place of the time column: a rising number, else a clock; -1 without one."""
    places = [k for k, one in enumerate(meant) if one.name == "time"]
    numeric = [k for k in places if raw.columns[k].kind == "number"]
    clocks = [k for k in places if raw.columns[k].kind in ("stamp", "clock")]
    numeric.sort(key=lambda k: (meant[k].source != "given", not is_rising(raw.columns[k].numbers)))
    if numeric and (not clocks or meant[numeric[0]].source == "given" or is_rising(raw.columns[numeric[0]].numbers)):
        return numeric[0]
    return clocks[0] if clocks else -1


def leave_blocks(raw: RawTable, meant: list[Meaning]) -> list[str]:
    """Ignore a time that restarts repeatedly, as loggers in append mode write it; return the note about it."""
    place = choose_time(raw, meant)
    blocks = count_blocks(raw.columns[place].numbers) if place >= 0 and raw.columns[place].kind == "number" else 1
    if blocks < 3:
        return []
    meant[place] = Meaning(IGNORED, "", "")
    return [
        f"Time begins again at its first value in {blocks} blocks and is left out: the file does not say how far apart "
        "its rows are. Give the time between rows (`--interval`)."
    ]


def _find_times(raw: RawTable, meant: list[Meaning]) -> tuple[TableTimes | None, int]:
    """Return the times of the rows and the place of their column; None and -1 without a time column."""
    seconds, start = find_start(raw)
    place = choose_time(raw, meant)
    if place < 0:
        return None, -1
    times = raw.columns[place].numbers
    if raw.columns[place].kind != "number" and seconds is not None and start is not None:
        return build_times(raw, seconds - start, start, False), place
    if seconds is not None and meant[place].source == "values":
        meant[place] = _judge_by_clock(meant[place], times, seconds)
    factor, _ = units.find_conversion(meant[place].unit or "s", "s")
    finite = times[np.isfinite(times)]
    absolute = bool(finite.size) and finite[0] * factor > 1e8  # a stamp of a computer or a spreadsheet
    times = (times - finite[0] if absolute else times) * factor
    begin = None if start is None or not finite.size else start - (0.0 if absolute else float(finite[0]) * factor)
    return build_times(raw, times, begin, True), place


def _judge_by_clock(one: Meaning, times: Numbers, seconds: Numbers) -> Meaning:
    """Return a time without unit in the unit that matches the duration of the clock."""
    rows = np.flatnonzero(np.isfinite(times) & np.isfinite(seconds))
    span = seconds[rows[-1]] - seconds[rows[0]] if rows.size > 1 else 0.0
    if not span > 0.0:
        return one
    ratio = (times[rows[-1]] - times[rows[0]]) / span
    for unit, size in (("s", 1.0), ("ms", 1e3), ("us", 1e6), ("min", 1 / 60.0)):
        if abs(ratio / size - 1.0) < 0.1 + 2.0 / span:
            return replace(one, unit=unit, sure=True)
    return one


def _list_doubts(raw: RawTable, meant: list[Meaning], clock: int) -> list[str]:
    """Return sentences about uncertain or skipped columns."""
    doubts: list[str] = []
    for place, (column, one) in enumerate(zip(raw.columns, meant, strict=True)):
        title = f"Column {place + 1}" + (f" `{column.heading}`" if column.heading else "")
        if column.wrong and column.kind != "text" and one.name not in ("", IGNORED):
            many = f"{len(column.wrong)} cells hold no finite number and count as missing"
            doubts.append(f"{title}: {many}, first {column.wrong[0]}.")
        doubts += filter(None, [_describe_doubt(title, f"--as {place + 1}", column, one, place == clock)])
        if column.unsure and place == clock:
            doubts.append(f"{title}: day and month cannot be told apart; the day is taken to come first.")
    return doubts


def _describe_doubt(title: str, option: str, column: RawColumn, meaning: Meaning, clock: bool) -> str:
    """Return a sentence about an uncertain meaning of a column; empty if it is certain."""
    name, by = meaning.name, meaning.source
    if by == AMBIGUOUS:
        return (
            f"{title} is left out: its values fit degrees and radians; write `{option}=angle[deg]` or "
            f"`{option}=angle[rad]`."
        )
    if clock or (name not in ("", IGNORED, "time") and by in ("values", "heading")):
        if by == "values" and not meaning.sure:
            return f"{title} is taken for {name} in {meaning.unit} by its values alone; `{option}=…` corrects it."
        if not meaning.sure:
            return (
                f"{title} has another unit, {column.unit}, below it; {meaning.unit} is read; `{option}=…` corrects it."
            )
        if by == "heading" and meaning.unit == "1" and name.rpartition(".")[2] not in CANONICAL:
            example = "heat_flow[W/g]" if name == HEAT_FLOW else "quantity[unit]"
            return f"{title} is kept as plain numbers, `{name}`; `{option}={example}` names it."
    elif not name and column.kind == "number" and np.isfinite(column.numbers).any():
        low, high = np.nanmin(column.numbers), np.nanmax(column.numbers)
        return (
            f"{title}, {low:.6g} to {high:.6g}, was not understood and is left out; "
            f"write for example `{option}=stress[MPa]`."
        )
    return ""


def _mend_columns(columns: dict[str, Numbers], meant: list[Meaning]) -> list[str]:
    """Correct a stepped supply whose counter fell back, if its values show it; return the note."""
    by_values = {one.name for one in meant if one.source == "values"}
    if not {"voltage", "current"} <= by_values:
        return []
    columns["voltage"], rows, height = mend_fall(columns["voltage"], columns["current"])
    where = f"at row {rows[0] + 1} of the record" if rows else ""
    words = f"The counter of `voltage` fell back by {height:g} V while the current went on, {where}: put right."
    return [words] if rows else []


def _explain_unknown(raw: RawTable, meant: list[Meaning]) -> str:
    numbered = [
        k for k, column in enumerate(raw.columns) if column.kind == "number" and np.isfinite(column.numbers).any()
    ]
    if all(meant[k].name == "time" for k in numbered):
        return f"`{raw.name}` holds no numbers but its times."
    ranges = [
        f"{k + 1} ({np.nanmin(raw.columns[k].numbers):.4g} to {np.nanmax(raw.columns[k].numbers):.4g})"
        for k in numbered[:6]
    ]
    blocks = {k: count for k in numbered if (count := count_blocks(raw.columns[k].numbers)) > 2}
    for place, count in blocks.items():
        rest = " ".join(f"--as {k + 1}=position[mm]" for k in numbered if k != place)
        return (
            f"`{raw.name}`: column {place + 1} begins again every {raw.rows // count} rows, as a time in blocks does; "
            "give the time between rows (`--interval`) and the meaning of the other columns, for example "
            f"`{rest}`."
        )
    free = next((k for k in numbered if meant[k].name != "time"), numbered[0])
    return (
        f"`{raw.name}`: neither headings nor values tell what the columns are: column {', '.join(ranges)}. "
        f"Name one, for example `stress[MPa]` (`--as {free + 1}=stress[MPa]`; in Python "
        f'`new_headings={{"{free + 1}": "stress[MPa]"}}`).'
    )
