"""The tangent method finds again what was put in.

Cycles that are straight from corner to corner give their corners. Cycles of laws with cosine
kinetics give the intersections of the tangent, at 1/2 - 1/π of each strip, known in closed form;
with noise the same, and 95 % intervals over several stresses hold the truth as often as they say.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from isobaric_cases import Bent, chord, edited, isobar, record
from scipy import stats

from martensite.base.confidence import Interval, interval_contains
from martensite.characterise.tangent_fit import TangentFit, fit_tangents
from martensite.characterise.tangent_lines import CORE
from martensite.characterise.tangent_points import TangentPoints, find_tangent_points
from martensite.characterise.transformation_strain import fit_transformation_strain, saturating_strain
from martensite.physics.laws.brinson import Brinson
from martensite.physics.laws.strip_laws import LiangRogers
from martensite.signals.records import Record

SAMPLE = Bent()
STRESS = 100e6
STRESSES = (50e6, 100e6, 150e6, 200e6)
REPETITIONS = 120
ALLOWED = stats.binom.interval(0.995, REPETITIONS, 0.95)
TEMPERATURES = ("A_s", "A_f", "M_s", "M_f")


# ---------------------------------------------------------------- straight from corner to corner


def off(found: TangentPoints, sample: Bent = SAMPLE, stress: float = STRESS) -> float:
    """Largest distance from the truth of all temperatures [K], and of strains by their size."""
    truth = sample.at(stress) | {"A_half": sample.half(stress, False), "M_half": sample.half(stress, True)}
    kelvins = [abs(getattr(found, name) - value) for name, value in truth.items()]
    residual = sample.residual if found.cycle.cold_start else 0.0
    H = 0.5 * (sample.gap(stress, False) + sample.gap(stress, True))
    strains = [
        (found.H - H) / H,
        (found.residual_strain - residual) / H,
        (found.alpha_A - sample.alpha_A) * 100.0 / H,
        (found.alpha_M - sample.alpha_M) * 100.0 / H,
    ]
    return max(*kelvins, *map(abs, strains))


def uneven() -> Record:
    """Rows ever denser towards the cold, with a hold there; twice the same temperature at times."""
    up = 270.0 + 140.0 * np.linspace(0.0, 1.0, 300) ** 2
    up = np.concatenate([np.full(200, 270.0), np.repeat(up, 2)])
    down = up[::-1]
    strain = [SAMPLE.strain(up, STRESS, False), SAMPLE.strain(down, STRESS, True)]
    return record(np.concatenate([up, down]), np.concatenate(strain), STRESS)


def wandering() -> Record:
    base = SAMPLE.cycle(STRESS)
    swing = 10e6 * np.sin(np.arange(len(base)) * 2.0 * math.pi / 30.0)
    return edited(base, "stress", STRESS + swing)


def spiked() -> Record:
    base = SAMPLE.cycle(STRESS)
    strain = np.array(base["strain"])
    strain[[20, 71, 110, 190, 260]] += 0.03
    return edited(base, "strain", strain)


def turned(timed: bool) -> Record:
    """The same rows from the last to the first, with times that say so or without."""
    base = SAMPLE.cycle(STRESS)
    back = {name: column[::-1] for name, column in base.columns.items()}
    if timed:
        return replace(base, columns=back)
    return replace(base, columns=back | {"time": base.times}, interval=1.0)


def repeated() -> Record:
    """Two cycles, of which the first goes only part of the way through, after a start half-way."""
    colder = replace(SAMPLE, A_s=325.0, A_f=341.0)
    pieces = [colder.cycle(STRESS), SAMPLE.cycle(STRESS)]
    start = np.linspace(330.0, 271.0, 20)
    T = np.concatenate([start, *(p["temperature"] for p in pieces)])
    strain = np.concatenate([SAMPLE.strain(start, STRESS, True), *(p["strain"] for p in pieces)])
    return record(T, strain, STRESS)


@pytest.mark.parametrize(
    "cycle",
    [
        SAMPLE.cycle(STRESS),
        SAMPLE.cycle(STRESS, rows=60),
        SAMPLE.cycle(STRESS, rows=3001),
        SAMPLE.cycle(STRESS, hot_first=True),
        SAMPLE.cycle(STRESS, coldest=310.0, hottest=375.0),
        uneven(),
        wandering(),
        spiked(),
        turned(True),
        turned(False),
        repeated(),
    ],
    ids=[
        "plain",
        "few rows",
        "many rows",
        "hot first",
        "narrow",
        "uneven",
        "wandering stress",
        "spikes",
        "turned",
        "turned without times",
        "second cycle",
    ],
)
def test_corners_are_found(cycle: Record) -> None:
    found = find_tangent_points(cycle)
    assert off(found) < 1e-9
    assert found.stress == pytest.approx(STRESS, rel=1e-3)


def test_what_is_said_of_a_cycle() -> None:
    assert find_tangent_points(SAMPLE.cycle(STRESS)).remarks == ()
    assert "Cycle 2 of 2" in find_tangent_points(repeated()).remarks[0]
    assert off(find_tangent_points(repeated(), cycle=0)) > 1.0
    assert "reverse order" in find_tangent_points(turned(False)).remarks[0]
    few = find_tangent_points(SAMPLE.cycle(STRESS, rows=24)).remarks
    assert len(few) == 2 and "On heating only 3 rows" in few[0]
    short = find_tangent_points(SAMPLE.cycle(STRESS, coldest=316.0)).remarks
    assert len(short) == 1 and "below it: the cold line is uncertain" in short[0]


def test_over_stress() -> None:
    """Slopes, zero-stress temperatures and H exactly, of records in any order of stress."""
    fit = fit_tangents([SAMPLE.cycle(s) for s in (200e6, 50e6, 100e6)])
    assert [points.stress for points in fit.levels] == [50e6, 100e6, 200e6]
    zero = SAMPLE.at(0.0)
    for name in TEMPERATURES:
        assert getattr(fit, name).value == pytest.approx(zero[name], abs=1e-9)
    assert (fit.C_A, fit.C_M) == pytest.approx((SAMPLE.C_A, SAMPLE.C_M), rel=1e-9)
    for direction in (fit.reverse, fit.forward):
        for name, line in direction.own.items():
            assert 1.0 / line.values[1] == pytest.approx(direction.slope, rel=1e-3), name
    guess = fit.guess()
    assert set(guess) == {*TEMPERATURES, "C_A", "C_M", "eps_L", "H_min", "H_sat"}
    assert guess["C_A"] == pytest.approx(SAMPLE.C_A, rel=1e-9)
    mean = sum(SAMPLE.gap(s, way) for s in (50e6, 100e6, 200e6) for way in (True, False)) / 6.0
    assert (guess["eps_L"], fit.eps_L.value) == pytest.approx((mean, mean), rel=1e-9)
    assert fit.remarks == ()
    wider = fit.guess("cosine")
    assert wider["A_s"] + wider["A_f"] == pytest.approx(guess["A_s"] + guess["A_f"])
    width = 0.5 * math.pi * (SAMPLE.M_s - SAMPLE.M_f)
    assert wider["M_s"] - wider["M_f"] == pytest.approx(width, rel=1e-9)


def test_stresses_that_are_given_replace_the_column() -> None:
    cycles = [SAMPLE.cycle(s) for s in (50e6, 100e6)]
    fit = fit_tangents(cycles, stresses=(60e6, 160e6))
    assert fit.C_A == pytest.approx(2.0 * SAMPLE.C_A, rel=1e-9)
    assert fit.reverse.slope_interval() == (-math.inf, math.inf)
    assert fit.A_s.interval() == (-math.inf, math.inf)
    assert "C_A" in fit.guess() and fit.remarks == ()


def test_a_slope_the_wrong_way_is_not_found() -> None:
    cycles = [SAMPLE.cycle(s) for s in (50e6, 100e6, 150e6)]
    fit = fit_tangents(cycles, stresses=(150e6, 100e6, 50e6))
    assert {"C_A", "C_M"} & set(fit.guess()) == set()
    assert [text.split()[0] for text in fit.remarks] == ["C_A", "C_M"]


def test_widths_that_change_with_stress_are_remarked_upon() -> None:
    cycles = [replace(SAMPLE, A_f=SAMPLE.A_f + s / 30e6).cycle(s) for s in STRESSES]
    (remark,) = fit_tangents(cycles).remarks
    assert remark.startswith("A_s and A_f rise differently") and "8 and 6.32 MPa/K" in remark


# ---------------------------------------------------------------- laws with cosine kinetics


LIANG = LiangRogers(
    E_A=60e9, E_M=60e9, Theta=0.0, eps_L=0.045, A_s=330.0, A_f=350.0, M_s=325.0, M_f=303.0, C_A=8e6, C_M=7e6
)
BRINSON = Brinson(
    E_A=60e9,
    E_M=60e9,
    Theta=0.0,
    eps_L=0.067,
    A_s=307.7,
    A_f=322.2,
    M_s=291.4,
    M_f=282.2,
    C_A=13.8e6,
    C_M=8e6,
    sigma_s=100e6,
    sigma_f=170e6,
)


def strips(law: LiangRogers | Brinson, stress: float) -> dict[str, float]:
    """Ends of the strips at a stress; those of Brinson's martensite for stresses above sigma_f."""
    up, down = stress / law.C_A, stress / law.C_M
    ends = {"A_s": law.A_s + up, "A_f": law.A_f + up}
    if isinstance(law, Brinson):
        lines = {"M_s": law.sigma_s, "M_f": law.sigma_f}
        return ends | {name: law.M_s + (stress - s) / law.C_M for name, s in lines.items()}
    return ends | {"M_s": law.M_s + down, "M_f": law.M_f + down}


