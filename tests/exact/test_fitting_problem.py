"""Problems of a fit: what counts as a residual, and its derivatives in all free parameters.

Source of truth: central differences of the residuals, one parameter after the other. Steps are
short or temperatures given, so that runs are solved to rounding and differences mean something.
"""

from __future__ import annotations

import math
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from builders import FunctionWaveform, chamber, hanging_wire, law_a, through

from martensite.actuators.assembly import AbstractSystem
from martensite.base.errors import ParameterError, SolveError
from martensite.fit.experiment import Experiment
from martensite.fit.problem import Problem, build_problem
from martensite.fit.solve import solve_problem
from martensite.physics.electrical.sources import VoltageSource
from martensite.scenario.scenario import load
from martensite.search import batch_runner
from martensite.search.free_numbers import SearchRange
from martensite.signals.records import Record
from martensite.signals.step import Step
from martensite.simulate.api import simulate

EXAMPLES = Path(__file__).parents[2] / "examples"
UNITS = {"time": "s", "position": "m", "temperature": "K", "martensite_fraction": "1"}
HEATING = through([290.0, 400.0, 300.0, 380.0, 290.0])
VOLTS = Step(low=0.0, high=5.5, at=0.2, until=1.4)
DURATION = 4.0
TRIED = 0.013
"""How far from the truth, as shares of the search ranges, derivatives are judged."""


@cache
def column(system: AbstractSystem, wave: Any, output: str, rows: int) -> tuple[float, ...]:
    run = simulate(system, wave, DURATION, step=0.01, samples=rows)
    return tuple(run[output])


def experiment(
    name: str = "one",
    *outputs: str,
    rows: int = 121,
    system: AbstractSystem | None = None,
    wave: Any = HEATING,
    step: float = 0.02,
    **changes: Any,
) -> Experiment:
    """A record of a wire in a chamber, as its system makes it."""
    system = system or chamber(law_a(), mass=1.0)
    outputs = outputs or ("position",)
    columns = {"time": np.linspace(0.0, DURATION, rows).tolist()}
    columns |= {output: list(column(system, wave, output, rows)) for output in outputs}
    record = Record(name, columns, {key: UNITS[key] for key in columns})
    compared = {output: output for output in outputs}
    return Experiment(name, system, wave, record, compared, step=step, **changes)


def moved(one: Experiment, change: Any) -> Experiment:
    """The same record with other numbers in the columns compared."""
    columns = {
        key: column if key == "time" else change(np.array(column)).tolist()
        for key, column in one.record.columns.items()
    }
    return replace(one, record=replace(one.record, columns=columns))


def away(task: Problem) -> Any:
    """A point where nothing is at a bound, nor at a sample."""
    steps = 1.0 + np.arange(len(task.free)) % 3
    return np.clip(task.start + TRIED * steps, 0.05, 0.93)


def apart(task: Problem, width: float = 1e-5) -> float:
    """Largest error of the Jacobian, as a share of the largest of its column."""
    u = away(task)
    found = task.evaluate(u, slopes=True)
    assert found is not None
    worst = 0.0
    for i in range(len(u)):
        pairs: list[Any] = []
        for share in (1.0, 2.0):
            ends = [task.evaluate(u + s * share * width * np.eye(len(u))[i]) for s in (1.0, -1.0)]
            assert ends[0] is not None
            assert ends[1] is not None
            pairs.append((ends[0].residuals - ends[1].residuals) / (2.0 * share * width))
        meant = (4.0 * pairs[0] - pairs[1]) / 3.0
        largest = np.abs(meant).max()
        assert largest > 0.0, task.names[i]
        worst = max(worst, float(np.abs(found.jacobian[:, i] - meant).max() / largest))
    return worst


