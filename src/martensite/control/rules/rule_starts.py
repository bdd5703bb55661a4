"""Gains of a PID controller on a bench by all rules, from a step test and a relay test.

Both tests lie around a level of the reading. `find_holding_signals` finds the signals u_h and u_c that hold it on the
heating and cooling branch. The step goes from 0.3 (u_h - u_c) below the lower to as much above the higher signal; the
relay switches 0.75 (u_h - u_c) around their mean, both within the limits of the controller.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from martensite.base.errors import DataError, ParameterError
from martensite.control.controllers.pid import Pid
from martensite.control.loop.bench import Bench
from martensite.control.rules.formulas import FORMS, RULES, IdealGains, gains_by_rule
from martensite.control.rules.relay import RELAY_RULES, LimitCycle, gains_by_relay, run_relay_test
from martensite.control.rules.step_test import HoldingSignals, StepTest, Waveforms, find_holding_signals, run_step_test
from martensite.control.tuning.goals import Course
from martensite.control.tuning.loop_runs import LoopRuns, find_loop
from martensite.control.tuning.measures import compute_itae

BEYOND, SWING, BAND = 0.3, 0.75, 0.02
"""Margins of step and relay in widths of the hysteresis; band of the relay over the range of the step test."""
LEAST_STEP = 0.05
"""Least width of step and relay over the range of the signal."""


class LoopTests(NamedTuple):
    """Results of step and relay tests around a level."""

    holding: HoldingSignals
    step: StepTest
    cycle: LimitCycle | None
    """Limit cycle of the relay, or None."""


def find_pid(bench: Bench, drive: str | None = None) -> tuple[str, Pid]:
    """Return drive and PID controller of a loop; raise `ParameterError` for another controller."""
    name = find_loop(bench, drive)
    controller = bench.controllers.members()[name]
    if not isinstance(controller, Pid):
        raise ParameterError(
            f"Tuning rules need a `pid` controller, but the controller of `{name}` is `{controller.registered_name}`."
        )
    return name, controller


def convert_to_pid(bench: Bench, gains: IdealGains, drive: str | None = None) -> dict[str, float]:
    """Return the gains as parameters of the PID controller of a loop, by path in the bench."""
    name, controller = find_pid(bench, drive)
    numbers = (gains.per_sample(bench.period) if controller.sampled else gains.per_second())._asdict()
    if math.isfinite(controller.Ti) or controller.Td != 0.0:
        numbers = {"Kp": gains.Kp, "Ti": gains.Ti, "Td": gains.Td}
    return {f"controllers.{name}.{key}": float(v) for key, v in numbers.items()}


def run_loop_tests(
    bench: Bench,
    level: float,
    *,
    drive: str | None = None,
    hold: float | None = None,
    seed: int | None = 0,
    waveforms: Waveforms | None = None,
) -> LoopTests:
    """Run a step test and a relay test of a loop with a PID controller, around a level.

    Args:
        bench: the bench.
        level: level of the reading, in SI.
        drive: drive of the loop; required for several controllers.
        hold: time at each level of the step test [s].
        seed: seed of noise and jitter; None for runs without noise.
        waveforms: signals of other drives of the plant.

    Raises:
        ParameterError: the loop has no PID controller, or the level cannot be held.
        DataError: the output does not respond.
    """
    name, controller = find_pid(bench, drive)
    low, high = float(controller.law.low), float(controller.law.high)
    holding = find_holding_signals(bench, level, low, high, drive=name, hold=hold, waveforms=waveforms)
    width = max(holding.width, LEAST_STEP * (high - low))
    first = max(min(holding) - BEYOND * width, low)
    last = min(max(holding) + BEYOND * width, high)
    stepped = run_step_test(bench, first, last - first, drive=name, hold=hold, seed=seed, waveforms=waveforms)
    swing = min(SWING * width, high - holding.bias, holding.bias - low)
    band = BAND * float(stepped.reading.max() - stepped.reading.min())
    return LoopTests(holding, stepped, _test_relay(bench, level, holding, swing, band, name, seed, stepped))


def _test_relay(
    bench: Bench,
    level: float,
    holding: HoldingSignals,
    swing: float,
    band: float,
    drive: str,
    seed: int | None,
    stepped: StepTest,
) -> LimitCycle | None:
    reverse = stepped.heating.first_order.gain < 0.0
    try:
        return run_relay_test(bench, level, holding.bias, swing, band, drive=drive, reverse=reverse, seed=seed)
    except DataError:
        return None


def gains_by_tests(tests: LoopTests, period: float) -> Mapping[str, IdealGains]:
    """Return the gains by all rules, by name, such as `simc pid (heating)` or `relay tyreus-luyben pi`.

    Args:
        tests: step and relay test.
        period: period of the controller [s].
    """
    models = {which: tests.step.model(which) for which in ("heating", "cooling", "mean")}
    gains = {
        f"{rule} {form} ({which})": gains_by_rule(model, rule, form, period=period)
        for rule in RULES
        for form in FORMS
        for which, model in models.items()
    }
    if tests.cycle is not None:
        for rule, forms in RELAY_RULES.items():
            for form in forms:
                gains[f"relay {rule} {form}"] = gains_by_relay(tests.cycle, rule, form)
    return gains


def choose_best_rules(runs: LoopRuns, tests: LoopTests, count: int) -> list[Mapping[str, float]]:
    """Return the gains by rules with the least ITAE on the nominal plant, as parameters by path.

    Args:
        runs: runs of the loop.
        tests: step and relay test of the loop.
        count: number of results.
    """
    gains = gains_by_tests(tests, runs.bench.period).values()
    tried = [convert_to_pid(runs.bench, one, runs.drive) for one in gains]
    table = runs.table({p: [numbers[p] for numbers in tried] for p in tried[0]}, len(tried))
    outputs = runs.run(table)
    itae = np.asarray(compute_itae(outputs, Course(outputs.one(0), runs.bench.period)))
    order = np.argsort(np.where(np.isfinite(itae), itae, np.inf), kind="stable")
    return [tried[int(k)] for k in order[:count]]
