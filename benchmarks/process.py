"""Whole fresh processes: wall time, CPU time (user + system) and peak memory.

What: the command is started by a bare interpreter that waits for it with `os.wait4`. The detour
keeps the peak memory honest: a child starts with the high-water mark of the process that forked
it, and the benchmark process itself holds other libraries. Interpreter and imports of the command count, the
launcher does not. POSIX only.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

LAUNCHER = """
import os, sys, time
path, *command = sys.argv[1:]
begin = time.perf_counter()
pid = os.fork()
if pid == 0:
    os.execvp(command[0], command)
_, status, used = os.wait4(pid, 0)
wall = time.perf_counter() - begin
unit = 1 if sys.platform == "darwin" else 1024
values = [wall, used.ru_utime + used.ru_stime, used.ru_maxrss * unit / 1e6, status]
with open(path, "w") as file:
    file.write(repr(values))
"""
ROOT = Path(__file__).resolve().parents[1]


class Usage(NamedTuple):
    """What one process took."""

    wall: float  # [s]
    cpu: float  # [s]
    peak: float  # [MB]
    answer: Any  # what it printed, read as JSON; None if it printed no JSON


def run_process(command: Sequence[str], environment: Mapping[str, str] | None = None) -> Usage:
    """Run a command to its end from the repository root."""
    with tempfile.TemporaryDirectory() as folder:
        report = Path(folder) / "usage.json"
        done = subprocess.run(
            [sys.executable, "-I", "-S", "-c", LAUNCHER, str(report), *command],
            env={**os.environ, **(environment or {})},
            cwd=ROOT,
            capture_output=True,
            text=True,
            check=False,
        )
        wall, cpu, peak, status = json.loads(report.read_text())
    if status:
        raise RuntimeError(f"`{' '.join(command)}` failed:\n{done.stderr[-2000:]}")
    return Usage(wall, cpu, peak, json.loads(done.stdout) if done.stdout[:1] == "{" else None)


def interleaved(
    commands: Mapping[Any, tuple[Sequence[str], Mapping[str, str]]], repeats: int
) -> dict[Any, list[Usage]]:
    """Each command `repeats` times, in rounds, after one round that only warms the disk."""
    found: dict[Any, list[Usage]] = {name: [] for name in commands}
    for turn in range(repeats + 1):
        for name, (command, environment) in commands.items():
            usage = run_process(command, environment)
            if turn:
                found[name].append(usage)
    return found
