"""From a wire behind a board to a fitted scenario: excitation profiles, logs, and a fit.

The model of the fit is the scenario without its loop, driven by the duty cycle of the log. It is written next to the
logs, so that `martensite fit` repeats the fit.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from martensite.base.errors import InputError
from martensite.base.files import write_file
from martensite.base.formats import write_quantity
from martensite.base.summary import Block, DataTable, Sentence
from martensite.boards.characterise.experiments import DutyCourse, list_courses, measure_pace
from martensite.boards.characterise.information import OTHERS, ChosenCourses, UnknownNumber, choose_courses
from martensite.boards.rig_scenarios import write_rig_scenario
from martensite.control.loop.bench import Bench
from martensite.control.loop.plant_leaves import find_plant_leaf

if TYPE_CHECKING:
    from martensite.fit.fit import Fit

WIDTHS = {"K": 5.0, "1": 0.1}
"""Assumed uncertainty of a parameter before the tests, by its unit: kelvin, or a fraction."""
RELATIVE_WIDTH = 0.2
"""Assumed uncertainty for all other units, as a fraction."""
RIG = "rig.toml"
"""Scenario of the fit."""
MARGIN = 5.0
"""Distance from the temperature limit of the element [K]."""


def list_unknown(bench: Bench, names: Sequence[str], widths: Mapping[str, float]) -> list[UnknownNumber]:
    """Return the unknown parameters, by paths in the plant or unique endings.

    Args:
        bench: bench with the plant.
        names: names of the parameters.
        widths: uncertainties [SI] by name; default: by unit.

    Raises:
        ParameterError: the parameter does not exist.
    """
    parameters: list[UnknownNumber] = []
    for name in names:
        leaf = find_plant_leaf(bench, name)
        usual = WIDTHS["K"] if leaf.declared.unit == "K" else RELATIVE_WIDTH * abs(float(leaf.value)) or WIDTHS["1"]
        parameters.append(UnknownNumber(leaf.path, leaf.declared.unit, float(leaf.value), widths.get(name, usual)))
    return parameters


def plan_courses(bench: Bench, unknown: Sequence[UnknownNumber], budget: float) -> ChosenCourses:
    """Return the safe excitation profiles with the most information within a time [s].

    Raises:
        InputError: the plant has several wires, or the element no temperature limit.
        SolveError: no duty cycle transforms the wire to austenite.
    """
    actuators = list(bench.plant.actuators().values())
    if len(actuators) != 1:
        raise InputError(f"One wire is characterised at a time, but this scenario has {len(actuators)}.")
    limit = float(actuators[0].element.limits.temperature_limit)
    if limit == float("inf"):
        raise InputError("The element has no `temperature_limit`: write one in [element.limits] first.")
    candidates = list(list_courses(measure_pace(bench.plant)))
    return choose_courses(bench, unknown, candidates, limit=limit - MARGIN, budget=budget)


def fit_courses(text: str, folder: Path, logs: Sequence[Path], unknown: Sequence[UnknownNumber]) -> Fit:
    """Fit the parameters to the logs, and write the scenario of the fit, `rig.toml`, into the folder."""
    from martensite.fit.api import fit_logs

    scenario = folder / RIG
    write_file(scenario, write_rig_scenario(text))
    return fit_logs(scenario, list(logs), [one.path for one in unknown])


def write_fit(fit: Fit, folder: Path) -> list[Path]:
    """Write material and report next to the scenario of a fit, and return all files."""
    from martensite.fit.material_files import write_material
    from martensite.show.pages import write_report

    material = folder / "wire.toml"
    write_material(fit, material, title="Wire behind a board")
    return [folder / RIG, material, *write_report(fit, folder / "report.html")]


def describe_plan(unknown: Sequence[UnknownNumber], chosen: ChosenCourses) -> list[Block]:
    """Describe the profiles and their expected information."""
    courses = [[one.name, f"{one.duration:.3g} s", f"{max(d for _, d in one.levels):.3f}"] for one in chosen.courses]
    rows = [
        [one.path, write_quantity(one.value, one.unit), f"{one.width:.3g}", f"{one.width * left:.2g}", one.unit]
        for one, left in zip(unknown, chosen.remaining_uncertainty, strict=True)
    ]
    hottest = write_quantity(chosen.hottest, "K")
    return [
        DataTable(("course", "time", "largest duty"), courses, right=(1, 2)),
        Sentence(f"The hottest of {OTHERS} wires that may be at hand reaches {hottest}, on the model."),
        DataTable(("number", "in the scenario", "unknown by", "then by", "SI"), rows, right=(1, 2, 3)),
    ]


def describe_fit(fit: Fit) -> list[Block]:
    """Describe the results of a fit."""
    from martensite.show.summaries.fit import summarise_fit

    return list(summarise_fit(fit).blocks)


def name_logs(folder: Path, courses: Sequence[DutyCourse]) -> list[Path]:
    """Return a log file for every profile."""
    return [folder / f"{k + 1:02d}_{one.name.replace(' ', '_')}.csv" for k, one in enumerate(courses)]
