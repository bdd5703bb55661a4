"""Variants: many runs at a time are what single runs are, whatever marches beside them.

Source of truth: `simulate` of the system with the numbers of each run in it, at the same step.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from builders import problem_a

from martensite.base.errors import InputError
from martensite.base.status import Status
from martensite.signals.pwm import PulseWidthModulation
from martensite.simulate.api import simulate
from martensite.simulate.ensembles import Ensemble
from martensite.simulate.variants import VariantSetup

SYSTEM = problem_a()
PWM = PulseWidthModulation(high=3.0, frequency=2.0, duty=0.5)
COURSE = VariantSetup(SYSTEM, {"drive": PWM}, 1.5, 7, 0.05, ("position", "temperature"), "floats")
RUNS = 5
VALUES = {
    "element.diameter": np.linspace(0.3e-3, 0.45e-3, RUNS),
    "environment.temperature": np.array([290.0, 295.0, 300.0, 285.0, 293.0]),
}
SIGNALS = {"drive": {"duty": np.array([0.2, 0.5, 0.9, 0.4, 0.7]), "high": np.full(RUNS, 5.0)}}
HARD = {**VALUES, "element.diameter": np.array([3e-4, 4e-4, 1e-200, 3.5e-4, 4e-4])}
"""The third has no heat capacity to speak of."""
FAILED = Status.UNSOLVED


def single(course: VariantSetup, run: int, values: Any, signals: Any, runtime: str) -> list[np.ndarray]:
    """One run by itself."""
    system = course.system.with_values({path: float(v[run]) for path, v in values.items()})
    wave = PWM.with_values({p: float(v[run]) for p, v in signals.get("drive", {}).items()})
    found = simulate(
        system, wave, course.duration, step=course.step, samples=course.samples, runtime=runtime or "floats"
    )
    return [np.asarray(found[name]) for name in course.outputs]


def same(first: Ensemble, second: Ensemble, rows: Any = slice(None)) -> None:
    """Both must be the same, bit for bit."""
    assert np.array_equal(first.status[rows], second.status[rows])
    for name, column in first.columns.items():
        assert np.array_equal(column[rows], second.columns[name][rows], equal_nan=True)


@pytest.mark.parametrize("signals", [{}, SIGNALS], ids=["one-signal", "own-signals"])
@pytest.mark.parametrize(("runtime", "off"), [("floats", 0.0), ("c", 1e-12)])
def test_variants_are_single_runs(runtime: str, off: float, signals: Any, c_compiler: str) -> None:
    course = replace(COURSE, runtime=runtime)
    found = course.run(VALUES, signals)
    assert (found.status < FAILED).all()
    for run in range(RUNS):
        alone = single(course, run, VALUES, signals, runtime)
        for name, column in zip(course.outputs, alone, strict=True):
            assert found.columns[name][run] == pytest.approx(column, rel=off, abs=off)
    assert np.ptp(found.columns["temperature"][:, -1]) > 1.0


def test_another_run_is_noticed() -> None:
    found = COURSE.run(VALUES, {})
    other = single(COURSE, 1, VALUES, {}, "floats")[1]
    assert found.columns["temperature"][0] != pytest.approx(other, rel=1e-12)


@pytest.mark.parametrize("values", [VALUES, HARD], ids=["plain", "hard"])
@pytest.mark.parametrize("runtime", ["floats", "c"])
def test_a_run_does_not_depend_on_those_beside_it(runtime: str, values: Any, c_compiler: str) -> None:
    course = replace(COURSE, runtime=runtime, lanes=16)
    together = course.run(values, SIGNALS)
    assert (together.status >= FAILED).tolist() == [values is HARD and k == 2 for k in range(RUNS)]
    for first, stop in ((0, 2), (2, 3), (3, 5), (1, 5)):
        part = {path: column[first:stop] for path, column in values.items()}
        own = {"drive": {p: v[first:stop] for p, v in SIGNALS["drive"].items()}}
        expected = {name: c[first:stop] for name, c in together.columns.items()}
        ended, accuracy = together.ended[first:stop], together.accuracy[first:stop]
        same(course.run(part, own), Ensemble(expected, together.status[first:stop], ended, accuracy))


def test_a_run_does_not_depend_on_how_many_march_together(c_compiler: str) -> None:
    floats = COURSE.run(VALUES, SIGNALS)
    same(floats, replace(COURSE, lanes=2).run(VALUES, SIGNALS))
    course = replace(COURSE, runtime="c")
    few, many = (replace(course, lanes=n).run(VALUES) for n in (16, 64))
    same(few, many)


def test_a_failed_run_fails_alone(c_compiler: str) -> None:
    for runtime in ("floats", "c"):
        course = replace(COURSE, runtime=runtime, lanes=16)
        calm = {**HARD, "element.diameter": np.full(RUNS, 3e-4)}
        calm["element.diameter"][[0, 1, 3, 4]] = HARD["element.diameter"][[0, 1, 3, 4]]
        hard, easy = course.run(HARD, SIGNALS), course.run(calm, SIGNALS)
        assert hard.status[2] == Status.NOT_FINITE
        same(hard, easy, [0, 1, 3, 4])


def test_a_run_that_stays_unsolved_is_a_status() -> None:
    course = replace(COURSE)

    def engine(values: Any, grid: Any, runs: int) -> Any:
        found = [np.zeros((runs, course.samples)) for _ in course.outputs]
        reports = np.array([[0.0, 1.0, np.nan, 0.0, 0.0], [0.0, 0.0, 0.0, 1.0, 0.0]])
        return found, reports, np.full(runs, np.inf)

    course.__dict__.update(engine=engine, lanes=RUNS)
    expected = Status.OK, Status.UNSOLVED, Status.NOT_FINITE, Status.LONG_STEP, Status.OK
    assert tuple(course.run(VALUES).status) == expected


# ---------------------------------------------------------------- refusals

REFUSED = {
    "out of range": {"element.diameter": [3e-4, -3e-4, 3e-4]},
    "no number": {"environment.temperature": [290.0, np.nan, 300.0]},
    "contradiction": {"element.law.A_s": [341.15, 361.15, 342.15]},
}


@pytest.mark.parametrize("case", REFUSED)
def test_refused_runs_are_rows_and_the_others_are_not_touched(case: str) -> None:
    values = {path: np.array(column) for path, column in REFUSED[case].items()}
    found = COURSE.run(values)
    assert (found.status == Status.REFUSED).tolist() == [False, True, False]
    assert np.isnan(found.columns["position"][1]).all()
    good = COURSE.run({path: column[[0, 2]] for path, column in values.items()})
    for name, column in good.columns.items():
        assert np.array_equal(found.columns[name][[0, 2]], column)


def test_refused_signals_are_rows() -> None:
    found = COURSE.run({}, {"drive": {"duty": np.array([0.5, 1.5, -0.1, 0.3])}})
    assert (found.status == Status.REFUSED).tolist() == [False, True, True, False]


def test_a_block_of_refused_runs_is_not_marched() -> None:
    found = COURSE.run({"element.diameter": np.full(3, -1.0)})
    assert found.status.tolist() == [Status.REFUSED] * 3
    assert np.isnan(found.columns["position"]).all()


@pytest.mark.parametrize(
    ("runtime", "precision", "sentence"),
    [("cud", "float64", "Did you mean `cuda`"), ("c", "float32", "float32 on CUDA"), ("floats", "float16", "float16")],
)
def test_wrong_runtimes_are_refused(runtime: str, precision: str, sentence: str) -> None:
    with pytest.raises(InputError, match=sentence):
        VariantSetup(SYSTEM, {}, 1.0, 3, 0.1, (), runtime, precision)


def test_many_clocks_are_kept_within_bounds() -> None:
    course = replace(COURSE, duration=1.0, samples=3, lanes=70)
    count = 70
    frequency = {"drive": {"frequency": np.linspace(1.0, 3.0, count)}}
    found = course.run({}, frequency)
    last = single(course, count - 1, {}, frequency, "floats")
    assert np.array_equal(found.columns["position"][-1], last[0])
    assert len(course._clocks) <= 64
