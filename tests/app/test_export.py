"""Files that the bench makes of a run."""

import csv
import io
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr
from app_server import Bench
from typer.testing import CliRunner

from martensite.cli.app import app
from martensite.logs.reader import read_table
from martensite.logs.record_text import format_heading
from martensite.scenario.csv_files import write_csv
from martensite.scenario.netcdf import read_labelled
from martensite.scenario.scenario import load

FLOATS = "--runtime", "floats"
OWN = ("created", "runtime", "accuracy", "step", "ripple", "heat", "work", "martensite_result")
"""What two runtimes do not share to the last digit, or begins so."""

EXAMPLE = Path(__file__).parents[2] / "examples/constant_power.toml"
TEXT = EXAMPLE.read_text("utf-8")


def made(bench: Bench, what: str, text: str = TEXT) -> tuple[str, bytes]:
    """Name and content of what is exported."""
    found = bench.call("export", {"text": text, "what": what})
    assert "error" not in found, found
    with bench.client() as client:
        return found["name"], client.get(f"/api/files/{found['key']}").content


@pytest.mark.parametrize(("what", "begin"), [("png", b"\x89PNG"), ("svg", b"<?xml")])
def test_figures(bench: Bench, what: str, begin: bytes) -> None:
    name, content = made(bench, what)
    assert name == f"Constant power by PWM_ 0.1 mm wire.{what}"
    assert content.startswith(begin)
    assert len(content) > 20_000


def test_the_netcdf_is_that_of_the_command_line(bench: Bench, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    _, content = made(bench, "nc")
    (tmp_path / "bench.nc").write_bytes(content)
    done = CliRunner().invoke(app, ["run", str(EXAMPLE), "--out", str(tmp_path / "cli.nc"), "--no-figure", *FLOATS])
    assert done.exit_code == 0, done.output
    one, other = (read_labelled(tmp_path / name).to_xarray() for name in ("bench.nc", "cli.nc"))
    kept = {name for name in one.variables if str(name).startswith("restart_state")}  # with what the passes differ by
    xr.testing.assert_allclose(one.drop_vars(kept), other.drop_vars(kept), rtol=1e-9)  # the page may compute in C
    kept = {k: v for k, v in one.attrs.items() if not k.startswith(OWN)}
    assert kept == {k: v for k, v in other.attrs.items() if not k.startswith(OWN)}
    assert one["temperature"].attrs == other["temperature"].attrs


def test_another_run_is_another_file(bench: Bench, tmp_path: Path) -> None:
    """The comparison can fail."""
    (tmp_path / "a.nc").write_bytes(made(bench, "nc")[1])
    (tmp_path / "b.nc").write_bytes(made(bench, "nc", TEXT.replace("0.45 W", "0.4 W"))[1])
    one, other = (read_labelled(tmp_path / name).to_xarray() for name in ("a.nc", "b.nc"))
    assert not one.equals(other)


def test_the_csv_holds_all_digits(bench: Bench) -> None:
    _, content = made(bench, "csv")
    rows = list(csv.reader(io.StringIO(content.decode("utf-8"))))
    result = load(EXAMPLE).run(runtime="floats")
    assert rows[0][:3] == ["time [s]", "drive [W]", "temperature [K]"]
    assert len(rows) == len(result.times) + 1
    place = rows[0].index("stress [Pa]")
    found = [float(row[place]) for row in rows[1:]]
    assert found == pytest.approx(result["stress"], rel=1e-9)  # the page may compute in C


def test_the_csv_can_be_read_again(tmp_path: Path) -> None:
    result = load(EXAMPLE).run()
    write_csv(result, tmp_path / "run.csv")
    record = read_table(tmp_path / "run.csv")
    assert np.array_equal(record.columns["temperature"], result["temperature"])


@pytest.mark.parametrize("name", ["=1+1", "+a", "-a", "@a", "\ta"])
def test_no_heading_is_a_formula(name: str) -> None:
    assert format_heading(name, "K") == f"'{name} [K]"


def test_other_headings_stay() -> None:
    assert format_heading("temperature", "K") == "temperature [K]"


@pytest.mark.parametrize("what", ["exe", "../x", ""])
def test_other_kinds_are_refused(bench: Bench, what: str) -> None:
    found: Any = bench.call("export", {"text": TEXT, "what": what})
    assert found["kind"] == "input"
    assert "No file named" in found["error"]


def test_a_title_is_no_path(bench: Bench) -> None:
    found = bench.call("export", {"text": TEXT, "changes": {"title": "../../=cmd|' /C calc'!A0"}, "what": "csv"})
    assert "error" not in found, found
    assert "/" not in found["name"]
    assert not found["name"].startswith(("=", "."))
