"""A processor that hangs or faults switches the heating off and reports why it was reset.

Source of truth: the pins of emulated processors. simavr has the watchdog of an AVR. QEMU has the interrupts, faults and
timers of an STM32F405, but not its independent watchdog, which no test here sees.
"""

from __future__ import annotations

import json
import re
import shutil
import socket
import time
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path
from typing import Any

import pytest

import martensite as ms
from martensite.boards.emulators.avr import SimavrBoard
from martensite.boards.emulators.cortex import QemuBoard
from martensite.boards.emulators.toolchains import compile_bare, compile_sketch
from martensite.boards.firmware.project import build_firmware
from martensite.boards.firmware.settings import Limits
from martensite.boards.link.host import BoardLink
from martensite.boards.link.messages import BoardFlags, ResetCause

EXAMPLES = Path(__file__).parents[2] / "examples"
AVR = shutil.which("avr-g++") and Path("/usr/include/simavr/sim_avr.h").exists()
ARM = shutil.which("arm-none-eabi-gcc") and shutil.which("qemu-system-arm")
LOOP, STACK, BUS = 1001, 1002, 1003
"""Rates of telemetry that stand for a harm 0.3 s after arming, in the sabotaged firmware only."""
AFTER, OFF_WITHIN, PERIOD = 0.3, 0.05, 0.02
HARM = """
static volatile uint8_t depth;
#if defined(__AVR__)
#define DEEPER(k) ((k) < 22u) /* through the variables, but not below the RAM, where simavr stops */
#else
#define DEEPER(k) (depth)
#endif
static uint8_t fall(uint8_t k) {
    volatile uint8_t room[64];
    room[k & 63u] = k;
    return (uint8_t)(DEEPER(k) ? fall((uint8_t)(k + 1u)) + room[k & 63u] : k);
}
static void harm(void) {
    if (!(flags & FLAG_ARMED) || every <= 1000u || milliseconds - armed_at < 300u) {
        return;
    }
    depth = 1;
    if (every == 1002u) {
        (void)fall(0);
    }
    if (every == 1003u) {
        *(volatile uint32_t *)(uintptr_t)0x60000000ul = 1u;
    }
    for (;;) {
    }
}

static void sample(uint32_t now) {
    harm();
"""


def write_sabotaged(folder: Path, board: str, limits: Limits) -> Path:
    """Write a firmware that harms itself on demand, without the check of the supply."""
    build_firmware(ms.load(EXAMPLES / "closed_loop.toml"), board, name=folder.name, limits=limits).write(folder)
    app, settings = folder / "app.c", folder / "settings.h"
    app.write_text(app.read_text("utf-8").replace("static void sample(uint32_t now) {\n", HARM), "utf-8")
    text = re.sub(r"(APP_SUPPLY_CHANNEL) \d+", r"\1 -1", settings.read_text("utf-8"))
    settings.write_text(text, "utf-8")
    return folder


def heat(link: BoardLink, harm: int) -> None:
    """Arm a board at a duty cycle of 0.9."""
    link.greet()
    link.command("set", place=4, value=1.0)  # calibrated
    link.choose_mode("waveform")
    link.command("rate", every=harm)
    link.arm("ARM")
    link.command("level", drive=0, micros=100_000_000, value=0.9)


def find_reset(link: BoardLink) -> ResetCause:
    """Return the cause of the newest reset of a board that is not armed."""
    hello = link.greet()
    link.command("rate", every=1)
    until = link.now() + 0.5
    flags = [m.values["flags"] for m in iter_messages(link, until) if m.name == "telemetry"]
    assert flags and not any(BoardFlags(one) & BoardFlags.ARMED for one in flags)
    return ResetCause(hello.values["reset"])


def iter_messages(link: BoardLink, until: float) -> Iterator[Any]:
    while link.now() < until:
        yield from link.receive()


@pytest.fixture(scope="module")
def uno(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = write_sabotaged(tmp_path_factory.mktemp("faults") / "uno", "uno", Limits(silence=5.0))
    return compile_sketch(folder, "uno")


@pytest.mark.skipif(not AVR, reason="gcc-avr, arduino-core-avr or libsimavr-dev are not installed")
@pytest.mark.parametrize(
    ("harm", "causes"),
    [(LOOP, {ResetCause.WATCHDOG}), (STACK, {ResetCause.WATCHDOG, ResetCause.FAULT})],
    ids=["endless loop", "stack overflow"],
)
def test_an_uno_that_hangs_is_off_within_50_ms(uno: Path, tmp_path: Path, harm: int, causes: set[ResetCause]) -> None:
    board = SimavrBoard(uno, "uno", 500_000, tmp_path)
    try:
        board.run(0.1)
        link = BoardLink(board, now=board.now)
        heat(link, harm)
        armed = board.now()
        board.run(0.1)
        assert board.duties[0] > 0.85
        while board.duties[0] > 0.0 and board.now() < armed + 1.0:
            board.run(1e-3)
        assert AFTER < board.now() - armed < AFTER + PERIOD + OFF_WITHIN
        board.run(0.1)
        assert find_reset(link) in causes and board.duties[0] == 0.0
    finally:
        board.close()


@pytest.fixture(scope="module")
def cortex(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("faults") / "stm"
    return compile_bare(write_sabotaged(folder, "stm32f405", Limits(silence=30.0)))


class Monitor:
    """Registers of a processor under QEMU."""

    def __init__(self, place: Path) -> None:
        self.line = socket.socket(socket.AF_UNIX)
        self.line.connect(str(place))
        self.file = self.line.makefile("rw")
        self.file.readline()
        self.ask("qmp_capabilities")

    def ask(self, name: str, **arguments: Any) -> Any:
        self.file.write(json.dumps({"execute": name, "arguments": arguments}) + "\n")
        self.file.flush()
        while "return" not in (answer := json.loads(self.file.readline())):
            pass
        return answer["return"]

    def close(self) -> None:
        self.file.close()
        self.line.close()

    def read_duty(self) -> int:
        """Return TIM3_CCR1."""
        return int(self.ask("human-monitor-command", **{"command-line": "xp /1wx 0x40000434"}).split(":")[1], 16)


@pytest.mark.skipif(not ARM, reason="gcc-arm-none-eabi or qemu-system-arm are not installed")
@pytest.mark.parametrize(
    ("harm", "cause"),
    [(LOOP, ResetCause.WATCHDOG), (STACK, ResetCause.FAULT), (BUS, ResetCause.FAULT)],
    ids=["endless loop", "stack overflow", "bus fault"],
)
def test_a_cortex_that_hangs_is_switched_off(cortex: Path, tmp_path: Path, harm: int, cause: ResetCause) -> None:
    settings = (cortex.parent / "settings.h").read_text("utf-8")
    (limit,) = re.findall(r"APP_WATCHDOG (\d+)", settings)
    assert 1e-3 * int(limit) < OFF_WITHIN  # SysTick, which switches off, counts milliseconds
    place = tmp_path / "qmp"
    board = QemuBoard(cortex, ("-qmp", f"unix:{place},server=on,wait=off"))
    try:
        link = BoardLink(board)
        heat(link, harm)
        with closing(Monitor(place)) as monitor:
            until, seen = time.monotonic() + 20.0, [monitor.read_duty()]
            while not (seen[-1] == 0 and max(seen) > 0) and time.monotonic() < until:
                seen.append(monitor.read_duty())
        assert max(seen) > 0 and seen[-1] == 0
        assert find_reset(link) is cause
    finally:
        board.close()
