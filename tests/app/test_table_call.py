"""Uploaded tables: what is in them, what their columns may mean, and what is refused."""

import gzip
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from app_server import Bench
from typescript import check_answer

from martensite.app.calls.logs import describe_records as records
from martensite.app.calls.logs import describe_table as table
from martensite.app.calls.logs import place_sample
from martensite.app.uploads import UploadFolder
from martensite.app.worker import Desk
from martensite.base.errors import InputError
from martensite.logs.datasets import describe_dataset

LOG = "Time_s;T (C);F/N;remark\n0;20,5;1;=cmd()\n1;;2;\n2;21,5;3;+1+1\n"
BAD = {
    "binary": ("a.csv", bytes(range(256)) * 20, "not a text file"),
    "empty": ("a.csv", b"", "is empty"),
    "comments": ("a.csv", b"# nothing\n\n", "has no numeric row"),
    "headings": ("a.csv", b"t [s],T [C]\n", "has no numeric row"),
    "ragged": ("a.csv", b"t,T\n" + b"".join(b"1" + b",x" * (k % 7) + b"\n" for k in range(30)), "is ragged"),
    "wide": ("a.csv", b"a," * 500 + b"a\n" + b"1," * 500 + b"1\n", "501 columns; at most 200"),
    "workbook": ("a.xlsx", b"PK\x03\x04" + bytes(60), "cannot be read as .xlsx"),
    "no mat": ("a.mat", b"\0\1\2\3" * 99, "cannot be read as"),
    "empty mat": ("a.mat", b"", "cannot be read as"),
    "no netcdf": ("a.nc", b"what", "cannot be read as .nc"),
}


@pytest.fixture
def desk(tmp_path: Path) -> Desk:
    return Desk(tmp_path)


def put(desk: Desk, data: bytes | str, name: str = "log.csv") -> str:
    key, path = UploadFolder(desk.folder).place(name)
    path.write_bytes(data if isinstance(data, bytes) else data.encode())
    return key


def columns(*named: tuple[int, str, str]) -> list[dict[str, Any]]:
    return [{"at": at, "name": name, "unit": unit} for at, name, unit in named]


def test_a_reader_without_a_log_takes_the_measured_one(desk: Desk) -> None:
    """Temperature, strain and stress of a loop without headings, known by their values; it can be fitted."""
    given = place_sample({}, desk)
    found = table({"key": given["key"]}, desk)
    assert (given["name"], found["rows"]) == ("isobaric_172MPa.txt", 499)
    assert [(one["name"], one["unit"]) for one in found["columns"]] == [
        ("temperature", "degC"),
        ("strain", "1"),
        ("stress", "MPa"),
    ]
    named = [{"at": at, "name": one["name"], "unit": one["unit"]} for at, one in enumerate(found["columns"])]
    assert records({"key": given["key"], "columns": named, "interval": 1.0, "cuts": []}, desk)["rows"] == 499


def test_columns_are_guessed_and_counted(desk: Desk) -> None:
    found = table({"key": put(desk, LOG)}, desk)
    check_answer(found, "identify", "TableView")
    assert (found["rows"], found["separator"]) == (3, "semicolon")
    guessed = [(one["name"], one["unit"]) for one in found["columns"]]
    assert guessed == [("time", "s"), ("temperature", "degC"), ("force", "N"), ("", "")]
    warm = found["columns"][1]
    assert (warm["min"], warm["max"], warm["missing"], warm["wrong"]) == (20.5, 21.5, 1, 0)
    assert set(found["names"]["temperature"]) == {"degC", "degF", "K"}


def test_formulas_are_text_and_no_numbers(desk: Desk) -> None:
    found = table({"key": put(desk, LOG)}, desk)
    assert [row[3] for row in found["preview"]] == ["=cmd()", "", "+1+1"]
    remark = found["columns"][3]
    assert (remark["wrong"], remark["first_wrong"], remark["min"]) == (2, "row 2: =cmd()", None)
    mapped = columns((0, "time", "s"), (3, "force", "N"))
    with pytest.raises(InputError, match=r"row 2, column `force`: `=cmd\(\)` is not a number"):
        records({"key": put(desk, LOG), "columns": mapped}, desk)


@pytest.mark.parametrize("case", BAD)
def test_bad_files_are_refused_with_a_sentence(desk: Desk, case: str) -> None:
    name, data, words = BAD[case]
    with pytest.raises(InputError, match=words) as caught:
        table({"key": put(desk, data, name)}, desk)
    assert str(desk.folder) not in str(caught.value)


