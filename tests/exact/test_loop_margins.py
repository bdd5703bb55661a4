"""Loops of a bench for small signals: margins, linear systems on both branches, schedules of gains.

Sources of truth: a loop with margins in closed form, python-control, and the bench itself a little moved.
"""

from __future__ import annotations

from functools import cache
from pathlib import Path
from typing import Any

import control
import numpy as np
import pytest
from command import Command

from martensite.base.errors import InputError
from martensite.control.controllers.relay import OnOff
from martensite.control.loop.parts import Controllers
from martensite.control.margins.linear_loop import LinearLoop, measure_noise
from martensite.control.margins.loop_case import LoopCase
from martensite.control.margins.loop_points import find_validity, linearise_case
from martensite.control.margins.margins import compute_margins
from martensite.identify.chains.linear_system import LinearSystem
from martensite.scenario.scenario import load
from martensite.show.figures.margins import plot_margins, to_control_system
from martensite.simulate.lanes import Lanes
from martensite.simulate.operating_point import find_operating_point

EXAMPLE = Path(__file__).resolve().parents[2] / "examples" / "closed_loop.toml"
PERIOD, TAU, LATE = 0.05, 2.0, 4
SAMPLES, STEP = 60, 1e-6
pytestmark = pytest.mark.usefixtures("c_compiler")


@cache
def build_case() -> LoopCase:
    """The loop of the example, with a sensor that does not round."""
    scenario = load(EXAMPLE, {"sensor.resolution": "0 mm"})
    assert scenario.bench is not None
    return LoopCase(scenario.bench, "drive", scenario.bench.controllers.members()["drive"], scenario.duration)


@cache
def linearise_example() -> list[LinearLoop]:
    """Three points of each branch and one in the dead band."""
    return linearise_case(build_case())


def build_late_lag(gain: float) -> LinearSystem:
    """L = K (1 - a)/(z - a) z⁻ᵈ: a first-order lag, held and late by some samples."""
    a = np.exp(-PERIOD / TAU)
    matrix = np.diag([a, *[0.0] * LATE]) + np.diag([1.0] * LATE, -1)
    into, out = np.eye(LATE + 1)[:, :1] * gain * (1.0 - a), np.eye(LATE + 1)[-1:]
    nothing = np.zeros(1)
    return LinearSystem(
        matrix, into, out, np.zeros((1, 1)), PERIOD, nothing, np.zeros(LATE + 1), nothing, ("u",), ("y",)
    )


@pytest.mark.parametrize("gain", [5.0, 30.0])
def test_margins_of_a_late_lag_are_those_in_closed_form(gain: float) -> None:
    found, a = compute_margins(build_late_lag(gain)), np.exp(-PERIOD / TAU)
    size = gain * (1.0 - a)
    angle = np.arccos((1.0 + a * a - size * size) / (2.0 * a))  # |e^jθ - a| = K (1 - a)
    phase = np.pi - LATE * angle - np.angle(np.exp(1j * angle) - a)
    assert found.crossover == pytest.approx(angle / PERIOD, rel=1e-9)
    assert found.phase == pytest.approx(phase, rel=1e-9)
    assert found.delay == pytest.approx(max(phase, 0.0) / angle * PERIOD, rel=1e-9)
    assert found.stable == (phase > 0.0) == (gain < 20.0)
    turned = np.angle(np.exp(1j * np.linspace(1e-3, np.pi, 200_001)) - a) + LATE * np.linspace(1e-3, np.pi, 200_001)
    theta = np.interp(np.pi, turned, np.linspace(1e-3, np.pi, 200_001))
    margin = found.gain if found.stable else found.least_gain
    assert margin == pytest.approx(abs(np.exp(1j * theta) - a) / size, rel=1e-7)


@pytest.mark.parametrize("place", [0, 2, 5])
def test_margins_are_those_of_python_control(place: int) -> None:
    one = linearise_example()[place]
    found, omega = compute_margins(one.loop), np.geomspace(1e-2, 0.999 * np.pi / one.loop.interval, 2000)
    response = control.frd(to_control_system(one.loop), omega, smooth=True)
    margins: Any = control.stability_margins(response)
    gain, phase, modulus, _, crossover, _ = margins
    mine = found.gain, np.degrees(found.phase), found.modulus, found.crossover
    np.testing.assert_allclose(mine, (gain, phase, modulus, crossover), rtol=1e-6)


