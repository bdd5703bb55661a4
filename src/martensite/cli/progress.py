"""Progress on standard error, if it is a terminal."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial
from typing import TYPE_CHECKING

if TYPE_CHECKING:
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
def open_bar(label: str, total: float | None, counted: bool = False) -> Iterator[Callable[..., None] | None]:
    """Yield the function that moves a bar with a text and times, and optionally counts; None without a terminal."""
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
    with open_bar(label, None) as move:
        yield move and (lambda done, total: move(completed=done, total=total))


@contextmanager
def show_share(label: str) -> Iterator[Callable[[str, float], None] | None]:
    """A bar, moved by calling what it gives with a sentence and the share that is done."""
    with open_bar(label, 1.0) as move:
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
    with open_bar("fitting", None) as move:
        yield move and (
            lambda note: move(description=describe(note), completed=note.share, total=1.0 if note.share > 0.0 else None)
        )
