"""Whatever a call is asked, it answers or refuses in a sentence; nothing else may come of it."""

import json
import math
import re
import tomllib
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import fault_trials
import pytest
from app_server import Bench
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import martensite.app as app
from martensite.app.documents import check_files, read_request_scenario
from martensite.app.messages import (
    DEEPEST_NESTING,
    BadMessageError,
    describe_refusal,
    read_message,
    require_entry,
    write_message,
)
from martensite.app.routes import ROUTES, find_call
from martensite.app.uploads import UploadFolder
from martensite.app.worker import Desk
from martensite.base.errors import DataError, MartensiteError, ParameterError

SOURCES = Path(app.__file__).parent
ENTRIES = sorted(
    {
        name
        for path in SOURCES.rglob("*.py")
        for name in re.findall(r'(?:require_entry\(\w+, |\.get\()"(\w+)"', path.read_text("utf-8"))
    }
)
"""Entries of requests that are looked at anywhere."""
TEXT = (Path(__file__).parents[2] / "examples/constant_power.toml").read_text("utf-8")
HOSTILE: list[Any] = [
    *(one for one in fault_trials.HOSTILE if not (isinstance(one, float) and not math.isfinite(one))),
    *("nan mm", "C:\\x.toml", {"kind": "table", "file": "../x.csv", "column": "t"}),
    {"kind": "steady", "level": "nan V"},
]
SIMPLE = st.none() | st.booleans() | st.integers() | st.floats(allow_nan=False) | st.text(max_size=30)
VALUES = st.sampled_from(HOSTILE) | st.recursive(
    SIMPLE,
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(st.text(max_size=8), inner, max_size=4),
    max_leaves=10,
)
NAMES = st.sampled_from(ENTRIES) | st.text(max_size=8)
FUZZED = settings(max_examples=10, suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow])


def outcome(call: str, request: Any, folder: Path) -> str:
    """What a worker would send: `answer`, or the sentence of the refusal."""
    try:
        request = read_message(write_message(request))  # as it comes over the wire
    except BadMessageError as error:
        return str(error)
    desk = Desk(folder)
    desk.stop.set()  # long work ends at once
    try:
        sent = write_message({"answer": find_call(call)(request, desk)})
    except Exception as error:
        said = describe_refusal(error)["refused"]
        assert not said.startswith("Unexpected"), f"{call} {request!r}: {said}"
        assert "Traceback" not in said
        assert said.strip()
        return said
    json.loads(sent)
    return "answer"


@pytest.fixture
def folder(tmp_path: Path) -> Iterator[Path]:
    """A folder of a bench; there must be nothing beside it in the end."""
    inside = tmp_path / "outer" / "bench"
    inside.mkdir(parents=True)
    yield inside
    assert list(inside.parent.iterdir()) == [inside]


@pytest.mark.parametrize("call", ROUTES)
@FUZZED
@given(request=st.dictionaries(NAMES, VALUES, max_size=6))
def test_arbitrary_requests(call: str, request: dict[str, Any], folder: Path) -> None:
    outcome(call, request, folder)


# ---------------------------------------------------------------- what is nearly right


def leaves(table: Mapping[str, Any], above: str = "") -> Iterator[str]:
    for key, value in table.items():
        yield f"{above}{key}"
        if isinstance(value, dict):
            yield from leaves(value, f"{above}{key}.")


PATHS = list(leaves(tomllib.loads(TEXT)))
BUILT = [path for path in PATHS if not path.startswith("run")]
CSV = b"time [s],strain [-],temperature [degC]\n0,0,20\n1,=1+1,21\n2,0.01,22\n3,0.02,\n"


