"""Designs: derivatives, the search beside brute force, whole numbers, what holds a design.

Sources of truth: central differences of the same runs, grids of all designs, designs found anew
with another limit.
"""

from __future__ import annotations

import numpy as np
import pytest
from design_cases import COUNT, DIAMETER, POWER, SAMPLES, STEP, bundle, designs, differences, steering
from numpy.typing import NDArray

from martensite.base.errors import InputError, ParameterError, UnitError
from martensite.base.parameters import Number, param
from martensite.design.optimise.evaluate import DesignEvaluator
from martensite.design.optimise.optimise import optimise_design
from martensite.design.optimise.optimised_design import OptimisedDesign
from martensite.design.optimise.question import build_life_constraints, read_question
from martensite.design.optimise.search import DesignSearch, scan_designs
from martensite.signals.base import DRIVE, AbstractWaveform
from martensite.signals.sine import Sine
from martensite.simulate.api import simulate
from martensite.simulate.waveform_levels import WaveformLevels

ALL = (
    "stroke >= 3 mm",
    "rise-time <= 1 s",
    "fall-time <= 1 s",
    "max(stress) <= 200 MPa",
    "max(temperature) <= 120 degC",
    "at(position, time=1 s) >= 3 mm",
    "rms(current) <= 1 A",
    "mean(power) <= 5 W",
    "element.count <= 4",
)
LIMITS = (
    "stroke >= 7.5 mm",
    "rise-time <= 0.5 s",
    "fall-time <= 1 s",
    "max(stress) <= 450 MPa",
    "max(temperature) <= 170 degC",
)
QUICK = DesignSearch(sample=16, descents=1, clouds=1, iterations=30)
pytestmark = pytest.mark.usefixtures("c_compiler")


def found(
    free: tuple[str, ...],
    *limits: str,
    begin: WaveformLevels | None = None,
    search: DesignSearch = QUICK,
    **options: object,
) -> OptimisedDesign:
    given = begin or steering()
    options = {"life": None, **options}  # these tests say what limits there are
    return optimise_design(
        given.system,
        given.waveforms,
        given.duration,
        free,
        subject=limits or LIMITS,
        samples=SAMPLES,
        step=STEP,
        search=search,
        **options,  # type: ignore[arg-type]
    )


# ---------------------------------------------------------------- derivatives


@pytest.fixture(scope="module")
def all_measures() -> DesignEvaluator:
    """In steps that are solved exactly, as derivatives take them to be."""
    free = COUNT, DIAMETER, POWER, "stiffness=0.2..1 N/mm"
    return designs(free, "energy", ALL)


def agree(exact: NDArray[np.float64], near: NDArray[np.float64]) -> bool:
    size = np.abs(near).max(axis=2, keepdims=True)
    return bool((np.abs(exact - near) <= 1e-5 * size + 1e-12).all())


@pytest.mark.parametrize("z", [(0.3, 0.1, 0.55, 0.3), (0.2, 0.05, 0.4, 0.6)])
def test_derivatives_are_those_of_differences(all_measures: DesignEvaluator, z: tuple[float, ...]) -> None:
    place = np.array(z)
    exact = all_measures.slopes(place)
    assert exact is not None
    np.testing.assert_allclose(exact.values[None], all_measures.values(place[None]), rtol=1e-9)
    near = differences(all_measures, place, 1e-5)
    assert agree(exact.slopes, near)
    assert not agree(exact.slopes * (1.0 + 1e-4), near)


def test_without_a_compiler_differences_serve(all_measures: DesignEvaluator) -> None:
    z = np.array([0.3, 0.1, 0.55, 0.3])
    plain = DesignEvaluator(steering(), all_measures.question, samples=SAMPLES, step=STEP, native=False)
    exact, near = all_measures.slopes(z), plain.slopes(z)
    assert exact is not None
    assert near is not None
    np.testing.assert_allclose(near.values, exact.values, rtol=1e-5)
    size = np.abs(exact.slopes).max(axis=2, keepdims=True)
    assert (np.abs(near.slopes - exact.slopes) <= 2e-3 * size).all()
    assert plain.counts.slopes == 1


# ---------------------------------------------------------------- levels of waveforms


def test_a_steered_run_is_the_run_itself() -> None:
    one = bundle()
    given = steering()
    steered = given.with_levels([given.level("drive", "high"), given.level("drive", "low")])
    plain, other = (
        simulate(system, waves, one.duration, step=STEP, samples=SAMPLES, runtime="c")
        for system, waves in ((one.system, one.waveform), (steered.whole, steered.system_waveforms()))
    )
    np.testing.assert_allclose(other["position"], plain["position"], atol=1e-12)
    assert max(plain["position"]) > 1e-3


