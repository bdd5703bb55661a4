"""Fits find the truth again, for laws, mechanisms and noise; intervals hold it at their rate."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cache

import numpy as np
import pytest

from martensite.base.errors import ParameterError
from martensite.fit.experiment import Experiment
from martensite.fit.fit import Fit
from martensite.fit.problem import build_problem
from martensite.fit.solve import solve_problem
from martensite.scenario.scenario import Scenario, read_scenario
from martensite.search.free_numbers import SearchRange
from martensite.signals.records import Record

REPETITIONS = 120
FEWEST, MOST = 106, 119
"""99.5 % of binomial numbers with rate 0.95 lie between."""
WIRE = """
[element]
kind = "wire"
material = "{material}"
law = {{ {law} }}
diameter = "0.381 mm"
length = "100 mm"
resistance = {{ kind = "mixture", rho_A = "8.4e-7 ohm*m", rho_M = "9.2e-7 ohm*m" }}
"""
HEATED = """
[environment]
temperature = "25 degC"
cooling = { kind = "constant", h = "70 W/m^2/K" }

[drive]
kind = "current"
waveform = { kind = "triangle", low = "0 A", high = "2.2 A", frequency = "0.02 Hz" }

[run]
duration = "100 s"
"""
CHAMBER = """
[drive]
kind = "temperature"
waveform = {{ kind = "triangle", low = "{low}", high = "{high}", frequency = "0.01 Hz" }}

[run]
duration = "100 s"
"""
WEIGHT = '[mechanism]\nkind = "dead-weight"\nmass = "1 kg"\n'
SPRING = '[mechanism]\nkind = "bias-spring"\nstiffness = "2 N/mm"\npreload = "6 N"\n'
WORN = """
[element.wear]
settling_cycles = 4
residual_strain = "0.7 %"
stroke_loss = "20 %"
temperature_shift = "-8 K"
"""
MACHINE = """
[mechanism]
kind = "testing-machine"
control = "stress"
section = "0.114 mm^2"

