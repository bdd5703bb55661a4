"""Addresses of the bench.

    GET  /                      the page; other paths below it are its scripts and styles
    POST /api/call/NAME         a quick call: request and answer in JSON; columns of numbers as binary
                                (`messages.pack_columns`) for clients that accept them
    GET  /api/lane              progress of the running quick call of the lane, or null
    DELETE /api/lane            end the running quick call of the lane
    POST /api/jobs              begin long work: {"call": …, "request": …} -> the job
    GET  /api/jobs              the jobs of this tab
    DELETE /api/jobs/ID         cancel it; by force after `?within=` seconds, at most 5
    WS   /api/jobs/ID/watch     its past notes, then new notes, then its end
    POST /api/files?name=…      upload the body -> its key
    GET  /api/files/KEY         download a file

Header `X-Tab` names the browser tab (or `?tab=` of a socket), `X-Lane` the lane in which a newer call replaces an older
one. A refusal is `{"error": "a sentence", "kind": "input"}` with an error status. A request with `X-Quietly: 1` gets
the status 200, and the error status in `X-Refused`.
"""

from __future__ import annotations

import asyncio
import mimetypes
import os
import re
import time
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager, suppress
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path
from typing import Any

from starlette.applications import Starlette
from starlette.middleware import Middleware
from starlette.middleware.gzip import GZipMiddleware
from starlette.requests import ClientDisconnect, Request
from starlette.responses import FileResponse, Response
from starlette.routing import Mount, Route, WebSocketRoute
from starlette.staticfiles import StaticFiles
from starlette.types import ASGIApp
from starlette.websockets import WebSocket, WebSocketDisconnect

from martensite.app import messages
from martensite.app.jobs import PageJob, PageJobs
from martensite.app.messages import BadMessageError, Refusal, describe_refusal, read_message, require_entry
from martensite.app.request_guard import RequestGuard, json_response, refusal_response
from martensite.app.uploads import UploadFolder
from martensite.app.worker_pool import STOP_LIMIT, WorkerPool
from martensite.base.errors import InputError

STATIC = Path(os.environ.get("MARTENSITE_STATIC", Path(__file__).parent / "static"))
"""The bundled page; developers of the page can name another build."""
WIDGET, NOTEBOOK = "widget.js", "notebook.js"
"""Widget of a notebook, and its first module; the page loads neither."""
QUIETLY = "x-quietly"
PAGE_FIRST = 0.5
"""Delay before a new server starts workers, in favour of the page [s]."""
COMPRESSED = [Middleware(GZipMiddleware, minimum_size=1400, compresslevel=4)]
"""Compression of answers longer than a packet; downloads are not compressed."""
LASTING = re.compile(r".*-[0-9A-Z]{8}\.js|icon\.svg")
"""Files that browsers need not ask for again: their names follow from their content, or they never change."""
_TAB = re.compile(r"[0-9A-Za-z-]{4,64}")
SWALLOWED, PATIENCE = 2**30, 20.0
"""Largest number of discarded bytes of a refused upload, and largest time for them [s].

Browsers read the answer only after they have sent all.
"""
for _ending, _type in ((".js", "text/javascript"), (".css", "text/css"), (".svg", "image/svg+xml")):
    mimetypes.add_type(_type, _ending)  # on Windows others may have changed them


class PageFiles(StaticFiles):
    """The files of the page."""

    def file_response(self, full_path: str | os.PathLike[str], *arguments: Any, **options: Any) -> Response:
        """Return a file; browsers keep the lasting ones."""
        response = super().file_response(full_path, *arguments, **options)
        if LASTING.fullmatch(Path(full_path).name):
            response.headers["Cache-Control"] = "private, max-age=31536000, immutable"
        return response


