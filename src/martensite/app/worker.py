"""Process that answers calls in sequence; lines of JSON come in and go out.

    in:  {"call": "run", "request": {…}, "folder": "…"}   a call
    in:  {…, "columns": true}                             the answer can be columns
    in:  {"stop": true}                                   end the running call
    out: {"tell": {…}}                                    any number of notes
    out: {"bytes": 1234}, then as many                    the answer as columns
    out: {"answer": {…}} or {"refused": "a sentence", "kind": "input"}

It ends with its input, even during a call, with all its child processes, so a worker never outlives the server. Calls
are those of `martensite.app.routes`.
"""

from __future__ import annotations

import json
import os
import signal
import sys
import threading
import traceback
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from queue import SimpleQueue
from typing import BinaryIO

from martensite.app.messages import JsonTable, Request, describe_refusal, pack_columns, write_message
from martensite.app.routes import find_call
from martensite.app.uploads import UploadFolder

MEMORY = 4 * 2**30
"""Memory limit of a worker [bytes]."""


@dataclass
class Desk:
    """Environment of a call in addition to its request."""

    folder: Path
    """Folder of uploaded and new files."""
    tell: Callable[[Request], None] = lambda note: None
    """Function that sends a progress note."""
    stop: threading.Event = field(default_factory=threading.Event)
    """Set to end the work, if possible with the best result so far."""

    @property
    def files(self) -> UploadFolder:
        """Return the uploaded and new files."""
        return UploadFolder(self.folder)


class _Lines:
    """Thread-safe writer of messages as lines."""

    def __init__(self, out: BinaryIO) -> None:
        self._out, self._lock = out, threading.Lock()

    def send(self, message: Request) -> None:
        with self._lock:
            self._out.write(write_message(message) + b"\n")
            self._out.flush()

    def send_columns(self, answer: Request) -> None:
        packed = pack_columns(answer)
        with self._lock:
            self._out.write(write_message({"bytes": len(packed)}) + b"\n" + packed)
            self._out.flush()


_Work = SimpleQueue[tuple[JsonTable, threading.Event]]
"""Calls, each with its stop event."""


def _read_calls(source: BinaryIO, work: _Work) -> None:
    """Queue calls, and end the process with the input."""
    stop = threading.Event()
    for line in source:
        message = json.loads(line)
        if message.get("stop"):
            stop.set()
        else:
            stop = threading.Event()
            work.put((message, stop))
    if hasattr(os, "killpg") and os.getpgid(0) == os.getpid():
        os.killpg(0, signal.SIGKILL)
    os._exit(0)


def limit_memory() -> None:
    """Limit the memory of this process, so that an excessive run fails here."""
    try:
        import resource
    except ModuleNotFoundError:  # Windows
        return
    most = resource.getrlimit(resource.RLIMIT_DATA)[1]
    if most == resource.RLIM_INFINITY or most > MEMORY:
        with suppress(ValueError, OSError):
            resource.setrlimit(resource.RLIMIT_DATA, (MEMORY, most))


def _open_streams() -> tuple[BinaryIO, BinaryIO]:
    """Return the input and output of messages; other output goes to standard error."""
    source, out = os.fdopen(os.dup(0), "rb"), os.fdopen(os.dup(1), "wb")
    nothing = os.open(os.devnull, os.O_RDONLY)
    os.dup2(nothing, 0)
    os.dup2(2, 1)
    return source, out


@cache
def _import_later_calls() -> None:
    """Import what forms and `Live` need, while the page shows the answer before."""
    from martensite.scenario.catalogue import list_registries

    with suppress(Exception):  # the call that needs a faulty part answers with the reason
        find_call("model")
        for registry in list_registries().values():
            registry.names()


def main() -> None:
    """Answer calls until the input ends."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is for the server
    source, out = _open_streams()
    work, lines = _Work(), _Lines(out)
    threading.Thread(target=_read_calls, args=(source, work), daemon=True).start()
    limit_memory()
    find_call("run")  # makes the first call fast
    while True:
        if work.empty():
            _import_later_calls()
        message, stop = work.get()
        desk = Desk(Path(message["folder"]), lambda note: lines.send({"tell": note}), stop)
        try:
            answer = find_call(message["call"])(message["request"], desk)
            if message.get("columns"):
                lines.send_columns(answer)
            else:
                lines.send({"answer": answer})
        except BrokenPipeError:
            return  # the server is gone
        except Exception as error:
            refusal = describe_refusal(error)
            if refusal["refused"].startswith("Unexpected"):
                traceback.print_exc(file=sys.stderr)
            lines.send(refusal)


if __name__ == "__main__":
    main()
