"""The run of a fit for the command line: read, search, profile, write, show."""

from __future__ import annotations

import math
import os
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Any

import typer

from martensite.base.errors import DataError, InputError, UnknownNameError
from martensite.cli.options import quantity
from martensite.cli.waiting import search_bar, spinner

if TYPE_CHECKING:
    from martensite.fit.posterior import Posterior
    from martensite.fit.task import Arranged, LogFit, Task
    from martensite.fit.watch import Note
    from martensite.search.profile import Profile

REPORTS, MATERIAL = (".md", ".html"), (".toml",)


@dataclass(frozen=True)
class Given:
    """What the command line says about a fit, as text."""

    logs: Sequence[str]
    scenarios: Sequence[Path]
    free: Sequence[str]
    each: Sequence[str]
    hold_out: str | None
    columns: Sequence[str]
    """Outputs to compare."""
    noise: Sequence[str]
    settings: Sequence[str]
    method: str | None
    loss: str | None
    starts: int | None
    step: str | None
    headings: str | None
    interval: str | None

    def task(self) -> Task:
        """The task; options go over what a fit file says.

        Raises:
            InputError: something is missing, or contradicts a fit file.
        """
        from martensite.fit.documents import is_fit_file, read_fit_file
        from martensite.fit.free_parameters import split_list
        from martensite.scenario.overrides import read_settings

        if any(map(is_fit_file, self.logs)):
            self._refuse_beside_fit_file()
            task = read_fit_file(self.logs[0])
        else:
            task = self._own()
        return task.changed(
            each=split_list(self.each),
            hold_out=self.hold_out,
            columns=self.columns,
            noise=_pairs(self.noise),
            step=self._seconds("step"),
            settings=read_settings(self.settings),
            search={"method": self.method, "loss": self.loss, "starts": self.starts},
        )

    def _own(self) -> Task:
        from martensite.fit.api import task_of

        if not self.scenarios:
            raise InputError("A fit needs --scenario, the file of one; none given.")
        if not self.free:
            raise InputError(
                "A fit needs --free, what is to be found, such as `--free A_s,A_f`; none given."
            )
        task, interval = task_of(self.scenarios, self.logs, self.free), self._seconds("interval")
        logs = (replace(x, columns=self._headings(), interval=interval) for x in task.logs)
        return replace(task, logs=tuple(logs))

    def _refuse_beside_fit_file(self) -> None:
        if len(self.logs) > 1:
            raise InputError("A fit file stands alone; its records are listed in it.")
        idle = {
            "--scenario": self.scenarios, "--free": self.free, "--columns": self.headings,
            "--interval": self.interval,
        }  # fmt: skip
        name = next((name for name, given in idle.items() if given), None)
        if name is not None:
            raise InputError(f"Option `{name}` has no effect: the fit file says that.")

    def _headings(self) -> tuple[str, ...] | None:
        return None if self.headings is None else tuple(self.headings.split(","))

    def _seconds(self, name: str) -> float | None:
        text = getattr(self, name)
        return None if text is None else quantity(name, text, "s")


def _pairs(texts: Sequence[str]) -> dict[str, str]:
    found: dict[str, str] = {}
    for text in texts:
        name, equals, value = text.partition("=")
        if not equals:
            raise InputError(f'`{text}` is no noise; write `OUTPUT=AMOUNT`, e.g. "strain=0.02 %".')
        found[name.strip()] = value.strip()
    return found


