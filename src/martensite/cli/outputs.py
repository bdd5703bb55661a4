"""Files that a command writes: checked before it starts, complete or absent afterwards."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from martensite.base.errors import DataError
from martensite.base.files import replace_together, write_file
from martensite.cli.options import FigureFile, Force, Json, SaveAnyway, refuse_idle
from martensite.show.figures.style import FORMATS

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from martensite.base.summary import Summary

DATA = (".nc",)
FIGURE = tuple(f".{name}" for name in FORMATS)


class Verdict(NamedTuple):
    """Statement of the first line of an answer."""

    worse: bool
    """True for an answer that is saved only with --save-anyway."""
    sentence: str
    """Without a full stop."""


@dataclass(frozen=True)
class Outputs:
    """Output files; None for an unused one."""

    data: Path | None
    figure: Path | None
    profile: Path | None = None
    """A figure of what differs along the element."""

    def paths(self) -> list[Path]:
        """The files that will be written."""
        return [path for path in (self.data, self.figure, self.profile) if path is not None]

    def check(self, force: bool, data: tuple[str, ...] = DATA) -> Outputs:
        """Raise `DataError` if a file has a wrong ending, no folder, or is there already.

        Args:
            force: files that are there may be replaced.
            data: endings allowed for the data file.
        """
        check_ending(self.data, data)
        check_ending(self.figure, FIGURE)
        check_ending(self.profile, FIGURE)
        for path in self.paths():
            check_folder(path)
            check_absent(path, force)
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

    def answer_verdict(
        self,
        verdict: Verdict,
        summary: Summary,
        options: JudgedOptions,
        text: Callable[[], str],
        draw: Callable[[], Figure] | None = None,
    ) -> bool:
        """Answer with a verdict as the first line, and save a worse answer only with --save-anyway.

        Returns:
            True if the answer was not saved, so that the command exits with 1.
        """
        refused = verdict.worse and not options.save_anyway
        ending = "; not saved. --save-anyway saves it" if refused else "; saved by --save-anyway"
        first = f"{verdict.sentence}{ending if verdict.worse and self.data is not None else ''}."
        lead = "; ".join(filter(None, (summary.title, summary.lead)))
        said = replace(summary, title=first, lead=lead)
        outputs = replace(self, data=None) if refused else self
        outputs.answer(said, options.json, text, draw)
        return refused

    def write(self, text: Callable[[], str] | None = None, draw: Callable[[], Figure] | None = None) -> None:
        """Write the text that is wanted, and the figure."""
        from martensite.show.figures.style import write_figure

        with replace_together():
            if self.data is not None and text is not None:
                write_file(self.data, text())
            if self.figure is not None and draw is not None:
                write_figure(draw(), self.figure)


@dataclass(frozen=True)
class AnswerOptions:
    """A figure beside what is printed, and how."""

    figure: FigureFile = None
    force: Force = False
    json: Json = False

    def check_files(self, data: Path | None = None, *endings: str) -> Outputs:
        """The figure and a data file, which may be written; `DataError` if one may not."""
        return Outputs(data, self.figure).check(self.force, data=endings)


@dataclass(frozen=True)
class JudgedOptions(AnswerOptions):
    """Options of a command whose answer may be worse than before or exceed a limit."""

    save_anyway: SaveAnyway = False

    def check_files(self, data: Path | None = None, *endings: str) -> Outputs:
        """Return the output files; raise `InputError` if `--save-anyway` has no effect."""
        refuse_idle("--save-anyway", self.save_anyway and data is None, "nothing is saved")
        return super().check_files(data, *endings)


def check_ending(path: Path | None, endings: tuple[str, ...]) -> None:
    """Raise `DataError` if a file has another ending."""
    if path is not None and path.suffix.lower() not in endings:
        raise DataError(f"`{path}` must end in {' or '.join(endings)}.")


def check_folder(path: Path) -> None:
    """Raise `DataError` if the folder of a file is missing or read-only, or if the file name is invalid."""
    try:
        folder = path.is_dir()
        path.exists()
    except OSError as error:
        raise DataError(f"The file `{path}` cannot be written: {error.strerror}.") from None
    if folder:
        raise DataError(f"`{path}` is a folder; name a file to write.")
    if not path.parent.is_dir():
        raise DataError(f"There is no folder `{path.parent}` to write `{path.name}` into.")
    if not os.access(path.parent, os.W_OK):
        raise DataError(f"The folder `{path.parent}` cannot be written to.")


def check_absent(path: Path, force: bool) -> None:
    """Raise `DataError` if a file is there and must not be replaced."""
    if path.exists() and not force:
        raise DataError(f"`{path}` is there already; use --force to replace it, or write to another file.")


@dataclass
class BestSoFar:
    """Best result of a search so far: a scenario from which an interrupted search can continue."""

    file: Path
    """File of an interrupted search."""
    text: Callable[[], str] | None = None
    """Makes the scenario of the best so far; None before there is one."""
    judged: int = 0
    """Number of improvements."""

    def keep(self, text: Callable[[], str]) -> None:
        """Take a better one."""
        self.text, self.judged = text, self.judged + 1

    def save(self) -> str:
        """Write it, and say so; nothing where there is none yet."""
        if self.text is None:
            return ""
        write_file(self.file, self.text())
        return f"Interrupted; the best so far is in `{self.file}`: the same command with it goes on from there."


def name_interrupted(save: Path | None, scenario: Path) -> BestSoFar:
    """The best so far of a search: where its result is to be saved, or else beside where one stands."""
    return BestSoFar(save or Path(f"{scenario.stem}-interrupted.toml"))


def check_folder_files(folder: Path, names: Sequence[str], force: bool) -> list[Path]:
    """Return the files that a command will write into a folder.

    Args:
        folder: made if it is missing; its parent must be there.
        names: of the files.
        force: whether existing files may be replaced.

    Raises:
        DataError: a file is there already, or the parent folder is missing.
    """
    files = [folder / name for name in names]
    missing = not folder.exists()
    for path in [folder.parent / names[1]] if missing else files:
        Outputs(path, None).check(force or missing, data=(path.suffix,))
    return files
