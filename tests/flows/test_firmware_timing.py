"""Samples of the firmware come in time whatever the line carries; its temperature bound counts measured time.

Source of truth: the clock of the board, and an element that heats and cools exactly as the guard assumes of the worst.
"""

from __future__ import annotations

import random
import shutil
from collections.abc import Callable
from pathlib import Path

import pytest
from firmware_on_host import PER_MS, HostBoard, flood

import martensite as ms
from martensite.boards.firmware.bounds import FirmwareBound
from martensite.boards.firmware.project import Firmware, build_firmware
from martensite.boards.firmware.settings import Limits
from martensite.boards.link.host import BoardLink
from martensite.boards.link.messages import DisarmReason

EXAMPLES = Path(__file__).parents[2] / "examples"
PERIOD = 0.02
"""Sample time of the loop [s]."""
pytestmark = pytest.mark.skipif(shutil.which("cc") is None, reason="there is no C compiler")


@pytest.fixture(scope="module")
def firmware() -> Firmware:
    limits = Limits(silence=100.0)
    return build_firmware(ms.load(EXAMPLES / "closed_loop.toml"), "uno", limits=limits)


class WorstWire:
    """An element that heats and cools as the guard assumes of the worst, and never moves."""

    def __init__(self, firmware: Firmware, folder: Path) -> None:
        (self.bound,) = firmware.plan.bounds
        self.board = HostBoard(firmware, folder)
        self.board.set_channel(1, 1023.0)  # the supply
        self.link = BoardLink(self.board, now=self.board.now)
        self.temperature = self.hottest = self.bound.ambient
        self.greet()
        self.run(10.0, 1000)

    def greet(self) -> None:
        """Prepare a board that has just begun."""
        self.link.greet()
        self.link.command("set", place=4, value=1.0)
        self.link.command("set", place=9, value=0.0045)  # a reference out of reach
        self.link.choose_mode("loop")

    def run(self, seconds: float, turn: int | Callable[[], int], line: Callable[[], bytes] = bytes) -> bytes:
        """Advance by a time [s] with turns [us], and each millisecond of what the line carries."""
        until, output, sent = self.board.now() + seconds, b"", self.board.now()
        while (now := self.board.now()) < until:
            while sent < now:
                self.board.write(line())
                sent += 1e-3
            duty = self.board.duty()
            output += self.board.run(1e-9, turn() if callable(turn) else turn)
            self.heat(duty, self.board.now() - now)
        return output

    def heat(self, duty: float, time: float) -> None:
        """Heat the element with a duty cycle for a time [s]."""
        one: FirmwareBound = self.bound
        steps = max(1, round(1e3 * time))
        for _ in range(steps):
            slope = one.rate * duty - one.cooling * (self.temperature - one.ambient)
            self.temperature += slope * time / steps
        self.hottest = max(self.hottest, self.temperature)

    def is_safe(self) -> bool:
        """Return whether the element was never hotter than the limit and the printed margin."""
        return self.hottest < self.bound.limit + self.bound.find_margin(PERIOD)


@pytest.mark.parametrize(
    "line",
    [flood("ping", token=1), flood("set", place=9, value=0.0045), lambda: random.Random(1).randbytes(PER_MS)],
    ids=["ping", "set", "noise"],
)
def test_a_full_line_delays_no_sample(firmware: Firmware, tmp_path: Path, line: Callable[[], bytes]) -> None:
    wire = WorstWire(firmware, tmp_path)
    wire.link.arm("ARM")
    wire.run(8.0, 100, line)
    assert wire.board.longest_gap() < 1.2 * PERIOD and wire.is_safe()
    assert wire.temperature > 0.9 * wire.bound.limit  # it was heated all the time


def test_late_samples_are_counted_or_disarm(firmware: Firmware, tmp_path: Path) -> None:
    wire = WorstWire(firmware, tmp_path)
    wire.link.command("set", place=5, value=4.8e-5)  # a sensor of 45 mm, so that its ends switch the signal on and off
    wire.link.arm("ARM")

    def stretch_heating() -> int:
        on = wire.board.duty() > 0.0
        wire.board.set_channel(0, 1023.0 if on else 0.0)
        return 19_000 if on else 100

    wire.run(20.0, stretch_heating)  # the next sample is late whenever the wire is heated
    assert wire.temperature > 0.9 * wire.bound.limit and wire.is_safe()
    output = wire.board.run(1e-9, 45_000)
    wire.board.read = lambda _=1: output  # type: ignore[method-assign]
    reasons = [m.values["reason"] for m in wire.link.receive() if m.name == "disarmed"]
    assert reasons == [DisarmReason.OVERRUN] and wire.board.duty() == 0.0


@pytest.mark.parametrize("how", ["disarm", "reset"])
def test_arming_anew_does_not_forget_the_heat(firmware: Firmware, tmp_path: Path, how: str) -> None:
    wire = WorstWire(firmware, tmp_path)
    for _ in range(40):
        wire.link.arm("ARM")
        wire.run(0.5, 500)
        if how == "disarm":
            wire.link.disarm()
        else:
            wire.board.restart()
            wire.greet()
    assert wire.is_safe() and wire.temperature > 0.9 * wire.bound.limit
