"""Calls about logs: an uploaded table, its records, and its scenario."""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from martensite.app.documents import describe_scenarios, list_following
from martensite.app.identify.fit_request import build_scenario, list_rows
from martensite.app.identify.followed_columns import describe_drives, follow_column
from martensite.app.identify.log_kinds import describe_proposal, describe_reading, find_experiment, propose_models
from martensite.app.identify.log_overlay import draw_overlay, interpolate_within
from martensite.app.identify.mapped_table import describe_cuts, prepare_log, read_file, read_records
from martensite.app.messages import JsonTable, Request, require_entry
from martensite.app.views.columns import describe_conversion, describe_difference, describe_display, find_envelope
from martensite.app.worker import Desk
from martensite.base import units
from martensite.base.errors import MartensiteError, ParameterError
from martensite.base.files import MOST_LOG, read_unpacked, toml_document
from martensite.base.parameters import Leaf
from martensite.base.toml_text import as_toml
from martensite.fit.column_matching import list_echoes, match_columns
from martensite.fit.free_parameters import build_free_numbers
from martensite.fit.losses import LOSSES
from martensite.fit.solve import METHODS
from martensite.logs.column_meanings import Meaning, guess_meanings
from martensite.logs.datasets import locate_file
from martensite.logs.heading_guess import usual_units
from martensite.logs.lab_files import LabFile, choose_time, interpret_table, leave_blocks, read_raw
from martensite.logs.layout import CANONICAL
from martensite.logs.raw_table import RawColumn, RawTable
from martensite.scenario.assemble import waveform_path
from martensite.scenario.scenario import Scenario
from martensite.search.free_numbers import SearchRange
from martensite.signals.records import Record

SAMPLE = "flexinol-isobaric/isobaric_{}MPa.txt"
LOADS = (172, 50, 100, 200)
"""Stresses of the sample logs [MPa], the default first."""
SMALL = 120
"""Points of the small curve of a column."""
LONG = 100_000
"""Rows above which thinning is recommended."""


def place_sample(request: Request, desk: Desk) -> JsonTable:
    """Return a packaged log like an upload.

    {"load": 172} -> {"key", "name", "bytes"}
    """
    load = require_entry(request, "load", int, LOADS[0])
    if load not in LOADS:
        raise ParameterError(f"There is no measured loop at {load} MPa; there are {', '.join(map(str, LOADS))}.")
    name = SAMPLE.format(load)
    content = read_unpacked(locate_file(name), MOST_LOG)
    key, path = desk.files.place(name.rpartition("/")[2])
    path.write_bytes(content)
    return {"key": key, "name": path.name, "bytes": len(content)}


def describe_table(request: Request, desk: Desk) -> JsonTable:
    """Return the content of an uploaded table, and the possible meanings of its columns.

    {"key": …, "separator": "auto"}
    -> {"name", "said", "recognised", "rows", "separator", "preview": [[text, …], …], "columns": [{heading, name,
    unit, min, max, missing, wrong, curve, …}], "names": {name: [unit, …]}, "notes": […]}

    Cells are text. Numbers of columns are in the unit of the file.
    """
    path = desk.files.path(require_entry(request, "key", str))
    raw = read_raw(path, require_entry(request, "separator", str, "auto"))
    meanings = guess_meanings(raw, {})
    blocks = leave_blocks(raw, meanings)
    clock = choose_time(raw, meanings)
    guesses = [_name_guess(one, at == clock) for at, one in enumerate(meanings)]
    file = _read_untold(raw, path)
    return {
        "name": raw.name,
        "said": describe_reading(file, file.has_time) if file else "",
        "recognised": file is not None and find_experiment([file.record]) is not None,
        "rows": raw.rows,
        "separator": raw.separator,
        "headed": raw.has_headings,
        "preview": raw.preview,
        "columns": [_describe_column(c, *one) for c, one in zip(raw.columns, guesses, strict=True)],
        "names": {name: usual_units(name) for name in CANONICAL},
        "notes": [*blocks, *_list_notes(raw, meanings, clock)],
    }


def _name_guess(meaning: Meaning, is_clock: bool) -> tuple[str, str]:
    """Return the known name and unit of a column, empty if unknown; only one column is the time."""
    canonical = meaning.name.rpartition(".")[2] in CANONICAL and (meaning.name != "time" or is_clock)
    return (meaning.name, meaning.unit) if canonical else ("", "")


def _describe_column(column: RawColumn, name: str, unit: str) -> JsonTable:
    numbers, entries = column.numbers, column.numbers[~np.isnan(column.numbers)]
    rows = find_envelope(numbers, SMALL)
    return {
        "heading": column.heading,
        "name": name if entries.size else "",
        "unit": unit,
        "min": entries.min().item() if entries.size else None,
        "max": entries.max().item() if entries.size else None,
        "missing": len(numbers) - len(entries) - len(column.wrong),
        "wrong": len(column.wrong),
        "first_wrong": str(column.wrong[0]) if column.wrong else "",
        "curve": [rows, numbers[rows].tolist()],
    }


