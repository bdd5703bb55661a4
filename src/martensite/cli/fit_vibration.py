"""`fit vibration`: frequency and damping from the record of a free vibration."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from typer import Argument, Option

from martensite.base.errors import DataError, InputError, suggest_name
from martensite.cli.fit import fit
from martensite.cli.options import Json, Text, read_positive, read_quantity
from martensite.cli.outputs import Outputs

if TYPE_CHECKING:
    from martensite.signals.records import Record


@fit.command("vibration")
def vibration(
    record: Annotated[Path, Argument(metavar="RECORD", help="A record with `time` and what vibrates.")],
    column: Annotated[Text, Option(help="Column that vibrates, if there are several.")] = None,
    start: Annotated[Text, Option(help='Time from which on it is free, e.g. "0.5 s".')] = None,
    end: Annotated[Text, Option(help='Time of the last row used, e.g. "4 s".')] = None,
    cycles: Annotated[int | None, Option(help="Most cycles used; all if left out.")] = None,
    stiffness: Annotated[Text, Option(help='Stiffness, e.g. "540 N/m": gives the moving mass.')] = None,
    mass: Annotated[Text, Option(help='Moving mass, e.g. "190 g": gives the stiffness.')] = None,
    json: Json = False,
) -> None:
    """Frequency and damping from the record of a free vibration.

    RECORD begins at the release, or --start says when that was. The frequency is found from the
    spectrum, then from the times of the extremes; the damping ratio is that of the logarithmic
    decrement over all cycles.
    """
    if stiffness is not None and mass is not None:
        raise InputError("Give --stiffness or --mass, not both: the frequency tells the other one.")
    k, m = read_positive("stiffness", stiffness, "N/m"), read_positive("mass", mass, "kg")
    times, values, label = read_vibration(record, column, start, end)
    from martensite.characterise.free_vibration import log_decrement
    from martensite.characterise.spectrum import natural_frequency
    from martensite.show.summaries.laboratory import Oscillator, summarise_vibration

    peak = natural_frequency(times, values)
    found = log_decrement(times, values, cycles=cycles, frequency=peak.frequency)
    title = f"Free vibration of {label}, {len(times)} rows, {found.cycles:g} cycles used"
    Outputs(None, None).answer(summarise_vibration(peak, found, Oscillator(k, m), title), json)


def read_vibration(
    path: Path, column: str | None, start: str | None, end: str | None
) -> tuple[list[float], list[float], str]:
    """Times [s] and values of the part of a record between two times, and a name for the values.

    Raises:
        DataError: there is no such column, none to choose, no time, or no row in between.
        UnitError: `start` or `end` is no time.
    """
    from martensite.scenario.tables import read_table

    record = read_table(path)
    if record.interval is not None:
        raise DataError(f"`{path.name}` has no column `time`; a vibration needs one, `time [s]`.")
    name = _choose_column(record, column)
    first = -math.inf if start is None else read_quantity("start", start, "s")
    last = math.inf if end is None else read_quantity("end", end, "s")
    rows = [k for k, time in enumerate(record.times) if first <= time <= last]
    if not rows:
        raise DataError(
            f"`{path.name}` has no rows between --start and --end: it goes from "
            f"{record.times[0]:.6g} s to {record.times[-1]:.6g} s."
        )
    unit = record.units[name]
    label = f"`{name}`" if unit == "1" else f"`{name}` [{unit}]"
    return [record.times[k] for k in rows], [record[name][k] for k in rows], label


def _choose_column(record: Record, column: str | None) -> str:
    others = [name for name in record.columns if name != "time"]
    if column is None:
        if len(others) != 1:
            listed = ", ".join(f"`{name}`" for name in others) or "none"
            raise DataError(f"Give --column: record `{record.name}` has {len(others)} columns beside `time`, {listed}.")
        return others[0]
    if column not in others:
        raise DataError(f"Record `{record.name}` has no column `{column}`. {suggest_name(column, others)}")
    return column
