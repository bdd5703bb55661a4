"""Runs on a GPU are runs in C: the same program, printed as CUDA C.

Source of truth: lanes of C on the same steps. Where there is no GPU, which is what continuous integration has, the
printed text is made by the C compiler for the processor, behind a few words that say what those of CUDA mean
(`cuda_on_host.py`), and NVRTC, which needs no device, compiles the same text for one.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from benchmarks import sections_cuda
from benchmarks.sections import Options
from command import Command
from cuda_on_host import HostMemory, HostProgram

from martensite.base.errors import InputError
from martensite.base.status import Status
from martensite.design.sweep.subject import list_waveforms
from martensite.scenario.scenario import load
from martensite.simulate.batch import simulate_batch
from martensite.simulate.cuda import device, march, to_ends
from martensite.simulate.cuda.source import MarchSource
from martensite.simulate.ensembles import Ensemble
from martensite.simulate.march_kernel import kernel_of
from martensite.simulate.variants import VariantSetup

EXAMPLES = Path(__file__).parents[2] / "examples"
STEP = 0.02
CASES = {
    "pwm_bias_spring": (20.0, {}),
    "finger": (8.0, {"element.law": "mas"}),  # rates of a law, and a mechanism with inertia
    "clamped_wire": (4.0, {}),  # cells of a wire
    "antagonistic_wires": (8.0, {}),  # two drives
}


def has_device() -> bool:
    """Whether there is a GPU."""
    try:
        device.open_device()
    except InputError:
        return False
    return True


@pytest.fixture(params=["host", "device"])
def machine(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch, c_compiler: str) -> Iterator[str]:
    """What marches: the processor, and a GPU where there is one."""
    if request.param == "device" and not has_device():
        pytest.skip("there is no CUDA device")
    if request.param == "host":
        monkeypatch.setattr(device, "open_device", lambda: None)
        monkeypatch.setattr(device, "DeviceProgram", HostProgram)
        monkeypatch.setattr(device, "DeviceMemory", HostMemory)
    for kept in (march.load_march, to_ends.load_program):
        kept.cache_clear()
    yield request.param
    for kept in (march.load_march, to_ends.load_program):
        kept.cache_clear()


def course_of(name: str, runtime: str, **others: Any) -> VariantSetup:
    """A scenario of the examples, with everything that is judged."""
    duration, changes = CASES[name]
    scenario = load(EXAMPLES / f"{name}.toml", changes)
    judged = tuple(scenario.system.convergence_scales())
    return VariantSetup(scenario.system, list_waveforms(scenario), duration, 21, STEP, judged, runtime, **others)


def vary(course: VariantSetup, count: int) -> dict[str, Any]:
    """Diameters of the first wire, and what it loses to its surroundings."""
    nominal = {leaf.path: leaf.value for leaf in course.system.leaves()}
    paths = [next(p for p in nominal if p.endswith(end)) for end in ("diameter", "temperature")]
    return {path: nominal[path] * np.linspace(0.99, 1.01, count) for path in paths}


def compare(course: VariantSetup, found: Ensemble, exact: Ensemble, share: float) -> None:
    """Columns to a share of their ranges, or of the least that count; when and how runs ended."""
    for name, least in course.system.convergence_scales().items():
        column = exact.columns[name]
        assert np.array_equal(np.isnan(found.columns[name]), np.isnan(column))
        scale = max(np.ptp(column[np.isfinite(column)]), least)
        assert np.nanmax(np.abs(found.columns[name] - column)) <= share * scale
    fractions = [column for name, column in exact.columns.items() if "fraction" in name]
    assert max(np.nanmax(column) - np.nanmin(column) for column in fractions) > 0.1  # something happens
    assert found.status.tolist() == exact.status.tolist()
    np.testing.assert_allclose(found.ended, exact.ended, rtol=1e-12)


@pytest.mark.parametrize("name", CASES)
def test_runs_are_those_of_c(name: str, machine: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """In doubles to 1e-12, fused products apart; however many have room at a time."""
    monkeypatch.setattr(HostMemory, "free", 1 << 17)
    exact = course_of(name, "c")
    values = vary(exact, 5)
    found = course_of(name, "cuda").run(values)
    compare(exact, found, exact.run(values), 1e-12 if machine == "host" else 1e-9)


def test_single_precision_is_said_to_be_what_it_is(machine: str) -> None:
    """A step is solved as well as floats allow, and is called solved; what is off is far below what a model knows."""
    exact = course_of("pwm_bias_spring", "c")
    values = vary(exact, 3)
    found = course_of("pwm_bias_spring", "cuda", precision="float32").run(values)
    compare(exact, found, exact.run(values), 2e-4)
    doubled = course_of("pwm_bias_spring", "cuda").run(values)
    assert np.abs(found.columns["stress"] - doubled.columns["stress"]).max() > 0.0


def test_a_batch_takes_its_chunk(machine: str) -> None:
    """What `ms.run` and `simulate_batch` return, made two runs at a time."""
    course = course_of("pwm_bias_spring", "c")
    (wave,) = course.waveforms.values()
    given = (course.system, wave, 2.0, vary(course, 5))
    found, exact = (simulate_batch(*given, step=STEP, samples=11, runtime=name, chunk=2) for name in ("cuda", "c"))
    assert found.runtime == "CUDA"
    assert np.abs(found["position"] - exact["position"]).max() <= 1e-9 * np.ptp(exact["position"])


def test_runs_with_signals_and_limits_of_their_own(machine: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Steps that differ from run to run; runs that leave the envelope, and a limit of it that varies; refused ones."""
    monkeypatch.setattr(march, "OWN_SIGNALS", 1 << 15)  # in blocks of a few
    courses = {runtime: course_of("pwm_bias_spring", runtime) for runtime in ("c", "cuda")}
    leaves = {leaf.path: leaf.value for leaf in courses["c"].system.leaves()}
    stop = next(path for path in leaves if path.endswith("temperature_stop"))
    (drive,) = courses["c"].waveforms
    values = {
        "element.diameter": leaves["element.diameter"] * np.array([1.0, 1.01, -1.0, 1.02, 0.99]),
        stop: leaves[stop] * np.array([1.0, 0.2, 1.0, 1.0, 1.0]),
    }
    signals = {drive: {"duty": np.array([0.2, 0.5, 0.3, 0.3, 0.6])}}
    exact, found = (course.run(values, signals) for course in courses.values())
    compare(courses["c"], found, exact, 1e-12 if machine == "host" else 1e-9)
    assert Status.REFUSED in exact.status and Status.OUT_OF_ENVELOPE in exact.status


