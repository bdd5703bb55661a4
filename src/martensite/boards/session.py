"""A connected board: its project, its link, and its operation.

`Session.open` takes a serial port, or `emulator`: the board of the project under simavr with the plant of the scenario
at its pins, or under QEMU. All heating uses `drive`, which arms, keeps the link alive, and always disarms.
"""

from __future__ import annotations

import json
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

from martensite.base import units
from martensite.base.caches import require_cache
from martensite.base.errors import DataError, InputError, SolveError, suggest_name
from martensite.base.files import read_text_file
from martensite.boards.board_log import BoardLog
from martensite.boards.firmware.boards import find_board
from martensite.boards.link.host import BoardLink, Port, find_stale, open_port
from martensite.boards.link.messages import DisarmReason

if TYPE_CHECKING:
    from martensite.scenario.scenario import Scenario
    from martensite.signals.base import AbstractWaveform

EMULATOR = "emulator"
"""Name of the emulator instead of a port."""
HEARTBEAT = 0.01
"""Time between messages to an armed board [s]."""
CALIBRATION = "calibration.json"
"""File next to `firmware.json` with gains and offsets of this board."""


@dataclass
class Session:
    """A board with its project and the description of its firmware."""

    project: Path
    firmware: dict[str, Any]
    link: BoardLink
    port: Port

    @classmethod
    @contextmanager
    def open(cls, project: Path, port: str, emulated: Mapping[str, Any] | None = None) -> Iterator[Session]:
        """Open the board of a project, greet it, and send its calibration; close it at the end.

        Args:
            project: folder of the project.
            port: serial port, or `emulator`.
            emulated: changes of the wire of an emulator, by path of the scenario.

        Raises:
            DataError: there is no `firmware.json`.
            InputError: the port cannot be opened, or the board has another firmware.
            SolveError: the board does not answer.
        """
        firmware = read_project(project)
        baud = find_board(firmware["board"]).baud
        if emulated and port != EMULATOR:
            raise InputError("Only the wire of an emulator can be changed.")
        line = _start_emulator(project, firmware, emulated) if port == EMULATOR else open_port(port, baud)
        try:
            clock: Callable[[], float] = getattr(line, "now", time.monotonic)
            session = cls(project, firmware, BoardLink(line, now=clock), line)
            session._greet()
            yield session
        finally:
            line.close()

    def _greet(self) -> None:
        self.link.greet(self.firmware["digest"])
        for name, value in load_calibration(self.project)["settings"].items():
            if self.firmware.get("alone"):  # it is in the EEPROM, and a board that heats takes no other
                self.firmware["settings"][self.find_setting(name)]["value"] = float(value)
            else:
                self.set(name, float(value))

    @property
    def settings(self) -> dict[str, float]:
        """Return the settings of the board by name, in SI."""
        return {row["name"]: row["value"] for row in self.firmware["settings"]}

    @property
    def scenario(self) -> Scenario:
        """Return the scenario of the firmware."""
        return read_project_scenario(self.firmware)

    def list_references(self) -> dict[str, AbstractWaveform]:
        """Return the references of the loop, by the names of its settings."""
        from martensite.control.loop.run import reference_waveforms

        bench = self.scenario.bench
        return {} if bench is None else reference_waveforms(bench)

    def find_setting(self, name: str) -> int:
        """Return the place of a setting or parameter; raise `InputError` if it does not exist."""
        names = [row["name"] for row in (*self.firmware["settings"], *self.firmware["parameters"])]
        if name not in names:
            raise InputError(f"The firmware has no setting `{name}`. {suggest_name(name, names)}")
        return names.index(name)

    def set(self, name: str, value: float) -> None:
        """Set a setting of the board in SI.

        Raises:
            InputError: the setting does not exist.
            SolveError: the board refuses it.
        """
        place = self.find_setting(name)
        self.link.command("set", place=place, value=value)
        if place < len(self.firmware["settings"]):
            self.firmware["settings"][place]["value"] = value

    def get(self, name: str) -> float:
        """Return a setting of the board in SI."""
        place = self.find_setting(name)
        until = self.link.now() + 1.0
        self.link.send("read", place=place)
        while self.link.now() < until:
            for message in self.link.receive():
                if message.name == "setting" and message.values["place"] == place:
                    return float(message.values["value"])
        raise SolveError(f"The board does not say its `{name}`.")

    def listen(self, duration: float, watch: Callable[[BoardLog, float], None] | None = None) -> BoardLog:
        """Log a board that is not armed.

        Args:
            duration: duration [s].
            watch: called repeatedly with the log and the completed fraction.

        Raises:
            BoardStopped: the line failed, or the newest telemetry is older than `stale`.
        """
        log = BoardLog(self.firmware)
        self.link.command("rate", every=1)
        self._collect(log, duration, watch)
        return log

    @property
    def stale(self) -> float:
        """Return the age of the newest telemetry above which the board counts as lost [s]."""
        return find_stale(float(self.firmware["period"]))

    def _collect(
        self,
        log: BoardLog,
        duration: float,
        watch: Callable[[BoardLog, float], None] | None,
        beat: Callable[[float], None] | None = None,
    ) -> None:
        """Fill a log for a duration; call `beat` with the time since the start [s] if the board is armed."""
        begin = heard = self.link.now()
        try:
            while (passed := self.link.now() - begin) < duration:
                if beat is not None:
                    beat(passed)
                for message in self.link.receive():
                    if log.take(message):
                        heard = self.link.now()
                    elif message.name == "disarmed" and beat is not None:
                        reason = REASONS[DisarmReason(message.values["reason"])]
                        raise BoardStopped(log, f"The board disarmed after {passed:.4g} s: {reason}.")
                if (age := self.link.now() - heard) > self.stale:
                    raise BoardStopped(
                        log,
                        f"The newest telemetry is {age:.3g} s old (limit {self.stale:.3g} s), {passed:.4g} s after "
                        "the start: check the cable and the power of the board.",
                    )
                if watch is not None:
                    watch(log, passed / duration)
        except BoardStopped:
            raise
        except SolveError as error:  # the line
            raise BoardStopped(log, str(error)) from None

    def drive(
        self,
        mode: str,
        duration: float,
        *,
        word: str,
        send: Callable[[float], None],
        watch: Callable[[BoardLog, float], None] | None = None,
    ) -> BoardLog:
        """Arm the board in a mode, keep the link alive, log, and disarm.

        Args:
            mode: `loop` or `waveform`.
            duration: duration [s].
            word: `ARM`, given by a person.
            send: called every 10 ms with the time since arming [s], to send messages.
            watch: as for `listen`.

        Raises:
            InputError: another word.
            SolveError: the board refuses to arm.
            BoardStopped: the board disarmed itself, the line failed, or the newest telemetry is older than `stale`.
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
        last = -HEARTBEAT

        def beat(passed: float) -> None:
            nonlocal last
            if passed - last >= HEARTBEAT:
                last = passed
                self.link.send("ping", token=0)
                send(passed)

        try:
            self._collect(log, duration, watch, beat)
        except BaseException:
            with suppress(SolveError):  # a board that does not hear this disarms by itself
                self.link.send("disarm")
            raise
        self.link.send("disarm")
        for message in self.link.receive():  # an emulator advances while it is read
            log.take(message)
        return log

    def follow(
        self, references: Mapping[str, AbstractWaveform], duration: float, *, word: str, watch: Any = None
    ) -> BoardLog:
        """Run the loop on the board, with references by the names of their settings; see `drive`."""
        places = {self.find_setting(name): one for name, one in references.items()}

        def send(passed: float) -> None:
            for place, one in places.items():
                self.link.send("set", place=place, value=one.value(passed))

        send(0.0)
        return self.drive("loop", duration, word=word, send=send, watch=watch)

    def play(self, levels: Sequence[tuple[float, float]], *, word: str, watch: Any = None) -> BoardLog:
        """Play levels of the duty cycle of the only drive, pairs of time [s] and duty cycle; see `drive`."""
        waiting, ahead = list(levels), 0.0

        def send(passed: float) -> None:
            nonlocal ahead
            while waiting and ahead < passed + 4 * HEARTBEAT:
                length, duty = waiting.pop(0)
                self.link.send("level", drive=0, micros=round(1e6 * length), value=duty)
                ahead += length

        return self.drive("waveform", sum(length for length, _ in levels), word=word, send=send, watch=watch)


class BoardStopped(SolveError):
    """A board disarmed itself or is lost; `log` has the samples until then."""

    def __init__(self, log: BoardLog, sentence: str) -> None:
        super().__init__(sentence)
        self.log = log


REASONS = {
    DisarmReason.ASKED: "it was asked to",
    DisarmReason.SILENCE: "it heard nothing from this program",
    DisarmReason.GUARD: "its guard cut",
    DisarmReason.BROWN_OUT: "its supply is too low",
    DisarmReason.LOOP: "its loop could not be solved",
    DisarmReason.TIME: "it was armed for as long as is allowed",
    DisarmReason.CURRENT: "its current is too large",
    DisarmReason.OVERRUN: "a sample was late by a whole period",
    DisarmReason.PIN: "its switch was opened",
}


def read_levels(text: str) -> list[tuple[float, float]]:
    """Return times [s] and duty cycles from `2 s:0.4, 5 s:0`; raise `InputError` for an invalid text."""
    levels = list[tuple[float, float]]()
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
        levels.append((seconds, duty))
    return levels


def read_project(project: Path) -> dict[str, Any]:
    """Return the content of `firmware.json` of a project; raise `DataError` for another folder."""
    place = project / "firmware.json"
    if not place.exists():
        raise DataError(f"`{project}` holds no firmware.json: write a project by `martensite export firmware`.")
    return cast("dict[str, Any]", json.loads(read_text_file(place, "firmware")))


def load_calibration(project: Path) -> dict[str, Any]:
    """Return the stored points and settings of a project; empty before the first."""
    place = project / CALIBRATION
    if not place.exists():
        return {"points": {}, "settings": {}}
    return cast("dict[str, Any]", json.loads(read_text_file(place, "calibration")))


def read_project_scenario(firmware: Mapping[str, Any], changes: Mapping[str, Any] | None = None) -> Scenario:
    """Return the scenario of a firmware, with changes by path."""
    from martensite.scenario.scenario import read_scenario

    return read_scenario(firmware["scenario"], None, changes)


def _start_emulator(project: Path, firmware: dict[str, Any], changes: Mapping[str, Any] | None) -> Port:
    """Return the emulated board of a project, compiled if necessary."""
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