def test_the_peak_scales_all_of_a_waveform() -> None:
    wave = Sine(low=-1.0, high=3.0, frequency=1.0)
    given = WaveformLevels(bundle().system, wave, 2.0)
    assert given.level("drive", "peak").value == pytest.approx(3.0)
    twice = given.at("drive", {"peak": 6.0})
    assert [twice.value(t) for t in (0.0, 0.3)] == pytest.approx([2.0 * wave.value(t) for t in (0.0, 0.3)])
    with pytest.raises(ParameterError, match="cannot both be free"):
        given.with_levels([given.level("drive", "peak"), given.level("drive", "high")])


class Squared(AbstractWaveform):
    """A signal that is not affine in its level."""

    level: Number = param(DRIVE, "root of the signal", default=2.0)

    def value(self, time: float) -> float:
        return self.level**2


def test_a_level_that_is_not_affine_is_refused() -> None:
    given = WaveformLevels(bundle().system, Squared(), 1.0)
    with pytest.raises(ParameterError, match="not affine in its `level`"):
        given.with_levels([given.level("drive", "level")])


# ---------------------------------------------------------------- the search


def test_it_agrees_with_brute_force() -> None:
    best = found(("strand.diameter=0.08..0.14 mm", "drive.waveform.high=2..6 W"))
    grid = scan_designs(best.designs, 21)
    assert best.feasible
    assert grid.best is not None
    assert best.goal <= grid.values[0] * (1.0 + 1e-6)
    assert grid.values[0] <= best.goal * 3.0 ** (1.0 / 20.0)  # energy is power: a cell of it
    assert max(grid.cells(np.array(best.z))) <= 1.0
    assert best.counts.simulations + best.counts.slopes < len(grid.z) == 441


def test_what_a_limit_costs_is_what_another_limit_gains() -> None:
    best = found((DIAMETER, POWER))
    assert best.balance is not None
    assert best.balance.residue < 1e-2
    held = {one.name: one for one in best.balance.pressing}
    other = found((DIAMETER, POWER), *(t.replace("0.5 s", "0.505 s") for t in LIMITS))
    one = held["rise-time <= 0.5 s"]
    assert one.step == pytest.approx(0.005)
    assert best.goal - other.goal == pytest.approx(one.gain, rel=0.1)
    assert "more would gain" in one.words("J")


def test_whole_numbers_are_those_of_a_grid() -> None:
    best = found((COUNT, DIAMETER, POWER))
    grid = scan_designs(best.designs, [6, 7, 7])
    assert best.feasible
    assert best.numbers[0] == round(best.numbers[0])
    assert grid.best is not None
    assert best.numbers[0] == grid.numbers[0]
    assert best.goal <= grid.values[0] * (1.0 + 1e-6)
    tried = {one.whole[0]: one for one in best.rounded_designs}
    count = int(best.numbers[0])
    assert {n for n in (count - 1, count + 1) if 1 <= n <= 6} <= set(tried)
    assert all(best.goal <= one.goal * (1.0 + 1e-9) for one in tried.values() if one.feasible)
    assert best.relaxed_goal is not None
    assert best.relaxed_goal <= best.goal * (1.0 + 1e-4)


def test_it_leaves_a_start_that_does_not_move() -> None:
    cold = WaveformLevels(bundle().system, bundle().waveform, 3.0).at("drive", {"high": 0.05})
    begin = WaveformLevels(bundle().system, cold, 3.0)
    free = DIAMETER, "drive.waveform.high=0.05..12 W"
    one = designs(free, "energy", LIMITS, begin)
    z = np.array([one.share(one.start) for one in one.question.free])
    flat = one.slopes(z)
    assert flat is not None
    assert np.abs(flat.slopes[0, 1]).max() < 1e-9  # of the stroke
    best = found(free, begin=begin)
    assert best.feasible
    assert best.measures[1].before[0] < 1e-4 < 7.5e-3 <= best.measures[1].after[0] * (1.0 + 1e-4)


def test_what_cannot_be_kept_is_said() -> None:
    search = DesignSearch(sample=8, more=1, descents=1, clouds=0, iterations=20)
    best = found((DIAMETER, POWER), "stroke >= 50 mm", "max(stress) <= 300 MPa", search=search)
    assert not best.feasible
    assert "stroke >= 50 mm" in best.violated_constraints
    assert "Widen the bounds" in best.notes[0]


def test_cases_are_all_kept() -> None:
    warm = found((DIAMETER, POWER), cases=("environment.temperature=35 degC",))
    alone = found((DIAMETER, POWER))
    times = {one.words: one.after for one in warm.measures}
    assert warm.feasible
    assert times["fall-time"][0] < times["fall-time"][1] <= 1.0 * (1.0 + 1e-4)
    assert times["rise-time"][1] < times["rise-time"][0] <= 0.5 * (1.0 + 1e-4)
    assert warm.goal >= alone.goal * (1.0 - 1e-4)


