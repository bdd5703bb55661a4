"""Files as instruments write them, read without options: what must be understood of each.

Source of truth: the layouts of the makers' exports (`lab_files.toml`), with numbers put in here; for the raw files of
the published data sets the notes of their authors. Ten broken files get a sentence each.
"""

from __future__ import annotations

import json
import math
import os
import sys
from pathlib import Path

import h5py
import numpy as np
import pytest
from lab_cases import FILES, write_case
from scipy.io import savemat

from martensite.base.errors import DataError, InputError
from martensite.logs.datasets import describe_dataset
from martensite.logs.lab_files import LabFile, read_lab_file
from martensite.logs.merged_files import merge_by_clock
from martensite.logs.reader import read_log, read_one, read_parts, read_table


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
    for known in (True, False):  # as fits, runs, laws and identification read it
        again = read_log(tmp_path / name, known=known)
        assert again.record.times == pytest.approx(found.record.times), known
        if known or not again.exact:
            assert again.record.units == found.record.units
            for column, numbers in found.record.columns.items():
                np.testing.assert_allclose(again.record[column], numbers, rtol=1e-12, err_msg=column)


DATA = Path(os.environ.get("MARTENSITE_DATA", ""))
RAW = {
    "flexinol_isobaric/isobaric_172MPa.txt": (("temperature", "degC"), ("strain", "1"), ("stress", "MPa")),
    "nitihf_isobaric/isobaric_7MPa.txt": (("temperature", "degC"), ("strain", "%"), ("stress", "MPa")),
    "nitihf_isobaric/isobaric_300MPa.txt": (("temperature", "degC"), ("strain", "%"), ("stress", "MPa")),
    "flexinol_electrothermal/untrained_wire_voltage_current_run5.txt": (("voltage", "mV"), ("current", "mA")),
    "flexinol_electrothermal/trained_wire_172MPa_electric.txt": (("voltage", "mV"), ("current", "mA")),
    "flexinol_electrothermal/trained_wire_172MPa_temperature.txt": (("temperature", "degC"),),
}
"""Raw file -> columns and units that its authors' notes name."""


@pytest.mark.parametrize("name", RAW)
def test_raw_files_are_read_as_their_notes_say(name: str) -> None:
    folder, _, file = name.partition("/")
    packed = describe_dataset(folder.replace("_", "-")).packaged
    path = DATA / name if packed is None else packed / f"{file}.gz"
    if not path.is_file():
        pytest.skip("MARTENSITE_DATA names no folder with the record")
    found = read_lab_file(path)
    assert [(one.name, one.unit) for one in found.columns if one.name not in ("-", "time")] == list(RAW[name])
    listed = read_table(f"data:{name.replace('_', '-', 1)}")
    assert len(found.record) in (len(listed), len(listed) + 1)
    for own, other in zip(found.record.columns.items(), listed.columns.items(), strict=True):
        assert own[1][:200] == pytest.approx(other[1][:200])


def write_workbook(path: Path) -> None:
    book = pytest.importorskip("openpyxl").Workbook()
    book.active.append(["Notes", "nothing here"])
    sheet = book.create_sheet("Test 1")
    for row in (["Wire 3"], [], ["Time", "Temp", "Strain"], ["s", "°C", "%"]):
        sheet.append(row)
    for k in range(40):
        sheet.append([0.1 * k, 20.0 + 2.0 * k, 4.0 - 0.1 * k])
    book.save(path)


def write_tdms(path: Path) -> None:
    tdms = pytest.importorskip("nptdms")
    made = {"Temp": (20.0 + 2.0 * np.arange(40), "degC"), "Strain": (4.0 - 0.1 * np.arange(40), "%")}
    with tdms.TdmsWriter(path) as file:
        file.write_segment(
            [
                tdms.ChannelObject(
                    "run", name, values, {"unit_string": unit, "wf_increment": 0.1, "wf_start_offset": 0.0}
                )
                for name, (values, unit) in made.items()
            ]
        )


