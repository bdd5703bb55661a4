"""Hosts of a board, in Python and in C: they run it, and notice a board that is lost.

Source of truth: the emulated board, and the time at which its line is cut on purpose.
"""

from __future__ import annotations

import contextlib
import json
import os
import re
import shutil
import subprocess
import threading
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

import pytest
from typer.testing import CliRunner

import martensite as ms
from martensite.boards.calibration import accept_nominal
from martensite.boards.emulators.avr import SimavrBoard
from martensite.boards.emulators.rig import start_rig
from martensite.boards.emulators.toolchains import compile_sketch
from martensite.boards.firmware.project import build_firmware
from martensite.boards.firmware.settings import Limits
from martensite.boards.link.host import BoardLink
from martensite.boards.session import BoardStopped, Session
from martensite.cli import app

EXAMPLES = Path(__file__).parents[2] / "examples"
AVR = shutil.which("avr-g++") and Path("/usr/include/simavr/sim_avr.h").exists()
needs_avr = pytest.mark.skipif(not AVR, reason="gcc-avr, arduino-core-avr or libsimavr-dev are not installed")


@dataclass
class CutLine:
    """An emulated Uno whose line carries nothing in either direction from a time on."""

    board: SimavrBoard
    end: float = float("inf")

    def now(self) -> float:
        return self.board.now()

    def write(self, data: bytes) -> int:
        return self.board.write(data) if self.now() < self.end else len(data)

    def read(self, size: int = 1) -> bytes:
        came = self.board.read(size)
        return came if self.now() < self.end else b""

    def close(self) -> None:
        self.board.close()


@pytest.fixture(scope="module")
def uno(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("hosts") / "uno"
    build_firmware(ms.load(EXAMPLES / "closed_loop.toml"), "uno", name="uno").write(folder)
    compile_sketch(folder, "uno")
    return folder


@pytest.fixture
def line(uno: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[CutLine]:
    line = CutLine(SimavrBoard(uno / "firmware.elf", "uno", 500_000, uno, volts=[2.5, *[5.0] * 7]))
    line.board.run(0.1)
    monkeypatch.setattr("martensite.boards.session._start_emulator", lambda *_: line)
    yield line
    line.close()


@needs_avr
@pytest.mark.parametrize("operation", ["listen", "follow", "play"])
def test_every_session_ends_when_the_line_dies(uno: Path, line: CutLine, operation: str) -> None:
    session = Session(uno, json.loads((uno / "firmware.json").read_text("utf-8")), BoardLink(line, now=line.now), line)
    session.link.greet()
    accept_nominal(session)
    calls: dict[str, Callable[[], object]] = {
        "listen": lambda: session.listen(5.0),
        "follow": lambda: session.follow(session.list_references(), 5.0, word="ARM"),
        "play": lambda: session.play([(5.0, 0.1)], word="ARM"),
    }
    line.end = line.now() + 1.0
    with pytest.raises(BoardStopped, match=r"newest telemetry is .* old \(limit 0.56 s\)") as caught:
        calls[operation]()
    assert len(caught.value.log) > 40  # 50 samples a second until then
    assert line.now() < line.end + 0.6


@needs_avr
def test_a_run_without_a_board_fails_and_its_log_remains(uno: Path, line: CutLine, tmp_path: Path) -> None:
    line.end = line.now() + 1.5
    words = ["hardware", "run", str(uno), "--arm", "ARM", "--duration", "5 s", "--out", str(tmp_path / "log.csv")]
    done = CliRunner().invoke(app, words)
    assert (
        done.exit_code == 1 and "telemetry is" in done.stderr and "samples until then" in " ".join(done.stderr.split())
    )
    assert len(ms.read_table(tmp_path / "log.csv").times) > 40


def run_c_host(
    project: Path, calibration: Path, seconds: float, lasts: float
) -> tuple[subprocess.CompletedProcess[str], float]:
    """Run the example in C on a pseudo-terminal to an emulated rig that stops after some time; its duration [s]."""
    subprocess.run(
        ["make", "-s", "CFLAGS=-std=c99 -O1 -Wall -Wextra -Wconversion -Wshadow -Werror"],
        cwd=project / "host",
        check=True,
    )
    rig = start_rig(ms.load(EXAMPLES / "closed_loop.toml"), project / "firmware.elf", "uno", project)
    rig.run(0.1)
    near, far = os.openpty()
    os.set_blocking(near, False)
    begin, over = time.monotonic(), threading.Event()

    def pump() -> None:
        """Advance the rig with the clock of the wall, not faster."""
        while not over.is_set() and (passed := time.monotonic() - begin) < lasts:
            if rig.now() - 0.1 > passed:
                time.sleep(0.001)
                continue
            with contextlib.suppress(BlockingIOError):
                rig.write(os.read(near, 4096))
            os.write(near, rig.run(0.002))

    worker = threading.Thread(target=pump)
    worker.start()
    try:
        words = [project / "host" / "example", os.ttyname(far), calibration, "reference", "0.003", f"{seconds:g}"]
        done = subprocess.run(words, capture_output=True, text=True, timeout=60, check=False)
        return done, time.monotonic() - begin
    finally:
        over.set()
        worker.join()
        rig.close()
        os.close(near)
        os.close(far)


@needs_avr
def test_a_host_in_c_calibrates_arms_runs_and_notices(tmp_path: Path) -> None:
    project, stored = tmp_path / "uno", tmp_path / "calibration.json"
    build_firmware(ms.load(EXAMPLES / "closed_loop.toml"), "uno", name="uno", limits=Limits(silence=9.0)).write(project)
    header = project / "host" / "firmware.h"  # a busy machine may stop the emulator for a second
    header.write_text(re.sub(r"(FIRMWARE_STALE) \S+", r"\1 5.0", header.read_text("utf-8")), "utf-8")
    compile_sketch(project, "uno")
    done, _ = run_c_host(project, stored, 1.0, 60.0)
    assert done.returncode == 1 and "run `martensite hardware calibrate`" in done.stdout
    stored.write_text(json.dumps({"points": {}, "settings": {}}), "utf-8")
    done, _ = run_c_host(project, stored, 1.0, 60.0)
    assert done.returncode == 1 and "refused" in done.stdout  # it is not calibrated
    stored.write_text(json.dumps({"points": {}, "settings": {"gain position": 5e-6, "calibrated": 1.0}}), "utf-8")
    done, _ = run_c_host(project, stored, 2.0, 60.0)
    values = dict(line.rsplit(" ", 1) for line in done.stdout.splitlines() if "samples" not in line)
    assert done.returncode == 0 and float(values["duty"]) > 0.2
    done, passed = run_c_host(project, stored, 30.0, 3.0)
    assert done.returncode == 1 and "newest telemetry is too old" in done.stdout and passed < 20.0
