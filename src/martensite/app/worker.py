"""Process that answers calls, one after the other; lines of JSON come in and go out.

    in:  {"call": "run", "request": {…}, "folder": "…"}   a call
    in:  {…, "columns": true}                             the answer may be columns
    in:  {"stop": true}                                   end the running call
    out: {"tell": {…}}                                    any number, while it works
    out: {"bytes": 1234}, then so many                    the answer as columns
    out: {"answer": {…}} or {"refused": "a sentence", "kind": "input"}

It ends with its input, even during a call, and ends the processes that it has started. So a worker never outlives the
server. Calls are those of `martensite.app.routes`.
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
from pathlib import Path
from queue import SimpleQueue
from typing import BinaryIO

from martensite.app.messages import JsonTable, Request, describe_refusal, pack_columns, write_message
from martensite.app.routes import find_call

MEMORY = 4 * 2**30
"""Bytes that a worker may hold, threads and what they reserve included."""


@dataclass
class Desk:
    """Environment of a call besides its request."""

    folder: Path
    """Folder of uploaded and new files."""
    tell: Callable[[Request], None] = lambda note: None
    """Sends a note on how far it is."""
    stop: threading.Event = field(default_factory=threading.Event)
    """Set once the work shall end; who can, ends with the best so far."""


class _Lines:
    """Writes messages as lines; from several threads."""

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
"""Calls, each with what tells it to stop."""


def _read_calls(source: BinaryIO, work: _Work) -> None:
    """Put calls on the pile, and end with the input."""
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
    """Let a run that grows without end fail here, before it drives others out of memory."""
    try:
        import resource
    except ModuleNotFoundError:  # Windows
        return
    most = resource.getrlimit(resource.RLIMIT_DATA)[1]
    if most == resource.RLIM_INFINITY or most > MEMORY:
        with suppress(ValueError, OSError):
            resource.setrlimit(resource.RLIMIT_DATA, (MEMORY, most))


def _open_streams() -> tuple[BinaryIO, BinaryIO]:
    """Return the input and output of the messages; what prints elsewhere goes to standard error."""
    source, out = os.fdopen(os.dup(0), "rb"), os.fdopen(os.dup(1), "wb")
    nothing = os.open(os.devnull, os.O_RDONLY)
    os.dup2(nothing, 0)
    os.dup2(2, 1)
    return source, out


def main() -> None:
    """Answer calls until the input ends."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is for the server
    source, out = _open_streams()
    work, lines = _Work(), _Lines(out)
    threading.Thread(target=_read_calls, args=(source, work), daemon=True).start()
    limit_memory()
    find_call("run")  # before the first call, that it be quick
    while True:
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
            said = describe_refusal(error)
            if said["refused"].startswith("Unexpected"):
                traceback.print_exc(file=sys.stderr)
            lines.send(said)


if __name__ == "__main__":
    main()
