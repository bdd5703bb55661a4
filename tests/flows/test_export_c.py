"""C cores: the same numbers as the march on floats, and answers to whatever a caller does.

Source of truth: the kernels on plain floats with patient steps, of which the C must be the same
bit for bit; the documented meaning of every status; operations counted by hand.
"""

from __future__ import annotations

import csv
import ctypes
import io
import math
import random
import shutil
import subprocess
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from builders import problem_a, volts_a
from c_cores import BAD_INPUT, LONG_STEP, NOT_FINITE, OK, UNSOLVED, Called, built, compiled

from martensite.actuators.assembly import AbstractSystem
from martensite.base.errors import InputError, ParameterError
from martensite.control.controllers.base import AbstractController
from martensite.control.controllers.iterative_learning import IterativeLearning
from martensite.control.controllers.mpc import Mpc
from martensite.control.controllers.pid import Pid
from martensite.control.controllers.relay_tuning import RelayTuning
from martensite.control.loop.bench import Bench
from martensite.control.loop.parts import Controllers, MountedSensor, Observers, Sensors
from martensite.control.loop.realtime import RealtimeStep
from martensite.control.loop.run import simulate_bench
from martensite.control.observers.extended import ExtendedKalman
from martensite.control.sensors.position import PositionSensor
from martensite.export.c_core import build_c_core, build_c_loop
from martensite.export.c_example import example_text, list_run_inputs
from martensite.export.c_kernels import PRECISIONS, count_operations
from martensite.export.c_names import choose_identifier
from martensite.kernels.program import Program
from martensite.physics.electrical.switches import PwmVoltage
from martensite.signals.sine import Sine
from martensite.simulate.compiled import bind_system

pytestmark = pytest.mark.usefixtures("c_compiler")

MM, PERIOD = 1e-3, 0.02
SYSTEM = problem_a()
PLANT = SYSTEM.with_parts(source=PwmVoltage(supply=6.0))
COURSE = Sine(low=1 * MM, high=5 * MM, frequency=0.5)
BENCH = Bench(
    plant=PLANT,
    period=PERIOD,
    substeps=2,
    sensors=Sensors(position=MountedSensor(sensor=PositionSensor(noise=0.02 * MM), delay=2 * PERIOD, jitter=PERIOD)),
    controllers=Controllers(drive=Pid(measured="position", reference=COURSE, Kp=150.0, Ki=300.0, Kd=0.4)),
)
WATCHED = BENCH.with_parts(
    observers=Observers(ekf=ExtendedKalman(model=PLANT, measured=("position",), reading_deviation=0.02 * MM))
)

Steps = list[tuple[tuple[float, ...], float]]


def pulses(count: int, seed: int = 0) -> Steps:
    """Inputs and lengths of steps: pulses far beyond the rating of the wire, and rests."""
    rng = random.Random(seed)
    return [((rng.choice((0.0, 0.0, 30.0 * rng.random())),), 10.0 ** rng.uniform(-3.0, 0.5)) for _ in range(count)]


def followed(count: int, seed: int = 0) -> Steps:
    """References with noise and jitter of a sensor."""
    rng = random.Random(seed)
    return [((COURSE.value(k * PERIOD), rng.gauss(0.0, 1.0), rng.gauss(0.0, 1.0)), PERIOD) for k in range(count)]


def on_floats(
    system: AbstractSystem, steps: Steps, first: tuple[float, ...] | None = None
) -> Iterator[tuple[Any, Any]]:
    """State and outputs after every step, as a run has them."""
    (functions, size), first = bind_system(system), first or steps[0][0]
    state = functions["init"](*first)
    yield state, functions["observe"](*state, *first)
    for inputs, dt in steps:
        state = functions["step"](*state, *inputs, dt)[:size]
        yield state, functions["observe"](*state, *inputs)


def in_c(called: Called, steps: Steps) -> Iterator[tuple[Any, Any]]:
    """The same in C."""
    assert called.start(*steps[0][0]) == OK
    yield called.state, called.observe(*steps[0][0])[1]
    for inputs, dt in steps:
        assert called.step(*inputs, dt=dt) in (OK, LONG_STEP)
        status, seen = called.observe(*inputs)
        assert status == OK
        yield called.state, seen


