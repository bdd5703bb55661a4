"""Runs as the page makes them of columns: the TypeScript of `web/src/views` in Node.js."""

from __future__ import annotations

import json
import subprocess
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from node_js import WEB, node

from martensite.actuators.assembly.lengths import measure_lengths
from martensite.actuators.mechanisms.drawing import DrawingShape, DrawingState
from martensite.app.messages import write_message
from martensite.app.views.formulas import write_number
from martensite.scenario.scenario import Scenario
from martensite.simulate.result import Result
from martensite.simulate.tracing import AbstractTrace
from martensite.simulate.track import StepRows, Track


class PageRuns:
    """Makes runs; the script is bundled once."""

    def __init__(self, folder: Path) -> None:
        self.folder, self.node = folder, node()
        bundle = ["node_modules/.bin/esbuild", "test/describe_run.ts", "--bundle", "--platform=node", "--format=esm"]
        subprocess.run(
            [*bundle, f"--outfile={folder / 'describe_run.mjs'}", "--log-level=warning"], cwd=WEB, check=True
        )

    def describe(self, *asked: tuple[Scenario, Result, dict[str, Any]]) -> list[dict[str, Any]]:
        """What the page draws of runs, from what Python says of the scenario; the page of another one of its kind does.

        The columns are those of the result, as the march in the page gives them.
        """
        cores = [{"core": _strip_run(scenario, result), "page": page} for scenario, result, page in asked]
        (self.folder / "asked.json").write_bytes(write_message({"asked": cores}))
        command = [self.node, str(self.folder / "describe_run.mjs"), str(self.folder / "asked.json")]
        done = subprocess.run(command, capture_output=True, text=True, check=True)
        return json.loads(done.stdout)


def _strip_run(scenario: Scenario, result: Result) -> dict[str, Any]:
    """A `RunCore` of web/src/engine/types.ts."""
    return {
        "text": scenario.text,
        "times": result.times,
        "columns": result.columns,
        "track": None if result.track is None else _tabulate_track(result, result.track),
        "status": result.status.name,
        "accuracy": result.accuracy,
        "steps": result.steps,
        "step": result.step,
        "parameters": {leaf.path: write_number(leaf.value) for leaf in scenario.whole.leaves()},
        "seconds": 0.0,
        "warnings": [],
        "cautions": scenario.cautions,
    }


def _tabulate_track(result: Result, track: Track) -> dict[str, Any]:
    times, columns = result.list_rows()
    return {"times": times, "columns": columns, "weights": track.weights}


@dataclass(frozen=True)
class KeptTrace(AbstractTrace):
    """A track that is known."""

    track: Track

    def compute_track(self) -> Track:
        return self.track


def keep_rows(result: Result) -> Result:
    """Return a run judged at the rows of its track alone, as the page judges it, without curves between them."""
    track = result.track
    if track is None:
        return result
    none = StepRows(track.steps.rows[:0], track.steps.joined[:0], track.steps.plain[:0])
    rows = replace(track, steps=none)
    fresh = replace(result, trace=KeptTrace(rows), notes=[])
    guard = [one for one in result.warnings if one.startswith("Warning: The guard")]
    return replace(fresh, notes=guard)


def draw_row(system: Any, result: Result, row: int) -> list[DrawingShape]:
    """The mechanism at one row of a result, on floats."""
    mechanism = system.mechanism
    outputs = {name: float(result.columns[name][row]) for name in mechanism.outputs()}
    return mechanism.draw_shapes(DrawingState(outputs, measure_lengths(system, result.columns)))