@dataclass(frozen=True)
class Site:
    """Shared state of the addresses."""

    pool: WorkerPool
    jobs: PageJobs
    drawer: UploadFolder

    async def call(self, request: Request) -> Response:
        """Answer a quick call."""
        lane = _read_lane(request)
        message = read_message(await _read_body(request))
        columns = messages.COLUMNS_TYPE in request.headers.get("accept", "")
        try:
            return json_response(await self.pool.ask(lane, request.path_params["name"], message, columns))
        except asyncio.CancelledError:
            raise Refusal("The bench is ending.", 503, "lost") from None

    async def show_call(self, request: Request) -> Response:
        """Return the last progress note of the running quick call of a lane."""
        return json_response(self.pool.notes.get(_read_lane(request)))

    async def stop_call(self, request: Request) -> Response:
        """End the running quick call of a lane."""
        return json_response({"stopped": self.pool.cancel(_read_lane(request))})

    async def begin(self, request: Request) -> Response:
        """Begin a job."""
        message = read_message(await _read_body(request))
        call, job_request = (require_entry(message, "call", str), require_entry(message, "request", dict, {}))
        job = self.jobs.begin(_read_tab(request.headers.get("x-tab")), call, job_request)
        return json_response(job.summary(), 201)

    async def list_jobs(self, request: Request) -> Response:
        """Return the jobs of a tab."""
        jobs = self.jobs.of(_read_tab(request.headers.get("x-tab")))
        return json_response([job.summary() for job in jobs])

    async def cancel(self, request: Request) -> Response:
        """Cancel a job."""
        job = self.jobs.find(_read_tab(request.headers.get("x-tab")), request.path_params["id"])
        await self.jobs.cancel(job, _read_grace(request.query_params.get("within")))
        return json_response(job.summary())

    async def watch(self, socket: WebSocket) -> None:
        """Send the notes of a job until it ends; messages of the page are ignored."""
        try:
            job = self.jobs.find(_read_tab(socket.query_params.get("tab")), socket.path_params["id"])
        except (Refusal, InputError) as error:
            await socket.accept()
            await socket.close(4404, str(error)[:120])
            return
        await socket.accept()
        tasks = [asyncio.create_task(work) for work in (_send_notes(job, socket), _await_leaving(socket))]
        try:
            await asyncio.wait(tasks, return_when=asyncio.FIRST_COMPLETED)
        finally:
            for task in tasks:
                task.cancel()
            await asyncio.gather(*tasks, return_exceptions=True)

    async def upload(self, request: Request) -> Response:
        """Store an uploaded file."""
        name = request.query_params.get("name", "")
        if not name:
            raise Refusal("An upload needs `?name=`, what the file is called.")
        stream = request.stream()
        try:
            key, path = await self.drawer.take(name, stream)
        except Refusal:
            await _drain_stream(stream)
            raise
        return json_response({"key": key, "name": path.name, "bytes": path.stat().st_size}, 201)

    async def download(self, request: Request) -> Response:
        """Return a stored file."""
        path = self.drawer.path(request.path_params["key"])
        return FileResponse(path, filename=path.name, media_type="application/octet-stream")


async def _send_notes(job: PageJob, socket: WebSocket) -> None:
    with suppress(WebSocketDisconnect, RuntimeError):  # the page has left
        async with job.listening() as queue:
            over = False
            while not over:
                message = await queue.get()
                over = message.get("job", {}).get("state", "running") != "running"
                await socket.send_text(messages.write_message(message).decode())
        await socket.close()


async def _await_leaving(socket: WebSocket) -> None:
    """Ignore messages of the page until it leaves."""
    while (await socket.receive())["type"] != "websocket.disconnect":
        pass


def _read_tab(name: str | None) -> str:
    if name is None or not _TAB.fullmatch(name):
        raise BadMessageError("The header `X-Tab` (or `?tab=`) must be 4 to 64 letters or digits.")
    return name


def _read_lane(request: Request) -> str:
    """Return tab and lane of a quick call; empty without a lane."""
    tab, lane = _read_tab(request.headers.get("x-tab")), request.headers.get("x-lane", "")[:64]
    return f"{tab} {lane}" if lane else ""


