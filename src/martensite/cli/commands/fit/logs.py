"""`fit LOG...`: fit parameters of a scenario to logs."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer
from typer import Argument, Option

from martensite.base.errors import InputError, UnknownNameError
from martensite.base.interrupts import InterruptError, accept_interrupt, rescue_answer
from martensite.cli.commands.fit import fit
from martensite.cli.fit_best import tell_best, tell_state
from martensite.cli.fit_log_model import ModelOptions, fit_alone
from martensite.cli.options import (
    Force,
    Imports,
    Json,
    NamedColumns,
    Settings,
    Text,
    Texts,
    import_modules,
    read_positive,
    read_quantity,
    spread_options,
)
from martensite.cli.outputs import check_absent, check_ending, check_folder
from martensite.cli.progress import show_search, show_spinner
from martensite.search.time_box import TimeBox

if TYPE_CHECKING:
    from martensite.base.summary import Summary
    from martensite.fit.fit import Fit
    from martensite.fit.fit_task import ArrangedFit, FitTask
    from martensite.fit.posterior import Posterior
    from martensite.fit.search_monitor import SearchNote
    from martensite.search.profile import Profile

REPORTS, MATERIAL = (".md", ".html"), (".toml",)


@dataclass(frozen=True)
class FitOptions:
    """Scenario, free parameters and fit options."""

    scenario: Annotated[
        list[Path] | None, Option(help="Scenario file for all logs, or repeated, one for each log.")
    ] = None
    free: Annotated[
        Texts,
        Option(
            metavar="NAME[=LOW..HIGH UNIT][@START]",
            help='Free parameters, comma-separated or repeated, e.g. A_s,A_f,"C_A=5..12 MPa/K".',
        ),
    ] = None
    each: Annotated[
        Texts,
        Option(
            help=('Parameters with a separate value for each log, e.g. offset, delay, "h:by=specimen" or "h=±20 %".')
        ),
    ] = None
    hold_out: Annotated[
        Text,
        Option(
            help=(
                'Held-out data: auto, none, "each in turn", names of logs, or a percentage such as "25 %" '
                "[default: auto]."
            )
        ),
    ] = None
    column: Annotated[
        Texts,
        Option(
            metavar="OUTPUT[=COLUMN[*FACTOR]]",
            help="Compared column, e.g. position; repeatable [default: all that log and scenario share].",
        ),
    ] = None
    noise: Annotated[
        Texts,
        Option(metavar="OUTPUT=AMOUNT", help='Standard deviation of a measurement, e.g. "strain=0.02 %"; repeatable.'),
    ] = None
    method: Annotated[Text, Option(help="Search method: trf, coordinate, or evolution [default: trf].")] = None
    loss: Annotated[Text, Option(help="Loss function: linear, soft-l1, huber, or cauchy [default: linear].")] = None
    starts: Annotated[int | None, Option(help="Number of further starting points within the bounds [default: 0].")] = (
        None
    )
    step: Annotated[Text, Option(help='Maximum time step, e.g. "0.5 s" [default: set by the tolerance].')] = None
    fix: Annotated[
        Texts,
        Option(
            metavar="NAME[=VALUE]",
            help='Parameter that is not free, without --scenario, e.g. "E_A=60 GPa"; repeatable.',
        ),
    ] = None
    time_box: Annotated[
        Text,
        Option(
            metavar="TIME", help='Limit of CPU time, e.g. "30 s" [default: 60 s without --scenario, otherwise none].'
        ),
    ] = None
    interval: Annotated[Text, Option(help='Time between rows of logs without a time column, e.g. "0.1 s".')] = None
    new_headings: NamedColumns = None

    def read_task(self, logs: Sequence[str], settings: list[str] | None) -> FitTask:
        """Return the task; options override the fit file."""
        from martensite.fit.fit_file import is_fit_file, read_fit_file
        from martensite.fit.free_parameters import split_list
        from martensite.scenario.overrides import read_settings

        if any(map(is_fit_file, logs)):
            self._refuse_beside_fit_file(logs)
            task = read_fit_file(logs[0])
        else:
            task = self._make_task(logs)
        return task.with_changes(
            each=split_list(self.each or []),
            hold_out=self.hold_out,
            columns=self.column or (),
            noise=_read_pairs(self.noise or []),
            step=read_quantity("step", self.step, "s"),
            settings=read_settings(settings or []),
            search={"method": self.method, "loss": self.loss, "starts": self.starts},
        )

    def take_carried(self, logs: Sequence[str]) -> FitOptions:
        """Return these options with the scenario and free numbers recorded in logs of a board, if none are given."""
        from martensite.boards.rig_scenarios import read_rigs

        if self.scenario:
            return self
        rigs = read_rigs(logs, self.free)
        return self if rigs is None else replace(self, scenario=rigs[0], free=rigs[1])

    def is_alone(self, logs: Sequence[str]) -> bool:
        """Test whether neither a scenario nor a fit file is given."""
        from martensite.fit.fit_file import is_fit_file

        return not self.scenario and not any(map(is_fit_file, logs))

    def list_search(self) -> dict[str, Any]:
        """Return the arguments of `model_logs` that are given."""
        from martensite.fit.free_parameters import split_list
        from martensite.logs.reader import parse_new_headings

        given = {
            "new_headings": parse_new_headings(self.new_headings or ()),
            "interval": read_quantity("interval", self.interval, "s"),
            "free": [one for text in self.free or () for one in split_list(text)],
            "fixed": list(self.fix or ()),
            "hold_out": "each" if self.hold_out == "each in turn" else self.hold_out,
            "starts": self.starts,
            "time_box": read_positive("time-box", self.time_box, "s"),
        }
        return {name: value for name, value in given.items() if value is not None}

    def _make_task(self, logs: Sequence[str]) -> FitTask:
        from martensite.fit.api import build_task
        from martensite.logs.reader import parse_new_headings

        if not self.scenario:
            raise InputError("A fit needs --scenario, the file of one; none given.")
        if not self.free:
            raise InputError("A fit needs --free, what is to be found, such as `--free A_s,A_f`; none given.")
        task = build_task(self.scenario, logs, self.free)
        interval = read_quantity("interval", self.interval, "s")
        new_headings = parse_new_headings(self.new_headings or ())
        read = (replace(one, interval=interval, new_headings=new_headings) for one in task.logs)
        return replace(task, logs=tuple(read))

    def _refuse_beside_fit_file(self, logs: Sequence[str]) -> None:
        if len(logs) > 1:
            raise InputError("A fit file lists its own records; give no other logs.")
        idle = {
            "--scenario": self.scenario,
            "--free": self.free,
            "--interval": self.interval,
            "--as": self.new_headings,
        }
        name = next((name for name, given in idle.items() if given), None)
        if name is not None:
            raise InputError(f"Option `{name}` has no effect, since the fit file sets it.")


@dataclass(frozen=True)
class FitExtras:
    """Further results of a fit, and its files."""

    profile: Annotated[
        Texts, Option(metavar="NAME", help="Parameter whose profile likelihood is computed, e.g. A_s; repeatable.")
    ] = None
    posterior: Annotated[
        int | None, Option(metavar="STEPS", help="Steps of each walker for posterior samples, e.g. 500; needs emcee.")
    ] = None
    resume: Annotated[
        Path | None,
        Option(metavar="STATE", help="File that stores the state of the search, and from which the search resumes."),
    ] = None
    report: Annotated[Path | None, Option(help="Report to write: .md (with figures in the same folder) or .html.")] = (
        None
    )
    out: Annotated[Path | None, Option(metavar="MATERIAL", help="Material file to write: .toml.")] = None

    def refuse_without_scenario(self) -> None:
        """Raise `InputError` for options that require a scenario file."""
        idle = {"--profile": self.profile, "--posterior": self.posterior, "--resume": self.resume}
        if name := next((name for name, given in idle.items() if given), None):
            raise InputError(f"Option `{name}` needs --scenario and --free; without, it has no effect.")

    def check(self, arranged: ArrangedFit) -> None:
        """Raise an error before the search if an extra result cannot be computed."""
        names = arranged.problem.names
        unknown = next((name for name in self.profile or () if name not in names), None)
        if unknown is not None:
            raise UnknownNameError("free parameter", unknown, names)
        if self.posterior is not None and self.posterior < 1:
            raise InputError(f"Option `--posterior` must be at least 1, but is {self.posterior}.")
        if self.posterior is not None and find_spec("emcee") is None:
            raise InputError("Option `--posterior` needs emcee: `pip install 'martensite[posterior]'`.")

    def check_files(self, force: bool) -> None:
        """Raise `DataError` if a file may not be written."""
        check_ending(self.report, REPORTS)
        check_ending(self.out, MATERIAL)
        for path in filter(None, (self.report, self.out, self.resume)):
            check_folder(path)
        for path in filter(None, (self.report, self.out, self._find_figures())):
            check_absent(path, force)

    def _find_figures(self) -> Path | None:
        """Return the figure folder of a report that does not contain its figures."""
        from martensite.show.pages import HTML, find_figure_folder

        if self.report is None or self.report.suffix.lower() in HTML:
            return None
        return find_figure_folder(self.report)

    def write(self, fit: Fit, summary: Summary) -> list[Path]:
        """Write the requested files; return their paths."""
        written: list[Path] = []
        if self.out is not None:
            from martensite.fit.material_files import write_material

            write_material(fit, self.out, scenario=fit.scenario)
            written.append(self.out)
        if self.report is not None:
            from martensite.show.pages import write_page

            written += write_page(summary, self.report)
        return written


@fit.command("logs")
@spread_options
def fit_logs(
    logs: Annotated[
        list[str],
        Argument(
            metavar="LOG...",
            help=(
                "Measured tables with headings such as `strain [%]`, one row per time or condition; "
                "data:SET/FILE for a published data set; or one fit file (.toml)."
            ),
        ),
    ],
    options: FitOptions,
    extras: FitExtras,
    models: ModelOptions,
    settings: Settings = None,
    modules: Imports = None,
    force: Force = False,
    json: Json = False,
) -> None:
    """Fit parameters of a scenario to logs (default command).

    Without --scenario the logs are recognised, and a scenario is proposed, fitted and tested on held-out
    data; the exit code is 1 if it does not predict them. Logs of `martensite hardware` include their scenario.

    Waveforms of kind `log` make the scenario follow the log. All other columns that the scenario computes are
    compared. Ctrl-C or SIGTERM ends the search, prints the best result and gives exit code 130.
    """
    import_modules(modules)
    extras.check_files(force)
    options = options.take_carried(logs)
    if options.is_alone(logs):
        extras.refuse_without_scenario()
        models.check(options, extras.report, force)
        fit_alone(logs, models, settings or [], options.list_search(), (extras.report, extras.out), json)
    models.refuse_beside_scenario()
    if options.fix:
        raise InputError("Option `--fix` has no effect with --scenario: leave the name out of --free, and use --set.")
    latest: dict[str, Any] = {}
    seconds = read_positive("time-box", options.time_box, "s")
    with rescue_answer(lambda: tell_best(latest, extras.resume, json)):
        whole = run_fit(options.read_task(logs, settings), extras, json, latest, seconds)
    if not whole:
        raise typer.Exit(InterruptError.exit_code)


def run_fit(
    task: FitTask, extras: FitExtras, json: bool, latest: dict[str, Any] | None = None, seconds: float | None = None
) -> bool:
    """Run a fit and print its results; return False if it was interrupted.

    `latest` receives the problem and the best numbers so far; `seconds` limits the CPU time.
    """
    check = TimeBox(seconds).limit(1.0) if seconds else None
    names = extras.profile or []
    with show_spinner("reading logs, choosing steps"):
        arranged = task.arrange().choose_drift(check)
        for module in ("scipy.optimize", "scipy.stats", "scipy.stats.qmc"):
            import_module(module)  # an interrupt during the search would leave it half imported
        extras.check(arranged)
    with show_search(lambda note: _describe_note(note, task.noise)) as tell:
        training = arranged.problem.training

        def remember(note: SearchNote) -> None:
            if latest is not None and math.isfinite(note.cost):
                latest.update(problem=training, note=note)
            if tell is not None:
                tell(note)
            if check is not None:
                check(note)

        fit = arranged.solve(remember, extras.resume)
    profiles, posterior = _walk_profiles(fit, names), None
    if extras.posterior is not None and len(profiles) == len(names):
        posterior = _draw_posterior(fit, extras.posterior)
    from martensite.show.summaries.fit import summarise_fit
    from martensite.show.terminal import print_summary

    summary = summarise_fit(fit, fit.scenario, profiles, fit.scenario.title if fit.scenario else "", posterior)
    with show_spinner("writing"):
        written = extras.write(fit, summary)
    print_summary(summary, json, written)
    whole = len(profiles) == len(names) and (posterior is None) == (extras.posterior is None)
    if not whole:
        typer.echo("interrupted: profiles or samples are missing", err=True)
    if fit.reason == "interrupted":
        typer.echo(f"interrupted: this is the best so far{tell_state(extras.resume)}", err=True)
    return whole and fit.reason != "interrupted"


def _draw_posterior(fit: Fit, draws: int) -> Posterior | None:
    from martensite.fit.posterior import sample_posterior

    try:
        with show_spinner("drawing posterior samples"):
            return sample_posterior(fit, draws=draws)
    except KeyboardInterrupt:
        accept_interrupt()
        return None


def _walk_profiles(fit: Fit, names: Sequence[str]) -> list[Profile]:
    from martensite.fit.profiling import profile_likelihood

    walked: list[Profile] = []
    try:
        for name in names:
            with show_spinner(f"profile of {name}"):
                walked.append(profile_likelihood(fit, name))
    except KeyboardInterrupt:
        accept_interrupt()
    return walked


def _describe_note(note: SearchNote, noise: Mapping[str, Any]) -> str:
    root = math.sqrt(note.cost)
    size = f"{root:.3g} of noise" if noise else f"{100.0 * root:.3g} % of range"
    return f"{note.stage}: best RMS {size}, {note.simulations} runs"


def _read_pairs(texts: Sequence[str]) -> dict[str, str]:
    table: dict[str, str] = {}
    for text in texts:
        name, equals, value = text.partition("=")
        if not equals:
            raise InputError(f'`{text}` is no noise; write `OUTPUT=AMOUNT`, e.g. "strain=0.02 %".')
        table[name.strip()] = value.strip()
    return table
