"""Options of commands for boards."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from typer import Option

from martensite.base.errors import InputError, SolveError
from martensite.base.summary import Block, DataTable, Sentence, Summary
from martensite.boards.board_log import ENDINGS
from martensite.cli.options import FigureFile, Force, Json, Text
from martensite.cli.outputs import Outputs
from martensite.cli.progress import open_bar

if TYPE_CHECKING:
    from martensite.boards.board_log import BoardLog
    from martensite.boards.session import Session

ProjectFolder = Annotated[
    Path, typer.Argument(metavar="PROJECT", help="Folder written by `martensite export firmware`.")
]
SHOWN = 4
"""Number of values beside a progress bar."""


@dataclass(frozen=True)
class BoardSource:
    """Firmware project and serial port."""

    project: ProjectFolder
    port: Annotated[str, Option(help="Serial port, e.g. /dev/ttyACM0 or COM3, or the word emulator.")] = "emulator"


@dataclass(frozen=True)
class LogOptions:
    """Log file and figure of a board session."""

    out: Annotated[Path | None, Option(help="Log file to write: .csv, .parquet or .mcap.")] = None
    figure: FigureFile = None
    force: Force = False
    json: Json = False

    def check_file(self) -> LogOptions:
        """Return these options; raise `DataError` if a file may not be written."""
        Outputs(self.out, self.figure).check(self.force, data=ENDINGS)
        return self


Armed = Annotated[
    Text,
    Option(
        "--arm",
        metavar="ARM",
        help=("Permission to heat: the word ARM. Without it the command is a dry run, which heats nothing."),
    ),
]


def require_empty(folder: Path, force: bool) -> Path:
    """Return a folder; raise `InputError` if it is not empty, unless `force`."""
    if folder.exists() and any(folder.iterdir()) and not force:
        raise InputError(f"`{folder}` is not empty; use --force to write into it, or name another folder.")
    return folder


@contextmanager
def open_session(source: BoardSource) -> Iterator[Session]:
    """Yield an open session with a board."""
    from martensite.boards.session import Session

    with Session.open(source.project, source.port) as session:
        yield session


@contextmanager
def save_interrupted(session: Session, options: LogOptions) -> Iterator[None]:
    """Write the log of a board that stops before the end, then report the stop."""
    from martensite.boards.session import BoardStopped

    try:
        yield
    except BoardStopped as error:
        if options.out is None or not len(error.log):
            raise
        error.log.write(options.out, session.link.reader.counts)
        raise SolveError(f"{error} `{options.out}` has the {len(error.log)} samples until then.") from None


@contextmanager
def show_log(label: str) -> Iterator[Callable[[BoardLog, float], None] | None]:
    """Yield a function that moves a progress bar with the newest values of a log."""
    with open_bar(label, 1.0) as move:
        yield move and (lambda log, share: move(description=_describe_latest(label, log), completed=share))


def _describe_latest(label: str, log: BoardLog) -> str:
    names = list(log.latest.items())[3 : 3 + SHOWN]
    return f"{label}: " + ", ".join(f"{name} {value:.4g}" for name, value in names)


def answer_log(session: Session, log: BoardLog, options: LogOptions, before: list[Block] | None = None) -> None:
    """Write log and figure, and print a summary."""
    from martensite.show.figures.style import write_figure
    from martensite.show.terminal import print_summary

    counts = session.link.reader.counts
    if options.out is not None:
        log.write(options.out, counts)
    if options.figure is not None:
        write_figure(log.plot(), options.figure)
    table = log.table()
    rows = (
        [
            [heading, f"{column.min():.5g}", f"{column.max():.5g}", f"{column[-1]:.5g}"]
            for heading, column in zip(log.headings(), table.T, strict=True)
        ]
        if len(log)
        else []
    )
    words = f"{len(log)} samples; frames: {counts.good} good, {counts.describe()}"
    blocks: list[Block] = [
        *(before or []),
        Sentence(words),
        DataTable(("column", "least", "largest", "last"), rows, right=(1, 2, 3)),
    ]
    data = {"samples": len(log), **vars(counts)}
    print_summary(Summary("", blocks, data), options.json, Outputs(options.out, options.figure).paths())