def test_doubtful_files_come_with_notes(desk: Desk) -> None:
    alone = table({"key": put(desk, "strain [%]\n1\n2\n")}, desk)
    assert any("has one column" in note for note in alone["notes"])
    assert "its rows count as 1 s apart, unless you say otherwise" in alone["said"]
    ragged = table({"key": put(desk, "t [s],T [C]\n1,2\n3\n4,5,6\n7,8\n")}, desk)["said"]
    assert "left out: 2 rows (more or fewer cells" in ragged and ": 3, 4)" in ragged
    infinite = table({"key": put(desk, "t [s],T [C]\n1,inf\n2,nan\n3,4\n")}, desk)["columns"][1]
    assert (infinite["wrong"], infinite["missing"], infinite["max"]) == (0, 2, 4.0)
    assert not table({"key": put(desk, "t [s],T [C]\n1,2\n3,4\n")}, desk)["notes"]


def test_other_encodings_and_files_without_headings(desk: Desk) -> None:
    latin = table({"key": put(desk, "t [s],T [°C]\n1,2\n".encode("latin-1"))}, desk)
    assert latin["columns"][1]["unit"] == "degC"
    plain = table({"key": put(desk, "0,20\n1,21\n")}, desk)
    assert (plain["headed"], plain["rows"]) == (False, 2)


def test_mat_files_are_read(desk: Desk) -> None:
    scipy_io = pytest.importorskip("scipy.io")
    key, path = UploadFolder(desk.folder).place("log.mat")
    rows = {"t": np.arange(12.0), "T_degC": 20.0 + np.arange(12.0), "other": np.eye(3)}
    scipy_io.savemat(path, rows)
    found = table({"key": key}, desk)
    assert sorted(one["name"] for one in found["columns"]) == ["temperature", "time"]
    at = [{"at": k, **{n: one[n] for n in ("name", "unit")}} for k, one in enumerate(found["columns"])]
    for one in at:
        one["unit"] = one["unit"] or "s"
    record = records({"key": key, "columns": at}, desk)
    assert record["columns"][0]["values"][0] == 293.15
    assert (record["begin"], record["end"]) == (0.0, 11.0)


def test_units_are_checked_when_columns_are_mapped(desk: Desk) -> None:
    key = put(desk, LOG)
    for unit, words in (("", "has no unit"), ("bar", "cannot be converted"), ("x]y", "not a name with a unit")):
        with pytest.raises(InputError, match=words):
            records({"key": key, "columns": columns((0, "time", "s"), (2, "force", unit))}, desk)
    with pytest.raises(InputError, match="two columns `force`"):
        records({"key": key, "columns": columns((1, "force", "N"), (2, "force", "N"))}, desk)
    with pytest.raises(InputError, match="no column 9; the file has 4"):
        records({"key": key, "columns": columns((8, "force", "N"))}, desk)


def test_a_serial_monitor_with_labels_is_understood(desk: Desk) -> None:
    """Every labelled number is a column under its name, and the monitor's clock is the time."""
    rows = [(13.456 + 0.1 * k, 22.0 + k, 0.01 * k, 0.3) for k in range(30)]
    lines = [f"10:12:{t:06.3f} -> temp={heat:.2f} pos={x:.3f} I=-{i:.3f}" for t, heat, x, i in rows]
    key = put(desk, "\n".join(["Boot v1.3 SMA rig", *lines]), "monitor.txt")
    found = table({"key": key}, desk)
    assert [(one["heading"], one["name"], one["wrong"]) for one in found["columns"]] == [
        ("time", "time", 0),
        ("temp", "temperature", 0),
        ("pos", "position", 0),
        ("I", "current", 0),
    ]
    named = [{"at": at, "name": one["name"], "unit": one["unit"]} for at, one in enumerate(found["columns"])]
    read = records({"key": key, "columns": named}, desk)
    assert read["end"] - read["begin"] == pytest.approx(2.9)


