"""Logs of instruments on the page: understood without hand work, put right in words, merged, fitted, and judged."""

import math
import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from typescript import check_answer

from martensite.app.calls.fits import run_fit, write_fit_file
from martensite.app.calls.logs import describe_records, describe_table, overlay_logs, place_sample, propose_fit
from martensite.app.identify.mapped_table import read_record
from martensite.app.uploads import UploadFolder
from martensite.app.worker import Desk
from martensite.base.errors import InputError

LOOP = [(30.0 + 2.0 * (k if k < 50 else 100 - k), k) for k in range(101)]


def _strain(celsius: float, row: int) -> float:
    return 0.022 * (1.0 - math.tanh((celsius - (95.0 if row < 50 else 75.0)) / 6.0))


def _write_loop(share: float, separator: str) -> str:
    cells = [(t, share * _strain(t, k), 100.0 + 0.2 * (k % 5)) for t, k in LOOP]
    return "".join(f"{t:.6f}{separator}{e:.8f}{separator}{s:.4f}\n" for t, e, s in cells)


def _write_supply(stamp: bool) -> str:
    """Volts on steps that the counter loses once, milliamperes, remarks of the logger."""
    rows = ["2016-07-18 18:54:00\tCalibrating" if stamp else "Cal1000.00  6.54 "]
    for k in range(300):
        volts = 1000.0 + 100.0 * (k // 12) - (1500.0 if stamp and k >= 180 else 0.0)
        ampere = (1000.0 + 100.0 * (k // 12)) / 1.5 + 3.1 * (7 * k % 12)
        clock = f"2016-07-18 18:{54 + (k + 1) // 60}:{(k + 1) % 60:02d}\t" if stamp else ""
        rows.append(f"{clock}{volts:.2f}  {ampere:.2f} ")
    rows.insert(2, "2016-07-18 18:54:02\tCalibrating" if stamp else "Calibrating")
    return "\n".join(rows) + "\n"


def _write_camera() -> str:
    head = [
        "Plot 1 FLIR A320",
        "",
        "\t\t\t\tBx1.Max.",
        "Emissivity\t\t\t\t0.95",
        *(f"{name}\t\t\t\t20" for name in "abcdefg"),
        "",
    ]
    head.append("Date\tTime\tMilliseconds\tRelative time\tBx1.Max.")
    rows = [
        f"18/07/2016\t18:{54 + k // 120}:{k // 2 % 60:02d}\t{500 * (k % 2):03d}\t{k / 2:g}\t{25 + 0.1 * k:.6f}".replace(
            ".", ","
        )
        for k in range(600)
    ]
    return "\n".join(head) + "\n" + "\n".join(rows).replace("Bx1,Max,", "Bx1.Max.") + "\n"


FILES: dict[str, tuple[Callable[[], str], list[tuple[str, str]], str]] = {
    "loop of numbers": (
        lambda: _write_loop(1.0, " "),
        [("temperature", "degC"), ("strain", "1"), ("stress", "MPa")],
        "needs none: a slow loop",
    ),
    "loop in percent": (
        lambda: _write_loop(100.0, "\t"),
        [("temperature", "degC"), ("strain", "%"), ("stress", "MPa")],
        "needs none: a slow loop",
    ),
    "supply with a clock": (
        lambda: _write_supply(True),
        [("time", "clock"), ("voltage", "mV"), ("current", "mA")],
        "Taken as resistance",
    ),
    "supply": (lambda: _write_supply(False), [("voltage", "mV"), ("current", "mA")], "rows count as 1 s apart"),
    "camera": (_write_camera, [("time", "s"), ("temperature", "degC")], "The file has only a temperature"),
}


@pytest.fixture
def desk(tmp_path: Path) -> Desk:
    return Desk(tmp_path)


def _take(desk: Desk, text: str, name: str = "log.txt") -> dict[str, Any]:
    """A request with the columns as they are guessed."""
    key, path = UploadFolder(desk.folder).place(name)
    path.write_text(text, encoding="utf-8")
    return _map(desk, key)


def _map(desk: Desk, key: str) -> dict[str, Any]:
    found = describe_table({"key": key}, desk)["columns"]
    named = [{"at": at, "name": c["name"], "unit": c["unit"]} for at, c in enumerate(found) if c["name"]]
    return {"key": key, "columns": named}


@pytest.mark.parametrize("case", FILES)
def test_files_of_instruments_are_understood_without_a_word(desk: Desk, case: str) -> None:
    """The measured files after which they are made are read in `test_lab_files.py`."""
    write, columns, said = FILES[case]
    request = _take(desk, write())
    table = describe_table(request, desk)
    assert [(one["name"], one["unit"]) for one in request["columns"]] == columns
    assert said in table["said"]
    found = describe_records(request, desk)
    check_answer(found, "identify", "RecordsView")
    assert found["rows"] > 80 and found["timed"] == ("time" in dict(columns))


def test_a_guess_that_nobody_changed_is_put_right_by_its_values(desk: Desk) -> None:
    """The counter of the supply fell back by 1.5 V while the current went on."""
    volts = read_record(_take(desk, _write_supply(True)), desk)["voltage"].tolist()
    assert volts[-1] == pytest.approx(3.4) and volts == sorted(volts)


def test_steps_change_what_they_say_and_nothing_else(desk: Desk) -> None:
    rows = [f"{k},{20 + k % 2 + (40 if k == 30 else 0)},{5 + k}" for k in range(60)]
    request = _take(desk, "time [s],temperature [degC],force [N]\n" + "\n".join(rows), "log.csv")
    steps: list[dict[str, Any]] = [
        {"kind": "outliers", "column": "temperature", "limit": 6.0},
        {"kind": "smooth", "column": "temperature", "width": 3},
        {"kind": "zero", "column": "force", "rows": 1},
        {"kind": "resample", "interval": 2.0},
        {"kind": "cut", "from": 10.0, "to": 50.0},
    ]
    record = read_record({**request, "steps": steps}, desk)
    assert (record.times[0], record.times[-1], len(record)) == (10.0, 50.0, 21)
    assert record["force"] == pytest.approx(record.times)
    assert max(x for x in record["temperature"] if not math.isnan(x)) < 294.0
    found = describe_records({**request, "steps": steps}, desk)
    assert "1 outliers beyond 6 scatters count as missing (row 31)" in found["steps"][0]
    assert [one["before"] != [] for one in found["columns"]] == [True, True]
    assert [one["before"] for one in describe_records(request, desk)["columns"]] == [[], []]
    with pytest.raises(InputError, match="No step named `blur`"):
        read_record({**request, "steps": [{"kind": "blur"}]}, desk)
    with pytest.raises(InputError, match="odd number of rows"):
        read_record({**request, "steps": [{"kind": "median", "column": "force", "width": 4}]}, desk)


def test_two_instruments_become_one_record_by_their_clocks(desk: Desk) -> None:
    camera = {**_take(desk, _write_camera(), "camera.txt"), "merge": True}
    both = {**_take(desk, _write_supply(True), "supply.txt"), "further": [camera]}
    record = read_record(both, desk)
    at = record.times.tolist().index(100.0)
    # the supply's first row is one second after the camera's
    assert record["temperature"][at] == pytest.approx(273.15 + 25.0 + 0.2 * 101.0, abs=0.11)
    assert "by the dates of both" in describe_records(both, desk)["steps"][0]
    assert propose_fit(both, desk)["kind"] == "heating"
    later = {**both, "further": [{**camera, "shift": 10.0}]}
    assert read_record(later, desk)["temperature"][at] == pytest.approx(273.15 + 25.0 + 0.2 * 90.0, abs=0.11)


def test_loops_lead_to_a_material_with_a_verdict_and_a_command(desk: Desk) -> None:
    logs = [_map(desk, place_sample({"load": load}, desk)["key"]) for load in (50, 100, 172, 200)]
    step = {"kind": "median", "column": "strain", "width": 3}
    request: dict[str, Any] = {**logs[0], "steps": [step], "further": logs[1:]}
    drawn = overlay_logs(request, desk)
    check_answer(drawn, "identify", "OverlayView")
    assert drawn["loops"] and drawn["axis"]["name"] == "temperature" and len(drawn["records"]) == 4
    proposed = propose_fit(request, desk)
    check_answer(proposed, "identify", "ProposalView")
    model = min(proposed["models"], key=lambda one: len(one["free"]))
    free = [{key: one[key] for key in ("name", "low", "high", "start", "scale")} for one in model["free"]]
    each = [{"name": name} for name in model["each"]]
    found = run_fit({**request, "text": model["text"], "proposed": model["name"], "free": free, "each": each}, desk)
    check_answer(found, "identify", "Outcome")
    verdict = found["verdict"]
    assert verdict["word"] == "usable" and verdict["untold"] == [] and len(verdict["told"]) == 7
    assert "for the naive baseline (neighbouring loads)" in verdict["headline"]
    assert verdict["next"] == ["A loop at 150 MPa, in the widest gap between the loads."]
    assert "median of 3 rows" in found["prepared"][0]
    assert found["rows"][0]["axis"]["name"] == "temperature"
    made = write_fit_file({"key": found["fit"], "what": "terminal"}, desk)
    with zipfile.ZipFile(UploadFolder(desk.folder).path(made["key"])) as packed:
        names = {f"isobaric_{load}MPa.csv" for load in (50, 100, 172, 200)}
        assert set(packed.namelist()) == {"README.md", "scenario.toml", *names}
        assert found["command"] in packed.read("README.md").decode()
    assert "--hold-out isobaric_172MPa" in found["command"]


def test_a_single_loop_asks_for_other_loads(desk: Desk) -> None:
    request = _map(desk, place_sample({}, desk)["key"])
    model = min(propose_fit(request, desk)["models"], key=lambda one: len(one["free"]))
    free = [{key: one[key] for key in ("name", "low", "high", "start", "scale")} for one in model["free"]]
    each = [{"name": name} for name in model["each"]]
    asked = {**request, "text": model["text"], "proposed": model["name"], "free": free, "each": each}
    verdict = run_fit(asked, desk)["verdict"]
    assert "`A_f` =" in " ".join(verdict["told"]) and "C_A" not in " ".join(verdict["told"])
    assert "Loops under other loads than 172 MPa" in verdict["next"][0]
