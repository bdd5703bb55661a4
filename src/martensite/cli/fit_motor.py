"""`fit motor`: constants of a DC motor from its tests."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from typer import Argument, Option

from martensite.base.errors import DataError, InputError
from martensite.cli.fit import fit
from martensite.cli.options import Json, Text, read_positive
from martensite.cli.outputs import Outputs

if TYPE_CHECKING:
    from martensite.characterise.motor_tests import SteadyRunning, Winding
    from martensite.characterise.time_constant import Rise
    from martensite.signals.records import Record

SPEED = "rad/s"
SPEEDS = (SPEED, "rpm")
"""Units of a speed; those of a frequency would leave open what turns once."""


@fit.command("motor")
def motor(
    steady: Annotated[Path, Argument(metavar="STEADY", help="Steady states: `voltage`, `current`, `speed`.")],
    locked: Annotated[Path | None, Option(help="Rotor held still: `voltage` and `current`.")] = None,
    resistance: Annotated[Text, Option(help='Resistance instead, e.g. "41 ohm".')] = None,
    current_rise: Annotated[Path | None, Option(help="Step of the voltage, rotor held: `time` and `current`.")] = None,
    inductance: Annotated[Text, Option(help='Inductance instead, e.g. "3 mH".')] = None,
    run_up: Annotated[Path | None, Option(help="Step of the voltage, rotor free: `time` and `speed`.")] = None,
    json: Json = False,
) -> None:
    """Constants of a DC motor from its tests.

    The resistance and the steady states give K_T = K_B and friction, viscous and dry; a run-up
    gives the inertia. Records of a step begin after it. Speeds are in rad/s or rpm.
    """
    winding = read_winding(locked, resistance)
    coil = read_positive("inductance", inductance, "H")
    states = read_steady(steady)
    from martensite.characterise.motor_constants import estimate_motor_constants
    from martensite.show.summaries.laboratory import summarise_motor

    found = estimate_motor_constants(
        states,
        winding,
        current_rise=read_rise(current_rise, "current"),
        inductance=coil,
        run_up=read_rise(run_up, "speed"),
    )
    Outputs(None, None).answer(summarise_motor(found, len(states.speeds)), json)


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
        return Winding(MeasuredValue(read_positive("resistance", str(resistance), "ohm")))
    record = read_table(locked, interval=1.0)
    return winding_resistance(record["voltage"], record["current"])


def read_steady(path: Path) -> SteadyRunning:
    """Steady states of a table with voltage, current and speed.

    Raises:
        DataError: the table does not hold what is needed.
    """
    from martensite.characterise.motor_tests import steady_running
    from martensite.scenario.tables import read_table

    record = read_table(path, interval=1.0)
    return steady_running(record["voltage"], record["current"], _read_speeds(record))


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
    values = _read_speeds(record) if column == "speed" else record[column]
    return fit_rise(record.times, values)


def _read_speeds(record: Record) -> list[float]:
    """Column `speed` [rad/s]."""
    from martensite.base import units

    numbers, unit = record["speed"], record.units["speed"]
    if unit not in SPEEDS:
        raise DataError(
            f"Column `speed` of record `{record.name}` must be in {' or '.join(SPEEDS)}, but is in "
            f"`{unit}`; write for example `speed [rpm]`."
        )
    return [units.to_si(number, unit, SPEED) for number in numbers]
