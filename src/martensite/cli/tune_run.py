"""Run of a tuning, with training and test plants."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

from martensite.base.errors import InputError
from martensite.base.interrupts import rescue_answer
from martensite.cli.options import read_positive, read_quantity
from martensite.cli.progress import show_share, show_spinner
from martensite.cli.tune_answer import TuningAnswer, judge_scenario
from martensite.show.summaries.tuning import TuningOutcome, summarise_tuning

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from martensite.cli.commands.tune import TuneOptions
    from martensite.cli.outputs import BestSoFar
    from martensite.control.loop.bench import Bench
    from martensite.control.rules.rule_starts import LoopTests
    from martensite.control.tuning.bench_tuning import TunedBench
    from martensite.control.tuning.loop_runs import LoopRuns
    from martensite.control.tuning.plant_spread import Plants
    from martensite.scenario.scenario import Scenario


TRIED = 3
"""Number of best rules that start a search."""
PID = ("Kp", "Ki", "Kd")
PLANTS = 64


def run_tuning(scenario: Scenario, options: TuneOptions, best: BestSoFar) -> TuningAnswer:
    """Tune by rules, a relay or descents; `best` receives the best gains so far."""
    from martensite.control.tuning.loop_runs import find_loop

    bench = _find_bench(scenario)
    drive = find_loop(bench, options.loop)
    length = _read_duration(options, scenario)
    with show_spinner("reading"):
        runs = _make_runs(bench, length, drive, scenario)
    training_plants, others = draw_both_plants(options.spread or [], options.plants, options.seed, scenario, bench)
    if options.method == "gradient":
        tuned_bench, tests, origin = _search_gains(runs, options, length, scenario, (training_plants, others), best)
    else:
        tuned_bench, tests, origin = _apply_rule(runs, options, scenario, others)
    outcome = TuningOutcome(scenario, options.method, tuned_bench, drive, tests, origin)
    with show_spinner("checking the tuned loop"):
        verdict = judge_scenario(scenario, tuned_bench.bench, tuned_bench.judgement)
    return TuningAnswer(
        verdict,
        summarise_tuning(outcome),
        lambda: scenario.write_changed(tuned_bench.after, f"tuned: {origin}"),
        lambda: _plot_outcome(outcome),
    )


def _plot_outcome(outcome: TuningOutcome) -> Figure:
    from martensite.show.figures.tuning import plot_tuning

    return plot_tuning(outcome.tuned_bench, outcome.drive, outcome.scenario.title)


def _find_bench(scenario: Scenario) -> Bench:
    from martensite.control.tuning.rest_check import check_static_curve
    from martensite.identify.chains.plant import ModelMechanism

    if scenario.bench is None or not scenario.bench.controllers.members():
        raise InputError("The scenario has no [controller] that could be tuned.")
    plant = getattr(scenario.bench.plant, "mechanism", None)
    if isinstance(plant, ModelMechanism) and plant.model.inputs == 1:
        check_static_curve(plant.model, plant.convert_inputs([0.0])[0])
    return scenario.bench


def _read_duration(options: TuneOptions, scenario: Scenario) -> float:
    if options.duration is None:
        return scenario.duration
    return read_positive("duration", options.duration, "s")


def _make_runs(bench: Bench, duration: float, drive: str, scenario: Scenario) -> LoopRuns:
    from martensite.control.tuning.loop_runs import LoopRuns
    from martensite.simulate.drive_waveforms import by_name

    waves = by_name(scenario.system, scenario.waveform)
    return LoopRuns(bench, duration, drive=drive, seed=scenario.seed, waveforms=waves)


def _choose_level(options: TuneOptions, runs: LoopRuns) -> float:
    from martensite.control.loop.names import list_readings

    measured = runs.bench.controllers.members()[runs.drive].measured
    if options.level is not None:
        return read_quantity("level", options.level, list_readings(runs.bench)[measured].unit)
    nominal = runs.run(runs.table({}, 1))
    low = min(float(nominal.reference.min()), float(nominal.output[0, 0]))
    high = max(float(nominal.reference.max()), float(nominal.output[0, 0]))
    return 0.5 * (low + high)


def _run_tests(options: TuneOptions, runs: LoopRuns, scenario: Scenario) -> LoopTests:
    from martensite.control.rules.rule_starts import run_loop_tests
    from martensite.simulate.drive_waveforms import by_name

    waves = by_name(scenario.system, scenario.waveform)
    with show_spinner("step and relay test"):
        return run_loop_tests(
            runs.bench, _choose_level(options, runs), drive=runs.drive, seed=scenario.seed, waveforms=waves
        )


def _apply_rule(
    runs: LoopRuns, options: TuneOptions, scenario: Scenario, judged: Plants | None
) -> tuple[TunedBench, LoopTests, str]:
    from martensite.control.rules.formulas import gains_by_rule
    from martensite.control.rules.relay import RELAY_RULES, gains_by_relay
    from martensite.control.rules.rule_starts import convert_to_pid
    from martensite.control.tuning.bench_tuning import compare_gains

    tests, form = _run_tests(options, runs, scenario), options.form or "pid"
    if options.method == "rules":
        rule = options.rule or "simc"
        gains = gains_by_rule(tests.step.model(), rule, form, period=runs.bench.period)
    elif tests.cycle is None:
        raise InputError("The relay makes no limit cycle here; choose another --level.")
    else:
        rule = options.rule or "tyreus-luyben"
        # A derivative by a relay rule amplifies the noise: the signal chatters.
        form = options.form or ("pi" if "pi" in RELAY_RULES[rule] else "pid")
        gains = gains_by_relay(tests.cycle, rule, form)
    values = convert_to_pid(runs.bench, gains, runs.drive)
    return compare_gains(runs, values, judged=judged), tests, f"{form} by rule {rule}"


def _search_gains(
    runs: LoopRuns,
    options: TuneOptions,
    length: float,
    scenario: Scenario,
    both: tuple[Plants | None, Plants | None],
    best: BestSoFar,
) -> tuple[TunedBench, LoopTests | None, str]:
    """Search on the training plants and score on the test plants."""
    from martensite.control.controllers.pid import Pid
    from martensite.control.tuning.bench_tuning import tune_bench
    from martensite.control.tuning.gain_search import TuningSearch
    from martensite.control.tuning.goals import TuningGoal
    from martensite.simulate.drive_waveforms import by_name

    plants, judged = both
    goal = TuningGoal(error=options.goal or "itae")
    controller = runs.bench.controllers.members()[runs.drive]
    free = _name_free(options, runs, isinstance(controller, Pid))
    tests, starts = _find_starts(options, runs, scenario, isinstance(controller, Pid))

    def keep(gains: dict[str, float]) -> None:
        best.keep(lambda: scenario.write_changed(gains, "best gains so far"))

    with rescue_answer(best.save), show_share("tuning") as tell:
        tuned = tune_bench(
            runs.bench,
            length,
            free,
            goal=goal,
            plants=plants,
            judged=judged,
            starts=starts,
            drive=runs.drive,
            search=TuningSearch(seed=options.seed),
            noise_seed=scenario.seed,
            watch=tell,
            keep=keep,
            waveforms=by_name(scenario.system, scenario.waveform),
        )
    count = plants.count if plants else 1
    where = f"on {count} plants" if plants else "on the plant of the scenario"
    return tuned, tests, f"least cost ({goal.error}) {where}"


def _name_free(options: TuneOptions, runs: LoopRuns, pid: bool) -> list[str]:
    if options.free is None and not pid:
        raise InputError("Option `--free` is needed for a controller that is no `pid`.")
    names = PID if options.free is None else [name.strip() for name in options.free.split(",")]
    own = {leaf.path for leaf in runs.bench.controllers.members()[runs.drive].leaves()}
    return [f"{runs.drive}.{x}" if x.partition("=")[0].strip() in own else x for x in names]


def _find_starts(
    options: TuneOptions, runs: LoopRuns, scenario: Scenario, pid: bool
) -> tuple[LoopTests | None, list[Mapping[str, float]]]:
    """Return the best gains by rules on the nominal plant; empty if the tests fail."""
    if not pid:
        return None, []
    from martensite.control.rules.rule_starts import choose_best_rules

    try:
        tests = _run_tests(options, runs, scenario)
    except InputError:
        if options.level is not None:
            raise
        return None, []
    return tests, choose_best_rules(runs, tests, TRIED)


def draw_both_plants(
    texts: Sequence[str], count: int | None, seed: int, scenario: Scenario, bench: Bench
) -> tuple[Plants | None, Plants | None]:
    """Return training and test plants; None without a spread."""
    if not texts:
        return None, None
    from martensite.control.tuning.plant_spread import draw_plants

    spreads = dict(_read_spread(text, scenario, bench) for text in texts)
    first, second = (draw_plants(bench, spreads, PLANTS if count is None else count, seed + k) for k in (0, 1))
    return first, second


def _read_spread(text: str, scenario: Scenario, bench: Bench) -> tuple[str, float]:
    from martensite.search.free_numbers import Target, find_alike

    name, equals, size = (part.strip() for part in text.partition("="))
    if not equals:
        raise InputError(f'`{text}` is no spread; write `PATH=SPREAD`, e.g. element.diameter="3 %".')
    leaves = bench.plant.leaves()
    targets = [Target.from_leaf(leaf, scenario.places.path(f"plant.{leaf.path}")) for leaf in leaves]
    (target,) = find_alike(name, targets, several=False)
    if target.unit == "K" and "deg" in size:
        raise InputError(f"A spread of a temperature is a difference: write `{name}=3 K`.")
    return target.path, read_quantity("spread", size, "K" if target.unit == "K" else "1")
