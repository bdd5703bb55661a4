"""`design`: optimise numbers of a scenario."""

from __future__ import annotations

import tomllib
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from typer import Exit, Option

from martensite.base.errors import InputError, ParameterError
from martensite.base.interrupts import rescue_answer
from martensite.cli.app import app
from martensite.cli.options import ScenarioSource, Text, Texts, read_quantity, refuse_idle, spread_options
from martensite.cli.outputs import BestSoFar, JudgedOptions, Verdict, name_interrupted
from martensite.cli.progress import show_share

if TYPE_CHECKING:
    from martensite.design.optimise.optimised_design import OptimisedDesign
    from martensite.design.optimise.question import DesignQuestion
    from martensite.scenario.scenario import Scenario
    from martensite.search.free_numbers import Target


@dataclass(frozen=True)
class DesignOptions:
    """Free parameters, goal, constraints and search options."""

    free: Annotated[
        Texts,
        Option(
            metavar="PATH=LOW..HIGH",
            help=(
                'Free parameter with bounds, e.g. "element.diameter=0.05..0.5 mm" or "drive.peak=1..5 W"; repeatable.'
            ),
        ),
    ] = None
    minimise: Annotated[Text, Option(help='Measure to minimise, e.g. "max(stress)" [default: energy].')] = None
    maximise: Annotated[Text, Option(help="Measure to maximise, e.g. stroke.")] = None
    subject: Annotated[
        Texts, Option(metavar="MEASURE<=LIMIT", help='Constraint, e.g. "max(stress) <= 200 MPa"; repeatable.')
    ] = None
    life: Annotated[Text, Option(help='Safety margin to the limits of the elements, e.g. "20 %" [default: 0 %].')] = (
        None
    )
    no_limits: Annotated[bool, Option("--no-limits", help="Ignore the limits that the elements declare.")] = False
    case: Annotated[
        Texts,
        Option(
            metavar="PATH=VALUE",
            help=(
                'Further operating case in which the constraints must hold, e.g. "environment.temperature=35 '
                'degC"; repeatable.'
            ),
        ),
    ] = None
    grid: Annotated[
        int | None, Option(help="Points of each free parameter for a comparison with a full grid, e.g. 9.")
    ] = None
    sample: Annotated[int, Option(help="Number of designs in the first sample, a power of 2.")] = 64
    descents: Annotated[int, Option(help="Number of designs from which a gradient descent starts.")] = 3
    seed: Annotated[int, Option(help="Seed of the first sample.")] = 0

    def check(self) -> None:
        """Raise `InputError` for a number out of range or an option without effect."""
        refuse_idle("--life", self.no_limits and self.life is not None, "--no-limits ignores all limits")
        if self.sample < 1 or self.sample & (self.sample - 1):
            raise ParameterError(f"Option `--sample` must be a power of 2, such as 64, but is {self.sample}.")
        if self.descents < 1:
            raise ParameterError(f"Option `--descents` must be at least 1, but is {self.descents}.")
        if self.grid is not None and self.grid < 2:
            raise ParameterError(f"Option `--grid` must be at least 2, but is {self.grid}.")

    def search(self, scenario: Scenario, best: BestSoFar, *, saved: bool) -> OptimisedDesign:
        """Return the best design.

        Args:
            scenario: start of the search.
            best: receives the best design so far.
            saved: True if the scenario will be written.
        """
        from martensite.design.optimise.optimise import optimise_design
        from martensite.design.optimise.search import DesignSearch

        if scenario.bench is not None:
            raise InputError(
                "A scenario with sensors or controllers cannot be designed: take it without them, "
                "and tune its controller after that."
            )
        free = self.free or []
        if saved:
            require_written(scenario, free)

        def keep(question: DesignQuestion, numbers: Sequence[float], kept: bool) -> None:
            lead = "# best so far" + ("" if kept else ", NOT KEEPING all limits")
            best.keep(lambda: f"{lead}\n\n{_write_numbers(question, numbers, scenario)}")

        with rescue_answer(best.save), show_share("designing") as tell:
            optimum = optimise_design(
                scenario.system,
                scenario.waveform,
                scenario.duration,
                free,
                minimise=self.minimise,
                maximise=self.maximise,
                subject=self.subject or (),
                life=None if self.no_limits else read_quantity("life", self.life or "0", "1"),
                cases=self.case or (),
                samples=scenario.samples,
                step=scenario.step,
                search=DesignSearch(sample=self.sample, descents=self.descents, seed=self.seed),
                scenario_paths=name_targets(scenario),
                watch=tell,
                keep=keep,
            )
            if self.grid is None:
                return optimum
            from martensite.design.optimise.search import scan_designs

            watch = None if tell is None else partial(tell, "grid")
            compared = scan_designs(optimum.designs, self.grid, watch)
            return replace(optimum, scan=compared)


