"""Fits of the bench: the same numbers as the library's, told while they run, stopped and kept."""

import json
import tomllib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from app_server import Bench
from fit_cases import HEATED, ISOBARIC, TRUE, heated, isobaric, repeated, write_log
from typescript import check_answer
from websockets.sync.client import connect

from martensite.app.calls.fits import run_fit as fit
from martensite.app.calls.fits import write_fit_file as written
from martensite.app.calls.logs import LOSS_WORDS, METHOD_WORDS
from martensite.app.calls.logs import describe_records as records
from martensite.app.calls.logs import list_followers as starts
from martensite.app.calls.logs import match_scenario as beside
from martensite.app.calls.scenarios import run_scenario as run
from martensite.app.uploads import UploadFolder
from martensite.app.views.columns import find_corners
from martensite.app.worker import Desk
from martensite.base.errors import InputError, SolveError
from martensite.fit.api import fit_logs as library_fit
from martensite.fit.losses import LOSSES
from martensite.fit.material_files import write_material
from martensite.fit.solve import METHODS
from martensite.logs.reader import read_table
from martensite.scenario.scenario import read_scenario

COLUMNS = [
    {"at": 0, "name": "time", "unit": "s"},
    {"at": 1, "name": "temperature", "unit": "degC"},
    {"at": 2, "name": "stress", "unit": "MPa"},
    {"at": 3, "name": "strain", "unit": "%"},
]
FREE = [{"name": "A_s"}, {"name": "A_f", "low": 330.0, "high": 380.0, "start": 352.0}]
SAME = "A_s", "A_f=330..380 K@352 K"
Notes = list[dict[str, Any]]


@pytest.fixture
def notes() -> Notes:
    return []


@pytest.fixture
def desk(tmp_path: Path, notes: Notes) -> Desk:
    return Desk(tmp_path, lambda note: notes.append(json.loads(json.dumps(dict(note)))))


def asked(desk: Desk, noise: float = 0.01, **more: Any) -> dict[str, Any]:
    """A request for a fit of an isobaric log."""
    key, path = UploadFolder(desk.folder).place("cycle.csv")
    write_log(isobaric(noise=noise), path)
    return {"key": key, "columns": COLUMNS, "text": ISOBARIC, "free": FREE, **more}


def numbers(found: dict[str, Any]) -> dict[str, float]:
    return {one["name"]: one["value"] for one in found["parameters"]}


def test_it_finds_what_the_library_finds(desk: Desk, notes: Notes, tmp_path: Path) -> None:
    request = asked(desk, each=[{"name": "offset.strain"}])
    found = fit(request, desk)
    check_answer(found, "identify", "Outcome")
    for note in notes:
        check_answer(note, "identify", "Note")
    log = UploadFolder(desk.folder).path(request["key"])
    scenario = read_scenario(ISOBARIC, log=read_table(log))
    same = library_fit(scenario, log, SAME, each="offset.strain")
    assert numbers(found) == pytest.approx(same.numbers, rel=1e-9)
    assert found["cost"] == pytest.approx(same.cost, rel=1e-9)
    for one in found["parameters"]:
        assert one["interval"] == pytest.approx(same.uncertainty.widen_interval(one["name"]), rel=1e-9)
    for name, value in TRUE.items():
        assert numbers(found)[name] == pytest.approx(value, abs=0.5)
    assert found["scores"][0]["rms"] == pytest.approx(same.scores[0].rms, rel=1e-9)
    assert found["open"] == list(same.identifiability.sentences)
    assert [("problem" in note, "curves" in note) for note in notes][:2] == [(True, False), (False, True)]
    assert notes[-1]["values"] == pytest.approx(same.numbers, rel=1e-9)
    material = written({"key": found["fit"], "what": "material"}, desk)
    assert material["name"] == "cycle.toml"
    mine = tomllib.loads(UploadFolder(desk.folder).path(material["key"]).read_text("utf-8"))
    write_material(same, tmp_path / "cycle.toml", scenario=same.scenario)
    theirs = tomllib.loads((tmp_path / "cycle.toml").read_text())
    assert mine.keys() == theirs.keys()
    for section in ("law", "values", "fit"):
        assert mine[section] == theirs[section]


def test_another_start_gives_other_bits(desk: Desk) -> None:
    """The comparison above can fail: it tells apart what differs by more than rounding."""
    one = numbers(fit(asked(desk), desk))
    other = numbers(fit(asked(desk, free=[{"name": "A_s"}], hold_out="none"), desk))
    assert one["A_s"] != pytest.approx(other["A_s"], rel=1e-9)


def test_what_cannot_be_told_is_said(desk: Desk) -> None:
    found = fit(asked(desk, free=[{"name": "A_s"}, {"name": "A_f"}, {"name": "C_A"}]), desk)
    assert not found["determined"]
    assert any("`C_A`" in sentence for sentence in found["open"])
    marks = {one["name"]: one["mark"] for one in found["parameters"]}
    assert marks["C_A"] in ("weak", "not determined")


