"""Whatever a logger writes between its rows is dropped and counted, and nothing else changes.

Source of truth: the table without the garbage, read strictly; and, for what counts as garbage,
a pattern of two plain numbers that is not shared with the reader.
"""

from __future__ import annotations

import re
import tempfile
from pathlib import Path

import pytest
from hypothesis import assume, example, given
from hypothesis import strategies as st

from martensite.base.errors import DataError
from martensite.logs.reader import read_table

NUMBER = r'\s*"?\s*[+-]?(\d+([.,]\d*)?|[.,]\d+)([eE][+-]?\d+)?\s*"?\s*'
SIGNS = {"whitespace": r"\s", "tab": "\t", "semicolon": ";", "comma": ","}
WRITTEN = {"whitespace": "  ", "tab": "\t", "semicolon": ";", "comma": ","}
HEADINGS = ["time [s]", "current [mA]"]
ROWS = st.lists(st.floats(-1e4, 1e4).map(lambda x: round(x, 3)), min_size=2, max_size=30)
LINES = st.one_of(
    st.sampled_from(
        [
            "Calibrating",
            "Cal1000.00  6.54 ",
            "5500.00  ",
            "1,2,3,4",
            "nan nan",
            "3 inf",
            '5 "7',
            '"',
            "\0\0\0",
            "1_0 5",
            "１ ２",
            "time current",
            "0\tx",
            "--",
            "5;",
            "1 2 3",
            "1e999 5",
        ]
    ),
    st.text(st.characters(exclude_characters="\n\r", exclude_categories=["Cs"]), max_size=30),
)
INSERTED = st.lists(st.tuples(st.integers(0, 30), LINES), max_size=12)


def is_row(line: str, separator: str) -> bool:
    """Whether a line could be two numbers."""
    return re.fullmatch(NUMBER + f"({SIGNS[separator]})+" + NUMBER, line, re.ASCII) is not None


def is_seen(line: str) -> bool:
    """Whether a line is neither empty nor a comment, which are never counted."""
    return bool(line.strip()) and not line.lstrip().startswith("#")


def read(lines: list[str], separator: str, *, drop: bool):
    """The record of a file of these lines."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "log.txt"
        path.write_bytes("\n".join(lines).encode())
        return read_table(path, HEADINGS, separator=separator, drop=drop)


def listed(record) -> dict[str, list[float]]:
    """The columns as lists, which can be compared."""
    return {name: column.tolist() for name, column in record.columns.items()}


def mixed(rows: list[str], inserted: list[tuple[int, str]]) -> list[str]:
    """The rows with lines put in before the given places."""
    lines = list(rows)
    for place, line in sorted(inserted, key=lambda item: -item[0]):
        lines.insert(min(place, len(rows)), line)
    return lines


@given(ROWS, INSERTED, st.sampled_from(sorted(SIGNS)))
@example([1.0, 2.0], [(0, "Calibrating"), (1, "\0"), (9, "5500.00  ")], "whitespace")
@example([1.0, 2.0], [(0, '"'), (2, '"')], "tab")
def test_garbage_is_dropped_and_counted(values, inserted, separator) -> None:
    assume(not any(is_row(line, separator) for _, line in inserted))
    rows = [f"{t}{WRITTEN[separator]}{x!r}" for t, x in enumerate(values)]
    clean = read(rows, separator, drop=False)
    found = read(mixed(rows, inserted), separator, drop=True)
    assert listed(found) == listed(clean)
    assert found.units == clean.units
    assert found.dropped == sum(is_seen(line) for _, line in inserted)


@given(ROWS, st.lists(st.integers(0, 29), max_size=10))
def test_repeated_times_are_dropped_and_counted(values, repeated) -> None:
    rows = [f"{t} {x!r}" for t, x in enumerate(values)]
    places = sorted(p for p in repeated if p < len(rows))
    lines = mixed(rows, [(p + 1, f"{p}.0 7.5") for p in places])
    found = read(lines, "whitespace", drop=True)
    assert listed(found) == listed(read(rows, "whitespace", drop=True))
    assert found.dropped == len(places)


@pytest.mark.parametrize("garbage", ["Calibrating", "Cal1000.00  6.54", "7.0", "1 nan", "1 2 3"])
def test_without_drop_garbage_is_an_error(garbage) -> None:
    with pytest.raises(DataError):
        read(["0 1.0", garbage, "2 3.0"], "whitespace", drop=False)


def test_nothing_but_garbage_is_an_error() -> None:
    with pytest.raises(DataError, match="has no numeric"):
        read(["Calibrating", "7.0", "ng"], "whitespace", drop=True)


@given(ROWS, st.sampled_from(sorted(SIGNS)))
def test_the_separator_is_that_of_most_lines(values, separator) -> None:
    rows = [f"{t}{WRITTEN[separator]}{x!r}" for t, x in enumerate(values)]
    found = read(["Calibrating", *rows], "auto", drop=True)
    assert listed(found) == listed(read(rows, separator, drop=False))


def test_a_decimal_comma_and_header_lines(tmp_path) -> None:
    header = [f"line {k}\t{k}" for k in range(13)]
    rows = ["12/07/2016\t19:36:38\t0\t25,699", "12/07/2016\t19:36:39\t0,483\t25,7", "12/07\t19:3"]
    path = tmp_path / "camera.txt"
    path.write_text("\n".join([*header, *rows]))
    columns = ["-", "-", "time [s]", "temperature [degC]"]
    found = read_table(path, columns, separator="tab", drop=True)
    assert found.times.tolist() == [0.0, 0.483]
    assert found["temperature"] == pytest.approx([25.699 + 273.15, 25.7 + 273.15])
    assert found.dropped == 14


@pytest.mark.parametrize("stamp", ["1_7:27:33", "17:27", "17:61:00", "17:27:nan", "x17:27:33"])
def test_a_malformed_time_of_day_is_dropped(tmp_path, stamp) -> None:
    path = tmp_path / "clock.txt"
    path.write_text(f"17:27:31 1\n{stamp} 2\n17:27:33,5 3\n")
    found = read_table(path, ["time [clock]", "current [A]"], separator="whitespace", drop=True)
    assert found.times.tolist() == [0.0, 2.5]
    assert found.dropped == 1
