"""The benchmark in words and tables; units are chosen here, at the edge."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

from benchmarks.control.competition import (
    BenchmarkRow,
    BenchmarkTable,
    compare_pairs,
    list_faults,
    make_digest,
    rank_entries,
)
from benchmarks.control.entries import list_missing, load_entries
from benchmarks.control.guards import MARGIN
from benchmarks.control.runs import NO_FAULT
from benchmarks.control.tasks import load_tasks
from benchmarks.control.wires import SEED
from martensite.base.summary import Block, DataTable, Heading, Sentence, Summary
from martensite.control.controllers.base import CONTROLLERS

KELVIN, HOUR = 273.15, 3600.0
HOT = 140.0
"""Temperature limit of the wires [degC]."""
HEAD = (
    *("entry", "task", "median", "90 %", "settling", "overshoot", "ITAE", "activity", "energy", "hottest", "above"),
    *("alarms", "µs"),
)


def summarise_benchmark(table: BenchmarkTable, title: str = "Benchmark of control") -> Summary:
    """The ranking, every entry on every task, and what faults do."""
    return Summary(title, list(_list_blocks(table)), table.to_json())


def _list_blocks(table: BenchmarkTable) -> Iterator[Block]:
    sound = table.select(fault=NO_FAULT)
    tasks, wires = list(dict.fromkeys(one.task for one in sound)), sound[0].wires
    held = "" if table.seed == SEED else f" of the held-out seed {table.seed}"
    yield Sentence(f"martensite {table.version}, benchmark {table.digest}, {wires} wires{held}.")
    yield _make_ranking(table, tasks)
    yield Sentence(
        "Ranked by the score: the mean over the tasks of the rms error that 90 % of the wires keep, in % of the span "
        "asked for; a task that an entry does not run counts as 100 %, and a wire above its limit puts it last."
    )
    pairs = [
        (one, other, f"{100.0 * mean:.2f} ± {100.0 * half:.2f}") for one, other, mean, half in compare_pairs(table)
    ]
    if pairs:
        yield DataTable(("entry", "next entry", "less error"), pairs, right=(2,))
        yield Sentence("Paired differences of the rms error over common tasks, in % of the span, with 95 % intervals.")
    yield Sentence(_describe_cuts(sound))
    yield Heading("Without a fault", detail=True)
    order = {name: k for k, name in enumerate(table.entries)}
    rows = sorted(sound, key=lambda one: (tasks.index(one.task), order[one.entry]))
    yield DataTable(HEAD, [_write_row(one) for one in rows], right=range(2, len(HEAD)))
    if len(sound) < len(table.rows):
        yield Heading("With a fault")
        yield _make_fault_table(table)
        yield Sentence("By fault, over all tasks: highest temperature [°C], and the share of runs above the limit.")
        yield _make_heat_table(table)
        yield Sentence("Highest temperature [°C] of any wire on any task, by entry and fault, with the guard.")
    lost = [one for one in table.rows if one.failed > 0.0]
    if lost:
        count = round(sum(one.wires * one.failed for one in lost))
        names = ", ".join(dict.fromkeys(f"{one.task} ({one.fault})" for one in lost))
        total = sum(one.wires for one in table.rows)
        yield Sentence(f"No result, and not counted as hot: {count} of {total} runs, on {names}.", "caution")


def _make_ranking(table: BenchmarkTable, tasks: Sequence[str]) -> DataTable:
    rows: list[list[str]] = []
    for name, score in rank_entries(table):
        own = {one.task: one for one in table.select(entry=name, fault=NO_FAULT)}
        rows.append([name, f"{100.0 * score:.1f}", *(_write_error(own.get(task)) for task in tasks)])
    return DataTable(("entry", "score", *tasks), rows, right=range(1, 2 + len(tasks)))


def _write_error(row: BenchmarkRow | None) -> str:
    return "–" if row is None else _write_share(row.error_90)


def _write_share(share: float) -> str:
    return f"{100.0 * share:.1f}" if share < 10.0 else "lost"


def _write_row(one: BenchmarkRow) -> list[str]:
    return [
        one.entry,
        one.task,
        _write_share(one.error_median),
        _write_share(one.error_90),
        f"{one.settling:.2f} s",
        f"{100.0 * one.overshoot:.1f}",
        _write_known(one.itae),
        _write_known(one.activity),
        f"{one.energy:.1f} J",
        f"{one.hottest - KELVIN:.0f} °C",
        f"{100.0 * one.above:.0f} %",
        f"{100.0 * one.alarms:.0f} %",
        _write_known(1e6 * one.cost),
    ]


def _write_known(value: float) -> str:
    return "–" if math.isnan(value) else f"{value:.3g}"


def _make_fault_table(table: BenchmarkTable) -> DataTable:
    faults = [name for name in dict.fromkeys(one.fault for one in table.rows) if name != NO_FAULT]
    rows: list[list[str]] = []
    for fault in faults:
        own = table.select(fault=fault)
        worst = max(own, key=lambda one: one.hottest)
        runs = sum(one.wires for one in own)
        above, alarms = (
            100.0 * sum(one.wires * getattr(one, name) for one in own) / runs for name in ("above", "alarms")
        )
        rows.append([fault, f"{worst.hottest - KELVIN:.0f}", worst.entry, f"{above:.1f}", f"{alarms:.0f}"])
    return DataTable(("fault", "hottest", "of", "% above", "% alarms"), rows, right=(1, 3, 4))


def _make_heat_table(table: BenchmarkTable) -> DataTable:
    """Highest temperatures by entry and fault, and without one."""
    faults = list(dict.fromkeys(one.fault for one in table.rows))
    rows = [
        [name, *(_write_hottest(table.select(entry=name, fault=fault)) for fault in faults)] for name in table.entries
    ]
    return DataTable(("entry", *faults), rows, right=range(1, 1 + len(faults)))


def _write_hottest(rows: Sequence[BenchmarkRow]) -> str:
    return f"{max(one.hottest for one in rows) - KELVIN:.0f}" if rows else "–"


def _describe_cuts(sound: Sequence[BenchmarkRow]) -> str:
    """Runs without a fault that the guard cut: how many, in how long, of whom, and whether wires were that hot."""
    known, times = load_tasks(), dict[str, float]()
    for one in sound:
        times[one.entry] = times.get(one.entry, 0.0) + one.wires * known[one.task].duration / HOUR
    cut = [one for one in sound if one.alarms > 0.0]
    count, runs = round(sum(one.wires * one.alarms for one in cut)), sum(one.wires for one in sound)
    said = (
        f"Without a fault the guard cut {count} of {runs} runs, in {min(times.values()):.2g} h or more of every entry"
    )
    if not cut:
        return f"{said}."
    who = {name: [one.task for one in cut if one.entry == name] for name in dict.fromkeys(one.entry for one in cut)}
    cool = [f"{one.entry} on {one.task}" for one in cut if one.hottest - KELVIN <= HOT - MARGIN]
    least = f"the {HOT - MARGIN:.0f} °C at which it shall cut"
    false = f"No wire passed {least} on {', '.join(cool)}" if cool else f"Everywhere some wire passed {least}"
    listed = "; ".join(f"{name} on {', '.join(tasks)}" for name, tasks in who.items())
    return f"{said}: {listed}. {false}."


def summarise_parts() -> Summary:
    """Tasks, entries and faults of the benchmark."""
    tasks, entries = load_tasks(), load_entries()
    rows = [(one.name, one.plant, one.title) for one in tasks.values()]
    who = [(one.name, ", ".join(one.plants), one.title) for one in entries.values()]
    missing = list_missing(entries, CONTROLLERS.names())
    blocks: list[Block] = [
        DataTable(("task", "plant", "what is asked for"), rows),
        DataTable(("entry", "plants", "what it is"), who),
        Sentence(f"Faults: {', '.join(list_faults())}."),
        Sentence(f"Controllers of the package without an entry: {'; '.join(f'{n} ({w})' for n, w in missing)}."),
    ]
    data = {"tasks": list(tasks), "entries": list(entries), "faults": list_faults(), "digest": make_digest()}
    return Summary("", blocks, data)