def test_a_stopped_fit_keeps_the_best_and_goes_on_later(desk: Desk, notes: Notes) -> None:
    begun = desk.tell

    def stopping(note: dict[str, Any]) -> None:
        begun(note)
        if "cost" in note:
            desk.stop.set()

    eager = Desk(desk.folder, stopping, desk.stop)  # type: ignore[arg-type]
    request = asked(desk)
    found = fit(request, eager)
    assert found["reason"] == "interrupted"
    told = [note for note in notes if "cost" in note]
    assert found["cost"] <= told[0]["cost"]
    assert any("did not converge: interrupted" in one for one in found["warnings"])
    desk.stop.clear()
    state = notes[0]["problem"]["state"]
    assert fit(request | {"state": state, "finish": True}, desk)["cost"] == found["cost"]
    desk.stop.clear()
    whole = fit(request | {"state": state}, desk)
    assert whole["reason"] == "converged"
    assert numbers(whole)["A_s"] == pytest.approx(numbers(fit(request, desk))["A_s"], abs=1e-3)
    with pytest.raises(InputError, match="another problem"):
        fit(request | {"state": state, "free": [{"name": "A_s"}]}, desk)


def test_stopped_before_the_first_run_it_says_so(desk: Desk) -> None:
    desk.stop.set()
    found = fit(asked(desk), desk)
    assert found["reason"] == "interrupted"
    assert numbers(found)["A_s"] == found["parameters"][0]["start"]


def test_the_report_is_that_of_the_fit(desk: Desk) -> None:
    found = fit(asked(desk), desk)
    made = written({"key": found["fit"], "what": "report"}, desk)
    text = UploadFolder(desk.folder).path(made["key"]).read_text("utf-8")
    assert made["name"].endswith(".html")
    assert "Converged: " in text
    assert repr(numbers(found)["A_s"]) in text
    with pytest.raises(InputError, match="contains no fit"):
        written({"key": made["key"], "what": "report"}, desk)
    with pytest.raises(InputError, match="No file named"):
        written({"key": found["fit"], "what": "all"}, desk)


def test_the_bench_runs_what_was_fitted(desk: Desk) -> None:
    found = fit(asked(desk, noise=0.0), desk)
    made = run({"text": found["scenario"], "changes": {}}, desk)
    assert made["status"] == "OK"
    table = tomllib.loads(found["scenario"])
    assert table["drive"]["waveform"]["kind"] == "table"
    (row,) = found["rows"]
    ends = max(row["measured"]), min(row["measured"])
    strain = made["columns"]["strain"]
    assert (max(strain), min(strain)) == pytest.approx(ends, abs=2e-4)


def test_a_drive_follows_a_column(desk: Desk) -> None:
    key, path = UploadFolder(desk.folder).place("pulse.csv")
    write_log(heated(), path)
    columns = [
        {"at": at, "name": name, "unit": unit}
        for at, (name, unit) in enumerate([("time", "s"), ("current", "A"), ("position", "mm"), ("resistance", "ohm")])
    ]
    own = HEATED.replace('"log"', '{ kind = "constant", level = "3 W" }').replace('kind = "current"', 'kind = "power"')
    own = own.replace("[run]", '[run]\nduration = "5 s"')
    request = {"key": key, "columns": columns, "text": own}
    before = beside(request, desk)
    check_answer(before, "identify", "ScenarioView")
    assert [(one["path"], one["waveform"]) for one in before["drives"]] == [("drive.waveform", "constant")]
    found = beside(request | {"follow": {"path": "drive.waveform", "column": "current"}}, desk)
    made = tomllib.loads(found["text"])
    assert made["drive"] == {"kind": "current", "waveform": {"kind": "log", "column": "current"}}
    assert "duration" not in made["run"]
    assert found["drives"][0]["column"] == "current"
    assert [one["name"] for one in found["outputs"]] == ["position", "resistance"]
    (film,) = (one for one in found["numbers"] if one["name"] == "h")
    assert (film["value"], film["low"], film["high"]) == pytest.approx((70.0, 14.0, 350.0))
    assert film["doc"]
    with pytest.raises(InputError, match="No source takes `position`"):
        beside(request | {"follow": {"path": "drive.waveform", "column": "position"}}, desk)
    with pytest.raises(InputError, match="no drive or signal at `x`"):
        beside(request | {"follow": {"path": "x", "column": "current"}}, desk)


def test_a_scenario_that_does_not_fit_the_log_is_told_why(desk: Desk) -> None:
    request = asked(desk, columns=COLUMNS[:2] + COLUMNS[3:])
    found = beside(request, desk)
    assert "no column `stress`" in found["refused"]
    assert [one["path"] for one in found["drives"]] == ["drive.waveform", "signals.command"]
    with pytest.raises(InputError, match="not valid TOML"):
        beside(request | {"text": "title = "}, desk)


