"""Signs on standard error that something is being computed, if somebody is looking there."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from martensite.design.sweep.api import Progress as Swept
    from martensite.fit.search_monitor import SearchNote, Tell


@contextmanager
def show_spinner(label: str) -> Iterator[None]:
    """A moving sign."""
    if not sys.stderr.isatty():
        yield
        return
    from rich.console import Console

    with Console(stderr=True).status(label):
        yield


@contextmanager
def _open_bar(label: str, total: float | None, counted: bool = False) -> Iterator[Callable[..., None] | None]:
    """What moves a bar with a text and times, and counts if wanted; None if nobody is looking."""
    if not sys.stderr.isatty():
        yield None
        return
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn
    from rich.progress import TimeRemainingColumn as Left

    counts = (MofNCompleteColumn(), TextColumn("{task.fields[rate]}")) if counted else ()
    own = (TextColumn("{task.description}"), BarColumn(), *counts, TimeElapsedColumn(), Left())
    with Progress(*own, console=Console(stderr=True), transient=True) as bar:
        yield partial(bar.update, bar.add_task(label, total=total, rate=""))


@contextmanager
def show_progress(label: str) -> Iterator[Callable[[int, int], None] | None]:
    """A bar, moved by calling what it gives with the number done and the total."""
    with _open_bar(label, None) as move:
        yield move and (lambda done, total: move(completed=done, total=total))


@contextmanager
def show_share(label: str) -> Iterator[Callable[[str, float], None] | None]:
    """A bar, moved by calling what it gives with a sentence and the share that is done."""
    with _open_bar(label, 1.0) as move:
        yield move and (lambda text, share: move(description=text, completed=share))


@contextmanager
def show_run(label: str, quiet: bool) -> Iterator[Callable[[str, float], None] | None]:
    """A bar for a run, moved by calling what it gives with what is done, and its share."""
    if quiet:
        yield None
        return
    with show_share(f"simulating {label}") as tell:
        yield tell and (lambda doing, share: tell(f"{doing} {label}", share))


@contextmanager
def show_search(describe: Callable[[SearchNote], str]) -> Iterator[Tell | None]:
    """A bar for a search, with the words that `describe` finds for what it tells.

    The time left is shown once a search can say how much of it is done.
    """
    with _open_bar("fitting", None) as move:
        yield move and (
            lambda note: move(description=describe(note), completed=note.share, total=1.0 if note.share > 0.0 else None)
        )


@contextmanager
def show_sweep(label: str) -> Iterator[Callable[[Swept], None] | None]:
    """A bar for a sweep, with its rate and what failed."""
    begun = time.monotonic()
    with _open_bar(label, None, counted=True) as move:
        yield move and (
            lambda now: move(total=now.runs, completed=now.done, rate=_write_rate(now, time.monotonic() - begun))
        )


def _write_rate(now: Swept, elapsed: float) -> str:
    failed = sum(count for status, count in now.status.items() if status > 1)
    speed = "" if not elapsed or not now.made else f"{now.made / elapsed:.0f}/s"
    return f"{speed}, {failed} failed" if failed else speed
