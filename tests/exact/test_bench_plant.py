"""The simulated bench of study `hammerstein-wiener`: energy, hysteresis, sensors, records.

Sources of truth: conservation of energy, the rules that define a Preisach model, the measured
loop that its branches come from, and heat balances at rest.
"""

from __future__ import annotations

import math

import numpy as np
import pytest

from martensite.base.errors import ParameterError
from martensite.control.controllers.pid import Gains
from martensite.control.tuning.measures import build_steps, measure_steps
from martensite.kernels import floats
from martensite.logs import datasets
from martensite.logs.reader import read_table
from martensite.studies.hammerstein_wiener import branches, loop, records
from martensite.studies.hammerstein_wiener.bench import INTERVAL, ReferenceBench, RunningBench
from martensite.studies.hammerstein_wiener.branches import GRID, ZERO
from martensite.studies.hammerstein_wiener.preisach import Cell, everett_function

CORRELATION = 0.85
C, LATENT = 1.1, 31.9
QUICK = 0.02
"""Step of runs that go to rest [s]."""


def cell(celsius: float = 23.0) -> Cell:
    return Cell(everett_function(0.0, CORRELATION), C, LATENT, celsius + ZERO)


def state(wire: Cell) -> tuple[float, float]:
    return wire.temperature, wire.fraction


def to(wire: Cell, celsius: float, step: float = 0.05) -> None:
    """Heat or cool in small steps until a temperature is passed."""
    way = math.copysign(1.0, celsius + ZERO - wire.temperature)
    while way * (celsius + ZERO - wire.temperature) > 0.0:
        wire.heat(way * step)


# ---------------------------------------------------------------- branches


def test_the_table_is_what_the_measurements_give() -> None:
    keys = [f"flexinol-isobaric/isobaric_{s}MPa.txt" for s in branches.STRESSES]
    if not all(datasets.is_here(key) for key in keys):
        pytest.skip("the measurements are not on this machine")
    text = branches.FILE.read_text(encoding="utf-8")
    made, kept = (
        np.array([line.split(",") for line in t.splitlines()[7:]], dtype=float) for t in (branches.derive_text(), text)
    )
    assert text.startswith(branches.HEADER)
    np.testing.assert_allclose(made, kept, rtol=0.0, atol=2e-6)
    strains = [read_table(f"data:{key}")["strain"] for key in keys]
    assert [max(s) - min(s) for s in strains] == pytest.approx(branches.STROKES, abs=1e-6)


@pytest.mark.parametrize(
    ("share", "heating", "cooling", "stroke"), [(0.0, 83.8, 62.9, 0.0413), (1.0, 89.7, 69.9, 0.0435)]
)
def test_branches_turn_where_the_wire_did(share: float, heating: float, cooling: float, stroke: float) -> None:
    found = branches.build_loop(share)
    assert np.interp(0.5, found.heating, GRID) - ZERO == pytest.approx(heating, abs=0.3)
    assert np.interp(0.5, found.cooling, GRID) - ZERO == pytest.approx(cooling, abs=0.5)
    assert found.stroke == pytest.approx(stroke, abs=1e-4)
    for branch in (found.heating, found.cooling):
        assert np.all(np.diff(branch) >= 0.0)
        assert (branch[0], branch[-1]) == (0.0, 1.0)


def test_a_load_in_between_lies_in_between() -> None:
    made = [branches.build_loop(share) for share in (0.0, 0.5, 1.0)]
    low, middle, high = (np.interp(0.5, found.heating, GRID) for found in made)
    assert middle == pytest.approx(0.5 * (low + high), abs=0.01)


# ---------------------------------------------------------------- hysteresis with latent heat


def test_relays_have_weights_and_none_on_the_diagonal() -> None:
    weights = everett_function(0.0, CORRELATION)
    assert np.all(np.diff(weights, axis=0) >= -1e-15)
    assert np.all(np.diff(weights, axis=1) <= 1e-15)
    assert np.all(np.triu(weights) == 0.0)
    assert weights[-1, 0] == pytest.approx(1.0)


def test_major_branches_are_the_measured_ones() -> None:
    weights, found = everett_function(0.0, CORRELATION), branches.build_loop(0.0)
    assert np.abs(weights[:, 0] - found.heating).max() < 0.02
    assert np.abs(1.0 - weights[-1] - found.cooling).max() < 0.04


