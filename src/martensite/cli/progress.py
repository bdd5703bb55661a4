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
    """Show a spinner."""
    if not sys.stderr.isatty():
        yield
        return
    from rich.console import Console

    with Console(stderr=True).status(label):
        yield


@contextmanager
def open_bar(label: str, total: float | None, counted: bool = False) -> Iterator[Callable[..., None] | None]:
    """Yield the function that moves a bar with text, times and optional counts; None without a terminal."""
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
    """Yield a function that moves a bar by number done and total."""
    with open_bar(label, None) as move:
        yield move and (lambda done, total: move(completed=done, total=total))


@contextmanager
def show_share(label: str) -> Iterator[Callable[[str, float], None] | None]:
    """Yield a function that moves a bar by sentence and share."""
    with open_bar(label, 1.0) as move:
        yield move and (lambda text, share: move(description=text, completed=share))


@contextmanager
def show_run(label: str, quiet: bool) -> Iterator[Callable[[str, float], None] | None]:
    """Yield a function that moves the bar of a run by text and share."""
    if quiet:
        yield None
        return
    with show_share(f"simulating {label}") as tell:
        yield tell and (lambda doing, share: tell(f"{doing} {label}", share))


@contextmanager
def show_search(describe: Callable[[SearchNote], str]) -> Iterator[Tell | None]:
    """Yield a function that moves the bar of a search, with the words of `describe`.

    The remaining time appears once the search reports its share.
    """
    with open_bar("fitting", None) as move:
        yield move and (
            lambda note: move(description=describe(note), completed=note.share, total=1.0 if note.share > 0.0 else None)
        )
