"""Sweeps of the web bench as a client sees them: begun, watched, cancelled, gone on with."""

import json
import re
import shlex
import zipfile
from collections.abc import Callable, Generator, Iterator
from contextlib import closing
from pathlib import Path
from typing import Any
from urllib.parse import urlencode

import numpy as np
import psutil
import pytest
from app_server import Bench, running
from typer.testing import CliRunner
from typescript import check_answer
from websockets.sync.client import connect

from martensite.app.calls import sweep_form
from martensite.app.calls.sweeps import delete_sweep as delete
from martensite.app.calls.sweeps import estimate_indices as indices
from martensite.app.calls.sweeps import find_front as front
from martensite.app.calls.sweeps import list_sweeps as listed
from martensite.app.calls.sweeps import read_points as points
from martensite.app.calls.sweeps import read_row as row
from martensite.app.calls.sweeps import run_sweep as sweep
from martensite.app.sweeping.sweep_drawing import MOST_DRAWN, SweepDrawing
from martensite.app.sweeping.sweep_folder import SweepFolder, hold_store, make_slug
from martensite.app.sweeping.sweep_request import quote_words
from martensite.app.worker import Desk
from martensite.base.errors import DataError, InputError
from martensite.cli.app import app
from martensite.design.sweep.indices import compute_sensitivity as sensitivity_indices
from martensite.design.sweep.pareto import find_pareto_front
from martensite.design.sweep.reading import read_sweep
from martensite.design.sweep.store import Store

TEXT = (Path(__file__).parents[2] / "examples/constant_power.toml").read_text("utf-8")
SHORT = TEXT.replace('duration = "10 s"', 'duration = "2 s"\nsamples = 41')
GRID: dict[str, Any] = {
    "text": SHORT,
    "over": ["diameter=0.08..0.15 mm:8", "high=0.3..0.6 W:6"],
    "sample": "grid",
    "measures": ["stroke", "max(temperature)", "fall-time"],
    "step": "50 ms",
    "runtime": "floats",
}
LONG = {**GRID, "over": ["diameter=0.08..0.15 mm:200", "high=0.3..0.6 W:200"], "workers": 2}
TAB = "tab-of-sweeps"


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> tuple[Desk, str, list[dict[str, Any]]]:
    """A whole sweep, its key, and the notes that it sent."""
    notes: list[dict[str, Any]] = []
    desk = Desk(tmp_path_factory.mktemp("drawer"), lambda note: notes.append(dict(note)))
    found = sweep(GRID, desk)
    check_answer(found, "sweep", "Outcome")
    assert (found["done"], found["runs"], found["stopped"]) == (48, 48, "")
    return desk, found["key"], notes


def test_notes_hold_every_run_once(made: tuple[Desk, str, list[dict[str, Any]]]) -> None:
    desk, key, notes = made
    for note in notes:
        check_answer(note, "sweep", "Note")
    assert [note["number"] for note in notes] == list(range(len(notes)))
    told = [row for note in notes[1:] for row in note["rows"]]
    assert sorted(told) == list(range(48))
    table = read_sweep(SweepFolder(desk.folder).path(key))
    strokes = [v for note in notes[1:] for v in note["columns"]["stroke"]]
    assert np.allclose(np.array(strokes)[np.argsort(told)], table.measures["stroke"].values, 1e-5)
    assert notes[-1]["done"] == notes[-1]["runs"] == 48
    assert sum(notes[-1]["counts"].values()) == 48


def test_points_are_those_of_the_store(made: tuple[Desk, str, list[dict[str, Any]]]) -> None:
    desk, key, _ = made
    found = points({"key": key}, desk)
    check_answer(found, "sweep", "Stored")
    assert found["state"] == "done"
    assert [axis["short"] for axis in found["layout"]["axes"]] == ["diameter", "high"]
    assert len(found["layout"]["axes"][0]["levels"]) == 8
    celsius = next(m for m in found["layout"]["measures"] if m["name"] == "max(temperature)")
    shown = 300.0 * celsius["factor"] + celsius["offset"]
    assert celsius["display_unit"] == "degC" and shown == pytest.approx(26.85)
    assert found["points"]["rows"] == list(range(48))


