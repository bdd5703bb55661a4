"""Hosts of a board: they notice a board that is lost.

Source of truth: the emulated board, and the time at which its line is cut on purpose.
"""

from __future__ import annotations

import json
import shutil
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

import pytest
from typer.testing import CliRunner

import martensite as ms
from martensite.boards.calibration import accept_nominal
from martensite.boards.emulators.avr import SimavrBoard
from martensite.boards.emulators.toolchains import compile_sketch
from martensite.boards.firmware.project import build_firmware
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
