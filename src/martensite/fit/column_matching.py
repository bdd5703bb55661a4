"""Which columns of a log are compared with which outputs, and what drives instead.

Without a word every column is compared that is an output of the system, but for those that say
what drives it, and those that never change.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import replace

from martensite.actuators.assembly import AbstractSystem
from martensite.base.errors import DataError, suggest_name
from martensite.fit.columns import ComparedColumn
from martensite.signals.records import Record

ECHOES = {"K": ("temperature", "hottest"), "V": ("voltage",), "A": ("current",), "W": ("power",)}
"""Unit of a drive -> outputs that only say what drives."""


def list_echoes(system: AbstractSystem) -> set[str]:
    """Outputs that repeat what drives a system."""
    found = set(system.mechanism.signals())
    for port, one in system.actuators().items():
        names = ("drive", *ECHOES.get(one.source.unit, ()))
        found |= {system.label(port, name) for name in names}
    return found


def match_columns(
    record: Record,
    system: AbstractSystem,
    wanted: Sequence[ComparedColumn],
    follows: Mapping[str, str],
) -> tuple[dict[str, str], Record, list[str]]:
    """Output -> column of a record, the record with scaled columns, and what is left out.

    Args:
        record: as measured.
        system: that is to explain it.
        wanted: outputs that are asked for; all in common if empty.
        follows: drive -> column that it follows.

    Raises:
        DataError: a column is missing, or there is none to compare.
    """
    if wanted:
        return _match_asked(record, wanted, system)
    driven = list_echoes(system) | set(follows.values())
    common = [n for n in record.columns if n in system.outputs() and n not in driven]
    if not common:
        raise DataError(_refuse_nothing(record, system, driven))
    varied = [name for name in common if not _is_constant(record[name])]
    notes = [
        f"Column `{name}` of record `{record.name}` {_explain_mismatch(record[name])} and is not "
        "compared."
        for name in common
        if name not in varied and varied
    ]
    return {name: name for name in varied or common}, record, notes


def _match_asked(
    record: Record, wanted: Sequence[ComparedColumn], system: AbstractSystem
) -> tuple[dict[str, str], Record, list[str]]:
    columns, known = {}, system.outputs()
    for one in wanted:
        column = _find_column(record, one.column)
        columns[one.output] = column
        if one.factor != 1.0 and one.output in known:
            record = _scale_column(record, column, one, known[one.output].unit)
            columns[one.output] = one.output
    return columns, record, []


def _find_column(record: Record, name: str) -> str:
    """A column by its name in the file, or as the reader spells that."""
    spelt = re.sub(r"[\s-]+", "_", name.strip().lower())
    if name not in record.columns and spelt not in record.columns:
        known = [column for column in record.columns if column != "time"]
        raise DataError(
            f"Record `{record.name}` has no column `{name}`. {suggest_name(name, known)}"
        )
    return name if name in record.columns else spelt


def _scale_column(record: Record, column: str, one: ComparedColumn, unit: str) -> Record:
    """The record with a column for an output, in its unit."""
    numbers = [one.factor * number for number in record[column]]
    return replace(
        record,
        columns=record.columns | {one.output: numbers},
        units=record.units | {one.output: unit},
    )


def _is_constant(numbers: Sequence[float]) -> bool:
    known = [number for number in numbers if math.isfinite(number)]
    return not known or max(known) == min(known)


def _explain_mismatch(numbers: Sequence[float]) -> str:
    return "never changes" if any(map(math.isfinite, numbers)) else "holds no numbers"


def _refuse_nothing(record: Record, system: AbstractSystem, driven: set[str]) -> str:
    held = [name for name in record.columns if name != "time"]
    listed = ", ".join(f"`{name}`" for name in held) or "none but `time`"
    drives = ", ".join(f"`{name}`" for name in held if name in driven)
    why = f", of which {drives} say what drives" if drives else ""
    return (
        f"Record `{record.name}` has no column to compare: it holds {listed}{why}; the system "
        f"gives {', '.join(f'`{n}`' for n in system.outputs() if n not in driven)}. For a column "
        "of another name write `OUTPUT=COLUMN` (--column)."
    )
