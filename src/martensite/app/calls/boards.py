"""Calls about boards: list, firmware download, and live run."""

from __future__ import annotations

import hashlib
import tomllib
import zipfile
from pathlib import Path

from martensite.app.documents import describe_scenarios, list_standalone, read_request_scenario
from martensite.app.messages import BadMessageError, JsonTable, Request, read_optional, require_entry
from martensite.app.views.columns import choose_rows, describe_display, find_envelope
from martensite.app.worker import Desk
from martensite.base.errors import InputError
from martensite.boards import live_run
from martensite.scenario.scenario import Scenario

FOLDER = "boards"
"""Folder of projects, in the folder of the bench."""
DRAWN = 1500
"""Drawn points of a column."""


def describe_boards(request: Request, desk: Desk) -> JsonTable:
    """List boards, ports and scenarios with a loop.

    {} -> {"boards": [{name, title, emulated}], "ports": [{name, about}], "emulator": "emulator", "missing": "",
    "scenarios": [{name, title, text}]}

    `missing` names the missing requirements of the emulator.
    """
    loops = {name: text for name, text in list_standalone().items() if "controller" in tomllib.loads(text)}
    return {**live_run.describe_boards(), **describe_scenarios(loops)}


def write_board_firmware(request: Request, desk: Desk) -> dict[str, str]:
    """Return the packed project of a firmware.

    {"text": TOML, "board": "uno"} -> {"key": …, "name": …}
    """
    project = _make_project(request, read_request_scenario(request, desk), desk)
    key, path = desk.files.place(f"{project.name}.zip")
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as packed:
        for one in sorted(project.iterdir()):
            if one.is_file() and one.suffix != ".elf" and one.name != "calibration.json":
                packed.write(one, f"{project.name}/{one.name}")
    return {"key": key, "name": path.name}


def run_board(request: Request, desk: Desk) -> JsonTable:
    """Run a board, or record from it: long work. Without the word `ARM` nothing is heated.

    {"text": TOML, "board": "uno", "port": "emulator", "levels": "2 s:0.4, 5 s:0", "duration": null, "word": "",
    "calibration": null}
    -> {"key", "name": of the log, "columns", "outputs", "counts", "ended", "safe", "rig": TOML for a fit}

    Notes: {"stage": words, …}, then {"columns": new rows, "share", "counts": of the link, "armed"}; columns in SI.
    After a stop the board is disarmed, and the log is kept.
    """
    run = live_run.LiveRun(
        board=require_entry(request, "board", str),
        port=require_entry(request, "port", str),
        levels=require_entry(request, "levels", str, ""),
        duration=_read_duration(request),
        word=require_entry(request, "word", str, ""),
        calibration=_read_calibration(request),
    )
    run.check()
    desk.tell({"stage": "writing the firmware"})
    project = _make_project(request, read_request_scenario(request, desk), desk)
    key, path = desk.files.place(f"log_{run.board}.csv")

    def tell(note: Request) -> None:
        units = note.get("units")
        desk.tell(note if units is None else {**note, "outputs": _describe_units(units)})

    live = live_run.run_live(run, project, path, tell, desk.stop)
    logged = {"key": key, "name": path.name} if path.exists() else {"key": "", "name": ""}
    return {**live, **logged, **_draw_columns(live["columns"]), "outputs": _describe_units(live["units"])}


def _make_project(request: Request, scenario: Scenario, desk: Desk) -> Path:
    board = require_entry(request, "board", str)
    if not board.isalnum():
        raise BadMessageError("`board` must be the name of one.")
    digest = hashlib.sha256(f"{board}\n{scenario.text}".encode()).hexdigest()[:12]
    folder = desk.folder / FOLDER / digest / f"firmware_{board}"
    live_run.make_project(scenario, board, folder)
    return folder


def _read_duration(request: Request) -> float | None:
    duration: float | None = read_optional(request, "duration", float)
    if duration is not None and not 0.0 < duration <= 3600.0:
        raise InputError("The duration must be above 0 s and at most an hour.")
    return duration


def _read_calibration(request: Request) -> JsonTable | None:
    calibration: JsonTable | None = read_optional(request, "calibration", dict)
    settings = {} if calibration is None else calibration.get("settings")
    if not isinstance(settings, dict) or not all(isinstance(one, (int, float)) for one in settings.values()):
        raise BadMessageError("This is no calibration.json of `martensite hardware calibrate`.")
    return calibration


def _describe_units(units: Request) -> dict[str, JsonTable]:
    return {name: describe_display(name.rpartition(" ")[2], unit) for name, unit in units.items()}


def _draw_columns(columns: dict[str, list[float]]) -> JsonTable:
    times = columns.get("time", [])
    rows = set(choose_rows(len(times), 200))
    for values in columns.values():
        rows |= set(find_envelope(values, DRAWN // max(len(columns), 1)))
    return {"columns": {name: [values[k] for k in sorted(rows)] for name, values in columns.items()}}
