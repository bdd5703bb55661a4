"""`fit motor`: reading the tests of a DC motor, and what is printed."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from martensite.base.errors import DataError, InputError
from martensite.cli.fit_vibration import estimate_row
from martensite.cli.options import quantity

if TYPE_CHECKING:
    from martensite.characterise.motor_constants import MotorConstants
    from martensite.characterise.motor_tests import SteadyRunning, Winding
    from martensite.characterise.time_constant import Rise
    from martensite.signals.records import Record

SYMBOLS = {
    "resistance": "R",
    "inductance": "L",
    "constant": "K_T = K_B",
    "friction": "b",
    "dry_friction": "F_c",
    "inertia": "J",
}
SPEED = "rad/s"
SPEEDS = (SPEED, "rpm")
"""Units of a speed; those of a frequency would leave open what turns once."""


def read_winding(locked: Path | None, resistance: str | None) -> Winding:
    """Resistance from the test with a held rotor, or as given.

    Raises:
        InputError: neither or both of the two are there, or the resistance is not above 0.
        DataError: the table does not hold what is needed.
    """
    from martensite.characterise.estimate import MeasuredValue
    from martensite.characterise.motor_tests import Winding, winding_resistance
    from martensite.scenario.tables import read_table

    if (locked is None) == (resistance is None):
        raise InputError("Give the resistance in one way: --locked TABLE or --resistance.")
    if locked is None:
        return Winding(MeasuredValue(_positive("resistance", str(resistance), "ohm")))
    record = read_table(locked, interval=1.0)
    return winding_resistance(record["voltage"], record["current"])


def read_inductance(inductance: str | None) -> float | None:
    """Inductance [H] as given; None if it is not.

    Raises:
        InputError: it is not above 0.
        UnitError: it is no quantity, or of another dimension.
    """
    return None if inductance is None else _positive("inductance", inductance, "H")


def read_steady(path: Path) -> SteadyRunning:
    """Steady states of a table with voltage, current and speed.

    Raises:
        DataError: the table does not hold what is needed.
    """
    from martensite.characterise.motor_tests import steady_running
    from martensite.scenario.tables import read_table

    record = read_table(path, interval=1.0)
    return steady_running(record["voltage"], record["current"], _speeds(record))


def read_rise(path: Path | None, column: str) -> Rise | None:
    """The exponential rise of a current or a speed; None without a record.

    Raises:
        DataError: the record does not hold what is needed.
    """
    from martensite.characterise.time_constant import fit_rise
    from martensite.scenario.tables import read_table

    if path is None:
        return None
    record = read_table(path)
    if record.interval is not None:
        raise DataError(f"`{path.name}` has no column `time`; a rise needs one, `time [s]`.")
    values = _speeds(record) if column == "speed" else record[column]
    return fit_rise(record.times, values)


def _speeds(record: Record) -> list[float]:
    """Column `speed` [rad/s]."""
    from martensite.base import units

    numbers, unit = record["speed"], record.units["speed"]
    if unit not in SPEEDS:
        raise DataError(
            f"Column `speed` of record `{record.name}` must be in {' or '.join(SPEEDS)}, but is in "
            f"`{unit}`; write for example `speed [rpm]`."
        )
    return [units.to_si(number, unit, SPEED) for number in numbers]


def _positive(name: str, text: str, unit: str) -> float:
    found = quantity(name, text, unit)
    if not found > 0.0:
        raise InputError(f"Option `--{name}` must be above 0 {unit}, but is {found:g} {unit}.")
    return found


def print_motor(found: MotorConstants, states: int) -> None:
    """Print the constants, and what is doubtful."""
    from martensite.base.confidence import LEVEL
    from martensite.characterise.motor_constants import UNITS
    from martensite.cli import show

    show.text(f"DC motor from {states} steady states", "bold")
    rows = [
        estimate_row(f"{symbol}, {name.replace('_', ' ')}", getattr(found, name), UNITS[name])
        for name, symbol in SYMBOLS.items()
        if getattr(found, name) is not None
    ]
    show.table(("constant", "value", "unit"), rows, right="value")
    show.text(f"± half the {100 * LEVEL:g} % interval; a number that was given has none.")
    if found.run_up_time is not None:
        show.text(f"R J/(K_T K_B) = {found.run_up_time:.4g} s")
    for remark in found.remarks:
        show.text(remark, "yellow")