@app.command("design", rich_help_panel="Design")
@spread_options
def design(
    source: ScenarioSource,
    options: DesignOptions,
    answer: JudgedOptions,
    out: Annotated[Path | None, Option(help="Scenario with the optimised parameters to write: .toml.")] = None,
) -> None:
    """Optimise parameters of a scenario within limits.

    Goal and constraints are measures of the run, such as stroke, rise-time, energy, max(stress) or at(position,
    time=2 s). The search uses derivatives of the simulation. The limits of the elements always apply, as in `run`.
    If no design keeps all limits, the exit code is 1, and --save-anyway writes the nearest design.
    """
    outputs = answer.check_files(out, ".toml")
    options.check()
    loaded = source.load()
    best_design = options.search(loaded, name_interrupted(out, source.file), saved=out is not None)
    from martensite.show.figures.design import plot_design
    from martensite.show.summaries.design import describe_verdict, summarise_design

    refused = outputs.answer_verdict(
        Verdict(not best_design.feasible, describe_verdict(best_design)),
        summarise_design(best_design, loaded.title),
        answer,
        lambda: write_design(best_design, loaded),
        lambda: plot_design(best_design, loaded.title),
    )
    if refused:
        raise Exit(1)


def name_targets(scenario: Scenario) -> dict[str, str]:
    """Map the system path of each possible free number to its scenario path."""
    from martensite.design.optimise.targets import name_level
    from martensite.scenario.assemble import waveform_path
    from martensite.simulate.waveform_levels import PEAK, WaveformLevels

    system, places = scenario.system, scenario.places
    table = {leaf.path: places.path(leaf.path) for leaf in system.leaves()}
    steering = WaveformLevels(system, scenario.waveform, scenario.duration)
    for level in steering.available():
        before = waveform_path(system, level.drive, places.drive)
        if level.name == PEAK:
            before = before.removesuffix("waveform.")
        table[name_level(level.drive, level.name)] = before + level.name
    return table


def require_written(scenario: Scenario, free: Sequence[str]) -> None:
    """Raise `InputError` if a peak is free whose waveform is not in the scenario file."""
    from martensite.simulate.waveform_levels import PEAK

    for text in free:
        name = text.partition("=")[0].strip()
        before, _, last = name.rpartition(".")
        if last == PEAK and isinstance(_find_waveform(scenario, f"{before}.").get("file"), str):
            raise InputError(
                f"`{name}` is the peak of a waveform in a separate file, so no scenario can be "
                "written with another; leave out --out."
            )


def write_design(optimum: OptimisedDesign, scenario: Scenario) -> str:
    """Return the optimised scenario as TOML."""
    sense = "most" if optimum.question.is_maximised else "least"
    goal = f"# designed for the {sense} {optimum.question.goal.words}"
    limits = [f"# subject to {one.words}" for one in optimum.question.subject]
    missed = [f"# NOT KEPT: {words}" for words in optimum.violated_constraints]
    return "\n".join(
        [goal, *limits, *missed, f"# {optimum.life}", "", _write_numbers(optimum.question, optimum.numbers, scenario)]
    )


def _write_numbers(question: DesignQuestion, numbers: Sequence[float], scenario: Scenario) -> str:
    """Return the scenario as TOML with other free numbers [SI]; whole numbers are rounded."""
    from martensite.base.toml_text import as_toml
    from martensite.scenario.overrides import change_document

    changed: dict[str, Any] = {}
    for one, value in zip(question.free, numbers, strict=True):
        for target in one.targets:
            changed |= _write_settings(target, float(round(value)) if one.whole else value, scenario, whole=one.whole)
    return as_toml(change_document(tomllib.loads(scenario.text), changed))


def _write_settings(target: Target, value: float, scenario: Scenario, *, whole: bool) -> dict[str, Any]:
    from martensite.scenario.exact_text import exact_text
    from martensite.simulate.waveform_levels import PEAK

    if target.level is not None and target.level.name == PEAK:
        return _scale_levels(target, value / target.value, scenario)
    if target.unit == "1":
        return {target.name: int(value) if whole else value}
    return {target.name: exact_text(value, target.unit)}


def _scale_levels(target: Target, factor: float, scenario: Scenario) -> dict[str, Any]:
    from martensite.base import units
    from martensite.scenario.exact_text import exact_text
    from martensite.simulate.drive_waveforms import by_name

    before = target.name.removesuffix("peak")
    levels = _find_waveform(scenario, before).get("values")
    if isinstance(levels, list):
        values = [units.parse_quantity(v, target.unit) if isinstance(v, str) else float(v) for v in levels]
        return {f"{before}waveform.values": [exact_text(factor * v, target.unit) for v in values]}
    level = target.level
    drive = "" if level is None else level.drive
    wave = by_name(scenario.system, scenario.waveform)[drive]
    return {
        f"{before}waveform.{leaf.path}": exact_text(factor * leaf.value, target.unit)
        for leaf in wave.leaves()
        if leaf.declared.unit == "drive"
    }


def _find_waveform(scenario: Scenario, before: str) -> dict[str, Any]:
    node: Any = tomllib.loads(scenario.text)
    for key in f"{before}waveform".split("."):
        node = node.get(key, {}) if isinstance(node, dict) else {}
    return node if isinstance(node, dict) else {}