@pytest.fixture
def without_compiler(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(batch_runner, "find_compiler", lambda: None)


pytestmark = pytest.mark.usefixtures("c_compiler")

# ---------------------------------------------------------------- residuals


def test_residuals_are_mismatches_by_noise_or_range():
    one = moved(experiment("one", "position", "temperature"), lambda column: 1.01 * column)
    task = build_problem([replace(one, weights={"temperature": 4.0})], ["A_s"], noise={"temperature": 0.5})
    found = task.evaluate(task.start)
    assert found is not None
    model = found.fitted_records[0].model
    reach = np.ptp(one.measured[:, 0])
    position = (model[:, 0] - one.measured[:, 0]) / reach
    temperature = 2.0 * (model[:, 1] - one.measured[:, 1]) / 0.5
    assert found.residuals == pytest.approx(np.concatenate([position, temperature]), rel=1e-12)
    assert found.cost == pytest.approx(np.mean(found.residuals**2))
    assert task.lengths == [121, 121]


def test_missing_samples_are_left_out():
    whole = experiment("one", "position", "temperature")

    def with_holes(column: np.ndarray) -> np.ndarray:
        column[5:9] = math.nan
        return column

    task, other = (build_problem([one], ["A_s", "C_A"]) for one in (whole, moved(whole, with_holes)))
    u = away(task)
    full, less = task.evaluate(u, slopes=True), other.evaluate(u, slopes=True)
    assert full is not None
    assert less is not None
    kept = np.ones(242, bool)
    kept[5:9] = kept[126:130] = False
    assert other.lengths == [117, 117]
    assert (less.residuals == full.residuals[kept]).all()
    assert (less.jacobian == full.jacobian[kept]).all()
    assert other.costs(u[None])[0] == pytest.approx(less.cost)


def test_one_output_may_miss_what_another_has():
    one = experiment("one", "position", "temperature")
    columns = dict(one.record.columns)
    columns["position"] = [math.nan, *columns["position"][1:-1], math.nan]
    other = build_problem([replace(one, record=replace(one.record, columns=columns))], ["A_s"])
    assert other.lengths == [119, 121]
    assert solve_problem(other)["A_s"] == pytest.approx(law_a().A_s)


def test_held_stretches_are_not_seen_but_judged():
    """What is kept back may be nonsense."""
    one = experiment()
    wrong = moved(one, lambda x: x + 1e-3 * one.times * (one.times < 1.0))
    task = build_problem([replace(wrong, held_out_intervals=((0.0, 1.0),))], [SearchRange("A_s", start=350.0)])
    fit = solve_problem(task)
    assert task.lengths == [90]
    assert fit["A_s"] == pytest.approx(law_a().A_s, abs=1e-5)
    scores = {one.part: one for one in fit.scores}
    assert scores["training"].rms < 1e-8
    assert scores["held-out"].rms > 1e-4
    assert solve_problem(build_problem([wrong], ["A_s"]))["A_s"] != pytest.approx(law_a().A_s, abs=1e-5)


@pytest.mark.parametrize("native", [True, False])
def test_records_that_are_kept_back_are_predicted(native: bool, monkeypatch: pytest.MonkeyPatch):
    """Their own offsets are fitted to them, with nothing else free."""
    if not native:
        monkeypatch.setattr(batch_runner, "find_compiler", lambda: None)
    one, two = (experiment("one"), experiment("two", wave=through([290.0, 360.0, 290.0, 400.0, 320.0])))
    held = replace(two, held_out_intervals=((-math.inf, math.inf),))
    task = build_problem([one, held], [SearchRange("A_s", start=350.0)], each=["offset"])
    fit = solve_problem(task)
    assert fit.problem.names == ("A_s", "offset.position@one")
    assert fit.held_out_records[0].model[:, 0] == pytest.approx(two.measured[:, 0], abs=1e-9)
    assert fit.held_out_records[0].numbers == pytest.approx({"offset.position@two": 0.0}, abs=1e-9)


# ---------------------------------------------------------------- derivatives


def test_derivatives_of_several_records_and_outputs():
    others = ("position", "temperature", "martensite_fraction")
    system = hanging_wire(mass=1.7, source=VoltageSource(), law=law_a())
    heated = experiment("volts", *others, system=system, wave=VOLTS, step=0.002)
    task = build_problem([experiment("kelvins"), heated], ["A_s", "C_M", "eps_L", "h", "latent_heat"])
    assert apart(task) <= 1e-5


def test_derivatives_of_what_a_record_has_for_itself():
    """Offsets, delays, and parameters of the system that one record has alone."""
    one = experiment("one", "position", "temperature")
    two = experiment("two", wave=through([290.0, 360.0, 290.0, 400.0, 320.0]))
    task = build_problem([one, two], ["A_s"], each=["offset", "delay", "E_M", "initial_fraction"])
    assert len(task.free) == 10
    assert apart(task) <= 1e-5
    found = task.evaluate(away(task), slopes=True)
    assert found is not None
    names = [name.endswith("@two") for name in task.names]
    assert (found.jacobian[:242, names] == 0.0).all()


def test_a_delay_is_found():
    late = FunctionWaveform(function=lambda t: HEATING.value(max(t - 0.03, 0.0)), kinks=(0.03, 1.03, 2.03, 3.03))
    one = replace(experiment(rows=241, wave=late), waveform=HEATING)
    fit = solve_problem(build_problem([one], [SearchRange("A_s", start=344.0)], each=["delay"]))
    assert fit["delay@one"] == pytest.approx(0.03, abs=1e-4)
    assert fit["A_s"] == pytest.approx(law_a().A_s, abs=0.02)
    assert fit.cost < 1e-6


def test_one_name_moves_the_wires_of_all_actuators():
    scenario = load(EXAMPLES / "antagonistic_wires.toml")
    assert not isinstance(scenario.waveform, Step)
    times = np.linspace(0.0, 20.0, 41)
    columns = {"time": times.tolist(), "angle": np.sin(times).tolist()}
    record = Record("one", columns, {"time": "s", "angle": "rad"})
    one = Experiment("one", scenario.system, scenario.waveform, record, {"angle": "angle"}, step=0.02)
    names = ["E_A", "eps_T", "radius", "protagonist.element.law.E_M"]
    task = build_problem([one], names)
    paths = [path for path in task.runners[0].paths if task.free[0].moves(path)]
    assert len(paths) == 2
    assert apart(task) <= 1e-4
    at = task.system(0, away(task))
    assert at.value_of(paths[0]) == at.value_of(paths[1]) != scenario.system.value_of(paths[0])
    with pytest.raises(ParameterError, match="both move"):
        build_problem([one], ["E_A", "protagonist.element.law.E_A"])


def test_more_free_parameters_than_directions_of_one_run():
    law = ["A_s", "A_f", "M_s", "M_f", "C_A", "C_M", "E_A", "E_M", "eps_L", "Theta"]
    wire = ["diameter", "element.length", "density", "heat_capacity", "latent_heat", "r_A", "h"]
    system = hanging_wire(mass=1.7, source=VoltageSource(), law=law_a())
    one = experiment("one", "position", "temperature", system=system, wave=VOLTS, step=0.002)
    task = build_problem([one], [*law, *wire, "mass", "environment.temperature", "r_M"])
    assert len(task.free) == 20
    assert apart(task) <= 1e-5


def test_without_a_compiler_derivatives_are_differences(without_compiler: None):
    """Also of what is zero at the start, and at the ends of ranges."""
    one = experiment("one", "position", "temperature", rows=61)
    names = ["A_s", "C_A", SearchRange("element.latent_heat", 0.0, 3e4, 0.0), SearchRange("Theta", -1e6, 1e6, 0.0)]
    volts = experiment("volts", system=hanging_wire(mass=1.7, source=VoltageSource(), law=law_a()), wave=VOLTS, rows=61)
    plain = build_problem([one, volts], names, each=["offset"])
    assert not plain.runners[0].native
    with pytest.MonkeyPatch.context() as patch:
        patch.undo()
        patch.setattr(batch_runner, "find_compiler", lambda: "cc")
        native = build_problem([one, volts], names, each=["offset"])
        assert native.runners[0].native
    for u in (plain.start, away(plain)):
        found, meant = (task.evaluate(u, slopes=True) for task in (plain, native))
        assert found is not None
        assert meant is not None
        assert found.residuals == pytest.approx(meant.residuals, abs=1e-12)
        sizes = np.abs(meant.jacobian).max(axis=0)
        assert (np.abs(found.jacobian - meant.jacobian).max(axis=0) <= 1e-5 * sizes).all()


# ---------------------------------------------------------------- where runs fail


def test_points_that_contradict_themselves_are_not_tried(monkeypatch: pytest.MonkeyPatch):
    """The truth lies close to A_f = 351.15 K, which a search without an order oversteps."""
    failed: list[Any] = []
    evaluate = Problem.evaluate

    def counted(task: Problem, u: Any, *, slopes: bool = False) -> Any:
        found = evaluate(task, u, slopes=slopes)
        failed.extend([u] if found is None else [])
        return found

    monkeypatch.setattr(Problem, "evaluate", counted)
    sharp = experiment(rows=481, system=chamber(law_a(A_s=350.9), mass=1.0))
    task = build_problem([sharp], [SearchRange("A_s", 300.0, 400.0, 349.0)])
    assert task.evaluate([0.9]) is None
    assert task.costs(np.array([[0.9], task.start]))[0] == math.inf
    fit = solve_problem(task)
    assert len(failed) == 1
    assert (fit.reason, fit["A_s"]) == ("converged", pytest.approx(350.9, abs=1e-6))


def test_runs_that_fail_everywhere_are_an_error_with_a_remedy(monkeypatch: pytest.MonkeyPatch):
    task = build_problem([experiment()], [SearchRange("A_s", 300.0, 400.0)])
    monkeypatch.setattr(Problem, "evaluate", lambda *_, **__: None)
    monkeypatch.setattr(Problem, "costs", lambda _, points: np.full(len(points), math.inf))
    with pytest.raises(SolveError, match="start from other values"):
        solve_problem(task)


def test_a_start_that_contradicts_itself_is_moved():
    task = build_problem([experiment()], [SearchRange("A_s", 300.0, 400.0, 390.0)])
    for starts in (0, 2):
        assert solve_problem(task, starts=starts)["A_s"] == pytest.approx(law_a().A_s, abs=1e-4)


@pytest.mark.parametrize("names", [["A_s", "element.law.A_s"], ["A_s", "law.A_s"]])
def test_two_names_of_one_parameter_are_refused(names: list[str]):
    with pytest.raises(ParameterError, match="both move"):
        build_problem([experiment()], names)


def test_a_shared_and_an_own_name_of_one_parameter_are_refused():
    with pytest.raises(ParameterError, match="both move"):
        build_problem([experiment("one"), experiment("two")], ["A_s"], each=["element.law.A_s"])


def test_an_own_parameter_is_another_one_in_each_record():
    cold = chamber(law_a(A_s=345.15), mass=1.0)
    task = build_problem([experiment("one"), experiment("two", system=cold)], ["A_f"], each=["A_s"])
    fit = solve_problem(task)
    assert [fit["A_s@one"], fit["A_s@two"]] == pytest.approx([law_a().A_s, 345.15], abs=1e-5)
