"""Data for the drawing of a run on the page, except for its numbers.

Quantities that depend on the sliders (limits, lengths, positions of shapes, lines of the phase diagram) are formulas
(`martensite.app.views.formulas`). `web/src/views` makes the `Run` of the page.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from martensite.actuators.assembly import AbstractSystem, Actuator, Machine
from martensite.actuators.mechanisms.beam_motor import BeamMotor
from martensite.actuators.mechanisms.load_line import AbstractLoadLine
from martensite.app.messages import JsonTable
from martensite.app.views.columns import describe_column
from martensite.app.views.diagrams import describe_lines
from martensite.app.views.formulas import (
    Formulas,
    explore_choices,
    locate_part,
    rebuild_recorded,
    record_part,
    write_number,
)
from martensite.app.views.scene import describe_shapes
from martensite.app.views.traces import list_loops, list_panels
from martensite.base import units
from martensite.base.formats import choose_difference_unit, typeset_unit
from martensite.control.checks.base import LIMITED
from martensite.control.loop.bench import Bench
from martensite.control.loop.names import ALARM
from martensite.kernels import floats
from martensite.physics.kinetics.return_points import DEPTH
from martensite.physics.laws.base import AbstractLaw, Fractions
from martensite.scenario.scenario import Scenario
from martensite.show.summaries.run import PEAKS
from martensite.simulate.energy import find_length
from martensite.simulate.result import Result


def describe_page(scenario: Scenario, result: Result | None = None) -> JsonTable:
    """Return all data of a run's drawing, except for its numbers.

    Args:
        scenario: the scenario.
        result: a run of it, for the choices of formulas; by default a new run.
    """
    result = result or scenario.run(runtime="floats")
    return {
        "title": scenario.title,
        "described": scenario.system.description(),
        "outputs": {name: describe_column(result, name) for name in result.columns},
        "coordinate": result.coordinate,
        "ports": list(result.system.actuators()),
        "traces": list_panels(result, repeated=True),
        "loops": list_loops(result),
        "cautions": scenario.cautions,
        "views": {
            "elements": _describe_elements(scenario, result),
            "laws": [_describe_law(port, one) for port, one in result.system.actuators().items()],
            "doubts": {port: _list_doubts(scenario, result, port) for port in result.system.actuators()},
            "guard": _describe_guard(result),
            "key": _describe_key(result),
            "held": result.system.sample_time() > 0.0,
            **describe_formulas(scenario, result),
        },
    }


def describe_formulas(scenario: Scenario, result: Result) -> JsonTable:
    """Return the formulas that the page evaluates for each run: lines of the laws, shapes, and resonance of a motor."""
    return {
        "lines": describe_lines(scenario.whole, result),
        "scene": describe_shapes(scenario.whole, result),
        "motor": _describe_motor(scenario),
    }


def list_parameters(scenario: Scenario, views: JsonTable) -> dict[str, float | str]:
    """Return the parameters of formulas, by path."""
    paths = {row[1] for one in views.values() for row in one["rows"] if row[0] == "p"}
    return {leaf.path: write_number(leaf.value) for leaf in scenario.whole.leaves() if leaf.path in paths}


def _describe_motor(scenario: Scenario) -> JsonTable:
    table = Formulas()
    mechanism = rebuild_recorded(scenario.whole, table).mechanism
    return table.collect(resonance=mechanism.resonance() if isinstance(mechanism, BeamMotor) else None)


def _describe_elements(scenario: Scenario, result: Result) -> JsonTable:
    table = Formulas()
    system = rebuild_recorded(scenario.whole, table)
    ports = {port: _describe_port(table, system, port, one, result) for port, one in system.actuators().items()}
    supply = system.supply.current_limit if isinstance(system, Machine) and system.supply is not None else None
    alone = len(ports) == 1 and not system.signals()
    ranges = table.collect(ports=ports, supply=supply)
    return ranges | {"alone": alone, "prefixed": system.label("x", "stress") != "stress"}


def _describe_port(table: Formulas, system: AbstractSystem, port: str, one: Actuator, result: Result) -> JsonTable:
    limits, column = one.element.limits, system.label(port, "resistance")
    ohms: Any = table.leaf("y", column, result.columns[column][0])
    on_line, length = isinstance(system.mechanism, AbstractLoadLine), find_length(one.element)
    return {
        "temperature": limits.temperature_limit,
        "stress": limits.stress_limit,
        "strain": limits.strain_limit,
        "reach": list(one.source.reach(ohms)),
        "source": one.source.registered_name,
        "unit": one.source.unit,
        "prescribed": "yes" if one.source.sets_temperature else None,
        "way": result.coordinate if on_line else None,
        "length": None if on_line else length,
    }


def _describe_law(port: str, one: Actuator) -> JsonTable:
    law = one.element.law
    if not isinstance(law, AbstractLaw):
        return {"port": port, "name": "", "tension": False, "symmetric": False, "loops": 0}
    memory = law.init(floats, Fractions(0.5, 0.5), 0.0, 300.0)
    return {
        "port": port,
        "name": law.registered_name,
        "tension": law.tension_only,
        "symmetric": "compression" in law.declarations,
        "loops": 0 if law.find_forgotten_change(memory) is None else DEPTH,
    }


def _list_doubts(scenario: Scenario, result: Result, port: str) -> list[JsonTable]:
    """Return the stress limit of the law's validity and its sentence, for all outcomes of choices."""
    element_law = result.system.actuators()[port].element.law
    path = locate_part(scenario.whole, element_law)
    if not isinstance(element_law, AbstractLaw):
        return []

    def build(forced: Sequence[bool]) -> tuple[Formulas, Any]:
        table = Formulas(forced)
        law: AbstractLaw = (
            rebuild_recorded(scenario.whole, table).actuators()[port].element.law
            if path is None
            else record_part(element_law, path, table)
        )
        try:
            return table, law.doubt()
        except TypeError:  # found on floats, valid for these values
            for own, leaf in zip(law.leaves(), element_law.leaves(), strict=True):
                table.choose(table.constant(own.value == leaf.value))
            return table, element_law.doubt()

    return [
        table.collect(stress=doubt and doubt.stress, sentence=doubt and doubt.sentence)
        for table, doubt in explore_choices(build)
    ]


