"""Workers of the server: processes that are called, stopped, and replaced if they die."""

from __future__ import annotations

import asyncio
import contextlib
import json
import os
import signal
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Any

from martensite.app.messages import JsonTable, PackedColumns, Refusal, WorkerJson, write_message
from martensite.base.child_python import python_command, python_environment

COMMAND = tuple(python_command("-m", "martensite.app.worker"))
LONGEST_LINE = 64 * 2**20
QUICK_LIMIT = 60.0
"""Time limit of a quick call [s]."""
STOP_LIMIT = 5.0
"""Time limit of a requested stop [s]."""

ANSWER = b'{"answer":'
LONG_ANSWER = 2**16
"""Size from which an answer is passed on unparsed [bytes]."""
LOOKED_AFTER = 1.0
"""Interval of checks on a silent process [s]."""
LOST_SENTENCE = (
    "The process that computed this ended unexpectedly (out of memory?); try a shorter run or fewer samples."
)
STOPPED_SENTENCE = "Cancelled. The previous results are shown."
GARBLED_SENTENCE = "The process that computed this gave an answer that cannot be read. Please report it."

Tell = Callable[[JsonTable], None]


class Worker:
    """One process; it handles one call at a time."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self._process: asyncio.subprocess.Process | None = None
        self._stopped = False

    async def start(self) -> asyncio.subprocess.Process:
        """Return the running process, or a new one."""
        if self._process is not None and self._process.returncode is not None:
            await self.kill()  # child processes may continue
        if self._process is None:
            self._process = await asyncio.create_subprocess_exec(
                *COMMAND,
                env=python_environment(),
                start_new_session=True,
                stdin=asyncio.subprocess.PIPE,
                stdout=asyncio.subprocess.PIPE,
                limit=LONGEST_LINE,
            )
        return self._process

    async def ask(self, call: str, request: JsonTable, tell: Tell | None = None, columns: bool = False) -> Any:
        """Return the answer to a call; `PackedColumns` if it can be columns.

        Raises:
            Refusal: the call was refused or failed, or the process died.
        """
        try:
            process = await self.start()
            message = {"call": call, "request": request, "folder": str(self.folder), "columns": columns}
            await _write_line(process, message)
            if self._stopped:  # before its start
                await _write_line(process, {"stop": True})
            while True:
                reply: JsonTable = _parse_line(await _read_line(process))
                if "bytes" in reply:
                    reply = {"answer": await _read_bytes(process, reply["bytes"])}
                if "tell" not in reply:
                    break
                if tell is not None:
                    tell(reply["tell"])
        except OSError as error:
            await self.kill()
            raise Refusal(f"No process could be started: {error}.", 500, "lost") from None
        except BaseException:  # a late answer must not reach the next call
            await self.kill()
            raise
        return _take_answer(reply)

    async def stop(self) -> None:
        """Request the end of the running call."""
        self._stopped = True
        if self._process is not None and self._process.returncode is None:
            with contextlib.suppress(ConnectionError):
                await _write_line(self._process, {"stop": True})

    async def kill(self) -> None:
        """End the process and its child processes."""
        process, self._process, self._stopped = self._process, None, False
        if process is None:
            return
        with contextlib.suppress(ProcessLookupError, PermissionError):
            if hasattr(os, "killpg"):
                os.killpg(process.pid, signal.SIGKILL)
            else:
                process.kill()
        try:
            with contextlib.suppress(TimeoutError):
                await asyncio.wait_for(process.wait(), STOP_LIMIT)
        finally:  # waiting calls can be cancelled at the end of the server
            # asyncio does not close it while other processes hold the pipes
            transport = getattr(process, "_transport", None)
            if transport is not None:
                transport.close()


async def _write_line(process: asyncio.subprocess.Process, message: JsonTable) -> None:
    pipe = process.stdin
    if pipe is not None:
        pipe.write(write_message(message) + b"\n")
        with contextlib.suppress(ConnectionError):
            await pipe.drain()


async def _read_line(process: asyncio.subprocess.Process) -> bytes:
    """Return the next line; empty after the end of the process."""
    if process.stdout is None:
        return b""
    reading = asyncio.ensure_future(process.stdout.readline())
    try:
        while not (await asyncio.wait({reading}, timeout=LOOKED_AFTER))[0]:
            if process.returncode is not None:  # its child processes keep its output open
                return b""
        return reading.result()
    except ValueError:
        raise Refusal("The answer is too long to be shown.", 422, "failed") from None
    finally:
        reading.cancel()


async def _read_bytes(process: asyncio.subprocess.Process, count: int) -> PackedColumns:
    try:
        if process.stdout is None or not 0 <= count <= LONGEST_LINE:
            raise Refusal("The answer is too long to be shown.", 422, "failed")
        return PackedColumns(await process.stdout.readexactly(count))
    except asyncio.IncompleteReadError:
        raise Refusal(LOST_SENTENCE, 500, "lost") from None


def _parse_line(line: bytes) -> JsonTable:
    """Return the content of a line of a worker."""
    if not line.endswith(b"\n"):
        raise Refusal(LOST_SENTENCE, 500, "lost")
    if len(line) > LONG_ANSWER and line.startswith(ANSWER) and line.endswith(b"}\n"):
        return {"answer": WorkerJson(line[len(ANSWER) : -2])}
    try:
        message = json.loads(line)
        if "bytes" in message:
            return {"bytes": int(message["bytes"])}
        if "tell" in message or "answer" in message or (message["refused"] and message["kind"]):
            return message
    except (ValueError, TypeError, LookupError):
        pass
    raise Refusal(GARBLED_SENTENCE, 500, "lost")


def _take_answer(reply: JsonTable) -> Any:
    if "refused" in reply:
        status = 400 if reply["kind"] == "input" else 422
        raise Refusal(reply["refused"], status, reply["kind"])
    return reply["answer"]


@dataclass
class WorkerPool:
    """Workers for quick calls; a newer call of a lane replaces a waiting one."""

    folder: Path
    size: int = 2
    quick: float = QUICK_LIMIT
    """Time limit of a call [s]."""
    idle: list[Worker] = field(default_factory=list[Worker])
    """Idle workers; the last one used, with its compiled programs, is the next."""
    waiting: dict[str, asyncio.Future[Worker]] = field(default_factory=dict[str, "asyncio.Future[Worker]"])
    """Waiting calls by lane, in order."""
    workers: list[Worker] = field(default_factory=list[Worker])
    running: dict[asyncio.Task[Any], str] = field(default_factory=dict["asyncio.Task[Any]", str])
    """Lanes of running calls."""
    notes: dict[str, JsonTable] = field(default_factory=dict[str, JsonTable])
    """Last progress note of the running call, by lane."""
    _anonymous: int = 0

    async def warm(self) -> None:
        """Start a first worker in advance."""
        worker = self._new()
        await worker.start()
        self._free(worker)

    async def ask(self, lane: str, call: str, request: JsonTable, columns: bool = False) -> Any:
        """Return the answer to a quick call; a newer call of the same lane replaces a waiting one.

        Raises:
            Refusal: it was refused, failed, timed out, was cancelled, or replaced.
        """
        worker = await self._worker(lane)
        tell = partial(self.notes.__setitem__, lane) if lane else None
        task = asyncio.ensure_future(worker.ask(call, request, tell, columns))
        self.running[task] = lane
        try:
            return await asyncio.wait_for(task, self.quick)
        except asyncio.CancelledError:
            if task in self.running:
                raise
            raise Refusal(STOPPED_SENTENCE, 409, "stopped") from None
        except TimeoutError:
            raise Refusal(
                f"This took longer than {self.quick:g} s and was given up; make the run shorter or "
                "its tolerance larger.",
                422,
                "failed",
            ) from None
        finally:
            self.running.pop(task, None)
            self.notes.pop(lane, None)
            self._free(worker)

    def cancel(self, lane: str) -> bool:
        """End the running calls of a lane by force; return whether there were any."""
        entries = [task for task, of in self.running.items() if of == lane]
        for task in entries:
            del self.running[task]
            task.cancel()
        return bool(entries)

    async def close(self) -> None:
        """End all workers."""
        for worker in self.workers:
            await worker.kill()

    def _new(self) -> Worker:
        worker = Worker(self.folder)
        self.workers.append(worker)
        return worker

    async def _worker(self, lane: str) -> Worker:
        if self.idle:
            return self.idle.pop()
        if len(self.workers) < self.size:
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
        while self.waiting:
            first = next(iter(self.waiting))
            future = self.waiting.pop(first)
            if not future.done():
                future.set_result(worker)
                return
        self.idle.append(worker)
