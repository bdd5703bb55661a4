"""Loops fitted without a scenario: number of cycles, jitter, assumed values, hold-out.

Source of truth: loops computed here from cosines and straight lines with the given parameters.
"""

from __future__ import annotations

import itertools
from typing import Any

import numpy as np
import pytest

from martensite.base.summary import DataTable
from martensite.characterise.specimen import add_strain_and_stress
from martensite.characterise.tangent_points import find_all_cycles, find_tangent_points
from martensite.fit.experiment import Experiment
from martensite.fit.experiment_kinds.base import propose_scenarios, recognise_experiment
from martensite.fit.log_models import LogModel, model_logs
from martensite.fit.logs import choose_held_out
from martensite.fit.path_places import measure_places
from martensite.fit.problem import Problem
from martensite.fit.search_monitor import SearchNote
from martensite.scenario.scenario import read_scenario
from martensite.show.summaries.log_model import summarise_log_model
from martensite.signals.records import Record

TRUE = {"A_s": 110.0, "A_f": 130.0, "M_s": 120.0, "M_f": 90.0}
"""Transformation temperatures at 200 MPa [degC]."""
EPS = 0.038


def fall(celsius: Any, low: float, high: float) -> Any:
    """Cosine from 1 below a strip to 0 above it."""
    return 0.5 + 0.5 * np.cos(np.pi * np.clip((celsius - low) / (high - low), 0.0, 1.0))


def isobaric(cycles: int, jitter: float = 0.0, width: float = 1.0) -> Record:
    """Cycles at 200 MPa of 260 rows; the strips are `width` times as wide about their middles."""
    chance = np.random.default_rng(3)
    way = np.arange(130) / 130.0
    up, down = 35.0 + 265.0 * way, 300.0 - 265.0 * way
    strips = [(TRUE[a], TRUE[b]) for a, b in (("A_s", "A_f"), ("M_f", "M_s"))]
    ends = [(0.5 * (a + b) - 0.5 * width * (b - a), 0.5 * (a + b) + 0.5 * width * (b - a)) for a, b in strips]
    celsius = np.tile(np.concatenate([up, down]), cycles)
    strain = np.tile(EPS * np.concatenate([fall(up, *ends[0]), fall(down, *ends[1])]), cycles)
    columns = {
        "time": np.arange(float(len(celsius))),
        "temperature": celsius + 273.15 + jitter * chance.standard_normal(len(celsius)),
        "strain": strain + 5e-5 * chance.standard_normal(len(celsius)),
        "stress": np.full(len(celsius), 200e6),
    }
    units = {"time": "s", "temperature": "K", "strain": "1", "stress": "Pa"}
    return Record(f"loop_{cycles}", {name: x.tolist() for name, x in columns.items()}, units, interval=1.0)


def superelastic(repeat: int = 1, celsius: int = 30) -> Record:
    """Loops: E_A 60 GPa, E_M 30 GPa, eps_L 4 %, plateaus 300 to 340 and 180 to 140 MPa at 30 degC, 7 MPa/K."""
    rise = 7.0 * (celsius - 30)
    stress = (400.0 + rise) * np.concatenate([np.arange(121), np.arange(119, -1, -1)]) / 120.0
    up = np.clip((stress[:121] - 300.0 - rise) / 40.0, 0.0, 1.0)
    xi = np.concatenate([up, np.clip((stress[121:] - 140.0 - rise) / 40.0, 0.0, 1.0)])
    strain = np.tile(stress / (60e3 - 30e3 * xi) + 0.04 * xi, repeat)
    noise = 0.5 * np.random.default_rng(3).standard_normal(len(strain))
    columns = {"strain": strain, "stress": 1e6 * (np.tile(stress, repeat) + noise)}
    whole = {"time": np.arange(float(len(strain))), **columns}
    units = {"time": "s", "strain": "1", "stress": "Pa"}
    return Record(f"se_{repeat}_{celsius}C", {name: x.tolist() for name, x in whole.items()}, units, interval=1.0)


def check_temperatures(model: LogModel) -> None:
    """The intervals at 200 MPa hold the true temperatures."""
    found = {one.name: one for one in model.temperatures if one.stress > 0.0}
    for name, celsius in TRUE.items():
        assert abs(found[name].value - 273.15 - celsius) <= 2.0 * found[name].half_width, name
        assert not found[name].assumed


