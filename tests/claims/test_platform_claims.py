"""Study `platform`: claims against numbers found by code that the study does not use.

Sources of truth: a root and an integral over the heating path (`platform_reference`), matrices for
the kinematics, the bound on the ratio of the response times, and the numbers noted for this project
from separate programs.
"""

from __future__ import annotations

import math
import re
from dataclasses import replace

import pytest
from claim_checks import check_complete, check_decides, check_shipped, numbers_of, verdicts_of
from platform_cases import PLATES, about_x, about_y, by_matrices
from platform_reference import Platform as Reference
from platform_reference import bisected

from martensite.simulate.result import Result
from martensite.studies import readings
from martensite.studies.base import AbstractStudy, Answer, load_study
from martensite.studies.platform import Platform, bench, control_numbers, equation_numbers, loop, response_numbers
from martensite.studies.platform.bench import AS_PRINTED, CASES, IN_SERIES, VARIANTS, Case
from martensite.studies.tables import printed_numbers

PRINTED = printed_numbers("platform")
VERDICTS = {
    "reproduced": {"centroid", "contraction", "spring-mass"},
    "disagrees": {"time-5V", "time-3V"},
    "misprint": {"lever", "eq8"},
    "self-contradictory": {"current", "both-times", "limited-angle"},
    "recovery": {f"set-{name}-{volts}V" for name in ("A", "A2", "C") for volts in (5, 3)},
}
AT_25, AT_30 = math.radians(25.0), math.radians(30.0)


@pytest.fixture(scope="module")
def study() -> AbstractStudy:
    return load_study("platform")


@pytest.fixture(scope="module")
def answer(study: AbstractStudy) -> Answer:
    return study.compute()


@pytest.fixture(scope="module")
def listed(answer: Answer) -> dict[str, float | None]:
    return numbers_of([answer])


def computed(listed: dict[str, float | None], id: str) -> float:
    number = listed[id]
    assert number is not None
    return number


def reference(case: Case, volts: float) -> Reference:
    """The same case for the integral."""
    limit = case.limits[0 if volts >= PRINTED.high else 1]
    plain = Reference()
    return replace(
        plain,
        film=case.film,
        series=case.series,
        limit=limit,
        volts=volts,
        capacity=plain.capacity if case.capacity is None else case.capacity,
        latent=plain.latent if case.latent is None else case.latent,
        coil=case.coil or plain.coil,
        slope=case.slope or plain.slope,
    )


# ---------------------------------------------------------------- verdicts


def test_verdicts(answer: Answer) -> None:
    assert verdicts_of(answer.claims) == VERDICTS
    check_complete(answer)
    check_decides(answer.claims)


def test_what_ships_is_what_is_computed(study: AbstractStudy) -> None:
    check_shipped(study)


# ---------------------------------------------------------------- geometry


def test_lengths(listed: dict[str, float | None]) -> None:
    for degrees in (25.0, 30.0):
        hot, cold, _ = by_matrices(PLATES, about_x(math.radians(degrees)))
        assert computed(listed, f"length-{degrees:.0f}-hot") == pytest.approx(1e3 * hot, abs=1e-6)
        assert computed(listed, f"length-{degrees:.0f}-cold") == pytest.approx(1e3 * cold, abs=1e-6)


def test_order_of_rotations(listed: dict[str, float | None]) -> None:
    both = by_matrices(PLATES, about_y(AT_25) @ about_x(AT_25))
    swapped = by_matrices(PLATES, about_x(AT_25) @ about_y(AT_25))
    most = 1e3 * max(abs(both - swapped))
    assert computed(listed, "rotation-order") == pytest.approx(most, abs=1e-6)


def test_stroke_reach_and_vibration(listed: dict[str, float | None]) -> None:
    plain = Reference()
    assert computed(listed, "contraction") == pytest.approx(1e3 * plain.contraction(0.0), abs=1e-6)
    assert computed(listed, "contraction") == pytest.approx(30.38, abs=0.005)
    assert computed(listed, "full-angle") == pytest.approx(33.68, abs=0.005)
    reach = [computed(listed, f"reach-{way}") for way in ("alpha-low", "alpha-high", "beta-low", "beta-high")]
    assert reach == pytest.approx([-30.87, 33.06, -36.14, 36.14], abs=0.006)
    assert computed(listed, "natural-frequency") == pytest.approx(30.7, abs=0.05)
    assert computed(listed, "rate-cold") == pytest.approx(232.3, abs=0.05)
    assert computed(listed, "one-at-a-time") == pytest.approx(120.0, abs=0.01)
    assert computed(listed, "inertia") == pytest.approx(3.125e-5, rel=1e-12)


def test_equation_8_as_printed() -> None:
    found = [equation_numbers.equation_8(PRINTED, t) for t in (PRINTED.M_f, PRINTED.M_s)]
    assert found == pytest.approx([0.75, -0.25])
    assert equation_numbers.equation_8(PRINTED, PRINTED.M_f, 1.0) == 0.0


