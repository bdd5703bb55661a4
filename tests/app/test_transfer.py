"""What goes over the wire: columns as binary for who accepts them, else JSON; and calls that are cancelled."""

import asyncio
import base64
import json
import math
import time
from array import array
from pathlib import Path
from typing import Any

import pytest
from app_server import Bench
from bad_calls import command

from martensite.app import worker_pool
from martensite.app.messages import COLUMNS_TYPE, NUMBERS, SHORTEST_COLUMN, Refusal, pack_columns, write_message
from martensite.app.worker_pool import WorkerPool

TEXT = (Path(__file__).parents[2] / "examples/constant_power.toml").read_text("utf-8")
SMALL: dict[str, Any] = {
    "title": "ξ",
    "short": [1, 2.5, None],
    "flags": [True] * SHORTEST_COLUMN,
    "columns": {"a": [k / 8 - 1 for k in range(16)], "b": [None, math.inf, 3, *[1e-300] * 14]},
}


def unpack(body: bytes) -> Any:
    """A reader written from the description of the format alone."""
    length = int.from_bytes(body[:4], "little")
    planes = body[4 + length :]
    count = len(planes) // 8
    numbers = array("d")
    numbers.frombytes(bytes(planes[k * count + i] for i in range(count) for k in range(8)))

    def fill(table: dict[str, Any]) -> Any:
        if NUMBERS not in table:
            return table
        first, many = table[NUMBERS]
        return [value if math.isfinite(value) else None for value in numbers[first : first + many]]

    return json.loads(body[4 : 4 + length], object_hook=fill)


def test_packed_columns_are_the_same_message() -> None:
    packed = pack_columns(SMALL)
    assert unpack(packed) == json.loads(write_message(SMALL))
    assert NUMBERS.encode() in packed
    assert len(packed) < len(pack_columns({**SMALL, "more": [0.1] * 100}))


def test_the_page_reads_what_is_packed_here() -> None:
    page = (Path(__file__).parents[2] / "web/test/columns.test.ts").read_text("utf-8")
    assert base64.b64encode(pack_columns(SMALL)).decode() in page


def ask(bench: Bench, accept: str, encoding: str) -> tuple[int, str, Any, Any]:
    headers = {"Accept": accept, "Accept-Encoding": encoding}
    with bench.client(**headers) as client:
        request = client.build_request("POST", "/api/call/run", json={"text": TEXT, "changes": {}})
        answer = client.send(request, stream=True)
        raw = b"".join(answer.iter_raw())
        return len(raw), answer.headers.get("content-encoding", ""), answer.headers, raw


def test_an_answer_is_a_sixth_of_what_it_was(bench: Bench) -> None:
    long, encoding, headers, plain = ask(bench, "application/json", "identity")
    assert (encoding, headers["content-type"]) == ("", "application/json")
    short, encoding, headers, _ = ask(bench, f"{COLUMNS_TYPE}, application/json", "gzip")
    assert (encoding, headers["content-type"]) == ("gzip", COLUMNS_TYPE)
    assert 6 * short < long
    assert "default-src 'none'" in headers["content-security-policy"]
    assert headers["x-content-type-options"] == "nosniff"
    *_, packed = ask(bench, COLUMNS_TYPE, "identity")
    found, told = unpack(packed), json.loads(plain)
    assert found.pop("seconds") > 0 < told.pop("seconds")
    assert found == told


def test_refusals_are_sentences_also_for_who_accepts_columns(bench: Bench) -> None:
    with bench.client(Accept=COLUMNS_TYPE) as client:
        answer = client.post("/api/call/run", json={"text": "title = ", "changes": {}})
    assert answer.status_code == 400
    assert answer.json()["kind"] == "input"


def test_the_bundle_comes_compressed(bench: Bench) -> None:
    with bench.client(**{"Accept-Encoding": "gzip"}) as client:
        answer = client.get("/bench.css")
    assert answer.headers["content-encoding"] == "gzip"
    assert "etag" in answer.headers  # it is asked for again with this, and not sent again


def test_a_call_is_cancelled_within_a_second(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(worker_pool, "COMMAND", command(tmp_path))

    async def work() -> float:
        pool = WorkerPool(tmp_path, size=1)
        try:
            assert await pool.ask("other", "run", {}) == {"echo": {}}
            asked = asyncio.create_task(pool.ask("lane", "hang", {}))
            await asyncio.sleep(0.3)
            assert not pool.cancel("other")
            begun = time.monotonic()
            assert pool.cancel("lane")
            with pytest.raises(Refusal, match="Cancelled"):
                await asked
            took = time.monotonic() - begun
            assert await pool.ask("lane", "run", {}) == {"echo": {}}
            return took
        finally:
            await pool.close()

    assert asyncio.run(work()) < 1.0