def test_heat_goes_into_temperature_and_transformation() -> None:
    wire, rng = cell(), np.random.default_rng(5)
    begin, total = state(wire), 0.0
    for size in rng.normal(0.02, 2.0, 2000):
        wire.heat(size)
        total += size
        gained = C * (wire.temperature - begin[0]) + LATENT * (wire.fraction - begin[1])
        assert gained == pytest.approx(total, abs=1e-8)
        assert -1e-9 <= wire.fraction <= 1.0 + 1e-9


def test_an_inner_loop_closes_where_it_opened() -> None:
    wire = cell()
    to(wire, 84.0)
    opened = state(wire)
    wire.heat(-20.0)
    assert wire.temperature < 70.0 + ZERO
    wire.heat(20.0)
    assert state(wire) == pytest.approx(opened, abs=1e-9)


# ---------------------------------------------------------------- the bench


@pytest.mark.parametrize(
    ("percent", "celsius", "millimetres"),
    [(5, 57.8, 0.41), (8, 77.2, 1.69), (10, 93.8, 8.31), (14, 120.0, 9.23), (18, 145.1, 9.49)],
)
def test_where_it_comes_to_rest(percent: float, celsius: float, millimetres: float) -> None:
    plant = RunningBench(ReferenceBench())
    for _ in range(round(120.0 / QUICK)):
        plant.step(0.01 * percent, QUICK)
    assert plant.temperature - ZERO == pytest.approx(celsius, abs=0.1)
    assert 1e3 * plant.position == pytest.approx(millimetres, abs=0.01)


def test_it_rests_without_power_and_balances_heat_with_it() -> None:
    bench = ReferenceBench()
    plant = RunningBench(bench)
    plant.step(0.0, QUICK)
    assert (plant.temperature, plant.position) == (bench.ambient, 0.0)
    for _ in range(round(200.0 / QUICK)):
        plant.step(0.12, QUICK)
    ohms = bench.resistance * (1.0 - bench.resistance_drop * plant.fraction)
    gained = 0.12 * (19.2 / (ohms + 0.5)) ** 2 * ohms
    above = plant.temperature - bench.ambient
    lost = (40.0 + 9.0 * above**0.25) * math.pi * bench.diameter * above
    assert gained == pytest.approx(lost, rel=1e-4)
    assert plant.position == pytest.approx(bench.stroke * plant.fraction, rel=1e-4)


def test_the_paper_s_current_and_stroke() -> None:
    bench = ReferenceBench()
    assert bench.driver.closed_current(floats, 4.3 * bench.length) == pytest.approx(4.0)
    assert bench.stroke == pytest.approx(0.04 * bench.length, rel=0.04)
    assert bench.load * 9.81 / bench.section == pytest.approx(48e6, rel=0.01)


def test_cold_ends_transform_less() -> None:
    lumped, long = RunningBench(ReferenceBench()), RunningBench(ReferenceBench(cells=4.0))
    for _ in range(round(100.0 / QUICK)):
        lumped.step(0.12, QUICK)
        long.step(0.12, QUICK)
    assert long.temperature == pytest.approx(lumped.temperature, abs=1.5)
    assert 0.6 * lumped.fraction < long.fraction < 0.99 * lumped.fraction
    temperatures = [wire.temperature for wire in long._wire]
    assert temperatures == sorted(temperatures)


def test_conduction_takes_from_one_cell_what_it_gives_to_another() -> None:
    bench = ReferenceBench(cells=3.0)
    plant = RunningBench(bench)
    for wire, above in zip(plant._wire, (0.0, 30.0, 45.0), strict=True):
        wire.heat(above * bench.capacity)
    powers = [0.0, 0.0, 0.0]
    plant._conduct(powers)
    total = sum(p * size for p, size in zip(powers, plant._lengths, strict=True))
    first = plant._wire[0].temperature - bench.ambient
    assert total == pytest.approx(-bench.conductivity * bench.section * first / (0.5 * plant._lengths[0]), abs=1e-12)
    assert powers[1] != 0.0


# ---------------------------------------------------------------- under control


