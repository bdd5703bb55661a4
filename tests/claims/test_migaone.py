"""Study `migaone`: claims against numbers found for this project by code not shared with it.

The reference numbers come from a separate solution of the same equations (branch-wise
differential equations and root finding), given here to the digits it was noted with.
"""

from __future__ import annotations

from pathlib import Path

import pytest
from claim_checks import check_complete, check_decides, check_shipped, numbers_of, verdicts_of

from martensite.base.errors import DataError
from martensite.characterise.film_coefficient import film_r_squared
from martensite.simulate.result import Result
from martensite.studies.base import AbstractStudy, Answer, load_study
from martensite.studies.migaone import bench, film_numbers, motion_numbers, wire_numbers
from martensite.studies.tables import printed_numbers

PRINTED = printed_numbers("migaone")
COEFFICIENTS = PRINTED.h0, PRINTED.h1, PRINTED.h2
VERDICTS = {
    "reproduced": {"volume-of-misprint", "steady-1.0V", "steady-1.5V", "steady-2.0V", "steady-2.5V"},
    "disagrees": {"fit"},
    "misprint": {"diameter", "surface"},
    "self-contradictory": {"resistance", "r-squared"},
    "not comparable": {"actuation-time"},
    "recovery": {"length", "resistance-series"},
}


@pytest.fixture(scope="module")
def study() -> AbstractStudy:
    return load_study("migaone")


@pytest.fixture(scope="module")
def answer(study: AbstractStudy) -> Answer:
    return study.compute()


# ---------------------------------------------------------------- verdicts


def test_verdicts(answer: Answer) -> None:
    assert verdicts_of(answer.claims) == VERDICTS
    check_complete(answer)
    check_decides(answer.claims)


def test_what_ships_is_what_is_computed(study: AbstractStudy) -> None:
    check_shipped(study)


def test_the_digest_has_the_computed_numbers(answer: Answer) -> None:
    assert "0.381 mm, not 0.038 mm" in answer.digest["misprinted"]
    assert "no parabola exceeds 0.9890" in answer.digest["contradicts_itself"]


# ---------------------------------------------------------------- the wire


def test_geometry_and_resistance(answer: Answer) -> None:
    wire = bench.base_wire()
    assert wire.diameter == pytest.approx(PRINTED.diameter_in_text)
    assert wire.length == pytest.approx(wire_numbers.printed_length(PRINTED), abs=0.5e-3)
    assert wire.surface() == pytest.approx(3.27e-4, abs=0.005e-4)
    assert wire.surface() / PRINTED.surface == pytest.approx(10.0, rel=0.005)
    assert wire.section() * wire.length / PRINTED.volume == pytest.approx(100.0, rel=0.005)
    powers = [bench.heating_power(step, PRINTED) for step in PRINTED.steps]
    assert powers[0] == pytest.approx(0.143, abs=5e-4)
    assert powers[-1] == pytest.approx(1.021, abs=3e-3)  # noted for a length of 272.5 mm
    assert bench.equivalent_resistance(1.0, PRINTED) == pytest.approx(7.0, abs=0.05)
    assert numbers_of([answer])["resistance"] == pytest.approx(6.1, abs=0.05)
    series = [wire_numbers.series_resistance(v, PRINTED) for v in (1.0, 2.5)]
    assert series == pytest.approx([1.65, 1.36], abs=0.01)


def test_scenario_says_what_the_paper_does() -> None:
    scenario = bench.load_scenario()
    assert bench.read_number("environment.temperature") == pytest.approx(PRINTED.ambient + bench.ZERO)
    coefficients = tuple(bench.read_number(f"cooling.h{k}") for k in range(3))
    assert coefficients == pytest.approx(COEFFICIENTS)
    wire = bench.base_wire()
    ohms = bench.read_number("rho_M") * wire.length / wire.section()
    assert ohms == pytest.approx(PRINTED.resistance, abs=0.01)
    assert bench.read_number("series_resistance") == pytest.approx(
        wire_numbers.series_resistance(2.5, PRINTED), abs=0.005
    )
    assert scenario.single_waveform.value(100.0) == pytest.approx(PRINTED.steps[-1].voltage)


def test_scenario_moves_and_returns() -> None:
    run = bench.load_scenario().run()
    assert isinstance(run, Result)
    assert 6e-3 < run.stroke < 8e-3
    assert run["position"][-1] == pytest.approx(0.0, abs=1e-6)
    assert run["stress"][0] == pytest.approx(34.4e6, abs=0.05e6)


# ---------------------------------------------------------------- h(T)


def test_fits() -> None:
    full, even, line = (
        fit(PRINTED) for fit in (film_numbers.fit_quadratic, film_numbers.no_linear, film_numbers.fit_straight)
    )
    assert full.coefficients == pytest.approx((30.729, 0.34525, 4.701e-4), rel=3e-5)
    assert even.coefficients == pytest.approx((41.888, 0.0, 0.0030103), rel=3e-5)
    assert line.coefficients == pytest.approx((28.692, 0.40871), rel=3e-5)
    found = [fit.r_squared for fit in (full, even, line)]
    assert found == pytest.approx([0.98896, 0.98417, 0.98879], abs=6e-6)
    adjusted = [fit.adjusted for fit in (full, even, line)]
    assert adjusted == pytest.approx([0.967, 0.976, 0.983], abs=6e-4)
    assert film_numbers.printed_r_squared(PRINTED) == pytest.approx(0.98090, abs=6e-6)