def write_mcap(path: Path) -> None:
    writer_of = pytest.importorskip("mcap.writer").Writer
    with path.open("wb") as file:
        writer = writer_of(file)
        writer.start()
        schema = writer.register_schema("wire", "jsonschema", b"{}")
        channel = writer.register_channel("/wire", "json", schema)
        for k in range(40):
            text = json.dumps({"temp [degC]": 20.0 + 2.0 * k, "strain [%]": 4.0 - 0.1 * k})
            writer.add_message(channel, k * 100_000_000, text.encode(), k * 100_000_000)
        writer.finish()


def write_struct(path: Path) -> None:
    signals = [{"label": f"{name}", "values": values} for name, values in RAMPS.items()]
    savemat(path, {"out": {"time": 0.1 * np.arange(40), "signals": signals, "blockName": "wire/Scope"}})


def write_to_file_block(path: Path) -> None:
    savemat(path, {"strain": np.vstack([0.1 * np.arange(40), 4.0 - 0.1 * np.arange(40)])})


RAMPS = {"Temp (C)": 20.0 + 2.0 * np.arange(40), "Strain (%)": 4.0 - 0.1 * np.arange(40)}
KINDS = {"a.xlsx": write_workbook, "a.tdms": write_tdms, "a.mcap": write_mcap, "a.mat": write_struct}


@pytest.mark.parametrize("name", KINDS)
def test_files_that_are_no_text_are_understood(name: str, tmp_path: Path) -> None:
    KINDS[name](tmp_path / name)
    found = read_lab_file(tmp_path / name)
    assert len(found.record) == 40
    check_columns(found, {"time": (0.0, 3.9), "temperature": (293.15, 371.15), "strain": (0.04, 0.001)})
    if name == "a.xlsx":
        assert found.format == "spreadsheet, sheet `Test 1`, 4 heading lines"


def test_the_block_to_file_of_simulink_is_understood(tmp_path: Path) -> None:
    write_to_file_block(tmp_path / "b.mat")
    found = read_lab_file(tmp_path / "b.mat")
    check_columns(found, {"time": (0.0, 3.9), "strain": (0.04, 0.001)})
    assert "taken for strain in % by its values" in " ".join(found.notes) or found.columns[1].unit == "%"


def test_a_missing_package_is_a_sentence_that_names_the_extra(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "a.tdms").write_bytes(b"TDSm")
    monkeypatch.setitem(sys.modules, "nptdms", None)
    with pytest.raises(InputError, match=r"needs npTDMS.*\[tdms\]"):
        read_lab_file(tmp_path / "a.tdms")


ROWS = "".join(f"{k},{20 + k}\n" for k in range(20))
STATISTICS = "min,max\n" + 6 * f"{','.join('1' * 12)}\n" + "".join(f"{k}{',5' * (1 + k % 8)}\n" for k in range(40))
BROKEN: dict[str, tuple[str | bytes, str]] = {
    "empty.csv": ("", "is empty"),
    "junk.csv": (bytes(range(256)) * 20, "is not a text file"),
    "headings.csv": ("time [s],T [degC]\n", "has no numeric row"),
    "ragged.csv": ("time [s],T [degC]\n" + "".join(f"{k}" + ",x" * (k % 7) + "\n" for k in range(30)), "is ragged: of"),
    "words.txt": ("Lorem ipsum dolor\nsit amet, consectetur\n", "has no numeric row"),
    "cut.xlsx": (b"PK\x03\x04" + bytes(range(200)), "cannot be read as .xlsx"),
    "image.png": (b"\x89PNG\r\n\x1a\n" + bytes(range(32)) * 10, "is not a text file"),
    "back.csv": (f"time [s],T [degC]\n{ROWS}5,22\n6,23\n", "time runs backwards at row 22"),
    "one.csv": ("".join(f"{math.sin(k):.4f}\n" for k in range(30)), r"neither headings nor values.*--as 1="),
    "gaps.csv": ("time [s],T [degC]\n" + "0,NaN\n1,NaN\n2,\n", "holds no numbers but its times"),
    "two.csv": (
        "".join(f"{math.sin(k):.4f};{math.cos(3 * k):.4f}\n" for k in range(30)),
        r"neither headings nor values.*--as 1=",
    ),
    "gone.csv": ("a\n", "no file"),
    "statistics.csv": (STATISTICS, "has 46 rows with several numbers, but only 6 of them, rows 2 to 7"),
}


