"""Laws along a recorded path: what each says where a specimen was heated, or stretched.

A log in which the stress rests is followed in stress and temperature, and strains are compared; one in which it moves
is followed in strain and temperature, and stresses are compared, since a plateau answers to strain and jumps under
stress. Before its first row a law is cooled from austenite under the first stress, unless its phase state is given.

Where strain is zero is a matter of the log: compared strains are shifted by the mean of their difference, and a strain
that is followed begins at that of the law.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from martensite.base.errors import DataError
from martensite.kernels import floats
from martensite.physics.laws.base import AbstractLaw, Fractions
from martensite.scenario.laws import ConfiguredLaw, configure_laws
from martensite.scenario.log_tables import read_log_table
from martensite.signals.records import Record
from martensite.simulate.compiled_law import AUSTENITE
from martensite.simulate.path_layout import Choices, Guide
from martensite.simulate.point import PathLeg, PointResult, material_point

RESTS = 0.5
"""Range of a stress over its largest value below which it rests."""
ROWS = 400
"""Most rows of a log that are followed."""
ABOVE = 10.0
"""How far above A_f a law begins, or the hottest row [K]."""
Column = NDArray[np.float64]


@dataclass(frozen=True)
class RecordedPath:
    """Rows of a log that a law follows; SI."""

    name: str
    compared: str
    """`strain` or `stress`: what is not followed."""
    time: Column
    temperature: Column
    stress: Column
    strain: Column

    @property
    def measured(self) -> Column:
        """What is compared."""
        return getattr(self, self.compared)

    @property
    def range(self) -> float:
        """Between the smallest and the largest of it."""
        return float(np.ptp(self.measured))

    def list_legs(self, shift: float) -> list[PathLeg]:
        """From row to row; recorded strains count from those of the law, by a shift [-]."""
        times = np.maximum(np.diff(self.time), 1e-9).tolist()
        followed = self.stress if self.compared == "strain" else self.strain + shift
        name = "stress" if self.compared == "strain" else "strain"
        rows = zip(self.temperature[1:].tolist(), followed[1:].tolist(), times, strict=True)
        return [PathLeg(temperature=T, **{name: x}, duration=dt) for T, x, dt in rows]


class Misfit(NamedTuple):
    """Difference of law and log, as shares of the recorded range."""

    rms: float
    largest: float


@dataclass(frozen=True)
class LawComparison:
    """What a law says along a log."""

    configured: ConfiguredLaw
    path: RecordedPath
    result: PointResult
    """At the rows of the path; its strains are those of the law."""
    shift: float
    """What is added to strains of the law to compare them with those of the log [-]."""

    @property
    def computed(self) -> Column:
        """What is compared, as the log counts it."""
        found = self.result[self.path.compared]
        return found + self.shift if self.path.compared == "strain" else found

    @property
    def misfit(self) -> Misfit:
        """How far the two are apart."""
        apart = np.abs(self.computed - self.path.measured) / self.path.range
        return Misfit(float(np.sqrt(np.mean(apart**2))), float(apart.max()))


def compare_laws_with_log(
    names: Sequence[str],
    log: str | Path | Record,
    *,
    material: str | None = None,
    settings: Mapping[str, Any] | None = None,
    named: Mapping[str, str] | None = None,
    stress: float | None = None,
    temperature: float | None = None,
    fractions: Fractions | None = None,
    tolerance: float = 1e-3,
    runtime: str = "floats",
) -> list[LawComparison]:
    """Drive laws along the recorded path of a specimen, and say how far they are from it.

    Args:
        names: laws, numbers as `martensite law` finds them.
        log: a file, `data:SET/FILE`, or a record: `strain` [-], `temperature` [K] and `stress` [Pa].
        material: whose numbers; by default the first that has all of them.
        settings: values by parameter, or by law and parameter.
        named: what columns are, as of `read_lab_file`.
        stress: a constant one [Pa], where the log has none.
        temperature: a constant one [K], where the log has none.
        fractions: phase state at the first row; by default that of a specimen cooled under the first stress.
        tolerance: accepted change on halving the steps, as a share of range.
        runtime: `floats`, or `c`.

    Raises:
        DataError: the log cannot be read, or does not hold what is needed.
        InputError: a law, a material or a number is not known.
        SolveError: a law cannot be driven along the path.
    """
    record = log if isinstance(log, Record) else read_log_table(log, 1.0, named)
    path = cut_path(record, stress, temperature)
    how = {"steps": 1, "tolerance": tolerance, "runtime": runtime}
    configured = configure_laws(list(dict.fromkeys(names)), material, settings or {})
    return [_follow_path(one, path, fractions, how) for one in configured]


def cut_path(record: Record, stress: float | None = None, temperature: float | None = None) -> RecordedPath:
    """The rows of a record that a law follows: complete ones, equally far apart.

    Raises:
        DataError: a column is missing or given twice, or nothing moves.
    """
    columns = {name: np.asarray(record[name], float) for name in ("time", "strain") if name in record.columns}
    for name, given, option in (("stress", stress, "--stress"), ("temperature", temperature, "--at")):
        if (name in record.columns) == (given is not None):
            missing = f"has no column `{name}`; name it (`--as`), or give a constant one (`{option}`)"
            twice = f"has a column `{name}`, so that `{option}` has no effect"
            raise DataError(f"Record `{record.name}` {missing if given is None else twice}.")
        columns[name] = np.asarray(record[name], float) if given is None else np.full(len(record), given)
    if "strain" not in columns:
        raise DataError(f"Record `{record.name}` has no column `strain`; name it (`--as`).")
    whole = np.all([np.isfinite(column) for column in columns.values()], axis=0)
    columns = {name: column[whole] for name, column in columns.items()}
    if not whole.any() or np.ptp(columns["strain"]) == 0.0:
        raise DataError(f"In record `{record.name}` no strain moves.")
    pull = columns["stress"]
    compared = "strain" if np.ptp(pull) <= RESTS * np.abs(pull).max() else "stress"
    rows = _pick_rows([columns[name] for name in ("temperature", "stress", "strain")])
    return RecordedPath(record.name, compared, **{name: column[rows] for name, column in columns.items()})


def _pick_rows(columns: Sequence[Column]) -> NDArray[np.int_]:
    """Indices of at most `ROWS` rows, equally far apart on the way that they go, both ends included."""
    moving = [column / np.ptp(column) for column in columns if np.ptp(column) > 0.0]
    way = np.concatenate([[0.0], np.cumsum(np.sum([np.abs(np.diff(column)) for column in moving], axis=0))])
    wanted = np.searchsorted(way, np.linspace(0.0, way[-1], ROWS))
    return np.unique(np.append(wanted, way.size - 1))


def _follow_path(
    one: ConfiguredLaw, path: RecordedPath, fractions: Fractions | None, how: dict[str, Any]
) -> LawComparison:
    law, first = one.law, (float(path.stress[0]), float(path.temperature[0]))
    if path.compared == "stress":
        first = max(first[0], 0.0), first[1]
    cooling = _cool_down(law, first, float(path.temperature.max())) if fractions is None else None
    start = first if cooling is None else (first[0], cooling[0])
    before = [] if cooling is None else [cooling[1]]
    phases = AUSTENITE if fractions is None else fractions
    shift = 0.0
    if path.compared == "stress":
        rest = law.strain(floats, phases, *first)
        if before:
            rest = material_point(law, before, start=start, **how).strain[-1]
        shift = rest - float(path.strain[0])
    legs = [*before, *path.list_legs(shift)]
    found = material_point(law, legs, start=start, fractions=phases, label=path.name, **how)
    found = _cut_result(found, len(before))
    if path.compared == "strain":
        shift = float(np.mean(path.strain - found["strain"]))
    return LawComparison(one, path, found, shift)


def _cool_down(law: AbstractLaw, end: tuple[float, float], hottest: float) -> tuple[float, PathLeg]:
    """Where austenite is under the first stress [K], and the leg from there to the first row."""
    hot = max(Guide(law, Choices()).marks_at(end[0]).A_f, hottest) + ABOVE
    return hot, PathLeg(temperature=end[1], hold="stress", duration=hot - end[1], steps=50)


def _cut_result(found: PointResult, before: int) -> PointResult:
    """From the first row of a log on, as one leg."""
    begin = found.ends[before]
    names = ("time", "stress", "strain", "temperature", "martensite", "oriented")
    columns: dict[str, Any] = {name: getattr(found, name)[begin:] for name in names}
    begun = columns["time"][0]
    columns["time"] = [time - begun for time in columns["time"]]
    return replace(found, legs=found.legs[-1:], ends=[0, len(columns["time"]) - 1], **columns)
