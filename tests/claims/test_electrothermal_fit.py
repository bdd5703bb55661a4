"""Study `electrothermal-staircase`: what is identified, against straight lines by numpy.

With A_s and A_f free a single plateau between the phases is met whatever they are. What is left
of every shape of R is linear: constants or straight lines through the cold and the hot plateaus,
and V/I = R + V₀/I.
"""

from __future__ import annotations

import math

import numpy as np
import pytest
from claim_checks import numbers_of

from martensite.fit.profiling import profile_likelihood
from martensite.studies.electrothermal import ElectrothermalStaircase, model, record, resistance_numbers
from martensite.studies.electrothermal import heating_fit as heating
from martensite.studies.electrothermal import resistance_fit as fitting
from martensite.studies.electrothermal.record import RecordStaircase
from martensite.studies.tables import printed_numbers

STATED = printed_numbers("electrothermal")
OFFSETS = (fitting.LOWER, STATED.offset, fitting.UPPER)
PER_OHM = math.pi / 4.0 * 0.381e-3**2 / 0.19
pytestmark = pytest.mark.skipif(
    not record.has_files(record.UNTRAINED, record.WARMTH), reason=f"data set {record.DATA} is not on this machine"
)


@pytest.fixture(scope="module")
def listed() -> dict[str, float | None]:
    return numbers_of([ElectrothermalStaircase(STATED).settle_part("resistance")])


