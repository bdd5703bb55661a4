"""Files that a command writes: checked before it starts, complete or absent afterwards."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from martensite.base.errors import DataError
from martensite.base.interrupts import hold_interrupts, rescue_answer
from martensite.cli.options import FigureFile, Force, Json
from martensite.show.figures.files import FORMATS

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from martensite.base.summary import Summary

DATA = (".nc",)
FIGURE = tuple(f".{name}" for name in FORMATS)


@dataclass(frozen=True)
class Outputs:
    """Where results go; None for what is not wanted."""

    data: Path | None
    figure: Path | None
    profile: Path | None = None
    """A figure of what differs along the element."""

    def paths(self) -> list[Path]:
        """The files that will be written."""
        return [path for path in (self.data, self.figure, self.profile) if path is not None]

    def check(self, force: bool, data: tuple[str, ...] = DATA, option: str = "--force") -> Outputs:
        """Raise `DataError` if a file has a wrong ending, no folder, or is there already.

        Args:
            force: files that are there may be replaced.
            data: endings allowed for the data file.
            option: the one that allows it.
        """
        check_ending(self.data, data)
        check_ending(self.figure, FIGURE)
        check_ending(self.profile, FIGURE)
        for path in self.paths():
            check_folder(path)
            check_absent(path, force, option)
        return self

    def answer(
        self,
        summary: Summary,
        json: bool,
        text: Callable[[], str] | None = None,
        draw: Callable[[], Figure] | None = None,
    ) -> None:
        """Write the text that is wanted and the figure, then print what there is to say."""
        from martensite.show.terminal import print_summary

        self.write(text, draw)
        print_summary(summary, json, self.paths())

    def write(self, text: Callable[[], str] | None = None, draw: Callable[[], Figure] | None = None) -> None:
        """Write the text that is wanted, and the figure."""
        from martensite.show.figures.files import write_figure

        with open_parts(self) as files:
            if files.data is not None and text is not None:
                files.data.write_text(text(), encoding="utf-8", newline="\n")
            if files.figure is not None and draw is not None:
                write_figure(draw(), files.figure)


@dataclass(frozen=True)
class AnswerOptions:
    """A figure beside what is printed, and how."""

    figure: FigureFile = None
    force: Force = False
    json: Json = False

    def check_files(self, data: Path | None = None, *endings: str) -> Outputs:
        """The figure and a data file, which may be written; `DataError` if one may not."""
        return Outputs(data, self.figure).check(self.force, data=endings)


def check_ending(path: Path | None, endings: tuple[str, ...]) -> None:
    """Raise `DataError` if a file has another ending."""
    if path is not None and path.suffix.lower() not in endings:
        raise DataError(f"`{path}` must end in {' or '.join(endings)}.")


def check_folder(path: Path) -> None:
    """Raise `DataError` if there is no folder for a file, or none to write to."""
    if not path.parent.is_dir():
        raise DataError(f"There is no folder `{path.parent}` to write `{path.name}` into.")
    if not os.access(path.parent, os.W_OK):
        raise DataError(f"The folder `{path.parent}` cannot be written to.")


def check_absent(path: Path, force: bool, option: str = "--force") -> None:
    """Raise `DataError` if a file is there and must not be replaced."""
    if path.exists() and not force:
        raise DataError(f"`{path}` is there already; use {option} to replace it, or write to another file.")


@dataclass
class BestSoFar:
    """What a search has found up to now: a scenario to go on from, where it is interrupted."""

    file: Path
    """Where it is written then."""
    text: Callable[[], str] | None = None
    """Makes the scenario of the best so far; None before there is one."""
    judged: int = 0
    """How often there was a better one."""

    def keep(self, text: Callable[[], str]) -> None:
        """Take a better one."""
        self.text, self.judged = text, self.judged + 1

    def save(self) -> str:
        """Write it, and say so; nothing where there is none yet."""
        if self.text is None:
            return ""
        self.file.write_text(self.text(), encoding="utf-8", newline="\n")
        return f"Interrupted; the best so far is in `{self.file}`: the same command with it goes on from there."


def name_interrupted(save: Path | None, scenario: Path) -> BestSoFar:
    """The best so far of a search: where its result is to be saved, or else beside where one stands."""
    return BestSoFar(save or Path(f"{scenario.stem}-interrupted.toml"))


@contextmanager
def open_parts(outputs: Outputs) -> Iterator[Outputs]:
    """Names to write to; the files take their places together once all are complete."""
    mark = os.getpid()
    beside = {p: p.with_name(f".{p.stem}.{mark}{p.suffix}") for p in outputs.paths()}

    def part(path: Path | None) -> Path | None:
        return None if path is None else beside[path]

    def clear() -> str:
        for written in beside.values():
            written.unlink(missing_ok=True)
        return ""

    try:
        with rescue_answer(clear):
            yield Outputs(part(outputs.data), part(outputs.figure), part(outputs.profile))
            with hold_interrupts():
                for path, written in beside.items():
                    written.replace(path)
    finally:
        clear()