# ---------------------------------------------------------------- response times


@pytest.mark.parametrize("volts", [5.0, 3.0])
@pytest.mark.parametrize("name", [*VARIANTS, *IN_SERIES])
def test_readings_agree_with_the_integral(name: str, volts: float) -> None:
    case = (VARIANTS | IN_SERIES)[name]
    found = dict(zip((5.0, 3.0), response_numbers.free_times(case, PRINTED), strict=True))
    plain = reference(case, volts)
    if case.film == 0.0:
        plain = replace(plain, film=1e-6)  # the integral divides by it
    assert found[volts] == pytest.approx(plain.arrival(AT_25), abs=1e-3)


@pytest.mark.parametrize("key", ["A", "A'"])
def test_calibrated_sets_agree_with_the_integral(key: str) -> None:
    """To 0.1 ms; and they are calibrated."""
    for angle, at in ((PRINTED.angle, AT_25), (PRINTED.target, AT_30)):
        found = response_numbers.response_times(key, PRINTED, angle)
        expected = [reference(CASES[key], volts).arrival(at) for volts in (5.0, 3.0)]
        assert found == pytest.approx(expected, abs=1e-4)
    times = response_numbers.response_times(key, PRINTED, PRINTED.angle)
    assert times == pytest.approx((PRINTED.fast, PRINTED.slow), abs=0.01)


def test_no_reading_is_below_the_bound() -> None:
    """t(3 V)/t(5 V) ≥ 25/9 with equality without heat loss."""
    found = response_numbers.time_ratios(PRINTED)
    assert set(found) == {*VARIANTS, *IN_SERIES}
    assert min(found.values()) >= 25 / 9 - 1e-5
    assert found["no heat loss"] == pytest.approx(25 / 9, abs=1e-5)
    lossy = [ratio for name, ratio in found.items() if name != "no heat loss"]
    assert min(lossy) > 25 / 9 + 0.05


def test_current_limit(listed: dict[str, float | None]) -> None:
    stalled = Reference(limit=2.5)
    theta = bisected(lambda t: -stalled.surplus(t), 0.0, math.pi)
    angle = math.degrees(stalled.angle(math.cos(theta / 2) ** 2))
    assert computed(listed, "limited-angle") == pytest.approx(angle, abs=1e-3)
    assert angle == pytest.approx(18.64, abs=0.005)
    needed = bisected(lambda i: Reference(limit=i).surplus(Reference().theta_at(AT_25)), 1.0, 5.0)
    assert computed(listed, "needed-current") == pytest.approx(needed, abs=1e-4)
    assert needed == pytest.approx(2.803, abs=5e-4)
    assert computed(listed, "ratio-limited") == pytest.approx(1.0, abs=1e-12)


def test_just_less_current_stalls_and_just_more_arrives() -> None:
    """The needed current by long runs, against the balance of heat that the claim uses."""
    needed = response_numbers.needed_current(PRINTED)
    for share, arrives in ((0.995, False), (1.005, True)):
        case = replace(AS_PRINTED, limits=(share * needed, share * needed))
        time = bench.arrival_time(case, PRINTED, PRINTED.high, PRINTED.angle, 200.0, 0.05)
        assert math.isfinite(time) == arrives


def test_path_and_unit_of_the_stress_factor(listed: dict[str, float | None]) -> None:
    for angle, at, noted in ((25, AT_25, 76.0), (30, AT_30, 86.5)):
        theta = Reference().theta_at(at)
        found = computed(listed, f"path-MPa-{angle}")
        assert found == pytest.approx(Reference().temperature(theta), abs=2e-3)
        assert found == pytest.approx(noted, abs=0.06)
        steep = Reference(slope=1e9).temperature(theta)
        assert computed(listed, f"path-GPa-{angle}") == pytest.approx(steep, abs=2e-3)


def test_set_c(listed: dict[str, float | None]) -> None:
    assert computed(listed, "set-C-5V") == pytest.approx(18.0, abs=0.01)
    assert computed(listed, "set-C-3V") == pytest.approx(31.2, abs=0.06)
    result = bench.run_heated(CASES["C"], PRINTED, 5.0, bench.RISE, bench.FINE)
    assert max(result["first.temperature"]) - bench.ZERO > 300.0


def test_cooling(listed: dict[str, float | None]) -> None:
    found = [computed(listed, f"cooling-{name}") for name in ("hold", "10", "20")]
    assert found == pytest.approx([7.1, 18.1, 30.6], abs=0.1)


# ---------------------------------------------------------------- control


def test_limit_cycle() -> None:
    """Within two samples of 20 ms of what was found in steps of 5 ms."""
    first, period, on = control_numbers.limit_cycle(PRINTED)
    assert first == pytest.approx(reference(CASES["A"], 5.0).arrival(AT_30), abs=0.02)
    assert period == pytest.approx(16.63, abs=0.04)
    assert on == pytest.approx(8.94, abs=0.04)


