"""Running a scenario for the command line: simulate, compare, write, show."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass, replace
from typing import TYPE_CHECKING, Any

from martensite.cli.outputs import Outputs, parts
from martensite.cli.waiting import run_bar, spinner

if TYPE_CHECKING:
    from pathlib import Path

    from martensite.design.tuning.averaging import Averaging
    from martensite.scenario.compare import Agreement
    from martensite.scenario.scenario import Scenario
    from martensite.signals.records import Record
    from martensite.simulate.result import Result

AVERAGED = ("pulses - average", "RMS", "largest")
HAIR = 1e-12
COMPARED = ("computed - measured", "RMS", "largest", "at", "measured range")


@dataclass(frozen=True)
class Wanted:
    """What the command line asks of a run."""

    outputs: Outputs
    tolerance: float | None = None
    runtime: str | None = None
    compare: str | None = None
    """A record to compare with, instead of the one that the scenario names."""
    columns: Sequence[str] | None = None
    no_compare: bool = False
    log: Record | None = None
    """What the scenario follows; compared with as well, as far as the run goes."""
    carrier: float | None = None
    """Frequency [Hz] of the pulses to be made beside the averaged run."""
    quiet: bool = False
    """Whether no progress is shown, even to a terminal."""
    budget: float | None = None
    """CPU time [s] after which the run is given up."""


@dataclass(frozen=True)
class Executed:
    """A finished run, and everything that is said about it."""

    scenario: Scenario
    result: Result
    outputs: Outputs
    agreements: list[Agreement]
    """How far the run is from the record it was compared with."""
    averaging: Averaging | None = None
    """What the run leaves out by averaging over pulses, if that was asked for."""

    def show(self, json: bool) -> None:
        """Print the run."""
        from martensite.cli import show

        if json:
            show.as_json(self.summary())
        else:
            self._print()

    def summary(self) -> dict[str, Any]:
        """The run, ready for JSON; numbers in SI."""
        result = self.result
        return {
            "title": self.scenario.title,
            "duration": result.times[-1],
            "steps": result.steps,
            "step": result.step,
            "accuracy": result.accuracy,
            "runtime": result.runtime or None,
            "rejected_steps": result.rejected,
            "ripple": result.ripple,
            "heat": None if result.heat is None else result.heat.as_dict(),
            "work": None if result.work is None else result.work.as_dict(),
            "unbalanced": list(result.unbalanced),
            "conformance": result.conformance,
            "status": result.status.name,
            "status_time": result.status_time,
            "stroke": result.stroke,
            "columns": {
                name: {"lowest": min(c), "highest": max(c), "unit": result.unit(name)}
                for name, c in result.columns.items()
            },
            "cautions": self.scenario.cautions,
            "warnings": list(result.warnings),
            "alarms": [asdict(alarm) for alarm in result.alarms],
            "comparison": [asdict(agreement) for agreement in self.agreements],
            "averaging": _averaging(self.averaging),
            "files": [str(path) for path in self.outputs.paths()],
        }

    def _print(self) -> None:
        from martensite.cli import show

        show.text(self.scenario.title, "bold")
        first, *_ = str(self.result).partition("\n")
        show.text(f"{first}; {_stroke(self.result)}")
        show.table(("quantity", "lowest", "highest"), self._rows(), right="lowest,highest")
        for line in (*self.result.balances(), *self.result.remarks()):
            show.text(line)
        if self.agreements:
            rows = [self._agreement(agreement) for agreement in self.agreements]
            show.table(COMPARED, rows, right=",".join(COMPARED[1:]))
        if self.averaging:
            _print_averaging(self.averaging)
        for caution in self.scenario.cautions:
            show.text(f"Caution: {caution}", "yellow")
        for warning in self.result.warnings:
            show.text(warning, "yellow")
        for path in self.outputs.paths():
            show.text(f"wrote {path}")

    def _agreement(self, found: Agreement) -> tuple[str, ...]:
        from martensite.cli import show

        sizes = (found.rms, found.maximum)
        apart = (show.difference(size, found.unit) for size in sizes)
        spread = show.difference(found.range, found.unit)
        words = self.result.outputs[found.quantity].long_name
        return words, *apart, f"{found.time:.4g} s", spread

    def _rows(self) -> Iterator[tuple[str, str, str]]:
        from martensite.cli import show

        for name, column in self.result.columns.items():
            unit = self.result.unit(name)
            low, high = show.quantity(min(column), unit), show.quantity(max(column), unit)
            yield self.result.outputs[name].long_name, low, high


def _stroke(result: Result) -> str:
    from martensite.cli import show

    return f"stroke {show.difference(result.stroke, result.unit(result.coordinate))}"


def _averaging(found: Averaging | None) -> dict[str, Any] | None:
    """What averaging leaves out, ready for JSON; numbers in SI."""
    if found is None:
        return None
    return {
        "frequency": found.frequency,
        "differences": {name: asdict(d) for name, d in found.differences.items()},
        "ripple": found.ripple,
        "estimate": found.estimate,
        "alarms": [asdict(alarm) for alarm in found.pulsed.result.alarms],
    }


def _print_averaging(found: Averaging) -> None:
    from martensite.cli import show

    names = found.average.outputs
    rows = [
        (names[name][1], *(show.difference(v, names[name][0]) for v in (d.rms, d.largest)))
        for name, d in found.differences.items()
    ]
    show.table(AVERAGED, rows, right=",".join(AVERAGED[1:]))
    show.text(
        f"pulses of {found.frequency:.6g} Hz make the temperature ripple by up to "
        f"{found.ripple:.3g} K (estimate {found.estimate:.3g} K)"
    )


def execute(scenario: Scenario, wanted: Wanted) -> Executed:
    """Run a scenario and write what is wanted; nothing is written if anything fails."""
    record = _record(scenario, wanted)
    result = _run(scenario, wanted)
    averaging = _averaged(scenario, wanted.carrier)
    agreements = _compared(result, record, wanted.compare is None and wanted.log is not None)
    with spinner("writing"), parts(wanted.outputs) as files:
        _write(files, scenario, result, record)
    return Executed(scenario, result, wanted.outputs, agreements, averaging)


def _run(scenario: Scenario, wanted: Wanted) -> Result:
    """The run, which shows how far it is."""
    if scenario.bench is not None and not scenario.outside:
        with spinner(f"simulating {scenario.title}"):
            return scenario.run(runtime=wanted.runtime)
    with run_bar(scenario.title, wanted.quiet) as tell:
        return scenario.run(
            tolerance=wanted.tolerance, runtime=wanted.runtime, budget=wanted.budget, tell=tell
        )


def _averaged(scenario: Scenario, carrier: float | None) -> Averaging | None:
    if carrier is None:
        return None
    from martensite.actuators.assembly import System
    from martensite.base.errors import InputError
    from martensite.design.tuning.averaging import compare_averaging
    from martensite.signals.base import AbstractWaveform

    system, waveform = scenario.system, scenario.waveform
    alone = scenario.bench is None and isinstance(system, System)
    if not (alone and isinstance(waveform, AbstractWaveform)):
        raise InputError(
            "Option `--carrier` is for a system of one element and one drive, without a bench."
        )
    with spinner(f"simulating the pulses of {scenario.title}"):
        return compare_averaging(system, waveform, scenario.duration, carrier)


def _draw(path: Path, scenario: Scenario, result: Result, records: list[Record] | None) -> None:
    """The standard figure."""
    from martensite.show.figures.overview import save_figure

    save_figure(result, path, records, scenario.title, scenario.outside)


def _record(scenario: Scenario, wanted: Wanted) -> Record | None:
    """The record to compare with, read before anything is run."""
    if wanted.no_compare:
        return None
    if wanted.compare is None and wanted.log is not None:
        return _as_far_as_run(wanted.log, scenario)
    if wanted.compare is None:
        return scenario.measured.read() if scenario.measured else None
    from martensite.scenario.tables import read_table

    return read_table(wanted.compare, wanted.columns)


def _as_far_as_run(log: Record, scenario: Scenario) -> Record:
    """The rows of a log from its beginning to the end of the run."""
    from martensite.scenario.recorded import from_zero

    found = from_zero(log, scenario.lead)
    rows = bisect_right(found.times, scenario.duration * (1.0 + HAIR))
    return replace(found, columns={name: c[:rows] for name, c in found.columns.items()})


def _compared(result: Result, record: Record | None, followed: bool) -> list[Agreement]:
    if record is None:
        return []
    from martensite.scenario.compare import compare_with_record, list_common

    return (
        [] if followed and not list_common(result, record) else compare_with_record(result, record)
    )


def _write(files: Outputs, scenario: Scenario, result: Result, record: Record | None) -> None:
    from martensite.scenario.citations import list_citations

    if files.data is not None:
        from martensite.scenario.netcdf import save_result

        cited = list_citations(scenario, scenario.material)
        save_result(result, files.data, scenario.text, cited, scenario.material)
    if files.figure is not None:
        _draw(files.figure, scenario, result, [record] if record else None)
    if files.profile is not None:
        from martensite.show.figures.files import write_figure
        from martensite.show.figures.profile import plot_profile

        write_figure(plot_profile(result, scenario.title), files.profile)
