"""The form of a sweep, and its export files."""

from __future__ import annotations

import csv
import math
import zipfile
from collections.abc import Iterator
from pathlib import Path

from martensite.app.documents import read_request_scenario
from martensite.app.messages import JsonTable, Request, require_choice
from martensite.app.sweeping.sweep_folder import find_store
from martensite.app.worker import Desk
from martensite.base import units
from martensite.base.errors import MartensiteError
from martensite.base.files import replace_file
from martensite.base.parameters import FieldDeclaration
from martensite.base.status import Status
from martensite.design.sweep.backends.processes import count_cores
from martensite.design.sweep.job import MEASURES as USUAL
from martensite.design.sweep.reading import read_sweep
from martensite.design.sweep.sampling.samples import DESIGNS
from martensite.design.sweep.subject import list_waveforms
from martensite.design.sweep.table import NOT_MADE
from martensite.logs.record_text import format_heading
from martensite.scenario.catalogue import summarise_class
from martensite.scenario.exact_text import exact_text
from martensite.scenario.scenario import Scenario
from martensite.scenario.targets import list_targets
from martensite.search.free_numbers import Target
from martensite.simulate.measures.base import MEASURES, AbstractMeasure, parse_measure
from martensite.simulate.variants import RUNTIMES


def describe_sweep_form(request: Request, desk: Desk) -> JsonTable:
    """Return the options of a sweep of a scenario: parameters, samples, and measures.

    {"text": TOML} -> {"title", "targets": […], "designs": […], "measures": […], "outputs": […], …}
    """
    scenario = read_request_scenario(request, desk)
    return {
        "title": scenario.title,
        "text": scenario.text,
        "targets": list(_list_targets(scenario)),
        "designs": [{"name": n, "about": summarise_class(DESIGNS[n])} for n in _sort_grid_first(DESIGNS.names())],
        "measures": [_describe_measure(name, scenario) for name in MEASURES.names()],
        "outputs": [
            {"name": name, "about": one.long_name, "unit": units.choose_readable_unit(one.unit)}
            for name, one in scenario.whole.outputs().items()
        ],
        "usual": list(USUAL),
        "runtimes": list(RUNTIMES),
        "cores": count_cores(),
    }


def _sort_grid_first(names: list[str]) -> list[str]:
    return sorted(names, key=lambda name: (name != "grid", name))


def _list_targets(scenario: Scenario) -> Iterator[JsonTable]:
    leaves: dict[str | None, dict[str, FieldDeclaration]] = {
        None: {one.path: one.declared for one in scenario.whole.leaves()}
    }
    for name, wave in list_waveforms(scenario).items():
        leaves[name] = {one.path: one.declared for one in wave.leaves()}
    for target in list_targets(scenario).values():
        yield _describe_target(target, leaves[target.drive][target.path])


def _describe_target(one: Target, declared: FieldDeclaration) -> JsonTable:
    display_unit = units.choose_familiar_unit(one.value, one.unit)
    same = declared.unit == one.unit
    low, high = (declared.low, declared.high) if same else (-math.inf, math.inf)
    return {
        "name": one.name,
        "about": one.doc,
        "unit": "" if display_unit == "1" else display_unit,
        "value": units.from_si(one.value, display_unit, one.unit),
        "words": exact_text(one.value, one.unit),
        "low": units.from_si(low, display_unit, one.unit),
        "high": units.from_si(high, display_unit, one.unit),
        "open": declared.open_low,
    }


def _describe_measure(name: str, scenario: Scenario) -> JsonTable:
    kind = MEASURES[name]
    alone = True
    try:
        parse_measure(name).columns(scenario.whole)
    except MartensiteError:
        alone = False
    return {"name": name, "about": summarise_class(kind), "alone": alone, "usual": _find_usual(name, kind)}


def _find_usual(name: str, kind: type[AbstractMeasure]) -> str:
    return str(kind.declarations["of"].default or "the first coordinate")


def export_sweep(request: Request, desk: Desk) -> JsonTable:
    """Write an export file of a sweep.

    {"key": …, "kind": "csv" or "zarr"} -> {"file": key of the file, "name": …, "bytes": …}
    """
    store = find_store(request, desk.folder)
    ending, write = KINDS[require_choice(request, "kind", "export", KINDS)]
    key, path = desk.files.place(f"{store.stem}{ending}")
    write(store, path)
    return {"file": key, "name": path.name, "bytes": path.stat().st_size}


def write_csv(store: Path, path: Path) -> None:
    """Write one row per finished run, values in SI, units in the headings; values of failed runs are empty."""
    table = read_sweep(store)
    columns = {**table.varied, **table.measures}
    with replace_file(path) as part, part.open("w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(["run", "status", *(format_heading(name, one.unit) for name, one in columns.items())])
        values = [one.values.tolist() for one in columns.values()]
        for row, status in enumerate(table.status.tolist()):
            if status != NOT_MADE:
                word = Status(status).name.lower()
                writer.writerow([row, word, *(_write_number(column[row]) for column in values)])


def _write_number(value: float) -> str:
    return "" if math.isnan(value) else repr(value)


def write_zip(store: Path, path: Path) -> None:
    """Write the store, whose chunks are already compressed, in a folder of an archive."""
    with replace_file(path) as part, zipfile.ZipFile(part, "w", zipfile.ZIP_STORED) as archive:
        for one in sorted(store.rglob("*")):
            if one.is_file():
                archive.write(one, f"{store.name}/{one.relative_to(store).as_posix()}")


KINDS = {"csv": (".csv", write_csv), "zarr": (".zarr.zip", write_zip)}