@pytest.mark.parametrize("name", BROKEN)
def test_broken_files_get_a_sentence(name: str, tmp_path: Path) -> None:
    content, words = BROKEN[name]
    path = tmp_path / name
    if name != "gone.csv":
        path.write_bytes(content if isinstance(content, bytes) else content.encode())
    with pytest.raises(DataError, match=words):
        read_lab_file(path)


def test_what_is_given_goes_over_what_is_guessed(tmp_path: Path) -> None:
    path = tmp_path / "a.csv"
    path.write_text("t,Sensor,Bath\n" + "".join(f"{k},{100 + k},{k % 3}\n" for k in range(20)))
    found = read_lab_file(path, {"Sensor": "stress[MPa]", "3": "-", "1": "time[ms]"})
    assert list(found.record.columns) == ["time", "stress"]
    assert [one.source for one in found.columns[:2]] == ["given", "given"]
    check_columns(found, {"time": (0.0, 0.019), "stress": (1e8, 1.19e8)})
    with pytest.raises(DataError, match=r"has no column `Sens`.*Did you mean `Sensor`"):
        read_lab_file(path, {"Sens": "stress[MPa]"})
    with pytest.raises(DataError, match="cannot be converted"):
        read_lab_file(path, {"2": "stress[kg]"})


def test_a_column_takes_a_factor_and_an_offset(tmp_path: Path) -> None:
    path = tmp_path / "adc.csv"
    path.write_text("time [s],adc\n" + "".join(f"{k},{1000 + k}\n" for k in range(20)))
    found = read_log(path, {"adc": "force[mN]*0.5-300"})
    check_columns(found, {"force": (0.2, 0.2095)})
    assert [one.certainty for one in found.columns] == ["given", "given"]


@pytest.mark.parametrize(
    ("heading", "certainty"),
    [("temp [degC]", "given"), ("T", "inferred"), ("Fan (degC)", "inferred"), ("weg", "ambiguous")],
)
def test_certainty_of_a_meaning_is_marked(heading: str, certainty: str, tmp_path: Path) -> None:
    path = tmp_path / "log.csv"
    path.write_text(f"t [s],{heading}\n" + "".join(f"{k},{20 + k / 7:.3f}\n" for k in range(20)))
    assert read_lab_file(path).columns[1].certainty == certainty


def test_all_tables_of_a_file_are_read(tmp_path: Path) -> None:
    """Sheets of a workbook, and tables side by side; a single reader names the sheets that it leaves out."""
    book = pytest.importorskip("openpyxl").Workbook()
    for title, factor in (("75 MPa", 1.0), ("125 MPa", 2.0)):
        sheet = book.create_sheet(title)
        sheet.append(["T (°C)", "Strain (%)"])
        for k in range(40):
            sheet.append([20.0 + k, factor * k / 10.0])
    book.save(tmp_path / "book.xlsx")
    sheets = read_parts(tmp_path / "book.xlsx")
    assert [one.record["strain"][-1] for one in sheets] == pytest.approx([0.039, 0.078])
    assert [one.record.name for one in sheets] == ["book 75 MPa", "book 125 MPa"]
    assert "`book.xlsx:125 MPa`" in " ".join(read_log(tmp_path / "book.xlsx").notes)
    assert read_log(f"{tmp_path}/book.xlsx:125 MPa").record["strain"][-1] == pytest.approx(0.078)
    with pytest.raises(DataError, match="has no sheet `99 MPa`"):
        read_log(f"{tmp_path}/book.xlsx:99 MPa")
    pairs = read_parts(write_case(tmp_path, "side_by_side.csv"))
    assert [(one.record.name, one.record["stress"][0]) for one in pairs] == [
        ("side_by_side 30 C", pytest.approx(1e8)),
        ("side_by_side 50 C", pytest.approx(20e6)),
    ]
    assert read_one(f"{tmp_path}/side_by_side.csv:50 C").record["stress"][0] == pytest.approx(20e6)
    with pytest.raises(DataError, match=r"2 tables side by side, `30 C`, `50 C`: write for example `side_by_side.csv:"):
        read_one(tmp_path / "side_by_side.csv")
    with pytest.raises(DataError, match=r"has no table `60 C`. Did you mean `50 C`|has no table `60 C`"):
        read_one(f"{tmp_path}/side_by_side.csv:60 C")