def cut_off(ends: dict[str, float], share: float) -> dict[str, float]:
    """Temperatures by a share of its width inside each strip."""
    pairs = {"A_s": "A_f", "A_f": "A_s", "M_s": "M_f", "M_f": "M_s"}
    return {name: ends[name] + share * (ends[pairs[name]] - ends[name]) for name in ends}


TANGENT = 0.5 - 1.0 / math.pi
"""Share of a cosine strip that its tangent cuts off."""
CHORD = 0.5 - 1.0 / math.pi / chord(CORE)
"""The same for the line through the middle of the flank."""
CASES = [(LIANG, 120e6, 280.0, 400.0), (BRINSON, 300e6, 260.0, 400.0)]


def farthest(found: TangentPoints, truth: dict[str, float]) -> float:
    """Largest distance from the truth, by the widths of the strips [-]."""
    widths = {"A": truth["A_f"] - truth["A_s"], "M": truth["M_s"] - truth["M_f"]}
    return max(abs(getattr(found, n) - truth[n]) / widths[n[0]] for n in TEMPERATURES)


@pytest.mark.parametrize(("law", "stress", "coldest", "hottest"), CASES)
def test_the_tangent_cuts_off_the_round_ends_of_a_cosine(
    law: LiangRogers | Brinson, stress: float, coldest: float, hottest: float
) -> None:
    ends = strips(law, stress)
    found = find_tangent_points(isobar(law, stress, coldest, hottest))
    assert farthest(found, cut_off(ends, TANGENT)) < 0.012
    assert farthest(found, cut_off(ends, CHORD)) < 0.004
    assert farthest(found, ends) > 0.15  # no strip end is found by a tangent
    assert found.A_half == pytest.approx(0.5 * (ends["A_s"] + ends["A_f"]), abs=0.01)
    assert found.M_half == pytest.approx(0.5 * (ends["M_s"] + ends["M_f"]), abs=0.01)
    assert law.eps_L == pytest.approx(found.H, rel=1e-6)
    assert found.residual_strain == pytest.approx(0.0, abs=1e-9)


