"""The server under requests of all kinds: each is answered or refused, and memory stays.

Source of truth: the same request when nothing else goes on, and the memory of the process.
"""

from __future__ import annotations

import random
import socket
import time
from collections import Counter
from collections.abc import Callable
from contextlib import ExitStack
from pathlib import Path

import httpx
import pytest
from app_server import Bench, running
from fault_trials import HOSTILE, spoil_bytes

from martensite.app.messages import write_message
from martensite.app.routes import ROUTES

TEXT = (Path(__file__).parents[2] / "examples/constant_power.toml").read_text("utf-8")
LONG = ("size_catalogue", "study")
"""Calls that are long work even if nothing is asked."""
CALLS = [call for call in ROUTES if call not in LONG]
SOUND = write_message({"text": TEXT, "changes": {"run.samples": 11, "run.duration": "2 s"}})
OPEN_SOCKETS = 50
"""Half-open ones at a time."""


def measure_memory(pid: int) -> float:
    """Memory [MB] that a process holds."""
    lines = Path(f"/proc/{pid}/status").read_text().splitlines()
    return next(int(line.split()[1]) / 1024 for line in lines if line.startswith("VmRSS"))


def make_body(rng: random.Random) -> bytes:
    """The body of a request: sound, nearly so, or anything."""
    pick = rng.random()
    if pick < 0.2:
        return SOUND
    if pick < 0.5:
        return spoil_bytes(SOUND, rng)
    finite = [one for one in HOSTILE if not isinstance(one, float)]
    names = ("text", "changes", "key", "name", "fields", "table", "over", "runs")
    request = {rng.choice(names): rng.choice(finite) for _ in range(rng.randrange(5))}
    return write_message(request) if pick < 0.9 else rng.randbytes(rng.randrange(300))


def ask_hostile(client: httpx.Client, rng: random.Random) -> int:
    """One request of any kind; its status."""
    call, pick = rng.choice(CALLS), rng.random()
    if pick < 0.8:
        found = client.post(f"/api/call/{call}", content=make_body(rng))
    elif pick < 0.9:
        found = client.post(f"/api/call/{call}", content=SOUND, headers={"Authorization": "Bearer wrong"})
    else:
        found = client.get(rng.choice(("/api/status", "/..%2f..%2fetc/passwd", "/api/jobs", "/nothing", "/bench.js")))
    assert "Traceback" not in found.text and "Unexpected" not in found.text[:200], f"{call}: {found.text[:500]}"
    return found.status_code


def load_server(bench: Bench, going_on: Callable[[int], bool]) -> Counter[int]:
    """Requests one after another, beside sockets that say half of something; statuses."""
    rng, seen = random.Random(0), Counter[int]()
    with bench.client() as client, ExitStack() as kept:
        expected = client.post("/api/call/form", content=SOUND).json()
        for _ in range(OPEN_SOCKETS):
            wire = kept.enter_context(socket.create_connection(("127.0.0.1", bench.port), timeout=10))
            wire.sendall(b"POST /api/call/run HTTP/1.1\r\nHost: 127.0")
        while going_on(sum(seen.values())):
            seen[ask_hostile(client, rng)] += 1
        assert client.post("/api/call/form", content=SOUND).json() == expected
    return seen


def test_hostile_requests_change_nothing(bench: Bench) -> None:
    seen = load_server(bench, lambda done: done < 60)
    assert set(seen) <= {200, 400, 401, 403, 404, 405, 413, 422, 429}, seen
    assert {200, 400, 401} <= set(seen), seen


@pytest.mark.slow
def test_ten_minutes_of_hostile_requests(tmp_path: Path) -> None:
    with running(tmp_path) as bench:
        load_server(bench, lambda done: done < 300)  # what is imported and compiled once
        before, end = measure_memory(bench.pid), time.monotonic() + 600.0
        seen = load_server(bench, lambda _: time.monotonic() < end)
        grown = measure_memory(bench.pid) - before
    assert set(seen) <= {200, 400, 401, 403, 404, 405, 413, 422, 429}, seen
    assert grown < 20.0 + 1e-3 * sum(seen.values()), f"{grown:.1f} MB in {sum(seen.values())} requests"