def differing(system: AbstractSystem, called: Called, steps: Steps) -> int:
    """Steps after which not all numbers of C and Python are the same."""
    rows = zip(on_floats(system, steps), in_c(called, steps), strict=True)
    return sum(one != other for one, other in rows)


@pytest.fixture(scope="module")
def wire(tmp_path_factory: pytest.TempPathFactory, c_compiler: str) -> Called:
    return Called(build_c_core(SYSTEM, name="wire"), tmp_path_factory.mktemp("wire"))


@pytest.fixture(scope="module")
def bench(tmp_path_factory: pytest.TempPathFactory, c_compiler: str) -> Called:
    return Called(build_c_core(BENCH, name="bench"), tmp_path_factory.mktemp("bench"))


@pytest.fixture
def started(wire: Called) -> Called:
    """The wire somewhere on its way, with the parameters of the scenario."""
    wire.call("defaults")
    assert wire.start(0.0) == OK
    for k in range(20):
        assert wire.step(volts_a(0.1 * k), dt=0.1) == OK
    return wire


# ---------------------------------------------------------------- bit for bit


def test_a_wire_is_the_same_bit_for_bit(wire: Called) -> None:
    steps = pulses(2000)
    assert differing(SYSTEM, wire, steps) == 0


def test_a_bench_is_the_same_bit_for_bit(bench: Called) -> None:
    assert differing(BENCH, bench, followed(500)) == 0


@pytest.mark.slow
def test_long_runs_are_the_same_bit_for_bit(wire: Called, bench: Called) -> None:
    assert differing(SYSTEM, wire, pulses(20_000, seed=1)) == 0
    assert differing(BENCH, bench, followed(20_000, seed=1)) == 0


def test_a_bit_elsewhere_is_found(wire: Called) -> None:
    path = "environment.temperature"
    beside = SYSTEM.with_values({path: math.nextafter(SYSTEM.value_of(path), 0.0)})
    assert differing(beside, wire, pulses(20)) > 0


def test_changed_parameters_are_those_of_another_system(wire: Called) -> None:
    changes = {"element.diameter": 0.3e-3, "mechanism.stiffness": 700.0}
    wire.call("defaults")
    for name, value in changes.items():
        wire.set(name, value)
    assert wire.prepare() == OK
    assert differing(SYSTEM.with_values(changes), wire, pulses(100)) == 0
    wire.call("defaults")
    assert differing(SYSTEM, wire, pulses(100)) == 0


def test_a_loop_is_that_of_the_bench_bit_for_bit(tmp_path: Path) -> None:
    core = build_c_loop(WATCHED, name="loop")
    names = ["position", "position.age", "reference"]
    assert [(one.name, one.unit) for one in core.inputs] == list(zip(names, ["m", "s", "m"], strict=True))
    assert core.outputs[0].name == "drive"
    assert core.sample_time == PERIOD
    assert len(core.parameters) < len(list(WATCHED.leaves()))
    called, plain = Called(core, tmp_path), RealtimeStep(WATCHED, native=False)
    rng = random.Random(0)
    for k in range(300):
        read, age = 3 * MM * rng.random(), PERIOD * rng.random()
        reference = COURSE.value(k * PERIOD)
        (meant,) = plain.step({"position": read, "position.age": age}, references=[reference])
        given = (read, age, reference)
        status = called.step(*given, dt=PERIOD) if k else called.start(*given)
        assert status == OK
        status, (signal, *estimates) = called.observe(*given)
        assert (status, signal, estimates) == (OK, meant, list(plain.estimates.values()))


LEARNING = IterativeLearning(
    measured="position", reference=COURSE, Kp=150.0, learning_gain=100.0, period=PERIOD, task=2.0, points=20, lead=0.1
)
TUNING = RelayTuning(measured="position", reference=COURSE, level=3 * MM, skipped=1.0, cycles=2.0)