@dataclass(frozen=True)
class Files:
    """What a fit writes; None for what is not wanted."""

    report: Path | None
    material: Path | None
    state: Path | None
    """Read as well, if it is there."""

    def check(self, force: bool) -> Files:
        """Raise `DataError` if a file has a wrong ending, no folder, or is there already."""
        _ending(self.report, REPORTS)
        _ending(self.material, MATERIAL)
        for path in (self.report, self.material, self.state):
            if path is not None and not path.parent.is_dir():
                raise DataError(f"There is no folder `{path.parent}` to write `{path.name}` into.")
            if path is not None and not os.access(path.parent, os.W_OK):
                raise DataError(f"The folder `{path.parent}` cannot be written to.")
        for path in (self.report, self.material, self._figures()):
            if path is not None and path.exists() and not force:
                raise DataError(
                    f"`{path}` is there already; use --force to replace it, "
                    "or write to another file."
                )
        return self

    def _figures(self) -> Path | None:
        """Folder of the figures of a report that does not hold them."""
        if self.report is None or self.report.suffix.lower() != ".md":
            return None
        return self.report.with_name(f"{self.report.stem}_figures")

    def write(self, fit: LogFit, profiles: Sequence[Profile]) -> list[Path]:
        """Write what is wanted; the files that were written."""
        written: list[Path] = []
        if self.material is not None:
            from martensite.fit.material_files import write_material

            write_material(fit, self.material, scenario=fit.scenario)
            written.append(self.material)
        if self.report is not None:
            from martensite.show.reports.fit_report import write_report

            written += write_report(fit, self.report, scenario=fit.scenario, profiles=profiles)
        return written


def _ending(path: Path | None, endings: tuple[str, ...]) -> None:
    if path is not None and path.suffix.lower() not in endings:
        raise DataError(f"`{path}` must end in {' or '.join(endings)}.")


@dataclass(frozen=True)
class Further:
    """What is asked for beside the fit itself."""

    profiles: Sequence[str] = ()
    """Parameters whose profile likelihood is walked."""
    draws: int | None = None
    """Posterior samples of each chain."""

    def check(self, arranged: Arranged) -> None:
        """Refuse before the search what would fail after it."""
        names = arranged.problem.names
        unknown = next((name for name in self.profiles if name not in names), None)
        if unknown is not None:
            raise UnknownNameError("free parameter", unknown, names)
        if self.draws is not None and self.draws < 1:
            raise InputError(f"Option `--posterior` must be at least 1, but is {self.draws}.")
        if self.draws is not None and find_spec("numpyro") is None:
            raise InputError(
                "Option `--posterior` needs NumPyro; install it with "
                "`pip install martensite[posterior]`."
            )


def run_fit(task: Task, files: Files, further: Further, json: bool) -> bool:
    """Do what a task says and show what there is of it; False if it was interrupted."""
    from martensite.cli import fit_show, show

    with spinner("reading logs, choosing steps"):
        arranged = task.arranged()
        further.check(arranged)
    with search_bar(lambda note: _words(note, task.noise)) as tell:
        fit = arranged.solved(tell, files.state)
    profiles, draws = _profiles(fit, further.profiles), None
    if further.draws is not None and len(profiles) == len(further.profiles):
        draws = _posterior(fit, further.draws)
    whole = len(profiles) == len(further.profiles) and (draws is None) == (further.draws is None)
    with spinner("writing"):
        written = files.write(fit, profiles)
    shown = fit_show.Shown(fit, profiles, draws, written)
    if json:
        show.as_json(shown.as_dict())
    else:
        shown.show()
    if not whole:
        typer.echo("interrupted: profiles or samples are missing", err=True)
    return whole and fit.reason != "interrupted"


def _posterior(fit: LogFit, draws: int) -> Posterior | None:
    """Samples; None if they were interrupted."""
    from martensite.fit.posterior import posterior

    try:
        return posterior(fit, draws=draws, progress=sys.stderr.isatty())
    except KeyboardInterrupt:
        return None


def _profiles(fit: LogFit, names: Sequence[str]) -> list[Profile]:
    """Profiles; fewer if they were interrupted."""
    from martensite.fit.profiled import profile_likelihood

    walked: list[Profile] = []
    try:
        for name in names:
            with spinner(f"profile of {name}"):
                walked.append(profile_likelihood(fit, name))
    except KeyboardInterrupt:
        return walked
    return walked


def _words(note: Note, noise: Mapping[str, Any]) -> str:
    """What a search tells, for its bar."""
    root = math.sqrt(note.cost)
    size = f"{root:.3g} of noise" if noise else f"{100.0 * root:.3g} % of range"
    return f"{note.stage}: best RMS {size}, {note.simulations} runs"
