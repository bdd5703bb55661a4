"""Machines: several actuators on one mechanism, in files, results, figures and loops."""

from __future__ import annotations

import math
from collections.abc import Mapping
from functools import cache
from pathlib import Path
from typing import Any

import builders
import numpy as np
import pytest

from martensite.actuators.assembly import Actuator, Group, Machine, System
from martensite.actuators.elements.limits import ElementLimits
from martensite.actuators.mechanisms.pulley import AntagonisticPulley
from martensite.base.errors import InputError, ParameterError
from martensite.scenario.assemble import scenario_path
from martensite.scenario.netcdf import describe_result, read_labelled, save_result
from martensite.scenario.scenario import Scenario, load
from martensite.show.figures.overview import plot_result
from martensite.signals.base import AbstractDrive
from martensite.signals.constant import Constant
from martensite.signals.staircase import Staircase
from martensite.simulate.api import simulate
from martensite.simulate.controlled_run import simulate_controlled
from martensite.simulate.result import Result

EXAMPLE = Path(__file__).parents[2] / "examples" / "antagonistic_wires.toml"
PULLEY = AntagonisticPulley(radius=5e-3, preload=3.0)


def actuator(**changes: Any) -> Actuator:
    one = builders.hanging_wire(**changes)
    return Actuator(element=one.element, environment=one.environment, source=one.source)


def machine(**changes: Any) -> Machine:
    one = actuator(**changes)
    return Machine(mechanism=PULLEY, group=Group(protagonist=one, antagonist=one))


@cache
def example() -> Scenario:
    return load(EXAMPLE)


@cache
def run() -> Result:
    scenario = example()
    return simulate(scenario.system, scenario.waveform, 10.0, step=0.05, samples=41)


class TestStructure:
    def test_outputs_have_the_name_of_their_port(self):
        names = list(machine().outputs())
        assert names[0] == "angle"
        assert "protagonist.temperature" in names and "antagonist.power" in names
        assert [d.name for d in machine().drives()] == ["protagonist", "antagonist"]

    def test_parameters_are_reached_by_port(self):
        changed = machine().with_values({"group.antagonist.element.diameter": 3e-4})
        assert changed.value_of("group.antagonist.element.diameter") == 3e-4
        assert changed.value_of("group.protagonist.element.diameter") != 3e-4
        with pytest.raises(ParameterError, match="ambiguous"):
            machine().value_of("diameter")

    @pytest.mark.parametrize(
        ("made", "words"),
        [
            (lambda: Machine(mechanism=PULLEY, group=Group(protagonist=actuator())), "none given for antagonist"),
            (
                lambda: Machine(mechanism=PULLEY, group=Group(protagonist=actuator(), antagonists=actuator())),
                "no port `antagonists`.*Did you mean `antagonist`",
            ),
            (lambda: System(mechanism=PULLEY, **actuator().__dict__), "use `Machine`"),
            (lambda: Group(protagonist=PULLEY), "must be an `Actuator`"),  # type: ignore[arg-type]
        ],
    )
    def test_a_wrong_group_is_a_sentence(self, made, words):
        with pytest.raises(ParameterError, match=words):
            made()

    def test_waveforms_go_by_name(self):
        with pytest.raises(InputError, match="2 drives"):
            simulate(machine(), Constant(level=1.0), 1.0)
        with pytest.raises(InputError, match="Did you mean `antagonist`"):
            simulate(machine(), {"antagonists": Constant(level=1.0)}, 1.0)

    def test_what_has_no_waveform_stays_cold(self):
        result = simulate(machine(), {"protagonist": Constant(level=1.0)}, 2.0, step=0.05)
        assert result.range("antagonist.temperature") == 0.0
        assert result.range("protagonist.temperature") > 10.0


class TestScenario:
    def test_each_port_has_the_common_part_and_its_own(self):
        system = example().system
        assert isinstance(system, Machine)
        first, second = system.group.members().values()
        assert first == second
        changed = load(EXAMPLE, {"actuators.antagonist.element.length": "300 mm"}).system
        assert isinstance(changed, Machine)
        assert changed.value_of("group.antagonist.element.length") == 0.3
        assert changed.value_of("group.protagonist.element.length") == 0.44

    def test_another_kind_replaces_the_common_table(self):
        other = {"actuators.antagonist.environment.cooling": {"kind": "churchill-chu"}}
        changed = load(EXAMPLE, other).system
        assert isinstance(changed, Machine)
        cooling = changed.group.members()["antagonist"].environment.cooling
        assert cooling.registered_name == "churchill-chu"

    def test_a_listed_path_is_one_that_can_be_set(self):
        paths = {scenario_path(leaf.path): leaf for leaf in example().system.leaves()}
        assert "actuators.protagonist.element.law.eps_T" in paths
        assert "mechanism.radius" in paths
        for path in ("actuators.antagonist.element.diameter", "mechanism.radius"):
            changed = load(EXAMPLE, {path: "3 mm"}).system
            full = paths[path].path
            assert changed.value_of(full) == pytest.approx(3e-3)

    @pytest.mark.parametrize(
        ("changes", "words"),
        [
            ({"actuators.foo.element.length": "1 m"}, "actuators.foo.*Valid: `antagonist`"),
            ({"actuators.antagonist.lement.length": "1 m"}, "Did you mean `element`"),
            ({"signals.motor.kind": "constant"}, "signals.motor.*no signal"),
            ({"mechanism": {"kind": "dead-weight", "mass": "1 kg"}}, "takes one element"),
        ],
    )
    def test_a_fault_is_a_sentence(self, changes, words):
        with pytest.raises(InputError, match=words):
            load(EXAMPLE, changes)


