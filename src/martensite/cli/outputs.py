"""Output files: checked before a command starts, and written completely or not at all."""

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
    """First sentence of an answer."""

    worse: bool
    """True for an answer that needs --save-anyway."""
    sentence: str
    """Without a full stop."""


@dataclass(frozen=True)
class Outputs:
    """Output files; None if unused."""

    data: Path | None
    figure: Path | None
    profile: Path | None = None
    """Figure of the state along the element."""

    def paths(self) -> list[Path]:
        """Return the files that will be written."""
        return [path for path in (self.data, self.figure, self.profile) if path is not None]

    def check(self, force: bool, data: tuple[str, ...] = DATA) -> Outputs:
        """Raise `DataError` if a file may not be written.

        Args:
            force: replace existing files.
            data: endings of the data file.
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
        *,
        wrap: bool = False,
    ) -> None:
        """Write text and figure, then print the summary, with wrapped sentences if `wrap`."""
        from martensite.show.terminal import print_summary

        self.write(text, draw)
        print_summary(summary, json, self.paths(), wrap=wrap)

    def answer_verdict(
        self,
        verdict: Verdict,
        summary: Summary,
        options: JudgedOptions,
        text: Callable[[], str],
        draw: Callable[[], Figure] | None = None,
    ) -> bool:
        """Print the verdict first; save a worse answer only with --save-anyway.

        Returns:
            True if the answer was not saved, so that the command exits with 1.
        """
        refused = verdict.worse and not options.save_anyway
        ending = "; not saved. --save-anyway saves it" if refused else "; saved by --save-anyway"
        first = f"{verdict.sentence}{ending if verdict.worse and self.data is not None else ''}."
        lead = "; ".join(filter(None, (summary.title, summary.lead)))
        headed = replace(summary, title=first, lead=lead)
        outputs = replace(self, data=None) if refused else self
        outputs.answer(headed, options.json, text, draw)
        return refused

    def write(self, text: Callable[[], str] | None = None, draw: Callable[[], Figure] | None = None) -> None:
        """Write text and figure."""
        from martensite.show.figures.style import write_figure

        with replace_together():
            if self.data is not None and text is not None:
                write_file(self.data, text())
            if self.figure is not None and draw is not None:
                write_figure(draw(), self.figure)


@dataclass(frozen=True)
class AnswerOptions:
    """Figure and output format of an answer."""

    figure: FigureFile = None
    force: Force = False
    json: Json = False

    def check_files(self, data: Path | None = None, *endings: str) -> Outputs:
        """Return the output files; raise `DataError` if one may not be written."""
        return Outputs(data, self.figure).check(self.force, data=endings)


@dataclass(frozen=True)
class JudgedOptions(AnswerOptions):
    """Options of a command whose answer may be worse than before."""

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
    """Raise `DataError` if a folder is missing or read-only, or a file name is invalid."""
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
    """Raise `DataError` if a file exists and must not be replaced."""
    if path.exists() and not force:
        raise DataError(f"`{path}` is there already; use --force to replace it, or write to another file.")


@dataclass
class BestSoFar:
    """Best result of a search, saved on an interrupt so that the search can continue."""

    file: Path
    """File of an interrupted search."""
    text: Callable[[], str] | None = None
    """Returns the best scenario; None before the first."""
    judged: int = 0
    """Number of improvements."""

    def keep(self, text: Callable[[], str]) -> None:
        """Store a better result."""
        self.text, self.judged = text, self.judged + 1

    def save(self) -> str:
        """Write the best result; return a sentence, or "" if there is none."""
        if self.text is None:
            return ""
        write_file(self.file, self.text())
        return f"Interrupted; the best so far is in `{self.file}`: the same command with it goes on from there."


def name_interrupted(save: Path | None, scenario: Path) -> BestSoFar:
    """Return the best-so-far record of a search, named after its output or its scenario."""
    return BestSoFar(save or Path(f"{scenario.stem}-interrupted.toml"))


def check_folder_files(folder: Path, names: Sequence[str], force: bool) -> list[Path]:
    """Return the paths of files for a folder; create the folder.

    Args:
        folder: its parent must exist.
        names: file names.
        force: replace existing files.
    """
    files = [folder / name for name in names]
    missing = not folder.exists()
    for path in [folder.parent / names[1]] if missing else files:
        Outputs(path, None).check(force or missing, data=(path.suffix,))
    return files
