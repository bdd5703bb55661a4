"""What a design shows and writes: tables of numbers and measures, what holds it, the scenario."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from martensite.cli import show
from martensite.cli.design_saved import saved
from martensite.cli.outputs import Outputs, parts

if TYPE_CHECKING:
    from martensite.design.optimise.designed import Designed, Held, Reported
    from martensite.scenario.scenario import Scenario

NUMBERS = ("free", "scenario", "found", "from", "to", "")
MEASURES = ("measure", "scenario", "found", "limit", " ")
IMBALANCE = 0.05
"""Share of the slope of the goal that is not balanced, from which on it is told."""


def shown(found: Designed, scenario: Scenario, outputs: Outputs, json: bool) -> None:
    """Write the files, then print."""
    with parts(outputs) as files:
        if files.data is not None:
            files.data.write_text(saved(found, scenario), encoding="utf-8")
        if files.figure is not None:
            _draw(found, scenario.title, files.figure)
    written = [str(path) for path in outputs.paths()]
    if json:
        show.as_json({"title": scenario.title} | found.to_dict() | {"files": written})
        return
    _print(found, scenario.title)
    for path in written:
        show.text(f"wrote {path}")


def _print(found: Designed, title: str) -> None:
    question, counts = found.question, found.counts
    sense = "most" if question.most else "least"
    show.text(title, "bold")
    show.text(
        f"{sense} {question.goal.words}: {show.quantity(found.goal, question.goal.unit)}, of "
        f"{counts.simulations:,} simulations and {counts.slopes:,} with derivatives"
    )
    show.table(NUMBERS, _numbers(found), right="scenario,found,from,to")
    show.table(MEASURES, _measures(found), right="scenario,found,limit")
    _print_whole(found)
    _print_holding(found)
    _print_grid(found)
    if found.life:
        show.text(found.life)
    if found.accuracy > 1e-2:
        show.text(
            f"Caution: half the steps ({found.step:.3g} s) change this by "
            f"{100.0 * found.accuracy:.2g} % of limits and goal.", "yellow",
        )  # fmt: skip
    for words in found.missed:
        show.text(f"Not kept: {words}", "red")
    for note in found.notes:
        show.text(f"Caution: {note}", "yellow")


def _numbers(found: Designed) -> list[tuple[str, ...]]:
    """Rows of the free numbers."""
    rows: list[tuple[str, ...]] = []
    for one, value, z in zip(found.question.free, found.numbers, found.z, strict=True):
        bound = None if one.whole else one.bound(z)
        remark = "whole" if one.whole else f"at its {bound} bound" if bound else ""
        values = (one.start, value, one.low, one.high)
        rows.append((one.name, *(show.quantity(v, one.unit) for v in values), remark))
    return rows


def _measures(found: Designed) -> list[tuple[str, ...]]:
    """Rows of the measures, those with limits and the goal first."""
    question = found.question
    places = {one.name: k for k, one in enumerate(question.free)}
    return [
        (one.words, _values(one, one.before), _values(one, one.after), *_limit(found, one.words))
        for one in found.reported if one.words not in places
    ]  # fmt: skip


def _values(one: Reported, values: Sequence[float]) -> str:
    """A measure in all cases."""
    return ", ".join(dict.fromkeys(_value(value, one) for value in values))


def _value(value: float, one: Reported) -> str:
    if math.isnan(value):
        return "failed"
    if math.isinf(value):
        return "never"
    if one.unit == "K" and one.words.startswith("stroke"):
        return f"{value:.5g} K"
    return show.quantity(float(f"{value:.9g}"), one.unit)


def _limit(found: Designed, words: str) -> tuple[str, str]:
    """Limits of a measure, and whether it is pressed against them."""
    question = found.question
    limits = [c for c in question.subject if c.aim.words == words]
    goal = [("most" if question.most else "least")] if words == question.goal.words else []
    pressing = [] if found.balance is None else [p.name for p in found.balance.pressing]
    active = ["active"] if any(c.words in pressing for c in limits) else []
    missed = ["not kept"] if any(c.words in found.missed for c in limits) else []
    signs = [("<= " if c.most else ">= ") + show.quantity(c.limit, c.aim.unit) for c in limits]
    return ", ".join(signs), ", ".join([*goal, *(missed or active)])


def _print_whole(found: Designed) -> None:
    """The best designs with other whole numbers."""
    if not found.held or found.relaxed is None or found.relaxed_goal is None:
        return
    free, unit = found.question.free, found.question.goal.unit
    names = [one.name for one in free if one.whole]
    others = [(k, one) for k, one in enumerate(free) if not one.whole]
    rows = [_held(one, others, unit) for one in found.held]
    heads = (*names, *(one.name for _, one in others), found.question.goal.words, "kept")
    show.table(heads, rows, right=",".join(heads[:-1]))
    values = ", ".join(
        f"{one.name} = {v:.4g}" for one, v in zip(free, found.relaxed, strict=True) if one.whole
    )
    show.text(f"If nothing had to be whole: {values}, {show.quantity(found.relaxed_goal, unit)}.")


def _held(one: Held, others: Sequence[tuple[int, object]], unit: str) -> tuple[str, ...]:
    numbers = [
        show.quantity(float(f"{one.numbers[k]:.5g}"), getattr(free, "unit", "1"))
        for k, free in others
    ]
    kept = "yes" if one.kept else f"no, misses {100.0 * one.violation:.2g} %"
    return (*map(str, one.whole), *numbers, show.quantity(float(f"{one.goal:.5g}"), unit), kept)


def _print_holding(found: Designed) -> None:
    """What holds the design where it is."""
    if found.balance is None or not found.kept:
        return
    for one in found.balance.pressing:
        show.text(one.words(found.question.goal.unit))
    if found.balance.residue > IMBALANCE:
        show.text(
            f"Caution: {100.0 * found.balance.residue:.2g} % of the slope of the goal is not "
            "balanced: this is a kink, or not yet the best.", "yellow",
        )  # fmt: skip


def _print_grid(found: Designed) -> None:
    """The grid beside the search."""
    scan, question = found.scan, found.question
    if scan is None:
        return
    size = f"Grid of {' x '.join(map(str, scan.shape))} = {len(scan.z):,} simulations"
    if scan.best is None:
        show.text(f"{size}: none of its designs keeps all constraints.")
        return
    best = ", ".join(
        f"{one.name} {show.quantity(float(f'{v:.5g}'), one.unit)}"
        for one, v in zip(question.free, scan.numbers, strict=True)
    )
    import numpy as np

    cells = ", ".join(f"{c:.2g}" for c in scan.cells(np.array(found.z)))
    goal = show.quantity(float(f"{scan.values[0]:.6g}"), question.goal.unit)
    show.text(f"{size}: best {goal} at {best}; the design found is {cells} cells away.")


def _draw(found: Designed, title: str, path: Path) -> None:
    from martensite.show.figures.design import plot_design
    from martensite.show.figures.files import write_figure

    write_figure(plot_design(found, title), path)
