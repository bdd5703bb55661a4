"""Loops on emulated boards: AVR under simavr, Cortex-M4 under QEMU, over their emulated serial lines.

Source of truth: the run of the same scenario here, the emulator's own clock, and compilers and cppcheck for sources.
"""

from __future__ import annotations

import json
import random
import shutil
import subprocess
from collections.abc import Iterator
from importlib.resources import files
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
import pytest
from benchmarks.board_link import log_long, send_garbled, start_board
from firmware_on_host import flood
from typer.testing import CliRunner

import martensite as ms
from martensite.boards.board_log import BoardLog, read_log_scenario
from martensite.boards.characterise.characterise import list_unknown
from martensite.boards.characterise.experiments import list_courses, measure_pace
from martensite.boards.characterise.information import choose_courses, compute_information
from martensite.boards.emulators.avr import SimavrBoard
from martensite.boards.emulators.cortex import QemuBoard
from martensite.boards.emulators.cost import cost_on_cortex, write_cost
from martensite.boards.emulators.toolchains import compile_bare, compile_sketch, explain_overflow
from martensite.boards.firmware.project import build_firmware
from martensite.boards.firmware.settings import Limits
from martensite.boards.hil import compare_runs, run_hil
from martensite.boards.link.host import BoardLink
from martensite.boards.link.messages import BoardFlags, DisarmReason, Message
from martensite.boards.rig_scenarios import read_rigs
from martensite.boards.session import Session
from martensite.cli import app
from martensite.export.c_core import build_c_loop
from martensite.simulate.lanes import Lanes

EXAMPLES = Path(str(files("martensite"))).parents[1] / "examples"
AVR = shutil.which("avr-g++") and Path("/usr/include/simavr/sim_avr.h").exists()
ARM = shutil.which("arm-none-eabi-gcc") and shutil.which("qemu-system-arm")
needs_avr = pytest.mark.skipif(not AVR, reason="gcc-avr, arduino-core-avr or libsimavr-dev are not installed")
needs_arm = pytest.mark.skipif(not ARM, reason="gcc-arm-none-eabi or qemu-system-arm are not installed")


