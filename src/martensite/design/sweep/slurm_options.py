"""Options for SLURM in words: `partition=short, time=2 h, cpus=8, tasks=16, memory=4 GB`.

    tasks      of the array [16], at most one per missing chunk
    parallel   tasks that run at a time [all]
    cpus       cores of a task [1], each with a process
    time       time limit of a task, which then restarts [1 h]; also in SLURM's form, `1-12:00:00`
    memory     of a task, in MB, GB or TB of 1024 each [default of the cluster]

The options of `FREE` are as in `sbatch`.
"""

from __future__ import annotations

import math
import re
from dataclasses import dataclass, field
from typing import Any

from martensite.base import units
from martensite.base.errors import ParameterError, require_known

FREE = (
    "account",
    "constraint",
    "dependency",
    "exclude",
    "gres",
    "licenses",
    "mail-type",
    "mail-user",
    "nice",
    "nodelist",
    "partition",
    "qos",
    "reservation",
)
"""Options that `sbatch` gets unchanged."""
COUNTS = ("tasks", "parallel", "cpus")
NOTICE = 90
"""Longest notice before the end of a task [s]."""
CLOCK = r"(?:(\d+)-)?(\d+):(\d\d)(?::(\d\d))?"
"""Pattern of times in SLURM's form."""
POWERS = {"M": 0, "G": 1, "T": 2}
MOST_TASKS = 10_000


@dataclass(frozen=True)
class SlurmOptions:
    """Options of a job array for SLURM."""

    tasks: int = 16
    parallel: int | None = None
    cpus: int = 1
    time: float = 3600.0
    """Time limit of a task [s]."""
    memory: int | None = None
    """Memory of a task [MiB]."""
    free: dict[str, str] = field(default_factory=dict[str, str])

    def count_tasks(self, missing: int) -> int:
        """Return the number of tasks for a number of missing chunks."""
        return max(min(self.tasks, missing), 1)

    @property
    def minutes(self) -> int:
        """Return the time limit in minutes."""
        return math.ceil(self.time / 60.0)

    def to_submitit(self) -> dict[str, Any]:
        """Return the parameters of an executor of submitit."""
        more: dict[str, Any] = {"requeue": True, **self.free}
        if self.memory is not None:
            more["mem"] = f"{self.memory}M"
        return {
            "time": self.minutes,
            "cpus_per_task": self.cpus,
            "array_parallelism": self.parallel or self.tasks,
            "signal_delay_s": min(NOTICE, 15 * self.minutes),
            "additional_parameters": more,
        }


def parse_slurm_options(words: str) -> SlurmOptions:
    """Return the options of a text such as `partition=short, time=2 h`.

    Raises:
        InputError: an option is unknown, or its value is invalid.
    """
    options: dict[str, Any] = {}
    free: dict[str, str] = {}
    for one in re.split(r",(?=\s*[\w-]+\s*=)", words) if words.strip() else ():  # values have commas: `nodelist=a[1,2]`
        name, equals, value = (part.strip() for part in one.partition("="))
        if not (equals and value):
            raise ParameterError(f"`{one.strip()}` is no option of SLURM; write `time=2 h, cpus=4`.")
        require_known("option of SLURM", name, (*COUNTS, "time", "memory", *FREE))
        if name in options or name in free:
            raise ParameterError(f"Option `{name}` of SLURM is given twice.")
        if name in FREE:
            free[name] = value
        else:
            options[name] = {"time": _read_time, "memory": _read_memory}.get(name, _read_count)(name, value)
    return SlurmOptions(**options, free=free)


def _read_count(name: str, value: str) -> int:
    if not value.isdecimal() or not 1 <= int(value) <= MOST_TASKS:
        raise ParameterError(f"Option `{name}` of SLURM is a number from 1 to {MOST_TASKS:,}, not `{value}`.")
    return int(value)


def _read_time(name: str, value: str) -> float:
    """Return a time [s] from text with a unit, or `days-hours:minutes:seconds`."""
    match, long = re.fullmatch(CLOCK, value), re.fullmatch(r"(\d+(?:\.\d+)?)\s*([hd])", value)
    if match is not None:
        days, first, second, third = (int(part or 0) for part in match.groups())
        hours = match[1] is not None or match[4] is not None  # else `minutes:seconds`
        seconds = 86400.0 * days + (3600 * first + 60 * second + third if hours else 60 * first + second)
    elif long is not None:  # without pint, which takes a second to load
        seconds = float(long[1]) * {"h": 3600.0, "d": 86400.0}[long[2]]
    else:
        seconds = units.parse_quantity(value, "s")
    if not 0.0 < seconds < math.inf:
        raise ParameterError(f"Option `{name}` of SLURM must be above 0, not `{value}`.")
    return seconds


def _read_memory(name: str, value: str) -> int:
    match = re.fullmatch(r"(\d+(?:\.\d+)?)\s*([MGT])i?B?", value)
    if match is None or not float(match[1]):
        raise ParameterError(f"Option `{name}` of SLURM is written `4 GB`, not `{value}`.")
    return math.ceil(float(match[1]) * 1024 ** POWERS[match[2]])