def test_runs_to_a_tolerance(machine: str) -> None:
    """The C of single runs as it stands: each run is as exact as it says, whatever drives it."""
    courses = {runtime: replace(course_of("pwm_bias_spring", runtime), step=None) for runtime in ("c", "cuda")}
    values = vary(courses["c"], 3)
    for signals in ({}, {next(iter(courses["c"].waveforms)): {"duty": np.array([0.2, 0.3, 0.6])}}):
        exact, found = (course.run(values, signals) for course in courses.values())
        assert found.status.tolist() == [Status.OK] * 3
        assert np.all(found.accuracy <= 1e-4)
        for name, least in courses["c"].system.convergence_scales().items():
            apart = np.abs(found.columns[name] - exact.columns[name]).max(axis=1)
            scale = np.maximum(np.ptp(exact.columns[name], axis=1), least)
            assert np.all(apart <= (found.accuracy + exact.accuracy) * scale)


# ---------------------------------------------------------------- compiling


@pytest.mark.parametrize("precision", ["float64", "float32"])
def test_nvrtc_compiles_what_is_printed(precision: str) -> None:
    pytest.importorskip("cuda.bindings", reason="cuda-bindings is not installed")
    course = course_of("pwm_bias_spring", "cuda")
    source = MarchSource(course.compiled, course.places, (0, 1), precision)
    assert len(device.compile_source(source.text, "sm_90")) > 10_000


def test_nvrtc_compiles_the_c_of_single_runs() -> None:
    pytest.importorskip("cuda.bindings", reason="cuda-bindings is not installed")
    course = replace(course_of("pwm_bias_spring", "c"), step=None)
    kernel = kernel_of(course.plan, course.places, 1)
    made = device.compile_source(to_ends.print_source(kernel), "compute_90", (*to_ends.FLAGS, "--device-debug"))
    assert b"march_to_ends" in made  # to debug: NVRTC optimises for six seconds


def test_a_changed_number_compiles_nothing() -> None:
    course = course_of("pwm_bias_spring", "cuda")
    changed = course.system.with_values({"length": 0.123})
    other = VariantSetup(changed, course.waveforms, 2.0, 21, STEP, course.outputs, "cuda")
    assert MarchSource(other.compiled, other.places, (1,)) == MarchSource(course.compiled, course.places, (1,))


def test_targets() -> None:
    """Machine code where NVRTC knows the device, PTX for newer ones, a sentence for older ones."""
    assert device.choose_target(90, [75, 90, 100]) == "sm_90"
    assert device.choose_target(95, [75, 90, 100]) == "compute_90"
    with pytest.raises(InputError, match=r"compute capability 7\.0"):
        device.choose_target(70, [75, 90])


def test_without_a_device(tmp_path: Path) -> None:
    """One sentence, exit code 2, and nothing written."""
    if has_device():
        pytest.skip("there is a CUDA device")
    out = tmp_path / "s.zarr"
    words = ["sweep", str(EXAMPLES / "pwm_bias_spring.toml"), "--over", "diameter=0.2..0.3 mm:3", "--step", "20 ms"]
    said = Command(*words, "--runtime", "cuda", "--out", str(out)).refused()
    assert "CUDA device" in str(said) or "cuda-bindings" in str(said)
    assert not out.exists()
    (table,) = sections_cuda.cuda(Options([]))
    assert not table.rows and "Left out" in table.note
