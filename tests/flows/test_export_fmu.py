"""FMUs: driven as `simulate` is they give its numbers, and what is wrong is refused with a reason.

Source of truth: `simulate` on the same steps and inputs; FMPy's validation against the schemas
and rules of FMI 2.0 and 3.0; libcosim as a second importer.
"""

from __future__ import annotations

import ctypes
import math
import re
import subprocess
import zipfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from martensite.base.errors import InputError, MartensiteError, ParameterError, UnitError
from martensite.base.units import find_dimensions
from martensite.control.loop.run import simulate_bench
from martensite.export.fmu import Fmu, binaries, to_fmu
from martensite.export.fmu.variables import base_units
from martensite.scenario.scenario import Scenario, read_scenario
from martensite.signals.held import Held
from martensite.signals.table import Table
from martensite.simulate.api import simulate

fmpy = pytest.importorskip("fmpy")
from fmpy.validation import validate_fmu  # noqa: E402
from fmu_instance import DISCARD, ERROR, OK, WARNING, Instance  # noqa: E402
from one_wire import THIN_WIRE  # noqa: E402

pytestmark = pytest.mark.usefixtures("c_compiler")

SCENARIO = f"""{THIN_WIRE}
[drive]
kind = "voltage"
waveform = {{ kind = "constant", level = "3 V" }}

[run]
duration = "4 s"
samples = 81
step = "10 ms"
"""
LOOP = f"""{THIN_WIRE}
[driver]
kind = "mosfet"
supply = "5 V"
on_resistance = "0.03 ohm"
frequency = "1 kHz"

[sensor]
kind = "position"
delay = "40 ms"

[controller]
kind = "pid"
measured = "position"
period = "20 ms"
Kp = 150
Ki = 75

[reference]
kind = "constant"
level = "3 mm"

[run]
duration = "3 s"
"""
STEP, COUNT = 0.05, 80
FED = ("drive_echo", "current", "voltage", "power")
"""Outputs that follow the input at once: `simulate` shows them after a jump, an FMU before it."""
VERSIONS = ("2.0", "3.0")


@pytest.fixture(scope="module")
def scenario() -> Scenario:
    return read_scenario(SCENARIO)


@pytest.fixture(scope="module")
def made(scenario: Scenario, tmp_path_factory: pytest.TempPathFactory) -> dict[str, Fmu]:
    """A wire as an FMU of every version, and a loop."""
    folder, here = tmp_path_factory.mktemp("fmu"), [binaries.find_target()]
    found = {v: to_fmu(scenario, folder / f"wire{v[0]}.fmu", fmi=v, platforms=here) for v in VERSIONS}
    return found | {"loop": to_fmu(read_scenario(LOOP), folder / "loop.fmu", platforms=here)}


@pytest.fixture(params=VERSIONS)
def wire(request: pytest.FixtureRequest, made: dict[str, Fmu]) -> Iterator[Instance]:
    """A wire that is not initialized yet, in both versions."""
    instance = Instance(made[request.param].path)
    yield instance
    instance.close()


def played(path: Path, levels: list[float], outputs: list[str], **start: float) -> Any:
    """Outputs by FMPy's simulation, under levels that are held for a step each."""
    times = [STEP * k for k in range(len(levels) + 1)]
    rows = [(t, u) for k, u in enumerate(levels) for t, u in ((times[k], u), (times[k + 1], u))]
    signal = np.array(rows, dtype=[("time", float), ("drive", float)])
    return fmpy.simulate_fmu(
        str(path), stop_time=times[-1], output_interval=STEP, input=signal, output=outputs, start_values=start
    )


def apart(found: Any, columns: dict[str, Any], name: str) -> Any:
    """Differences of a column, as a share of its largest value."""
    wanted = np.array(columns[name.removesuffix("_echo")])
    return np.abs(found[name] - wanted) / np.abs(wanted).max()


