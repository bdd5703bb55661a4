"""`fit motor`, `fit tangents` and `fit vibration`."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from typer import Argument, Option

from martensite.base.errors import DataError, InputError, suggest_name
from martensite.cli.commands.fit import fit
from martensite.cli.options import Json, NamedColumns, Text, Texts, read_positive, read_quantity, spread_options
from martensite.cli.outputs import AnswerOptions, Outputs

if TYPE_CHECKING:
    from martensite.characterise.motor_constants import SteadyRunning, Winding
    from martensite.characterise.tangent_points import TangentPoints
    from martensite.characterise.time_constant import Rise
    from martensite.signals.records import Record

ALL_CYCLES = "all"
"""Value of `--cycle` for a table of every cycle."""
SPEED = "rad/s"
SPEEDS = (SPEED, "rpm")
"""Units of a speed; a frequency unit would be ambiguous."""


@fit.command("motor")
def motor(
    steady: Annotated[
        Path, Argument(metavar="STEADY", help="Table of steady states with columns `voltage`, `current`, `speed`.")
    ],
    locked: Annotated[
        Path | None, Option(help="Record with the rotor locked: columns `voltage` and `current`.")
    ] = None,
    resistance: Annotated[Text, Option(help='Winding resistance instead of --locked, e.g. "41 ohm".')] = None,
    current_rise: Annotated[
        Path | None, Option(help="Record of a voltage step with the rotor locked: columns `time` and `current`.")
    ] = None,
    inductance: Annotated[Text, Option(help='Winding inductance instead of --current-rise, e.g. "3 mH".')] = None,
    run_up: Annotated[
        Path | None, Option(help="Record of a voltage step with the rotor free: columns `time` and `speed`.")
    ] = None,
    json: Json = False,
) -> None:
    """Compute constants of a DC motor from laboratory tests.

    Resistance and steady states give K_T = K_B and viscous and dry friction; a run-up gives the inertia. Records of
    a step start after the step. Speeds are in rad/s or rpm.
    """
    winding = read_winding(locked, resistance)
    coil = read_positive("inductance", inductance, "H")
    states = read_steady(steady)
    from martensite.characterise.motor_constants import estimate_motor_constants
    from martensite.show.summaries.laboratory import summarise_motor

    motor_constants = estimate_motor_constants(
        states,
        winding,
        current_rise=read_rise(current_rise, "current"),
        inductance=coil,
        run_up=read_rise(run_up, "speed"),
    )
    Outputs(None, None).answer(summarise_motor(motor_constants, len(states.speeds)), json)


def read_winding(locked: Path | None, resistance: str | None) -> Winding:
    """Return the winding from a locked-rotor test or a given resistance."""
    from martensite.characterise.estimate import MeasuredValue
    from martensite.characterise.motor_constants import Winding, winding_resistance
    from martensite.logs.reader import read_complete

    if (locked is None) == (resistance is None):
        raise InputError("Give the resistance in one way: --locked TABLE or --resistance.")
    if locked is None:
        return Winding(MeasuredValue(read_positive("resistance", str(resistance), "ohm")))
    record = read_complete(locked, 1.0)
    return winding_resistance(record["voltage"].tolist(), record["current"].tolist())


def read_steady(path: Path) -> SteadyRunning:
    """Return the steady states of a table with voltage, current and speed."""
    from martensite.characterise.motor_constants import collect_steady_states
    from martensite.logs.reader import read_complete

    record = read_complete(path, 1.0)
    return collect_steady_states(record["voltage"].tolist(), record["current"].tolist(), _read_speeds(record))


def read_rise(path: Path | None, column: str) -> Rise | None:
    """Return the exponential rise of a current or speed; None without a record."""
    from martensite.characterise.time_constant import fit_rise
    from martensite.logs.reader import read_complete

    if path is None:
        return None
    record = read_complete(path)
    if record.interval is not None:
        raise DataError(f"`{path.name}` has no column `time`; a rise needs one, `time [s]`.")
    values = _read_speeds(record) if column == "speed" else record[column].tolist()
    return fit_rise(record.times.tolist(), values)


def _read_speeds(record: Record) -> list[float]:
    from martensite.base import units

    numbers, unit = record["speed"].tolist(), record.units["speed"]
    if unit not in SPEEDS:
        raise DataError(
            f"Column `speed` of record `{record.name}` must be in {' or '.join(SPEEDS)}, but is in "
            f"`{unit}`; write for example `speed [rpm]`."
        )
    return [units.to_si(number, unit, SPEED) for number in numbers]


@dataclass(frozen=True)
class SpecimenOptions:
    """Columns and sizes of a specimen."""

    length: Annotated[Text, Option(help='Gauge length of a log without strain, e.g. "50 mm".')] = None
    diameter: Annotated[Text, Option(help='Wire diameter of a log without stress, e.g. "0.381 mm".')] = None
    new_headings: NamedColumns = None

    def read(self, logs: Sequence[str]) -> list[Record]:
        """Return the tables of all logs with strain and stress."""
        from martensite.characterise.specimen import add_strain_and_stress
        from martensite.logs.reader import parse_new_headings, read_parts, tell_guesses

        sizes = read_positive("length", self.length, "m"), read_positive("diameter", self.diameter, "m")
        parts = [part for log in logs for part in read_parts(log, parse_new_headings(self.new_headings or ()))]
        return [add_strain_and_stress(tell_guesses(part).record, *sizes) for part in parts]


@fit.command("tangents")
@spread_options
def tangents(
    logs: Annotated[
        list[str],
        Argument(
            metavar="LOG...",
            help=(
                "Isobaric cycles, one per table, with `temperature`, `strain` and `stress`; or data:SET/FILE for "
                "a published data set."
            ),
        ),
    ],
    answer: AnswerOptions,
    sizes: SpecimenOptions,
    stress: Annotated[Texts, Option(help='Constant stress of each log, e.g. "100 MPa"; repeatable.')] = None,
    cycle: Annotated[
        Text,
        Option(metavar="NUMBER|all", help="Cycle of each log, from 1, or all cycles of one log [default: the last]."),
    ] = None,
) -> None:
    """Compute transformation temperatures by the tangent method.

    Each LOG contains one complete heating and cooling under a constant stress. Three straight lines per branch give
    A_s, A_f, M_s, M_f and the transformation strain. Two or more stresses give C_A, C_M and the temperatures at
    zero stress.
    """
    outputs = answer.check_files()
    from martensite.characterise.tangent_fit import fit_tangents
    from martensite.show.figures.laboratory import plot_tangents
    from martensite.show.summaries.laboratory import summarise_cycles, summarise_tangents

    if cycle == ALL_CYCLES:
        cycles = read_all_cycles(logs, stress, sizes)
        good = [one for one in cycles if not isinstance(one, str)]
        title = f"Tangents of {len(good)} of {len(cycles)} cycles"
        draw = None if not good else lambda: plot_tangents(good[-1], title)
        outputs.answer(summarise_cycles(cycles), answer.json, draw=draw)
        return
    levels = read_cycles(logs, stress, cycle, sizes)
    result = fit_tangents(levels) if len(levels) > 1 else levels[0]
    title = f"Tangents of {levels[0].name if len(levels) == 1 else f'{len(levels)} cycles'}"
    summary = summarise_tangents(result)
    outputs.answer(summary, answer.json, draw=lambda: plot_tangents(result, title))


def read_all_cycles(
    logs: Sequence[str], stresses: Sequence[str] | None, sizes: SpecimenOptions
) -> list[TangentPoints | str]:
    """Return the tangents of every cycle of one log; for a cycle without lines the reason.

    Raises:
        InputError: there are several logs or stresses.
        DataError: the log is missing, malformed, or holds no isobaric cycle.
    """
    from martensite.characterise.tangent_points import find_all_cycles

    if len(logs) != 1 or len(stresses or ()) > 1:
        raise InputError(f"Option `--cycle all` takes one LOG with one stress, but there are {len(logs)} logs.")
    level = read_quantity("stress", stresses[0], "Pa") if stresses else None
    records = sizes.read(logs)
    if len(records) != 1:
        names = ", ".join(f"`{one.name}`" for one in records)
        raise InputError(f"Option `--cycle all` takes one table, but `{logs[0]}` has {len(records)}: {names}.")
    return find_all_cycles(records[0], stress=level)


def read_cycles(
    logs: Sequence[str], stresses: Sequence[str] | None, cycle: str | None, sizes: SpecimenOptions
) -> list[TangentPoints]:
    """Return the tangents of each log."""
    from martensite.characterise.isobaric_cycles import cut_cycle
    from martensite.characterise.tangent_points import find_tangent_points

    if cycle is not None and not (cycle.isdecimal() and int(cycle) > 0):
        raise InputError(f"Option `--cycle` counts from 1 on, or is `all`, but is {cycle}.")
    records = sizes.read(logs)
    if stresses and len(stresses) != len(records):
        raise InputError(
            f"Give --stress once for every LOG, in their order; stresses: {len(stresses)}, logs: {len(records)}."
        )
    given = [read_quantity("stress", text, "Pa") for text in stresses] if stresses else [None] * len(records)
    points: list[TangentPoints] = []
    for record, stress in zip(records, given, strict=True):
        count = cut_cycle(record, stress=stress).cycles
        if cycle is not None and int(cycle) > count:
            raise InputError(
                f"Option `--cycle` must be from 1 to {count} for record `{record.name}`, or `all`, but is {cycle}."
            )
        points.append(find_tangent_points(record, stress=stress, cycle=-1 if cycle is None else int(cycle) - 1))
    return points


@fit.command("vibration")
def vibration(
    record: Annotated[Path, Argument(metavar="RECORD", help="Record with `time` and the vibrating quantity.")],
    column: Annotated[
        Text, Option(help="Column of the vibrating quantity, e.g. position; needed if there are several.")
    ] = None,
    start: Annotated[Text, Option(help='Start of the free vibration, e.g. "0.5 s".')] = None,
    end: Annotated[Text, Option(help='End of the evaluated part, e.g. "4 s".')] = None,
    cycles: Annotated[int | None, Option(help="Maximum number of cycles [default: all].")] = None,
    stiffness: Annotated[Text, Option(help='Known stiffness, e.g. "540 N/m"; gives the moving mass.')] = None,
    mass: Annotated[Text, Option(help='Known moving mass, e.g. "190 g"; gives the stiffness.')] = None,
    json: Json = False,
) -> None:
    """Compute frequency and damping of a free vibration.

    RECORD starts at the release, or --start gives its time. The frequency follows from the spectrum and then from
    the times of the extremes. The damping ratio follows from the logarithmic decrement over all cycles.
    """
    if stiffness is not None and mass is not None:
        raise InputError("Give --stiffness or --mass, not both: the frequency tells the other one.")
    k, m = read_positive("stiffness", stiffness, "N/m"), read_positive("mass", mass, "kg")
    times, values, label = read_vibration(record, column, start, end)
    from martensite.characterise.free_vibration import log_decrement
    from martensite.characterise.spectrum import natural_frequency
    from martensite.show.summaries.laboratory import Oscillator, summarise_vibration

    peak = natural_frequency(times, values)
    decrement = log_decrement(times, values, cycles=cycles, frequency=peak.frequency)
    title = f"Free vibration of {label}, {len(times)} rows, {decrement.cycles:g} cycles used"
    Outputs(None, None).answer(summarise_vibration(peak, decrement, Oscillator(k, m), title), json)


def read_vibration(
    path: Path, column: str | None, start: str | None, end: str | None
) -> tuple[list[float], list[float], str]:
    """Return times [s] and values of a record between two times, and the name of the values."""
    from martensite.logs.reader import read_complete

    record = read_complete(path)
    if record.interval is not None:
        raise DataError(f"`{path.name}` has no column `time`; a vibration needs one, `time [s]`.")
    name = _choose_column(record, column)
    first = -math.inf if start is None else read_quantity("start", start, "s")
    last = math.inf if end is None else read_quantity("end", end, "s")
    rows = (first <= record.times) & (record.times <= last)
    if not rows.any():
        raise DataError(
            f"`{path.name}` has no rows between --start and --end: it goes from "
            f"{record.times[0]:.6g} s to {record.times[-1]:.6g} s."
        )
    unit = record.units[name]
    label = f"`{name}`" if unit == "1" else f"`{name}` [{unit}]"
    return record.times[rows].tolist(), record[name][rows].tolist(), label


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