def _read_untold(raw: RawTable, path: Path) -> LabFile | None:
    """Return the table interpreted without user input, or None."""
    try:
        return interpret_table(raw, path, {})
    except MartensiteError:
        return None


def _list_notes(raw: RawTable, meant: list[Meaning], clock: int) -> Iterator[str]:
    yield from raw.notes
    unsure = [str(at) for at, one in enumerate(meant, start=1) if one.name and one.source == "values" and not one.sure]
    if unsure:
        yield f"Column {', '.join(unsure)}: guessed from the values; check the meaning."
    torn = [str(at) for at, one in enumerate(meant, start=1) if one.name and one.source == "heading" and not one.sure]
    if torn:
        yield f"Column {', '.join(torn)}: heading and row of units disagree; check the unit."
    if len(raw.columns) == 1:
        yield "The file has one column; if that is wrong, choose another separator."
    if any(column.wrong for column in raw.columns):
        yield "Some cells are not numeric. Leave out their columns or rows."
    if raw.rows > LONG:
        yield f"The file has {raw.rows:,} rows; thin it out in the next step."


DRAWN = 800


def describe_records(request: Request, desk: Desk) -> JsonTable:
    """Return the columns of a mapped table over time, to inspect, correct and cut.

    {"key": …, "columns": [{at, name, unit}], "interval": null, "drop": false, "steps": [], "cuts": [], "further": [] }
    -> {"begin": 0, "end": …, "rows": …, "columns": [{name, times, values, before, unit, display_unit, …}],
    "steps": […], "cuts": [{name, rows, refused}]}: curves thinned without loss of extremes; times in s, values in SI.
    `values` is the result of the steps at the times of `before`, the recorded values; `before` is empty without a
    change.
    """
    file, prepared = read_file(request, desk), prepare_log(request, desk)
    record = prepared.record
    return {
        "begin": record.times[0].item(),
        "end": record.times[-1].item(),
        "rows": len(record),
        "dropped": record.dropped,
        "timed": file.record.interval is None,
        "columns": [_draw_column(name, record, file.record) for name in record.columns if name != "time"],
        "steps": list(prepared.words),
        "cuts": describe_cuts(request, desk),
    }


def _draw_column(name: str, record: Record, recorded: Record) -> JsonTable:
    column = record[name]
    before = recorded.columns.get(name, column)
    same = _is_same(recorded.times, record.times) and _is_same(before, column)
    curve = column if same or name not in recorded.columns else before
    times = record.times if curve is column else recorded.times
    rows = find_envelope(curve, DRAWN)
    curve_times = times[rows].tolist()
    values = column[rows].tolist() if curve is column else interpolate_within(record.times, column, curve_times)
    return {
        "name": name,
        "times": curve_times,
        "values": values,
        "before": [] if curve is column else before[rows].tolist(),
        "missing": int(np.isnan(column).sum()),
        **describe_display(name, record.units[name]),
    }


def _is_same(one: Any, other: Any) -> bool:
    """Return whether two columns have the same values, and the same gaps."""
    return np.array_equal(one, other, equal_nan=True)


def overlay_logs(request: Request, desk: Desk) -> JsonTable:
    """Return all records of a request as one figure: over time from start or by the clock, or as loops.

    {the logs, "align": "start" or "clock"}
    -> {"said": …, "records": [name], "axis": {name, unit, …}, "x": […], "loops": true, "quantities": [{name, unit, …,
    "lines": [[value or null, …], …]}]}: one line per quantity and record, SI.
    """
    return draw_overlay(read_records(request, desk), require_entry(request, "align", str, "start"))


def propose_fit(request: Request, desk: Desk) -> JsonTable:
    """Return the kind of the logs, and proposed scenarios with their free parameters.

    {the logs} -> {"kind", "said", "refused", "notes": […], "models": [{name, text, free: [{name, low, high, start,
    scale}], "each": […], "starts"}]}; for an unknown kind `refused` has the reason.
    """
    try:
        proposals = propose_models(read_records(request, desk), {})
        models = [describe_proposal(one) for one in proposals.proposals]
    except MartensiteError as error:
        return {"kind": "", "said": "", "refused": str(error), "notes": [], "models": []}
    guess = proposals.experiment
    sentence = f"Taken as {guess.name}, {guess.kind.meaning}: {guess.why}."
    return {"kind": guess.name, "said": sentence, "refused": "", "notes": list(proposals.notes), "models": models}


def list_followers(request: Request, desk: Desk) -> JsonTable:
    """Return the packaged scenarios that follow a log.

    {} -> {"scenarios": [{name, title, text}]}
    """
    return describe_scenarios(list_following())


