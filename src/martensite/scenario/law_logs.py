"""Comparison of laws with the recorded path of a specimen.

A log with a resting stress is followed in stress and temperature, and strains are compared. A log with a moving stress
is followed in strain and temperature, and stresses are compared, because stress control would jump over plateaus. By
default a law is cooled from austenite under the first stress.

The zero of strain is a matter of the log. Compared strains are shifted by the mean difference; a followed strain begins
at the strain of the law.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from martensite.base.errors import DataError
from martensite.kernels import floats
from martensite.logs.reader import read_log_table
from martensite.physics.laws.base import Fractions
from martensite.scenario.laws import ConfiguredLaw, configure_laws
from martensite.signals.records import Record
from martensite.simulate.compiled_law import AUSTENITE
from martensite.simulate.path_layout import Choices, Guide
from martensite.simulate.point import COLUMNS, PathLeg, PointResult, material_point

RESTS = 0.5
"""Range of a stress over its largest value below which it rests."""
ROWS = 400
"""Largest number of followed rows of a log."""
Column = NDArray[np.float64]


@dataclass(frozen=True)
class LawComparison:
    """Response of a law to the excitation of a log."""

    configured: ConfiguredLaw
    log: str
    compared: str
    """`strain` or `stress`, the quantity that is not followed."""
    recorded: dict[str, Column]
    """Followed rows: time, temperature, stress and strain, in SI."""
    result: PointResult
    """State at these rows, with strains of the law."""
    shift: float
    """Offset from strains of the law to strains of the log [-]."""

    @property
    def computed(self) -> Column:
        """Return the compared column of the law, with the offset of the log."""
        return self.result[self.compared] + (self.shift if self.compared == "strain" else 0.0)

    @property
    def misfit(self) -> Column:
        """Return the difference of law and log, as a share of the recorded range."""
        return (self.computed - self.recorded[self.compared]) / np.ptp(self.recorded[self.compared])

    @property
    def rms(self) -> float:
        """Return the root mean square of the misfit."""
        return float(np.sqrt(np.mean(self.misfit**2)))


def compare_laws_with_log(
    names: Sequence[str],
    log: str | Path | Record,
    *,
    material: str | None = None,
    settings: Mapping[str, Any] | None = None,
    new_headings: Mapping[str, str] | None = None,
    stress: float | None = None,
    temperature: float | None = None,
    fractions: Fractions | None = None,
    tolerance: float = 1e-3,
    runtime: str = "floats",
) -> list[LawComparison]:
    """Return the deviation of laws from the recorded path of a specimen.

    Args:
        names: laws; their numbers come from the material and the settings, as for `martensite law`.
        log: a file, `data:SET/FILE`, or a record with `strain` [-], `temperature` [K] and `stress` [Pa].
        material: source of the numbers, by default the first material that has all of them.
        settings: values by parameter, or by law and parameter.
        new_headings: meaning of the columns, as in `read_lab_file`.
        stress: constant stress [Pa] of a log without one.
        temperature: constant temperature [K] of a log without one.
        fractions: phase state at the first row, by default after cooling under the first stress.
        tolerance: accepted change on halving the steps, as a fraction of range.
        runtime: `floats` or `c`.

    Raises:
        DataError: the log cannot be read or lacks a quantity.
        InputError: a law, a material or a number is unknown.
        SolveError: a law cannot follow the path.
    """
    record = log if isinstance(log, Record) else read_log_table(log, 1.0, new_headings)
    rows = _pick_rows(record, {"stress": stress, "temperature": temperature})
    pull = np.abs(rows["stress"])
    compared = "strain" if np.ptp(rows["stress"]) <= RESTS * pull.max() else "stress"
    how = {"steps": 1, "tolerance": tolerance, "runtime": runtime, "label": record.name}
    configured = configure_laws(list(dict.fromkeys(names)), material, settings or {})
    return [_follow_rows(one, rows, compared, fractions, how) for one in configured]


def _pick_rows(record: Record, constant: Mapping[str, float | None]) -> dict[str, Column]:
    """Return complete rows of a record, at most `ROWS`, equally spaced along the path."""
    columns = _list_columns(record, constant)
    whole = np.all([np.isfinite(column) for column in columns.values()], axis=0)
    columns = {name: column[whole] for name, column in columns.items()}
    if not whole.any() or np.ptp(columns["strain"]) == 0.0:
        raise DataError(f"In record `{record.name}` no strain moves.")
    moving = [column / np.ptp(column) for name, column in columns.items() if name != "time" and np.ptp(column) > 0.0]
    way = np.concatenate([[0.0], np.cumsum(np.sum([np.abs(np.diff(column)) for column in moving], axis=0))])
    chosen = np.unique(np.append(np.searchsorted(way, np.linspace(0.0, way[-1], ROWS)), way.size - 1))
    return {name: column[chosen] for name, column in columns.items()}


def _list_columns(record: Record, constant: Mapping[str, float | None]) -> dict[str, Column]:
    """Return time and strain of a record, and the other columns or constants."""
    columns = {n: np.asarray(record[n], float) for n in ("time", "strain", *constant) if n in record.columns}
    given = {name: value for name, value in constant.items() if value is not None}
    for name in constant:
        if name in columns and name in given:
            raise DataError(f"Record `{record.name}` has a column `{name}`: a constant one has no effect.")
    columns |= {name: np.full(len(record), value) for name, value in given.items()}
    missing = next((name for name in ("strain", *constant) if name not in columns), None)
    if missing is not None:
        words = "" if missing == "strain" else ", or give a constant one (`--stress`, `--at`)"
        raise DataError(f"Record `{record.name}` has no column `{missing}`; name it (`--as`){words}.")
    return columns


def _follow_rows(
    one: ConfiguredLaw, rows: dict[str, Column], compared: str, fractions: Fractions | None, how: dict[str, Any]
) -> LawComparison:
    """Follow a path with a law; without a phase state it is first cooled from above A_f."""
    law, cold, shift = one.law, float(rows["temperature"][0]), 0.0
    pull = float(rows["stress"][0]) if compared == "strain" else max(float(rows["stress"][0]), 0.0)
    start, before = (pull, cold), list[PathLeg]()
    if fractions is None:
        hot = max(Guide(law, Choices()).marks_at(pull).A_f, float(rows["temperature"].max())) + 10.0
        start, before = (pull, hot), [PathLeg(temperature=cold, hold="stress", duration=hot - cold, steps=50)]
    how = how | {"start": start, "fractions": fractions or AUSTENITE}
    followed, name = rows["stress"], "stress"
    if compared == "stress":
        rest = material_point(law, before, **how).strain[-1] if before else law.strain(floats, how["fractions"], *start)
        shift = rest - float(rows["strain"][0])
        followed, name = rows["strain"] + shift, "strain"
    times = np.maximum(np.diff(rows["time"]), 1e-9).tolist()
    moves = zip(rows["temperature"][1:].tolist(), followed[1:].tolist(), times, strict=True)
    legs = [PathLeg(temperature=T, **{name: x}, duration=dt) for T, x, dt in moves]
    result = material_point(law, [*before, *legs], **how)
    columns: dict[str, Any] = {c: getattr(result, c)[result.ends[len(before)] :] for c in COLUMNS}
    columns["time"] = rows["time"] - rows["time"][0]
    result = replace(result, legs=result.legs[-1:], ends=[0, len(followed) - 1], **columns)
    if compared == "strain":
        shift = float(np.mean(rows["strain"] - result["strain"]))
    return LawComparison(one, how["label"], compared, rows, result, shift)
