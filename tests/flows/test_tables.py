"""Measured tables: what is read, and where a sentence points when it is not."""

from __future__ import annotations

import math
import os
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from builders import plain_system

from martensite.base.errors import DataError, ParameterError
from martensite.logs.reader import read_table
from martensite.scenario.compare import compare_with_record
from martensite.signals.pwm import PulseWidthModulation
from martensite.signals.records import Record, table_waveform
from martensite.simulate.api import simulate

HEADLESS = ["time [s]", "temperature [degC]"]


@pytest.fixture
def write(tmp_path):
    """Write a table and return its path."""

    def to_file(text, name="log.csv", encoding="utf-8"):
        path = tmp_path / name
        path.write_bytes(text.encode(encoding))
        return path

    return to_file


def test_columns_are_read_in_si(write):
    path = write(
        "time [ms],temperature [degC],stress (MPa),strain [%],position [mm]\n0,20,100,1,2\n500,100.5,-200,4.5,0\n"
    )
    record = read_table(path)
    assert record.units == {"time": "s", "temperature": "K", "stress": "Pa", "strain": "1", "position": "m"}
    assert record.times.tolist() == [0.0, 0.5]
    assert record["temperature"] == pytest.approx([293.15, 373.65], rel=1e-15)
    assert record["stress"] == pytest.approx([1e8, -2e8], rel=1e-15)
    assert record["strain"] == pytest.approx([0.01, 0.045], rel=1e-15)
    assert record["position"] == pytest.approx([2e-3, 0.0], rel=1e-15)
    assert (record.name, record.source, record.dropped, len(record)) == ("log", path, 0, 2)
    assert record.interval is None


@pytest.mark.parametrize(
    "text",
    [
        "time [s],temperature [degC]\n0,20.5\n1,21.5\n",
        "time [s], temperature [degC]\n0, 20.5\n1, 21.5\n",
        "time [s];temperature [degC]\n0;20,5\n1;21,5\n",
        "time [s]\ttemperature [degC]\n0\t20,5\n1\t21,5\n",
        "time [s] temperature [degC]\n0  20.5\n 1 21.5\n",
        "# a comment, with commas\n\ntime [s],temperature (°C)\n0,20.5\n# another\n1,21.5\n\n",
        "time [s],temperature [degC]\r\n0,2.05e1\r\n1,+21.5\r\n",
        "\ufefftime [s],temperature [degC]\n0,20.5\n1,21.5",
        "time [s],temperature [degC],\n0,20.5,\n1,21.5,\n",
        '"time [s]","temperature [degC]"\n"0","20.5"\n"1","21.5"\n',
        "Time [s],Temperature [ degC ]\n0,20.5\n1,21.5\n",
    ],
)
def test_ways_to_write_the_same_table(write, text):
    record = read_table(write(text))
    assert record.times.tolist() == [0.0, 1.0]
    assert record["temperature"] == pytest.approx([293.65, 294.65], rel=1e-15)


def test_a_file_of_another_encoding(write):
    record = read_table(write("time [s],temperature [°C]\n0,20\n", encoding="latin-1"))
    assert record["temperature"] == pytest.approx([293.15], rel=1e-15)


def test_columns_may_be_named_from_outside(write):
    record = read_table(write("0 20 7\n1 21 8\n"), [*HEADLESS, "-"])
    assert list(record.columns) == ["time", "temperature"]
    assert record["temperature"] == pytest.approx([293.15, 294.15], rel=1e-15)


def test_names_from_outside_replace_headings(write):
    record = read_table(write("t,T\n0,20\n1,21\n"), HEADLESS)
    assert record.times.tolist() == [0.0, 1.0]
    assert record["temperature"] == pytest.approx([293.15, 294.15], rel=1e-15)


def test_a_given_separator_allows_a_decimal_comma_between_blanks(write):
    record = read_table(write("0,5 20,5\n1,5 21,5\n"), HEADLESS, separator="whitespace")
    assert record.times.tolist() == [0.5, 1.5]


