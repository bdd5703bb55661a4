"""Connections that hold the bench without asking anything: closed in time, whoever asks is answered.

Source of truth: a server with the protocol of the bench and a short time to wait, beside a client that does
ask; and the bench itself, as it is started.
"""

import asyncio
import socket
import time
from collections.abc import Awaitable, Callable
from contextlib import suppress
from pathlib import Path
from typing import Any

import pytest
import uvicorn
from app_server import running

from martensite.app import request_guard
from martensite.app.request_guard import REQUEST_WAIT, TimedProtocol

WAIT = 0.3
HEAD = b"GET / HTTP/1.1\r\nHost: here\r\n"
Client = Callable[[asyncio.StreamReader, asyncio.StreamWriter], Awaitable[float]]


async def answer_slowly(scope: Any, receive: Any, send: Any) -> None:
    """An answer that takes longer than a request may."""
    await asyncio.sleep(3 * WAIT)
    await send({"type": "http.response.start", "status": 200, "headers": [(b"content-length", b"2")]})
    await send({"type": "http.response.body", "body": b"ok"})


def ask(client: Client, monkeypatch: pytest.MonkeyPatch) -> float:
    """What a client finds on a server of its own."""
    monkeypatch.setattr(request_guard, "REQUEST_WAIT", WAIT)

    async def run() -> float:
        config = uvicorn.Config(answer_slowly, http=TimedProtocol, lifespan="off", log_level="error")
        config.load()
        state = uvicorn.Server(config).server_state
        server = await asyncio.get_running_loop().create_server(
            lambda: TimedProtocol(config, state, {}), "127.0.0.1", 0
        )
        async with server:
            reader, writer = await asyncio.open_connection(*server.sockets[0].getsockname())
            try:
                return await asyncio.wait_for(client(reader, writer), 20 * WAIT)
            finally:
                writer.close()

    return asyncio.run(run())


async def measure_patience(reader: asyncio.StreamReader) -> float:
    """Seconds until the server closes the connection."""
    begun = time.monotonic()
    with suppress(ConnectionError):
        assert await reader.read() == b""
    return time.monotonic() - begun


@pytest.mark.parametrize("sent", [b"", b"GE", HEAD], ids=["nothing", "half a word", "half a head"])
def test_who_asks_nothing_is_sent_away(sent: bytes, monkeypatch: pytest.MonkeyPatch) -> None:
    async def be_silent(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> float:
        writer.write(sent)
        return await measure_patience(reader)

    assert 0.5 * WAIT < ask(be_silent, monkeypatch) < 5 * WAIT


def test_bytes_one_by_one_do_not_prolong_it(monkeypatch: pytest.MonkeyPatch) -> None:
    async def trickle(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> float:
        closed = asyncio.create_task(measure_patience(reader))
        for byte in HEAD * 10:
            if closed.done():
                break
            writer.write(bytes([byte]))
            await asyncio.sleep(WAIT / 10)
        return await closed

    assert ask(trickle, monkeypatch) < 5 * WAIT


def test_a_second_request_that_never_ends_is_given_up(monkeypatch: pytest.MonkeyPatch) -> None:
    async def ask_and_stop(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> float:
        writer.write(HEAD + b"\r\n")
        assert (await reader.readuntil(b"ok")).startswith(b"HTTP/1.1 200")
        writer.write(HEAD)
        return await measure_patience(reader)

    assert ask(ask_and_stop, monkeypatch) < 5 * WAIT


def test_a_long_answer_is_waited_for(monkeypatch: pytest.MonkeyPatch) -> None:
    async def be_patient(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> float:
        begun = time.monotonic()
        writer.write(HEAD + b"\r\n")
        assert (await reader.readuntil(b"ok")).startswith(b"HTTP/1.1 200")
        return time.monotonic() - begun

    assert ask(be_patient, monkeypatch) > 2 * WAIT


@pytest.mark.slow
def test_the_bench_closes_what_holds_it(tmp_path: Path) -> None:
    with running(tmp_path) as bench:
        held = [socket.create_connection(("127.0.0.1", bench.port)) for _ in range(100)]
        with bench.client() as client:
            assert client.get("/api/status").status_code == 200
        end = time.monotonic() + REQUEST_WAIT + 10.0
        for one in held:
            one.settimeout(max(end - time.monotonic(), 0.1))
            with one, suppress(ConnectionError):
                assert one.recv(1) == b""
