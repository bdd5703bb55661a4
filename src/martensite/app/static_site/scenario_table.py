"""Data of a scenario for the page, as in `Scenario` of web/src/engine/types.ts."""

from __future__ import annotations

import base64
import math
from collections.abc import Sequence
from typing import Any

from martensite.actuators.assembly.ledger import ACCOUNTS
from martensite.app.messages import JsonTable
from martensite.app.static_site.control_map import InputMap
from martensite.app.static_site.flat_inputs import SEGMENT, TONE
from martensite.app.static_site.input_map import list_numbers
from martensite.app.static_site.rounding import describe_rounding
from martensite.app.static_site.run_module import RunSource, describe_layout
from martensite.app.views.page import describe_page
from martensite.base import units
from martensite.base.formats import typeset_unit
from martensite.base.status import Status
from martensite.scenario.scenario import Scenario
from martensite.simulate.compiled import CompiledMarch, compile_march
from martensite.simulate.envelope import BEYOND, WORDS, Envelope
from martensite.simulate.result import Result

SCALARS = ("duration", "tolerance", "samples", "step", "mechanism", "inertial", "interval")


def describe_static(
    name: str,
    text: str,
    input_map: InputMap,
    source: RunSource,
    module: str,
    *,
    magnified: float = 0.0,
    result: Result | None = None,
) -> JsonTable:
    """Return all data to run and draw a scenario on the page.

    Args:
        name: name of the scenario.
        text: its document.
        input_map: map of its controls.
        source: C of its runs.
        module: file name of its module.
        magnified: effect of rounding (`measure_rounding`).
        result: a run of the scenario, of any duration; by default a new run.
    """
    scenario = input_map.scenario
    compiled = compile_march(scenario.whole)
    order = order_entries(input_map, compiled)
    entries = {entry: k for k, entry in enumerate(order)}
    return {
        "name": name,
        "text": text,
        "module": module,
        "layout": describe_layout(compiled, source),
        "form": input_map.form,
        "units": _list_units(input_map),
        "inputs": [_write_number(input_map.numbers[entry]) for entry in order],
        "places": _list_places(input_map, compiled, entries),
        "readings": [base64.b64encode(one.tobytes()).decode() for one in input_map.samples],
        **_describe_map(input_map, entries),
        **_describe_outputs(scenario, compiled, magnified),
        **describe_page(scenario, result or scenario.run(runtime=None if scenario.whole.sample_time() else "floats")),
    }


def order_entries(input_map: InputMap, compiled: CompiledMarch) -> list[str]:
    """Return the names of the inputs, parameters first."""
    bounds = range(len(compiled.envelope))
    ordered = [f"p:{path}" for path in compiled.paths]
    ordered += [*SCALARS, *(f"low:{k}" for k in bounds), *(f"high:{k}" for k in bounds)]
    for number, shape in enumerate(input_map.drives):
        ordered += [f"drive:{number}.{name}:{k}" for name in SEGMENT for k in range(shape.segments)]
        ordered += [f"drive:{number}.{name}:{k}" for name in TONE for k in range(shape.tones)]
    return ordered


def _write_number(value: float) -> float | str:
    return value if math.isfinite(value) else "Infinity" if value > 0.0 else "-Infinity"


def _list_places(input_map: InputMap, compiled: CompiledMarch, entries: dict[str, int]) -> JsonTable:
    drives, readings = list[JsonTable](), 0
    system = input_map.scenario.whole
    heated = {system.drive_at(port): port for port in system.actuators()}
    for number, (shape, drive) in enumerate(zip(input_map.drives, system.drives(), strict=True)):
        at = entries.get(f"drive:{number}.start:0", 0)
        own: JsonTable = {"segments": shape.segments, "tones": shape.tones, "at": at, "readings": readings}
        table = {"name": drive.name, "how": _describe_unit(drive.name, drive.unit), "port": heated.get(drive.name, "")}
        drives.append({**own, "ahead": bool(drive.ahead), **table})
        readings += not shape.segments
    first = len(compiled.paths) + len(SCALARS)
    return {
        **{name: entries[name] for name in SCALARS},
        "low": first,
        "high": first + len(compiled.envelope),
        "drives": drives,
        "dependent": _list_dependent(input_map, entries),
    }