@pytest.fixture(scope="module")
def seen() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Set-points [V], currents [A] and apparent temperatures [K] of what the fit has seen."""
    table = RecordStaircase(STATED).table
    names = ("set_point", "current", "apparent_temperature")
    rows = [i for i in range(3, 36) if (i - 3) % 5 != 4]
    volts, amperes, kelvin = (np.array(table[name])[rows] for name in names)
    away = np.abs(volts - 2.3) > 0.01
    return volts[away], amperes[away], kelvin[away]


def test_every_fifth_plateau_is_kept_back() -> None:
    one = fitting.build_experiment("mixture", STATED.offset)
    held = np.array(fitting.compared_column("set_point"))[one.held_out_rows]
    assert held == pytest.approx([1.7, 2.2, 2.7, 3.2, 3.7, 4.2])
    assert [len(one.times), fitting.fit_shape("mixture", STATED.offset).uncertainty.samples] == [33, 27]
    always = [fitting.list_held_out(place) for place in range(fitting.HELD)]
    assert sum(map(len, always)) == 33 - len(fitting.EDGE)


@pytest.mark.parametrize("offset", OFFSETS)
@pytest.mark.parametrize("shape", fitting.SHAPES)
def test_fits_are_lines_through_both_branches(shape: str, offset: float, seen) -> None:
    volts, amperes, kelvin = seen
    ohms, cold, rise = (volts - offset) / amperes, volts < 2.25, kelvin - fitting.T_RHO
    fit, slopes = fitting.fit_shape(shape, offset), fitting.SHAPES[shape]
    left = 0.0
    for name, rows in (("rho_A", ~cold), ("rho_M", cold)):
        sloped = "a_" + name in slopes
        line = np.polyfit(rise[rows], ohms[rows], int(sloped))
        assert fit[name] == pytest.approx(line[-1] * PER_OHM, rel=1e-4)
        if sloped:
            assert fit["a_" + name] == pytest.approx(line[0] / line[1], abs=2e-6)
        left += float(np.sum((np.polyval(line, rise[rows]) - ohms[rows]) ** 2))
    assert fitting.sum_squares(fit) == pytest.approx(left, rel=1e-4)
    assert fitting.residual_rms(fit) == pytest.approx(math.sqrt(left / 27), rel=1e-4)


@pytest.mark.parametrize("shape", ["mixture", "austenite"])
def test_offset_is_that_of_linear_least_squares(shape: str, seen) -> None:
    volts, amperes, kelvin = seen
    cold = (volts < 2.25).astype(float)
    columns = [cold, 1.0 - cold, 1.0 / amperes]
    if shape == "austenite":
        columns.append((1.0 - cold) * (kelvin - fitting.T_RHO))
    found, left, *_ = np.linalg.lstsq(np.stack(columns, axis=1), volts / amperes)
    profile = fitting.offset_of(shape)
    assert profile.value == pytest.approx(found[2], abs=2e-4)
    assert fitting.sum_squares(fitting.fit_shape(shape, profile.value)) == pytest.approx(left[0], rel=1e-3)
    low, high = profile.interval
    assert low < profile.value < high
    assert all(low < offset < high for offset in OFFSETS)


def test_the_step_of_two_slopes_is_free_of_the_offset() -> None:
    def reach(shape: str) -> float:
        steps = [fitting.resistivity_difference(fitting.fit_shape(shape, offset))[0] for offset in OFFSETS]
        assert min(steps) > 0.0
        return max(steps) - min(steps)

    assert reach("both") < 0.05 * reach("mixture")
    assert reach("mixture") > fitting.resistivity_difference(fitting.fit_shape("mixture", STATED.offset))[1]


def test_what_is_not_determined_is_said() -> None:
    fit = fitting.fit_shape("mixture", STATED.offset)
    (weak,) = fit.identifiability.weak
    assert set(weak.names) == {"A_s", "A_f"}
    assert fitting.count_transforming(fit) == 1
    assert resistance_numbers.strip_profile("A_s", STATED.offset).below.reason == "limit"
    stretched = fitting.fit_shape(fitting.STRAINED, STATED.offset)
    (weak,) = stretched.identifiability.weak
    assert set(weak.names) == {"rho_M", "eps_L"}
    resistive = stretched["rho_M"] / stretched["rho_A"]
    whole = resistive * (1.0 + fitting.stretch_share(stretched["eps_L"]))
    assert whole == pytest.approx(fit["rho_M"] / fit["rho_A"], rel=1e-4)


def test_criterion() -> None:
    fit = fitting.fit_shape("both", STATED.offset)
    n, k = 27, 5 + 1  # A_s and A_f count once
    expected = n * math.log(fitting.sum_squares(fit) / n) + 2 * k + 2 * k * (k + 1) / (n - k - 1)
    assert fitting.akaike_criterion(fit) == pytest.approx(expected, rel=1e-12)


def test_kept_back_plateaus_are_predicted(listed: dict[str, float | None]) -> None:
    table = RecordStaircase(STATED).table
    fit = fitting.fit_shape("mixture", STATED.offset)
    rows = [7, 12, 17, 22, 27, 32]
    volts, amperes = (np.array(table[name])[rows] for name in ("set_point", "current"))
    rho = np.where(volts < 2.25, fit["rho_M"], fit["rho_A"])
    apart = rho / PER_OHM - (volts - STATED.offset) / amperes
    expected = math.sqrt(float(np.mean(apart**2)))
    assert listed["fit-held-out"] == pytest.approx(expected, rel=1e-4)
    assert 0.015 < fitting.predicted_rms("mixture", STATED.offset) < expected


# ---------------------------------------------------------------- the electrical way


def test_electrical_way_agrees_where_it_must() -> None:
    fit, other = heating.fit_heating(STATED.offset), fitting.fit_shape("mixture", STATED.offset)
    for name in ("rho_A", "rho_M"):
        low, high = fit.uncertainty.widen_interval(name)
        assert low < other[name] < high
    low, high = fit.uncertainty.widen_interval("h")
    calibrated = model.calibrate_model(RecordStaircase(STATED)).h
    assert max(model.free_films()) * 3.0 < low < calibrated < high


def test_current_does_not_know_another_film() -> None:
    fit = heating.fit_heating(STATED.offset)
    place = list(fit.problem.names).index("h")
    for factor in (0.7, 1.4):
        moved = list(fit.values)
        moved[place] = fit.problem.free[place].share(factor * fit["h"])
        found = fit.problem.evaluate(moved)
        assert found is not None
        assert found.cost > 1.5 * fit.cost


def test_films_of_the_camera_close_the_balance() -> None:
    films, table = heating.apparent_films(STATED.offset), RecordStaircase(STATED).table
    ohms = RecordStaircase(STATED).resistance[20]
    surface = math.pi * 0.381e-3 * 0.19
    lost = films[17] * surface * (table["apparent_temperature"][20] - 298.75)
    assert lost == pytest.approx(table["current"][20] ** 2 * ohms, rel=1e-9)
    assert films[-1] > 2.0 * films[0]


# ---------------------------------------------------------------- claims and words


def _row(shape: str, offset: float) -> str:
    fit = fitting.fit_shape(shape, offset)
    step, half = fitting.resistivity_difference(fit)

    def number(name: str, scale: float) -> str:
        if name not in fit.numbers:
            return "–"
        low, high = fit.uncertainty.widen_interval(name)
        return f"{scale * fit[name]:.1f} ± {0.5 * scale * (high - low):.1f}"

    resistivities = f"{number('rho_A', 1e8)} | {number('rho_M', 1e8)} | {1e8 * step:.1f} ± "
    resistivities += f"{1e8 * half:.1f} | {number('a_rho_A', 1e4)} | {number('a_rho_M', 1e4)}"
    errors = f"{fitting.residual_rms(fit):.3f} Ω | {fitting.residual_rms(fit, 'held-out'):.3f} Ω"
    return f"| {offset:.3f} V | {resistivities} | {errors} |"


def test_readme_has_what_was_identified() -> None:
    text = model.SCENARIO.with_name("README.md").read_text(encoding="utf-8")
    for shape in fitting.SHAPES:
        assert all(_row(shape, offset) in text for offset in OFFSETS)
        best, (low, high) = fitting.offset_of(shape).value, fitting.offset_of(shape).interval
        assert f"{best:.2f} V ({low:.2f} to {high:.2f})" in text
    free = ", ".join(f"{h:.0f}" for h in model.free_films())
    assert f"| {free} |" in text
    lower, middle, upper = (f"{heating.fit_heating(offset)['h']:.0f}" for offset in OFFSETS)
    low, high = profile_likelihood(heating.fit_heating(STATED.offset), "h").interval
    assert f"| {lower}, {middle} (95 %: {low:.0f} to {high:.0f}), {upper} |" in text
    camera = heating.apparent_films(STATED.offset)
    assert f"| {camera[0]:.0f}, {camera[10]:.0f}, {camera[-1]:.0f} |" in text


def test_readme_has_the_numbers_of_its_sentences(listed: dict[str, float | None]) -> None:
    text = " ".join(model.SCENARIO.with_name("README.md").read_text(encoding="utf-8").split())
    computed = {id: number for id, number in listed.items() if number is not None}
    start, end = computed["fit-strip-start"], computed["fit-strip-end"]
    assert f"A_s is above {start:.0f} and A_f below {end:.0f} °C" in text
    austenite, both = computed["aicc-austenite"], computed["aicc-both"]
    assert f"AICc differs by {austenite:.1f} and {both:+.1f} from the plain mixture" in text
    for shape in fitting.SHAPES:
        assert f"RMS is {computed[f'left-out-{shape}']:.3f} Ω for all three" in text
    fit = fitting.fit_shape("mixture", STATED.offset)
    measured = 100.0 * fit["rho_M"] / fit["rho_A"]
    assert f"from {100.0 + computed['geometry']:.1f} to 100 %, of {measured:.1f} to 100" in text
    step, half = fitting.resistivity_difference(fitting.fit_shape("both", STATED.offset))
    assert f"is {1e8 * step:.1f} ± {1e8 * half:.1f} µΩ cm whatever the offset" in text
    heated = heating.fit_heating(STATED.offset)
    for name in ("rho_A", "rho_M"):
        low, high = heated.uncertainty.widen_interval(name)
        assert f"{1e8 * heated[name]:.1f} ± {0.5e8 * (high - low):.1f}" in text
    assert f"with an RMS of {fitting.residual_rms(heated):.3f} A" in text
