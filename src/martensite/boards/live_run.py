"""Boards for the web bench: connected boards, a project for a scenario, and a run with progress.

All tables and numbers are in SI. A board is armed only with the word of a person.
"""

from __future__ import annotations

import json
import shutil
import threading
import time
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

from martensite.base.errors import InputError, SolveError
from martensite.base.files import write_file
from martensite.boards.board_log import BoardLog
from martensite.boards.calibration import accept_nominal
from martensite.boards.emulators.toolchains import CORE, MCUS, SIMAVR
from martensite.boards.firmware.boards import list_boards
from martensite.boards.firmware.project import build_firmware
from martensite.boards.link.host import ARM
from martensite.boards.link.messages import BoardFlags
from martensite.boards.rig_scenarios import write_rig_scenario
from martensite.boards.session import CALIBRATION, EMULATOR, BoardStopped, Session, read_levels

if TYPE_CHECKING:
    from martensite.scenario.scenario import Scenario
    from martensite.signals.base import AbstractWaveform

TOLD = 0.2
"""Least time between two reports [s]."""
MOST_ROWS = 24
"""Largest number of samples in a report; the log has all."""
LISTENED = 2.0
"""Default duration of a dry run [s]."""
TRUE = {"temperature": "K", "resistance": "ohm"}
"""True values of the wire, which only an emulator has."""

Tell = Callable[[Mapping[str, Any]], None]


def describe_boards() -> dict[str, Any]:
    """Return boards, serial ports, and missing tools of emulators."""
    from serial.tools.list_ports import comports

    boards = [{"name": one.name, "title": one.title, "emulated": one.name in MCUS} for one in list_boards().values()]
    ports = [{"name": one.device, "about": one.description or ""} for one in comports()]
    return {"boards": boards, "ports": ports, "emulator": EMULATOR, "missing": find_missing()}


def find_missing() -> str:
    """Return a sentence about missing tools of an emulator, or an empty text."""
    there = shutil.which("avr-g++") and CORE.is_dir() and SIMAVR.exists()
    return "" if there else "An emulator needs gcc-avr, avr-libc, arduino-core-avr and libsimavr-dev (Debian)."


@dataclass(frozen=True)
class LiveRun:
    """Request for a run of a board."""

    board: str
    port: str
    levels: str = ""
    """Times and duty cycles such as `2 s:0.4, 5 s:0`; empty for the loop of the scenario."""
    duration: float | None = None
    """Duration of the loop, or of a dry run [s]; default: that of the scenario, or `LISTENED`."""
    word: str = ""
    """`ARM`, given by a person; empty for a dry run, which heats nothing."""
    calibration: Mapping[str, Any] | None = None
    """Content of `calibration.json`; None for nominal gains."""

    def check(self) -> None:
        """Raise `InputError` for an unknown port, invalid levels, or another word than `ARM`."""
        allowed = [EMULATOR, *(one["name"] for one in describe_boards()["ports"])]
        if self.port not in allowed:
            raise InputError(f"There is no port `{self.port}`; there are {', '.join(allowed)}.")
        if self.word not in ("", ARM):
            raise InputError(f"Nothing is armed without the word `{ARM}`, but `{self.word}` was given.")
        self.list_levels()

    def list_levels(self) -> list[tuple[float, float]]:
        """Return times [s] and duty cycles; empty for the loop."""
        return read_levels(self.levels) if self.levels.strip() else []


