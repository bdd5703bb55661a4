"""Runs the trials of measures and alarms, keeps what came out with the commit, and writes it for the page."""

from __future__ import annotations

import json
import time
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from multiprocessing import Pool
from typing import Any

import numpy as np

from laboratory.faults import find_commit
from laboratory.measure_trials import EVENTS, NAMES, Compared, try_trial
from laboratory.structures import ROOT, STRUCTURES

RECORD = ROOT / "docs/explanation/laboratory-measures.json"
ALARMS = ("alarm worst", "alarm first", "alarm duration", "alarm missed")
HEAD = "| {} | {} | not estimated | true / claimed: median | 99 % | worst |"
WORST = 10
"""Comparisons that the page lists, those with the largest ratios above `ALLOWED`."""
ALLOWED = 3.0
MOST = 1e9
"""Ratio that stands for an infinite one."""
TEXT = """
## Measures and alarms

This part compares the numbers that users read with a reference: `max`, `min`, `stroke`, `change`, `mean`, `integral`,
`rms`, `energy`, values at a time and at the end, rise, fall, reach and peak times, and alarms.

- Structures: {structures}, with every law, fibres, bundles, springs, mechanisms of several elements, inertia, R-phase,
  return points, compression and wear.
- Drives: steps, short pulses in long runs, slow and fast PWM, slow and fast sines, three tones, triangles and tables.
- Tolerances: 1e-3, 1e-4 and 1e-5. One run in five continues from a restart.
- Reference: the same run at a tolerance of 1e-7. It is read from its accepted steps and from 10⁵ stored samples (in one
  scenario of five, else 10⁴). The true error is the larger difference. The difference from samples is lessened by what
  their distance explains. Samples are left out if a drive has fewer than a hundred in a period.

A scenario compares 16 measures, drawn at random. *Claimed* is the bound that `Result.bound` returns. *Not estimated*
means that it returns no bound, for example for an event that may not occur. The worst value of an alarm is compared
with the bound of the extreme value. Times of an alarm are compared with their change if the limit is off by that bound.

The functions of `python -m laboratory accuracy`, in the folder `tests` of a checkout, compute the tables. A run of
fewer than 1000 scenarios leaves out slow structures.
"""


@dataclass(frozen=True)
class Row:
    """A row of a table."""

    name: str
    count: int
    unclaimed: int
    median: float = 0.0
    most: float = 0.0
    """Ratio that 99 % do not exceed."""
    worst: float = 0.0
    above: int = 0
    """Comparisons with a ratio above 1."""

    @property
    def cells(self) -> str:
        """The row, in Markdown."""
        shown = (self.median, self.most, self.worst)
        numbers = " | ".join(f"{one:.2f}" for one in shown) if self.count else "- | - | -"
        return f"| {self.name} | {self.count} | {self.unclaimed} | {numbers} |"


@dataclass(frozen=True)
class MeasureRecord:
    """What a run of the laboratory found."""

    commit: str
    day: str
    scenarios: int
    measures: list[Row]
    """By measure; the last one is of all."""
    alarms: list[Row]
    groups: list[Row]
    """By kind of structure, of measures."""
    worst: list[list[Any]] = field(default_factory=list[list[Any]])
    """Seed, structure, drives, tolerance, words and ratio of comparisons above `ALLOWED`."""

    @classmethod
    def read(cls) -> MeasureRecord:
        """The record of the page."""
        data = json.loads(RECORD.read_text(encoding="utf-8"))
        tables = {name: [Row(**one) for one in data[name]] for name in ("measures", "alarms", "groups")}
        return cls(**(data | tables))

    def write(self) -> None:
        """Write the record."""
        data = vars(self) | {
            name: [vars(one) for one in getattr(self, name)] for name in ("measures", "alarms", "groups")
        }
        RECORD.write_text(json.dumps(data, indent=1) + "\n", encoding="utf-8")

    def page(self) -> str:
        """Its section of the page, in Markdown."""
        lines = [
            TEXT.format(structures=len(STRUCTURES)),
            f"{self.scenarios} scenarios, {self.day}, commit `{self.commit}`:",
            "",
        ]
        for title, rows in (("measure", self.measures), ("alarm", self.alarms), ("structure", self.groups)):
            lines += [
                HEAD.format(title, "compared"),
                "| --- | ---: | ---: | ---: | ---: | ---: |",
                *(one.cells for one in rows),
                "",
            ]
        if self.worst:
            lines += [f"Ratios above {ALLOWED:g}, the largest first:", ""]
            lines += [
                f"- seed {seed}, {name}, {kind}, {tol:g}: `{words}` {ratio:.3g}"
                for seed, name, kind, tol, words, ratio in self.worst
            ]
        else:
            lines += [f"No ratio is above {ALLOWED:g}."]
        return "\n".join(lines) + "\n"


def make_row(name: str, rows: Iterable[Compared]) -> Row:
    """Summarise comparisons."""
    listed = list(rows)
    ratios = np.array([one.ratio for one in listed if one.claimed is not None])
    if not len(ratios):
        return Row(name, 0, len(listed))
    ratios = np.minimum(ratios, MOST)
    median, most = float(np.median(ratios)), float(np.quantile(ratios, 0.99, method="lower"))
    above = int((ratios > 1.0).sum())
    return Row(name, len(ratios), len(listed) - len(ratios), median, most, float(ratios.max()), above)


def build_record(rows: Sequence[Compared], commit: str) -> MeasureRecord:
    """Summarise the comparisons of all scenarios."""
    judged = [one for one in rows if one.name not in ALARMS]

    def rows_by(names: Iterable[str], some: Sequence[Compared], key: Callable[[Compared], str]) -> list[Row]:
        return [make_row(name, [one for one in some if key(one) == name]) for name in names]

    groups = dict.fromkeys(one.group for one in STRUCTURES.values())
    beyond = sorted((one for one in rows if one.ratio > ALLOWED), key=lambda one: -one.ratio)
    return MeasureRecord(
        commit,
        time.strftime("%-d %B %Y"),
        len({one.seed for one in rows}),
        [*rows_by((*NAMES, *EVENTS), judged, lambda one: one.name), make_row("all", judged)],
        rows_by(ALARMS, rows, lambda one: one.name),
        rows_by(groups, judged, lambda one: STRUCTURES[one.structure].group),
        [[one.seed, one.structure, one.kind, one.tolerance, one.words, min(one.ratio, MOST)] for one in beyond[:WORST]],
    )


def run_trials(count: int) -> MeasureRecord:
    """Make so many trials, two at a time."""
    commit = find_commit()
    with Pool(2) as pool:
        rows = [row for found in pool.imap_unordered(try_trial, range(count)) for row in found]
    return build_record(sorted(rows, key=lambda one: (one.seed, one.words)), commit)
