"""Cutting isobaric records into branches, and one clear sentence for what is none.

Source of truth: how the records were put together, and the documented sentences.
"""

from __future__ import annotations

import math
import re
from dataclasses import replace

import numpy as np
import pytest
from isobaric_cases import Bent, edited, record

from martensite.base.errors import DataError, ParameterError
from martensite.characterise.isobaric_cycles import cut_cycle, find_turning_points
from martensite.characterise.straight_lines import average_cells, fit_isotonic, fit_line, fit_three_lines, smooth_median
from martensite.characterise.tangent_fit import fit_tangents
from martensite.characterise.tangent_points import find_tangent_points
from martensite.characterise.transformation_strain import fit_transformation_strain
from martensite.signals.records import Record

SAMPLE = Bent()
STRESS = 100e6
CYCLE = SAMPLE.cycle(STRESS)
UP = np.linspace(300.0, 400.0, 30)
DOWN = UP[::-1]


def said(base: Record, **options: float) -> str:
    with pytest.raises((DataError, ParameterError)) as caught:
        find_tangent_points(base, **options)  # type: ignore[arg-type]
    return str(caught.value)


def changed(**columns: object) -> Record:
    """The cycle with other columns."""
    base = CYCLE
    for name, values in columns.items():
        base = edited(base, name, values)
    return base


# ---------------------------------------------------------------- cutting


@pytest.mark.parametrize(
    ("pieces", "turns"),
    [
        ((UP, DOWN), [0, 29, 59]),
        ((DOWN, UP), [0, 29, 59]),
        ((UP, DOWN, UP), [0, 29, 59, 89]),
        ((UP[15:0:-1], UP, DOWN), [15, 44, 74]),
        ((UP, UP[:18:-1], UP[19:], DOWN), [0, 51, 81]),
        ((UP, DOWN, UP[:12]), [0, 29, 59]),
        ((UP, DOWN[:12]), [0, 29]),
        ((np.full(40, 300.0),), []),
    ],
)
def test_turning_points(pieces: tuple[np.ndarray, ...], turns: list[int]) -> None:
    found = find_turning_points(np.concatenate(pieces).tolist())
    temperatures = np.concatenate(pieces)
    assert temperatures[found] == pytest.approx(temperatures[turns])
    assert len(found) == len(turns)
    noise = np.random.default_rng(1).normal(0.0, 0.8, temperatures.size)
    if turns:
        rough = find_turning_points((temperatures + noise).tolist())
        assert np.abs(np.asarray(rough) - turns).max() <= 22  # within a hold or a small reversal
        assert len(rough) == len(turns)


def test_a_cycle_is_cut_and_named() -> None:
    cut = cut_cycle(SAMPLE.cycle(STRESS, rows=40))
    assert (cut.number, cut.cycles, cut.cold_start, cut.timed) == (1, 1, True, True)
    assert len(cut.heating.temperature) == 40 and len(cut.cooling.temperature) == 41
    assert cut.heating.temperature[0] == cut.cooling.temperature[-1] == 270.0
    other = cut_cycle(SAMPLE.cycle(STRESS, rows=40, hot_first=True))
    assert not other.cold_start
    assert other.heating.temperature[-1] == other.cooling.temperature[0] == 410.0


def test_the_stress_of_a_cycle() -> None:
    wandering = changed(stress=STRESS + 10e6 * np.sin(np.arange(len(CYCLE))))
    cut = cut_cycle(wandering)
    assert cut.stress == pytest.approx(STRESS, rel=2e-3)
    assert cut.stress_deviation == pytest.approx(10e6 / math.sqrt(2.0), rel=2e-2)
    assert cut.remarks == ()
    assert cut_cycle(wandering, stress=70e6).stress == 70e6
    rising = changed(stress=np.linspace(0.0, 2.0 * STRESS, len(CYCLE)))
    assert "is the cycle isobaric?" in cut_cycle(rising).remarks[0]
    assert cut_cycle(changed(stress=np.zeros(len(CYCLE)))).stress == 0.0


# ---------------------------------------------------------------- lines


def test_isotonic_regression_is_the_nearest_monotone_sequence() -> None:
    """Against SciPy, which shares no code, and for what is monotone already."""
    from scipy.optimize import isotonic_regression

    noise = np.random.default_rng(3).normal(0.0, 1.0, 200) + np.linspace(0.0, 3.0, 200)
    assert fit_isotonic(noise) == pytest.approx(isotonic_regression(noise).x)
    rising = np.sort(noise)
    assert fit_isotonic(rising) == pytest.approx(rising)
    assert smooth_median(rising) == pytest.approx(rising)


def test_means_of_cells_stay_on_a_line() -> None:
    x = np.sort(np.random.default_rng(5).uniform(300.0, 400.0, 500))
    t, e = average_cells(x, 0.04 - 1e-4 * (x - 300.0), 20)
    assert len(t) == 20
    assert e == pytest.approx(0.04 - 1e-4 * (t - 300.0), abs=1e-15)


