"""Material points: both controls agree, clamped points obey Clausius–Clapeyron, errors are said.

Source of truth: the law itself driven by stress, its slopes, and values written down by hand.
"""

from __future__ import annotations

import itertools
from typing import Any

import builders
import numpy as np
import pytest

from martensite.base.errors import InputError, ParameterError, SolveError, UnknownNameError
from martensite.base.status import Status
from martensite.kernels import floats
from martensite.physics.laws.base import AbstractLaw, Fractions
from martensite.physics.laws.strip_laws import LiangRogers
from martensite.simulate import point
from martensite.simulate.compiled_law import compile_law
from martensite.simulate.path_layout import Choices
from martensite.simulate.path_stages import list_stages, residual_strain
from martensite.simulate.paths import PATHS, build_paths
from martensite.simulate.point import PathLeg, PointResult, material_point

LAW: dict[str, Any] = {
    "E_A": 60e9,
    "E_M": 30e9,
    "eps_L": 0.05,
    "A_s": 310.0,
    "A_f": 325.0,
    "M_s": 300.0,
    "M_f": 285.0,
    "C_A": 7e6,
    "C_M": 7e6,
    "T_ref": 300.0,
}
HOT = 345.0
LOOP = (PathLeg(stress=500e6), PathLeg(stress=0.0))


def law(**changes: Any) -> LiangRogers:
    return LiangRogers(**{**LAW, "modulus": "mixture", **changes})


def stretched(by: float, one: AbstractLaw, **arguments: Any) -> PointResult:
    """Stretched hot to a strain and released to none."""
    legs = PathLeg(strain=by), PathLeg(strain=0.0)
    return material_point(one, legs, start=(0.0, HOT), **arguments)


# ---------------------------------------------------------------- both controls


def test_strain_driven_is_the_inverse_of_stress_driven() -> None:
    driven = material_point(law(), LOOP, start=(0.0, HOT), tolerance=None)
    legs = [PathLeg(strain=strain, steps=1) for strain in driven.strain[1:]]
    back = material_point(law(), legs, start=(0.0, HOT), tolerance=None)
    assert max(driven.martensite) == 1.0
    assert np.max(np.abs(np.subtract(back.stress, driven.stress))) < 1e-9 * 500e6
    assert np.max(np.abs(np.subtract(back.martensite, driven.martensite))) < 1e-9
    assert np.max(np.abs(np.subtract(back.strain, driven.strain))) < 1e-9 * 0.05


def test_both_controls_do_the_same_work() -> None:
    peak = material_point(law(), LOOP[:1], start=(0.0, HOT)).strain[-1]
    works = [
        material_point(law(), LOOP, start=(0.0, HOT), steps=2000, tolerance=None).work,
        stretched(peak, law(), steps=2000, tolerance=None).work,
    ]
    assert works[0] == pytest.approx(works[1], rel=1e-5)
    assert works[0] > 1e6


def test_elastic_leg_has_the_modulus_of_austenite() -> None:
    result = stretched(0.001, law())
    assert result.stress[result.ends[1]] == pytest.approx(60e6, rel=1e-12)
    assert result.work == pytest.approx(0.0, abs=1e-6)
    assert residual_strain(result) == pytest.approx(0.0, abs=1e-15)


def test_slack_point_is_longer_than_what_is_prescribed() -> None:
    legs = PathLeg(strain=0.06), PathLeg(strain=0.0)
    cold = {"start": (0.0, 305.0), "steps": 50}
    slack = material_point(law(), legs, **cold)
    assert slack.stress[-1] == 0.0
    assert slack.strain[-1] == pytest.approx(0.05, abs=1e-12)
    pressed = material_point(law(), legs, tension_only=False, **cold)
    assert pressed.stress[-1] < -50e6
    assert pressed.strain[-1] == pytest.approx(0.0, abs=1e-12)


def test_what_is_held_stays_and_what_was_prescribed_is_held() -> None:
    legs = (
        PathLeg(strain=0.04),
        PathLeg(strain=0.02),
        PathLeg(temperature=350.0),
        PathLeg(temperature=HOT, hold="stress"),
        PathLeg(duration=5.0),
    )
    result = material_point(law(), legs, start=(0.0, HOT))
    a, b, c = result.ends[2:5]
    assert np.ptp(result.strain[a : b + 1]) < 1e-12
    assert result.stress[b] > result.stress[a] + 1e6
    assert np.ptp(result.stress[b:]) == 0.0
    assert result.temperature[c] == HOT
    assert result.time[-1] == pytest.approx(9.0)


def test_the_slack_strain_is_not_taken_for_the_clamped_one() -> None:
    """Released below its free length and clamped there, a point pulls only once that is free."""
    legs = PathLeg(strain=0.04), PathLeg(strain=0.02), PathLeg(temperature=400.0, hold="strain")
    result = material_point(law(), legs, start=(0.0, 305.0))
    assert result.stress[result.ends[2]] == 0.0
    assert result.strain[result.ends[2]] > 0.03
    assert result.strain[-1] == pytest.approx(0.02, abs=1e-10)
    assert result.stress[-1] > 100e6


