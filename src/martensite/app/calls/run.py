"""Run a scenario: all that the bench draws of it.

{"text": TOML, "changes": {"element.diameter": "0.25 mm"}}
-> {"text": TOML with the changes, "title": …, "times": […], "columns": {…}, …}
"""

from __future__ import annotations

import time
from collections.abc import Mapping
from typing import Any

from martensite.app.documents import scenario_of
from martensite.app.engine import run
from martensite.app.views.columns import columns
from martensite.app.views.energy import energy
from martensite.app.views.key_results import key_results
from martensite.app.views.phase import phase
from martensite.app.views.scene import scene
from martensite.app.views.traces import loops, stretches, traces
from martensite.app.views.warnings import alarms
from martensite.app.worker import Desk
from martensite.scenario.scenario import Scenario
from martensite.simulate.result import Result


def answer(request: Mapping[str, Any], desk: Desk) -> dict[str, Any]:
    """Build the scenario, run it, and describe what came out."""
    scenario = scenario_of(request, desk)
    begun = time.perf_counter()
    result, runtime = run(scenario)
    took = time.perf_counter() - begun
    return {
        "text": scenario.text,
        **_summary(scenario, result),
        "runtime": runtime,
        "seconds": took,
        **columns(result),
        **_drawn(scenario, result),
    }


def _summary(scenario: Scenario, result: Result) -> dict[str, Any]:
    return {
        "title": scenario.title,
        "described": scenario.system.described(),
        "status": result.status.name,
        "accuracy": result.accuracy,
        "steps": result.steps,
        "step": result.step,
        "stroke": result.stroke,
        "coordinate": result.coordinate,
        "ports": list(result.system.actuators()),
        "cautions": scenario.cautions,
        "warnings": list(result.warnings),
        "alarms": alarms(result),
    }


def _drawn(scenario: Scenario, result: Result) -> dict[str, Any]:
    """What the charts need beside the columns."""
    energies = energy(result)
    return {
        "traces": traces(result, scenario.outside),
        "loops": loops(result),
        "stretches": stretches(result),
        "phase": phase(result),
        "energy": energies,
        "key": key_results(result, energies),
        "scene": scene(scenario, result),
    }