@dataclass
class LiveWatch:
    """Reports new rows of a log, and stops a run on request."""

    session: Session
    tell: Tell
    stop: threading.Event
    references: Mapping[str, AbstractWaveform] = field(default_factory=dict[str, "AbstractWaveform"])
    """References of the loop, by column."""
    log: BoardLog | None = None
    _reported_rows: int = 0
    _next: float = 0.0
    _true: list[list[float]] = field(default_factory=list[list[float]])

    def __call__(self, log: BoardLog, share: float) -> None:
        """Report a log with its completed fraction.

        Raises:
            RunStopped: a stop was requested.
        """
        self.log = log
        truth = getattr(self.session.port, "truth", None)
        if truth and len(log) > len(self._true):
            self._true += [[truth[name] for name in TRUE]] * (len(log) - len(self._true))
        if self.stop.is_set():
            raise RunStopped
        if (now := time.monotonic()) >= self._next:
            self._next = now + TOLD
            self.tell({**self.describe_rows(self._reported_rows, MOST_ROWS), "share": share, **self.describe_link()})
            self._reported_rows = len(log)

    def describe_rows(self, first: int, most: int | None = None) -> dict[str, Any]:
        """Return the columns from a row on, with at most `most` evenly spaced rows, including the newest."""
        if self.log is None or len(self.log) <= first:
            return {"columns": {}}
        table = self.log.table(first)
        every = 1 if most is None else -(-len(table) // most)
        rows = slice((len(table) - 1) % every, None, every)
        columns = {name: table[rows, k].tolist() for k, name in enumerate(self.log.names)}
        true = self._true[first:][rows]
        columns |= {f"true {name}": [row[k] for row in true] for k, name in enumerate(TRUE) if true}
        columns |= {name: [one.value(t) for t in columns["time"]] for name, one in self.references.items()}
        return {"columns": columns}

    def describe_link(self) -> dict[str, Any]:
        """Return the counters of the link, and whether the board is armed."""
        latest = self.log.latest if self.log is not None else {}
        armed = bool(int(latest.get("status", 0.0)) & BoardFlags.ARMED)
        return {"counts": vars(self.session.link.reader.counts).copy(), "armed": armed}


class RunStopped(Exception):
    """A person has stopped the run."""


def make_project(scenario: Scenario, board: str, folder: Path) -> None:
    """Write the firmware of a scenario into a folder, unless it exists."""
    if not (folder / "firmware.json").exists():
        build_firmware(scenario, board, name=folder.name).write(folder)


def run_live(run: LiveRun, project: Path, log: Path, tell: Tell, stop: threading.Event) -> dict[str, Any]:
    """Run, or listen to, the board of a project; report progress, write a log, and return all its columns.

    Raises:
        InputError: the port cannot be opened, or the board has another firmware.
        SolveError: the board does not answer, or the link failed.
    """
    calibration = {"points": {}, "settings": {}, **(run.calibration or {})}
    write_file(project / CALIBRATION, json.dumps(calibration, indent=1) + "\n")
    tell({"stage": "compiling and starting the emulator" if run.port == EMULATOR else "opening the port"})
    with Session.open(project, run.port) as session:
        if run.calibration is None and run.word:
            accept_nominal(session)
        watch = LiveWatch(session, tell, stop, name_wanted(session) if run.word and not run.levels.strip() else {})
        units = list_units(session, watch.references)
        tell({"stage": "running" if run.word else "listening", "units": units})
        ended = _run_watched(run, session, watch)
        safe = _confirm_disarmed(session) if run.word else "Dry run: nothing was armed."
        if watch.log is not None and len(watch.log):
            watch.log.write(log, session.link.reader.counts)
        rig = write_rig_scenario(session.firmware["scenario"])
        columns = {**watch.describe_rows(0), "counts": watch.describe_link()["counts"], "units": units}
    return {**columns, "ended": ended, "safe": safe, "rig": rig}


def name_wanted(session: Session) -> dict[str, AbstractWaveform]:
    """Return the references of the loop as columns: `wanted position` for a column with the same unit."""
    units = {row["name"]: row["unit"] for row in session.firmware["settings"]}
    wanted: dict[str, AbstractWaveform] = {}
    for name, one in session.list_references().items():
        alike = (row["name"] for row in session.firmware["telemetry"] if row["unit"] == units[name] != "1")
        wanted[f"wanted {next(alike, name).removeprefix('estimated.')}"] = one
    return wanted


def list_units(session: Session, wanted: Iterable[str]) -> dict[str, str]:
    """Return the SI units of the columns of a log, and of the added columns."""
    telemetry = {row["name"]: row["unit"] for row in session.firmware["telemetry"]}
    true = TRUE if hasattr(session.port, "truth") else {}
    plain = {name.removeprefix("estimated."): unit for name, unit in telemetry.items()}
    beside = {name: plain.get(name.removeprefix("wanted "), "1") for name in wanted}
    return {"time": "s", **telemetry, **beside, **{f"true {name}": unit for name, unit in true.items()}}


def _run_watched(run: LiveRun, session: Session, watch: LiveWatch) -> str:
    """Return why the run ended early, or an empty text."""
    try:
        if not run.word:
            session.listen(LISTENED if run.duration is None else run.duration, watch)
        elif run.levels.strip():
            session.play(run.list_levels(), word=run.word, watch=watch)
        else:
            seconds = session.scenario.duration if run.duration is None else run.duration
            session.follow(session.list_references(), seconds, word=run.word, watch=watch)
    except RunStopped:
        return "Stopped."
    except BoardStopped as error:
        watch.log = error.log
        return str(error)
    return ""


def _confirm_disarmed(session: Session) -> str:
    """Disarm the board once more, with an answer."""
    try:
        session.link.disarm()
    except SolveError:
        return "The board did not answer; it disarms by itself when it hears nothing."
    return "The board is disarmed and says so."
