"""A board that is at hand: its project, its link, and what is done with it.

`Session.open` takes a serial port, or `emulator`: the board of the project under simavr with the plant of the scenario
at its pins, or under QEMU. Everything that heats goes through `drive`, which arms, keeps the board listening, and
disarms whatever happens.
"""

from __future__ import annotations

import json
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

from martensite.base import units
from martensite.base.caches import require_cache
from martensite.base.errors import DataError, InputError, SolveError, suggest_name
from martensite.base.files import read_text_file
from martensite.boards.board_log import BoardLog
from martensite.boards.firmware.boards import find_board
from martensite.boards.link.host import BoardLink, Port, open_port
from martensite.boards.link.messages import DisarmReason

if TYPE_CHECKING:
    from martensite.scenario.scenario import Scenario
    from martensite.signals.base import AbstractWaveform

EMULATOR = "emulator"
"""In the place of a port."""
HEARTBEAT = 0.01
"""Time between words to the board while it is armed [s]."""
CALIBRATION = "calibration.json"
"""Beside `firmware.json`: gains and offsets of this very board."""


@dataclass
class Session:
    """Board with its project and its firmware description."""

    project: Path
    firmware: dict[str, Any]
    """`firmware.json`, with settings as the board has them."""
    link: BoardLink
    port: Port

    @classmethod
    @contextmanager
    def open(cls, project: Path, port: str, emulated: Mapping[str, Any] | None = None) -> Iterator[Session]:
        """Open the board of a project, greet it, and send its calibration; close it at the end.

        `emulated` changes the wire of an emulator, by path of the scenario: what is at hand is never quite the model.

        Raises:
            DataError: there is no `firmware.json`.
            InputError: the port cannot be opened, or the board holds another firmware.
            SolveError: the board does not answer.
        """
        firmware = read_project(project)
        baud = find_board(firmware["board"]).baud
        if emulated and port != EMULATOR:
            raise InputError("Only the wire of an emulator can be changed.")
        line = _start_emulator(project, firmware, emulated) if port == EMULATOR else open_port(port, baud)
        try:
            clock: Callable[[], float] = getattr(line, "now", time.monotonic)
            found = cls(project, firmware, BoardLink(line, now=clock), line)
            found._greet()
            yield found
        finally:
            line.close()

    def _greet(self) -> None:
        self.link.greet(self.firmware["digest"])
        for name, value in load_calibration(self.project)["settings"].items():
            self.set(name, float(value))

    @property
    def settings(self) -> dict[str, float]:
        """Return the numbers of the board by name, in SI."""
        return {row["name"]: row["value"] for row in self.firmware["settings"]}

    @property
    def scenario(self) -> Scenario:
        """Return the scenario that the firmware was written for."""
        return read_project_scenario(self.firmware)

    def list_references(self) -> dict[str, AbstractWaveform]:
        """Return the references of the loop of the scenario, by the names of its settings."""
        from martensite.control.loop.run import reference_waveforms

        bench = self.scenario.bench
        return {} if bench is None else reference_waveforms(bench)

    def find_setting(self, name: str) -> int:
        """Return the place of a setting or of a parameter of the loop; `InputError` if there is none."""
        names = [row["name"] for row in (*self.firmware["settings"], *self.firmware["parameters"])]
        if name not in names:
            raise InputError(f"The firmware has no setting `{name}`. {suggest_name(name, names)}")
        return names.index(name)

    def set(self, name: str, value: float) -> None:
        """Set a setting of the board, in SI, and record it.

        Raises:
            InputError: the setting does not exist.
            SolveError: the board refuses it.
        """
        place = self.find_setting(name)
        self.link.command("set", place=place, value=value)
        if place < len(self.firmware["settings"]):
            self.firmware["settings"][place]["value"] = value

    def get(self, name: str) -> float:
        """Return a number as the board has it, in SI."""
        place = self.find_setting(name)
        until = self.link.now() + 1.0
        self.link.send("read", place=place)
        while self.link.now() < until:
            for message in self.link.receive():
                if message.name == "setting" and message.values["place"] == place:
                    return float(message.values["value"])
        raise SolveError(f"The board does not say its `{name}`.")

    def listen(self, duration: float, watch: Callable[[BoardLog, float], None] | None = None) -> BoardLog:
        """Log what the board measures, nothing armed.

        Args:
            duration: [s]
            watch: called now and then with the log and the share that is done.
        """
        log = BoardLog(self.firmware)
        self.link.command("rate", every=1)
        begin = self.link.now()
        while (passed := self.link.now() - begin) < duration:
            for message in self.link.receive():
                log.take(message)
            if watch is not None:
                watch(log, passed / duration)
        return log

    def drive(
        self,
        mode: str,
        duration: float,
        *,
        word: str,
        send: Callable[[float], None],
        watch: Callable[[BoardLog, float], None] | None = None,
    ) -> BoardLog:
        """Arm the board in a mode, keep it listening, log it, and disarm it.

        Args:
            mode: `loop` or `waveform`.
            duration: [s]
            word: `ARM`, said by a person.
            send: called every 10 ms with the time since it was armed [s]; sends what belongs there.
            watch: as for `listen`.

        Raises:
            InputError: another word.
            SolveError: the board refuses, or disarms by itself; the log until then is in its `log`.
        """
        log = BoardLog(self.firmware)
        if self.settings["calibrated"] < 0.5:
            raise InputError(
                "This board is not calibrated: `martensite hardware calibrate` sets its gains, and `--nominal` takes "
                "them as they are."
            )
        self.link.command("rate", every=1)
        self.link.choose_mode(mode)
        self.link.arm(word)
        begin, beat = self.link.now(), -HEARTBEAT
        try:
            while (passed := self.link.now() - begin) < duration:
                if passed - beat >= HEARTBEAT:
                    beat = passed
                    self.link.send("ping", token=0)
                    send(passed)
                for message in self.link.receive():
                    log.take(message)
                    if message.name == "disarmed":
                        raise BoardStopped(log, DisarmReason(message.values["reason"]), passed)
                if watch is not None:
                    watch(log, passed / duration)
        finally:
            self.link.send("disarm")
            for message in self.link.receive():  # the time of an emulator goes on while it is read from
                log.take(message)
        return log

    def follow(
        self, references: Mapping[str, AbstractWaveform], duration: float, *, word: str, watch: Any = None
    ) -> BoardLog:
        """Run the loop on the board, with references by the names of their settings; arguments as for `drive`."""
        places = {self.find_setting(name): one for name, one in references.items()}

        def send(passed: float) -> None:
            for place, one in places.items():
                self.link.send("set", place=place, value=one.value(passed))

        send(0.0)
        return self.drive("loop", duration, word=word, send=send, watch=watch)

    def play(self, levels: Sequence[tuple[float, float]], *, word: str, watch: Any = None) -> BoardLog:
        """Play levels of the duty of the only drive: pairs of time [s] and duty; arguments as for `drive`."""
        waiting, ahead = list(levels), 0.0

        def send(passed: float) -> None:
            nonlocal ahead
            while waiting and ahead < passed + 4 * HEARTBEAT:
                length, duty = waiting.pop(0)
                self.link.send("level", drive=0, micros=round(1e6 * length), value=duty)
                ahead += length

        return self.drive("waveform", sum(length for length, _ in levels), word=word, send=send, watch=watch)