def test_a_controller_holds_the_wire_at_a_position() -> None:
    """Gains in percent per millimetre are 10 times as large in duty per metre."""
    reference = build_steps([(0.0, 0.2), (3e-3, 4.8)], INTERVAL)
    gains = Gains(10.0 * 106.0, 10.0 * 0.024, 10.0 * 3670.0)
    run = loop.run_controlled(gains, reference)
    (found,) = measure_steps(reference, run.output, INTERVAL)
    assert found.rise == pytest.approx(1.24, abs=0.05)
    assert found.overshoot < 0.02
    assert abs(found.error) < 5e-5
    assert (run.signal.min(), run.signal.max()) == (0.0, 1.0)
    again = loop.run_controlled(gains, reference)
    np.testing.assert_array_equal(run.output, again.output)


# ---------------------------------------------------------------- records

SHORT = records.parse_pulses("short", ((30, 0.1, 0.1),), 1)


def test_records_repeat_by_their_seed() -> None:
    first, again = records.record_bench(SHORT), records.record_bench(SHORT)
    np.testing.assert_array_equal(first.outputs, again.outputs)
    other = records.record_bench(records.Excitation("other", SHORT.duty, 2))
    assert np.any(other.outputs != first.outputs)
    assert first.interval == INTERVAL
    assert first.inputs.max() == pytest.approx(0.3)


def test_a_reading_does_not_depend_on_the_duty_of_its_row() -> None:
    kick = np.array([0.0, 0.0, 1.0, 0.0, 0.0])
    quiet = ReferenceBench(
        thermometer=ReferenceBench().thermometer.with_values({"noise": 0.0, "resolution": 0.0}),
        encoder=ReferenceBench().encoder.with_values({"noise": 0.0, "resolution": 0.0}),
    )
    found = records.record_bench(records.Excitation("kick", kick, 0), quiet).outputs[:, 0]
    assert np.all(found[:3] == quiet.ambient)
    assert found[3] > found[2] + 1e-4


def test_the_paper_s_cadence() -> None:
    made = [records.estimation_duty(), records.validation_duty(), records.slow_duty()]
    lengths = [len(e.duty) * INTERVAL - records.LEAD for e in made]
    assert lengths == pytest.approx([283.5, 163.5, 310.0])
    assert made[0].duty.max() == pytest.approx(0.36)
    assert all(np.all(e.duty[:1000] == 0.0) for e in made)
    assert made[2].duty[1000:].min() == pytest.approx(0.05, abs=1e-4)
    assert made[2].duty[1000:11_000] == pytest.approx(0.06)


def test_stages_are_columns_of_one_record() -> None:
    whole = records.record_bench(SHORT)
    one, two = records.split_stages(whole)
    np.testing.assert_array_equal(one.outputs, two.inputs)
    np.testing.assert_array_equal(two.outputs[:, 0], whole.outputs[:, 1])


@pytest.mark.parametrize("seed", range(5))
def test_sealed_records_are_what_they_should_be(seed: int) -> None:
    made = records.sealed_duty(seed)
    np.testing.assert_array_equal(made.duty, records.sealed_duty(seed).duty)
    percent = 100.0 * made.duty[round(records.LEAD / INTERVAL) :]
    assert 300.0 <= len(percent) * INTERVAL <= 600.0
    held = round(20.0 / INTERVAL)
    assert 5.0 <= percent[0] <= 7.0
    assert np.ptp(percent[:held]) == 0.0
    active = percent[: -round(60.0 / INTERVAL)]
    assert np.all(percent[len(active) :] == 0.0)
    assert 5.0 <= active.min() < active.max() <= 15.0
    rates = np.diff(active[held:]) / INTERVAL
    assert np.abs(rates).min() < np.abs(rates).max() / 2.9
    assert np.abs(rates).max() < 0.301
    turns = np.count_nonzero(np.diff(np.sign(rates[np.abs(rates) > 1e-9])))
    assert 5 <= turns <= 9


def test_seeds_give_other_records_and_benches() -> None:
    assert len(records.sealed_duty(0).duty) != len(records.sealed_duty(1).duty)
    (one, factor), (two, _) = records.sealed_bench(0), records.sealed_bench(1)
    assert one != two
    assert one.fan == factor
    assert 1.5 <= factor <= 3.0
    with pytest.raises(ParameterError, match="at least 0"):
        records.sealed_duty(-1)
