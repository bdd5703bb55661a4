"""Runs that the page makes of columns by itself are those that Python tells of the same result."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from page_runs import PageRuns, keep_rows

from martensite.app.documents import FOLDER, list_standalone
from martensite.app.messages import write_message
from martensite.app.views.columns import list_columns
from martensite.app.views.diagrams import describe_energy
from martensite.app.views.formulas import Formulas, explore_choices
from martensite.app.views.page import describe_page
from martensite.app.views.traces import list_alarms, list_loops, list_panels
from martensite.scenario.scenario import Scenario, read_scenario
from martensite.show.figures.hysteresis import find_senses, split_runs
from martensite.show.figures.phase_diagram import find_bands
from martensite.show.summaries.run import tabulate_key_results
from martensite.simulate.result import Result

MARCH = ("The run stopped", "Warning: The trial step", "Warning: The run ends")
"""How sentences begin that a run in the page says itself (`web/src/engine/run.ts`)."""
LIMITED = {
    "element.limits.temperature_limit": "90 degC",
    "element.limits.stress_limit": "80 MPa",
    "element.limits.strain_limit": "2 %",
}
CASES: dict[str, tuple[str, dict[str, Any]]] = {
    "limits": ("constant_power", LIMITED),
    "guard": ("closed_loop_guarded", {}),
    "ports and supply": ("closed_loop_platform", {}),
    "no elements": ("sommerfeld_beam", {"run.duration": "1 s"}),
    "prescribed, driven": ("tensile-test", {"run.duration": "60 s", "run.samples": 101}),
}
"""Short runs in which every kind of view is there."""


def run(name: str, changes: dict[str, Any]) -> tuple[Scenario, Result]:
    scenario = read_scenario(list_standalone()[name], FOLDER / "scenario.toml", changes or None)
    return scenario, keep_rows(scenario.run())


def expect_run(scenario: Scenario, result: Result) -> dict[str, Any]:
    """All but the phase diagram and the scene, of which there are no others in Python (see `test_scene`)."""
    drawn, system = list_columns(result), result.system
    heated = {port: drawn["columns"][system.label(port, "temperature")] for port in system.actuators()}
    runs = {port: split_runs(find_senses(one)) for port, one in heated.items()}
    last = len(drawn["times"]) - 1
    return {
        **drawn,
        "stroke": result.stroke,
        "alarms": list_alarms(result),
        "warnings": [one for one in result.warnings if not one.startswith(MARCH)],
        "traces": list_panels(result),
        "loops": list_loops(result),
        "energy": describe_energy(result),
        "key": tabulate_key_results(result).rows,
        "stretches": {port: own if len(own) <= 32 else [(0, 0, last)] for port, own in runs.items()},
    }


def list_differences(found: Any, wanted: Any, path: str = "") -> list[str]:
    """Where texts differ, or numbers by more than 1e-9."""
    if isinstance(wanted, dict):
        keys = found.keys() | wanted.keys() if isinstance(found, dict) else {"": None}
        return [d for key in keys for d in list_differences(found.get(key), wanted.get(key), f"{path}.{key}")]
    if isinstance(wanted, list | tuple):
        if not isinstance(found, list) or len(found) != len(wanted):
            return [f"{path}: {found!r:.300} for {wanted!r:.300}"]
        pairs = enumerate(zip(found, wanted, strict=True))
        return [d for k, pair in pairs for d in list_differences(*pair, f"{path}.{k}")]
    if isinstance(wanted, float) and isinstance(found, int | float):
        near = math.isclose(found, wanted, rel_tol=1e-9, abs_tol=1e-15)
        return [] if near or math.isnan(wanted) else [f"{path}: {found!r} for {wanted!r}"]
    gone = isinstance(wanted, float) and math.isnan(wanted) and found is None
    return [] if found == wanted or gone else [f"{path}: {found!r:.300} for {wanted!r:.300}"]


def compare(page_runs: PageRuns, ran: dict[str, tuple[Scenario, Result]]) -> dict[str, list[str]]:
    made = page_runs.describe(*((*pair, describe_page(*pair)) for pair in ran.values()))
    differences = dict[str, list[str]]()
    for (name, pair), one in zip(ran.items(), made, strict=True):
        wanted = expect_run(*pair)
        found = list_differences({key: one[key] for key in wanted}, wanted)
        differences |= {name: found[:5]} if found else {}
        check_phase(pair[1], one["phase"])
    return differences


def check_phase(result: Result, found: dict[str, Any]) -> None:
    """Lines are those of the laws, up to the stress that the diagram says."""
    assert list(found["ports"]) == list(result.system.actuators())
    for port, one in result.system.actuators().items():
        diagram = found["diagrams"][found["ports"][port]["diagram"]]
        assert diagram["highest"] >= 1.12 * max(result[found["ports"][port]["y"]])
        lines = [line for band in diagram["bands"] for line in (band["start"], band["finish"])]
        coldest = min((t for line in lines for t in line["temperature"]), default=200.0)
        known = find_bands(one.element.law, diagram["highest"], coldest)
        wanted = [line for band in known for line in (band.start, band.finish)]
        assert [line["name"] for line in lines] == [line.name for line in wanted]
        for line, other in zip(lines, wanted, strict=True):
            assert line["stress"] == pytest.approx(other.stress, rel=1e-9)
            assert line["temperature"][-1] == pytest.approx(other.temperature[-1], rel=1e-9)


def test_runs_of_the_page_are_those_of_python(page_runs: PageRuns) -> None:
    ran = {case: run(*one) for case, one in CASES.items()}
    told = {alarm["kind"] for _, result in ran.values() for alarm in list_alarms(result)}
    assert told >= {"temperature", "stress", "strain", "supply", "supervisor"}
    assert compare(page_runs, ran) == {}


def test_alarms_that_are_rare_are_told_alike(page_runs: PageRuns) -> None:
    """Of columns as they may be: an element without force for a while, another orientation after a cycle."""
    scenario, plain = run("constant_power", {})
    columns = dict(plain.columns)
    columns["force"] = np.where((plain.times > 3.0) & (plain.times < 4.0), 0.0, columns["force"])
    k = np.arange(1001.0)
    columns["martensite_fraction"] = 1.0 - np.sin(math.pi * k / 1000)
    columns["oriented_fraction"] = (0.5 + 4e-4 * k) * columns["martensite_fraction"]
    result = replace(plain, columns=columns, trace=None, notes=[])
    assert {alarm["kind"] for alarm in list_alarms(result)} >= {"slack", "drift"}
    assert compare(page_runs, {"rare": (scenario, result)}) == {}


@pytest.mark.slow
@pytest.mark.parametrize("name", list_standalone())
def test_every_packaged_run_is_the_same(name: str, page_runs: PageRuns) -> None:
    assert compare(page_runs, {name: run(name, {})}) == {}


@pytest.mark.parametrize(
    ("name", "changes"),
    [
        ("constant_power", {"mechanism.preload": "3 N", "drive.waveform.high": "2 W"}),
        ("finger", {"element.diameter": "0.2 mm", "mechanism.offset": "4 mm"}),
        ("antagonistic_wires", {"mechanism.radius": "12 mm", "run.duration": "6 s"}),
    ],
)
def test_the_page_follows_parameters(name: str, changes: dict[str, Any], page_runs: PageRuns) -> None:
    """What was recorded at some numbers holds for others: a slider needs no Python."""
    page, (scenario, result) = describe_page(*run(name, {"run.duration": "1 s"})), run(name, changes)
    moved, fresh = page_runs.describe((scenario, result, page), (scenario, result, describe_page(scenario, result)))
    assert list_differences(moved, fresh) == []
    assert list_differences(moved, {**fresh, "step": fresh["step"] * (1.0 + 1e-8)})


def test_what_no_longer_holds_is_told(page_runs: PageRuns) -> None:
    """A tendon shorter than its way has a tether, which a page for a longer one does not draw."""
    page = describe_page(*run("finger", {"run.duration": "1 s"}))
    scenario, result = run("finger", {"element.length": "20 mm", "run.duration": "1 s"})
    (found,) = page_runs.describe((scenario, result, page))
    assert found["scene"]["shapes"] == []
    assert "other parts" in found["scene"]["sentence"]


def test_choices_are_explored() -> None:
    def build(forced: Any) -> tuple[Formulas, str]:
        table = Formulas(forced)
        x, y = table.leaf("p", "x", 2.0), table.leaf("p", "y", 3.0)
        return table, "large" if x * y > 5.0 else f"{x + 1.0:.3g}"

    (_, here), (table, there) = explore_choices(build)
    assert here == "large"
    told = table.collect(text=there)
    (choice,) = told["choices"]
    assert choice[1] == 0
    assert told["rows"][int(told["text"][1:-5])][0] == "add"
    with pytest.raises(TypeError):
        math.cos(table.leaf("p", "x", 2.0))  # type: ignore[arg-type]


def test_what_is_infinite_is_written_by_name() -> None:
    table = Formulas()
    limit = table.constant(math.inf)
    assert b'"Infinity"' in write_message(table.collect(limit=limit))
