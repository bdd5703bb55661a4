"""`run`: simulate a scenario."""

from __future__ import annotations

from bisect import bisect_right
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from typer import Option

from martensite.base.errors import InputError
from martensite.base.files import replace_together
from martensite.cli.app import app
from martensite.cli.options import (
    Force,
    Imports,
    Json,
    NamedColumns,
    ScenarioFile,
    Settings,
    Text,
    import_modules,
    read_quantity,
    refuse_idle,
    spread_options,
)
from martensite.cli.outputs import Outputs
from martensite.cli.progress import show_run, show_spinner

if TYPE_CHECKING:
    from martensite.base.summary import Summary
    from martensite.design.analysis.averaging import Averaging
    from martensite.scenario.compare import Agreement
    from martensite.scenario.scenario import Scenario
    from martensite.signals.records import Record
    from martensite.simulate.result import Result

ROUNDING = 1e-12
"""Relative to the duration of a run."""


@dataclass(frozen=True)
class RunOptions:
    """Options of a run."""

    compare: Annotated[
        Text, Option(metavar="FILE", help="Record to compare with [default: the record of the scenario].")
    ] = None
    log: Annotated[
        Text, Option(metavar="FILE", help="Log that drives the scenario, and that the run is compared with.")
    ] = None
    new_headings: NamedColumns = None
    no_compare: Annotated[bool, Option("--no-compare", help="Skip the comparison.")] = False
    tolerance: Annotated[
        float | None,
        Option(help=("Tolerance relative to the range of each quantity, e.g. 1e-5 [default: that of the scenario].")),
    ] = None
    seed: Annotated[
        int | None, Option(min=0, help="Seed of the sensor noise [default: `run.seed` of the scenario, or 0].")
    ] = None
    runtime: Annotated[
        Text,
        Option(
            help=(
                "Runtime: auto, floats or c [default: auto, the first to finish; for loops c if there is a compiler]."
            )
        ),
    ] = None
    begin: Annotated[
        Text,
        Option(
            "--from", metavar="FILE", help="Result file of the same system from whose stored state the run continues."
        ),
    ] = None
    at: Annotated[Text, Option(metavar="TIME", help='Time of the stored state, e.g. "12.3 s" [default: its end].')] = (
        None
    )
    measure: Annotated[
        list[str] | None,
        Option(
            metavar="MEASURE",
            help='Measure to print with its error bound, e.g. "max(temperature)" or energy; repeatable.',
        ),
    ] = None
    time_box: Annotated[Text, Option(metavar="TIME", help='Limit of CPU time, e.g. "30 s".')] = None
    carrier: Annotated[
        Text,
        Option(
            metavar="FREQUENCY",
            help=(
                'PWM frequency, e.g. "100 Hz", of a second run with every pulse, which shows the error of the average.'
            ),
        ),
    ] = None

    def load(self, path: Path, settings: list[str] | None) -> tuple[Scenario, Record | None]:
        """Return the scenario and the log that it follows."""
        from martensite.scenario.overrides import read_settings
        from martensite.scenario.scenario import load

        log = None if self.log is None else _read_log(self.log, None if self.compare else self.new_headings)
        seeds = {} if self.seed is None else {"run.seed": self.seed}
        loaded = load(path, read_settings(settings or []) | seeds, log=log)
        refuse_idle("--seed", self.seed is not None and not _has_noise(loaded), "the scenario has no noise")
        idle = log is not None and not loaded.follows
        refuse_idle("--log", idle, "no waveform of the scenario is of kind `log`; use --compare")
        closed = loaded.bench is not None and self.tolerance is not None
        refuse_idle("--tolerance", closed, "a bench runs in its periods")
        refuse_idle("--at", self.at is not None and self.begin is None, "there is no --from")
        if self.begin is not None:
            from martensite.scenario.running import go_on_from

            loaded = go_on_from(loaded, self.begin, self.at)
        return loaded, log

    def read_record(self, scenario: Scenario, log: Record | None) -> Record | None:
        """Return the record to compare with."""
        if self.no_compare:
            return None
        if self.compare is not None:
            return _read_log(self.compare, self.new_headings)
        if log is not None:
            return _cut_log(log, scenario)
        return scenario.measured.read() if scenario.measured else None

    def run(self, scenario: Scenario, *, quiet: bool) -> Result:
        """Return the run; show its progress unless `quiet`."""
        most = read_quantity("time-box", self.time_box, "s")
        if scenario.bench is not None:
            with show_spinner(f"simulating {scenario.title}"):
                return scenario.run(runtime=self.runtime, budget=most)
        with show_run(scenario.title, quiet) as tell:
            return scenario.run(tolerance=self.tolerance, runtime=self.runtime, budget=most, tell=tell)