def test_times_of_day_become_seconds(write):
    path = write("day clock current\n18/07/2016 17:59:59 1\n18/07/2016 18:00:01,5 2\n")
    record = read_table(path, ["-", "time [clock]", "current [A]"], separator="whitespace")
    assert record.times.tolist() == [0.0, 2.5]


def test_unknown_columns_keep_their_unit_or_have_none(write):
    record = read_table(write("time [s],fan speed [rpm],lead [mV],cycle\n0,1000,5,1\n"))
    assert record.units == {"time": "s", "fan_speed": "rad/s", "lead": "V", "cycle": "1"}
    assert record["fan_speed"] == pytest.approx([1000.0 * 2.0 * math.pi / 60.0])
    assert record["lead"] == pytest.approx([5e-3])


def test_a_drive_is_in_the_unit_of_its_source(write):
    record = read_table(write("time [s],drive [mA]\n0,500\n"))
    assert record.units["drive"] == "A"
    assert record["drive"] == pytest.approx([0.5])


def test_a_record_without_time_has_an_interval(write):
    path = write("strain [-]\n0.1\n0.2\n0.3\n")
    assert read_table(path).times.tolist() == [0.0, 1.0, 2.0]
    assert read_table(path).interval == 1.0
    assert read_table(path, interval=0.5).times.tolist() == [0.0, 0.5, 1.0]


@pytest.mark.parametrize(
    ("heading", "sentence"),
    [
        ("t [s]", "has no column `time`, but `t` seems to be one; head"),
        ("t", "has no column `time`, but `t` seems to be one; head"),
        ("time_s", r"heading `time_s` has its unit without brackets; write `time \[s\]`"),
        ("t_ms", r"heading `t_ms` has its unit without brackets; write `time \[ms\]`"),
    ],
)
def test_a_time_of_another_name_is_not_replaced_unnoticed(write, heading, sentence):
    path = write(f"{heading},strain\n0,0.1\n2,0.2\n")
    with pytest.raises(DataError, match=sentence):
        read_table(path)
    if "_" not in heading:
        assert read_table(path, interval=2.0).times.tolist() == [0.0, 2.0]


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ("", r"`log.csv` is empty: it holds no rows"),
        ("# only this\n\n", r"`log.csv` is empty"),
        ("time [s],strain\n", r"`log.csv` holds headings but no rows of numbers"),
        ("time,strain\n0,1\n", r"column `time` has no unit; write for example `time \[s\]`"),
        ("stress,strain\n0,1\n", r"`stress` has no unit; write for example `stress \[MPa\]`"),
        ("temperature [C]\n1\n", r"unit `C` cannot be .* for example `temperature \[degC\]`"),
        ("temperature [bogus]\n1\n", r"`bogus` is not a known unit.* `temperature \[degC\]`"),
        ("drive\n1\n", r"column `drive` has no unit; write for example `drive \[V\]`"),
        ("drive [Hz]\n1\n", r"The unit `Hz` is none of volt, ampere, watt and kelvin"),
        ("strain,strain\n1,2\n", r"has two columns `strain`; rename one"),
        ("strain,,x\n1,2,3\n", r"heading `` of column 2 is not a name with a unit"),
        ("1,2,3\n4,5,6\n", r"has no headings: row 1 holds numbers; name all 3 columns"),
        ("strain\n0.1\n\nabc\n", r"`log.csv`, row 4, column `strain`: `abc` is not a number"),
        ("strain;force [N]\n0,1;2\n0.1;1.234,5\n", r"row 3, column `force`: `1.234,5` is not a"),
        ("strain,x\n0.1,1\n0.2,1_000\n", r"row 3, column `x`: `1_000` is not a number"),
        ("strain,x\n0.1,1\n,2\n", r"row 3, column `strain`: the cell is empty"),
        ("strain,x\n0.1,1\n0.2,nan\n", r"row 3, column `x`: .* finite, but this is `nan`"),
        ("strain,x\n0.1,1\n0.2,-inf\n", r"row 3, column `x`: .* finite, but this is `-inf`"),
        ("strain,x\n0.1,1\n0.2,1e999\n", r"row 3, column `x`: .* finite, but this is `1e999`"),
        ("# c\nstrain,x\n0.1,1\n0.2\n", r"row 4 has 1 cells, but there are 2 columns: `strain`"),
        ("strain,x\n0.1,1,5\n", r"row 2 has 3 cells, but there are 2 columns: `strain`, `x`"),
        ("time [s],x\n0,1\n3.2,1\n3.1,1\n", r"increase.* but row 4 goes from 3.2 s to 3.1 s"),
        ("time [s],x\n0,1\n0,1\n", r"time must increase.* but row 3 goes from 0 s to 0 s"),
        ('a,b\n"1,2\n3,4\n', r"quoted cell that goes over several rows"),
    ],
)
def test_bad_tables_are_refused_with_their_place(write, text, sentence):
    with pytest.raises(DataError, match=sentence):
        read_table(write(text))