def test_records_are_cut_and_thinned(desk: Desk) -> None:
    cuts = [
        {"name": "up", "from": 0.0, "to": 60.0, "every": 1},
        {"name": "down", "from": 60.5, "to": 120.0, "every": 2},
    ]
    request = asked(desk, cuts=cuts, hold_out=["down"])
    found = records(request, desk)
    check_answer(found, "identify", "RecordsView")
    told = [(one["name"], one["rows"], one["refused"]) for one in found["cuts"]]
    assert told == [("up", 61, ""), ("down", 30, "")]
    fitted = fit(request, desk)
    parts = {(one["record"], one["part"]) for one in fitted["scores"]}
    assert parts == {("up", "training"), ("down", "held-out")}
    for cut, words in (
        ({"name": "short", "from": 1.0, "to": 2.0}, "Record `short`, 1 s to 2 s, has 2 rows"),
        ({"name": "none", "every": 0}, "1 is the least"),
    ):
        (one,) = records(request | {"cuts": [cut]}, desk)["cuts"]
        assert words in one["refused"]
        with pytest.raises(InputError, match=words):
            fit(request | {"cuts": [cut]}, desk)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"free": []}, "Nothing is free"),
        ({"free": [{"name": "A_z"}]}, "no parameter `A_z`"),
        ({"free": [{"name": "A_s", "low": 400.0, "high": 300.0}]}, "Bounds of the free parameter"),
        ({"free": [{"name": "A_s", "low": "cold"}]}, "must be a number"),
        ({"method": "magic"}, "magic"),
        ({"loss": "magic"}, "magic"),
        ({"starts": 10_000}, "must be 0 to 64"),
        ({"hold_out": ["cycle"]}, "none is left to be fitted"),
        ({"compare": ["resistance"]}, "no column `resistance`"),
    ],
)
def test_what_cannot_be_fitted_is_refused(desk: Desk, change: dict[str, Any], words: str) -> None:
    with pytest.raises((InputError, SolveError), match=words):
        fit(asked(desk, **change), desk)


def test_every_method_and_loss_has_words() -> None:
    assert METHOD_WORDS.keys() == set(METHODS)
    assert LOSS_WORDS.keys() == set(LOSSES)


def test_packaged_scenarios_that_follow_a_log(desk: Desk) -> None:
    found = {one["name"]: one for one in starts({}, desk)["scenarios"]}
    assert "isobaric_log" in found
    assert "constant_power" not in found
    told = beside(asked(desk) | {"text": found["isobaric_log"]["text"]}, desk)
    assert told["refused"] == ""


def test_corners_keep_the_shape_of_a_curve() -> None:
    times = [0.1 * k for k in range(1001)]
    steps = [float(t >= 30.0) + (t - 60.0) * float(t >= 60.0) for t in times]
    rows = find_corners(times, steps)
    assert {0, 299, 300, 600, 1000} <= set(rows)
    assert len(rows) < 10
    assert find_corners(times, [1.0] * 1001) == [0, 1000]


def test_stop_and_keep_over_the_socket(bench: Bench, tmp_path: Path) -> None:
    """A long search is ended by DELETE, and answers with the best so far."""
    with bench.client() as client:
        log = Path(write_log(repeated(heated(), 8), tmp_path / "pulse.csv"))
        key = client.post("/api/files?name=pulse.csv", content=log.read_bytes()).json()["key"]
        columns = [
            {"at": 0, "name": "time", "unit": "s"},
            {"at": 1, "name": "current", "unit": "A"},
            {"at": 2, "name": "position", "unit": "mm"},
        ]
        free = [{"name": name} for name in ("h", "A_s", "A_f", "M_s", "M_f", "C_A", "C_M")]
        request = {
            "key": key,
            "columns": columns,
            "text": HEATED,
            "free": free,
            "method": "coordinate",
            "hold_out": "none",
        }
        job = client.post("/api/jobs", json={"call": "fit", "request": request}).json()
        address = f"{bench.origin.replace('http', 'ws')}/api/jobs/{job['id']}/watch?tab=tab-of-tests"
        headers = {"Authorization": f"Bearer {bench.token}"}
        with connect(address, additional_headers=headers, max_size=2**26) as socket:
            heard = listened(socket.recv, lambda m: m.get("note", {}).get("simulations", 0) > 5)
            client.delete(f"/api/jobs/{job['id']}")
            heard += listened(socket.recv, lambda m: m.get("job", {}).get("state") == "done")
    outcome = heard[-1]["job"]["outcome"]
    assert outcome["reason"] == "interrupted"
    told = [m["note"]["cost"] for m in heard if "cost" in m.get("note", {})]
    assert outcome["cost"] == pytest.approx(min(told), rel=1e-9)


def listened(receive: Callable[..., Any], enough: Callable[[dict[str, Any]], bool]) -> list[dict[str, Any]]:
    """Messages up to the one that is waited for."""
    heard: list[dict[str, Any]] = []
    while not heard or not enough(heard[-1]):
        message = json.loads(receive(timeout=30))
        assert message.get("job", {}).get("state") not in ("failed", "cancelled"), message
        heard.append(message)
    return heard
