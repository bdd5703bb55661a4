"""Gains and offsets of the channels of a board, from known values.

    x = gain (steps - offset)

A channel at a known value gives a point. A point at 0 sets the offset, another one the gain, two or more both, by least
squares. A known resistor in place of the wire sets the gain of the current, so that voltage over current is exact, as a
resistance needs. Points are saved in `calibration.json`, with the spread of the readings.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from martensite.base.errors import DataError, InputError, SolveError, suggest_name
from martensite.base.files import write_file
from martensite.boards.board_log import BoardLog
from martensite.boards.session import CALIBRATION, Session, load_calibration

READ_FOR = 0.5
"""Time of reading for a point [s]."""
RESISTOR_DUTY, RESISTOR_FOR = 0.2, 1.0
"""Duty cycle and time [s] of heating a known resistor."""


@dataclass(frozen=True)
class CalibrationPoint:
    """A channel at a known value."""

    steps: float
    spread: float
    """Standard deviation of the reading [steps]."""
    value: float


def list_channels(firmware: Mapping[str, Any]) -> list[str]:
    """Return the channels of a firmware."""
    settings = firmware["settings"]
    return [row["name"].removeprefix("gain ") for row in settings if row["name"].startswith("gain ")]


def find_channel_unit(firmware: Mapping[str, Any], channel: str) -> str:
    """Return the SI unit of a channel; raise `InputError` if it does not exist."""
    channels = list_channels(firmware)
    if channel not in channels:
        raise InputError(f"The board has no channel `{channel}`. {suggest_name(channel, channels)}")
    row = next(row for row in firmware["settings"] if row["name"] == f"gain {channel}")
    return str(row["unit"]).removesuffix("/step")


def read_steps(session: Session, channel: str, log: BoardLog) -> tuple[float, float]:
    """Return mean and standard deviation of the readings of a converter in a log.

    Raises:
        InputError: the channel does not exist.
        DataError: the log is empty.
    """
    find_channel_unit(session.firmware, channel)
    if len(log) < 2:
        raise DataError("The board said too little to calibrate by: is its telemetry on?")
    values = log.table()[:, log.names.index(channel)]
    numbers = session.settings
    steps = values / numbers[f"gain {channel}"] + numbers[f"offset {channel}"]
    return float(np.mean(steps)), float(np.std(steps))


def add_point(session: Session, channel: str, value: float) -> CalibrationPoint:
    """Read a channel at a known value [SI], store the point, and set gain and offset from all points."""
    log = session.listen(READ_FOR)
    point = CalibrationPoint(*read_steps(session, channel, log), value)
    calibration = load_calibration(session.project)
    points = calibration["points"].setdefault(channel, [])
    points.append([point.steps, point.spread, point.value])
    numbers = session.settings
    before = numbers[f"gain {channel}"], numbers[f"offset {channel}"]
    gain, offset = solve_points([CalibrationPoint(*row) for row in points], *before)
    _keep_settings(session, calibration, {f"gain {channel}": gain, f"offset {channel}": offset})
    return point


def solve_points(points: list[CalibrationPoint], gain: float, offset: float) -> tuple[float, float]:
    """Return gain and offset from calibration points and their present values.

    Raises:
        DataError: the points do not determine them.
    """
    steps = np.array([one.steps for one in points])
    values = np.array([one.value for one in points])
    if np.ptp(values) > 0.0:
        if np.ptp(steps) < 3.0 * max(one.spread for one in points) or np.ptp(steps) == 0.0:
            raise DataError("Two values gave the same reading: is the channel connected?")
        slope, at_zero = np.polyfit(steps, values, 1)
        return float(slope), float(-at_zero / slope)
    if values[0] == 0.0:
        return gain, float(np.mean(steps))
    if np.mean(steps) == offset:
        raise DataError("The channel reads 0 at a value that is not: is it connected?")
    return float(values[0] / (np.mean(steps) - offset)), offset


def calibrate_resistor(session: Session, ohms: float, *, word: str) -> float:
    """Set the gain of the current with a known resistor in place of the wire, and return its change as a factor.

    Args:
        session: the board.
        ohms: resistance.
        word: `ARM`, since the resistor is heated for a second with a small duty cycle.

    Raises:
        InputError: the board measures no resistance.
        SolveError: no current flows.
    """
    if "current" not in list_channels(session.firmware):
        raise InputError("This board measures no current, so a resistor cannot calibrate it.")
    session.set("calibrated", 1.0)
    log = session.play([(RESISTOR_FOR, RESISTOR_DUTY)], word=word)
    table, names = log.table(), log.names
    on = table[:, names.index("duty")] > 0.0
    rows = table[on][3:]  # the filters settle in the first samples
    current = rows[:, names.index("current")]
    if not len(rows) or np.mean(current) <= 0.0:
        raise SolveError("No current flows through the resistor: check switch, supply and wiring.")
    factor = float(np.mean(rows[:, names.index("voltage")]) / np.mean(current) / ohms)
    gain = session.settings["gain current"]
    _keep_settings(session, load_calibration(session.project), {"gain current": gain * factor})
    return factor


def accept_nominal(session: Session) -> None:
    """Accept the nominal gains and offsets."""
    _keep_settings(session, load_calibration(session.project), {})


def _keep_settings(session: Session, calibration: dict[str, Any], settings: dict[str, float]) -> None:
    """Send settings to the board, mark it as calibrated, and store them."""
    calibration["settings"] |= settings | {"calibrated": 1.0}
    for name, value in calibration["settings"].items():
        session.set(name, value)
    if session.firmware.get("alone"):
        session.link.store()
    write_file(session.project / CALIBRATION, json.dumps(calibration, indent=1) + "\n")