@pytest.mark.parametrize("one", [LEARNING, TUNING], ids=["learning", "tuning"])
def test_a_loop_says_what_its_controller_says(one: AbstractController, tmp_path: Path) -> None:
    """As on the bench, and readings of the bench lead to the same signals."""
    bench = Bench(plant=PLANT, period=PERIOD, substeps=2, controllers=Controllers(drive=one))
    run = simulate_bench(bench, 8.0, runtime="floats")
    core = build_c_loop(bench, name="loop")
    names = [name for name in run.columns if name.startswith("controller.")]
    assert [row.name for row in core.outputs] == ["drive", *names]
    called, columns = Called(core, tmp_path), [run[name] for name in ("wanted", *names)]
    for k, (read, wanted) in enumerate(zip(run["position"], run["reference"], strict=True)):
        given = (read, 0.0, wanted)
        assert (called.step(*given, dt=PERIOD) if k else called.start(*given)) == OK
        assert called.observe(*given)[1] == pytest.approx([column[k] for column in columns], rel=1e-9, abs=1e-12)
    assert any(values[-1] != values[0] for values in columns[1:])


def test_a_loop_that_looks_ahead_takes_what_lies_there(tmp_path: Path) -> None:
    planned = Mpc(model=PLANT, measured="position", reference=COURSE, period=PERIOD, horizon=0.6, blocks=2)
    looking = BENCH.with_parts(controllers=Controllers(drive=planned))
    core = build_c_loop(looking, name="planned")
    ahead = ["reference.ahead.1", "reference.ahead.2"]
    assert [one.name for one in core.inputs] == ["position", "position.age", "reference", *ahead]
    called, plain = Called(core, tmp_path), RealtimeStep(looking, native=False)
    found: list[float] = []
    for k in range(12):
        references = [COURSE.value(k * PERIOD + lead) for lead in (0.0, 0.3, 0.6)]
        (meant,) = plain.step({"position": 0.1 * MM * k}, references=references)
        given = (0.1 * MM * k, 0.0, *references)
        assert (called.step(*given, dt=PERIOD) if k else called.start(*given)) == OK
        found.append(called.observe(*given)[1][0])
        assert found[-1] == meant
    assert len(set(found)) > 3


FLOAT_BOUND = 2e-5
"""Of outputs in float32, as a share of their range, over 2000 steps of a run."""


def test_float32_stays_close(tmp_path: Path) -> None:
    steps: Steps = [((volts_a(0.02 * k),), 0.02) for k in range(2000)]
    single = Called(build_c_core(SYSTEM, name="single", precision="float32"), tmp_path)
    meant, found = (np.array([seen for _, seen in rows]) for rows in (on_floats(SYSTEM, steps), in_c(single, steps)))
    span = np.ptp(meant, axis=0)
    moving = span > 0.0
    error = np.abs(found - meant).max(axis=0)[moving] / span[moving]
    assert 1e-8 < error.max() < FLOAT_BOUND


# ---------------------------------------------------------------- failures are statuses

BAD = [math.nan, math.inf, -math.inf]


@pytest.mark.parametrize("value", BAD)
def test_bad_inputs_change_nothing(started: Called, value: float) -> None:
    before = started.everything
    assert started.step(value, dt=0.1) == BAD_INPUT
    assert started.step(1.0, dt=value) == BAD_INPUT
    assert started.start(value) == BAD_INPUT
    assert started.observe(value) == (BAD_INPUT, (0.0,) * len(started.core.outputs))
    assert started.everything == before


def test_a_step_of_no_time_keeps_the_state_and_none_goes_back(started: Called) -> None:
    before = started.everything
    assert started.step(3.0, dt=0.0) == OK
    assert started.step(3.0, dt=-0.1) == BAD_INPUT
    assert started.everything == before


@pytest.mark.parametrize("value", [*BAD, 0.0, -1.0])
def test_bad_parameters_are_refused(started: Called, value: float) -> None:
    rest = tuple(started.model.c), started.state
    started.set("element.diameter", value)
    assert started.prepare() == BAD_INPUT
    assert (tuple(started.model.c), started.state) == rest
    assert started.step(1.0, dt=0.1) == OK  # with the parameters before