def _describe_unit(name: str, unit: str) -> JsonTable:
    """Return the display of a signal: displayed number = SI · factor + offset."""
    display_unit = units.of_column(name, unit)
    offset = units.from_si(0.0, display_unit, unit)
    return {
        "unit": unit,
        "display_unit": display_unit,
        "factor": units.from_si(1.0, display_unit, unit) - offset,
        "offset": offset,
    }


def _list_dependent(input_map: InputMap, entries: dict[str, int]) -> list[tuple[int, str]]:
    """Return the parameters with a control that depend on the control of another path."""
    places, own = input_map.scenario.places, {node["path"]: node["value"] for node in list_numbers(input_map.form)}
    moved = {name: control.path for control in input_map.controls for name in control.terms if name.startswith("p:")}
    moves = ((name, places.path(name.removeprefix("p:")), by) for name, by in moved.items())
    return [
        (entries[name], path) for name, path, by in moves if path != by and own.get(path) == input_map.numbers[name]
    ]


def _describe_map(input_map: InputMap, entries: dict[str, int]) -> JsonTable:
    controls = [
        {
            "path": one.path,
            "value": one.value,
            "low": one.low,
            "high": one.high,
            "terms": [[entries[name], *term] for name, term in one.terms.items()],
            "said": list(one.cautions),
        }
        for one in input_map.controls
    ]
    return {
        "controls": controls,
        "products": [[entries[name], a, b, c] for (name, a, b), c in input_map.products.items()],
        "inverted": [entries[name] for name in sorted(input_map.inverted)],
        "apart": [list(pair) for pair in sorted(input_map.apart)],
        "rows": {row.path: row.describe() for row in input_map.rows},
        "ordered": [list(pair) for pair in sorted(input_map.ordered)],
        "elsewhere": list(input_map.left_out),
    }


def _list_units(input_map: InputMap) -> dict[str, dict[str, tuple[float, float]]]:
    """Return the spellings by SI unit, with size and zero: SI = number · size + zero."""
    factors: dict[str, dict[str, tuple[float, float]]] = {}
    for node in (*list_numbers(input_map.form), *(row.items[0] for row in input_map.rows)):
        unit = node["unit"] or "1"
        if unit not in factors:
            everyday = ((spelling, how) for spelling, (declared, *how) in units.EVERYDAY.items() if declared == unit)
            factors[unit] = {spelling: (factor, zero) for spelling, (factor, zero) in everyday}
        for spelling in (node["display_unit"], unit):
            if spelling and spelling not in factors[unit]:
                factors[unit][spelling] = units.find_conversion(spelling, unit)
    return factors


def _describe_outputs(scenario: Scenario, compiled: CompiledMarch, magnified: float) -> JsonTable:
    judged = [(compiled.outputs.index(name), least) for name, least in compiled.convergence_scales]
    book = compiled.book
    return {
        "parameters": list(compiled.paths),
        "names": list(compiled.outputs),
        "columns": len(scenario.whole.outputs()),
        "judged": judged,
        "envelope": _list_bounds(scenario, compiled),
        "accounts": list(ACCOUNTS),
        "balances": {"heat": book.has_heat_balance, "work": book.has_work_balance},
        "statuses": {str(int(one)): one.sentence for one in Status},
        "magnified": magnified,
        "differs": [describe_rounding(magnified)] if magnified else [],
    }


def _list_bounds(scenario: Scenario, compiled: CompiledMarch) -> Sequence[Any]:
    system = scenario.whole
    places, several = Envelope(system).places, len(system.actuators()) > 1
    bounds: list[JsonTable] = []
    for place, (port, name) in zip(places, compiled.envelope, strict=True):
        unit = system.outputs()[system.label(port, name)].unit
        how = _describe_unit(name, unit)
        del how["unit"]
        how["display_unit"] = typeset_unit(how["display_unit"])
        bounds.append(
            {
                "output": place,
                "words": f"{WORDS[name]} of `{port}`" if several else WORDS[name],
                **how,
                "reason": BEYOND[name],
                "port": port,
                "name": name,
            }
        )
    return bounds