def test_a_large_sweep_is_thinned_evenly(tmp_path: Path) -> None:
    class Large(SweepDrawing):
        size = 90_000
        levels = (range(300), range(300))

    found = Large(Store(tmp_path))
    kept = found.select_drawn_runs(np.arange(90_000))
    assert 0.4 * MOST_DRAWN < len(kept) <= MOST_DRAWN
    assert found.strides == [3, 2] or found.strides == [2, 3]
    assert len({int(k) // 300 for k in kept}) == -(-300 // found.strides[0])


def test_a_run_is_opened_with_exactly_its_numbers(made: tuple[Desk, str, list[dict[str, Any]]]) -> None:
    from martensite.scenario.scenario import read_scenario

    desk, key, _ = made
    found = row({"key": key, "row": 27}, desk)
    scenario = read_scenario(found["text"])
    table = read_sweep(SweepFolder(desk.folder).path(key))
    leaves = {leaf.path: leaf.value for leaf in scenario.whole.leaves()}
    assert leaves["element.diameter"] == table.varied["element.diameter"].values[27]
    high = table.varied["drive.waveform.high"].values[27]
    assert scenario.single_waveform.value_of("high") == high
    with pytest.raises(DataError, match="no run 48"):
        row({"key": key, "row": 48}, desk)


def test_the_front_is_that_of_the_library(made: tuple[Desk, str, list[dict[str, Any]]]) -> None:
    desk, key, _ = made
    found = front({"key": key, "minimise": ["max(temperature)"], "maximise": ["stroke"]}, desk)
    table = read_sweep(SweepFolder(desk.folder).path(key))
    known = find_pareto_front(table, ["max(temperature)"], ["stroke"])
    assert found["rows"] == known.runs.tolist()
    assert 1 < found["count"] < found["compared"]


def test_indices_say_what_matters(made: tuple[Desk, str, list[dict[str, Any]]]) -> None:
    desk, key, _ = made
    found = indices({"key": key, "measure": "stroke"}, desk)
    table = read_sweep(SweepFolder(desk.folder).path(key))
    (known,) = sensitivity_indices(table, ["stroke"])
    assert found["names"] == [known.names[k] for k in known.order]
    assert found["method"] == "grid"
    total = list(found["indices"]["total"]["values"])
    assert total == known.indices["total"].values[known.order].tolist()
    assert 0.5 < total[0] <= 1.0 + 1e-9


def test_the_table_is_safe_in_a_spreadsheet(made: tuple[Desk, str, list[dict[str, Any]]]) -> None:
    desk, key, _ = made
    said = sweep_form.export_sweep({"key": key, "kind": "csv"}, desk)
    lines = (desk.folder / said["file"] / said["name"]).read_text("utf-8").splitlines()
    assert lines[0].startswith("run,status,element.diameter [m],drive.waveform.high [W],stroke [m]")
    assert len(lines) == 49


def test_the_zip_is_the_store(made: tuple[Desk, str, list[dict[str, Any]]], tmp_path: Path) -> None:
    desk, key, _ = made
    said = sweep_form.export_sweep({"key": key, "kind": "zarr"}, desk)
    with zipfile.ZipFile(desk.folder / said["file"] / said["name"]) as packed:
        packed.extractall(tmp_path)
    (copy,) = tmp_path.iterdir()
    same(copy, SweepFolder(desk.folder).path(key))


def same(one: Path, other: Path) -> None:
    """Two stores hold the same bits."""
    a, b = read_sweep(one), read_sweep(other)
    assert a.status.tobytes() == b.status.tobytes()
    for name, column in {**a.varied, **a.measures}.items():
        assert column.values.tobytes() == b.column(name).values.tobytes(), name


def test_the_command_makes_the_same_sweep(
    bench: Bench, made: tuple[Desk, str, list[dict[str, Any]]], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    desk, key, _ = made
    said = bench.call("sweep_plan", GRID)
    assert said["runs"] == 48 and not said["faults"]
    words = shlex.split(said["command"])
    monkeypatch.chdir(tmp_path)
    Path(words[2]).write_text(SHORT, "utf-8")
    found = CliRunner().invoke(app, [*words[1:], "--out", "again.zarr"])
    assert found.exit_code == 0, found.output
    same(tmp_path / "again.zarr", SweepFolder(desk.folder).path(key))


def test_words_are_quoted_for_a_shell() -> None:
    for words in ("a=1..2 mm:3", "max(stress)", "x'y $(rm) `z`", 'a "b"', "plain"):
        assert shlex.split(quote_words(words)) == [words]


def test_faults_stand_beside_their_fields(bench: Bench) -> None:
    wrong = {
        **GRID,
        "measures": ["strok", "max(stress)"],
        "over": ["diametr=1..2 mm:3", "length=1..2:3", "emissivity=0.5..1.5:3", "preload=1..2 N"],
        "runtime": "fortran",
        "step": "2 m",
    }
    found = bench.call("sweep_plan", wrong)
    faults = found["faults"]
    assert found["runs"] is None
    assert "Did you mean" in faults["over.0"] and "no unit" in faults["over.1"]
    assert "between" in faults["over.2"] or "at most" in faults["over.2"]
    assert "no levels" in faults["over.3"]
    assert "stroke" in faults["measures.0"] and "measures.1" not in faults
    assert "fortran" in faults["runtime"] and "step" in faults
    sample = bench.call("sweep_plan", {**GRID, "sample": "sobol"})["faults"]
    assert list(sample) == ["sample"] and "sobol:1024" in sample["sample"]
    many = bench.call("sweep_plan", {**GRID, "sample": "sobol:2000000"})["faults"]
    assert "at most 1,000,000" in many["sample"]
    assert bench.call("sweep_plan", {**GRID, "over": []})["faults"][""].startswith("A sweep needs varied")


def test_the_form_is_made_of_declarations(bench: Bench) -> None:
    found = bench.call("sweep_form", {"text": SHORT})
    targets = {one["name"]: one for one in found["targets"]}
    emissivity = targets["environment.cooling.radiation.emissivity"]
    assert (emissivity["low"], emissivity["high"], emissivity["value"]) == (0.0, 1.0, 0.6)
    assert targets["drive.waveform.high"]["words"] == "0.45 W"
    assert targets["element.diameter"]["unit"] == "mm"
    names = [one["name"] for one in found["designs"]]
    assert names[0] == "grid" and {"sobol", "saltelli"} <= set(names)
    measures = {one["name"]: one for one in found["measures"]}
    assert measures["energy"]["usual"] == "power" and all(m["about"] for m in measures.values())


def test_the_time_is_estimated_from_a_block(bench: Bench) -> None:
    found = bench.call("sweep_time", GRID)
    assert found["tried"] == 16 and found["runtime"] == "floats"
    assert found["seconds"] == pytest.approx(3 * found["took"] / found["workers"])


@pytest.mark.parametrize("key", ["", "..", "../../etc", "0" * 16, "*", "a-*", 7])
def test_keys_lead_nowhere_else(made: tuple[Desk, str, list[dict[str, Any]]], key: Any) -> None:
    with pytest.raises(InputError):
        delete({"key": key}, made[0])


def test_titles_are_no_paths() -> None:
    assert make_slug("../../etc/passwd") == "etc-passwd"
    assert make_slug("=cmd|' /C calc'!A0") == "cmd-c-calc-a0"
    assert make_slug("…") == "sweep"
    assert len(make_slug("x" * 500)) == 40


# Over the interface: a job that is watched, cancelled, and gone on with


def begin(bench: Bench, request: dict[str, Any], tab: str = TAB) -> str:
    with bench.client(tab) as client:
        found = client.post("/api/jobs", json={"call": "sweep", "request": request}).json()
    assert "id" in found, found
    return found["id"]


def heard(bench: Bench, job: str, tab: str = TAB) -> Generator[dict[str, Any]]:
    """What a page hears of a job until it ends."""
    address = f"ws://127.0.0.1:{bench.port}/api/jobs/{job}/watch?{urlencode({'tab': tab})}"
    headers = {"Authorization": f"Bearer {bench.token}"}
    with connect(address, additional_headers=headers, max_size=2**26) as socket:
        for text in socket:
            yield json.loads(text)


def until(messages: Iterator[dict[str, Any]], enough: Callable[[dict[str, Any]], bool]) -> dict[str, Any]:
    """The first note that is enough, or the end of the job."""
    for message in messages:
        notes = message["job"]["trail"] if "job" in message else [message["note"]]
        ended = message.get("job", {}).get("state", "running") != "running"
        found = next((note for note in notes if enough(note)), None)
        if ended or found:
            return found or message["job"]
    raise AssertionError("the socket closed")


def ended(bench: Bench, job: str, tab: str = TAB) -> dict[str, Any]:
    *_, last = heard(bench, job, tab)
    return last["job"]


def under(pid: int) -> list[psutil.Process]:
    """All processes that a server has started, and theirs."""
    return psutil.Process(pid).children(recursive=True)


def cancel(bench: Bench, job: str, tab: str = TAB) -> None:
    with bench.client(tab) as client:
        assert client.delete(f"/api/jobs/{job}").status_code == 200


def test_cancelled_it_keeps_what_was_made_and_leaves_no_process(bench: Bench) -> None:
    bench.call("sweep_plan", GRID)
    before = {one.pid for one in under(bench.pid)}
    job = begin(bench, LONG)
    with closing(heard(bench, job)) as messages:
        note = until(messages, lambda note: note.get("done", 0) > 0)
    assert 0 < note["done"] < note["runs"] == 40_000, note
    assert note["rate"] > 0.0 and note["left"] > 0.0
    started = [one for one in under(bench.pid) if one.pid not in before]
    assert len(started) >= 3  # the worker, and two processes of its own
    cancel(bench, job)
    outcome = ended(bench, job)["outcome"]
    assert outcome == "Cancelled." or "Interrupted when" in outcome["stopped"], outcome
    _, alive = psutil.wait_procs(started, timeout=10)
    assert alive == []
    (line,) = [one for one in bench.call("sweeps", {})["sweeps"] if one["key"] == note["key"]]
    assert line["state"] == "stopped" and 0 < line["done"] < line["runs"]
    assert bench.call("sweep_delete", {"key": note["key"]}) == {}
    assert not list((bench.folder / "sweeps").glob(f"*{note['key']}*"))


@pytest.mark.slow
def test_resumed_on_another_server_it_has_the_same_bits(tmp_path: Path) -> None:
    wanted = {**GRID, "over": ["diameter=0.08..0.15 mm:40", "high=0.3..0.6 W:48"]}
    folder = tmp_path / "kept"
    desk = Desk(folder)
    notes: list[Any] = []

    def tell(note: Any) -> None:
        notes.append(note)
        if note.get("done"):
            desk.stop.set()

    desk.tell = tell
    stopped = sweep(wanted, desk)
    assert 0 < stopped["done"] < stopped["runs"] == 1920
    assert re.match(r"Interrupted when \d+ of 1,920 runs were there", stopped["stopped"])
    with running(folder) as other:
        (line,) = other.call("sweeps", {})["sweeps"]
        assert line["state"] == "stopped"
        outcome = ended(other, begin(other, {"resume": line["key"]}))["outcome"]
        assert outcome["done"] == 1920, outcome
    whole = sweep(wanted, Desk(tmp_path / "other"))
    same(SweepFolder(folder).path(line["key"]), SweepFolder(tmp_path / "other").path(whole["key"]))


def test_a_sweep_that_runs_is_neither_deleted_nor_begun_twice(made: tuple[Desk, str, list[dict[str, Any]]]) -> None:
    desk, key, _ = made
    with hold_store(SweepFolder(desk.folder).path(key)):
        with pytest.raises(DataError, match="running already"):
            delete({"key": key}, desk)
        with pytest.raises(DataError, match="running already"):
            sweep({"resume": key}, desk)
    assert [one["key"] for one in listed({}, desk)["sweeps"]] == [key]


def test_two_tabs_do_not_disturb_each_other(bench: Bench) -> None:
    first, second = begin(bench, GRID, "tab-one"), begin(bench, GRID, "tab-two")
    with bench.client("tab-one") as client:
        assert [one["id"] for one in client.get("/api/jobs").json()] == [first]
        assert client.delete(f"/api/jobs/{second}").status_code == 404
    one, two = (ended(bench, first, "tab-one"), ended(bench, second, "tab-two"))
    assert one["outcome"]["done"] == two["outcome"]["done"] == 48
    assert one["outcome"]["key"] != two["outcome"]["key"]