def test_no_parabola_beats_the_fit() -> None:
    best = film_numbers.fit_quadratic(PRINTED)
    for k in range(3):
        for factor in (0.999, 1.001):
            moved = [c * (factor if i == k else 1.0) for i, c in enumerate(best.coefficients)]
            r_squared = film_r_squared(PRINTED.steps.column("temperature"), PRINTED.steps.column("film"), moved)
            assert r_squared < best.r_squared < PRINTED.r_squared


def root_of_balance(power: float, surface: float, coefficients: tuple[float, ...]) -> float:
    """Steady temperature [°C] by bisection of P = h(T) S (T - T_a)."""
    low, high = PRINTED.ambient, 200.0
    for _ in range(60):
        middle = 0.5 * (low + high)
        h = sum(c * middle**k for k, c in enumerate(coefficients))
        low, high = (middle, high) if h * surface * (middle - PRINTED.ambient) < power else (low, middle)
    return low


def test_steady_temperatures() -> None:
    errors = film_numbers.steady_errors("polynomial", PRINTED)
    assert max(map(abs, errors)) < 0.3
    for step, error in zip(PRINTED.steps, errors, strict=True):
        power = bench.heating_power(step, PRINTED)
        root = root_of_balance(power, bench.base_wire().surface(), COEFFICIENTS)
        assert step.temperature + error == pytest.approx(root, abs=1e-3)
    assert max(map(abs, film_numbers.steady_errors("refitted", PRINTED))) < 0.45
    mean = film_numbers.steady_errors("constant", PRINTED)
    assert max(mean, key=abs) == pytest.approx(7.7, abs=0.05)


# ---------------------------------------------------------------- motion


@pytest.mark.parametrize(
    ("key", "hottest", "rise", "fall", "stroke"),
    [
        ("polynomial", 82.0, 98.7, 165.2, 6.70),
        ("constant", 86.8, 95.3, 167.9, 8.0),
        ("paper", 86.8, 82.8, 151.8, 8.0),
        ("one-curve", 86.8, 82.8, 122.1, 8.0),
    ],
)
def test_sine(key: str, hottest: float, rise: float, fall: float, stroke: float) -> None:
    """The reference has stroke proportional to 1 - ξ; here 0.2 mm of it is elastic."""
    found = bench.read_response(key, PRINTED)
    assert found.hottest == pytest.approx(hottest, abs=0.1)
    assert found.rise == pytest.approx(rise, abs=0.25)
    assert found.fall == pytest.approx(fall, abs=0.25)
    assert 1e3 * found.stroke == pytest.approx(stroke, abs=0.05)


def test_actuation_time() -> None:
    """The reference is for a room of 25 °C, and to two digits."""
    assert motion_numbers.fastest_time(PRINTED) == pytest.approx(0.38, abs=0.01)
    assert motion_numbers.slowest_time(PRINTED) == pytest.approx(1.7, abs=0.05)
    assert motion_numbers.thin_wire_time(PRINTED, motion_numbers.ROOM) == pytest.approx(0.016, abs=0.0005)
    here = bench.actuation_time(PRINTED, PRINTED.ambient)
    assert motion_numbers.fastest_time(PRINTED) < here < motion_numbers.slowest_time(PRINTED)


# ---------------------------------------------------------------- the study


def test_figure(tmp_path) -> None:
    study = load_study("migaone")
    study.figure(tmp_path / "migaone.png")
    assert (tmp_path / "migaone.png").read_bytes().startswith(b"\x89PNG")
    with pytest.raises(DataError, match="suffix"):
        study.figure(tmp_path / "migaone.txt")
    with pytest.raises(DataError, match="does not exist"):
        study.figure(tmp_path / "absent" / "migaone.png")


def test_readme_has_the_computed_numbers() -> None:
    text = Path(bench.__file__).with_name("README.md").read_text(encoding="utf-8")
    for key in bench.VARIANTS:
        r = bench.read_response(key, PRINTED)
        row = f"| {r.hottest:.1f} °C | {r.rise:.1f} s | {r.fall:.1f} s | {1e3 * r.stroke:.2f} mm |"
        assert row in text
    even, line = film_numbers.no_linear(PRINTED), film_numbers.fit_straight(PRINTED)
    h0, _, h2 = even.coefficients
    assert f"| {h0:.3f}, 0, {h2:.7f} | {even.r_squared:.5f} |" in text
    assert f"| {line.coefficients[0]:.3f}, {line.coefficients[1]:.5f}, 0 |" in text
    assert f"about 1 s: {bench.actuation_time(PRINTED, PRINTED.ambient):.2f} s" in text
    fastest = motion_numbers.fastest_time(PRINTED)
    spread = f"{fastest:.2f} to {motion_numbers.slowest_time(PRINTED):.2f} s"
    assert spread in text
    mean = film_numbers.steady_errors("constant", PRINTED)
    assert "{:+.1f}, {:+.1f}, {:+.1f} and {:+.1f} K".format(*mean) in text
