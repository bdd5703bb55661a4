"""Files as instruments write them, read without options: what must be understood of each.

Source of truth: the layouts of the makers' exports (`lab_files.toml`), with numbers put in here; for the raw files of
the published data sets the notes of their authors. Ten broken files get a sentence each.
"""

from __future__ import annotations

import math
import os
import tomllib
from pathlib import Path
from typing import Any

import pytest

from martensite.scenario.lab_files import LabFile, read_lab_file
from martensite.scenario.tables import read_table

FILES: dict[str, Any] = tomllib.loads((Path(__file__).parent / "lab_files.toml").read_text("utf-8"))


def write_clock(seconds: float, digits: int = 3) -> str:
    minutes, rest = divmod(seconds, 60.0)
    return f"{int(minutes // 60) % 24:02d}:{int(minutes % 60):02d}:{rest:0{digits + 3 if digits else 2}.{digits}f}"


def write_row(case: dict[str, Any], k: int) -> str:
    turn = min(k, 39 - k)
    values = {
        **{"k": k, "t": 0.1 * k, "T": 20.0 + 2.0 * k, "e": 4.0 - 0.1 * k, "s": 100.0 + 0.25 * k, "h": 100 * k},
        **{"c": write_clock(86_398.0 + 0.1 * k), "S": write_clock(36_000.0 + k, 0), "m": 100 * (k % 10)},
        **{"q": write_clock(36_000.0 + k // 10, 0), "w": (2**32 - 1000 + 100 * k) % 2**32, "d": 0.1 * (k - (k > 20))},
        **{"v": (65_000 + 100 * k) % 2**16, "x": 20.0 + 5.0 * turn, "y": 0.04 - 0.0018 * turn, "z": 172 + k % 3},
        **{
            "g": 0.001 + 0.002 * turn,
            "p": 1000 + 100 * (k // 20) - 1500 * (k >= 300),
            "i": 20 * (k // 20) + k % 7 * 0.3,
        },
    }
    side = [*case["side"], *[","] * 40][k] + "," if "side" in case else ""
    return side + case["row"].format(**values)


def write_case(folder: Path, name: str) -> Path:
    case = FILES[name]
    text = "\n".join(write_row(case, k) for k in range(case.get("rows", 40)))
    text = (text.replace(".", ",") if case.get("comma") else text).replace(*case.get("replace", ("\r", "")))
    head, end = (f"{case['head']}\n" if "head" in case else ""), case.get("end", "")
    path = folder / name
    path.write_bytes(f"{head}{text}\n{end}\n".encode(case.get("encoding", "utf-8")))
    return path


def check_columns(found: LabFile, ends: dict[str, tuple[float, float]]) -> None:
    for column, (first, last) in ends.items():
        values = [x for x in found.record[column] if math.isfinite(x)]
        assert values[0] == pytest.approx(first, rel=1e-5, abs=1e-9), column
        assert values[-1] == pytest.approx(last, rel=1e-5, abs=1e-9), column


@pytest.mark.parametrize("name", FILES)
def test_files_of_many_makes_are_understood(name: str, tmp_path: Path) -> None:
    case = FILES[name]
    found = read_lab_file(write_case(tmp_path, name))
    assert case.get("form", "text") in found.format
    left = case.get("left", {})
    rows = case.get("rows", 40) - left.get("the time of the row before again", 0)
    assert (len(found.record), found.has_time) == (rows, not case.get("untimed", False))
    check_columns(found, ({} if case.get("untimed") else {"time": (0.0, 3.9)}) | case["columns"])
    assert {one.reason: one.count for one in found.dropped} == left
    assert case.get("says", "") in " ".join(found.notes)


DATA = Path(os.environ.get("MARTENSITE_DATA", ""))
needs_data = pytest.mark.skipif(not os.environ.get("MARTENSITE_DATA"), reason="MARTENSITE_DATA names no folder")
RAW = {
    "flexinol_isobaric/isobaric_172MPa.txt": (("temperature", "degC"), ("strain", "1"), ("stress", "MPa")),
    "nitihf_isobaric/isobaric_7MPa.txt": (("temperature", "degC"), ("strain", "%"), ("stress", "MPa")),
    "nitihf_isobaric/isobaric_300MPa.txt": (("temperature", "degC"), ("strain", "%"), ("stress", "MPa")),
    "flexinol_electrothermal/untrained_wire_voltage_current_run5.txt": (("voltage", "mV"), ("current", "mA")),
    "flexinol_electrothermal/trained_wire_172MPa_electric.txt": (("voltage", "mV"), ("current", "mA")),
    "flexinol_electrothermal/trained_wire_172MPa_temperature.txt": (("temperature", "degC"),),
}
"""Raw file -> columns and units that its authors' notes name."""


@needs_data
@pytest.mark.parametrize("name", RAW)
def test_raw_files_are_read_as_their_notes_say(name: str) -> None:
    found = read_lab_file(DATA / name)
    assert [(one.name, one.unit) for one in found.columns if one.name not in ("-", "time")] == list(RAW[name])
    listed = read_table(f"data:{name.replace('_', '-', 1)}")
    assert len(found.record) in (len(listed), len(listed) + 1)
    for own, other in zip(found.record.columns.items(), listed.columns.items(), strict=True):
        assert own[1][:200] == pytest.approx(other[1][:200])
