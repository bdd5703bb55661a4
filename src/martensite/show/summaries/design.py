"""Summary of a design: parameters, measures, constraints and cautions."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

import numpy as np

from martensite.base.formats import write_quantity
from martensite.base.summary import Block, DataTable, Sentence, Summary
from martensite.design.optimise.optimised_design import OptimisedDesign, ReportedMeasure, RoundedDesign

NUMBERS = ("free", "scenario", "found", "from", "to", "")
MEASURES = ("measure", "scenario", "found", "limit", "")
IMBALANCE = 0.05
"""Unbalanced fraction of the goal's derivative that causes a caution."""
COARSE = 1e-2
"""Relative change by half the steps that causes a caution."""


def summarise_design(optimum: OptimisedDesign, title: str) -> Summary:
    """Return the summary of a design."""
    question, counts = optimum.question, optimum.counts
    sense = "most" if question.is_maximised else "least"
    lead = (
        f"{sense} {question.goal.words}: {write_quantity(optimum.goal, question.goal.unit)}, of "
        f"{counts.simulations:,} simulations and {counts.slopes:,} with derivatives"
    )
    blocks = [
        DataTable(NUMBERS, _number_rows(optimum), right=(1, 2, 3, 4)),
        DataTable(MEASURES, _measure_rows(optimum), right=(1, 2, 3)),
        *_describe_whole(optimum),
        *_describe_balance(optimum),
        *_describe_grid(optimum),
        *_describe_doubts(optimum),
    ]
    return Summary(title, blocks, {"title": title} | optimum.to_dict(), lead)


def describe_verdict(optimum: OptimisedDesign) -> str:
    """Return whether a design keeps all limits, with its goal or violations, without a full stop."""
    if not optimum.feasible:
        missed = ", ".join(optimum.violated_constraints)
        return f"No design that keeps all limits was found: the nearest one misses {missed}"
    sense, goal = "most" if optimum.question.is_maximised else "least", optimum.question.goal
    verdict = (
        "All constraints are kept, but limits of the elements are exceeded"
        if optimum.exceeded_limits
        else "All limits are kept"
    )
    return f"{verdict}: {sense} {goal.words} {write_quantity(optimum.goal, goal.unit, 4)}"


def _describe_doubts(optimum: OptimisedDesign) -> Iterator[Block]:
    if optimum.life:
        yield Sentence(optimum.life)
    if optimum.accuracy > COARSE:
        yield Sentence(
            f"Caution: half the steps ({optimum.step:.3g} s) change this by "
            f"{100.0 * optimum.accuracy:.2g} % of limits and goal.",
            "caution",
        )
    yield from (Sentence(f"Not kept: {words}", "bad") for words in optimum.violated_constraints)
    yield from (Sentence(f"Caution: {note}", "caution") for note in optimum.notes)


def _number_rows(optimum: OptimisedDesign) -> list[tuple[str, ...]]:
    rows: list[tuple[str, ...]] = []
    for one, value, z in zip(optimum.question.free, optimum.numbers, optimum.z, strict=True):
        bound = None if one.whole else one.bound(z)
        remark = "whole" if one.whole else f"at its {bound} bound" if bound else ""
        values = (one.start, value, one.low, one.high)
        rows.append((one.name, *(write_quantity(v, one.unit) for v in values), remark))
    return rows


def _measure_rows(optimum: OptimisedDesign) -> list[tuple[str, ...]]:
    question = optimum.question
    places = {one.name: k for k, one in enumerate(question.free)}
    return [
        (one.words, _write_values(one, one.before), _write_values(one, one.after), *_write_limits(optimum, one.words))
        for one in optimum.measures
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


def _write_limits(optimum: OptimisedDesign, words: str) -> tuple[str, str]:
    question = optimum.question
    limits = [c for c in question.subject if c.aim.words == words]
    goal = [("most" if question.is_maximised else "least")] if words == question.goal.words else []
    pressing = [] if optimum.balance is None else [p.name for p in optimum.balance.pressing]
    active = ["active"] if any(c.words in pressing for c in limits) else []
    missed = ["not kept"] if any(c.words in optimum.violated_constraints for c in limits) else []
    signs = [("<= " if c.is_upper_limit else ">= ") + write_quantity(c.limit, c.aim.unit) for c in limits]
    return ", ".join(signs), ", ".join([*goal, *(missed or active)])


def _describe_whole(optimum: OptimisedDesign) -> Iterator[Block]:
    if not optimum.rounded_designs or optimum.relaxed_numbers is None or optimum.relaxed_goal is None:
        return
    free, unit = optimum.question.free, optimum.question.goal.unit
    names = [one.name for one in free if one.whole]
    others = [(k, one) for k, one in enumerate(free) if not one.whole]
    rows = [_whole_row(one, others, unit) for one in optimum.rounded_designs]
    head = (*names, *(one.name for _, one in others), optimum.question.goal.words, "kept")
    yield DataTable(head, rows, right=range(len(head) - 1))
    values = ", ".join(
        f"{one.name} = {v:.4g}" for one, v in zip(free, optimum.relaxed_numbers, strict=True) if one.whole
    )
    goal = write_quantity(optimum.relaxed_goal, unit)
    yield Sentence(f"If nothing had to be whole: {values}, {goal}.")


def _whole_row(one: RoundedDesign, others: Sequence[tuple[int, object]], unit: str) -> tuple[str, ...]:
    numbers = [write_quantity(float(f"{one.numbers[k]:.5g}"), getattr(free, "unit", "1")) for k, free in others]
    verdict = "yes" if one.feasible else f"no, misses {100.0 * one.violation:.2g} %"
    return (*map(str, one.whole), *numbers, write_quantity(float(f"{one.goal:.5g}"), unit), verdict)


def _describe_balance(optimum: OptimisedDesign) -> Iterator[Block]:
    if optimum.balance is None or not optimum.feasible:
        return
    for one in optimum.balance.pressing:
        yield Sentence(one.words(optimum.question.goal.unit))
    if optimum.balance.residue > IMBALANCE:
        yield Sentence(
            f"Caution: {100.0 * optimum.balance.residue:.2g} % of the slope of the goal is not "
            "balanced: this is a kink, or not yet the best.",
            "caution",
        )


def _describe_grid(optimum: OptimisedDesign) -> Iterator[Block]:
    scan, question = optimum.scan, optimum.question
    if scan is None:
        return
    size = f"Grid of {' x '.join(map(str, scan.shape))} = {len(scan.z):,} simulations"
    if scan.best is None:
        yield Sentence(f"{size}: none of its designs keeps all constraints.")
        return
    best = ", ".join(
        f"{one.name} {write_quantity(v, one.unit, 5)}" for one, v in zip(question.free, scan.numbers, strict=True)
    )
    cells = ", ".join(f"{c:.2g}" for c in scan.cells(np.array(optimum.z)))
    goal = write_quantity(scan.values[0], question.goal.unit)
    yield Sentence(f"{size}: best {goal} at {best}; the design found is {cells} cells away.")