def test_too_few_names(write):
    with pytest.raises(DataError, match=r"row 1 has 3 cells, but there are 2 columns"):
        read_table(write("1 2 3\n"), HEADLESS)


def test_a_binary_file(tmp_path):
    path = tmp_path / "log.xlsx"
    path.write_bytes(b"PK\x03\x04\0\0")
    with pytest.raises(DataError, match=r"`log.xlsx` cannot be read as .xlsx"):
        read_table(path)


def test_a_missing_file_names_the_nearest(write, tmp_path):
    write("strain\n1\n", name="heating.csv")
    with pytest.raises(DataError, match=r"no file `.*heatin.csv`. Did you mean `heating.csv`\?"):
        read_table(tmp_path / "heatin.csv")
    with pytest.raises(DataError, match=r"nor one of a similar name beside it"):
        read_table(tmp_path / "zzz.dat")
    with pytest.raises(DataError, match=r"nor the folder `.*nowhere`"):
        read_table(tmp_path / "nowhere" / "log.csv")
    with pytest.raises(DataError, match=r"is a folder; name a file in it"):
        read_table(tmp_path)


def test_bad_arguments(write):
    path = write("strain\n1\n")
    with pytest.raises(ParameterError, match=r"`interval` must be above 0 s, but is 0.0 s"):
        read_table(path, interval=0.0)
    with pytest.raises(ParameterError, match=r"`separator` is `semi`. .*`semicolon`"):
        read_table(path, separator="semi")


@pytest.mark.skipif(os.name == "nt" or os.geteuid() == 0, reason="root may read every file")
def test_an_unreadable_file(write):
    path = write("strain\n1\n")
    path.chmod(0)
    with pytest.raises(DataError, match=r"cannot be read: Permission denied"):
        read_table(path)


def test_a_missing_column_names_the_nearest(write):
    record = read_table(write("time [s],temperature [K]\n0,300\n"))
    with pytest.raises(DataError, match=r"no column `temprature`. Did you mean `temperature`\?"):
        record["temprature"]


@pytest.mark.parametrize(
    ("columns", "units", "sentence"),
    [
        ({"strain": [1.0]}, {"strain": "1"}, r"needs a column `time`"),
        ({"time": [0.0], "strain": [1.0]}, {"time": "s"}, r"needs one unit for each"),
        ({"time": [0.0], "strain": []}, {"time": "s", "strain": "1"}, r"`strain` holds 0 numbers"),
        ({"time": []}, {"time": "s"}, r"holds no rows"),
    ],
)
def test_a_record_is_checked(columns, units, sentence):
    with pytest.raises(DataError, match=sentence):
        Record("made", columns, units)


def test_a_column_becomes_a_waveform(write):
    record = read_table(write("time [s],drive [V]\n0,1\n2,3\n4,3\n"))
    waveform = table_waveform(record, "drive")
    assert [waveform.value(t) for t in (0.0, 1.0, 2.0, 9.0)] == [1.0, 2.0, 3.0, 3.0]
    assert waveform.edges(4.0) == [2.0]
    with pytest.raises(DataError, match=r"has no column `voltage`"):
        table_waveform(record, "voltage")


