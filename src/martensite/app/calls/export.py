"""Make a file of a scenario: a figure, or its numbers.

{"text": TOML, "changes": {…}, "what": "png"} -> {"key": of the file, "name": what it is called}

The run is the one that `martensite run` makes, with all its samples.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from martensite.app.documents import scenario_of
from martensite.app.drawer import Drawer
from martensite.app.messages import BadMessageError, wanted
from martensite.app.worker import Desk
from martensite.base.errors import suggest_name
from martensite.scenario.scenario import Scenario
from martensite.simulate.result import Result


def answer(request: Mapping[str, Any], desk: Desk) -> dict[str, Any]:
    """Run the scenario and write the file."""
    what = wanted(request, "what", str)
    if what not in WRITERS:
        raise BadMessageError(f"`what` is `{what}`. {suggest_name(what, WRITERS)}")
    scenario = scenario_of(request, desk)
    result = scenario.run()
    key, path = Drawer(desk.folder).place(f"{scenario.title[:60]}.{what}")
    WRITERS[what](scenario, result, path)
    return {"key": key, "name": path.name}


def _figure(scenario: Scenario, result: Result, path: Path) -> None:
    from martensite.show.figures.overview import save_figure

    records = [scenario.measured.read()] if scenario.measured else None
    save_figure(result, path, records, scenario.title, scenario.outside)


def _csv(scenario: Scenario, result: Result, path: Path) -> None:
    from martensite.scenario.csv_files import write_csv

    write_csv(result, path)


def _netcdf(scenario: Scenario, result: Result, path: Path) -> None:
    from martensite.scenario.citations import list_citations
    from martensite.scenario.netcdf import save_result

    cited = list_citations(scenario, scenario.material)
    save_result(result, path, scenario.text, cited, scenario.material)


WRITERS: dict[str, Callable[[Scenario, Result, Path], None]] = {
    "png": _figure,
    "svg": _figure,
    "csv": _csv,
    "nc": _netcdf,
}
"""By the suffix of the file."""