@pytest.fixture(scope="module")
def uno(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A project of the loop with a position sensor, compiled for the Uno."""
    return compile_loop(tmp_path_factory.mktemp("boards"), "uno")


def compile_loop(parent: Path, board: str) -> Path:
    """Write and compile the loop with a position sensor for an AVR board."""
    folder = parent / board
    build_firmware(ms.load(EXAMPLES / "closed_loop.toml"), board, name=board).write(folder)
    compile_sketch(folder, board)
    return folder


@pytest.fixture
def board(uno: Path) -> Iterator[SimavrBoard]:
    found = SimavrBoard(uno / "firmware.elf", "uno", 500_000, uno)
    found.run(0.1)
    yield found
    found.close()


def read_description(folder: Path) -> dict[str, Any]:
    return json.loads((folder / "firmware.json").read_text("utf-8"))


@needs_avr
def test_a_loop_on_an_uno_is_that_of_the_simulation(uno: Path, board: SimavrBoard) -> None:
    scenario, link = ms.load(EXAMPLES / "closed_loop.toml"), BoardLink(board, now=board.now)
    found = run_hil(scenario, link, read_description(uno), word="ARM", duration=5.0)
    far = {name: share for name, _, _, share in compare_runs(scenario, found)}
    assert far["position"] < 1e-4 and far["temperature"] < 1e-4 and len(found.times) == 251
    assert found.lost_frames == 0 and link.reader.counts.garbled == 0


@needs_avr
def test_a_nano_runs_the_loop_as_an_uno_does(tmp_path: Path) -> None:
    folder = compile_loop(tmp_path, "nano")
    board = SimavrBoard(folder / "firmware.elf", "nano", 500_000, folder)
    board.run(0.1)
    link = BoardLink(board, now=board.now)
    scenario = ms.load(EXAMPLES / "closed_loop.toml")
    found = run_hil(scenario, link, read_description(folder), word="ARM", duration=1.0)
    board.close()
    assert max(share for _, _, _, share in compare_runs(scenario, found)) < 1e-3 and found.lost_frames == 0


@needs_avr
def test_a_board_that_hears_nothing_disarms_within_50_ms(board: SimavrBoard) -> None:
    link = BoardLink(board, now=board.now)
    link.greet()
    link.choose_mode("emulated")
    link.arm("ARM")
    silent, found = board.now(), []
    while not found and board.now() < silent + 0.2:
        found = [message for message in link.receive() if message.name == "disarmed"]
    assert found[0].values["reason"] == DisarmReason.SILENCE
    assert 0.03 < board.now() - silent < 0.05


@needs_avr
def test_noise_on_the_line_does_nothing(board: SimavrBoard) -> None:
    link, rng = BoardLink(board, now=board.now), random.Random(3)
    hello = link.greet()
    for _ in range(60):
        link.port.write(rng.randbytes(rng.randrange(300)) + bytes(rng.randrange(3)))
        assert [message for message in link.receive() if message.name != "answer"] == []
    board.run(0.4)
    assert link.greet().values["digest"] == hello.values["digest"]
    assert board.duties == (0.0, 0.0)


@needs_avr
def test_nothing_is_armed_without_the_word_or_a_calibration(uno: Path, board: SimavrBoard) -> None:
    link = BoardLink(board, now=board.now)
    link.greet()
    link.choose_mode("loop")
    with pytest.raises(ms.InputError, match="without the word `ARM`"):
        link.arm("yes")
    with pytest.raises(ms.SolveError, match="not now"):  # gains are nominal
        link.arm("ARM")
    description = read_description(uno)
    names = [row["name"] for row in (*description["settings"], *description["parameters"])]
    for name in ("most_duty", "supervisor.checks.bound_drive.limit", "controllers.drive.Kp"):
        with pytest.raises(ms.SolveError, match="constant in flash"):
            link.command("set", place=names.index(name), value=0.5)
    link.command("rate", every=1)
    (told,) = {BoardFlags(m.values["flags"]) for _ in range(90) for m in link.receive() if m.name == "telemetry"}
    assert BoardFlags.ARMED not in told and board.duties == (0.0, 0.0)


@needs_avr
def test_a_full_line_delays_no_sample_of_an_uno(board: SimavrBoard) -> None:
    link, line = BoardLink(board, now=board.now), flood("ping", token=1)
    board.volts[1] = 5.0  # the supply
    link.greet()
    link.command("set", place=4, value=1.0)  # calibrated
    link.choose_mode("loop")
    link.command("rate", every=1)
    link.arm("ARM")
    messages = list[Message]()
    for _ in range(1000):
        board.write(line())
        messages += link.reader.feed(board.run(1e-3))
    times = [m.values["time"] for m in messages if m.name == "telemetry"]
    assert len(times) >= 49 and np.max(np.diff(times)) < 24_000
    assert not any(m.name == "disarmed" for m in messages) and board.duties[0] > 0.0


@needs_avr
def test_a_rig_is_calibrated_run_logged_and_replayed(uno: Path, tmp_path: Path) -> None:
    project, log = tmp_path / "uno", tmp_path / "log.csv"
    shutil.copytree(uno, project, ignore=shutil.ignore_patterns("build"))
    call = CliRunner().invoke
    done = call(app, ["hardware", "run", str(project), "--duration", "0.1 s"])
    assert done.exit_code == 0 and "Dry run: nothing was armed." in done.stdout
    done = call(app, ["hardware", "run", str(project), "--arm", "ARM", "--duration", "1 s"])
    assert done.exit_code == 2 and "not calibrated" in done.stderr
    assert call(app, ["hardware", "calibrate", str(project), "--channel", "position", "--is", "0 mm"]).exit_code == 0
    done = call(
        app, ["hardware", "run", str(project), "--arm", "ARM", "--duration", "5 s", "--out", str(log), "--json"]
    )
    said = json.loads(done.stdout)
    assert said["samples"] == 250 and (said["lost"], said["garbled"]) == (0, 0)
    assert read_log_scenario(log) == (EXAMPLES / "closed_loop.toml").read_text("utf-8")
    record = ms.data.read_lab_file(log).record
    run = ms.load(EXAMPLES / "closed_loop.toml").run()
    ours = np.interp(record["time"], run.times, run.columns["position"])
    assert np.max(np.abs(np.array(record["position"]) - ours)) < 1.8e-4 < 0.1 * np.ptp(ours)
    assert set(record.columns) == {"time", "status", "alarm", "position", "duty", "supply.voltage"}
    thin, lines = log.with_name("thin.csv"), log.read_text("utf-8").splitlines()  # a fit takes the square of the rows
    first = next(k for k, line in enumerate(lines) if line.startswith("time"))
    thin.write_text("\n".join([*lines[: first + 1], *lines[first + 1 :: 3]]), "utf-8")
    told = call(app, ["fit", str(thin), "--free", "h", "--json"])  # by the scenario that it carries
    assert told.exit_code == 0, told.stderr
    found = json.loads(told.stdout)["parameters"]["h"]["value"]
    assert abs(found - 120.0) < 1.0  # that of the wire in the emulator
    rigs, free = read_rigs([str(log)]) or ([], [])  # what `martensite fit log.csv` takes
    assert rigs and free == ["h", "A_s", "A_f"]  # it never cooled
    done = call(app, ["hardware", "replay", str(project), str(log), "--json"])
    assert json.loads(done.stdout)["position"]["fit"] > 0.95


@needs_avr
def test_a_host_that_begins_anew_is_heard(board: SimavrBoard) -> None:
    first = BoardLink(board, now=board.now)
    for _ in range(40):
        first.greet()
    board.run(0.1)
    assert BoardLink(board, now=board.now).greet().name == "hello"  # it counts from 0 again


@needs_avr
def test_nothing_is_lost_unnoticed_at_1_khz(tmp_path: Path) -> None:
    fast, firmware = start_board(tmp_path)
    try:
        (found, _), garbled = log_long(fast, firmware, 1.0, 2e-4), send_garbled(fast, 300)
    finally:
        fast.close()
    assert (
        found["lost unnoticed"] == found["altered unnoticed"] == 0
        and found["lost by the board"] == 0
        and found["counted as lost"] > 0
    )
    assert found["samples told"] > 990 and found["samples logged"] >= found["samples told"] - found["counted as lost"]
    assert (garbled["accepted"], garbled["alive"]) == (0, True)


def test_a_firmware_says_its_parts_its_limits_and_whether_it_fits(tmp_path: Path) -> None:
    example, out = EXAMPLES / "closed_loop_sensorless.toml", tmp_path / "mega"
    done = CliRunner().invoke(app, ["export", "firmware", str(example), "--board", "mega2560", "--out", str(out)])
    said = " ".join(done.stdout.split())
    assert "The switches close at 250 Hz." in said and "The standard deviation of a reading is 0.33 %" in said
    drawing = ElementTree.parse(out / "wiring.svg").getroot()
    words = {one.text for one in drawing.iter("{http://www.w3.org/2000/svg}text")}
    assert {"fuse 0.63 A", "A0", "A1", "shunt 0.1 ohm", "current-sense amplifier x 50", "100 ohm", "+"} <= words
    parts = (out / "WIRING.md").read_text("utf-8")
    assert "| 1 | element | wire, diameter 0.15 mm, length 250 mm |" in parts and "| 1 | shunt, with" in parts
    overflow = "firmware.elf section `.text' will not fit in region `text'; region `text' overflowed by 40892 bytes"
    with pytest.raises(ms.InputError, match="does not fit into the flash of Arduino Uno"):
        explain_overflow(overflow, "uno")


@needs_arm
def test_a_sensorless_loop_on_a_cortex_is_that_of_the_simulation(tmp_path: Path) -> None:
    scenario = ms.load(EXAMPLES / "closed_loop_sensorless.toml")
    build_firmware(scenario, "stm32f405", limits=Limits(silence=5.0)).write(tmp_path)
    board = QemuBoard(compile_bare(tmp_path))
    try:
        found = run_hil(scenario, BoardLink(board), read_description(tmp_path), word="ARM", duration=1.0)
    finally:
        board.close()
    far = {name: share for name, _, _, share in compare_runs(scenario, found)}
    assert far["position"] < 2e-3 and found.lost_frames == 0


@needs_arm
def test_what_a_step_costs_is_counted(tmp_path: Path) -> None:
    scenario = ms.load(EXAMPLES / "closed_loop.toml")
    core = build_c_loop(scenario.bench, name="core", precision="float32")  # type: ignore[arg-type]
    write_cost(core, [[0.0, 0.02, 1e-3]] * 20, 0.02, tmp_path)
    found = cost_on_cortex(core, tmp_path)
    least = sum(core.operations["step"].values())
    assert least < found.most < 20 * least and not found.failed  # QEMU's clock: an instruction is a nanosecond


def test_courses_are_safe_and_tell_what_they_say() -> None:
    bench = ms.load(EXAMPLES / "closed_loop.toml").bench
    assert bench is not None
    unknown = list_unknown(bench, ["h", "A_s"], {})
    pace = measure_pace(bench.plant)
    pulse, *_ = list_courses(pace)
    chosen = choose_courses(bench, unknown, [pulse, pulse.scaled(2.0)], limit=400.0, budget=30.0)
    assert chosen.hottest <= 400.0 and sum(one.duration for one in chosen.courses) <= 30.0
    told = compute_information(bench, unknown, pulse)
    slope = np.sqrt(told[0, 0])  # of the position with h, against two runs of the plant by hand
    lanes = Lanes(bench.plant, 2, {unknown[0].path: np.array([119.0, 121.0])})
    lanes.reset(np.zeros((1, 2)))
    duty = np.broadcast_to(pulse.sample(0.02)[:, None, None], (len(pulse.sample(0.02)), 1, 2))
    seen = lanes.advance(duty, 0.02)[:, lanes.names.index("position")]
    noise = np.hypot(0.5e-6, 0.01 * np.ptp(np.mean(seen, axis=1)))
    ours = unknown[0].width * np.sqrt(np.sum((np.diff(seen)[:, 0] / 2.0) ** 2)) / noise
    assert abs(slope / ours - 1.0) < 0.1


@pytest.mark.parametrize(
    ("example", "board", "alone"),
    [("closed_loop", "stm32f405", None), ("closed_loop_guarded", "stm32f405", None), ("closed_loop", "uno", "pin")],
)
def test_sources_are_clean(tmp_path: Path, example: str, board: str, alone: str | None) -> None:
    found = build_firmware(ms.load(EXAMPLES / f"{example}.toml"), board, alone=alone)
    found.write(tmp_path)
    strict = [
        "-std=c99",
        "-fsyntax-only",
        "-Wall",
        "-Wextra",
        "-Wtype-limits",
        "-Wconversion",
        "-Wshadow",
        "-Werror",
        "-Wdouble-promotion",
    ]
    names = ["app.c", "link.c", "loop.c", *(["alone_mode.c"] if alone else [])]
    subprocess.run(["cc", *strict, *names], cwd=tmp_path, check=True)
    if ARM and board == "stm32f405":
        own = [
            "arm-none-eabi-gcc",
            "-mcpu=cortex-m4",
            "-mthumb",
            *strict,
            *names,
            "board_stm32f405.c",
            "guard_stm32f405.c",
            "start_stm32f405.c",
        ]
        subprocess.run(own, cwd=tmp_path, check=True)
    if shutil.which("cppcheck"):
        words = ["cppcheck", "--enable=warning,style,performance,portability", "--std=c99", "-q", "--error-exitcode=1"]
        subprocess.run([*words, *(one.name for one in tmp_path.glob("*.c"))], cwd=tmp_path, check=True)


def test_logs_go_to_tables_and_back(tmp_path: Path) -> None:
    description = {"telemetry": [{"name": "position", "unit": "m"}], "scenario": "title = 'a'\n"}
    log, wrap = BoardLog(description), 1 << 32
    from martensite.boards.link.frames import LinkCounts
    from martensite.boards.link.messages import Message

    for k in range(5):  # the clock wraps on the way
        micros = (wrap - 2_000_000 + 1_000_000 * k) % wrap
        log.take(Message("telemetry", {"time": micros, "flags": 0, "alarm": 0, "values": (0.001 * k,)}))
    for ending in (".csv", ".parquet", ".mcap"):
        if ending != ".csv":
            pytest.importorskip({".parquet": "pyarrow", ".mcap": "mcap"}[ending])
        path = tmp_path / f"log{ending}"
        log.write(path, LinkCounts(good=5))
        record = ms.data.read_lab_file(path).record
        assert np.allclose(record["time"], np.arange(5.0)) and np.allclose(record["position"], 0.001 * np.arange(5))
        assert read_log_scenario(path) == description["scenario"]


def test_sessions_refuse_what_is_no_project(tmp_path: Path) -> None:
    with pytest.raises(ms.InputError, match="export firmware"), Session.open(tmp_path, "emulator"):
        pass
