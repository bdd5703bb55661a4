"""Spoilt files of instruments are read in the units of their own words, or refused.

Source of truth: the words of each spoilt file, parsed by `unit_words`, which shares nothing with the reader; and the
numbers of the file times the factor of that unit.
"""

from __future__ import annotations

import random
from pathlib import Path

import numpy as np
import pytest
from fault_trials import spoil_bytes
from lab_cases import FILES, spoil_heads, spoil_lines, write_case
from unit_words import Words, read_words

from martensite.base.errors import MartensiteError
from martensite.logs.lab_files import LabFile, ReadColumn
from martensite.logs.reader import read_log

SPOILERS = (spoil_bytes, spoil_lines, spoil_heads, spoil_heads)


def find_fault(found: LabFile, column: ReadColumn, words: Words) -> str:
    """Return how a column contradicts the words of its file without a note; empty if it does not."""
    told = column.certainty != "given" and f"Column {column.number}" in " ".join(found.notes)
    if not words.claims or told or column.unit == "clock":
        return ""
    if column.name == "time":
        fits = words.allows_times(found.record.times.tolist())
    elif column.si == "1" and all(unit != "1" for unit, _, _ in words.claims):
        fits = f"Column {column.number}" in " ".join(found.notes)  # kept as plain numbers
    else:
        fits = words.allows(column.si, found.record[column.name])
    return (
        "" if fits else f"column {column.number} `{column.heading}` as {column.name} in {column.unit}: {words.claims}"
    )


def judge_file(path: Path) -> tuple[int, list[str]]:
    """Return the number of columns whose units the file gives, and the faults of their reading."""
    found, words = read_log(path, known=True), read_words(path.read_bytes())
    assert not found.has_time or np.all(np.diff(found.record.times) > 0.0)
    alike = len(words) == len(found.columns)  # else the parser splits the rows otherwise, and makes no claim
    own = [(one, words[one.number]) for one in found.columns if one.si and alike]
    return sum(bool(w.claims) for _, w in own), [fault for one, w in own if (fault := find_fault(found, one, w))]


@pytest.mark.parametrize(("seed", "files"), [(5, 120), pytest.param(6, 3000, marks=pytest.mark.slow)])
def test_spoilt_files_are_read_by_their_own_words_or_refused(tmp_path: Path, seed: int, files: int) -> None:
    rng, claims, refused = random.Random(seed), 0, 0
    names = [name for name in FILES if FILES[name].get("rows", 40) == 40]
    for k in range(files):
        path, spoil = write_case(tmp_path, rng.choice(names)), rng.choice(SPOILERS)
        path.write_bytes(spoil(path.read_bytes(), rng))
        try:
            claimed, faults = judge_file(path)
        except MartensiteError:
            refused += 1
            continue
        claims += claimed
        assert not faults, f"file {k}, {path.name} after {spoil.__name__}: {faults}"
    assert refused < 0.4 * files and claims > files, "the parser makes too few claims"


HEADINGS = {
    "time,V\n0,1\n1,2\n2,1\n3,4\n4,3\n": ("time", "voltage"),
    "Elapsed Time (%),F (N)\n0,1\n1,2\n2,1\n3,4\n4,3\n": ("elapsed_time", "force"),
    "strain,stress\n%,MPa\n0,1\n1,2\n2,1\n3,4\n4,3\n": ("strain", "stress"),
    "time,T (C),F (N)\n,nan,nan\n0,20,1\n1,21,2\n2,22,1\n3,23,4\n4,24,3\n": ("time", "temperature", "force"),
    "Sig1\tTime (min)\nSig2\tTemperature (°C)\nSig3\tForce (N)\n" + 5 * "Remark\n" + "0\t1\t2\n1\t2\t3\n2\t3\t4\n": (
        *("time", "temperature", "force"),
    ),
}
"""Text -> its columns: a row of headings is no row of units; % is no angle, and no comment; missing cells no headings;
signals are named far above."""


@pytest.mark.parametrize("text", HEADINGS)
def test_rows_above_a_table_are_told_apart(text: str, tmp_path: Path) -> None:
    path = tmp_path / "a.csv"
    path.write_text(text)
    found = read_log(path, known=True)
    assert tuple(one.name for one in found.columns) == HEADINGS[text]


def test_a_heading_and_a_unit_row_that_disagree_are_told(tmp_path: Path) -> None:
    path = tmp_path / "a.csv"
    path.write_text("time,Temp (C)\ns,deg\n" + "".join(f"{k},{20 + k}\n" for k in range(9)))
    found = read_log(path)
    assert found.columns[1].certainty == "ambiguous" and "has another unit, deg" in found.notes[0]


def test_a_unit_by_values_of_a_second_column_is_no_given_unit(tmp_path: Path) -> None:
    path = tmp_path / "a.csv"
    path.write_text("time [s],Temp (C),Set temperature\n" + "".join(f"{k},{20 + k},{30 + k}\n" for k in range(9)))
    assert [one.certainty for one in read_log(path).columns] == ["given", "given", "inferred"]