@app.command("run", rich_help_panel="Simulate")
@spread_options
def run(
    scenario: ScenarioFile,
    options: RunOptions,
    settings: Settings = None,
    out: Annotated[Path | None, Option(help="Result file (netCDF) to write [default: ./SCENARIO.nc].")] = None,
    figure: Annotated[
        Path | None, Option(help="Figure to write: .png, .svg or .pdf [default: ./SCENARIO.png].")
    ] = None,
    no_figure: Annotated[bool, Option("--no-figure", help="Skip the figure.")] = False,
    profile: Annotated[
        Path | None,
        Option(help=("Figure of temperature and fraction along an axial-wire or a ribbon: .png, .svg or .pdf.")),
    ] = None,
    modules: Imports = None,
    force: Force = False,
    json: Json = False,
) -> None:
    """Simulate a scenario; write a netCDF file and a figure.

    A run that leaves the physical range (melting, 3 GPa, 20 % strain, or your own bound) stops there, keeps the
    results up to that time, and gives exit code 1.
    """
    lone = options.new_headings is not None and options.compare is None and options.log is None
    refuse_idle("--as", lone, "there is neither --compare nor --log")
    refuse_idle("--figure", figure is not None and no_figure, "--no-figure is given")
    idle = options.compare is not None and options.no_compare
    refuse_idle("--compare", idle, "--no-compare is given")
    import_modules(modules)
    loaded, log = options.load(scenario, settings)
    figure_path = None if no_figure else figure or Path(f"{scenario.stem}.png")
    outputs = Outputs(out or Path(f"{scenario.stem}.nc"), figure_path, profile).check(force)
    result, summary = run_scenario(loaded, options, outputs, log, quiet=json)
    from martensite.show.terminal import print_summary

    print_summary(summary, json, outputs.paths(), wrap=True)
    if result.status.failed:
        raise typer.Exit(1)


def run_scenario(
    scenario: Scenario, options: RunOptions, outputs: Outputs, log: Record | None = None, *, quiet: bool = False
) -> tuple[Result, Summary]:
    """Run a scenario and write the requested files; on an error, write none."""
    from martensite.simulate.measures.base import parse_measure

    for words in options.measure or ():
        parse_measure(words).columns(scenario.whole)
    record = options.read_record(scenario, log)
    pulses = read_quantity("carrier", options.carrier, "Hz")
    result = options.run(scenario, quiet=quiet)
    averaging = None if pulses is None else _make_pulses(scenario, pulses)
    agreements = _compare_record(result, record, options.compare is None and log is not None)
    with show_spinner("writing"), replace_together():
        _write_files(outputs, scenario, result, record)
    from martensite.show.summaries.run import summarise_run

    return result, summarise_run(scenario, result, agreements, averaging, options.measure or ())


def _read_log(path: str, new_headings: list[str] | None) -> Record:
    from martensite.logs.reader import parse_new_headings, read_log_table

    return read_log_table(path, new_headings=parse_new_headings(new_headings or ()))


def _has_noise(scenario: Scenario) -> bool:
    from martensite.control.loop.run import list_noises

    return scenario.bench is not None and scenario.seed is not None and bool(list_noises(scenario.bench))


def _make_pulses(scenario: Scenario, carrier: float) -> Averaging:
    from martensite.actuators.assembly import System
    from martensite.design.analysis.averaging import compare_averaging
    from martensite.signals.base import AbstractWaveform

    system, waveform = scenario.require_home("A comparison with pulses").system, scenario.waveform
    alone = scenario.bench is None
    if alone and isinstance(system, System) and isinstance(waveform, AbstractWaveform):
        with show_spinner(f"simulating the pulses of {scenario.title}"):
            return compare_averaging(system, waveform, scenario.duration, carrier)
    raise InputError("Option `--carrier` is for a system of one element and one drive, without a bench.")


def _cut_log(log: Record, scenario: Scenario) -> Record:
    from martensite.scenario.recorded_waveforms import from_zero

    shifted = from_zero(log, scenario.lead)
    rows = bisect_right(shifted.times, scenario.duration * (1.0 + ROUNDING))
    return replace(shifted, columns={name: c[:rows] for name, c in shifted.columns.items()})


def _compare_record(result: Result, record: Record | None, followed: bool) -> list[Agreement]:
    from martensite.scenario.compare import compare_with_record, list_common

    if record is None or (followed and not list_common(result, record)):
        return []
    return compare_with_record(result, record)


def _write_files(files: Outputs, scenario: Scenario, result: Result, record: Record | None) -> None:
    if files.data is not None:
        from martensite.scenario.citations import list_citations
        from martensite.scenario.netcdf import save_result

        cited = list_citations(scenario, scenario.material)
        save_result(result, files.data, scenario.text, cited, scenario.material)
    if files.figure is not None:
        from martensite.show.figures.overview import save_figure

        records = [record] if record else None
        save_figure(result, files.figure, records, scenario.title)
    if files.profile is not None:
        from martensite.show.figures.overview import plot_profile
        from martensite.show.figures.style import write_figure

        write_figure(plot_profile(result, scenario.title), files.profile)