def test_the_guess_for_cosines_is_near_the_parameters() -> None:
    cycles = [isobar(LIANG, s, 280.0, 400.0) for s in (50e6, 120e6, 200e6)]
    fit = fit_tangents(cycles)
    guess = fit.guess("cosine")
    for name in TEMPERATURES:
        assert guess[name] == pytest.approx(getattr(LIANG, name), abs=0.3)  # 1.5 % of a width
        assert abs(fit.guess()[name] - getattr(LIANG, name)) > 3.0
    assert guess["C_A"] == pytest.approx(LIANG.C_A, rel=1e-3)
    assert guess["C_M"] == pytest.approx(LIANG.C_M, rel=1e-3)
    assert guess["eps_L"] == pytest.approx(LIANG.eps_L, rel=1e-6)


def test_a_cosine_with_noise() -> None:
    """Within three standard deviations of 20 repetitions, which are about 1 % of a width."""
    clean = isobar(LIANG, 120e6, 280.0, 400.0)
    truth = cut_off(strips(LIANG, 120e6), CHORD)
    strain = np.asarray(clean["strain"])
    found: dict[str, list[float]] = {name: [] for name in TEMPERATURES}
    for seed in range(20):
        noise = np.random.default_rng(seed).normal(0.0, 0.01 * LIANG.eps_L, strain.size)
        points = find_tangent_points(edited(clean, "strain", strain + noise))
        for name in TEMPERATURES:
            found[name].append(getattr(points, name))
    for name, values in found.items():
        error = float(np.std(values)) / math.sqrt(20.0)
        assert 0.02 < error < 0.08
        assert abs(float(np.mean(values)) - truth[name]) < 3.0 * error + 0.05


# ---------------------------------------------------------------- intervals


@pytest.fixture(scope="module")
def fits() -> list[TangentFit]:
    """Four stresses each, with noise of 1 % of the transformation strain."""
    return [
        fit_tangents([SAMPLE.cycle(s, rows=100, noise=0.01, seed=10 * k + i) for i, s in enumerate(STRESSES)])
        for k in range(REPETITIONS)
    ]