[signals.command]
kind = "sine"
low = "80 MPa"
high = "120 MPa"
frequency = "0.03 Hz"
"""


@dataclass(frozen=True)
class Cell:
    """A law at a mechanism, what is measured, and what is to be found."""

    name: str
    text: str
    output: str
    unit: str
    free: tuple[SearchRange, ...]
    rows: int = 101
    step: float = 0.5


def wire(material: str, law: str) -> str:
    return WIRE.format(material=material, law=law)


CELLS = (
    Cell(
        "liang-rogers, dead weight, heated by current",
        wire("flexinol-90", 'kind = "liang-rogers", modulus = "mixture"') + WEIGHT + HEATED,
        "position",
        "m",
        (SearchRange("A_s", 330.0, 352.0), SearchRange("eps_L", 0.03, 0.05), SearchRange("cooling.h", 55.0, 90.0)),
    ),
    Cell(
        "brinson, bias spring, heated by current",
        wire("flexinol-90", 'kind = "brinson", sigma_s = "50 MPa", sigma_f = "90 MPa"') + SPRING + HEATED,
        "position",
        "m",
        (SearchRange("A_f", 343.0, 357.0), SearchRange("M_s", 316.0, 328.0), SearchRange("eps_L", 0.03, 0.05)),
    ),
    Cell(
        "lagoudas, testing machine, in a chamber",
        wire("niti-lagoudas", 'kind = "lagoudas"') + MACHINE + CHAMBER.format(low="-20 degC", high="110 degC"),
        "strain",
        "1",
        (SearchRange("A_f", 320.0, 342.0), SearchRange("M_s", 298.0, 314.0), SearchRange("H_sat", 0.04, 0.07)),
        step=1.0,
    ),
    Cell(
        "tanaka, dead weight, in a chamber",
        wire("flexinol-90", 'kind = "tanaka"') + WEIGHT + CHAMBER.format(low="20 degC", high="130 degC"),
        "strain",
        "1",
        (SearchRange("A_s", 330.0, 348.0), SearchRange("M_f", 305.0, 318.0), SearchRange("eps_L", 0.03, 0.05)),
        step=1.0,
    ),
    Cell(
        "wear of liang-rogers, dead weight, ten cycles in a chamber",
        wire("flexinol-90", 'kind = "liang-rogers"')
        + WORN
        + WEIGHT
        + CHAMBER.format(low="20 degC", high="130 degC").replace("0.01 Hz", "0.1 Hz"),
        "strain",
        "1",
        (
            SearchRange("settling_cycles", 2.0, 9.0),
            SearchRange("residual_strain", 0.004, 0.012),
            SearchRange("stroke_loss", 0.1, 0.3),
            SearchRange("temperature_shift", -12.0, -4.0),
        ),
        rows=401,
        step=0.25,
    ),
)
NOISES = (0.001, 0.01)
"""Standard deviation of the measurement, as a share of its range."""


@cache
def scenario(cell: Cell) -> Scenario:
    return read_scenario(cell.text)


@cache
def truth(cell: Cell) -> dict[str, float]:
    return {wish.name: scenario(cell).system.value_of(wish.name) for wish in cell.free}


def experiment(cell: Cell, values: np.ndarray) -> Experiment:
    times = np.linspace(0.0, 100.0, cell.rows)
    columns = {"time": times.tolist(), cell.output: values.tolist()}
    record = Record("test", columns, {"time": "s", cell.output: cell.unit})
    made = scenario(cell)
    columns = {cell.output: cell.output}
    return Experiment("test", made.system, made.waveform, record, columns, step=cell.step)


@cache
def exact(cell: Cell) -> np.ndarray:
    """What a perfect sensor measures."""
    runner = experiment(cell, np.arange(float(cell.rows))).runner()
    found = runner.run_one(runner.base)
    assert found is not None
    return found[:, 0]


@cache
def fitted(cell: Cell, noise: float, seed: int) -> Fit:
    """From a tenth of the search range beside the truth."""
    true = exact(cell)
    random = np.random.default_rng(seed)
    measured = true + noise * np.ptp(true) * random.standard_normal(true.size)
    wishes: list[SearchRange] = []
    for wish in cell.free:
        assert wish.low is not None
        assert wish.high is not None
        beside = truth(cell)[wish.name] + 0.1 * (wish.high - wish.low)
        wishes.append(replace(wish, start=beside))
    return solve_problem(build_problem([experiment(cell, measured)], wishes))


def covered(cell: Cell, noise: float, share: float = 1.0) -> dict[str, int]:
    """In how many repetitions the interval, or a share of it, holds the truth."""
    held = dict.fromkeys(truth(cell), 0)
    for seed in range(REPETITIONS):
        fit = fitted(cell, noise, seed)
        for name, value in truth(cell).items():
            low, high = fit.uncertainty.interval(name)
            held[name] += abs(value - fit[name]) <= 0.5 * share * (high - low)
    return held


@pytest.mark.usefixtures("c_compiler")
class TestRecovery:
    @pytest.mark.parametrize("cell", CELLS, ids=lambda cell: cell.name)
    def test_without_noise_the_truth_is_found(self, cell: Cell) -> None:
        fit = fitted(cell, 0.0, 0)
        for name, value in truth(cell).items():
            assert fit[name] == pytest.approx(value, rel=1e-6), name

    @pytest.mark.parametrize(
        ("cell", "noise"),
        [
            pytest.param(
                cell,
                noise,
                id=f"{cell.name}-{noise}",
                marks=[] if (cell, noise) == (CELLS[1], NOISES[1]) else [pytest.mark.slow],
            )
            for cell in CELLS
            for noise in NOISES
        ],
    )
    def test_intervals_hold_the_truth_at_their_rate(self, cell: Cell, noise: float) -> None:
        held = covered(cell, noise)
        assert all(FEWEST <= count <= MOST for count in held.values()), held


def test_two_movers_of_one_number_are_refused() -> None:
    one = experiment(CELLS[0], np.arange(101.0))
    with pytest.raises(ParameterError, match=r"both move `element\.law\.A_s`"):
        build_problem([one], ["A_s", "element.law.A_s"])


def test_a_shared_and_an_own_mover_are_refused() -> None:
    one = experiment(CELLS[0], np.arange(101.0))
    with pytest.raises(ParameterError, match=r"both move `element\.law\.A_s`"):
        build_problem([one], ["A_s"], each=["law.A_s"])