LEVELS = [float(u) for u in np.repeat(np.random.default_rng(3).uniform(0.0, 8.0, COUNT // 2), 2)]


@pytest.mark.parametrize("version", VERSIONS)
def test_an_fmu_gives_the_numbers_of_a_run(version: str, made: dict[str, Fmu], scenario: Scenario) -> None:
    """Every level is held for two steps: within it outputs follow the same input."""
    outputs = [one.name for one in made[version].select_variables("output")]
    given = {"mechanism.preload": 1.4, "drive.series_resistance": 0.3}
    found = played(made[version].path, LEVELS, outputs, **given)
    system = scenario.system.with_values({"preload": 1.4, "series_resistance": 0.3})
    waveform = Held(values=tuple(LEVELS), frequency=1.0 / STEP)
    wanted = simulate(system, waveform, COUNT * STEP, step=0.01, samples=COUNT + 1)
    assert wanted.range("martensite_fraction") > 0.5
    for name in outputs:
        differences = apart(found, wanted.columns, name)
        assert (differences[1::2] if name in FED else differences).max() < 1e-9, name


def test_other_parameters_give_other_numbers(made: dict[str, Fmu]) -> None:
    """The comparison can fail: the preload matters."""
    usual, other = (
        played(made["2.0"].path, LEVELS, ["position"], **given)["position"]
        for given in ({}, {"mechanism.preload": 1.4})
    )
    assert np.abs(usual - other).max() > 1e-4


def test_inputs_with_slopes_are_followed_within_a_step(made: dict[str, Fmu], scenario: Scenario) -> None:
    """FMI 2.0: a slope over a step gives what a line between samples gives.

    But for the squares of the line within an inner step, of which the core takes the middle.
    """
    times = [0.1 * k for k in range(31)]
    levels = [4.0 * math.sin(0.7 * t) for t in times]
    table = Table(times=tuple(times), values=tuple(levels))
    wanted = simulate(scenario.system, table, 3.0, step=0.01, samples=31)
    instance = Instance(made["2.0"].path).begin()
    for k in range(30):
        instance.set({"drive": levels[k]})
        slope = (levels[k + 1] - levels[k]) / (times[k + 1] - times[k])
        instance.fmu.setRealInputDerivatives([0], [1], [slope])
        assert instance.step(times[k], times[k + 1] - times[k]) == OK
        for name in ("temperature", "position", "current", "drive_echo"):
            expected = wanted[name.removesuffix("_echo")][k + 1]
            assert instance.get(name)[0] == pytest.approx(expected, rel=1e-5, abs=1e-5)
    instance.close()


def test_a_loop_gives_the_numbers_of_its_run(made: dict[str, Fmu]) -> None:
    """A step over three periods, and one over half of one, which holds what was sampled."""
    outputs = [one.name for one in made["loop"].select_variables("output")]
    bench = read_scenario(LOOP).bench
    assert bench is not None
    wanted = simulate_bench(bench, 3.0, seed=None)
    assert wanted.range("position") > 2e-3
    instance, period = Instance(made["loop"].path).begin(), 0.02
    sample, time = 0, 0.0
    for pieces in [0.5, 0.5, 3.0, 1.0, 1.5, 1.5, *[2.0] * 60]:
        assert instance.step(time, pieces * period) == OK
        time += pieces * period
        sample = math.floor(time / period + 1e-6)
        columns = [wanted[name.removesuffix("_echo")][sample] for name in outputs]
        assert instance.get(*outputs) == pytest.approx(columns, rel=1e-9, abs=1e-15)
    assert sample == 128
    instance.close()


def test_what_decides_the_program_of_a_loop_is_constant(made: dict[str, Fmu]) -> None:
    """Period and delay fix how much is kept; they are shown but cannot be set."""
    assert {one.name for one in made["loop"].select_variables("local")} == {"controller.period", "sensor.delay"}
    instance = Instance(made["loop"].path)
    assert instance.set({"sensor.delay": 0.1}) == ERROR
    assert "is a constant" in instance.said[-1]
    assert instance.set({"controller.Kp": 100.0, "reference": 2e-3}) == OK
    instance.close()


def test_a_second_importer_gives_the_same(made: dict[str, Fmu]) -> None:
    """libcosim, FMI 2.0."""
    pytest.importorskip("libcosimpy")
    from libcosimpy.CosimExecution import CosimExecution
    from libcosimpy.CosimLogging import CosimLogLevel, log_output_level
    from libcosimpy.CosimManipulator import CosimManipulator
    from libcosimpy.CosimObserver import CosimObserver
    from libcosimpy.CosimSlave import CosimLocalSlave

    log_output_level(CosimLogLevel.FATAL)
    execution = CosimExecution.from_step_size(step_size=int(STEP * 1e9))
    slave = execution.add_local_slave(CosimLocalSlave(str(made["2.0"].path), "wire"))
    observer, manipulator = CosimObserver.create_last_value(), CosimManipulator.create_override()
    execution.add_observer(observer)
    execution.add_manipulator(manipulator)
    names = ["temperature", "martensite_fraction", "position", "current"]
    references = [one.reference for n in names for one in made["2.0"].variables if one.name == n]
    rows: list[list[float]] = []
    for level in LEVELS:
        manipulator.slave_real_values(slave, [0], [level])
        execution.step()
        rows.append(list(observer.last_real_values(slave, references)))
    found = played(made["2.0"].path, LEVELS, names)
    for name, column in zip(names, np.transpose(rows), strict=True):
        assert np.abs(column - found[name][1:]).max() < 1e-9 * np.abs(found[name]).max(), name


# ---------------------------------------------------------------- description and archive


@pytest.mark.parametrize("which", [*VERSIONS, "loop"])
def test_descriptions_are_valid(which: str, made: dict[str, Fmu]) -> None:
    """Schema, names, structure, start values, units."""
    assert validate_fmu(str(made[which].path)) == []


def test_a_wrong_description_is_noticed(made: dict[str, Fmu], tmp_path: Path) -> None:
    """The validation can fail: a unit that nothing defines."""
    broken = tmp_path / "broken"
    with zipfile.ZipFile(made["3.0"].path) as archive:
        archive.extractall(broken)
    described = broken / "modelDescription.xml"
    text = described.read_text("utf-8").replace('unit="V"', 'unit="volts"')
    described.write_text(text, "utf-8")
    assert any("volts" in one for one in validate_fmu(str(broken)))


def test_variables_have_units_bounds_and_lasting_references(made: dict[str, Fmu]) -> None:
    """Inputs from 0, outputs from 100000, parameters from 200000."""
    described = fmpy.read_model_description(str(made["2.0"].path))
    known = {one.name: one for one in described.modelVariables}
    drive, temperature = known["drive"], known["temperature"]
    assert (drive.valueReference, drive.unit, drive.causality) == (0, "V", "input")
    assert temperature.valueReference == 100001
    assert (temperature.unit, temperature.displayUnit) == ("K", "degC")
    diameter = known["element.diameter"]
    assert diameter.valueReference == 200000
    assert (diameter.start, diameter.unit) == ("0.00015", "m")
    assert float(diameter.max) < 1.0
    assert known["inner_step"].valueReference == 300001
    units = {one.name: one for one in described.unitDefinitions}
    stress = units["Pa"].baseUnit
    assert (stress.kg, stress.m, stress.s, stress.K) == (1, -1, -2, 0)
    (celsius,) = units["K"].displayUnits
    assert (celsius.name, float(celsius.factor), float(celsius.offset)) == ("degC", 1.0, -273.15)


def test_units_are_taken_apart() -> None:
    """Exponents of SI base units; a unit that is no coherent one is refused."""
    assert find_dimensions("N*m*s/rad") == {"kg": 1.0, "m": 2.0, "s": -1.0, "rad": -1.0}
    assert find_dimensions("delta_degC") == {"K": 1.0}
    assert base_units("1") == {}
    assert base_units("Pa^0.5") is None
    for wrong in ("mm", "nonsense"):
        with pytest.raises(UnitError, match=wrong):
            find_dimensions(wrong)


def test_an_archive_is_reproducible_and_its_token_follows_its_content(made: dict[str, Fmu], tmp_path: Path) -> None:
    """The same bytes from the same scenario; another token from another number."""
    again = to_fmu(read_scenario(SCENARIO), tmp_path / "wire2.fmu", platforms=[binaries.find_target()])
    assert again.path.read_bytes() == made["2.0"].path.read_bytes()
    other = read_scenario(SCENARIO, overrides={"mechanism.preload": "1.4 N"})
    changed = to_fmu(other, tmp_path / "wire2.fmu", platforms=[])
    assert changed.token != again.token
    names = set(zipfile.ZipFile(changed.path).namelist())
    assert {"modelDescription.xml", "sources/all.c", "resources/scenario.toml"} <= names
    assert not any(name.startswith("binaries") for name in names)


def compiled(compiler: str, sources: Path, library: Path) -> None:
    """A library of all.c, with every warning an error."""
    flags = ["-std=c99", "-O0", "-Wall", "-Wextra", "-Werror", "-fPIC", "-shared"]
    command = [compiler, *flags, "all.c", "-o", str(library), "-lm"]
    subprocess.run(command, cwd=sources, check=True)


def test_sources_alone_can_be_compiled(made: dict[str, Fmu], c_compiler: str, tmp_path: Path) -> None:
    """From all.c in an empty folder, with every warning an error; the numbers are the same."""
    with zipfile.ZipFile(made["3.0"].path) as archive:
        archive.extractall(tmp_path)
    (library,) = (tmp_path / "binaries").glob("*/*")
    before = played(tmp_path, LEVELS, ["position"])["position"]
    library.unlink()
    flags = ["-std=c99", "-O0", "-Wall", "-Wextra", "-Werror", "-fPIC", "-shared"]
    sources = tmp_path / "sources"
    subprocess.run([c_compiler, *flags, "all.c", "-o", str(library), "-lm"], cwd=sources, check=True)
    after = played(tmp_path, LEVELS, ["position"])["position"]
    assert np.abs(after - before).max() < 1e-12


def test_every_function_of_the_standard_is_there(made: dict[str, Fmu], tmp_path: Path) -> None:
    """Those that FMPy's copies of the headers name."""
    headers = Path(fmpy.__file__).parent / "c-code"
    for version in VERSIONS:
        number = version[0]
        text = (headers / f"fmi{number}FunctionTypes.h").read_text("utf-8")
        names = set(re.findall(rf"\b(fmi{number}\w+)TYPE\b", text))
        if version == "2.0":  # those of model exchange alone
            start = text.index("Types for Functions for FMI2 for Model Exchange")
            end = text.index("Types for Functions for FMI2 for Co-Simulation")
            names -= set(re.findall(r"\b(fmi2\w+)TYPE\b", text[start:end]))
        folder = tmp_path / number
        with zipfile.ZipFile(made[version].path) as archive:
            archive.extractall(folder)
        (library,) = (folder / "binaries").glob("*/*")
        loaded = ctypes.CDLL(str(library))
        assert len(names) > 30
        assert [name for name in sorted(names) if not hasattr(loaded, name)] == []


def test_cross_compilers_are_used(scenario: Scenario, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A compiler for Windows on the path: here one that copies the source it is given."""
    folder = tmp_path / "bin"
    folder.mkdir()
    cross = folder / "x86_64-w64-mingw32-gcc"
    cross.write_text('#!/bin/sh\nwhile [ "$1" != all.c ]; do shift; done\ncp all.c "$3"\n')
    cross.chmod(0o755)
    monkeypatch.setenv("PATH", str(folder), prepend=":")
    assert "x86_64-windows" in binaries.checked_targets(None)
    for version, place in (("2.0", "win64"), ("3.0", "x86_64-windows")):
        made = to_fmu(scenario, tmp_path / "wire.fmu", fmi=version, name="w", platforms=["x86_64-windows"])
        with zipfile.ZipFile(made.path) as archive:
            assert archive.read(f"binaries/{place}/w.dll") == archive.read("sources/all.c")
    cross.write_text("#!/bin/sh\necho no such header >&2\nexit 1\n")
    with pytest.raises(MartensiteError, match="no such header"):
        to_fmu(scenario, tmp_path / "wire.fmu", platforms=["x86_64-windows"])


def test_zig_is_used_for_platforms_that_are_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Not by default, for it may take minutes when it is used first."""
    zig = tmp_path / "zig"
    zig.write_text("#!/bin/sh\n")
    zig.chmod(0o755)
    monkeypatch.setenv("PATH", str(tmp_path), prepend=":")
    assert "aarch64-darwin" not in binaries.checked_targets(None)
    assert binaries.checked_targets(["aarch64-darwin"]) == ["aarch64-darwin"]
    assert binaries.find_command("aarch64-darwin") == ["zig", "cc", "-target", "aarch64-macos"]


def test_wrong_arguments_are_refused(scenario: Scenario, tmp_path: Path) -> None:
    """Nothing is written."""
    path = tmp_path / "x.fmu"
    with pytest.raises(InputError, match="No version of FMI named `2`"):
        to_fmu(scenario, path, fmi="2")
    with pytest.raises(InputError, match="No platform named `linux`"):
        to_fmu(scenario, path, platforms=["linux"])
    with pytest.raises(ParameterError, match="`step` must be above 0"):
        to_fmu(scenario, path, step=0.0)
    with pytest.raises(ParameterError, match=r"samples of 0\.02 s"):
        to_fmu(read_scenario(LOOP), path, step=0.01)
    with pytest.raises(ParameterError, match="identifier"):
        to_fmu(scenario, path, name="2 wires")
    assert not path.exists()


def test_the_step_is_that_of_a_run(tmp_path: Path) -> None:
    """Where the scenario leaves it to its tolerance; for a system alone a sensible one."""
    free = read_scenario(SCENARIO.replace('step = "10 ms"', "tolerance = 1e-2"))
    found = to_fmu(free, tmp_path / "a.fmu", platforms=[]).step
    rough = simulate(free.system, free.waveform, free.duration, step=found, samples=free.samples)
    fine = free.run(tolerance=1e-6)
    apart = np.abs(np.subtract(rough["temperature"], fine["temperature"])).max()
    assert apart < 1.1e-2 * fine.range("temperature")
    alone = to_fmu(free.system, tmp_path / "b.fmu", platforms=[])
    assert 0.0 < alone.step < 1.0
    assert "source.series_resistance" in {one.name for one in alone.variables}


# ---------------------------------------------------------------- life and saved states


def advance(instance: Instance, first: int, last: int) -> list[float]:
    """Steps under `LEVELS`; some outputs at their end."""
    for k in range(first, last):
        instance.set({"drive": LEVELS[k]})
        assert instance.step(STEP * k, STEP * (k + 1) - STEP * k) == OK
    return instance.get("temperature", "position", "stress", "current")


def test_a_saved_state_is_gone_back_to(wire: Instance, made: dict[str, Fmu]) -> None:
    """To the last bit, in the instance itself and by its bytes in another one."""
    wire.begin({"mechanism.preload": 1.4})
    advance(wire, 0, 20)
    second = wire.second
    state = (wire.fmu.getFMUstate if second else wire.fmu.getFMUState)()
    data = (wire.fmu.serializeFMUstate if second else wire.fmu.serializeFMUState)(state)
    wanted = advance(wire, 20, 60)
    (wire.fmu.setFMUstate if second else wire.fmu.setFMUState)(state)
    assert advance(wire, 20, 60) == wanted
    other = Instance(made["2.0" if second else "3.0"].path)
    read_back = (other.fmu.deSerializeFMUstate if second else other.fmu.deserializeFMUState)(data)
    (other.fmu.setFMUstate if second else other.fmu.setFMUState)(read_back)
    assert advance(other, 20, 60) == wanted
    for one, kept in ((wire, state), (other, read_back)):
        (one.fmu.freeFMUstate if second else one.fmu.freeFMUState)(kept)
    other.close()


def test_a_state_of_another_size_or_fmu_is_refused(wire: Instance) -> None:
    """By its size, by its token, and by numbers that cannot be; the instance stays as it was."""
    wire.begin()
    before = advance(wire, 0, 5)
    second = wire.second
    save, give = (
        ("serializeFMUstate", "deSerializeFMUstate") if second else ("serializeFMUState", "deserializeFMUState")
    )
    state = (wire.fmu.getFMUstate if second else wire.fmu.getFMUState)()
    data = bytes(getattr(wire.fmu, save)(state))
    assert wire.status(give, data[:-8]) == ERROR
    assert "bytes" in wire.said[-1]
    another = b"1" if data[1:2] == b"0" else b"0"
    assert wire.status(give, data[:1] + another + data[2:]) == ERROR
    assert "not one of this FMU" in wire.said[-1]
    assert wire.status(give, data[:64] + b"\xff" * (len(data) - 64)) == ERROR
    assert "cannot be" in wire.said[-1]
    assert wire.status("setFMUstate" if second else "setFMUState", None) == ERROR
    assert wire.get("temperature", "position", "stress", "current") == before


def test_instances_do_not_know_of_each_other(wire: Instance, made: dict[str, Fmu]) -> None:
    """And a reset makes one new."""
    other = Instance(made["2.0" if wire.second else "3.0"].path).begin({"mechanism.preload": 1.4})
    wire.begin()
    apart = advance(other, 0, 20)
    wanted = advance(wire, 0, 20)
    assert wanted != apart
    assert other.status("reset") == OK
    assert advance(other.begin(), 0, 20) == wanted
    other.close()


# ---------------------------------------------------------------- what is refused


def refused(wire: Instance, status: int, wanted: int, words: str) -> None:
    """A call ended with a status and a sentence through the logger."""
    name = "logStatusDiscard" if wanted == DISCARD else "logStatusError"
    assert status == wanted
    assert wire.said[-1].startswith(f"{wanted} {name}: ")
    assert words in wire.said[-1]
    assert wire.said[-1].endswith(".")


def test_values_that_cannot_be_are_refused(wire: Instance) -> None:
    """None of several is taken if one is refused."""
    wire.begin()
    for value in (math.nan, math.inf):
        refused(wire, wire.set({"drive": value}), ERROR, "must be finite")
    refused(wire, wire.set({"drive": 1.0, 77: 1.0}), ERROR, "value reference 77")
    assert wire.get("drive") == [0.0]
    refused(wire, wire.set({"temperature": 300.0}), ERROR, "cannot be set")
    refused(wire, wire.set({"mechanism.preload": 1.4}), ERROR, "not allowed while stepping")
    assert wire.status("getReal" if wire.second else "getFloat64", [100999]) == ERROR
    assert "value reference 100999" in wire.said[-1]
    assert wire.status("getInteger" if wire.second else "getInt32", [0]) == ERROR
    assert wire.set({"drive": 2.0}) == OK
    assert wire.step(0.0, STEP) == OK
    assert all(map(math.isfinite, wire.get("temperature", "position", "current")))


def test_parameters_out_of_range_are_discarded(wire: Instance) -> None:
    """They stay as they were, and the instance can go on."""
    refused(wire, wire.set({"element.diameter": -1.0}), DISCARD, "`element.diameter` must be")
    refused(wire, wire.set({"inner_step": 0.0}), DISCARD, "`inner_step` must be above 0")
    refused(wire, wire.set({"element.diameter": math.nan}), ERROR, "must be finite")
    assert wire.get("element.diameter") == [0.00015]
    wire.begin()
    assert wire.step(0.0, STEP) == OK


def test_steps_that_cannot_be_are_refused(wire: Instance) -> None:
    """The order of calls, and length and start of a step."""
    refused(wire, wire.step(0.0, STEP), ERROR, "not allowed after instantiation")
    refused(wire, wire.status("exitInitializationMode"), ERROR, "not allowed after instantiation")
    wire.begin()
    refused(wire, wire.step(0.0, -STEP), ERROR, "longer than 0 s")
    refused(wire, wire.step(0.0, math.nan), ERROR, "must be finite")
    refused(wire, wire.step(1.0, STEP), ERROR, "must begin at 0 s")
    assert wire.step(0.0, STEP) == OK
    assert wire.status("terminate") == OK
    refused(wire, wire.step(STEP, STEP), ERROR, "not allowed after termination")


def test_a_step_that_fails_is_discarded_and_then_an_error(
    made: dict[str, Fmu], c_compiler: str, tmp_path: Path
) -> None:
    """Here of a core that gives up above 7 V: the state is as before, and no master hangs."""
    with zipfile.ZipFile(made["2.0"].path) as archive:
        archive.extractall(tmp_path)
    core, (library,) = tmp_path / "sources/wire2_core.c", (tmp_path / "binaries").glob("*/*")
    text = core.read_text("utf-8")
    assert text.count("if (m->residual > ") == 1
    core.write_text(text.replace("if (m->residual > ", "if (u[0] > 7.0 || m->residual > "), "utf-8")
    compiled(c_compiler, core.parent, library)
    wire = Instance(tmp_path).begin()
    before = advance(wire, 0, 5)
    wire.set({"drive": 7.5})
    refused(wire, wire.step(5 * STEP, STEP), DISCARD, "not solved together. Try a shorter one")
    wire.set({"drive": LEVELS[4]})
    assert wire.get("temperature", "position", "stress", "current") == before
    assert wire.step(5 * STEP, STEP) == OK
    time = 6 * STEP
    ends: list[int] = []
    for share in (1.0, 0.5, 0.5):
        wire.set({"drive": 7.5})
        ends.append(wire.step(time, share * STEP))
    assert ends == [DISCARD, DISCARD, ERROR]
    assert "failed again" in wire.said[-1]
    assert wire.fmu.getRealStatus(2) == pytest.approx(time)
    wire.close()


def test_a_step_of_too_many_inner_steps_is_discarded(wire: Instance) -> None:
    """A shorter one is made then."""
    wire.begin({"inner_step": 1e-9})
    refused(wire, wire.step(0.0, 10.0), DISCARD, "too many inner steps")
    assert wire.step(0.0, 1e-6) == OK


def test_parameters_without_a_state_at_rest_end_the_initialization(wire: Instance) -> None:
    """A wire of no section, whose stress is infinite; put right it goes on."""
    wire.set({"element.diameter": 1e-300})
    if wire.second:
        wire.fmu.setupExperiment(startTime=0.0)
    assert wire.status("enterInitializationMode") == OK
    refused(wire, wire.status("exitInitializationMode"), ERROR, "infinite or undefined")
    assert wire.set({"element.diameter": 2e-4}) == OK
    assert wire.status("exitInitializationMode") == OK
    assert wire.step(0.0, STEP) == OK


def test_a_coarse_step_warns_once(made: dict[str, Fmu]) -> None:
    """A long inner step through the transformation."""
    instance = Instance(made["2.0"].path).begin({"inner_step": 2.0})
    instance.set({"drive": 4.0})
    assert {instance.step(2.0 * k, 2.0) for k in range(4)} == {OK}
    warned = [one for one in instance.said if "`inner_step`" in one]
    assert len(warned) == 1
    assert warned[0].startswith(f"{WARNING} ")
    instance.close()


@pytest.mark.parametrize("version", VERSIONS)
def test_a_wrong_token_gives_no_instance(version: str, made: dict[str, Fmu]) -> None:
    """Binary and description are not of the same FMU."""
    with pytest.raises(Exception, match="Failed to instantiate"):
        Instance(made[version].path, token="{wrong}")


def test_what_fmi_3_has_beyond_this_is_refused(made: dict[str, Fmu]) -> None:
    """Events, states, configuration."""
    instance = Instance(made["3.0"].path).begin()
    for name in ("enterEventMode", "enterStepMode"):
        refused(instance, instance.status(name), ERROR, "nothing that this FMU does")
    instance.close()