def test_arrays_of_hdf5_and_of_unlabelled_signals_are_read(tmp_path: Path) -> None:
    with h5py.File(tmp_path / "a.h5", "w") as file:
        file["time"], file["strain"] = 0.1 * np.arange(40), 0.04 - 0.001 * np.arange(40)
        file["strain"].attrs["units"] = "%"
    check_columns(read_log(tmp_path / "a.h5"), {"time": (0.0, 3.9), "strain": (4e-4, 1e-5)})
    signals = {"values": np.arange(40.0), "label": np.array([])}
    savemat(tmp_path / "a.mat", {"out": {"time": 0.1 * np.arange(40), "signals": signals}})
    check_columns(read_log(tmp_path / "a.mat"), {"time": (0.0, 3.9), "out1": (0.0, 39.0)})


def test_the_understood_table_is_read_by_the_strict_reader(tmp_path: Path) -> None:
    found = read_lab_file(write_case(tmp_path, "testxpert.TRA"))
    found.save(tmp_path / "out.csv")
    again = read_table(tmp_path / "out.csv")
    assert again.units == found.record.units
    for name, column in found.record.columns.items():
        assert again[name] == pytest.approx(column, rel=1e-9)


@pytest.mark.parametrize("clocked", [True, False])
def test_files_of_one_experiment_are_joined_by_clock(clocked: bool, tmp_path: Path) -> None:
    """The second logger is started 3 s later; without its clock the offset follows from what both measure."""
    times = np.arange(0.0, 60.0, 0.1)
    heat = 40.0 + 20.0 * np.sin(times / 7.0) + 10.0 * np.sin(times / 2.3)
    rows = [f"2026-01-02 10:00:{0.1 * k // 1:02.0f}.{k % 10},{heat[k]:.4f}\n" for k in range(600)]
    (tmp_path / "camera.csv").write_text("clock,T [degC]\n" + "".join(rows))
    later = list(range(30, 600, 3))
    stamps = [f"10:00:{0.1 * k // 1:02.0f}.{k % 10}" if clocked else f"{0.1 * (k - 30):.1f}" for k in later]
    text = "".join(f"{stamp},{heat[k]:.4f},{0.01 * k:.3f}\n" for stamp, k in zip(stamps, later, strict=True))
    (tmp_path / "logger.csv").write_text(f"{'clock' if clocked else 'time [s]'},T [degC],I [A]\n{text}")
    merged = merge_by_clock([read_lab_file(tmp_path / "camera.csv"), read_lab_file(tmp_path / "logger.csv")])
    current = merged.record["current"]
    assert math.isnan(current[0])
    assert current[300] == pytest.approx(3.0, abs=2e-3)
    words = "times of day" if clocked else "estimated: `temperature` and `temperature` go together"
    assert words in " ".join(merged.notes)


def test_clocks_that_cannot_be_compared_are_said(tmp_path: Path) -> None:
    rng = np.random.default_rng(1)
    files: list[LabFile] = []
    for name in ("a.csv", "b.csv"):
        rows = "".join(f"{k},{x:.4f}\n" for k, x in enumerate(rng.normal(50.0, 5.0, 300)))
        (tmp_path / name).write_text(f"time [s],T [degC]\n{rows}")
        files.append(read_lab_file(tmp_path / name))
    with pytest.raises(DataError, match="is unknown: one has no absolute time"):
        merge_by_clock(files)
    assert "as given" in " ".join(merge_by_clock(files, [2.0]).notes)