def _describe_guard(result: Result) -> JsonTable | None:
    bench = result.system
    if not isinstance(bench, Bench) or bench.supervisor is None:
        return None
    checks = {str(number): names for number, names in bench.supervisor.name_checks().items()}
    return {"column": ALARM, "checks": checks, "limited": LIMITED, "period": bench.period}


def _describe_key(result: Result) -> JsonTable:
    judged = {result.coordinate, *result.system.mechanism.convergence_scales()}
    strokes: list[JsonTable] = []
    for name, output in result.system.mechanism.outputs().items():
        if name in judged:
            words = "stroke ({})" if name == result.coordinate else "range of {}"
            display_unit, size = choose_difference_unit(output.unit, name)
            how = {"column": name, "size": size, "unit": "" if display_unit == "1" else display_unit}
            strokes.append({"words": words.format(output.long_name), **how})
    ports = list(result.system.actuators())
    peaks = [_describe_peak(result, ports, *one) for one in PEAKS] if ports else []
    return {"strokes": strokes, "peaks": peaks}


def _describe_peak(result: Result, ports: Sequence[str], name: str, words: str, choose: Any) -> JsonTable:
    columns = [result.system.label(port, name) for port in ports]
    unit = result.unit(columns[0])
    display_unit = units.choose_readable_unit(unit)
    size, zero = units.find_conversion(display_unit, unit)
    spelled = "" if display_unit == "1" else typeset_unit(display_unit)
    return {"words": words, "columns": columns, "least": choose is min, "size": size, "zero": zero, "unit": spelled}
