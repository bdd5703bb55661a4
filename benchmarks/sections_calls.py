"""The section of the benchmark on what users call: runs of scenarios, and whole commands.

What: `scenario.run(runtime="c")` of examples, repeated in one process, and commands in fresh processes with warm
caches. A first command has an empty cache of compiled programs; the compiler in the background is not counted.
"""

from __future__ import annotations

import statistics
import sys
import tempfile
from collections.abc import Sequence
from typing import Any

from benchmarks.harness import Candidate, measure
from benchmarks.process import ROOT, interleaved, run_process
from benchmarks.report import Table
from benchmarks.sections import Options, section
from martensite.scenario.scenario import load

RUNS = ("constant_power", "migaone", "pwm_bias_spring", "closed_loop")
FIRST = ("migaone", "pwm_bias_spring", "closed_loop", "finger", "torsion_wire")
SIZE = ("size", "--pull", "8N", "--stroke", "5mm", "--rate", "0.5Hz", "--supply", "12V")


def write_command(*words: str) -> list[str]:
    """The command line of `martensite`."""
    return [sys.executable, "-m", "martensite", *words]


def write_run(name: str, folder: str, *words: str) -> list[str]:
    """The command that runs an example and writes its files into a folder."""
    return write_command("run", str(ROOT / f"examples/{name}.toml"), "--force", "--out", f"{folder}/run.nc", *words)


@section
def calls(options: Options, names: Sequence[str] = RUNS) -> list[Table]:
    """Repeated runs of examples in C, and whole commands."""
    runs = []
    for name in names:
        scenario = load(ROOT / f"examples/{name}.toml")
        runs.append(Candidate("scenario.run", lambda one=scenario: one.run(runtime="c"), setting=name))
    rows = [
        {"call": t.name, "example": t.setting, "cpu [ms]": 1e3 * t.cpu, "spread": t.spread}
        for t in measure(runs, options.repeats)
    ]
    return [Table("Runs of examples as users call them", rows)]


@section
def commands(options: Options, first: Sequence[str] = FIRST) -> list[Table]:
    """Whole commands, with warm caches and with an empty cache of compiled programs."""
    rows: list[dict[str, Any]] = []
    with tempfile.TemporaryDirectory() as folder:
        example = str(ROOT / "examples/pwm_bias_spring.toml")
        made: dict[Any, tuple[Sequence[str], dict[str, str]]] = {
            "check": (write_command("check", example), {}),
            "run --no-figure": (write_run("pwm_bias_spring", folder, "--no-figure"), {}),
            "run": (write_run("pwm_bias_spring", folder, "--figure", f"{folder}/run.png"), {}),
            "size": (write_command(*SIZE), {}),
        }
        for name, used in interleaved(made, options.repeats).items():
            rows.append({"command": name, "cache": "warm", "cpu [ms]": 1e3 * statistics.median(u.cpu for u in used)})
        for name in first:
            command = write_run(name, folder, "--no-figure", "--runtime", "c")
            used = run_process(command, {"XDG_CACHE_HOME": f"{folder}/{name}", "MARTENSITE_QUICK_C": "first"})
            rows.append({"command": f"run {name} --no-figure", "cache": "empty", "cpu [ms]": 1e3 * used.cpu})
    return [Table("Commands", rows, "Bytecode is warm. The compiler in the background is not counted.")]