def test_the_same_seed_gives_the_same_design() -> None:
    first, again = (found((DIAMETER, POWER)).to_dict() for _ in range(2))
    assert first == again


# ---------------------------------------------------------------- life


def test_life_is_the_declared_limits_with_a_margin() -> None:
    limits = build_life_constraints(steering(), (), 0.1)
    said = {one.aim.words: one.limit for one in limits}
    assert said["max(stress)"] == pytest.approx(0.9 * 172e6)
    assert said["stroke(strain)"] == pytest.approx(0.9 * 0.05)
    assert said["max(hottest)"] == pytest.approx(295.15 + 0.9 * (413.15 - 295.15))
    best = found((DIAMETER, POWER), "stroke >= 5 mm", life=0.1)
    assert "no number of cycles" in best.life
    assert len(best.question.subject) == 4


def test_life_needs_limits() -> None:
    bare = steering(stress_limit=1e12, strain_limit=1e3, temperature_limit=1e6)
    numbers = {name: float("inf") for name in ("stress_limit", "strain_limit", "temperature_limit")}
    system = bare.system.with_values(numbers)
    with pytest.raises(ParameterError, match="No element declares a limit"):
        build_life_constraints(WaveformLevels(system, bare.waveforms, 3.0), (), 0.1)
    assert build_life_constraints(WaveformLevels(system, bare.waveforms, 3.0), ()) == []


def test_limits_are_kept_unless_told_otherwise() -> None:
    """Thin wires that carry a lot are best, and break soon."""
    thin = (DIAMETER, POWER), "stroke >= 5 mm", "max(stress) <= 450 MPa"
    bold, kept = (found(*thin, life=life) for life in (None, 0.0))
    stress = [max(next(m.after for m in one.measures if m.words == "max(stress)")) for one in (bold, kept)]
    assert stress[0] > 1.5 * 172e6
    assert stress[1] <= 172e6 * (1.0 + 1e-3)
    assert "are ignored, as asked" in bold.life
    assert "are kept" in kept.life


# ---------------------------------------------------------------- texts

REFUSED: dict[str, tuple[str, type[Exception]]] = {
    "0.1..0.2 mm": ("is no free parameter", ParameterError),
    "strand.diameter=0.2..0.1 mm": ("must rise", ParameterError),
    "strand.diameter=0.1..0.2 s": ("cannot be converted", UnitError),
    "strand.diameter=0.1..0.2": ("has no unit", UnitError),
    "strand.diametr=0.1..0.2 mm": ("Did you mean `element.strand.diameter`", ParameterError),
    "element.count=0.5..3": ("must rise and lie within", ParameterError),
    "element.count=1..3.5": ("must be whole numbers", ParameterError),
    "limits.stress_limit=0..9 MPa log": ("on one side of 0|no number", ParameterError),
    "drive.waveform.at=0..1 s": ("There is no parameter", ParameterError),
}


@pytest.mark.parametrize("text", REFUSED)
def test_a_free_number_is_refused(text: str) -> None:
    words, error = REFUSED[text]
    with pytest.raises(error, match=words):
        read_question(steering(), [text], "energy")


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("stroke > ", "cannot be read|not a number"),
        ("stroke", "is no constraint"),
        ("stroke >= 3 s", "cannot be converted"),
        ("strok >= 3 mm", "Did you mean `stroke`"),
        ("max(stres) <= 3 MPa", "Did you mean `stress`"),
    ],
)
def test_a_constraint_is_refused(text: str, words: str) -> None:
    with pytest.raises(InputError, match=words):
        read_question(steering(), [DIAMETER], "energy", [text])


def test_questions_are_refused() -> None:
    with pytest.raises(ParameterError, match="Nothing is free"):
        read_question(steering(), [], "energy")
    with pytest.raises(ParameterError, match="more than once"):
        read_question(steering(), [DIAMETER, "diameter=0.1..0.2 mm"], "energy")
    with pytest.raises(ParameterError, match="is free and cannot differ"):
        read_question(steering(), [DIAMETER], "energy", cases=["diameter=0.1 mm"])
    with pytest.raises(ParameterError, match="one goal"):
        found((DIAMETER,), minimise="energy", maximise="stroke")


def test_scales_and_bounds_are_chosen() -> None:
    texts = ["element.count=1..6", "diameter=0.08..0.1 mm", "stiffness", "preload=1..10 N linear"]
    count, diameter, stiffness, preload = read_question(steering(), texts, "energy").free
    assert count.whole
    assert (diameter.logarithmic, stiffness.logarithmic, preload.logarithmic) == (False, True, False)
    assert (stiffness.low, stiffness.high) == pytest.approx((80.0, 2000.0))
    assert stiffness.value(stiffness.share(400.0)) == pytest.approx(400.0)
    assert (stiffness.bound(0.0), stiffness.bound(0.5), stiffness.bound(1.0)) == ("lower", None, "upper")
