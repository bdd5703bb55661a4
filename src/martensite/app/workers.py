"""Workers as the server sees them: processes that are asked, stopped, and replaced if they die."""

from __future__ import annotations

import asyncio
import contextlib
import os
import signal
import sys
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from martensite.app.messages import Refusal, dumps

LONGEST_LINE = 256 * 2**20
QUICK = 60.0
"""Seconds after which a quick call is given up."""
POLITE = 5.0
"""Seconds that a call is given to stop by itself."""

Tell = Callable[[dict[str, Any]], None]


class Worker:
    """One process; it does one thing at a time."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self._process: asyncio.subprocess.Process | None = None

    async def start(self) -> asyncio.subprocess.Process:
        """The process; a new one if there is none or it has ended."""
        if self._process is None or self._process.returncode is not None:
            self._process = await asyncio.create_subprocess_exec(
                sys.executable, "-m", "martensite.app.worker", start_new_session=True,
                stdin=asyncio.subprocess.PIPE, stdout=asyncio.subprocess.PIPE, limit=LONGEST_LINE,
            )  # fmt: skip
        return self._process

    async def ask(self, call: str, request: dict[str, Any], tell: Tell | None = None) -> Any:
        """The answer to a call.

        Raises:
            Refusal: the call was refused or failed, or the process died over it.
        """
        process = await self.start()
        message = {"call": call, "request": request, "folder": str(self.folder)}
        try:
            await _write(process, message)
            while line := await _line(process):
                said = _read(line)
                if "tell" in said:
                    if tell is not None:
                        tell(said["tell"])
                    continue
                return _answer(said)
        except asyncio.CancelledError:  # what it would answer later is not for the next call
            await self.kill()
            raise
        await self.kill()
        raise Refusal(
            "The process that computed this ended unexpectedly (out of memory?); try a shorter "
            "run or fewer samples.", 500, "lost",
        )  # fmt: skip

    async def stop(self) -> None:
        """Ask what is being done to end."""
        if self._process is not None and self._process.returncode is None:
            with contextlib.suppress(ConnectionError):
                await _write(self._process, {"stop": True})

    async def kill(self) -> None:
        """End the process and all that it has started."""
        process, self._process = self._process, None
        if process is None:
            return
        with contextlib.suppress(ProcessLookupError, PermissionError):
            if hasattr(os, "killpg"):
                os.killpg(process.pid, signal.SIGKILL)
            else:
                process.kill()
        await process.wait()


async def _write(process: asyncio.subprocess.Process, message: dict[str, Any]) -> None:
    pipe = process.stdin
    if pipe is not None:
        pipe.write(dumps(message) + b"\n")
        with contextlib.suppress(ConnectionError):
            await pipe.drain()


async def _line(process: asyncio.subprocess.Process) -> bytes:
    """The next line; empty once the process has ended."""
    if process.stdout is None:
        return b""
    try:
        return await process.stdout.readline()
    except ValueError:
        return dumps({"refused": "The answer is too long to be shown.", "kind": "failed"})


def _read(line: bytes) -> dict[str, Any]:
    """A line of a worker, however long."""
    import json

    return json.loads(line)


def _answer(said: dict[str, Any]) -> Any:
    if "refused" in said:
        status = 400 if said["kind"] == "input" else 422
        raise Refusal(said["refused"], status, said["kind"])
    return said["answer"]


@dataclass
class Pool:
    """A few workers for quick calls; who asks anew gives up what he asked and waits for."""

    folder: Path
    size: int = 2
    idle: list[Worker] = field(default_factory=list[Worker])
    """The last used is the next: it remembers what it has compiled."""
    waiting: dict[str, asyncio.Future[Worker]] = field(
        default_factory=dict[str, "asyncio.Future[Worker]"]
    )
    """In the order of asking, by who asks for what."""
    made: list[Worker] = field(default_factory=list[Worker])
    _anonymous: int = 0

    async def warm(self) -> None:
        """Start a first worker, so that the first call need not wait for it."""
        worker = self._new()
        await worker.start()
        self._free(worker)

    async def ask(self, lane: str, call: str, request: dict[str, Any]) -> Any:
        """The answer to a quick call; a newer one of the same lane goes over one that waits.

        Raises:
            Refusal: it was refused, failed, took too long, or a newer one came.
        """
        worker = await self._worker(lane)
        try:
            return await asyncio.wait_for(worker.ask(call, request), QUICK)
        except TimeoutError:
            raise Refusal(
                f"This took longer than {QUICK:g} s and was given up; make the run shorter or its "
                "tolerance larger.", 422, "failed",
            ) from None  # fmt: skip
        finally:
            self._free(worker)

    async def close(self) -> None:
        """End all workers."""
        for worker in self.made:
            await worker.kill()

    def _new(self) -> Worker:
        worker = Worker(self.folder)
        self.made.append(worker)
        return worker

    async def _worker(self, lane: str) -> Worker:
        """An idle worker, or the next that gets idle."""
        if self.idle:
            return self.idle.pop()
        if len(self.made) < self.size:
            return self._new()
        if not lane:
            self._anonymous += 1
            lane = f"#{self._anonymous}"
        older = self.waiting.pop(lane, None)
        if older is not None and not older.done():
            older.set_exception(Refusal("A newer request came.", 409, "superseded"))
        future = self.waiting[lane] = asyncio.get_running_loop().create_future()
        try:
            return await future
        except asyncio.CancelledError:
            if future.done() and not future.cancelled() and future.exception() is None:
                self._free(future.result())
            raise
        finally:
            if self.waiting.get(lane) is future:
                del self.waiting[lane]

    def _free(self, worker: Worker) -> None:
        """Give a worker to who waits longest, or lay it aside."""
        while self.waiting:
            first = next(iter(self.waiting))
            future = self.waiting.pop(first)
            if not future.done():
                future.set_result(worker)
                return
        self.idle.append(worker)
