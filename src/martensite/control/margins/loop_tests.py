"""Tests of a loop: margins, pace, offset, sampling, noise, observability.

Every test yields findings for a `LoopCase`, and raises an error with the reason if it is impossible. Textbook bounds:
M_s at most 2, phase margin 30°, gain margin 2 (Åström and Murray 2008, section 11.3), and at least four samples per
rise of the plant (Åström and Wittenmark 1997, section 2.9).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from typing import Any

import numpy as np

from martensite.base.errors import InputError, MartensiteError
from martensite.base.formats import write_difference, write_percent, write_quantity
from martensite.base.units import DIFFERENCE
from martensite.control.loop.findings import LoopFinding
from martensite.control.margins.linear_loop import LinearLoop, measure_noise, measure_rise
from martensite.control.margins.loop_case import LoopCase
from martensite.control.margins.loop_points import SOON, find_validity, linearise_case, list_first_answers
from martensite.control.margins.margins import compute_margins
from martensite.control.margins.observability import check_observability
from martensite.control.margins.pace import check_pace

SENSITIVITY, LEAST_PHASE, LEAST_GAIN = 2.0, math.radians(30.0), 2.0
SAMPLES_PER_RISE = 4.0
OFFSET = 0.05
"""Largest steady error as a fraction of the reachable range."""
LOUD = 0.1
"""Largest change of the signal by noise or one step of a reading, as a fraction of its range."""
KICK = 10.0
"""First answer over a later answer above which a derivative is unfiltered."""
DEVIATIONS = 2.0
"""Standard deviations of a reading below which a band is too narrow."""
Tests = dict[str, Callable[[LoopCase], Iterator[LoopFinding]]]


def make_tests(margins: list[Mapping[str, Any]]) -> Tests:
    """Return the tests by name; they append rows of margins to a list."""
    cache: dict[str, list[LinearLoop] | MartensiteError] = {}

    def find_loops(case: LoopCase) -> list[LinearLoop]:
        if case.drive not in cache:
            try:
                cache[case.drive] = linearise_case(case)
            except MartensiteError as error:
                cache[case.drive] = error
        loops = cache[case.drive]
        if isinstance(loops, MartensiteError):
            raise loops
        return loops

    def check_margins(case: LoopCase) -> Iterator[LoopFinding]:
        rows = [tabulate_loop(case, one) for one in find_loops(case)]
        margins.extend(rows)
        yield from judge_margins(case, rows)

    return {
        "pace": check_pace,
        "margins": check_margins,
        "offset": lambda case: check_offset(case, find_loops(case)),
        "sampling": lambda case: check_sampling(case, find_loops(case)),
        "noise": lambda case: check_noise(case, find_loops(case)),
        "derivative": check_derivative,
        "band": check_band,
        "observability": check_observability,
    }


def tabulate_loop(case: LoopCase, one: LinearLoop) -> dict[str, Any]:
    """Return a row: operating point, plant, margins, and range of validity."""
    margins, times = compute_margins(one.loop), one.plant.time_constants()
    low, high = find_validity(case, one)
    return {
        "drive": case.drive,
        "branch": one.branch,
        "reading": one.reading,
        "unit": case.unit,
        "signal": one.point.signal,
        "plant_gain": float(one.plant.gain()[0, 0]),
        "time_constant": float(times[0]) if len(times) else 0.0,
        **vars(margins),
        "sensitivity": margins.sensitivity,
        "holds_from": low,
        "holds_to": high,
    }


def judge_margins(case: LoopCase, rows: list[dict[str, Any]]) -> Iterator[LoopFinding]:
    """Yield the worst row of each branch that is beyond the bounds."""
    for branch in dict.fromkeys(row["branch"] for row in rows):
        mine = [row for row in rows if row["branch"] == branch]
        swinging = [row for row in mine if not row["stable"]]
        worst = max(swinging or mine, key=lambda row: row["sensitivity"])
        at = f"at `{case.controller.measured}` of {write_quantity(worst['reading'], case.unit, 3)}, {branch}"
        numbers = worst["sensitivity"], SENSITIVITY, "1"
        if swinging:
            sentence = f"The loop swings {at}: it is unstable at {len(swinging)} of {len(mine)} points there."
            remedy = "Try lower gains, a shorter period or a quicker sensor."
            yield case.find("margins", "controllers", (sentence, remedy), numbers, fault=len(swinging) == len(mine))
        elif is_near(worst):
            sentence = (
                f"The loop is near to swinging {at}: M_s {worst['sensitivity']:.2f}, gain margin {worst['gain']:.2f}, "
                f"phase margin {math.degrees(worst['phase']):.0f}°, delay margin "
                f"{write_quantity(worst['delay'], 's', 3)}."
            )
            yield case.find("margins", "controllers", (sentence, "Try lower gains."), numbers)


def is_near(row: Mapping[str, Any]) -> bool:
    """Return whether a margin is beyond its bound."""
    return row["sensitivity"] > SENSITIVITY or row["phase"] < LEAST_PHASE or row["gain"] < LEAST_GAIN


def check_offset(case: LoopCase, loops: list[LinearLoop]) -> Iterator[LoopFinding]:
    """Check that the steady state of the loop is at its reference, on both branches."""
    reached = case.read(case.heating)
    allowed = OFFSET * float(np.ptp(reached))
    worst = max((one for one in loops if one.branch != "dead band"), key=lambda one: abs(one.offset))
    if abs(worst.offset) > allowed:
        sentence = (
            f"The loop rests beside its reference: at {write_quantity(worst.reading, case.unit, 3)}, {worst.branch}, "
            f"only an error of {write_difference(worst.offset, case.unit, 3)} gives the signal of "
            f"{worst.point.signal:.3g} that it takes."
        )
        numbers = abs(worst.offset), allowed, case.unit
        yield case.find("offset", "controllers", (sentence, "Try an integral, or a feed-forward."), numbers)


def check_sampling(case: LoopCase, loops: list[LinearLoop]) -> Iterator[LoopFinding]:
    """Check that the period and the age of readings are short compared with the rise of the plant."""
    period, rise = case.bench.period, min((t for t in map(measure_rise, loops) if t > 0.0), default=math.inf)
    most, words = rise / SAMPLES_PER_RISE, f"beside a plant that rises in {write_quantity(rise, 's', 3)}"
    if period > most:
        sentence = f"The period of {write_quantity(period, 's', 3)} is long {words}."
        remedy = f"Try at most {write_quantity(most, 's', 2)}."
        yield case.find("sampling", "bench.period", (sentence, remedy), (period, most, "s"))
    name = case.controller.measured
    mounted = case.bench.sensors.members().get(name)
    late = period if mounted is None else float(mounted.delay + max(mounted.sample_time, period))
    if late > 0.5 * rise:
        sentence = f"A reading is up to {write_quantity(late, 's', 3)} old when it is answered, {words}."
        yield case.find(
            "sampling", f"sensors.{name}.delay", (sentence, "Try a quicker sensor."), (late, 0.5 * rise, "s")
        )


def check_noise(case: LoopCase, loops: list[LinearLoop]) -> Iterator[LoopFinding]:
    """Check the effect of sensor noise on the signal in the closed loop."""
    sizes = [size for one in loops if (size := measure_noise(one)) is not None]
    if not sizes:
        raise InputError("the loop is unstable wherever it was linearised")
    worst, whole = max(sizes), case.limits[1] - case.limits[0]
    if worst > LOUD * whole:
        sentence = (
            f"Noise of the sensors moves the signal by {worst:.3g} rms, {write_percent(worst / whole)} of its range."
        )
        remedy = "Try lower gains, or a filter of the derivative or the reading."
        yield case.find("noise", "controllers", (sentence, remedy), (worst, LOUD * whole, "1"))


def check_derivative(case: LoopCase) -> Iterator[LoopFinding]:
    """Check the first answer to a step of the reading, and the effect of the resolution of its sensor."""
    answers, name, whole = list_first_answers(case), case.controller.measured, case.limits[1] - case.limits[0]
    at_once, later = abs(answers[0]), abs(answers[-1])
    if at_once > KICK * later > 0.0:
        sentence = (
            f"A step of `{name}` is answered by {at_once:.4g} per unit at once, by {later:.4g} {SOON} samples later: "
            "the derivative is not filtered, and all noise becomes pulses."
        )
        numbers = at_once / later, KICK, "1"
        yield case.find("derivative", "controllers", (sentence, "Filter the derivative."), numbers)
    mounted = case.bench.sensors.members().get(name)
    least = 0.0 if mounted is None else float(mounted.sensor.resolution)
    if at_once * least > LOUD * whole:
        sentence = (
            f"The least step of the sensor, {write_difference(least, case.unit, 3)}, moves the signal by "
            f"{write_percent(at_once * least / whole)} of its range."
        )
        numbers = at_once * least, LOUD * whole, "1"
        where = f"sensors.{name}.resolution"
        yield case.find("quantisation", where, (sentence, "Try lower gains or a finer sensor."), numbers)


def check_band(case: LoopCase) -> Iterator[LoopFinding]:
    """Check that bands of a controller are wider than resolution and noise of its sensor."""
    mounted = case.bench.sensors.members().get(case.controller.measured)
    if mounted is None:
        return
    least = max(float(mounted.sensor.resolution), DEVIATIONS * float(mounted.sensor.noise))
    for leaf in case.controller.leaves():
        if leaf.declared.unit == DIFFERENCE and 0.0 < leaf.value < least and not leaf.path.startswith("reference."):
            where = f"controllers.{case.drive}.{leaf.path}"
            sentence = (
                f"`{where}` is {write_difference(leaf.value, case.unit, 3)}, within noise and least step of its "
                f"sensor, {write_difference(least, case.unit, 3)}."
            )
            remedy = f"Try at least {write_difference(least, case.unit, 2)}."
            yield case.find("band", where, (sentence, remedy), (leaf.value, least, case.unit))