def test_a_column_takes_a_factor(desk: Desk) -> None:
    """A sensor of 2 mm per volt: a reading of 1.5 V is 3 mm."""
    lines = "".join(f"{k},{0.5 * k}\n" for k in range(10))
    key = put(desk, f"Time (s),CH2 (V)\n{lines}")
    named = columns((0, "time", "s"), (1, "position", "mm"))
    named[1]["factor"] = 2.0
    (position,) = records({"key": key, "columns": named}, desk)["columns"]
    assert position["values"][3] == pytest.approx(3e-3)
    named[1]["factor"] = 0.0
    with pytest.raises(InputError, match="The factor of `position` is 0"):
        records({"key": key, "columns": named}, desk)


def test_rows_that_cannot_be_read_are_left_out_if_asked(desk: Desk) -> None:
    rows = "".join(f"{k},{20 + k}\n" for k in range(10))
    request = {
        "key": put(desk, f"t [s],T [C]\n{rows}oops\n10,30\n"),
        "columns": columns((0, "time", "s"), (1, "temperature", "degC")),
    }
    found = records(request, desk)
    assert (found["rows"], found["end"], found["dropped"]) == (11, 10.0, 1)


def test_a_loop_without_headings_and_times_is_understood(desk: Desk) -> None:
    """A record of the package as its authors wrote it: nothing has to be said of it."""
    packed = describe_dataset("flexinol-isobaric").packaged
    assert packed is not None
    key = put(desk, gzip.decompress((packed / "isobaric_172MPa.txt.gz").read_bytes()), "isobaric_172MPa.txt")
    found = table({"key": key}, desk)
    meant = [{"at": at, "name": one["name"], "unit": one["unit"]} for at, one in enumerate(found["columns"])]
    assert [(one["name"], one["unit"]) for one in meant] == [
        ("temperature", "degC"),
        ("strain", "1"),
        ("stress", "MPa"),
    ]
    assert "It has no times, and needs none" in found["said"] and found["notes"] == []
    record = records({"key": key, "columns": meant}, desk)
    assert (record["rows"], record["end"]) == (499, 498.0)


def test_the_clock_of_an_infrared_camera_is_its_relative_time(desk: Desk) -> None:
    rows = "".join(f"12/07/2016\t19:36:{38 + k}\t{100 * k:03d}\t{k},1\t{25 + k},5\n" for k in range(9))
    head = "Plot 1\n\nEmissivity\t\t\t\t0,95\n\nDate\tTime\tMilliseconds\tRelative time\tBx1.Max.\n"
    key = put(desk, (head + rows).encode("utf-16"), "camera.txt")
    found = table({"key": key}, desk)
    named = [(one["name"], one["unit"]) for one in found["columns"]]
    assert named == [("", ""), ("", ""), ("", ""), ("time", "s"), ("temperature", "degC")]


def test_long_columns_keep_their_lows_and_highs(desk: Desk) -> None:
    rows = [f"{k},{1000.0 if k == 4567 else 0.0}" for k in range(20_000)]
    key = put(desk, "\n".join(["t [s],F [N]", *rows]))
    found = records({"key": key, "columns": columns((0, "time", "s"), (1, "force", "N"))}, desk)
    (force,) = found["columns"]
    assert len(force["times"]) <= 900
    assert max(force["values"]) == 1000.0


def test_over_http(bench: Bench) -> None:
    with bench.client() as client:
        made = client.post("/api/files?name=../../etc/pass%00wd.csv", content=LOG).json()
        assert made["name"] == "pass_wd.csv"
        binary = client.post("/api/files?name=log.csv", content=bytes(range(256))).json()
    found = bench.call("table", {"key": made["key"]})
    assert found["preview"][0][3] == "=cmd()"
    refused = bench.call("table", {"key": binary["key"]})
    assert (refused["kind"], "text file" in refused["error"]) == ("input", True)
    assert "upload it again" in bench.call("table", {"key": "../../../etc/passwd"})["error"]
    assert not list(bench.folder.glob("*.csv"))


def test_a_time_that_begins_again_and_units_that_disagree_are_told(desk: Desk) -> None:
    """As `data show` reads the file: a time in blocks is no time, and a heading is not overruled by a row of units."""
    rows = "".join(f"{1e-5 * (k % 2):.6f}\t{k}\n" for k in range(12))
    found = table({"key": put(desk, f"X_Value\tTemp (C)\n\tdeg\n{rows}", "log.lvm")}, desk)
    assert [(one["name"], one["unit"]) for one in found["columns"]] == [("", ""), ("temperature", "degC")]
    notes = " ".join(found["notes"])
    assert "begins again at its first value in 6 blocks" in notes and "Column 2: heading and row of units" in notes
