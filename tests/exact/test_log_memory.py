"""Memory of reading a long log, traced by Python; and the careful and the fast reader of a long log agree."""

from __future__ import annotations

import tracemalloc
from pathlib import Path

import numpy as np
import pytest

from martensite.logs import plain_rows
from martensite.logs.reader import read_log

ROWS = 50_000
MOST = 6.0
"""Peak of the memory over the size of the file."""
HEADS = {
    "exact": ("time [s],temperature [degC],position [mm],voltage [V]", ",", "."),
    "guessed": ("Time,Temperature,Extension,Voltage\ns,°C,mm,V", ",", "."),
    "clock": ("Clock,Temp (C),Extension (mm),Voltage (V),Remark", ",", "."),
    "decimal commas": ("Zeit;Temperatur;Weg;Voltage\ns;°C;mm;V", ";", ","),
}


def write_log(path: Path, kind: str, rows: int) -> Path:
    """Write a log of four regular columns."""
    head, separator, point = HEADS[kind]
    times = 0.01 * np.arange(rows)
    columns = zip(times, 25.0 + 40.0 * np.sin(times / 7.0), 5.0 * np.cos(times / 3.0), times % 7.0, strict=True)
    lines = [separator.join(f"{x:.4f}" for x in row).replace(".", point) for row in columns]
    if kind == "clock":
        clocks = (f"{k // 360000:02d}:{k // 6000 % 60:02d}:{k % 6000 / 100.0:05.2f}" for k in range(rows))
        lines = [f"{clock},{line.partition(',')[2]}," for clock, line in zip(clocks, lines, strict=True)]
    path.write_text("\n".join([head, *lines, ""]), encoding="utf-8")
    return path


@pytest.mark.parametrize("kind", HEADS)
def test_a_long_log_takes_a_few_times_its_size(tmp_path: Path, kind: str) -> None:
    read_log(write_log(tmp_path / "short.csv", kind, 50))  # imports are no memory of the log
    path = write_log(tmp_path / "long.csv", kind, ROWS)
    tracemalloc.start()
    try:
        file = read_log(path)
        peak = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
    assert len(file.record) == ROWS and len(file.record.columns) == 4
    assert peak < MOST * path.stat().st_size


@pytest.mark.parametrize("kind", HEADS)
@pytest.mark.parametrize("odd", ["", "1234.5{0}{1}{1}{1}", "1234.5{0}25{0}7 mm{0}1", "1234.5{0}{0}7{0}1", "# remark"])
def test_both_readers_of_a_long_log_agree(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, kind: str, odd: str) -> None:
    """One odd row in the middle: more cells, a unit in a cell, an empty cell, a remark. Errors name the same row."""
    path = write_log(tmp_path / "log.csv", kind, 1_500)
    lines = path.read_text(encoding="utf-8").split("\n")
    if odd:
        lines.insert(750, odd.format(HEADS[kind][1], "5"))
        path.write_text("\n".join(lines), encoding="utf-8")
    fast = describe(path)
    monkeypatch.setattr(plain_rows, "EDGE", 10**9)
    monkeypatch.setattr("martensite.logs.exact_rows.read_plain_rows", lambda *_, **__: None)
    assert describe(path) == fast


def describe(path: Path) -> object:
    """Return all of a log that a caller sees, or its error."""
    try:
        file = read_log(path)
    except Exception as error:
        return type(error), str(error)
    columns = {name: column.tobytes() for name, column in file.record.columns.items()}
    return file.format, columns, file.columns, file.dropped, file.notes, file.record.dropped