class TestResult:
    def test_the_wires_turn_it_to_and_fro(self):
        scenario = example()
        result = simulate(scenario.system, scenario.waveform, 40.0, step=0.04, samples=41)
        angle = [math.degrees(a) for a in result["angle"]]
        assert angle[8] == pytest.approx(-angle[27], rel=1e-4)
        assert angle[8] > 15.0
        assert abs(angle[19]) < 1e-3 > abs(angle[40])
        assert result.stroke == pytest.approx(math.radians(2 * angle[8]), rel=1e-3)

    def test_a_saved_result_is_the_dataset(self, tmp_path: Path):
        save_result(run(), tmp_path / "a.nc", example().text)
        made, read = describe_result(run(), example().text).to_xarray(), read_labelled(tmp_path / "a.nc").to_xarray()
        assert {name: read.sizes[name] for name in ("time", "actuator")} == {"time": 41, "actuator": 2}
        assert list(read["actuator"].values) == ["protagonist", "antagonist"]
        one = read["temperature"].sel(actuator="protagonist")
        np.testing.assert_array_equal(one, run()["protagonist.temperature"])
        np.testing.assert_array_equal(read["angle"], run()["angle"])
        for name in made.data_vars:
            np.testing.assert_array_equal(read[name], made[name])
            assert read[name].attrs["units"] == made[name].attrs["units"]
        assert read["drive"].attrs["units"] == "W"

    def test_a_warning_names_the_port(self):
        limited = machine(limits=ElementLimits(temperature_limit=330.0))
        result = simulate(limited, {"protagonist": Constant(level=5.0)}, 20.0, step=0.05)
        hot = [alarm for alarm in result.alarms if alarm.kind == "temperature"]
        assert [alarm.port for alarm in hot] == ["protagonist"]
        assert any("`protagonist`: temperature" in sentence for sentence in result.warnings)

    def test_the_figure_shows_every_actuator(self):
        figure = plot_result(run(), title="A title")
        over_time = figure.axes[:5]
        assert [len(axes.lines) for axes in over_time] == [1, 2, 2, 2, 2]
        assert [text.get_text() for text in figure.legends[0].texts] == ["protagonist", "antagonist"]
        drawn = np.asarray(over_time[0].lines[0].get_ydata())
        np.testing.assert_allclose(drawn, np.degrees(run()["angle"]))


class Watcher(AbstractDrive):
    """Heats below an angle, and remembers what it was told."""

    def __init__(self, told: list[Mapping[str, float]]) -> None:
        super().__init__()
        self.__dict__["told"] = told

    def init(self) -> int:
        return 0

    def __call__(self, time: float, measurement: Mapping[str, float], memory: int):
        self.__dict__["told"].append({"time": time, **measurement})
        return (1.0 if measurement["angle"] < 0.001 else 0.0), memory + 1


class TestControlled:
    def test_waveforms_alone_run_as_usual(self):
        stairs = Staircase(first=0.5, increment=0.5, hold=0.5, count=3)
        drives = {"protagonist": stairs, "antagonist": Constant(level=0.3)}
        held = simulate_controlled(machine(), drives, 2.0, 0.1, step=0.02)
        free = simulate(machine(), drives, 2.0, step=0.02, samples=21)
        for name in machine().outputs():
            if not name.endswith(("drive", "power", "current", "voltage")):
                assert held[name] == pytest.approx(free[name], rel=1e-9, abs=1e-12), name

    def test_a_controller_sees_all_and_is_held(self):
        told: list[Mapping[str, float]] = []
        result = simulate_controlled(machine(), {"protagonist": Watcher(told)}, 6.0, 0.1, step=0.02, every=2)
        assert len(told) == 60 and len(result.times) == 31
        assert set(told[0]) == {"time", *machine().outputs()}
        assert told[10]["angle"] == pytest.approx(result["angle"][5])
        assert 0.001 < max(result["angle"]) < 0.0012
        assert min(result["protagonist.drive"]) == 0.0 < max(result["protagonist.drive"])

    @pytest.mark.parametrize(
        ("arguments", "words"),
        [
            ({"duration": 1.05, "period": 0.1}, "whole number of periods"),
            ({"duration": 1.0, "period": 0.1, "every": 3}, "must divide the 10 periods"),
        ],
    )
    def test_a_fault_is_a_sentence(self, arguments, words):
        with pytest.raises(ParameterError, match=words):
            simulate_controlled(machine(), {"protagonist": Constant(level=1.0)}, **arguments)
