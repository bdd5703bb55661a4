"""Tables of conditions: one row per short run from the initial state, with its settings and measures.

    specimen, current [A], duration [s], load [gf], peak stroke [mm], peak stroke sd [mm], n
    A,        2.0,         5,            300,       8.1,              0.3,                 5

A heading is one of these:

- an input of the run: a well-known word, or a path as for `--set`;
- a measure: `peak stroke`, `force rise`, `steady temperature`, `time to 90 % force`, or as for `--goal`: `max(force)`;
- the standard deviation of a measure (`… sd`), or the number of repeats (`n`);
- a specimen or another group.

A file without times and with a measure in a heading is such a table.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

from martensite.base import units
from martensite.base.errors import DataError, UnitError, suggest_name
from martensite.base.parameters import find_paths
from martensite.fit.condition_headings import find_measure_words, split_heading
from martensite.logs.column_meanings import find_places
from martensite.logs.exact_rows import is_gap, is_number, read_rows
from martensite.logs.layout import CANONICAL, IGNORED, Layout, list_quantities
from martensite.logs.open_files import TEXT, describe_unreadable
from martensite.logs.reader import read_table
from martensite.scenario.assemble import waveform_path
from martensite.scenario.scenario import Scenario
from martensite.search.free_numbers import Target
from martensite.signals.base import DRIVE
from martensite.signals.records import Record
from martensite.simulate.drive_waveforms import by_name
from martensite.simulate.measures.base import AbstractMeasure, parse_measure
from martensite.simulate.waveform_levels import Level

GROUPS = ("specimen", "sample", "piece", "batch", "serial", "day")
"""Headings of group columns, with any cells."""
COUNTS = ("n", "count", "repeats", "number of repeats")
SPREADS = ("sd", "std", "s.d.", "±", "+-", "spread", "standard deviation")
INPUTS = {
    "ambient": ("environment.temperature",),
    "ambient temperature": ("environment.temperature",),
    "room temperature": ("environment.temperature",),
    "duration": ("run.duration",),
    "run time": ("run.duration",),
    "pulse": ("drive.waveform.until",),
    "on time": ("drive.waveform.until",),
    "pulse length": ("drive.waveform.until",),
    "load": ("mechanism.mass", "mechanism.force", "mechanism.preload"),
    "weight": ("mechanism.mass", "mechanism.force"),
    "length": ("element.length", "element.free_length"),
    "spring rate": ("mechanism.stiffness",),
    "film": ("environment.cooling.h",),
    "film coefficient": ("environment.cooling.h",),
}
"""Well-known word -> candidate paths for `--set`, in order of preference."""
LEVELS = {name: CANONICAL[name] for name in (*list_quantities("drive"), "temperature")}
"""Drive quantities -> unit; such a column sets the level of the waveform."""
PEAKS = ("level", "high", "first")
"""Waveform parameters that are a level."""
HEAD_BYTES = 65536
"""Number of bytes read to distinguish a table from a log."""
GRAVITY = 9.80665
"""Gravity [m/s²], which converts a load force to a mass."""


@dataclass(frozen=True)
class InputColumn:
    """Column that sets a parameter of the scenario."""

    heading: str
    path: str
    """Path for `--set`."""
    unit: str
    values: tuple[float, ...]
    """In SI, one per row."""
    level: bool = False
    """True for the column of the drive."""


@dataclass(frozen=True)
class MeasureColumn:
    """Column with a measure of a run."""

    heading: str
    words: str
    """Text for `parse_measure`."""
    measure: AbstractMeasure
    unit: str
    """SI unit of the measure."""
    values: tuple[float, ...]
    """In SI; NaN for missing measurements."""
    spreads: tuple[float, ...] = ()
    """Standard deviations [unit], if the table has them."""


@dataclass(frozen=True)
class ConditionTable:
    """Table of conditions with the meaning of its columns."""

    name: str
    path: Path
    inputs: tuple[InputColumn, ...]
    measures: tuple[MeasureColumn, ...]
    groups: dict[str, tuple[str, ...]] = field(default_factory=dict[str, tuple[str, ...]])
    """Groups of the rows: heading -> cells."""
    counts: tuple[float, ...] = ()
    """Number of repeats in the mean of each row."""
    notes: tuple[str, ...] = ()
    numbers: tuple[int, ...] = ()
    """Row numbers in the file."""


def is_condition_table(source: object, new_headings: Mapping[str, str] | None = None) -> bool:
    """Return whether a file is a table of conditions: no times, and a measure in a heading or in `new_headings`."""
    if not isinstance(source, (str, Path)) or not str(source).lower().endswith(TEXT) or not Path(source).is_file():
        return False
    names = [split_heading(one)[0] for one in (*_read_first_line(Path(source)), *(new_headings or {}).values())]
    return "time" not in names and any(find_measure_words(one, ()) for one in names)


def _read_first_line(path: Path) -> list[str]:
    """Return the cells of the first line that is not a comment."""
    with describe_unreadable(path), path.open("rb") as file:
        lines = file.read(HEAD_BYTES).decode("utf-8-sig", "replace").splitlines()
    line = next((one for one in lines if one.strip() and not one.lstrip().startswith("#")), "")
    sign = next((sign for sign in "\t;," if sign in line), None)
    return [cell.strip().strip('"') for cell in line.split(sign)] if sign else [line]


def read_condition_table(
    source: str | Path, scenario: Scenario, new_headings: Mapping[str, str] | None = None
) -> ConditionTable:
    """Read a table of conditions and assign its columns to a scenario.

    Args:
        source: text file with one row per condition.
        scenario: scenario whose parameters the columns set.
        new_headings: replacement headings for unclear columns, by heading or number.

    Raises:
        InputError: a column is neither input nor measure, a unit is missing or wrong, or a cell is not a number.
    """
    path = Path(source)
    sheet = read_rows(path, Layout(()))
    own = not any(is_number(cell) for cell in sheet.rows[0])
    headings, rows = list(sheet.rows[0]) if own else [""] * len(sheet.rows[0]), sheet.rows[int(own) :]
    for place, text in find_places(headings, new_headings or {}, sheet.where).items():
        headings[place] = text
    if not rows:
        raise DataError(f"{sheet.where} holds headings but no rows.")
    width = next((k for k, row in enumerate(rows) if len(row) != len(headings)), None)
    if width is not None:
        where = f"{sheet.where}, row {sheet.numbers[width + own]}"
        raise DataError(f"{where} has {len(rows[width])} cells, but there are {len(headings)} columns.")
    reading = _Reading(path, scenario, rows, sheet.numbers[int(own) :])
    for place, heading in enumerate(headings):
        reading.add_column(place, heading)
    return reading.finish(headings)


class _Reading:
    """Reader of the columns of a table."""

    def __init__(self, path: Path, scenario: Scenario, rows: Sequence[Sequence[str]], numbers: Sequence[int]) -> None:
        self.path, self.scenario, self.rows, self.numbers = path, scenario, rows, numbers
        self.where, self.outputs = f"`{path.name}`", scenario.system.outputs()
        self.inputs = _list_inputs(scenario)
        self.roles: dict[int, tuple[str, str, str]] = {}
        """Column -> its role, heading, and path, measure or group."""
        self.units: dict[int, tuple[str, str]] = {}
        """Column -> unit as written, and in SI."""
        self.groups: dict[str, tuple[str, ...]] = {}
        self.notes: list[str] = []

    def add_column(self, place: int, heading: str) -> None:
        """Assign a role to a column."""
        name, unit = split_heading(heading)
        cells = [row[place].strip() for row in self.rows]
        words = any(not is_gap(cell) and not is_number(cell) for cell in cells)
        if name in ("", IGNORED):
            return
        if name in GROUPS or (words and len(set(cells)) < len(cells)):
            if not all(cells):
                raise DataError(f"{self.where}: column `{name}` has an empty cell; every row belongs to one.")
            self.groups[name] = tuple(cells)
            self.notes.append(f"Column `{name}`: what a row belongs to ({', '.join(dict.fromkeys(cells))}).")
        elif words:
            cell = next(cell for cell in cells if not is_gap(cell) and not is_number(cell))
            if self._find_role(name) is not None:
                raise DataError(f"{self.where}, column `{name}`: `{cell}` is not a number.")
            self.notes.append(f"Column `{name}` holds remarks and is passed over.")
        else:
            self._add_numbers(place, name, unit)

    def _add_numbers(self, place: int, name: str, unit: str) -> None:
        column_role = self._find_role(name)
        if column_role is None:
            likely = [*INPUTS, *LEVELS, *(n.rpartition(".")[2] for n in self.inputs)]
            raise DataError(
                f"{self.where}: column `{name}` is nothing that the scenario is given, and no measure. "
                f"{suggest_name(name, likely)} A measure is written `peak force`, `force rise` or "
                "`max(force)`; a column headed `-` is passed over."
            )
        role, what = column_role
        double = next((h for r, h, w in self.roles.values() if (r, w) == column_role), None)
        if double is not None:
            raise DataError(f"{self.where}: columns `{double}` and `{name}` both are `{what}`; leave one out.")
        si, spelling = "1", unit
        if role == "input":
            si = self.inputs[what].unit
            si = "N" if si == "kg" and _is_force(unit) else si
        elif role in ("measure", "spread"):
            si = parse_measure(what).unit_in(self.scenario.system)
            si, spelling = ("K", _spell_degrees(unit)) if si == units.DEGREES else (si, unit)
        self.units[place] = self._check_unit(name, spelling, si), si
        self.roles[place] = role, name, what
        if role != "count":
            unit_suffix = f" [{unit}]" if unit else ""
            meaning = {"input": "sets", "measure": "is", "spread": "is the standard deviation of"}[role]
            self.notes.append(f"Column `{name}{unit_suffix}` {meaning} `{what}`.")

    def _check_unit(self, name: str, spelling: str, si: str) -> str:
        if not spelling and si != "1":
            raise DataError(
                f"{self.where}: column `{name}` has no unit; write for example "
                f"`{name} [{units.choose_readable_unit(si)}]`."
            )
        try:
            units.to_si(1.0, spelling or "1", si)
        except UnitError as error:
            raise UnitError(f"{self.where}, column `{name}`: {error}") from None
        return spelling or "1"

    def _find_role(self, name: str) -> tuple[str, str] | None:
        """Return the role of a heading (input, measure, spread or count) and the quantity."""
        if name in COUNTS:
            return "count", name
        for mark in SPREADS:
            bare = re.sub(rf"(?:^{re.escape(mark)}(?: of)? | {re.escape(mark)}$)", "", name)
            if bare != name and (words := self._find_measure(bare)):
                return "spread", words
        path = self._find_input(name)
        if path:
            return "input", path
        words = self._find_measure(name)
        return ("measure", words) if words else None

    def _find_measure(self, name: str) -> str:
        words = find_measure_words(name, self.outputs)
        if not words and find_paths(name.replace(" ", "_"), self.outputs):
            words = f"final({name.replace(' ', '_')})"
        if words:
            words = words.replace("(, ", f"({next(iter(self.scenario.system.mechanism.outputs()))}, ")
            parse_measure(words).columns(self.scenario.system)
        return words

    def _find_input(self, name: str) -> str:
        """Return the path that a heading sets; empty if there is no such path."""
        if name in LEVELS:
            unit = LEVELS[name]
            return next((p for p, one in self.inputs.items() if one.level is not None and one.unit == unit), "")
        for path in INPUTS.get(name, ()):
            if path in self.inputs:
                return path
        paths = find_paths(name.replace(" ", "_") if "." not in name else name, self.inputs)
        return paths[0] if len(paths) == 1 else ""

    def finish(self, headings: Sequence[str]) -> ConditionTable:
        """Return the complete table.

        Raises:
            DataError: the table has no measure, or cells that are not numbers.
        """
        kinds = [role for role, _, _ in self.roles.values()]
        if "measure" not in kinds:
            raise DataError(f"{self.where} has no measure to fit, such as `peak stroke [mm]` or `max(force) [N]`.")
        names = [f"c{k} [{self.units[k][0]}]" if k in self.roles else IGNORED for k in range(len(headings))]
        record = read_table(self.path, names, interval=1.0, gaps=True)
        columns = {k: self._convert_column(k, record) for k in self.roles}
        spreads = {what: columns[k] for k, (role, _, what) in self.roles.items() if role == "spread"}
        inputs = tuple(
            InputColumn(name, what, self.inputs[what].unit, columns[k], self.inputs[what].level is not None)
            for k, (role, name, what) in self.roles.items()
            if role == "input"
        )
        measures = tuple(
            MeasureColumn(name, what, parse_measure(what), self.units[k][1], columns[k], spreads.get(what, ()))
            for k, (role, name, what) in self.roles.items()
            if role == "measure"
        )
        counts = next((columns[k] for k, (role, _, _) in self.roles.items() if role == "count"), ())
        table = ConditionTable(
            self.path.stem, self.path, inputs, measures, self.groups, counts, tuple(self.notes), tuple(self.numbers)
        )
        _check_cells(table, self.where, self.numbers)
        return table

    def _convert_column(self, place: int, record: Record) -> tuple[float, ...]:
        """Return a column in SI, with spreads as differences."""
        spelling, si = self.units[place]
        difference = self.roles[place][0] == "spread" or spelling.startswith("delta_")
        name = f"c{place}"
        written = [units.from_si(x, spelling, record.units[name]) for x in record[name].tolist()]
        factor, offset = units.find_conversion(spelling, si)
        role, _, what = self.roles[place]
        if role == "input" and self.inputs[what].unit != si:
            factor /= GRAVITY
        return tuple(x * factor + (0.0 if difference else offset) for x in written)


def _spell_degrees(unit: str) -> str:
    """Return the unit of a temperature difference, for all spellings."""
    return "K" if unit in ("K", "degC", "°C", "C") else unit


def _is_force(unit: str) -> bool:
    try:
        units.to_si(1.0, unit or "1", "N")
    except UnitError:
        return False
    return True


def _list_inputs(scenario: Scenario) -> dict[str, Target]:
    """Return the possible inputs of a table, by path for `--set`."""
    system = scenario.system
    targets = {"run.duration": Target("run.duration", "", "s", scenario.duration)}
    for leaf in system.leaves():
        path = scenario.places.path(leaf.path)
        targets[path] = Target.from_leaf(leaf, path)
    drives = {drive.name: drive.unit for drive in system.drives()}
    for name, wave in by_name(system, scenario.waveform).items():
        begin = waveform_path(system, name, scenario.places.drive)
        for leaf in wave.leaves():
            unit = drives[name] if leaf.declared.unit == DRIVE else leaf.declared.unit
            one = Target(begin + leaf.path, leaf.path, unit, float(leaf.value), leaf.declared.doc, drive=name)
            targets[one.name] = one
    return _mark_levels(targets)


def _mark_levels(targets: Mapping[str, Target]) -> dict[str, Target]:
    """Return the targets, with the first level parameter of every waveform marked as the drive."""
    marked = dict(targets)
    for drive in dict.fromkeys(one.drive for one in targets.values() if one.drive):
        own = {one.path: one for one in targets.values() if one.drive == drive}
        name = next((name for name in PEAKS if name in own), None)
        if name is not None:
            one = own[name]
            marked[one.name] = replace(one, level=Level(drive, name, one.value))
    return marked


def _check_cells(table: ConditionTable, where: str, numbers: Sequence[int]) -> None:
    """Raise `DataError` if required cells are missing."""
    for one in table.inputs:
        row = next((k for k, x in enumerate(one.values) if not math.isfinite(x)), None)
        if row is not None:
            raise DataError(f"{where}, row {numbers[row]}: `{one.heading}` is empty; every run needs what it is given.")
    for one in table.measures:
        if not any(map(math.isfinite, one.values)):
            raise DataError(f"{where}: column `{one.heading}` holds no numbers.")
        row = next((k for k, x in enumerate(one.spreads) if x <= 0.0), None)
        if row is not None:
            raise DataError(
                f"{where}, row {numbers[row]}: the standard deviation of `{one.heading}` must be above 0; "
                "leave the cell empty where it is not known."
            )
    row = next((k for k, x in enumerate(table.counts) if not x >= 1.0), None)
    if row is not None:
        raise DataError(f"{where}, row {numbers[row]}: the number of repeats must be at least 1.")