def _read_grace(words: str | None) -> float:
    if words is None:
        return STOP_LIMIT
    try:
        return min(max(float(words), 0.0), STOP_LIMIT)
    except ValueError:
        raise BadMessageError("`?within=` must be seconds.") from None


async def _read_body(request: Request) -> bytes:
    most, parts, size = messages.MOST_BYTES, list[bytes](), 0
    stream = request.stream()
    async for chunk in stream:
        parts.append(chunk)
        size += len(chunk)
        if size > most:
            parts.clear()
            await _drain_stream(stream)
            raise Refusal(f"The message has more than {most:,} bytes; a scenario needs far fewer.", 413)
    return b"".join(parts)


async def _drain_stream(stream: AsyncIterator[bytes]) -> None:
    size, end = 0, time.monotonic() + PATIENCE
    async for chunk in stream:
        size += len(chunk)
        if size > SWALLOWED or time.monotonic() > end:
            return


async def _warm_later(pool: WorkerPool) -> None:
    await asyncio.sleep(PAGE_FIRST)
    await pool.warm()


async def _answer_status(request: Request) -> Response:
    return json_response({"name": "martensite", "version": version("martensite")})


async def _answer_index(request: Request) -> Response:
    return FileResponse(STATIC / "index.html", media_type="text/html")


async def _answer_refusal(request: Request, error: Exception) -> Response:
    """Return the answer to a refusal.

    The page requests refusals with status 200, since browsers log all others on the console.
    """
    refusal = error if isinstance(error, Refusal) else Refusal(str(error))
    return refusal_response(refusal, quiet=request.headers.get(QUIETLY) == "1")


async def _answer_missing(request: Request, error: Exception) -> Response:
    status = getattr(error, "status_code", 404)
    words = {405: "This address does not take that."}.get(status, "There is nothing at this address.")
    return refusal_response(Refusal(words, status))


async def _answer_failure(request: Request, error: Exception) -> Response:
    return refusal_response(Refusal(describe_refusal(error)["refused"], 500, "failed"))


async def _answer_gone(request: Request, error: Exception) -> Response:
    return Response(status_code=499)


def build_site(folder: Path, token: str, port: int, earlier: frozenset[str] = frozenset()) -> ASGIApp:
    """Return the application.

    Args:
        folder: folder of files.
        token: token of authorised requests.
        port: port of the server.
        earlier: digests of earlier tokens, whose cookies are exchanged.
    """
    shared = Site(WorkerPool(folder), PageJobs(folder), UploadFolder(folder))

    @asynccontextmanager
    async def lifespan(app: Starlette) -> AsyncIterator[None]:
        warming = asyncio.create_task(_warm_later(shared.pool))
        try:
            yield
        finally:
            warming.cancel()
            await shared.jobs.close()
            await shared.pool.close()

    inside = Starlette(
        routes=[
            Route("/", _answer_index),
            Route("/api/status", _answer_status),
            Route("/api/call/{name}", shared.call, methods=["POST"], middleware=COMPRESSED),
            Route("/api/lane", shared.show_call),
            Route("/api/lane", shared.stop_call, methods=["DELETE"]),
            Route("/api/jobs", shared.begin, methods=["POST"]),
            Route("/api/jobs", shared.list_jobs),
            Route("/api/jobs/{id}", shared.cancel, methods=["DELETE"]),
            WebSocketRoute("/api/jobs/{id}/watch", shared.watch),
            Route("/api/files", shared.upload, methods=["POST"]),
            Route("/api/files/{key}", shared.download),
            Mount("/", PageFiles(directory=STATIC), middleware=COMPRESSED),
        ],
        exception_handlers={
            Refusal: _answer_refusal,
            InputError: _answer_refusal,
            404: _answer_missing,
            405: _answer_missing,
            ClientDisconnect: _answer_gone,
            Exception: _answer_failure,
        },
        lifespan=lifespan,
    )
    return RequestGuard(inside, token, port, earlier)