def held(fits: list[TangentFit], interval: Callable[[TangentFit], Interval], truth: float, factor: float = 1.0) -> int:
    """How many intervals, made longer by a factor, hold the truth."""
    count = 0
    for fit in fits:
        low, high = interval(fit)
        middle, half = 0.5 * (low + high), 0.5 * factor * (high - low)
        count += interval_contains((middle - half, middle + half), truth)
    return count


@pytest.mark.parametrize("name", TEMPERATURES)
def test_intervals_of_temperatures_hold_the_truth(fits: list[TangentFit], name: str) -> None:
    truth = SAMPLE.at(0.0)[name]
    share = held(fits, lambda fit: getattr(fit, name).interval(), truth)
    assert ALLOWED[0] <= share <= ALLOWED[1]


def test_intervals_of_slopes_hold_the_truth(fits: list[TangentFit]) -> None:
    for interval, truth in (
        (lambda fit: fit.reverse.slope_interval(), SAMPLE.C_A),
        (lambda fit: fit.forward.slope_interval(), SAMPLE.C_M),
    ):
        assert ALLOWED[0] <= held(fits, interval, truth) <= ALLOWED[1]


# ---------------------------------------------------------------- H(σ)


def strains(stresses: tuple[float, ...], *numbers: float) -> list[float]:
    low, high, rate, crit = numbers
    return [saturating_strain(low, high, rate, crit, s) for s in stresses]


MANY = (10e6, 50e6, 100e6, 150e6, 200e6, 300e6, 400e6, 500e6)


@pytest.mark.parametrize(
    ("stresses", "numbers"),
    [
        (MANY, (0.01, 0.05, 1.2e-8, 60e6)),
        (MANY, (0.01, 0.05, 1.2e-8, 0.0)),
        (MANY[:4], (0.0, 0.05, 1.2e-8, 0.0)),
        (MANY[2:7], (0.02, 0.05, 4e-9, 0.0)),
    ],
)
def test_the_saturating_form_is_recovered(stresses: tuple[float, ...], numbers: tuple[float, ...]) -> None:
    fit = fit_transformation_strain(stresses, strains(stresses, *numbers))
    assert fit.form == "saturating" and fit.H_k is not None
    found = fit.H_min.value, fit.H_sat.value, fit.H_k.value * 1e8
    assert found == pytest.approx((*numbers[:2], numbers[2] * 1e8), rel=1e-6, abs=1e-9)
    assert (fit.sigma_crit is not None) == (numbers[3] > 0.0)
    if fit.sigma_crit is not None:
        assert fit.sigma_crit.value == pytest.approx(numbers[3], rel=1e-6)
    assert fit.value(77e6) == pytest.approx(strains((77e6,), *numbers)[0], rel=1e-6)


def test_a_strain_that_does_not_change_is_constant() -> None:
    """Noise is taken for saturation in no more than one of twenty."""
    claimed = 0
    for seed in range(REPETITIONS):
        noise = np.random.default_rng(seed).normal(0.04, 0.001, len(MANY))
        claimed += fit_transformation_strain(MANY, noise.tolist()).form == "saturating"
    assert claimed <= stats.binom.interval(0.9999, REPETITIONS, 0.05)[1]
    flat = fit_transformation_strain(MANY[:3], (0.01, 0.03, 0.04))
    assert (flat.form, flat.H_k) == ("constant", None)
    assert flat.value(1e6) == pytest.approx(0.08 / 3.0)


def test_a_strain_that_does_not_saturate_has_no_intervals() -> None:
    fit = fit_transformation_strain(MANY, [s * 1e-10 for s in MANY])
    assert fit.form == "saturating" and fit.H_sat.value > 0.1
    assert fit.H_sat.interval() == (-math.inf, math.inf)


def test_intervals_of_the_saturating_form_hold_the_truth() -> None:
    truth = {"H_min": 0.01, "H_sat": 0.05, "H_k": 1.2e-8}
    count = dict.fromkeys(truth, 0)
    clean = np.asarray(strains(MANY, *truth.values(), 0.0))
    for seed in range(REPETITIONS):
        noise = np.random.default_rng(seed).normal(0.0, 4e-4, clean.size)
        fit = fit_transformation_strain(MANY, (clean + noise).tolist())
        for name, value in truth.items():
            count[name] += interval_contains(getattr(fit, name).interval(), value)
    assert all(ALLOWED[0] <= share <= ALLOWED[1] for share in count.values()), count
