"""A tuning, with its tests and other plants, and a design, with what holds it where it is: before and after."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from martensite.base.formats import choose_difference_unit, write_quantity
from martensite.base.summary import Block, DataTable, Sentence, Summary
from martensite.control.loop.names import list_readings
from martensite.design.optimise.optimised_design import OptimisedDesign, ReportedMeasure, RoundedDesign
from martensite.design.tuning.loop_runs import find_judged_output
from martensite.design.tuning.measures import UNITS

if TYPE_CHECKING:
    from martensite.design.rules.rule_starts import LoopTests
    from martensite.design.tuning.bench_tuning import TunedBench
    from martensite.design.tuning.plant_spread import Ratio
    from martensite.scenario.scenario import Scenario

HEAD = ("", "before", "after")
PER_TIME = {"Ki": "/s", "Kd": "*s"}
"""What gains in seconds have beside the unit of Kp."""
SHARES = ("overshoot",)
NUMBERS = ("free", "scenario", "found", "from", "to", "")
MEASURES = ("measure", "scenario", "found", "limit", "")
IMBALANCE = 0.05
"""Share of the slope of the goal that is not balanced, from which on it is told."""
COARSE = 1e-2
"""Change by half the steps from which on it is told."""


@dataclass(frozen=True, eq=False)
class TuningOutcome:
    """A finished tuning."""

    scenario: Scenario
    method: str
    """`rules`, `relay` or `gradient`."""
    found: TunedBench
    drive: str
    tests: LoopTests | None
    origin: str
    """Where the numbers come from, in words."""
    others: int
    """Plants it was judged on that it was not tuned on."""
    ratio: Ratio | None
    """ITAE after over before on them."""


def summarise_tuning(found: TuningOutcome) -> Summary:
    """Everything about a tuning."""
    tuned = found.found
    lead = f"{found.origin}; {tuned.evaluations:,} runs, {tuned.gradients:,} with derivatives"
    blocks = [
        *_describe_tests(found),
        DataTable(HEAD, _table_rows(found), right=(1, 2)),
        *_describe_others(found),
        *(Sentence(f"Caution: {note}", "caution") for note in tuned.notes),
    ]
    return Summary(found.scenario.title, blocks, _collect_numbers(found), lead)


def _describe_others(found: TuningOutcome) -> Iterator[Block]:
    if found.ratio is not None:
        yield Sentence(
            f"on {found.others} other plants: ITAE after/before {found.ratio.median:.3g} in the "
            f"median, {found.ratio.worst:.3g} at worst, better on {100.0 * found.ratio.won:.3g} %"
        )


def _describe_tests(found: TuningOutcome) -> Iterator[Block]:
    if found.tests is None or found.method == "gradient":
        return
    for name in ("heating", "cooling"):
        one = getattr(found.tests.step, name)
        K, T, L = one.first_order
        yield Sentence(f"{name}: K {K:.4g}, T {T:.4g} s, L {L:.4g} s (fit {one.fit:.1f} %)")
    cycle = found.tests.cycle
    if cycle is not None:
        steady = "" if cycle.steady else ", not steady"
        yield Sentence(f"relay: K_u {cycle.gain:.4g}, P_u {cycle.period:.4g} s, off/on {cycle.asymmetry:.3g}{steady}")


def _table_rows(found: TuningOutcome) -> list[tuple[str, str, str]]:
    tuned, places = found.found, found.scenario.places
    rows = [
        (f"{places.path(path)} [{unit}]", f"{tuned.before[path]:.5g}", f"{value:.5g}")
        for path, value, unit in _list_gains(found)
    ]
    rows.append(("cost", f"{tuned.cost_before:.4g}", f"{tuned.cost:.4g}"))
    after = tuned.measured.to_dict()
    return rows + [
        (name, _write_measure(name, value, found), _write_measure(name, after[name], found))
        for name, value in tuned.measured_before.to_dict().items()
    ]


def _write_measure(name: str, value: float, found: TuningOutcome) -> str:
    bench = found.found.bench
    unit = bench.outputs()[find_judged_output(bench, found.drive)].unit
    if math.isinf(value):
        return "never"
    if name == "hottest":
        return write_quantity(value, "K")
    if "{}" not in UNITS[name]:
        label = "" if UNITS[name] in ("1", "signal") else f" {UNITS[name]}"
        return f"{100.0 * value:.3g} %" if name in SHARES else f"{value:.4g}{label}"
    shown, factor = choose_difference_unit(unit)
    return f"{value / factor:.4g} {UNITS[name].format(shown)}"


def _collect_numbers(found: TuningOutcome) -> dict[str, Any]:
    tuned, places = found.found, found.scenario.places
    step = found.tests.step if found.tests else None
    cycle = found.tests.cycle if found.tests else None
    return {
        "title": found.scenario.title,
        "method": found.method,
        "origin": found.origin,
        "loop": found.drive,
        "parameters": {
            places.path(path): {"before": tuned.before[path], "after": value, "unit": unit}
            for path, value, unit in _list_gains(found)
        },
        "before": tuned.measured_before.to_dict() | {"cost": tuned.cost_before},
        "after": tuned.measured.to_dict() | {"cost": tuned.cost},
        "runs": tuned.evaluations,
        "gradients": tuned.gradients,
        "step_test": None
        if step is None
        else {name: getattr(step, name).first_order._asdict() for name in ("heating", "cooling")},
        "relay_test": None
        if cycle is None
        else {
            "ultimate_gain": cycle.gain,
            "ultimate_period": cycle.period,
            "amplitude": cycle.amplitude,
            "asymmetry": cycle.asymmetry,
            "steady": cycle.steady,
        },
        "other_plants": None
        if found.ratio is None
        else {
            "count": found.others,
            "itae_ratio_median": found.ratio.median,
            "itae_ratio_worst": found.ratio.worst,
            "share_improved": found.ratio.won,
        },
        "notes": tuned.notes,
    }


def _list_gains(found: TuningOutcome) -> list[tuple[str, float, str]]:
    """Path, number and unit of what was tuned."""
    bench, places = found.found.bench, found.scenario.places
    leaves = {leaf.path: leaf for leaf in bench.leaves()}
    controller = bench.controllers.members()[found.drive]
    drives = {drive.name: drive.unit for drive in bench.plant.drives()}
    base = f"{drives[found.drive]}/{list_readings(bench)[controller.measured].unit}"
    seconds = getattr(controller, "gains_are", "") == "in-seconds"
    rows: list[tuple[str, float, str]] = []
    for path, value in found.found.after.items():
        name = path.rpartition(".")[2]
        gain = name in ("Kp", "Ki", "Kd")
        unit = base + (PER_TIME.get(name, "") if seconds else "")
        rows.append((path, value, unit if gain else places.unit(leaves[path])))
    return rows


def summarise_design(found: OptimisedDesign, title: str) -> Summary:
    """Everything about a design."""
    question, counts = found.question, found.counts
    sense = "most" if question.most else "least"
    lead = (
        f"{sense} {question.goal.words}: {write_quantity(found.goal, question.goal.unit)}, of "
        f"{counts.simulations:,} simulations and {counts.slopes:,} with derivatives"
    )
    blocks = [
        DataTable(NUMBERS, _number_rows(found), right=(1, 2, 3, 4)),
        DataTable(MEASURES, _measure_rows(found), right=(1, 2, 3)),
        *_describe_whole(found),
        *_describe_balance(found),
        *_describe_grid(found),
        *_describe_doubts(found),
    ]
    return Summary(title, blocks, {"title": title} | found.to_dict(), lead)


def _describe_doubts(found: OptimisedDesign) -> Iterator[Block]:
    if found.life:
        yield Sentence(found.life)
    if found.accuracy > COARSE:
        yield Sentence(
            f"Caution: half the steps ({found.step:.3g} s) change this by "
            f"{100.0 * found.accuracy:.2g} % of limits and goal.",
            "caution",
        )
    yield from (Sentence(f"Not kept: {words}", "bad") for words in found.missed)
    yield from (Sentence(f"Caution: {note}", "caution") for note in found.notes)


def _number_rows(found: OptimisedDesign) -> list[tuple[str, ...]]:
    rows: list[tuple[str, ...]] = []
    for one, value, z in zip(found.question.free, found.numbers, found.z, strict=True):
        bound = None if one.whole else one.bound(z)
        remark = "whole" if one.whole else f"at its {bound} bound" if bound else ""
        values = (one.start, value, one.low, one.high)
        rows.append((one.name, *(write_quantity(v, one.unit) for v in values), remark))
    return rows


def _measure_rows(found: OptimisedDesign) -> list[tuple[str, ...]]:
    question = found.question
    places = {one.name: k for k, one in enumerate(question.free)}
    return [
        (one.words, _write_values(one, one.before), _write_values(one, one.after), *_write_limits(found, one.words))
        for one in found.reported
        if one.words not in places
    ]


def _write_values(one: ReportedMeasure, values: Sequence[float]) -> str:
    return ", ".join(dict.fromkeys(_write_value(value, one) for value in values))


def _write_value(value: float, one: ReportedMeasure) -> str:
    if math.isnan(value):
        return "failed"
    if math.isinf(value):
        return "never"
    if one.unit == "K" and one.words.startswith("stroke"):
        return f"{value:.5g} K"
    return write_quantity(float(f"{value:.9g}"), one.unit)


def _write_limits(found: OptimisedDesign, words: str) -> tuple[str, str]:
    question = found.question
    limits = [c for c in question.subject if c.aim.words == words]
    goal = [("most" if question.most else "least")] if words == question.goal.words else []
    pressing = [] if found.balance is None else [p.name for p in found.balance.pressing]
    active = ["active"] if any(c.words in pressing for c in limits) else []
    missed = ["not kept"] if any(c.words in found.missed for c in limits) else []
    signs = [("<= " if c.most else ">= ") + write_quantity(c.limit, c.aim.unit) for c in limits]
    return ", ".join(signs), ", ".join([*goal, *(missed or active)])


def _describe_whole(found: OptimisedDesign) -> Iterator[Block]:
    if not found.held or found.relaxed is None or found.relaxed_goal is None:
        return
    free, unit = found.question.free, found.question.goal.unit
    names = [one.name for one in free if one.whole]
    others = [(k, one) for k, one in enumerate(free) if not one.whole]
    rows = [_whole_row(one, others, unit) for one in found.held]
    head = (*names, *(one.name for _, one in others), found.question.goal.words, "kept")
    yield DataTable(head, rows, right=range(len(head) - 1))
    values = ", ".join(f"{one.name} = {v:.4g}" for one, v in zip(free, found.relaxed, strict=True) if one.whole)
    goal = write_quantity(found.relaxed_goal, unit)
    yield Sentence(f"If nothing had to be whole: {values}, {goal}.")


def _whole_row(one: RoundedDesign, others: Sequence[tuple[int, object]], unit: str) -> tuple[str, ...]:
    numbers = [write_quantity(float(f"{one.numbers[k]:.5g}"), getattr(free, "unit", "1")) for k, free in others]
    kept = "yes" if one.kept else f"no, misses {100.0 * one.violation:.2g} %"
    return (*map(str, one.whole), *numbers, write_quantity(float(f"{one.goal:.5g}"), unit), kept)


def _describe_balance(found: OptimisedDesign) -> Iterator[Block]:
    if found.balance is None or not found.kept:
        return
    for one in found.balance.pressing:
        yield Sentence(one.words(found.question.goal.unit))
    if found.balance.residue > IMBALANCE:
        yield Sentence(
            f"Caution: {100.0 * found.balance.residue:.2g} % of the slope of the goal is not "
            "balanced: this is a kink, or not yet the best.",
            "caution",
        )


def _describe_grid(found: OptimisedDesign) -> Iterator[Block]:
    scan, question = found.scan, found.question
    if scan is None:
        return
    size = f"Grid of {' x '.join(map(str, scan.shape))} = {len(scan.z):,} simulations"
    if scan.best is None:
        yield Sentence(f"{size}: none of its designs keeps all constraints.")
        return
    best = ", ".join(
        f"{one.name} {write_quantity(v, one.unit, 5)}" for one, v in zip(question.free, scan.numbers, strict=True)
    )
    cells = ", ".join(f"{c:.2g}" for c in scan.cells(np.array(found.z)))
    goal = write_quantity(scan.values[0], question.goal.unit)
    yield Sentence(f"{size}: best {goal} at {best}; the design found is {cells} cells away.")
