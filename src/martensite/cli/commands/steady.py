"""`steady`: steady states under constant drives."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated

from typer import Exit, Option

from martensite.base import units
from martensite.base.errors import InputError, require_known
from martensite.cli.app import app
from martensite.cli.options import ScenarioSource, Text, Texts, read_positive, refuse_idle, spread_options
from martensite.cli.outputs import AnswerOptions
from martensite.cli.progress import show_share, show_spinner

if TYPE_CHECKING:
    from martensite.cli.outputs import Outputs
    from martensite.scenario.scenario import Scenario
    from martensite.simulate.judgement import Judgement
    from martensite.simulate.steady.rotations import ResponseSweep
    from martensite.simulate.steady.subjects import Subject


@dataclass(frozen=True)
class CurveOptions:
    """Options of a curve of steady rotations."""

    over: Annotated[
        Text,
        Option(
            metavar="PATH=LOW..HIGH",
            help=(
                "Range of a drive or parameter along which a rotation is followed through its folds, e.g. "
                '"motor=1..10 V".'
            ),
        ),
    ] = None
    against: Annotated[
        Text,
        Option(
            metavar="PATH=LOW..HIGH", help="Range of a second parameter in which the folds are followed; needs --over."
        ),
    ] = None
    runs: Annotated[
        int, Option(min=0, help="Number of levels of simulated runs up and down, drawn as dots; needs --over.")
    ] = 0
    hold: Annotated[Text, Option(help='Duration of each level of --runs, e.g. "20 s".')] = None
    steps: Annotated[
        int | None, Option(min=32, help="Time steps per revolution, at least 32; needs --over [default: 512].")
    ] = None
    speed: Annotated[str, Option(help="Unit of the rotor speed: rpm, rad/s or Hz.")] = "rpm"

    def check(self) -> CurveOptions:
        """Raise `InputError` for an option that is missing or has no effect."""
        from martensite.show.summaries.steady import SPEEDS

        require_known("unit of speed", self.speed, SPEEDS)
        for name in ("against", "runs", "hold", "steps"):
            refuse_idle(f"--{name}", bool(getattr(self, name)) and self.over is None, "there is no --over")
        refuse_idle("--hold", self.hold is not None and not self.runs, "there are no --runs")
        if self.runs and self.hold is None:
            raise InputError('Option `--runs` needs the duration of each level: add `--hold "20 s"`.')
        return self


@app.command("steady", rich_help_panel="Simulate")
@spread_options
def steady(
    source: ScenarioSource,
    curve: CurveOptions,
    answer: AnswerOptions,
    drive: Annotated[
        Texts, Option(metavar="[NAME=]LEVEL", help='Constant level of a drive, e.g. "2 V" or first="3 V"; repeatable.')
    ] = None,
    start: Annotated[
        str, Option("--from", help="State before: cold, or hot (steady state under the highest drives).")
    ] = "cold",
    high: Annotated[
        Text, Option(metavar="LEVEL", help='Level of the drive before, e.g. "5 V"; needs --from hot.')
    ] = None,
    cycle: Annotated[
        bool, Option("--cycle", help="Find the limit cycle of periodic drives or of an ON/OFF loop.")
    ] = False,
) -> None:
    """Find a steady state, limit cycle or response curve.

    By default the command finds the steady state under constant drives, the limits that it exceeds, and its
    stability. The exit code is 1 if a limit is exceeded.
    """
    over = curve.check().over
    refuse_idle("--cycle", cycle and over is not None, "--over follows a rotation")
    refuse_idle("--drive", bool(drive) and cycle, "the drives of a cycle are those of the scenario")
    refuse_idle("--from", start != "cold" and (cycle or over is not None), "only a rest is come to from the hot")
    refuse_idle("--high", high is not None and start != "hot", "the rest is not come to from the hot")
    outputs, scenario = answer.check_files(), source.load()
    if cycle:
        _answer_cycle(scenario, outputs, answer.json)
    elif over is not None:
        _answer_response(scenario, outputs, answer.json, curve, over, _read_drives(scenario, drive))
    else:
        _answer_rest(scenario, outputs, answer, drive, start, high)


def _answer_rest(
    scenario: Scenario, outputs: Outputs, answer: AnswerOptions, drive: list[str] | None, start: str, high: str | None
) -> None:
    from martensite.show.summaries.steady import summarise_rest
    from martensite.simulate.steady.equilibria import find_steady_state

    refuse_idle("--figure", answer.figure is not None, "a rest is a table; ask for --over or --cycle")
    before = None if high is None else _read_drives(scenario, [high])
    with show_spinner(f"bringing {scenario.title} to rest"):
        steady_state = find_steady_state(scenario, _read_drives(scenario, drive), start=start, high=before)
    outputs.answer(summarise_rest(steady_state, scenario.title), answer.json)
    _end_with(steady_state.judgement)


def _answer_cycle(scenario: Scenario, outputs: Outputs, json: bool) -> None:
    from martensite.control.loop.switched_cycles import find_switched_cycle
    from martensite.show.figures.steady import plot_cycle
    from martensite.show.summaries.steady import summarise_cycle
    from martensite.simulate.steady.cycles import find_cycle

    with show_spinner(f"shooting for the cycle of {scenario.title}"):
        cycle = find_cycle(scenario) if scenario.bench is None else find_switched_cycle(scenario)
    outputs.answer(summarise_cycle(cycle, scenario.title), json, draw=lambda: plot_cycle(cycle, scenario.title))
    _end_with(cycle.judgement)


def _end_with(judgement: Judgement) -> None:
    if not judgement.is_within_limits:
        raise Exit(1)


def _answer_response(
    scenario: Scenario, outputs: Outputs, json: bool, curve: CurveOptions, over: str, levels: dict[str, float]
) -> None:
    from martensite.show.figures.steady import plot_response
    from martensite.show.summaries.steady import summarise_response
    from martensite.simulate.steady.curves import trace_folds
    from martensite.simulate.steady.rotations import STEPS, trace_response
    from martensite.simulate.steady.subjects import Subject

    one = Subject.read(scenario)
    name, low, high = _read_range(one, over)
    second = None if curve.against is None else _read_range(one, curve.against)
    refuse_idle("--runs", curve.runs > 0 and one.vary(name, low, high).path is not None, f"`{name}` is no drive")
    with show_share("following the curve") as tell:
        response = trace_response(scenario, name, low, high, drive=levels, steps=curve.steps or STEPS, tell=tell)
    if second is not None and not len(response.folds):
        raise InputError("The curve has no fold, so there is nothing to follow in a second number.")
    with show_spinner("following the folds"):
        boundaries = [] if second is None else [trace_folds(response, k, *second) for k in range(len(response.folds))]
    with show_spinner("running up and down"):
        sweeps = _make_runs(scenario, name, (low, high), curve, levels)
    summary = summarise_response(response, scenario.title, curve.speed, boundaries, sweeps)
    outputs.answer(
        summary, json, draw=lambda: plot_response(response, sweeps, boundaries, speed=curve.speed, title=scenario.title)
    )


def _make_runs(
    scenario: Scenario, name: str, ends: tuple[float, float], curve: CurveOptions, levels: dict[str, float]
) -> list[ResponseSweep]:
    import numpy as np

    from martensite.simulate.steady.rotations import sweep_response

    hold = read_positive("hold", curve.hold, "s")
    if hold is None:
        return []
    count = max(curve.runs, 2)
    up = np.geomspace(*ends, count) if ends[0] > 0.0 else np.linspace(*ends, count)
    both = sweep_response(scenario, name, np.concatenate([up, up[::-1]]), hold, drive=levels)
    return [both.cut(0, count), both.cut(count, 2 * count)]


def _read_drives(scenario: Scenario, given: list[str] | None) -> dict[str, float]:
    table = {one.name: one.unit for one in scenario.system.drives()}
    levels = dict[str, float]()
    for words in given or []:
        name, equals, level = words.rpartition("=")
        if not table:
            raise InputError(f"Scenario `{scenario.title}` has no drive.")
        name = name.strip() if equals else next(iter(table))
        require_known("drive", name, list(table))
        levels[name] = units.parse_quantity(level.strip(), table[name])
    return levels


def _read_range(one: Subject, words: str) -> tuple[str, float, float]:
    from martensite.search.free_numbers import SearchRange
    from martensite.search.free_text import parse_free

    text = parse_free(words, complete=True)
    return text.name, *SearchRange.read(text, one.vary(text.name, 0.0, 1.0).unit).ends