# ---------------------------------------------------------------- clamped and heated


def slopes(result: PointResult, leg: int) -> tuple[np.ndarray, np.ndarray]:
    """dσ/dT [Pa/K] and dξ of the steps of a leg."""
    part = slice(result.ends[leg], result.ends[leg + 1] + 1)
    stress, temperature, fraction = (np.array(result[name][part]) for name in ("stress", "temperature", "martensite"))
    return np.diff(stress) / np.diff(temperature), np.diff(fraction)


@pytest.mark.parametrize("name", ["liang-rogers", "tanaka", "elahinia", "brinson"])
def test_stress_of_a_clamped_point_never_rises_faster_than_its_slope(name: str) -> None:
    """The point may not leave the strip of the reverse transformation, whose slope is C_A."""
    one = builders.example(builders.REGISTRIES["law"][name])
    (course,) = build_paths("constrained-recovery", one)
    slope, change = slopes(course.follow(one), 2)
    acts = change < -1e-9
    assert acts.sum() > 20
    assert np.all(slope[acts] > 0.0)
    assert np.all(slope[acts] <= one.C_A * (1.0 + 1e-6))


# ---------------------------------------------------------------- steps


def test_refinement_reaches_its_tolerance() -> None:
    one = builders.example(builders.REGISTRIES["law"]["mas"])
    arguments: dict[str, Any] = {"start": (0.0, 350.0), "steps": 5}
    legs = PathLeg(strain=0.06, duration=60.0), PathLeg(strain=0.0, duration=60.0)
    coarse = material_point(one, legs, tolerance=None, **arguments)
    fine = material_point(one, legs, tolerance=1e-4, **arguments)
    exact = material_point(one, legs, tolerance=1e-5, **arguments)
    assert (coarse.accuracy, coarse.steps) == (None, 10)
    assert fine.accuracy is not None
    assert fine.accuracy <= 1e-4
    assert fine.steps >= 40
    assert len(fine.time) == len(coarse.time) == 11

    def error(result: PointResult) -> float:
        return float(np.max(np.abs(np.subtract(result.stress, exact.stress))) / np.ptp(exact.stress))

    assert error(fine) < 2e-4 < error(coarse)