METHOD_WORDS = {
    "trf": "least squares within bounds, with exact derivatives",
    "coordinate": "one parameter after the other, without derivatives",
    "evolution": "differential evolution over all bounds, then least squares",
}
LOSS_WORDS = {
    "linear": "squares: right where errors are noise",
    "soft-l1": "large errors count less",
    "huber": "large errors count by their size, not its square",
    "cauchy": "very large errors hardly count",
}


def match_scenario(request: Request, desk: Desk) -> JsonTable:
    """Match a scenario with a log: followed columns, compared outputs, and possible free parameters.

    {the table of `identify.mapped_table`, "text": TOML, "follow": {"path": …, "column": …}}
    -> {"text": …, "title": …, "refused": "", "drives": […], "numbers": […], "outputs": […], "records": […], "methods":
    {…}, "losses": {…}}

    If the scenario cannot be built with the log, `refused` has the reason, and other entries are incomplete.
    """
    records = list_rows(request, desk)
    text = require_entry(request, "text", str)
    document = toml_document(text)
    follow = require_entry(request, "follow", dict, {})
    if follow:
        column = require_entry(follow, "column", str)
        records[0][column]  # raises for an unknown column
        path, unit = require_entry(follow, "path", str), records[0].units[column]
        document = follow_column(document, path, column, unit)
        text = as_toml(document)
    table = {
        "text": text,
        "drives": describe_drives(document),
        "columns": {name: unit for name, unit in records[0].units.items() if name != "time"},
        "records": [one.name for one in records],
        "methods": {name: METHOD_WORDS.get(name, "") for name in METHODS},
        "losses": {name: LOSS_WORDS.get(name, "") for name in LOSSES},
    }
    try:
        scenario = build_scenario({"text": text}, records[0])
    except MartensiteError as error:
        return {**table, "title": "", "refused": str(error), "numbers": [], "outputs": []}
    return {**table, **_describe_built(scenario, records[0]), "drives": _list_drives(document, scenario)}


def _list_drives(document: Request, scenario: Scenario) -> list[dict[str, str]]:
    section = scenario.places.drive
    followed = {
        waveform_path(scenario.system, name, section).removesuffix("."): column
        for name, column in scenario.follows.items()
    }
    return [one | {"column": followed.get(one["path"], "")} for one in describe_drives(document)]


def _describe_built(scenario: Scenario, record: Record) -> JsonTable:
    system = scenario.system
    outputs, refused = list[JsonTable](), ""
    try:
        matches, _, notes = match_columns(record, system, (), scenario.follows)
        outputs = [{"name": name, **describe_display(name, system.outputs()[name].unit)} for name in matches]
    except MartensiteError as error:
        refused, notes = str(error), []
    return {
        "title": scenario.title,
        "described": system.description(),
        "refused": refused,
        "follows": scenario.follows,
        "echoes": sorted(list_echoes(system)),
        "numbers": list_numbers(scenario),
        "outputs": [{**one, "difference": describe_difference(one["name"], one["unit"])} for one in outputs],
        "notes": [*notes, *scenario.cautions],
    }


def list_numbers(scenario: Scenario) -> list[JsonTable]:
    """Return one entry per parameter, or per group of equal parameters of one name, which vary together."""
    leaves = [leaf for leaf in scenario.system.leaves() if _can_be_free(leaf)]
    endings: dict[str, list[Leaf]] = {}
    for leaf in leaves:
        endings.setdefault(leaf.path.rpartition(".")[2], []).append(leaf)
    return [entry for name, group in endings.items() for entry in _list_entries(scenario, name, group)]


def _can_be_free(leaf: Leaf) -> bool:
    return leaf.declared.unit not in units.OF_READINGS and math.isfinite(leaf.value)


def _list_entries(scenario: Scenario, name: str, group: list[Leaf]) -> Iterator[JsonTable]:
    if len({(leaf.value, leaf.declared.unit) for leaf in group}) == 1:
        yield _describe_entry(scenario, name, group)
    else:
        yield from (_describe_entry(scenario, leaf.path, [leaf]) for leaf in group)


def _describe_entry(scenario: Scenario, name: str, group: list[Leaf]) -> JsonTable:
    leaf = group[0]
    path, declared = scenario.places.path(leaf.path), leaf.declared
    spelling = units.choose_familiar_unit(leaf.value, declared.unit)
    low, high = _find_bounds(scenario, name)
    return {
        "name": name,
        "group": path.rpartition(".")[0],
        "places": len(group),
        "value": leaf.value,
        "low": low,
        "high": high,
        "allowed": declared.describe_range(),
        "doc": declared.doc,
        "origin": scenario.origins.get(path, ""),
        **describe_conversion(declared.unit, spelling),
    }


def _find_bounds(scenario: Scenario, name: str) -> tuple[float | None, float | None]:
    try:
        (free,) = build_free_numbers([SearchRange(name)], [scenario.system])
    except ParameterError:
        return None, None
    return free.low, free.high