class Run:
    """What `compare` asks of a result: x = 2t at samples 0, 1, …, 10 s."""

    def __init__(self):
        self.times = np.array([float(t) for t in range(11)])
        self.columns = {"position": 2.0 * self.times, "drive": self.times**2}

    def __getitem__(self, name):
        return self.columns[name]

    def unit(self, name):
        return {"position": "m", "drive": "V"}[name]


RUN: Any = Run()


def record_of(times, **columns):
    units = {"time": "s", "position": "m", "drive": "V", "speed": "m/s"}
    kept = {name: units[name] for name in ("time", *columns)}
    return Record("made", {"time": times, **columns}, kept)


def test_comparison_interpolates_linearly():
    record = record_of([0.0, 2.5, 10.0], position=[1.0, 2.0, 20.0], speed=[0.0, 0.0, 0.0])
    (found,) = compare_with_record(RUN, record)
    assert (found.quantity, found.unit) == ("position", "m")
    assert found.rms == pytest.approx(math.sqrt((1.0 + 9.0) / 3.0))
    assert (found.maximum, found.time, found.range) == (3.0, 2.5, 19.0)


def test_comparison_interpolates_chords_not_curves():
    record = record_of([1.5, 3.0], position=[3.0, 6.0], drive=[2.25, 9.0])
    position, drive = compare_with_record(RUN, record)
    assert (position.rms, position.maximum) == (0.0, 0.0)
    assert (drive.quantity, drive.unit) == ("drive", "V")
    assert (drive.maximum, drive.time) == (pytest.approx(0.25), 1.5)


@pytest.mark.parametrize("times", [[-0.1, 1.0], [9.0, 10.1]])
def test_comparison_extrapolates_nothing(times):
    with pytest.raises(DataError, match=r"but the run from 0 to 10 s; the run must cover"):
        compare_with_record(RUN, record_of(times, position=[0.0, 0.0]))


def test_comparison_allows_for_rounding():
    assert compare_with_record(RUN, record_of([10.0 + 1e-9], position=[20.0]))[0].maximum == 0.0


def test_comparison_needs_a_column_in_common():
    with pytest.raises(DataError, match=r"holds `speed`, the run `position`, `drive`"):
        compare_with_record(RUN, record_of([0.0], speed=[1.0]))


def test_comparison_refuses_other_units():
    record = Record("made", {"time": [0.0], "drive": [1.0]}, {"time": "s", "drive": "A"})
    with pytest.raises(DataError, match=r"`drive` of record `made` is in A, but .* run in V"):
        compare_with_record(RUN, record)


def test_a_path_may_be_text(write):
    assert read_table(str(write("strain\n1\n"))).source == Path(write("strain\n1\n"))


def test_a_run_written_as_a_table_agrees_with_itself(write):
    waveform = PulseWidthModulation(high=6.0, frequency=2.0, duty=0.3)
    run = simulate(plain_system(), waveform, 3.0, samples=31, step=0.01)
    names = ("temperature", "position", "drive")
    rows = zip(run.times.tolist(), *(run.columns[name].tolist() for name in names), strict=True)
    lines = [f"{t!r},{k - 273.15!r},{x * 1e3!r},{u!r}" for t, k, x, u in rows]
    heading = "time [s],temperature [degC],position [mm],drive [V]"
    agreements = compare_with_record(run, read_table(write("\n".join([heading, *lines]))))
    assert [a.quantity for a in agreements] == ["temperature", "position", "drive"]
    assert [a.unit for a in agreements] == ["K", "m", "V"]
    for found in agreements:
        assert found.range == pytest.approx(np.ptp(run[found.quantity]), rel=1e-9)
        assert found.range > 0.0
        assert found.maximum <= 1e-9 * found.range
