"""Limits of the firmware: no number of the line passes them, and no time wraps.

Source of truth: the description of the firmware for its ranges, and the clock and pins of a board made of the same C.
"""

from __future__ import annotations

import json
import math
import shutil
from pathlib import Path

import pytest
from firmware_on_host import HostBoard

import martensite as ms
from martensite.boards.firmware.project import Firmware, build_firmware
from martensite.boards.firmware.settings import Limits
from martensite.boards.link.host import BoardLink
from martensite.boards.link.messages import BoardAnswer, DisarmReason

EXAMPLES = Path(__file__).parents[2] / "examples"
GAIN = "controllers.drive.Kp"
pytestmark = pytest.mark.skipif(shutil.which("cc") is None, reason="there is no C compiler")


@pytest.fixture(scope="module")
def firmware() -> Firmware:
    return build_firmware(ms.load(EXAMPLES / "closed_loop.toml"), "uno", ranges={GAIN: "50:400"})


def start_board(firmware: Firmware, folder: Path, **options: int) -> tuple[HostBoard, BoardLink]:
    board = HostBoard(firmware, folder, **options)
    board.set_channel(1, 1023.0)  # the supply
    link = BoardLink(board, now=board.now)
    link.greet()
    return board, link


def try_value(link: BoardLink, place: int, value: float) -> BoardAnswer:
    answer = link._ask("set", lambda m, n: m.name == "answer" and m.values["to"] == n, place=place, value=value)
    return BoardAnswer(answer.values["result"])


def read_value(link: BoardLink, place: int) -> float:
    found = link._ask("read", lambda m, _: m.name == "setting" and m.values["place"] == place, place=place)
    return float(found.values["value"])


def test_every_place_refuses_what_it_was_not_declared_for(firmware: Firmware, tmp_path: Path) -> None:
    _, link = start_board(firmware, tmp_path)
    described = json.loads(firmware.texts["firmware.json"])
    rows = described["settings"]
    constants = [k for k, row in enumerate(rows) if row["fixed"]]
    constants += range(len(rows), len(rows) + len(described["parameters"]))
    before = [read_value(link, place) for place in constants]
    for armed in (False, True):
        if armed:
            link.choose_mode("loop")
            link.command("set", place=4, value=1.0)  # calibrated
            link.arm("ARM")
        for place in range(256):
            for value in (0.0, 1.0, 3000.0, -1.0, math.inf, math.nan, 1e-30):
                answer = try_value(link, place, value)
                if place in constants:
                    assert answer is BoardAnswer.FIXED
                elif place >= len(rows):
                    assert answer is BoardAnswer.OUT_OF_RANGE
                else:
                    low, high = rows[place]["range"]
                    allowed = low <= value <= high
                    calibration = place < len(rows) - 2  # the last two are the reference and the gain
                    wanted = BoardAnswer.REFUSED if allowed and armed and calibration else BoardAnswer.DONE
                    assert answer is (wanted if allowed else BoardAnswer.OUT_OF_RANGE), (place, value)
    assert [read_value(link, place) for place in constants] == before


def wait_for_disarm(link: BoardLink) -> int | None:
    return next((m.values["reason"] for m in link.receive() if m.name == "disarmed"), None)


@pytest.mark.parametrize(
    ("silence", "longest", "reason"),
    [(10_000.0, 7_200.0, DisarmReason.TIME), (7_200.0, 20_000.0, DisarmReason.SILENCE)],
)
def test_long_durations_end_an_armed_time(tmp_path: Path, silence: float, longest: float, reason: int) -> None:
    limits = Limits(silence=silence, longest=longest)  # longer than 32 bits of microseconds: 4295 s
    long = build_firmware(ms.load(EXAMPLES / "closed_loop.toml"), "uno", limits=limits)
    board, link = start_board(long, tmp_path, start=(1 << 32) - 1000)
    link.command("set", place=4, value=1.0)
    link.choose_mode("loop")
    link.arm("ARM")
    armed = board.now()
    board.run(7_199.0, turn=10_000)
    assert wait_for_disarm(link) is None
    data = board.run(2.0, turn=10_000)
    board.read = lambda _=1: data  # type: ignore[method-assign]
    assert wait_for_disarm(link) == reason and 7_200.0 < board.now() - armed < 7_202.0


@pytest.mark.parametrize("limits", [Limits(silence=1e-4), Limits(longest=3e6)])
def test_durations_that_do_not_fit_are_refused(limits: Limits) -> None:
    with pytest.raises(ms.InputError, match="does not fit the clock of the board"):
        build_firmware(ms.load(EXAMPLES / "closed_loop.toml"), "uno", limits=limits)


def test_a_declared_gain_acts_within_its_range(firmware: Firmware, tmp_path: Path) -> None:
    board, link = start_board(firmware, tmp_path)
    described = json.loads(firmware.texts["firmware.json"])
    place = [row["name"] for row in described["settings"]].index(GAIN)
    parameter = len(described["settings"]) + [row["name"] for row in described["parameters"]].index(GAIN)
    link.command("set", place=place, value=300.0)
    assert read_value(link, place) == read_value(link, parameter) == 300.0
    with pytest.raises(ms.SolveError, match="outside the range"):
        link.command("set", place=place, value=401.0)
    assert read_value(link, parameter) == 300.0
    board.close()
