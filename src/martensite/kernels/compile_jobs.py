"""Background compilation of optimised libraries: job files in the cache folder, and one worker process.

A job is a file `NAME.job` next to its library. The process is detached, has the lowest priority, and holds a lock of
its cache folder; it ends without remaining jobs. It writes a library like any other process, so an interrupted job
leaves no loadable file. A failed job leaves `NAME.failed` and is not repeated.
"""

from __future__ import annotations

import fcntl
import json
import os
import subprocess
from collections.abc import Callable, Generator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path

from martensite.base.caches import is_private_file, keep_private, make_cache
from martensite.base.child_python import python_command, python_environment
from martensite.base.errors import CompileError

LOCK, JOB, FAILED = "background.lock", ".job", ".failed"
LOWEST = "19"
"""Increment of the priority of the process."""


def order_library(path: Path, source: str, more: Sequence[str], quick: Path, module: str) -> None:
    """Order the background compilation of the optimised library of a source; without effect if impossible.

    Args:
        path: library in the cache.
        source: C source.
        more: additional compiler flags.
        quick: library to replace, which is then removed.
        module: module that runs the jobs.
    """
    if path.with_suffix(FAILED).exists():
        return
    with suppress(OSError):
        job, draft = path.with_suffix(JOB), path.with_suffix(f".{os.getpid()}")
        draft.write_text(json.dumps({"source": source, "more": list(more), "quick": quick.name}))
        keep_private(draft, job)
        with _lock(path.parent) as free:
            idle = free
        if idle:
            _start(path.parent, module)


def _start(folder: Path, module: str) -> None:
    """Start the process through a shell, so that no parent must wait for it."""
    command = ["nice", "-n", LOWEST, *python_command("-m", module)]
    nothing = subprocess.DEVNULL
    subprocess.run(
        ["/bin/sh", "-c", '"$@" &', "sh", *command],
        stdin=nothing,
        stdout=nothing,
        stderr=nothing,
        env=python_environment(),
        cwd=folder,
        start_new_session=True,
        check=False,
    )


@contextmanager
def _lock(folder: Path) -> Generator[bool]:
    """Hold the lock of a folder within the block; False if another process holds it."""
    with (folder / LOCK).open("a") as file:
        (folder / LOCK).chmod(0o600)
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            yield False
            return
        yield True


def do_jobs(compile_library: Callable[[Path, str, tuple[str, ...]], None]) -> None:
    """Run all jobs, unless another process does.

    A job is written before the lock is tried, and jobs are checked after its release, so that every job is found.

    Args:
        compile_library: function that compiles the library of a path, a source and flags, `CompileError` on failure.
    """
    with suppress(OSError):
        folder = make_cache("c")
        while any(folder.glob(f"*{JOB}")):
            with _lock(folder) as free:
                if not free:
                    return
                while jobs := sorted(folder.glob(f"*{JOB}"), key=lambda job: job.stat().st_mtime):
                    _do(jobs[0], compile_library)


def _do(job: Path, compile_library: Callable[[Path, str, tuple[str, ...]], None]) -> None:
    """Run a job of this user alone, and remove it."""
    trusted = is_private_file(job)
    try:
        order = json.loads(job.read_text()) if trusted else None
    finally:
        job.unlink()
    if order is None:
        return
    path = job.with_suffix(".so")
    try:
        compile_library(path, order["source"], tuple(order["more"]))
    except CompileError as error:
        path.with_suffix(FAILED).write_text(str(error))
        return
    for suffix in (".so", ".sha256"):
        path.with_name(order["quick"]).with_suffix(suffix).unlink(missing_ok=True)