def test_overshoot_follows_the_heating_path(listed: dict[str, float | None]) -> None:
    """Without inertia the angle goes on as it would have, for delay and sampling."""
    for key, id, sampling in (
        ("as-printed", "overshoot-printed-late", loop.QUICK),
        ("A", "overshoot-A-late", loop.CYCLES),
    ):
        plain = reference(CASES[key], 5.0)
        reached = plain.arrival(math.radians(PRINTED.target + computed(listed, id)))
        late = reached - plain.arrival(AT_30) - loop.DELAY
        assert -1e-3 < late < sampling.period + 1e-3


def test_what_overshoots_and_what_does_not(listed: dict[str, float | None]) -> None:
    prompt = [computed(listed, f"overshoot-{key}") for key in ("printed", "A", "printed-dynamic")]
    assert max(prompt) < 0.2
    assert prompt[2] > prompt[0]
    assert computed(listed, "overshoot-C") == pytest.approx(2.5, abs=0.05)


# ---------------------------------------------------------------- scenario, study, pages


def test_scenario_is_set_a() -> None:
    result = bench.load_scenario().run()
    assert isinstance(result, Result)
    when = readings.passing_time(result.times, bench.angle_degrees(result), PRINTED.angle)
    assert when == pytest.approx(PRINTED.fast, abs=0.02)
    assert max(bench.angle_degrees(result)) == pytest.approx(30.06, abs=0.02)
    assert result["alpha"][-1] < math.radians(2.0)


def test_springs_are_free_of_force_and_weigh_what_is_printed() -> None:
    for case in (AS_PRINTED, VARIANTS["6 mm mean coil diameter"]):
        spring = bench.build_spring(case, PRINTED)
        assert spring.mass() == pytest.approx(PRINTED.spring_mass)
        ends = [spring.resistance.value_of(n) * spring.wire_length() / spring.section() for n in ("rho_A", "rho_M")]
        assert ends == pytest.approx([PRINTED.R_A, PRINTED.R_M])
    rest = bench.build_machine(AS_PRINTED, PRINTED)
    run = bench.run_heated(AS_PRINTED, PRINTED, 0.0, 0.1)
    assert max(abs(run[f"{port}.force"][-1]) for port in rest.actuators()) == 0.0


def test_plain_floats_serve_where_there_is_no_compiler(monkeypatch: pytest.MonkeyPatch, c_compiler: str) -> None:
    assert readings.choose_runtime() == "c"
    monkeypatch.setattr(readings, "find_compiler", lambda: None)
    assert readings.choose_runtime() == "floats"


def test_figure(tmp_path) -> None:
    study = Platform()
    study.figure(tmp_path / "platform.png")
    assert (tmp_path / "platform.png").read_bytes().startswith(b"\x89PNG")


def test_readme_has_the_computed_numbers(listed: dict[str, float | None]) -> None:
    text = bench.SCENARIO.with_name("README.md").read_text(encoding="utf-8")
    assert f"{computed(listed, 'contraction'):.2f} mm at {computed(listed, 'full-angle'):.2f}°" in text
    fast, slow = (computed(listed, f"time-{v}V") for v in (5, 3))
    assert f"would take {fast:.2f} s and {slow:.2f} s" in text
    both = [response_numbers.free_times(case, PRINTED) for case in VARIANTS.values()]
    fasts, slows = zip(*both, strict=True)
    spread = f"{min(fasts):.2f} to {max(fasts):.2f} s and {min(slows):.2f} to {max(slows):.2f} s"
    assert spread in re.sub(r"\s+", " ", text)
    assert f"stalls at {computed(listed, 'limited-angle'):.2f}°" in text
    assert f"{computed(listed, 'needed-current'):.3f} A" in text
    for key, short in (("A", "A"), ("A'", "A2")):
        early = " / ".join(f"{t:.2f}" for t in response_numbers.response_times(key, PRINTED, 25.0))
        late = " / ".join(f"{t:.2f}" for t in response_numbers.response_times(key, PRINTED, 30.0))
        row = next(line for line in text.splitlines() if line.startswith(f"| {key}:"))
        assert f"| {early} s | {late} s |" in row, short
    for key, row in (
        ("printed", "as printed | none"),
        ("printed-late", "as printed | 0.3 s"),
        ("printed-dynamic", "as printed, with inertia, undamped | none"),
        ("A", "set A | none"),
        ("A-late", "set A | 0.3 s"),
        ("C", "set C | none"),
    ):
        assert f"| {row} | {computed(listed, f'overshoot-{key}'):.2f}° |" in text
    first, period, on = control_numbers.limit_cycle(PRINTED)
    assert f"first off after {first:.2f} s, then every {period:.2f} s" in text
    assert f"{on:.2f} s of them on" in text