def test_a_line_leaves_spikes_out_and_three_lines_find_corners() -> None:
    t = np.arange(300.0, 390.0)
    e = np.where(t < 330.0, 0.04, np.where(t >= 350.0, 0.0, 0.04 - 0.002 * (t - 329.5)))
    cold, steep, hot = fit_three_lines(t, e)
    assert (cold.rows, steep.rows, hot.rows) == (30, 20, 40)
    assert steep.slope == pytest.approx(-0.002)
    assert steep.meets(cold) == pytest.approx(329.5)
    assert cold.meets(cold) == math.inf
    e[[3, 11]] += 0.02
    spiked = fit_line(t, e, slice(0, 30))
    assert (spiked.rows, spiked.slope) == (28, pytest.approx(0.0, abs=1e-12))
    assert fit_line(t, e, slice(0, 9)).rows == 9  # too few to tell


# ---------------------------------------------------------------- what is wrong, in words


@pytest.mark.parametrize(
    ("base", "sentence"),
    [
        (SAMPLE.cycle(STRESS, rows=9), "18 rows, but a heating-cooling cycle needs at least 20"),
        (changed(temperature=np.asarray(CYCLE["temperature"]) - 273.15), "between 150 and 1500 K"),
        (changed(temperature=1e3 * np.asarray(CYCLE["temperature"])), "by 10^3"),
        (changed(strain=CYCLE["temperature"]), "within 0.5; is its unit off"),
        (changed(strain=100.0 * np.asarray(CYCLE["strain"])), "percent"),
        (changed(stress=np.full(len(CYCLE), 100.0)), "stress of record `cycle` is 100 Pa"),
        (changed(stress=np.full(len(CYCLE), 1e11)), "are columns swapped?"),
        (changed(strain=np.full(len(CYCLE), 0.02)), "No transformation found in `cycle` on"),
        (changed(strain=1e-5 * np.asarray(CYCLE["temperature"])), "No transformation found"),
        (changed(strain=-np.asarray(CYCLE["strain"])), "change the sign of the strain"),
        (SAMPLE.cycle(STRESS, hottest=352.0), "no straight hot part (austenite) beyond it; heat"),
        (SAMPLE.cycle(STRESS, coldest=332.0), "no straight cold part (martensite) beyond it; cool"),
        (record(UP, 0.01 + 0.0 * UP, STRESS), "no full cycle: its temperature only rises"),
        (record(DOWN, 0.01 + 0.0 * UP, STRESS), "no full cycle: its temperature only falls"),
        (record(0.01 * UP + 300.0, 0.0 * UP, STRESS), "stays between 303 and 304 K"),
        (record([*UP, 301.0, 300.0], np.zeros(32), STRESS), "only 3 rows on cooling"),
        (changed(strain=[math.nan] + [0.0] * (len(CYCLE) - 1)), "`strain` of record `cycle` must"),
        (changed(stress=[math.inf] * len(CYCLE)), "`stress` of record `cycle` must be finite"),
    ],
)
def test_what_is_no_isobaric_cycle(base: Record, sentence: str) -> None:
    text = said(base)
    assert sentence in text
    assert text.endswith((".", "?")) and "\n" not in text


def test_noise_alone_is_no_transformation() -> None:
    for seed in range(20):
        noise = np.random.default_rng(seed).normal(0.0, 1e-3, len(CYCLE))
        text = said(changed(strain=0.02 + noise))
        assert re.match("No transformation|The transformation", text), text


def test_missing_columns_and_wrong_arguments() -> None:
    names = ("time", "temperature", "strain")
    bare = Record("bare", {n: CYCLE.columns[n] for n in names}, {n: CYCLE.units[n] for n in names})
    assert "has no column `stress`: give the constant stress" in said(bare)
    assert find_tangent_points(bare, stress=STRESS).stress == STRESS
    names = ("time", "temperature")
    bare = Record("bare", {n: CYCLE.columns[n] for n in names}, {n: CYCLE.units[n] for n in names})
    assert "no column `strain`" in said(bare)
    assert "from -1 to 0, since record `cycle` has 1 full cycle, but is 1" in said(CYCLE, cycle=1)
    assert "must be finite" in said(CYCLE, stress=math.nan)


def test_a_loop_that_runs_backwards_in_time() -> None:
    """With times of its own a record is not turned round."""
    back = {name: column[::-1] for name, column in CYCLE.columns.items()}
    base = replace(CYCLE, columns=back | {"time": CYCLE.times})
    assert "lower temperature on heating" in said(base)


def test_fits_need_two_stresses() -> None:
    one = find_tangent_points(CYCLE)
    for cycles, sentence in (
        ([one], "but there is only one, at 100 MPa"),
        ([CYCLE, one], "but there are 2, all at 100 MPa"),
        ([], "but there are none;"),
    ):
        with pytest.raises(DataError, match="two or more different stresses") as caught:
            fit_tangents(cycles)
        assert sentence in str(caught.value)
    with pytest.raises(ParameterError, match="one stress per record, but there are 1 and 2"):
        fit_tangents([CYCLE, CYCLE], stresses=[1e8])
    fit = fit_tangents([CYCLE, SAMPLE.cycle(2e8)])
    with pytest.raises(ParameterError, match="Did you mean `cosine`"):
        fit.guess("cosines")
    with pytest.raises(DataError, match="one transformation strain per stress"):
        fit_transformation_strain([1e8], [])