class BoardStopped(SolveError):
    """A board disarmed by itself."""

    def __init__(self, log: BoardLog, reason: DisarmReason, time: float) -> None:
        """With what was logged until then."""
        super().__init__(f"The board disarmed after {time:.4g} s: {REASONS[reason]}.")
        self.log, self.reason, self.time = log, reason, time


REASONS = {
    DisarmReason.ASKED: "it was asked to",
    DisarmReason.SILENCE: "it heard nothing from this program",
    DisarmReason.GUARD: "its guard cut",
    DisarmReason.BROWN_OUT: "its supply is too low",
    DisarmReason.LOOP: "its loop could not be solved",
    DisarmReason.TIME: "it was armed for as long as is allowed",
    DisarmReason.CURRENT: "its current is too large",
}


def read_levels(text: str) -> list[tuple[float, float]]:
    """Return the times [s] and duties from `2 s:0.4, 5 s:0`; `InputError` for what is none."""
    found = list[tuple[float, float]]()
    for piece in text.split(","):
        length, sign, level = piece.rpartition(":")
        try:
            duty = float(level)
        except ValueError:
            sign = ""
            duty = 0.0
        if not sign or not 0.0 <= duty <= 1.0:
            raise InputError(
                f"Levels are times and duty cycles such as `2 s:0.4, 5 s:0`, but `{piece.strip()}` is none."
            )
        seconds = units.parse_quantity(length.strip(), "s")
        if not seconds > 0.0:
            raise InputError(f"Levels last longer than 0 s, but `{piece.strip()}` lasts {seconds:g} s.")
        found.append((seconds, duty))
    return found


def read_project(project: Path) -> dict[str, Any]:
    """Return the content of `firmware.json` of a project; raise `DataError` for another folder."""
    place = project / "firmware.json"
    if not place.exists():
        raise DataError(f"`{project}` holds no firmware.json: write a project by `martensite export firmware`.")
    return cast("dict[str, Any]", json.loads(read_text_file(place, "firmware")))


def load_calibration(project: Path) -> dict[str, Any]:
    """Return the points and settings that are kept for a project; empty ones before there are any."""
    place = project / CALIBRATION
    if not place.exists():
        return {"points": {}, "settings": {}}
    return cast("dict[str, Any]", json.loads(read_text_file(place, "calibration")))


def read_project_scenario(firmware: Mapping[str, Any], changes: Mapping[str, Any] | None = None) -> Scenario:
    """Return the scenario that a firmware was written for, with changes by path."""
    from martensite.scenario.scenario import read_scenario

    return read_scenario(firmware["scenario"], None, changes)


def _start_emulator(project: Path, firmware: dict[str, Any], changes: Mapping[str, Any] | None) -> Port:
    """Return the board of a project, emulated; compiled first if it is not."""
    from martensite.boards.emulators.cortex import QemuBoard
    from martensite.boards.emulators.rig import start_rig
    from martensite.boards.emulators.toolchains import MCUS, compile_bare, compile_sketch

    board, elf = firmware["board"], project / "firmware.elf"
    if board not in MCUS and board != "stm32f405":
        raise InputError(f"There is no emulator for `{board}` here; there is one for {', '.join(MCUS)} and stm32f405.")
    if not elf.exists():
        compile_sketch(project, board) if board in MCUS else compile_bare(project)
    if board not in MCUS:
        return QemuBoard(elf)
    rig = start_rig(read_project_scenario(firmware, changes), elf, board, require_cache("emulators"))
    rig.run(0.1)  # until it listens
    return rig
