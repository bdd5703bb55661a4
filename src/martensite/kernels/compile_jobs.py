"""Optimised libraries compiled in the background: jobs in the cache folder, and one process that does them.

A job is a file beside the library that it is for, `NAME.job`. The process is detached, of the lowest priority, and
alone in its cache folder by a lock; it ends when no job is left. It writes a library as any other process does, so an
interrupted job leaves nothing that could be loaded. A job that fails leaves `NAME.failed`, and is not tried again.
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
    """Let the optimised library of a source be compiled in the background; without effect where that is impossible.

    Args:
        path: library in the cache.
        source: its C.
        more: flags of the compiler beside the usual ones.
        quick: library that it replaces, which is removed then.
        module: module that does the jobs when it is run.
    """
    if path.with_suffix(FAILED).exists():
        return
    with suppress(OSError):
        job, made = path.with_suffix(JOB), path.with_suffix(f".{os.getpid()}")
        made.write_text(json.dumps({"source": source, "more": list(more), "quick": quick.name}))
        keep_private(made, job)
        with _lock(path.parent) as free:
            idle = free
        if idle:
            _start(path.parent, module)


def _start(folder: Path, module: str) -> None:
    """Start the process; the shell between leaves it to the system, so that nobody has to wait for it."""
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
    """Hold the lock of a folder within the block; False if another process has it."""
    with (folder / LOCK).open("a") as file:
        (folder / LOCK).chmod(0o600)
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            yield False
            return
        yield True


def do_jobs(compile_library: Callable[[Path, str, tuple[str, ...]], None]) -> None:
    """Do all jobs, unless another process does them.

    A job is written before the lock is tried, and jobs are looked for after its release: none is forgotten.

    Args:
        compile_library: compiles the library of a path, a source and more flags; `CompileError` if it cannot.
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
    """Do a job, of this user alone, and remove it."""
    trusted = is_private_file(job)
    try:
        asked = json.loads(job.read_text()) if trusted else None
    finally:
        job.unlink()
    if asked is None:
        return
    path = job.with_suffix(".so")
    try:
        compile_library(path, asked["source"], tuple(asked["more"]))
    except CompileError as error:
        path.with_suffix(FAILED).write_text(str(error))
        return
    for suffix in (".so", ".sha256"):
        path.with_name(asked["quick"]).with_suffix(suffix).unlink(missing_ok=True)
