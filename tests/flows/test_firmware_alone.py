"""A board without a host: it keeps its calibration, arms itself as it was told, and is as guarded as with a host.

Source of truth: the emulated wire at the pins of an emulated Uno, which stays warm while the board is off.
"""

from __future__ import annotations

import shutil
from pathlib import Path

import numpy as np
import pytest
from firmware_on_host import HostBoard

import martensite as ms
from martensite.boards.emulators.avr import SimavrBoard
from martensite.boards.emulators.rig import EmulatedRig
from martensite.boards.emulators.toolchains import compile_sketch
from martensite.boards.firmware.alone import TOLERANCE, simplify_track
from martensite.boards.firmware.project import Firmware, build_firmware
from martensite.boards.link.host import BoardLink
from martensite.boards.link.messages import BoardFlags, ResetCause

EXAMPLES = Path(__file__).parents[2] / "examples"
AVR = shutil.which("avr-g++") and Path("/usr/include/simavr/sim_avr.h").exists()
needs_avr = pytest.mark.skipif(not AVR, reason="gcc-avr, arduino-core-avr or libsimavr-dev are not installed")
CALIBRATED, OFFSET = 4, 7
"""Places of settings."""


@pytest.fixture(scope="module")
def firmware() -> Firmware:
    return build_firmware(ms.load(EXAMPLES / "closed_loop.toml"), "uno", alone="power-up")


@pytest.fixture(scope="module")
def elf(firmware: Firmware, tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("alone") / "uno"
    firmware.write(folder)
    return compile_sketch(folder, "uno")


def calibrate(rig: EmulatedRig) -> None:
    """Give a board its calibration, which it keeps."""
    link = BoardLink(rig, now=rig.now)
    link.greet()
    link.command("set", place=OFFSET, value=102.0)
    link.command("set", place=CALIBRATED, value=1.0)
    link.store()


def follow(rig: EmulatedRig, seconds: float) -> tuple[np.ndarray, float]:
    """Return the position each 20 ms, and the highest temperature."""
    positions, hottest = list[float](), 0.0
    for _ in range(round(seconds / 0.02)):
        rig.run(0.02)
        positions.append(rig.truth["position"])
        hottest = max(hottest, rig.truth["temperature"])
    return np.array(positions), hottest


@needs_avr
def test_a_board_without_a_host_follows_again_after_power_cycles(firmware: Firmware, elf: Path, tmp_path: Path) -> None:
    scenario = ms.load(EXAMPLES / "closed_loop.toml")
    alone, (bound,) = firmware.plan.alone, firmware.plan.bounds
    assert alone is not None and alone.follows is not None
    rig = EmulatedRig(scenario, SimavrBoard(elf, "uno", 500_000, tmp_path), turn=0.02)
    try:
        rig.run(0.1)
        assert rig.board.duties == (0.0, 0.0)  # it is not calibrated
        calibrate(rig)
        run, again = scenario.run(), 0.04 + alone.follows + bound.cooling_time
        wanted = np.interp(np.arange(0.0, 24.0, 0.02), run.times, run.columns["reference"])
        rig.run(0.2)
        assert rig.board.duties == (0.0, 0.0)  # it heats only after a power-up with a calibration
        for off_at in (0.7, 4.0):  # while it heats first, and on the way up
            rig.board.cycle_power()
            _, hottest = follow(rig, off_at)
            assert 300.0 < hottest < bound.limit + bound.find_margin(0.02)
        rig.board.cycle_power()
        positions, hottest = np.array([]), 0.0
        while not np.any(np.abs(positions - wanted[: len(positions)]) < 0.05 * np.ptp(wanted)):
            more, warm = follow(rig, 0.5)
            positions, hottest = np.append(positions, more), max(hottest, warm)
            assert len(positions) * 0.02 < again
        assert hottest < bound.limit + bound.find_margin(0.02)
        link = BoardLink(rig, now=rig.now)
        assert link.greet().values["reset"] == ResetCause.POWER_ON
        assert link._ask("read", lambda m, _: m.name == "setting", place=OFFSET).values["value"] == 102.0
    finally:
        rig.close()


@needs_avr
def test_a_damaged_calibration_is_not_taken(elf: Path, tmp_path: Path) -> None:
    rig = EmulatedRig(ms.load(EXAMPLES / "closed_loop.toml"), SimavrBoard(elf, "uno", 500_000, tmp_path), turn=0.02)
    try:
        rig.run(0.1)
        calibrate(rig)
        link = BoardLink(rig, now=rig.now)
        link.greet()
        link.command("set", place=OFFSET, value=90.0)
        link.ask_result("store")  # the first byte that differs, and then the power fails
        rig.board.cycle_power()
        rig.run(1.0)
        assert rig.board.duties == (0.0, 0.0)
        link = BoardLink(rig, now=rig.now)
        link.greet()
        link.command("rate", every=1)
        rig.run(0.1)
        flags = [m.values["flags"] for m in link.receive() if m.name == "telemetry"]
        assert flags and not any(BoardFlags(one) & BoardFlags.ARMED for one in flags)
    finally:
        rig.close()


@pytest.mark.skipif(shutil.which("cc") is None, reason="there is no C compiler")
def test_a_switch_arms_when_it_closes_and_disarms_when_it_opens(tmp_path: Path) -> None:
    board = HostBoard(build_firmware(ms.load(EXAMPLES / "closed_loop.toml"), "uno", alone="pin"), tmp_path)
    board.set_channel(1, 1023.0)  # the supply
    link = BoardLink(board, now=board.now)
    link.greet()
    link.command("set", place=CALIBRATED, value=1.0)
    link.store()
    board.c.test_switch(1)
    board.restart()
    board.run(1.0)
    assert board.duty() == 0.0  # it was closed when the power came
    for closed, heated in ((0, False), (1, True), (0, False), (1, True)):
        board.c.test_switch(closed)
        board.run(0.2)
        assert (board.duty() > 0.0) is heated


@pytest.mark.skipif(shutil.which("cc") is None, reason="there is no C compiler")
@pytest.mark.parametrize("cause", ResetCause)
def test_a_board_arms_itself_after_power_on_and_not_after_a_hang(
    firmware: Firmware, tmp_path: Path, cause: ResetCause
) -> None:
    board = HostBoard(firmware, tmp_path)
    board.set_channel(1, 1023.0)
    link = BoardLink(board, now=board.now)
    link.greet()
    link.command("set", place=CALIBRATED, value=1.0)
    link.store()
    board.c.test_cause(int(cause))
    board.restart()
    board.run(0.5)
    harmless = cause in {ResetCause.POWER_ON, ResetCause.BROWN_OUT, ResetCause.PIN}
    assert (board.duty() > 0.0) is harmless


def test_a_polyline_is_close_to_its_reference() -> None:
    times = np.linspace(0.0, 10.0, 501)
    for levels in (np.sin(times), np.floor(times), np.ones(501), 0.2 * times):
        points = simplify_track(levels)
        places, values = zip(*points, strict=True)
        line = np.interp(np.arange(501), places, values)
        assert np.max(np.abs(line - levels)) <= 1.001 * TOLERANCE * np.ptp(levels) + 1e-12 and len(points) < 100


@pytest.mark.parametrize(("board", "start", "words"), [("stm32f405", "pin", "available for"), ("uno", "key", "takes")])
def test_what_cannot_stand_alone_is_refused(board: str, start: str, words: str) -> None:
    with pytest.raises(ms.InputError, match=words):
        build_firmware(ms.load(EXAMPLES / "closed_loop.toml"), board, alone=start)