def test_no_number_is_ever_none(wire: Called) -> None:
    """Whatever a caller does, and whatever it is told."""
    rng, found = random.Random(3), set[tuple[str, int]]()
    for _ in range(300):
        wire.call("defaults")
        for one in rng.sample(wire.core.parameters, 3):
            low, high = (max(min(end, 1e300), -1e300) for end in (one.low, one.high))
            wire.model.p[one.index] = rng.choice((low, high, one.default, 0.0, math.nan))
        found.add(("prepare", wire.prepare()))
        found.add(("start", wire.start(rng.choice((0.0, 1.0, 1e300)))))
        for _ in range(5):
            before, dt = wire.state, 10.0 ** rng.uniform(-300.0, 300.0)
            status = wire.step(rng.choice((0.0, 1.0, 1e10, 1e300)), dt=dt)
            found.add(("step", status))
            assert status <= LONG_STEP or wire.state == before
            _, seen = wire.observe(rng.choice((0.0, 1e300)))
            told = (*wire.state, *seen, wire.model.residual, wire.model.crossing)
            assert all(map(math.isfinite, told))
    assert {("prepare", OK), ("prepare", BAD_INPUT), ("step", OK)} <= found
    assert ("step", NOT_FINITE) in found


def test_a_step_that_is_not_solved_leaves_the_state(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Of a core to which no step is solved."""
    hard = replace(PRECISIONS["float64"], solved=-1.0)
    monkeypatch.setitem(PRECISIONS, "float64", hard)
    core = Called(build_c_core(SYSTEM, name="hard"), tmp_path)
    core.call("defaults")
    assert core.start(0.0) == OK
    before = core.state
    assert core.step(2.0, dt=0.01) == UNSOLVED
    assert core.state == before


def test_pulses_leave_no_step_unsolved(wire: Called) -> None:
    """What an unsolved step leaves is looked at above."""
    wire.call("defaults")
    assert wire.start(0.0) == OK
    assert {wire.step(*inputs, dt=dt) for inputs, dt in pulses(300)} <= {OK, LONG_STEP}


def test_a_bench_steps_by_its_period(bench: Called) -> None:
    assert bench.start(0.0, 0.0, 0.0) == OK
    before = bench.everything
    assert bench.step(0.0, 0.0, 0.0, dt=0.5 * PERIOD) == BAD_INPUT
    assert bench.everything == before
    assert bench.step(0.0, 0.0, 0.0, dt=PERIOD * (1.0 + 1e-9)) == OK


def test_a_model_is_saved_by_copying_it(started: Called) -> None:
    saved = started.everything
    assert len(saved) == started.core.size
    rows = [(started.step(4.0, dt=0.1), started.state) for _ in range(5)]
    ctypes.memmove(ctypes.byref(started.model), saved, len(saved))
    assert [(started.step(4.0, dt=0.1), started.state) for _ in range(5)] == rows


# ---------------------------------------------------------------- what is written


SOURCES = {
    "bench float32": lambda: build_c_core(BENCH, name="a", precision="float32"),
    "loop float64": lambda: build_c_loop(WATCHED, name="a"),
    "loop float32": lambda: build_c_loop(WATCHED, name="a", precision="float32"),
}


@pytest.mark.parametrize("name", SOURCES)
def test_it_compiles_without_warnings(tmp_path: Path, name: str) -> None:
    compiled(SOURCES[name](), tmp_path, "-fsyntax-only")


def test_warnings_are_errors(tmp_path: Path) -> None:
    core = build_c_core(SYSTEM, name="a", precision="float32")
    bad = replace(core)
    vars(bad)["source"] = core.source.replace("sinf(", "sin(")
    assert bad.source != core.source
    with pytest.raises(AssertionError, match=r"double-promotion|conversion"):
        compiled(bad, tmp_path, "-fsyntax-only")


def test_the_header_is_one_of_cpp_too(tmp_path: Path) -> None:
    cpp = shutil.which("g++")
    if cpp is None:
        pytest.skip("no C++ compiler on this machine")
    build_c_core(SYSTEM, name="a").write(tmp_path)
    (tmp_path / "user.cpp").write_text('#include "a.h"\nint main() { return a_OK; }\n')
    command = [cpp, "-Wall", "-Wextra", "-Werror", "-fsyntax-only", "user.cpp"]
    subprocess.run(command, cwd=tmp_path, check=True)


def test_it_needs_no_library_but_libm(tmp_path: Path) -> None:
    if shutil.which("nm") is None:
        pytest.skip("no nm on this machine")
    path = compiled(build_c_core(SYSTEM, name="a"), tmp_path, "-c")
    listed = subprocess.run(["nm", str(path)], capture_output=True, text=True, check=True).stdout
    rows = [line.split()[-2:] for line in listed.splitlines()]
    wanted = {name for kind, name in rows if kind == "U"}
    assert {"sin"} <= wanted <= {"sin", "exp", "log", "sqrt", "fabs", "memcpy", "memset"}
    assert {kind for kind, _ in rows} <= {"U", "T", "t", "r"}  # no variables outside of a model


def test_the_example_prints_what_the_model_does(bench: Called, tmp_path: Path) -> None:
    first, steps = list_run_inputs(BENCH, {}, 10.0, 10)
    source, program = tmp_path / "example.c", tmp_path / "example"
    source.write_text(example_text(bench.core, first, steps), encoding="utf-8")
    built([str(source), f"-I{bench.path.parent}", str(bench.path)], program)
    done = subprocess.run([program], capture_output=True, text=True, check=True)
    title, *rows = csv.reader(io.StringIO(done.stdout))
    assert title == ["time", *BENCH.outputs()]
    given = [(inputs, length) for length, inputs in steps]
    meant = [list(seen) for _, seen in on_floats(BENCH, given, first)]
    assert [list(map(float, row[1:])) for row in rows] == meant
    assert float(rows[-1][0]) == pytest.approx(50 * PERIOD)


def test_what_is_in_it_is_said() -> None:
    core = build_c_core(SYSTEM, name="a")
    assert [one.name for one in core.parameters] == [leaf.path for leaf in SYSTEM.leaves()]
    diameter = next(one for one in core.parameters if one.name == "element.diameter")
    assert (diameter.unit, diameter.default, diameter.has_effect) == ("m", 0.381e-3, True)
    line = f"    a_p_element_diameter = {diameter.index}, /* [m] {diameter.words} */"
    assert line in core.header.splitlines()
    assert [(one.name, one.unit) for one in core.inputs] == [("drive", "V")]
    assert [one.name for one in core.outputs][:13] == list(SYSTEM.outputs())[:13]
    assert core.operations.keys() == {"prepare", "start", "step", "observe"}


def test_operations_are_those_counted_by_hand() -> None:
    program = Program()
    k = program.parameter("k")

    def kernel(xp: Any, x: Any, y: Any) -> list[Any]:
        rate = xp.exp(k * k) * x  # exp(k²) is known beforehand: 1 mul
        (sums,) = xp.each(lambda a: (xp.sqrt(a + y) / rate,), [x, y, x + y])  # 3 (add sqrt div)
        (end,) = xp.repeat(5, lambda z: (z - z * x,), sums[0])  # 5 (mul add)
        return [end + sums[1] + sums[2], xp.where(x < y, end, rate), end]  # 2 add, compare, select

    program.add("f", ["x", "y"], kernel)
    outputs = program.functions["f"].outputs
    assert count_operations(program.graph, outputs, program.hoisted_nodes) == {
        "add": 1 + 3 + 5 + 2,
        "mul": 1 + 5,
        "div": 3,
        "sqrt": 3,
        "compare": 1 + 3,
        "select": 1 + 3,
    }
    assert count_operations(program.graph, program.hoisted_nodes) == {"mul": 1, "exp": 1, "compare": 1, "select": 1}


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"name": "2wires"}, "try `m_2wires`"),
        ({"name": "float"}, "must be an identifier"),
        ({"precision": "float16"}, "Did you mean `float"),
    ],
)
def test_what_cannot_be_is_refused(arguments: dict[str, str], words: str) -> None:
    with pytest.raises(InputError, match=words):
        build_c_core(SYSTEM, **arguments)  # type: ignore[arg-type]


def test_a_loop_needs_a_controller() -> None:
    with pytest.raises(ParameterError, match="without controllers"):
        build_c_loop(Bench(plant=PLANT, period=PERIOD))


def test_identifiers() -> None:
    assert choose_identifier(None, "wire (brinson) on bias-spring") == "wire_brinson_on_bias_spring"
    assert [choose_identifier(None, name) for name in ("", "for", "3d")] == ["m", "m_for", "m_3d"]