def right(call: str, folder: Path) -> dict[str, Any]:
    """A request that is answered, or nearly so."""
    key, path = UploadFolder(folder).place("log.csv")
    path.write_bytes(CSV)
    columns = [
        {"at": 0, "name": "time", "unit": "s"},
        {"at": 1, "name": "strain", "unit": "1"},
        {"at": 2, "name": "temperature", "unit": "degC"},
    ]
    table = {"key": key, "separator": "auto", "columns": columns, "interval": None, "drop": True}
    swept = {
        "text": TEXT,
        "over": [{"name": "element.diameter", "values": ["0.2 mm", "0.3 mm"]}],
        "sample": "grid",
        "runs": 2,
        "measures": ["stroke"],
        "seed": 1,
        "step": "0.1 s",
    }
    return {
        "differences": {"texts": [TEXT, TEXT]},
        "form": {"text": TEXT, "changes": {}, "removed": []},
        "fit_records": {**table, "cuts": []},
        "fit_scenario": {**table, "text": TEXT, "follow": {"path": "drive", "column": "strain"}},
        "size_form": {"fields": {"force": "8 N", "stroke": "5 mm"}},
        "study_page": {"name": "finger"},
        "sweep_form": {"text": TEXT},
        "sweep_plan": swept,
        "table": table,
    }[call]


@pytest.mark.parametrize(
    "call",
    [
        "differences",
        "form",
        "fit_records",
        "fit_scenario",
        "size_form",
        "study_page",
        "sweep_form",
        "sweep_plan",
        "table",
    ],
)
@FUZZED
@given(data=st.data())
def test_requests_that_are_nearly_right(call: str, data: st.DataObject, folder: Path) -> None:
    request = right(call, folder)
    for _ in range(data.draw(st.integers(1, 2))):
        box: Any = request
        while True:
            name = data.draw(st.sampled_from(sorted(box) if isinstance(box, dict) else range(len(box))))
            below = box[name]
            if not (isinstance(below, (dict, list)) and below and data.draw(st.booleans())):
                break
            box = below
        box[name] = data.draw(VALUES)
    outcome(call, request, folder)


@pytest.mark.parametrize("call", ["form", "sweep_form"])
@FUZZED
@given(changes=st.dictionaries(st.sampled_from(PATHS) | st.text(max_size=12), VALUES, max_size=3))
def test_changes_of_all_kinds(call: str, changes: dict[str, Any], folder: Path) -> None:
    outcome(call, {"text": TEXT, "changes": changes}, folder)


@FUZZED
@given(path=st.sampled_from(BUILT), value=VALUES, more=st.dictionaries(st.sampled_from(BUILT), VALUES, max_size=1))
def test_runs_of_all_kinds(path: str, value: Any, more: dict[str, Any], folder: Path) -> None:
    """With a step, so that none takes long."""
    quick = {"run.step": "0.5 s", "run.samples": 11, "run.duration": "2 s"}
    outcome("run", {"text": TEXT, "changes": {**more, path: value, **quick}}, folder)


@FUZZED
@given(text=st.text(max_size=200) | st.sampled_from([TEXT[:k] for k in range(0, 3000, 37)]))
def test_texts_that_are_no_scenario(text: str, folder: Path) -> None:
    for call in ("form", "differences", "sweep_form"):
        outcome(call, {"text": text, "texts": [text]}, folder)


@pytest.mark.parametrize(
    "changes",
    [
        {"run.duration": "1e12 s"},
        {"run.step": "1e-9 s"},
        {"run.samples": 10_000_000},
        {"run.duration": "1e300 s", "run.step": "1e-300 s"},
        {"run.samples": 1e300},
    ],
)
def test_what_would_take_without_end_is_refused(changes: dict[str, Any], folder: Path) -> None:
    assert outcome("run", {"text": TEXT, "changes": changes}, folder) != "answer"


# ---------------------------------------------------------------- files


@pytest.mark.parametrize(
    "name",
    [
        "/etc/passwd",
        "../x.csv",
        "a/../../x.csv",
        "C:\\x.csv",
        "..\\x.csv",
        "\\\\host\\x",
        "file:///x",
        "\0",
        "~/../../x",
        "http://x/y.csv",
    ],
)
def test_a_scenario_reads_no_files_of_elsewhere(name: str) -> None:
    shown = json.dumps(name)
    for text, changes in (
        (f"[measured]\nfile = {shown}", {}),
        (f"[model]\nfile = {shown}", {}),
        ("", {"measured.file": name}),
        ("", {"drive": {"waveform": {"file": name}}}),
        (f'[drive]\nwaveform = {{ kind = "table", file = {shown}, column = "x" }}', {}),
        (f"[signals.a]\nb = [{{ file = {shown} }}]", {}),
    ):
        with pytest.raises(DataError, match="The bench reads no file"):
            check_files(text, changes)


