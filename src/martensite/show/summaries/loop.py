"""The loops of a bench and their tests."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from martensite.base.formats import show_quantity
from martensite.base.summary import Block, DataTable, Sentence

if TYPE_CHECKING:
    from martensite.control.loop.bench import Bench
    from martensite.control.loop.findings import LoopFinding
    from martensite.control.margins.loop_check import LoopReport
    from martensite.scenario.places import Places
    from martensite.scenario.scenario import Scenario
    from martensite.simulate.judgement import Judgement

LOOP_VERDICTS = {
    "sound": "the loop passes all tests",
    "not all tested": "the loop has no known fault, but some tests were not possible",
}
HEADINGS = ("branch", "reading", "signal", "gain margin", "phase margin", "delay margin", "M_s")


def check_scenario_loop(scenario: Scenario, bench: Bench) -> LoopReport:
    """Return the tested loops of a scenario's bench, with paths as in its file."""
    from martensite.control.margins.loop_check import check_loop
    from martensite.simulate.drive_waveforms import by_name

    played = by_name(scenario.system, scenario.waveform)
    loop = check_loop(bench, scenario.duration, waveforms=played)
    return replace(loop, findings=tuple(_place_finding(one, scenario.places) for one in loop.findings))


def _place_finding(finding: LoopFinding, places: Places) -> LoopFinding:
    where = places.path(finding.where)
    return replace(finding, where=where, sentence=finding.sentence.replace(f"`{finding.where}`", f"`{where}`"))


def describe_verdict(loops: LoopReport | None, judged: Judgement | None, unjudged: str) -> Sentence:
    """Return the verdict on a scenario: faults of its loops, and exceeded limits of its run.

    Args:
        loops: tests of the loops; None without a loop.
        judged: judgement of the run; None without a run.
        unjudged: reason for no run, with the remedy.
    """
    count = 0 if loops is None else sum(one.fault for one in loops.findings)
    tested = "valid" if loops is None else f"valid, {LOOP_VERDICTS.get(loops.verdict, '')}"
    if count:
        tested = f"the loop has {count} {'fault' if count == 1 else 'faults'}"
    if judged is None:
        limits = f"Limits not checked: {unjudged}."
    else:
        limits = "All limits are kept." if judged.is_within_limits else judged.verdict
    bad = count > 0 or (judged is not None and not judged.is_within_limits)
    words = limits if judged is not None and not judged.is_within_limits and not count else f"{tested}. {limits}"
    return Sentence(words, "bad" if bad else "caution" if judged is None else "good")


def describe_loops(report: LoopReport) -> Iterator[Block]:
    """Return findings, margins, and omitted tests with reasons."""
    yield from (Sentence(str(one), "bad" if one.fault else "caution") for one in report.findings)
    if report.margins:
        yield Sentence(_summarise_margins(report.margins))
        several = len({row["drive"] for row in report.margins}) > 1
        cells = [_list_cells(row, f"{row['drive']}, " * several) for row in report.margins]
        yield DataTable(HEADINGS, cells, right=tuple(range(1, len(HEADINGS))))
    for why in dict.fromkeys(report.untested.values()):
        names = ", ".join(name for name, reason in report.untested.items() if reason == why)
        yield Sentence(f"Not tested: {names}: {why}.")


def _summarise_margins(rows: Sequence[Mapping[str, Any]]) -> str:
    stable = [row for row in rows if row["stable"]]
    if len(stable) < len(rows):
        return f"Unstable at {len(rows) - len(stable)} of {len(rows)} operating points."
    worst = (
        ("gain", min(row["gain"] for row in rows), "{:.3g}"),
        ("phase", math.degrees(min(row["phase"] for row in rows)), "{:.0f}°"),
        ("delay", min(row["delay"] for row in rows), "{:.3g} s"),
        ("sensitivity peak M_s", max(row["sensitivity"] for row in rows), "{:.2f}"),
    )
    margins = ", ".join(f"{name} {form.format(value)}" for name, value, form in worst if math.isfinite(value))
    return f"Stable at all {len(rows)} operating points. Worst margins: {margins}."


def _list_cells(row: Mapping[str, Any], drive: str) -> tuple[str, ...]:
    phase, delay = row["phase"], row["delay"]
    return (
        drive + row["branch"],
        show_quantity(row["reading"], row["unit"], 3),
        f"{row['signal']:.3g}",
        "unstable" if not row["stable"] else f"{row['gain']:.3g}" if math.isfinite(row["gain"]) else "none",
        f"{math.degrees(phase):.0f}°" if math.isfinite(phase) else "none",
        show_quantity(delay, "s", 3),
        f"{row['sensitivity']:.2f}",
    )
