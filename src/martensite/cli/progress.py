"""Signs on standard error that something is being computed, if somebody is looking there."""

from __future__ import annotations

import signal
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from rich.progress import Progress

    from martensite.design.sweep.running import Progress as Swept
    from martensite.fit.search_monitor import SearchNote, Tell


@contextmanager
def end_on_signals() -> Iterator[None]:
    """SIGTERM ends what is computed as Ctrl-C does: the best so far is kept."""

    def interrupt(number: int, frame: object) -> None:
        raise KeyboardInterrupt

    before = signal.signal(signal.SIGTERM, interrupt)
    try:
        yield
    finally:
        signal.signal(signal.SIGTERM, before)


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
def _open_bar(*columns: Any) -> Iterator[Progress | None]:
    """A bar with a text, times, and other columns between; None if nobody is looking."""
    if not sys.stderr.isatty():
        yield None
        return
    from rich.console import Console
    from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn
    from rich.progress import TimeRemainingColumn as Left

    own = (TextColumn("{task.description}"), BarColumn(), *columns, TimeElapsedColumn(), Left())
    with Progress(*own, console=Console(stderr=True), transient=True) as bar:
        yield bar


@contextmanager
def show_progress(label: str) -> Iterator[Callable[[int, int], None] | None]:
    """A bar, moved by calling what it gives with the number done and the total."""
    with _open_bar() as bar:
        if bar is None:
            yield None
            return
        task = bar.add_task(label, total=None)
        yield lambda done, total: bar.update(task, completed=done, total=total)


@contextmanager
def show_share(label: str) -> Iterator[Callable[[str, float], None] | None]:
    """A bar, moved by calling what it gives with a sentence and the share that is done."""
    with _open_bar() as bar:
        if bar is None:
            yield None
            return
        task = bar.add_task(label, total=1.0)
        yield lambda text, share: bar.update(task, description=text, completed=share)


@contextmanager
def show_run(label: str, quiet: bool) -> Iterator[Callable[[str, float], None] | None]:
    """A bar for a run, moved by calling what it gives with what is done, and its share."""
    if quiet:
        yield None
        return
    with show_share(f"simulating {label}") as tell:
        yield None if tell is None else lambda doing, share: tell(f"{doing} {label}", share)


@contextmanager
def show_search(describe: Callable[[SearchNote], str]) -> Iterator[Tell | None]:
    """A bar for a search, with the words that `describe` finds for what it tells.

    The time left is shown once a search can say how much of it is done.
    """
    with _open_bar() as bar:
        if bar is None:
            yield None
            return
        task = bar.add_task("fitting", total=None)

        def tell(note: SearchNote) -> None:
            total = 1.0 if note.share > 0.0 else None
            bar.update(task, description=describe(note), completed=note.share, total=total)

        yield tell


@contextmanager
def show_sweep(label: str) -> Iterator[Callable[[Swept], None] | None]:
    """A bar for a sweep, with its rate and what failed."""
    if not sys.stderr.isatty():
        yield None
        return
    from rich.progress import MofNCompleteColumn, TextColumn

    with _open_bar(MofNCompleteColumn(), TextColumn("{task.fields[rate]}")) as bar:
        if bar is None:
            yield None
            return
        task = bar.add_task(label, total=None, rate="")

        def tell(now: Swept) -> None:
            bar.update(task, total=now.runs, completed=now.done, rate=_write_rate(now, bar.tasks[0]))

        yield tell


def _write_rate(now: Swept, task: Any) -> str:
    """Runs per second, and how many failed."""
    failed = sum(count for status, count in now.status.items() if status > 1)
    speed = "" if not task.elapsed or not now.made else f"{now.made / task.elapsed:.0f}/s"
    return f"{speed}, {failed} failed" if failed else speed