@pytest.mark.parametrize("cycles", [1, 20])
def test_equal_cycles_give_the_parameters_of_one(cycles: int) -> None:
    record = isobaric(cycles)
    model = model_logs(record)
    assert model.chosen_model.proposal.name == "liang-rogers"
    assert model.predicts
    check_temperatures(model)
    assert max(one.half_width for one in model.temperatures) < 0.2
    zeros = [one for one in model.temperatures if one.stress == 0.0]
    assert all("element.law." in path for one in zeros for path in one.assumed)
    assert all(one.assumed for one in zeros)
    truth = isobaric(1)
    (again,) = model.predict_record(truth).values()
    clean = np.concatenate(
        [
            EPS * fall(np.asarray(truth["temperature"][s]) - 273.15, *e)
            for s, e in ((slice(0, 130), (110.0, 130.0)), (slice(130, 260), (90.0, 120.0)))
        ]
    )
    assert float(np.sqrt(np.mean((again - clean) ** 2))) < 5e-5
    assert any("Cycles 18 to 20 are fitted" in note for note in model.notes) == (cycles == 20)


def test_jitter_of_the_temperature_is_in_the_intervals() -> None:
    model = model_logs(isobaric(1, jitter=4.0))
    check_temperatures(model)
    assert min(one.half_width for one in model.temperatures) > 0.5
    assert any("smoothed along each leg" in note for note in model.notes)


def test_tangents_of_every_cycle_bear_jitter() -> None:
    """Jitter of 5 K from row to row: points scatter by little about those without, and no cycle is refused."""
    clean = find_tangent_points(isobaric(1))
    found = find_all_cycles(isobaric(10, jitter=5.0))
    assert not any(isinstance(one, str) for one in found)
    for name in TRUE:
        apart = [getattr(one, name) - getattr(clean, name) for one in found]
        assert abs(float(np.mean(apart))) < 1.5, name
        assert float(np.std(apart)) < 2.5, name


@pytest.mark.parametrize("repeat", [1, 12])
def test_repeated_tensile_loops_give_the_parameters_of_one(repeat: int) -> None:
    found = model_logs([superelastic(repeat, celsius) for celsius in (30, 70)])
    assert found.predicts and found.chosen_model.proposal.name == "liang-rogers"
    truth = {"E_A": 60e9, "E_M": 30e9, "eps_L": 0.04, "C_A": 7e6, "C_M": 7e6}
    assert {name: found.fit.numbers[name] for name in truth} == pytest.approx(truth, rel=0.01)


@pytest.mark.parametrize("fixed", ["E_M", "E_M=30 GPa"])
def test_a_parameter_held_at_its_start_is_an_assumption(fixed: str) -> None:
    """The strain at the end of the plateau is eps_L plus stress over E_M; a given E_M is no assumption."""
    found = model_logs([superelastic(1, celsius) for celsius in (30, 70)], fixed=[fixed])
    assert ("element.law.E_M" in found.dependent.get("eps_L", ())) == ("=" not in fixed)


def with_force(record: Record, name: str) -> Record:
    """The load of the loops on a wire of 0.381 mm, and the travel of a gauge length of 50 mm."""
    force = np.asarray(record["stress"]) * np.pi / 4.0 * 0.381e-3**2
    travel = 0.05 * np.asarray(record["strain"])
    columns = {"time": record.times, "temperature": record["temperature"], "force": force.tolist()}
    units = {"time": "s", "temperature": "K", "force": "N", "position": "m"}
    return Record(name, columns | {"position": travel.tolist()}, units, interval=1.0)


@pytest.mark.parametrize("words", ["NiTi-3 d=0.381 mm L=50 mm", "Draht, Durchmesser 0,381 mm, Messlänge 50 mm"])
def test_sizes_in_the_lines_above_a_table_are_used(words: str) -> None:
    record = with_force(isobaric(1), "loop")
    found = recognise_experiment([record])
    (first, *_), known = propose_scenarios(found, [record], {}, {"loop": {"specimen": words}})
    assert first.rows[0]["stress"][0] == pytest.approx(200e6)
    assert first.rows[0]["strain"] == pytest.approx(isobaric(1)["strain"])
    assert not set(known.assumed) & {"element.diameter", "element.length"}
    _, bare = propose_scenarios(found, [record], {})
    assert {"element.diameter", "element.length"} <= set(bare.assumed)


