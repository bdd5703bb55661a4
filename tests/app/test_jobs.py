"""Long work over the socket, and the end of the server with all that it has started."""

import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from socket import SHUT_RDWR
from threading import Thread
from typing import Any

import httpx
import pytest
from app_server import TAB, Bench
from bad_calls import command
from websockets.exceptions import ConnectionClosed
from websockets.sync.client import ClientConnection, connect

from martensite.app.jobs import AT_ONCE, LONGEST_TRAIL

SERVER = """import json, sys
from pathlib import Path
from martensite.app import worker_pool
from martensite.app.server import serve_bench
worker_pool.COMMAND, worker_pool.STOP_LIMIT = {command!r}, 2.0
def ready(at):
    print(json.dumps([at.port, at.token]), flush=True)
serve_bench(0, {folder}, ready)
"""
SLOWEST = 20.0
"""Seconds in which what is waited for comes to pass, on a busy machine."""


@dataclass(frozen=True)
class Rough:
    """A server whose calls misbehave."""

    process: "subprocess.Popen[str]"
    bench: Bench


@contextmanager
def rough(folder: Path, kept: bool = True) -> Iterator[Rough]:
    below = folder / "files"
    below.mkdir()
    place = f"Path({str(below)!r})" if kept else None
    main = folder / "server_of_tests.py"
    main.write_text(SERVER.format(command=command(folder), folder=place))
    with subprocess.Popen(
        [sys.executable, str(main)],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env={**os.environ, "TMPDIR": str(folder)},
    ) as process:
        try:
            assert process.stdout
            port, token = json.loads(process.stdout.readline())
            yield Rough(process, Bench(port, token, below, process.pid))
        finally:
            process.kill()


@pytest.fixture(scope="module")
def served(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Bench]:
    with rough(tmp_path_factory.mktemp("rough")) as made:
        yield made.bench


def begun(bench: Bench, call: str, request: dict[str, Any] | None = None, tab: str = TAB) -> str:
    with bench.client(tab) as client:
        answer = client.post("/api/jobs", json={"call": call, "request": request or {}})
    assert answer.status_code == 201, answer.text
    return answer.json()["id"]


def watching(bench: Bench, job: str, tab: str = TAB) -> ClientConnection:
    address = f"{bench.origin.replace('http', 'ws')}/api/jobs/{job}/watch?tab={tab}"
    known = {"Authorization": f"Bearer {bench.token}"}
    return connect(address, additional_headers=known, max_size=2**24)


def to_the_end(bench: Bench, job: str) -> list[dict[str, Any]]:
    """All messages until the job is over."""
    with watching(bench, job) as socket:
        return [json.loads(message) for message in socket]


def until_told(socket: ClientConnection) -> None:
    """Wait until a job has said something."""
    while True:
        message = json.loads(socket.recv(SLOWEST))
        if "note" in message or message["job"]["trail"]:
            return


def cancelled(bench: Bench, job: str, tab: str = TAB) -> int:
    with bench.client(tab) as client:
        return client.delete(f"/api/jobs/{job}").status_code


def wait_until(true: Callable[[], bool]) -> None:
    end = time.monotonic() + SLOWEST
    while not true():
        assert time.monotonic() < end
        time.sleep(0.02)


def test_a_job_tells_how_far_it_is(served: Bench) -> None:
    heard = to_the_end(served, begun(served, "many", {"notes": 5}))
    last = heard[-1]["job"]
    assert heard[0]["job"]["call"] == "many"
    assert (last["state"], last["outcome"]) == ("done", {"k": 4})
    assert last["trail"] == [{"k": k} for k in range(5)]


def test_many_notes_are_thinned_out(served: Bench) -> None:
    job = begun(served, "many", {"notes": 1500})
    last = to_the_end(served, job)[-1]["job"]
    assert len(last["trail"]) <= LONGEST_TRAIL
    assert (last["trail"][0], last["trail"][-1]) == ({"k": 0}, {"k": 1499})
    assert to_the_end(served, job)[-1]["job"]["outcome"] == {"k": 1499}  # known afterwards


def test_a_job_that_is_stopped_ends_with_the_best_so_far(served: Bench) -> None:
    for wait in (True, False):  # also before it has begun
        job = begun(served, "stopped")
        if wait:
            with watching(served, job) as socket:
                until_told(socket)
        assert cancelled(served, job) == 200
        last = to_the_end(served, job)[-1]["job"]
        assert (last["state"], last["outcome"]) == ("done", {"best": "so far"})


def test_a_job_that_does_not_stop_is_ended(served: Bench) -> None:
    job = begun(served, "hang")
    assert cancelled(served, job) == 200
    assert to_the_end(served, job)[-1]["job"]["state"] == "cancelled"
    assert cancelled(served, job) == 200


def test_a_job_that_does_not_end_by_itself_is_cancelled_within_a_second(served: Bench) -> None:
    job = begun(served, "hang")
    with watching(served, job) as socket, served.client() as client:
        until_told(socket)
        assert client.delete(f"/api/jobs/{job}?within=soon").status_code == 400
        at = time.monotonic()
        assert client.delete(f"/api/jobs/{job}?within=0.2").json()["state"] == "cancelled"
        assert time.monotonic() - at < 1.0


@pytest.mark.parametrize("call, request_", [("die", {"signal": "SIGKILL"}), ("bug", {"zero": 0}), ("nothing", {})])
def test_a_job_that_fails_says_why(served: Bench, call: str, request_: dict[str, Any]) -> None:
    last = to_the_end(served, begun(served, call, request_))[-1]["job"]
    assert last["state"] == "failed"
    assert isinstance(last["outcome"], str)


