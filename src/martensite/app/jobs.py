"""Long work: each job in a separate process, with progress notes, until it is stopped.

A job belongs to a browser tab and survives a reload: the returning page receives past notes, then new ones.
"""

from __future__ import annotations

import asyncio
import json
import secrets
import time
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from martensite.app.messages import JsonTable, Refusal, WorkerJson, describe_refusal
from martensite.app.worker_pool import STOP_LIMIT, Worker

AT_ONCE = 4
MOST_KEPT = 20
"""Stored finished jobs."""
LONGEST_TRAIL = 400
"""Stored notes of a job; above this number each second one is dropped."""


@dataclass(eq=False)
class PageJob:
    """One piece of long work."""

    tab: str
    call: str
    request: JsonTable
    worker: Worker
    id: str = field(default_factory=lambda: secrets.token_hex(8))
    state: str = "running"
    """running, done, failed, or cancelled."""
    began: float = field(default_factory=time.time)
    end_time: float | None = None
    trail: list[JsonTable] = field(default_factory=list[JsonTable])
    """Past notes, thinned."""
    last: JsonTable | None = None
    outcome: Any = None
    """The answer, or the sentence of a refusal."""
    listeners: set[asyncio.Queue[JsonTable]] = field(default_factory=set["asyncio.Queue[JsonTable]"])
    task: asyncio.Task[None] | None = None

    def summary(self) -> JsonTable:
        """Return the job without its notes and outcome."""
        return {
            "id": self.id,
            "call": self.call,
            "state": self.state,
            "began": self.began,
            "ended": self.end_time,
            "last": self.last,
        }

    def whole(self) -> JsonTable:
        """Return the job with request, notes and outcome."""
        return {**self.summary(), "request": self.request, "trail": self.trail, "outcome": self.outcome}

    def add_note(self, note: JsonTable) -> None:
        """Store a note and pass it on."""
        self.last = note
        self.trail.append(note)
        if len(self.trail) > LONGEST_TRAIL:
            del self.trail[1:-1:2]
        self._send({"note": note})

    def end(self, state: str, outcome: Any) -> None:
        """Record the end and the outcome of the job."""
        self.state, self.outcome, self.end_time = state, outcome, time.time()
        self._send({"job": self.whole()})

    def _send(self, message: JsonTable) -> None:
        for queue in self.listeners:
            if queue.full():  # slow listeners get all notes again
                while not queue.empty():
                    queue.get_nowait()
                message = {"job": self.whole()}
            queue.put_nowait(message)

    @asynccontextmanager
    async def listening(self) -> AsyncIterator[asyncio.Queue[JsonTable]]:
        """Return a queue of the present state, new notes and the end."""
        queue: asyncio.Queue[JsonTable] = asyncio.Queue(64)
        queue.put_nowait({"job": self.whole()})
        self.listeners.add(queue)
        try:
            yield queue
        finally:
            self.listeners.discard(queue)


@dataclass
class PageJobs:
    """All jobs of a server."""

    folder: Path
    jobs_by_id: dict[str, PageJob] = field(default_factory=dict[str, PageJob])

    def begin(self, tab: str, call: str, request: JsonTable) -> PageJob:
        """Begin a job."""
        running = [job for job in self.jobs_by_id.values() if job.state == "running"]
        if len(running) >= AT_ONCE:
            raise Refusal(f"{AT_ONCE} jobs are running already; wait for one to end, or cancel one.", 429)
        job = PageJob(tab, call, request, Worker(self.folder))
        self.jobs_by_id[job.id] = job
        job.task = asyncio.create_task(self._work(job))
        self._forget()
        return job

    def of(self, tab: str) -> list[PageJob]:
        """Return the jobs of a tab, the newest first."""
        return [job for job in reversed(self.jobs_by_id.values()) if job.tab == tab]

    def find(self, tab: str, name: str) -> PageJob:
        """Return a job of a tab."""
        job = self.jobs_by_id.get(name)
        if job is None or job.tab != tab:
            raise Refusal("There is no such job here; it may be long over.", 404)
        return job

    async def cancel(self, job: PageJob, grace: float = STOP_LIMIT) -> None:
        """Stop a job by a request, then by force after `grace` seconds."""
        if job.state != "running" or job.task is None:
            return
        await job.worker.stop()
        await asyncio.wait([job.task], timeout=grace)
        if job.state == "running":
            job.end("cancelled", "Cancelled.")
            job.task.cancel()
        await job.worker.kill()

    async def close(self) -> None:
        """End all jobs at once."""
        tasks = [job.task for job in self.jobs_by_id.values() if job.task is not None]
        for task in tasks:
            task.cancel()
        await asyncio.gather(*tasks, return_exceptions=True)

    async def _work(self, job: PageJob) -> None:
        try:
            answer = await job.worker.ask(job.call, job.request, job.add_note)
            job.end("done", json.loads(answer) if isinstance(answer, WorkerJson) else answer)
        except Refusal as refusal:
            state = "cancelled" if refusal.kind == "stopped" else "failed"
            if job.state == "running":
                job.end(state, str(refusal))
        except Exception as error:
            job.end("failed", describe_refusal(error)["refused"])
            raise
        finally:
            await job.worker.kill()

    def _forget(self) -> None:
        over = [job.id for job in self.jobs_by_id.values() if job.state != "running"]
        for name in over[: max(0, len(over) - MOST_KEPT)]:
            del self.jobs_by_id[name]