def test_stress_in_a_name_replaces_an_assumed_section() -> None:
    record = with_force(isobaric(1), "loop_200MPa")
    (first, *_), known = propose_scenarios(recognise_experiment([record]), [record], {})
    assert first.rows[0]["stress"][0] == 200e6 and "element.diameter" not in known.assumed


def test_tangents_take_travel_and_force() -> None:
    whole = find_tangent_points(isobaric(1))
    raw = find_tangent_points(add_strain_and_stress(with_force(isobaric(1), "loop"), 0.05, 0.381e-3))
    assert [raw.stress, raw.A_s, raw.M_s, raw.H] == pytest.approx([whole.stress, whole.A_s, whole.M_s, whole.H])


def test_given_length_of_a_tensile_test_changes_no_strain() -> None:
    records, given = [superelastic(1, celsius) for celsius in (30, 70)], {"element.length": "40 mm"}
    free, known = model_logs(records), model_logs(records, overrides=given)
    assert free.fit.numbers == pytest.approx(known.fit.numbers, rel=1e-6)
    assert free.fit["E_A"] == pytest.approx(60e9, rel=0.01)
    assert free.fit["E_M"] == pytest.approx(30e9, rel=0.01)
    assert "E_A" not in free.dependent


def pull_unknown_section() -> Record:
    """Return forces of a superelastic wire of 0.5 mm whose diameter is not in the record."""
    record = superelastic()
    columns = {name: x for name, x in record.columns.items() if name != "stress"}
    columns["force"] = (np.asarray(record["stress"]) * np.pi / 4.0 * 0.5e-3**2).tolist()
    return Record("test_30C", columns, {"time": "s", "strain": "1", "force": "N"}, interval=1.0)


def test_assumed_section_is_named_at_the_moduli() -> None:
    model = model_logs(pull_unknown_section(), free=["E_A", "E_M", "eps_L"])
    assert "element.diameter" in model.dependent["E_A"] and not model.untested_assumptions
    assert model.fit["E_A"] == pytest.approx(15e9, rel=0.01)  # by the assumed 1 mm


def test_interrupted_fit_calls_nothing_determined_that_may_depend_on_assumptions() -> None:
    evaluations = itertools.count()

    def interrupt(_problem: Problem, _note: SearchNote) -> None:
        if next(evaluations) == 12:
            raise KeyboardInterrupt

    model = model_logs(pull_unknown_section(), keep=interrupt)
    assert model.stop_reason == "interruption" and "element.diameter" in model.untested_assumptions
    blocks = summarise_log_model(model).blocks
    tables = [one for one in blocks if isinstance(one, DataTable) and "determined" in one.head]
    marks = [row[-1] for table in tables for row in table.rows]
    assert "yes" not in marks
    assert any(one.startswith("not tested for assumed") and "diameter" in one for one in marks)


SHARP = """
element = { kind = "wire", material = "flexinol-90", diameter = "1 mm", length = "100 mm", initial_fraction = 0, \
law = { kind = "liang-rogers", eps_L = 0.04 } }
mechanism = { kind = "testing-machine", control = "stress", section = "0.7854 mm^2" }
signals = { command = { kind = "log", column = "stress" } }
drive = { kind = "temperature", waveform = { kind = "log" } }
run = { step = "1e3 s" }
"""


def test_held_out_stretch_never_holds_a_whole_transformation() -> None:
    """Strips of 2 K in a range of 265 K, which stretches of time can hold whole."""
    record = isobaric(1, width=0.1)
    scenario = read_scenario(SHARP, log=record)
    follows = dict(scenario.follows)
    one = Experiment("log", scenario.system, scenario.waveform, record, {"strain": "strain"}, follows=follows)
    (held,) = choose_held_out("auto", ["log"], [one.times.tolist()], [measure_places(one)])
    assert held
    for first, last in held:
        rows = (one.times >= first) & (one.times <= last)
        assert float(np.ptp(one.measured[rows, 0])) < 0.6 * EPS