def test_jobs_of_other_tabs_are_not_there(served: Bench) -> None:
    job = begun(served, "many", {"notes": 1})
    assert cancelled(served, job, "another-tab") == 404
    with served.client("another-tab") as client:
        assert client.get("/api/jobs").json() == []
    for name, tab in ((job, "another-tab"), ("0" * 16, TAB), ("%00", TAB), (job, "")):
        with watching(served, name, tab) as socket, pytest.raises(ConnectionClosed) as caught:
            socket.recv(SLOWEST)
        assert caught.value.rcvd is not None
        assert caught.value.rcvd.code == 4404
        assert caught.value.rcvd.reason


def test_too_many_jobs_are_refused(served: Bench) -> None:
    jobs = [begun(served, "stopped") for _ in range(AT_ONCE)]
    try:
        with served.client("another-tab") as client:
            answer = client.post("/api/jobs", json={"call": "run", "request": {}})
        assert answer.status_code == 429
        assert "running already" in answer.json()["error"]
    finally:
        for job in jobs:
            cancelled(served, job)
    assert to_the_end(served, begun(served, "run"))[-1]["job"]["state"] == "done"


@pytest.mark.parametrize(
    "body",
    [{}, {"call": 1}, {"call": "run", "request": []}, {"call": "run", "request": None}, [], "x", {"call": ["run"]}],
)
def test_a_job_that_is_none(served: Bench, body: Any) -> None:
    with served.client() as client:
        answer = client.post("/api/jobs", json=body)
    assert answer.status_code == 400
    assert answer.json()["error"]


@pytest.mark.parametrize("tab", ["", "abc", "x" * 65, "a b c d", "tab/../x", "täb1"])
def test_a_tab_that_is_none(served: Bench, tab: str) -> None:
    with served.client() as client:
        client.headers = httpx.Headers({**client.headers, "x-tab": tab}, encoding="latin-1")
        answers = [client.get("/api/jobs"), client.post("/api/call/run", json={})]
    assert {answer.status_code for answer in answers} == {400}
    assert "X-Tab" in answers[0].json()["error"]


@pytest.mark.parametrize("sent", ["text", b"\0\xff", "[" * 60_000, "x" * 70_000])
def test_what_comes_over_the_socket_harms_nothing(served: Bench, sent: str | bytes) -> None:
    job = begun(served, "stopped")
    with watching(served, job) as socket:
        for _ in range(20):
            try:
                socket.send(sent)
            except ConnectionClosed:  # a frame that is too long ends it
                assert len(sent) > 2**16
                break
    with watching(served, job) as again:
        assert json.loads(again.recv(SLOWEST))["job"]["state"] == "running"
    cancelled(served, job)


def test_many_sockets_hear_the_same(served: Bench) -> None:
    job = begun(served, "stopped")
    with ExitStack() as stack:
        sockets = [stack.enter_context(watching(served, job)) for _ in range(40)]
        for socket in sockets[::2]:
            socket.socket.shutdown(SHUT_RDWR)  # without a word
        cancelled(served, job)
        for socket in sockets[1::2]:
            last = [json.loads(message) for message in socket][-1]["job"]
            assert last["outcome"] == {"best": "so far"}
    with served.client() as client:
        assert client.get("/api/status").status_code == 200


def alive(pids: list[int]) -> list[int]:
    """Those processes that run."""
    found: list[int] = []
    for pid in pids:
        try:
            state = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0]
        except OSError:
            continue
        found += [pid] if state != "Z" else []
    return found


def below(pid: int) -> list[int]:
    """Processes that a process has started, and those that they have."""
    known: dict[int, list[int]] = {}
    for stat in Path("/proc").glob("[0-9]*/stat"):
        try:
            parent = int(stat.read_text().rpartition(")")[2].split()[1])
        except OSError:
            continue
        known.setdefault(parent, []).append(int(stat.parent.name))
    return list(_deep(known, pid))


def _deep(known: dict[int, list[int]], pid: int) -> Iterator[int]:
    for child in known.get(pid, []):
        yield child
        yield from _deep(known, child)


def ask_in_vain(bench: Bench) -> None:
    """A call that is not answered before the server ends."""
    with bench.client() as client, suppress(httpx.HTTPError):
        assert client.post("/api/call/hang", json={}).status_code >= 500


@pytest.mark.skipif(not Path("/proc").is_dir(), reason="looks into /proc")
@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGHUP, signal.SIGKILL])
def test_nothing_outlives_the_server(tmp_path: Path, number: signal.Signals) -> None:
    with rough(tmp_path, kept=False) as made, ExitStack() as stack:
        for call in ("family", "hang"):
            job = begun(made.bench, call)
            socket = stack.enter_context(watching(made.bench, job))
            until_told(socket)
        asking = Thread(target=ask_in_vain, args=(made.bench,))
        asking.start()
        stack.callback(asking.join)
        # a worker, two of jobs, and what one of them has started
        wait_until(lambda: len(below(made.process.pid)) >= 4)
        started = below(made.process.pid)
        folders = list(tmp_path.glob("martensite-*"))
        assert len(folders) == 1
        made.process.send_signal(number)
        code = made.process.wait(SLOWEST)
        wait_until(lambda: not alive(started))
        assert made.process.stderr
        said = made.process.stderr.read()
        assert "Traceback" not in said, said
    if number is signal.SIGKILL:
        assert code == -9
    else:
        assert code == 0
        assert not folders[0].exists()