def test_a_tolerance_out_of_reach_is_a_warning(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(point, "MOST_STEPS", 20)
    one = builders.example(builders.REGISTRIES["law"]["mas"])
    legs = PathLeg(strain=0.06, duration=60.0), PathLeg(strain=0.0, duration=60.0)
    result = material_point(one, legs, start=(0.0, 350.0), steps=5, tolerance=1e-12)
    assert result.status is Status.OK
    assert len(result.warnings) == 1
    assert "was not reached in 20 steps" in result.warnings[0]


def test_steps_of_a_leg_are_its_samples() -> None:
    legs = PathLeg(stress=500e6, steps=7), PathLeg(stress=0.0)
    result = material_point(law(), legs, start=(0.0, HOT), steps=11)
    assert result.ends == [0, 7, 18]
    assert [len(result[n]) for n in ("time", "strain", "oriented")] == [19, 19, 19]
    assert result.stress[7] == 500e6


# ---------------------------------------------------------------- the traced law


LAWS = [builders.variants(cls)[0] for cls in builders.registered("law")]


@pytest.mark.parametrize("one", LAWS, ids=builders.label)
def test_traced_steps_are_those_of_the_law(one: Any) -> None:
    compiled = compile_law(one)
    functions = compiled.program.bind_floats(*compiled.values(one))
    state = functions["init"](0.3, 0.2, 50e6, 320.0)
    memory = one.init(floats, Fractions(0.3, 0.2), 50e6, 320.0)
    for stress, temperature in ((100e6, 310.0), (250e6, 315.0), (20e6, 340.0)):
        state = functions["stress_step"](*state[: compiled.size], stress, temperature, 1.0)
        memory, fractions = one.kinetics(floats, memory, stress, temperature, 1.0)
        strain = one.strain(floats, fractions, stress, temperature)
        row = (*fractions[:2], strain, stress, 0.0)
        assert state[compiled.size :] == pytest.approx(row, rel=1e-9, abs=1e-12)


def test_programs_are_shared_by_structure() -> None:
    assert compile_law(law()) is compile_law(law(A_f=330.0))
    assert compile_law(law()) is not compile_law(law(modulus="austenite"))
    assert compile_law(law()) is not compile_law(law(), tension_only=False)


# ---------------------------------------------------------------- named paths


@pytest.mark.parametrize("name", PATHS)
def test_every_path_transforms_and_is_described(name: str) -> None:
    assert PATHS[name].summary.endswith(".")
    for course in build_paths(name, law()):
        result = course.follow(law(), tolerance=1e-3)
        assert np.ptp(result.martensite) > 0.2
        assert any(stage.process for stage in list_stages(result))


def test_stages_say_where_a_law_transforms() -> None:
    (course,) = build_paths("superelastic", law(), Choices(temperatures=(HOT,)))
    up, down = list_stages(course.follow(law(), steps=4000))
    assert (up.kind, up.process, up.varies) == ("loading", "forward", ("stress",))
    assert (down.kind, down.process) == ("unloading", "reverse")
    assert up.spots is not None
    assert down.spots is not None
    middle = 7e6 * (HOT - 292.5), 7e6 * (HOT - 317.5)
    assert up.spots[1].stress == pytest.approx(middle[0], abs=1e5)
    assert down.spots[1].stress == pytest.approx(middle[1], abs=1e5)
    stresses = [spot.stress for spot in (*up.spots, *down.spots)]
    assert stresses[:3] == sorted(stresses[:3])
    assert stresses[3:] == sorted(stresses[3:], reverse=True)


def test_choices_that_a_path_does_not_take_are_refused() -> None:
    with pytest.raises(ParameterError, match="takes no temperatures; its settings are stresses"):
        build_paths("isobaric", law(), Choices(temperatures=(300.0,)))
    with pytest.raises(UnknownNameError, match="Did you mean `isobaric`"):
        build_paths("isobarik", law())


# ---------------------------------------------------------------- errors


@pytest.mark.parametrize(
    ("leg", "sentence"),
    [
        ({"stress": 1e6, "strain": 0.01}, "but both are given"),
        ({"hold": "strian"}, "Did you mean `strain`"),
        ({"stress": 1e6, "hold": "stress"}, "holds nothing"),
        ({"duration": 0.0}, "must be above 0 s"),
        ({"steps": 0}, "at least 1"),
        ({"temperature": -3.0}, "above 0 K"),
        ({"strain": float("nan")}, "must be finite"),
    ],
)
def test_legs_that_make_no_sense(leg: dict[str, Any], sentence: str) -> None:
    with pytest.raises(ParameterError, match=sentence):
        PathLeg(**leg)


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        ({"legs": ()}, "at least one leg"),
        ({"start": (0.0, 0.0)}, "temperature above 0 K"),
        ({"fractions": Fractions(0.2, 0.5)}, "of at most that size"),
        ({"steps": 0}, "`steps` must be at least 1"),
        ({"tolerance": 0.0}, "`tolerance` must be above 0"),
        ({"runtime": "flots"}, "No runtime named `flots`"),
    ],
)
def test_arguments_that_make_no_sense(arguments: dict[str, Any], sentence: str) -> None:
    given: dict[str, Any] = {"legs": LOOP, "start": (0.0, HOT), **arguments}
    with pytest.raises(InputError, match=sentence):
        material_point(law(), given.pop("legs"), **given)


def test_unknown_column() -> None:
    with pytest.raises(InputError, match="Did you mean `stress`"):
        material_point(law(), LOOP, start=(0.0, HOT), steps=2, tolerance=None)["stres"]


class Restless(LiangRogers):
    """Answers every guess with its opposite: no stress fits any strain."""

    def follow(self, xp: Any, move: Any, stress: Any, temperature: Any, dt: Any) -> Fractions:
        fraction = xp.where(stress > 100e6, 0.9, 0.1)
        return Fractions(fraction, fraction)


def test_a_step_that_cannot_be_solved_says_where() -> None:
    restless = Restless(**LAW)
    with pytest.raises(SolveError, match=r"leg 2 failed at t = [\d.]+ s\. The stress of a presc"):
        legs = PathLeg(stress=150e6), PathLeg(strain=0.03)
        material_point(restless, legs, start=(0.0, HOT), steps=4, tolerance=None)


def test_numbers_that_are_none_say_so() -> None:
    class Broken(LiangRogers):
        def compliance(self, xp: Any, fractions: Fractions) -> Any:
            return 1.0 / (self.E_A - self.E_A * (1.0 + 0.0 * fractions.martensite))

    with pytest.raises((SolveError, ZeroDivisionError)):
        stretched(0.01, Broken(**LAW), steps=2)


def test_rates_matter_for_laws_with_rates_only() -> None:
    for name, matters in (("mas", True), ("liang-rogers", False)):
        one = builders.example(builders.REGISTRIES["law"][name])
        starts: list[float] = []
        for duration, _ in itertools.product((0.1, 1e3), (0,)):
            legs = (PathLeg(stress=600e6, duration=duration, steps=3000),)
            result = material_point(one, legs, start=(0.0, HOT), tolerance=None)
            (stage,) = list_stages(result)
            assert stage.spots is not None
            starts.append(stage.spots[1].stress)
        assert (abs(starts[0] - starts[1]) > 0.5e6) is matters
