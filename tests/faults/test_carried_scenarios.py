"""`fit` looks for the scenario that a log of a board carries: other and damaged files are no traceback.

Source of truth: a file without a whole scenario line carries none, and the reader of logs judges it.
"""

from __future__ import annotations

import random
from pathlib import Path

import pytest
from command import Command
from fault_trials import spoil_bytes

from martensite.boards.board_log import BoardLog, read_log_scenario
from martensite.boards.link.frames import LinkCounts
from martensite.boards.link.messages import Message

ROWS = "time [s],Temperatur [°C]\n0,1\n1,2\n"


@pytest.mark.parametrize("encoding", ["cp1252", "utf-16"])
def test_a_log_of_any_encoding_carries_no_scenario(tmp_path: Path, encoding: str) -> None:
    path = tmp_path / "log.csv"
    path.write_bytes(f"#Gerät: °\n{ROWS}".encode(encoding))
    assert read_log_scenario(path) == ""


@pytest.mark.parametrize("line", ["{bad", '"no toml"'])
def test_a_damaged_scenario_in_a_log_is_a_sentence(tmp_path: Path, line: str) -> None:
    path = tmp_path / "log.csv"
    path.write_text(f"# scenario: {line}\n{ROWS}", encoding="utf-8")
    assert "is damaged" in Command("fit", str(path)).refused()


def test_a_damaged_container_is_no_traceback(tmp_path: Path) -> None:
    pytest.importorskip("mcap")
    rng, path = random.Random(4), tmp_path / "log.mcap"
    log = BoardLog({"telemetry": [{"name": "position", "unit": "m"}], "scenario": "title = 'a'"})
    for k in range(3):
        log.take(Message("telemetry", {"time": 1000 * k, "flags": 0, "alarm": 0, "values": (0.001 * k,)}))
    log.write(path, LinkCounts(good=3))
    raw = path.read_bytes()
    for _ in range(40):
        path.write_bytes(spoil_bytes(raw, rng))
        assert isinstance(read_log_scenario(path), str)
