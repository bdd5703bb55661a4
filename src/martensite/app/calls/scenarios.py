"""Calls about scenarios: list, compare, run and export them."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import cast

from martensite.app.documents import LONGEST_TEXT, describe_scenarios, list_standalone, read_request_scenario
from martensite.app.engine import run_fast
from martensite.app.messages import BadMessageError, JsonTable, Request, require_choice, require_entry
from martensite.app.views.columns import list_columns
from martensite.app.views.diagrams import describe_energy
from martensite.app.views.page import describe_formulas, list_parameters
from martensite.app.views.traces import list_alarms, list_loops, list_panels
from martensite.app.worker import Desk
from martensite.base.files import toml_document
from martensite.base.toml_text import toml_value
from martensite.scenario.scenario import Scenario
from martensite.show.summaries.run import tabulate_key_results
from martensite.simulate.result import Result


def list_scenarios(request: Request, desk: Desk) -> JsonTable:
    """Return the packaged scenarios: `{}` -> `{"scenarios": [{name, title, text}]}`."""
    return describe_scenarios(list_standalone())


MOST_DOCUMENTS = 12
"""Largest number of compared documents."""


def compare_documents(request: Request, desk: Desk) -> JsonTable:
    """Return the differences between documents.

    {"texts": [TOML, TOML, …]}
    -> {"rows": [{"path": "element.diameter", "values": ["0.2 mm", null]}]}
    """
    texts = require_entry(request, "texts", list)
    if len(texts) > MOST_DOCUMENTS or not all(isinstance(t, str) and len(t) <= LONGEST_TEXT for t in texts):
        raise BadMessageError(f"`texts` must be at most {MOST_DOCUMENTS} documents, each a text.")
    documents = [dict(_flatten_document(toml_document(text, "A document"))) for text in texts]
    paths = dict.fromkeys(path for document in documents for path in document)
    rows = [{"path": path, "values": [d.get(path) for d in documents]} for path in paths]
    return {"rows": [row for row in rows if any(v != row["values"][0] for v in row["values"])]}


def _flatten_document(table: Request, above: str = "") -> Iterator[tuple[str, str]]:
    """Yield dotted path and written value of each entry."""
    for key, value in table.items():
        path = f"{above}{key}"
        if isinstance(value, dict):
            yield from _flatten_document(cast("JsonTable", value), f"{path}.")
        else:
            yield path, value if isinstance(value, str) else toml_value(value)


def run_scenario(request: Request, desk: Desk) -> JsonTable:
    """Run a scenario, and return its drawing.

    {"text": TOML, "changes": {"element.diameter": "0.25 mm"}}
    -> {"text": TOML with the changes, "title": …, "times": […], "columns": {…}, …}

    Notes: {"doing": words, "done": finished fraction, or null if it is not known}.
    """
    scenario = read_request_scenario(request, desk)
    start = time.perf_counter()
    result, runtime = run_fast(scenario, desk.tell)
    took = time.perf_counter() - start
    return {
        "text": scenario.text,
        **_summarise_run(scenario, result),
        "runtime": runtime,
        "seconds": took,
        **list_columns(result),
        **_draw_run(scenario, result),
    }


def _summarise_run(scenario: Scenario, result: Result) -> JsonTable:
    return {
        "title": scenario.title,
        "described": scenario.system.description(),
        "status": result.status.name,
        "accuracy": result.accuracy,
        "samples": len(result.times),
        "steps": result.steps,
        "step": result.step,
        "stroke": result.stroke,
        "coordinate": result.coordinate,
        "ports": list(result.system.actuators()),
        "cautions": scenario.cautions,
        "warnings": list(result.warnings),
        "alarms": list_alarms(result),
    }


def _draw_run(scenario: Scenario, result: Result) -> JsonTable:
    """Return the drawing of a run; `web/src/views/answer.ts` adds the evaluation of `views`."""
    views = describe_formulas(scenario, result)
    return {
        "traces": list_panels(result),
        "loops": list_loops(result),
        "energy": describe_energy(result),
        "key": tabulate_key_results(result).rows,
        "parameters": list_parameters(scenario, views),
        "views": views,
    }


def export_scenario(request: Request, desk: Desk) -> JsonTable:
    """Write a file of a run: a figure or its columns.

    {"text": TOML, "changes": {…}, "what": "png"} -> {"key": of the file, "name": of the file}

    The run is that of `martensite run`, with all samples.
    """
    what = require_choice(request, "what", "file", WRITERS)
    scenario = read_request_scenario(request, desk)
    result = scenario.run()
    key, path = desk.files.place(f"{scenario.title[:60]}.{what}")
    WRITERS[what](scenario, result, path)
    return {"key": key, "name": path.name}


def _write_figure(scenario: Scenario, result: Result, path: Path) -> None:
    from martensite.show.figures.overview import save_figure

    records = [scenario.measured.read()] if scenario.measured else None
    save_figure(result, path, records, scenario.title)


def _write_table(scenario: Scenario, result: Result, path: Path) -> None:
    from martensite.scenario.csv_files import write_csv

    write_csv(result, path)


def _write_netcdf(scenario: Scenario, result: Result, path: Path) -> None:
    from martensite.scenario.citations import list_citations
    from martensite.scenario.netcdf import save_result

    cited = list_citations(scenario, scenario.material)
    save_result(result, path, scenario.text, cited, scenario.material)


WRITERS: dict[str, Callable[[Scenario, Result, Path], None]] = {
    "png": _write_figure,
    "svg": _write_figure,
    "csv": _write_table,
    "nc": _write_netcdf,
}
"""Writer by file suffix."""
