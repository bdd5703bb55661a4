"""The sections of the benchmark that start fresh processes: cold start, first call, memory."""

from __future__ import annotations

import statistics
import sys
import tempfile
from collections.abc import Sequence
from typing import Any

from benchmarks.engines import Engine
from benchmarks.process import ROOT, Usage, interleaved, run_process
from benchmarks.report import Table
from benchmarks.sections import Options, section

SCENARIO = ROOT / "examples/migaone.toml"
MODULE = (sys.executable, "-m", "benchmarks.run_once")


def command(engine: Engine, kind: str, size: int = 1, repeats: int = 0) -> list[str]:
    """The command line that runs one engine once."""
    return [*MODULE, engine.name, kind, str(size), str(repeats)]


def environments(engine: Engine, folder: str) -> dict[str, dict[str, str]]:
    """Label -> environment; "CACHE" becomes a folder of its own per label."""
    filled = {}
    for i, (label, values) in enumerate(engine.environments.items()):
        place = f"{folder}/{engine.name}-{i}"
        filled[label] = {k: place if v == "CACHE" else v for k, v in values.items()}
    return filled


def command_lines(options: Options, folder: str) -> dict[Any, tuple[Sequence[str], dict[str, str]]]:
    """What a user types: the help text, and a run with its data file but without its figure."""
    if not any(engine.name == "ours" for engine in options.engines):
        return {}
    ours = (sys.executable, "-m", "martensite")
    run = ("run", str(SCENARIO), "--no-figure", "--out", f"{folder}/run.nc", "--force")
    return {("martensite --help", ""): ((*ours, "--help"), {}), ("martensite run --no-figure", ""): ((*ours, *run), {})}


def started(options: Options, repeats: int) -> dict[Any, list[Usage]]:
    """A single run of every engine in every environment, in fresh processes."""
    with tempfile.TemporaryDirectory() as folder:
        commands: dict[Any, tuple[Sequence[str], dict[str, str]]] = {}
        if not repeats:
            commands["bare interpreter", ""] = ([sys.executable, "-c", ""], {})
            commands |= command_lines(options, folder)
        for engine in options.engines:
            if engine.single and not engine.only_edges:
                for label, values in environments(engine, folder).items():
                    commands[engine.name, label] = (command(engine, "single", 1, repeats), values)
        return interleaved(commands, options.repeats)


@section
def cold(options: Options) -> list[Table]:
    """Interpreter start, imports, compilation and one run."""
    rows = []
    for (name, label), used in started(options, 0).items():
        row: dict[str, Any] = {"engine": name, "environment": label}
        row["wall [ms]"] = 1e3 * statistics.median(u.wall for u in used)
        row["cpu [ms]"] = 1e3 * statistics.median(u.cpu for u in used)
        row["peak [MB]"] = statistics.median(u.peak for u in used)
        rows.append(row)
    return [Table("Whole process, one run", rows, "Disk caches and bytecode are warm.")]


@section
def first(options: Options) -> list[Table]:
    """First call and repeat."""
    rows = []
    for (name, label), used in started(options, 5).items():
        row: dict[str, Any] = {"engine": name, "environment": label}
        for key, column in (("load", "imports"), ("first", "first call"), ("repeat", "repeat")):
            row[f"{column} [ms]"] = 1e3 * statistics.median(u.answer[key] for u in used)
        rows.append(row)
    return [Table("First call (preparation included) and repeat, wall", rows)]


@section
def memory(options: Options) -> list[Table]:
    """Peak memory of a process per kind of work."""
    tasks = {"single": ("single", 1), "gradient": ("gradient", 1)}
    tasks |= {f"batch {size}": ("batch", size) for size in options.sizes if size > 1}
    rows = []
    for engine in options.engines:
        row: dict[str, Any] = {"engine": engine.name}
        for label, (kind, size) in tasks.items():
            can = getattr(engine, kind) and size <= engine.batch_limit and not engine.only_edges
            used = run_process(command(engine, kind, size)) if can else None
            row[f"{label} [MB]"] = used.peak if used else None
        if any(value for key, value in row.items() if key != "engine"):
            rows.append(row)
    return [Table("Peak resident memory of a process", rows)]
