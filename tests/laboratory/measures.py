"""Runs the trials of measures and alarms, keeps what came out with the commit, and writes it for the page."""

from __future__ import annotations

import gc
import json
import sys
import time
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import asdict, dataclass, field, replace
from multiprocessing import Pool
from typing import Any

import numpy as np

from laboratory.faults import find_commit
from laboratory.measure_trials import (
    BUDGET,
    COMPARED,
    EVENTS,
    FAILED,
    NAMES,
    OUTCOMES,
    OVERLONG,
    Compared,
    Tried,
    try_trial,
)
from laboratory.structures import ROOT, STRUCTURES

RECORD = ROOT / "docs/developer/accuracy-measures.json"
MADE = ROOT / "build/laboratory/measures.jsonl"
"""Trials of a run so far, so that it can go on."""
SELDOM = (20_000, 20, 25)
"""Thresholds of the collector of garbage: traced graphs are full of cycles."""
ALARMS = ("alarm worst", "alarm first", "alarm duration", "alarm missed")
HEAD = "| {} | {} | not estimated | true / claimed: median | 99 % | worst |"
WORST = 10
"""Comparisons that the page lists, those with the largest ratios above `ALLOWED`."""
ALLOWED = 3.0
MOST = 1e9
"""Ratio that stands for an infinite one."""
TEXT = """
## Measures and alarms

This part compares the measures that users read with a reference: `max`, `min`, `stroke`, `change`, `mean`, `integral`,
`rms`, `energy`, values at a time and at the end, rise, fall, reach and peak times, and alarms.

- Structures: {structures}, with every law, element, mechanism, source and cooling model, including fibres, inertia,
  R-phase, return points, compression and wear.
- Drives: steps, short pulses in long runs, slow and fast PWM, slow and fast sines, three tones, triangles and tables.
- Tolerances: 1e-3, 1e-4 and 1e-5. One run in five continues from a restart.
- Reference: the same run at a tolerance of 1e-7, or of a hundredth of the tolerance for systems with inertia. The
  reference is read from its accepted steps and from 10⁴ stored samples (10⁵ in one scenario of twenty). The true error
  is the larger difference. The difference from samples is reduced by the part that the sampling interval explains.
  Samples are not used if a drive has fewer than a hundred per period.

Each scenario compares 12 random measures. *Claimed* is the bound that `Result.bound` returns. *Not estimated*
means that `Result.bound` returns no bound, for example for an event that may not occur. The worst value of an alarm
is compared with the bound of the extreme value. Times of an alarm are compared with their change if the limit is off
by that bound, or, in trials that were repeated, by the bound of the value at that time.
Closed loops have no bound; other tests compare them.

The command `python -m laboratory measures`, in the folder `tests` of a checkout, runs the trials and writes the
tables. It resumes after an interruption. A trial can take {budget:g} s of CPU time.

"""
DROPPED = """Scenarios without a comparison, by structure. A scenario that *left the envelope* ended at a limit of the
material. A scenario that *failed* ended with another status.
"""
FAILED_ONES = """Scenarios that failed or took too long:
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
    outcomes: dict[str, int]
    """Trials by outcome."""
    structures: dict[str, dict[str, int]]
    """The same of every structure."""
    measures: list[Row]
    """By measure; the last one is of all."""
    alarms: list[Row]
    groups: list[Row]
    """By kind of structure, of measures."""
    worst: list[list[Any]] = field(default_factory=list[list[Any]])
    """Seed, structure, drives, tolerance, words and ratio of comparisons above `ALLOWED`."""
    failed: list[list[Any]] = field(default_factory=list[list[Any]])
    """Seed, structure, tolerance and message of trials that failed or took too long."""
    repeated: str = ""
    """Commit at which the trials of `worst` were repeated; empty if they were not."""
    closed: list[list[Any]] = field(default_factory=list[list[Any]])
    """Seed, words, and ratio now of comparisons of `worst` that are no more above `ALLOWED`."""

    @property
    def scenarios(self) -> int:
        """Number of trials with comparisons."""
        return self.outcomes[COMPARED]

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
            TEXT.format(structures=len(STRUCTURES), budget=BUDGET),
            f"{sum(self.outcomes.values())} scenarios were drawn, and {self.scenarios} compared "
            f"({self.day}, commit `{self.commit}`):",
            "",
        ]
        for title, rows in (("measure", self.measures), ("alarm", self.alarms), ("structure", self.groups)):
            lines += [
                HEAD.format(title, "compared"),
                "| --- | ---: | ---: | ---: | ---: | ---: |",
                *(one.cells for one in rows),
                "",
            ]
        lines += self._list_dropped()
        if self.worst:
            lines += [f"Ratios above {ALLOWED:g}, the largest first:", ""]
            lines += [
                f"- seed {seed}, {name}, {kind}, {tol:g}: `{words}` {ratio:.3g}"
                for seed, name, kind, tol, words, ratio in self.worst
            ]
            closed = [f"- seed {seed}, `{words}`: {ratio:.3g}" for seed, words, ratio in self.closed]
            lines += (
                ["", f"Repeated at commit `{self.repeated}`, these are below {ALLOWED:g}:", "", *closed]
                if closed
                else []
            )
        else:
            lines += [f"No ratio is above {ALLOWED:g}."]
        return "\n".join(lines) + "\n"

    def _list_dropped(self) -> list[str]:
        """The scenarios without comparisons, with the reasons."""
        some = {name: row for name, row in self.structures.items() if sum(row.values()) > row[COMPARED]}
        head = f"| structure | {' | '.join(OUTCOMES)} |"
        lines = [head, "| --- |" + " ---: |" * len(OUTCOMES)]
        for name, row in [*some.items(), ("all structures", self.outcomes)]:
            lines.append(f"| {name} | {' | '.join(str(row[one]) for one in OUTCOMES)} |")
        listed = [f"- seed {seed}, {name}, {tolerance:g}: {text}" for seed, name, tolerance, text in self.failed]
        return [DROPPED, *lines, "", *([FAILED_ONES, *listed, ""] if listed else [])]


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


def build_record(trials: Sequence[Tried], commit: str) -> MeasureRecord:
    """Summarise all trials."""
    rows = [row for one in trials for row in one.rows]
    judged = [one for one in rows if one.name not in ALARMS]

    def rows_by(names: Iterable[str], some: Sequence[Compared], key: Callable[[Compared], str]) -> list[Row]:
        return [make_row(name, [one for one in some if key(one) == name]) for name in names]

    def count(some: Iterable[Tried]) -> dict[str, int]:
        found = Counter(one.outcome for one in some)
        return {outcome: found[outcome] for outcome in OUTCOMES}

    groups = dict.fromkeys(one.group for one in STRUCTURES.values())
    beyond = sorted((one for one in rows if one.ratio > ALLOWED), key=lambda one: -one.ratio)
    return MeasureRecord(
        commit,
        time.strftime("%-d %B %Y"),
        count(trials),
        {name: count(one for one in trials if one.structure == name) for name in STRUCTURES},
        [*rows_by((*NAMES, *EVENTS), judged, lambda one: one.name), make_row("all", judged)],
        rows_by(ALARMS, rows, lambda one: one.name),
        rows_by(groups, judged, lambda one: STRUCTURES[one.structure].group),
        [[one.seed, one.structure, one.kind, one.tolerance, one.words, min(one.ratio, MOST)] for one in beyond[:WORST]],
        [[one.seed, one.structure, one.tolerance, one.reason] for one in trials if one.outcome in (FAILED, OVERLONG)],
    )


def repeat_worst() -> MeasureRecord:
    """Repeat the trials with comparisons above `ALLOWED`; return the record with those that are closed since."""
    record = MeasureRecord.read()
    trials = {seed: try_trial(seed) for seed in sorted({one[0] for one in record.worst})}
    now = {(seed, row.words): row.ratio for seed, one in trials.items() for row in one.rows}
    pairs = [(one[0], one[4]) for one in record.worst]
    closed = [[*pair, now[pair]] for pair in pairs if now.get(pair, MOST) <= ALLOWED]
    return replace(record, repeated=find_commit(), closed=closed)


# ---------------------------------------------------------------- the run


def run_trials(count: int, processes: int = 1) -> MeasureRecord:
    """Make the trials of the seeds below `count`, go on where a run of this commit was interrupted."""
    commit = find_commit()
    done = {one.seed: one for one in read_made(commit) if one.seed < count}
    missing = [seed for seed in range(count) if seed not in done]
    MADE.parent.mkdir(parents=True, exist_ok=True)
    with (
        MADE.open("a", encoding="utf-8") as file,
        Pool(processes, initializer=gc.set_threshold, initargs=SELDOM) as pool,
    ):
        for one in pool.imap_unordered(try_trial, missing):
            done[one.seed] = one
            file.write(json.dumps({"commit": commit, **asdict(one)}) + "\n")
            file.flush()
            if len(done) % 50 == 0:
                sys.stderr.write(f"{len(done)} of {count} trials\n")
    return build_record([done[seed] for seed in sorted(done)], commit)


def read_made(commit: str) -> Iterator[Tried]:
    """Return the trials of this commit that an interrupted run made; none if files differ from the commit."""
    known = MADE.exists() and not commit.endswith("+")
    lines = MADE.read_text(encoding="utf-8").splitlines() if known else []
    for line in lines:
        data = json.loads(line)
        if data.pop("commit") == commit:
            yield Tried(**data | {"rows": tuple(Compared(**row) for row in data["rows"])})
