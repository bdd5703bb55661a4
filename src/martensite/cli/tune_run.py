"""The run of a tuning for the command line: read the options, test or search, judge."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from martensite.base.errors import InputError, ParameterError, UnknownNameError
from martensite.cli.options import quantity
from martensite.cli.tune import METHODS
from martensite.cli.tune_plants import drawn_plants, judged
from martensite.cli.waiting import share_bar, spinner

if TYPE_CHECKING:
    from martensite.control.loop.bench import Bench
    from martensite.design.rules.rule_starts import LoopTests
    from martensite.design.tuning.bench_tuning import TunedBench
    from martensite.design.tuning.loop_runs import LoopRuns
    from martensite.design.tuning.over_plants import Ratio
    from martensite.design.tuning.perturbed import Plants
    from martensite.scenario.scenario import Scenario

TRIED = 3
"""Starts by rules that a search is given: the best."""
PID = ("Kp", "Ki", "Kd")


@dataclass(frozen=True)
class Given:
    """What the command line says about a tuning."""

    method: str
    rule: str | None
    form: str | None
    level: str | None
    free: str | None
    goal: str | None
    spread: Sequence[str]
    plants: int | None
    seed: int
    loop: str | None
    duration: str | None

    def check(self) -> None:
        """Raise `InputError` for an unknown method, or an option without effect."""
        if self.method not in METHODS:
            raise UnknownNameError("method of tuning", self.method, METHODS)
        search = {"free": self.free, "goal": self.goal}
        rules = {"rule": self.rule, "form": self.form}
        idle = rules if self.method == "gradient" else search
        name = next((name for name, value in idle.items() if value is not None), None)
        if name is not None:
            raise InputError(f"Option `--{name}` has no effect with --method {self.method}.")
        known = self._rules()
        if self.rule is not None and self.rule not in known:
            raise UnknownNameError(f"rule for --method {self.method}", self.rule, known)
        if self.plants is not None and not self.spread:
            raise InputError("Option `--plants` has no effect without --spread.")

    def _rules(self) -> list[str]:
        """Rules of the method."""
        from martensite.design.rules.formulas import RULES
        from martensite.design.rules.relay import RELAY_RULES

        return list(RULES if self.method == "rules" else RELAY_RULES)


@dataclass(frozen=True, eq=False)
class Tuning:
    """A finished tuning."""

    scenario: Scenario
    given: Given
    found: TunedBench
    drive: str
    tests: LoopTests | None
    origin: str
    """Where the numbers come from, in words."""
    others: int
    """Plants it was judged on that it was not tuned on."""
    ratio: Ratio | None
    """ITAE after over before on them."""


def run_tuning(scenario: Scenario, given: Given) -> Tuning:
    """Do what the command line says.

    Raises:
        InputError: the scenario has no loop, or an option does not fit it.
        SolveError: the loop cannot be run.
    """
    from martensite.design.tuning.loop_runs import loop_of

    bench = _bench(scenario)
    drive = loop_of(bench, given.loop)
    length = _duration(given, scenario)
    with spinner("reading"):
        runs = _runs(bench, length, drive, scenario)
    seen, others = drawn_plants(given.spread, given.plants, given.seed, scenario, bench)
    if given.method == "gradient":
        found, tests, origin = _searched(runs, given, length, scenario, seen)
    else:
        found, tests, origin = _ruled(runs, given, scenario)
    return Tuning(
        scenario, given, found, drive, tests, origin, others.count if others else 0,
        judged(runs, found, others),
    )  # fmt: skip


def _bench(scenario: Scenario) -> Bench:
    if scenario.bench is None or not scenario.bench.controllers.members():
        outside = ", ".join(one.registered_name for one in scenario.outside.values())
        what = f"`{outside}` runs outside of the bench and" if outside else "The scenario"
        rest = "cannot be tuned." if outside else "has no [controller] that could be tuned."
        raise InputError(f"{what} {rest}")
    if scenario.outside:
        raise InputError("A scenario with a controller outside of the bench cannot be tuned.")
    return scenario.bench


def _duration(given: Given, scenario: Scenario) -> float:
    if given.duration is None:
        return scenario.duration
    length = quantity("duration", given.duration, "s")
    if not length > 0.0:
        raise ParameterError(f"Option `--duration` must be above 0 s, but is {given.duration}.")
    return length


def _runs(bench: Bench, duration: float, drive: str, scenario: Scenario) -> LoopRuns:
    from martensite.design.tuning.loop_runs import LoopRuns
    from martensite.simulate.driven import by_name

    waves = by_name(scenario.system, scenario.waveform)
    return LoopRuns(bench, duration, drive=drive, seed=scenario.seed, waveforms=waves)


# ---------------------------------------------------------------- methods


def _level(given: Given, runs: LoopRuns) -> float:
    """Where step and relay are laid."""
    from martensite.control.loop.names import list_readings

    measured = runs.bench.controllers.members()[runs.drive].measured
    if given.level is not None:
        return quantity("level", given.level, list_readings(runs.bench)[measured].unit)
    nominal = runs.run(runs.table({}, 1))
    low = min(float(nominal.reference.min()), float(nominal.output[0, 0]))
    high = max(float(nominal.reference.max()), float(nominal.output[0, 0]))
    return 0.5 * (low + high)


def _tests(given: Given, runs: LoopRuns, scenario: Scenario) -> LoopTests:
    from martensite.design.rules.rule_starts import loop_tests
    from martensite.simulate.driven import by_name

    waves = by_name(scenario.system, scenario.waveform)
    with spinner("step and relay test"):
        return loop_tests(
            runs.bench, _level(given, runs), drive=runs.drive, seed=scenario.seed,
            waveforms=waves,
        )  # fmt: skip


def _ruled(runs: LoopRuns, given: Given, scenario: Scenario) -> tuple[TunedBench, LoopTests, str]:
    """Gains by one rule, and the loop before and after."""
    from martensite.design.rules.formulas import gains_by_rule
    from martensite.design.rules.relay import gains_by_relay
    from martensite.design.rules.rule_starts import pid_values
    from martensite.design.tuning.bench_tuning import compared

    tests, form = _tests(given, runs, scenario), given.form or "pid"
    if given.method == "rules":
        rule = given.rule or "simc"
        gains = gains_by_rule(tests.step.model(), rule, form, period=runs.bench.period)
    elif tests.cycle is None:
        raise InputError("The relay makes no limit cycle here; choose another --level.")
    else:
        rule = given.rule or "tyreus-luyben"
        gains = gains_by_relay(tests.cycle, rule, form)
    values = pid_values(runs.bench, gains, runs.drive)
    return compared(runs, values), tests, f"{form} by rule {rule}"


def _searched(
    runs: LoopRuns, given: Given, length: float, scenario: Scenario, plants: Plants | None
) -> tuple[TunedBench, LoopTests | None, str]:
    """Gains of least cost."""
    from martensite.control.controllers.pid import Pid
    from martensite.design.tuning.bench_tuning import tune_bench
    from martensite.design.tuning.gain_search import Search
    from martensite.design.tuning.goals import Goal
    from martensite.simulate.driven import by_name

    goal = Goal(error=given.goal or "itae")
    controller = runs.bench.controllers.members()[runs.drive]
    free = _free(given, runs, isinstance(controller, Pid))
    tests, starts = _starts(given, runs, scenario, isinstance(controller, Pid))
    with share_bar("tuning") as tell:
        found = tune_bench(
            runs.bench, length, free, goal=goal, plants=plants, starts=starts, drive=runs.drive,
            search=Search(seed=given.seed), noise_seed=scenario.seed, watch=tell,
            waveforms=by_name(scenario.system, scenario.waveform),
        )  # fmt: skip
    count = plants.count if plants else 1
    where = f"on {count} plants" if plants else "on the plant of the scenario"
    return found, tests, f"least cost ({goal.error}) {where}"


def _free(given: Given, runs: LoopRuns, pid: bool) -> list[str]:
    """Names of what is searched, with the loop that they are in."""
    if given.free is None and not pid:
        raise InputError("Option `--free` is needed for a controller that is no `pid`.")
    names = PID if given.free is None else [name.strip() for name in given.free.split(",")]
    own = {leaf.path for leaf in runs.bench.controllers.members()[runs.drive].leaves()}
    return [f"{runs.drive}.{x}" if x.partition("=")[0].strip() in own else x for x in names]


def _starts(
    given: Given, runs: LoopRuns, scenario: Scenario, pid: bool
) -> tuple[LoopTests | None, list[Mapping[str, float]]]:
    """The best gains by rules on the nominal plant; none where the tests cannot be made."""
    if not pid:
        return None, []
    from martensite.design.rules.rule_starts import best_rules

    try:
        tests = _tests(given, runs, scenario)
    except InputError:
        if given.level is not None:
            raise
        return None, []
    return tests, best_rules(runs, tests, TRIED)