def test_a_scenario_reads_no_materials_of_elsewhere(tmp_path: Path) -> None:
    desk, known = Desk(tmp_path), "element.material"
    for name in ("/etc/x.toml", "../x.toml", "../x", "a/../../x", "..\\x.toml"):
        with pytest.raises(DataError, match="The bench reads no file"):
            read_request_scenario({"text": TEXT, "changes": {known: name}}, desk)
    with pytest.raises(MartensiteError, match="no material"):
        read_request_scenario({"text": TEXT, "changes": {known: "x.toml"}}, desk)
    check_files('[measured]\nfile = "data:set/file.csv"', {})


# ---------------------------------------------------------------- messages


@pytest.mark.parametrize(
    "data",
    [
        b"",
        b"{",
        b"nonsense",
        b"\xff\xfe{}",
        b"[]",
        b"1",
        b"null",
        b'"x"',
        b'{"a": NaN}',
        b"{}" * 2,
        b'{"a": 1e999}',
        b'{"a": -Infinity}',
        b'{"a": ' + b"9" * 400 + b"}",
        b'{"a": "\\ud800"}',
        b'{"a":' * 1000 + b"1" + b"}" * 1000,
        b'{"a":' + b"[" * DEEPEST_NESTING + b"]" * DEEPEST_NESTING + b"}",
        b'{"a":' + b"[" * 100_000,
        b'{"\\udc00": 1}',
        b'{"a": 1,}',
        b"{'a': 1}",
        b'{"a": 01}',
    ],
)
def test_messages_that_are_none(data: bytes) -> None:
    with pytest.raises(BadMessageError):
        read_message(data)


@given(st.binary(max_size=60) | VALUES.map(write_message))
def test_any_bytes_are_a_message_or_refused(data: bytes) -> None:
    try:
        found = read_message(data)
    except BadMessageError as error:
        assert str(error).startswith("The message")
        return
    assert read_message(write_message(found)) == found


@given(VALUES, st.sampled_from([str, dict, list, float, int, bool]))
def test_entries_are_of_their_sort_or_refused(value: Any, sort: type) -> None:
    try:
        found = require_entry({"a": value}, "a", sort)
    except BadMessageError as error:
        assert "`a` must be" in str(error)
        assert len(str(error)) < 150
        return
    assert type(found) is sort


def test_long_scenarios_are_refused(tmp_path: Path) -> None:
    with pytest.raises(ParameterError, match="letters"):
        read_request_scenario({"text": "#" * 2_000_000}, Desk(tmp_path))


# ---------------------------------------------------------------- over the wire

LONG = ("size_catalogue", "study")
"""Calls that are long work even if nothing is asked."""
ABSENT = ("nothing", "__init__", "_sizing", "..%2frun", "os", "run.py", "%00")


def test_over_the_wire_every_answer_is_a_sentence_or_an_answer(bench: Bench) -> None:
    unread = [b"", b"{", b"[]", b"\xff" * 100, b'{"a": 1e999}', b'{"a":' * 5000]
    read = [
        b'{"text": 1}',
        b'{"text": "' + b"x" * 10_000 + b'"}',
        b'{"key": "../../etc"}',
        b'{"name": "../x", "key": ""}',
    ]
    calls = [call for call in ROUTES if call not in LONG]
    with bench.client() as client:
        for number, call in enumerate((*calls, *ABSENT)):
            for body in (*unread, *read) if number < 5 else read:
                found = client.post(f"/api/call/{call}", content=body)
                assert found.status_code in (200, 400, 404, 405, 422), found.text
                assert "Unexpected" not in found.text[:100], f"{call} {body[:40]!r}: {found.text}"
        assert client.get("/api/status").status_code == 200


def test_the_fuzzing_notices_a_bug(monkeypatch: pytest.MonkeyPatch, folder: Path) -> None:
    def broken(request: dict[str, Any], desk: Desk) -> Any:
        return 1 / 0

    monkeypatch.setattr("martensite.app.calls.scenarios.list_scenarios", broken)
    with pytest.raises(AssertionError, match="Unexpected error: ZeroDivisionError"):
        outcome("scenarios", {}, folder)