@pytest.mark.parametrize(("place", "way"), [(1, 1.0), (4, -1.0)])
def test_a_small_step_of_the_reference_goes_as_the_linear_loop_says(place: int, way: float) -> None:
    """As long as nothing turns back."""
    bench, one = build_case().bench.with_parts(supervisor=None), linearise_example()[place]
    lanes = Lanes(bench, 1)
    lanes.state = one.closed.state[:-1, None].copy()
    signals = np.zeros((SAMPLES, len(lanes.drives), 1))
    signals[:, 0] = one.closed.inputs[0] + way * STEP
    seen = lanes.advance(signals, bench.period)[:, :, 0]
    moved = seen[:, [lanes.names.index(name) for name in ("measured.position", "wanted")]] - one.closed.outputs
    linear = one.closed.simulate(np.tile([way * STEP, 0.0, 0.0], (SAMPLES + 1, 1)))[1:]
    assert abs(linear[-1, 0]) > 0.7 * STEP
    np.testing.assert_allclose(moved / np.abs(linear).max(axis=0), linear / np.abs(linear).max(axis=0), atol=3e-5)


def test_the_plant_has_a_gain_on_each_branch_and_none_between() -> None:
    heated, cooled, between = (linearise_example()[k] for k in (1, 4, 6))
    case, signal = build_case(), heated.point.signal
    near = [find_operating_point(case.bench.plant, u).outputs["position"] for u in (signal, signal * (1.0 + 1e-4))]
    assert heated.plant.gain()[0, 0] == pytest.approx((near[1] - near[0]) / (1e-4 * signal), rel=5e-3)
    assert heated.plant.gain()[0, 0] > 1.5 * cooled.plant.gain()[0, 0] > 0.0
    assert between.branch == "dead band"
    assert abs(between.plant.gain()[0, 0]) < 1e-3 * heated.plant.gain()[0, 0]
    low, high = find_validity(case, heated)
    assert low < heated.reading < high


def test_noise_moves_the_signal_as_a_long_linear_run_says() -> None:
    one, rng = linearise_example()[0], np.random.default_rng(1)
    numbers = np.zeros((40_000, 3))
    numbers[:, 1] = rng.standard_normal(len(numbers))
    assert measure_noise(one) == pytest.approx(float(one.closed.simulate(numbers)[2000:, 1].std()), rel=0.03)


def test_a_schedule_has_the_same_sensitivity_at_all_points_and_follows_better(tmp_path: Path) -> None:
    """Found again with the scheduled controller on the bench; written, it is read as it was."""
    saved = tmp_path / "scheduled.toml"
    words = "--method", "schedule", "--sensitivity", "1.3", "--out", str(saved)
    found = Command("tune").report(str(EXAMPLE), *words)
    assert [one["branch"] for one in found["points"]] == ["heating"] * 4 + ["cooling"] * 4
    np.testing.assert_allclose([one["sensitivity"] for one in found["points"]], 1.3, rtol=2e-3)
    assert found["verdict"]["after"] < 0.6 * found["verdict"]["before"]
    written = load(saved).bench
    assert written is not None
    values = {leaf.path: leaf.value for leaf in written.controllers.members()["drive"].leaves()}
    for k, mark in enumerate(("rising", "falling")):
        rows = sorted(found["points"][4 * k : 4 * k + 4], key=lambda one: one["at"])
        for j, one in enumerate(rows, start=1):
            read = [values[f"{mark}.p{j}.{name}"] for name in ("at", "Kp", "Ki")]
            np.testing.assert_allclose(read, [one[name] for name in ("at", "Kp", "Ki")], rtol=1e-5)


@pytest.mark.parametrize(
    ("words", "said"), [(("--sensitivity", "0.9"), "must be above 1"), (("--rule", "simc"), "has no effect")]
)
def test_a_schedule_refuses_what_it_cannot_use(words: tuple[str, str], said: str) -> None:
    done = Command("tune")(str(EXAMPLE), "--method", "schedule", *words)
    assert done.exit_code != 0
    assert said in str(done.exception) + done.stderr


def test_a_figure_shows_every_branch_that_answers() -> None:
    figure = plot_margins(linearise_example(), "margins")
    legend = figure.axes[0].get_legend()
    assert legend is not None
    names = [text.get_text() for text in legend.get_texts()]
    assert [name.split()[0] for name in names] == ["heating"] * 3 + ["cooling"] * 3


def test_what_only_switches_has_no_linear_system() -> None:
    case = build_case()
    switch = OnOff(measured="position", reference=case.controller.reference, high=0.9)
    bench = case.bench.with_parts(controllers=Controllers(drive=switch))
    with pytest.raises(InputError, match="`on-off` does not answer small changes"):
        linearise_case(LoopCase(bench, "drive", switch, case.duration))
