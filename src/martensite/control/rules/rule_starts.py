"""Gains of a PID controller on a bench by every rule: a step test, a relay test, all that follows.

Both tests are laid around a level of the reading: `holding` finds the signals that hold it on the
way up and down, u_h and u_c; the step goes from 0.3 (u_h - u_c) below the lower to as much above
the upper one, the relay swings 0.75 (u_h - u_c) around their middle, both within the limits of the
controller.
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
"""Margins of step and relay in widths of the hysteresis; band of the relay in shares of the range
of the reading in the step test."""
LEAST_STEP = 0.05
"""Least width of step and swing, as a share of the limits."""


class LoopTests(NamedTuple):
    """Results of step and relay tests around a level."""

    holding: HoldingSignals
    step: StepTest
    cycle: LimitCycle | None
    """Limit cycle of the relay; None without a limit cycle."""


def find_pid(bench: Bench, drive: str | None = None) -> tuple[str, Pid]:
    """Return the drive and the PID controller of a loop; `ParameterError` if its controller is another one."""
    name = find_loop(bench, drive)
    controller = bench.controllers.members()[name]
    if not isinstance(controller, Pid):
        raise ParameterError(
            f"Tuning rules need a `pid` controller, but the controller of `{name}` is `{controller.registered_name}`."
        )
    return name, controller


def convert_to_pid(bench: Bench, gains: IdealGains, drive: str | None = None) -> dict[str, float]:
    """Return the gains as numbers of the PID controller of a loop, by path in the bench."""
    name, controller = find_pid(bench, drive)
    found = gains.per_sample(bench.period) if controller.sampled else gains.per_second()
    numbers = found._asdict()
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
    """Step and relay test of a loop with a PID controller, around a level.

    Args:
        bench: the bench.
        level: of the reading, in SI.
        drive: whose loop; needed if there are several.
        hold: time at each level of the step test [s].
        seed: of noise and jitter; None for none.
        waveforms: of other drives of the plant.

    Raises:
        ParameterError: the loop has no PID controller, or the level cannot be held.
        DataError: the output does not answer.
    """
    name, controller = find_pid(bench, drive)
    low, high = float(controller.law.low), float(controller.law.high)
    found = find_holding_signals(bench, level, low, high, drive=name, hold=hold, waveforms=waveforms)
    width = max(found.width, LEAST_STEP * (high - low))
    first = max(min(found) - BEYOND * width, low)
    last = min(max(found) + BEYOND * width, high)
    stepped = run_step_test(bench, first, last - first, drive=name, hold=hold, seed=seed, waveforms=waveforms)
    swing = min(SWING * width, high - found.bias, found.bias - low)
    band = BAND * float(stepped.reading.max() - stepped.reading.min())
    return LoopTests(found, stepped, _test_relay(bench, level, found, swing, band, name, seed, stepped))


def _test_relay(
    bench: Bench,
    level: float,
    held: HoldingSignals,
    swing: float,
    band: float,
    drive: str,
    seed: int | None,
    stepped: StepTest,
) -> LimitCycle | None:
    reverse = stepped.heating.first_order.gain < 0.0
    try:
        return run_relay_test(bench, level, held.bias, swing, band, drive=drive, reverse=reverse, seed=seed)
    except DataError:
        return None


def gains_by_tests(found: LoopTests, period: float) -> Mapping[str, IdealGains]:
    """Return the gains by all rules, by name, such as `simc pid (heating)` or `relay tyreus-luyben pi`.

    Args:
        found: step and relay test.
        period: of the controller [s].
    """
    models = {which: found.step.model(which) for which in ("heating", "cooling", "mean")}
    gains = {
        f"{rule} {form} ({which})": gains_by_rule(model, rule, form, period=period)
        for rule in RULES
        for form in FORMS
        for which, model in models.items()
    }
    if found.cycle is not None:
        for rule, forms in RELAY_RULES.items():
            for form in forms:
                gains[f"relay {rule} {form}"] = gains_by_relay(found.cycle, rule, form)
    return gains


def choose_best_rules(runs: LoopRuns, found: LoopTests, count: int) -> list[Mapping[str, float]]:
    """Return the gains by rules with the least ITAE on the nominal plant, as numbers by path.

    Args:
        runs: of the loop.
        found: its step and relay test.
        count: how many are wanted.
    """
    gains = gains_by_tests(found, runs.bench.period).values()
    tried = [convert_to_pid(runs.bench, one, runs.drive) for one in gains]
    table = runs.table({p: [numbers[p] for numbers in tried] for p in tried[0]}, len(tried))
    seen = runs.run(table)
    spent = np.asarray(compute_itae(seen, Course(seen.one(0), runs.bench.period)))
    order = np.argsort(np.where(np.isfinite(spent), spent, np.inf), kind="stable")
    return [tried[int(k)] for k in order[:count]]
