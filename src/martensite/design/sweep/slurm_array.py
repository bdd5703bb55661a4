"""Sweep as a SLURM job array, submitted with submitit.

Every task computes its part of the missing chunks and writes each finished chunk into the store. A task that SLURM ends
is started again:

    time is up            SLURM signals (USR2) before; submitit requeues the task
    preempted, node lost  SLURM requeues it (`--requeue`)
    killed (memory, …)    the script detects the signal and requeues it

A task with `FRUITLESS` starts without a new chunk stops with an error. A task that raises an error is not started
again; its log has the message. <https://slurm.schedmd.com/sbatch.html>,
<https://github.com/facebookincubator/submitit/blob/main/docs/checkpointing.md>
"""

from __future__ import annotations

import json
import os
import shlex
import signal
import subprocess
import sys
import time
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from multiprocessing import active_children
from pathlib import Path
from types import FrameType
from typing import Any

from martensite.base.child_python import python_command
from martensite.base.errors import InputError, StoppedError
from martensite.base.lazy import import_extra
from martensite.base.summary import Sentence, Summary
from martensite.design.sweep.api import PlannedSweep, run_chunks
from martensite.design.sweep.backends.processes import Processes, Serial
from martensite.design.sweep.job import SweepJob
from martensite.design.sweep.slurm_options import SlurmOptions
from martensite.design.sweep.store import Store, list_differences

PYTHON = shlex.join(python_command())
"""Command of Python in a task, for a shell."""
FRUITLESS = 5
"""Starts without a new chunk after which a task stops."""
RESTARTS = 1000
"""Largest number of restarts of a task."""
PATIENCE = 600.0
"""Time that a task waits for its end after SIGTERM [s]; grace times of partitions are minutes."""
REQUEUE = (
    "code=$?",
    'own="${SLURM_ARRAY_TASK_ID:+${SLURM_ARRAY_JOB_ID}_$SLURM_ARRAY_TASK_ID}"',
    'own="${own:-$SLURM_JOB_ID}"  # the number of the last task is that of the array as well',
    f'if [ "$code" -gt 128 ] && [ "$code" -lt 192 ] && [ "${{SLURM_RESTART_COUNT:-0}}" -lt {RESTARTS} ] \\',
    '  && [ "$(squeue --noheader --jobs "$own" --format %T)" = RUNNING ]; then',
    '  scontrol requeue "$own"',
    "fi",
    'exit "$code"',
)
"""Lines of the script after a task; an exit code above 128 is a signal."""


@dataclass(frozen=True)
class SlurmTask:
    """Task of an array, which submitit starts and restarts."""

    job: SweepJob
    chunks: tuple[int, ...]
    """Missing chunks at submission."""
    workers: int
    """Number of processes; 0 for this process alone."""

    def __call__(self) -> str:
        """Compute the missing chunks, and return a sentence on them.

        Raises:
            StoppedError: the task cannot continue; finished chunks are kept.
        """
        signal.signal(signal.SIGTERM, _await_end)
        store = Store(self.job.path)
        if list_differences(store.spec, json.loads(self.job.spec)):
            raise StoppedError(f"`{store.path}` holds another sweep now than when this task was submitted.")
        there = store.made()
        _count_starts(len(there.intersection(self.chunks)))
        backend = Processes(self.workers) if self.workers else Serial()
        progress = run_chunks(self.job, self.chunks, there, backend)
        sentence = f"{progress.done:,} of {progress.runs:,} runs of this task are there, {progress.made:,} of them now."
        sys.stdout.write("\n".join((*progress.remarks, sentence, "")))
        return sentence

    def checkpoint(self) -> Any:
        """Return the same task for resubmission; finished chunks are in the store."""
        return import_extra("submitit", "slurm").helpers.DelayedSubmission(self)


def _await_end(number: int, frame: FrameType | None) -> None:
    """Stop, and let SLURM end this task.

    SLURM sends SIGTERM before it preempts or cancels a task. A task that ended by itself would count as failed, and
    would not be requeued.
    """
    del frame
    for child in active_children():
        child.kill()
    time.sleep(PATIENCE)
    os._exit(128 + number)


def _count_starts(there: int) -> None:
    """Record a start of this task and the number of finished chunks in a separate file.

    Raises:
        StoppedError: too many starts finished no chunk.
    """
    paths = import_extra("submitit", "slurm").JobEnvironment().paths
    file = paths.folder / f"{paths.job_id}_starts.json"
    before, vain = json.loads(file.read_text()) if file.exists() else (-1, 0)
    vain = vain + 1 if there == before else 0
    if vain >= FRUITLESS:
        raise StoppedError(
            f"This task was ended {FRUITLESS} times before it had made a chunk more: give it more time or memory, or "
            "begin another store with smaller chunks (`--chunk-size`)."
        )
    beside = file.with_suffix(".part")
    beside.write_text(json.dumps([there, vain]))
    beside.replace(file)


@dataclass(frozen=True)
class SlurmArray:
    """Job array of a sweep with its options."""

    store: Path
    options: SlurmOptions

    @property
    def folder(self) -> Path:
        """Return the folder of scripts and logs, beside the store."""
        return self.store.absolute().with_name(f"{self.store.name}.slurm")

    def write_script(self, missing: int) -> str:
        """Return the script for `sbatch`, for a number of missing chunks.

        Raises:
            InputError: submitit is not installed.
        """
        count = self.options.count_tasks(missing)
        command = f"{PYTHON} -u -m submitit.core._submit {shlex.quote(str(self.folder))}"
        array = {"map_count": count} if count > 1 else {}
        return _import_slurm()._make_sbatch_string(command, self.folder, **self._settings(), **array)

    def require_idle(self) -> None:
        """Raise `InputError` if tasks of an earlier array are in the queue."""
        last = self.find_job()
        if last and self.count_states(last):
            raise InputError(f"Job {last} still writes into `{self.store}`; end it first: `scancel {last}`.")

    def go_on(self, begun: PlannedSweep) -> Summary | None:
        """Return the state of the array, after submission if necessary; None if no chunk is missing.

        Raises:
            InputError: submitit or SLURM is not installed, or SLURM refuses.
            StoppedError: SLURM does not answer.
        """
        there, total = begun.store.made(), begun.plan.chunks
        missing = [chunk for chunk in range(total) if chunk not in there]
        if not missing:
            return None
        last, remarks = self.find_job(), list(begun.remarks)
        states = self.count_states(last) if last else Counter[str]()
        if last and not states:
            remarks.append(f"Job {last} has ended before all was made; its logs say why.")
        number = last if last and states else self.submit(begun.job, missing)
        states = states or Counter({"submitted": self.options.count_tasks(len(missing))})
        counts = ", ".join(f"{count:,} {state}" for state, count in states.items())
        runs = sum(len(begun.plan.rows(chunk)) for chunk in there)
        blocks = [
            Sentence(f"job {number}: {counts}; {runs:,} of {begun.plan.size:,} runs are there"),
            *(Sentence(f"Warning: {one}", "caution") for one in remarks),
            Sentence(f"logs in {self.folder}"),
        ]
        numbers = {"job": number, "tasks": dict(states), "runs": begun.plan.size, "done": runs}
        places = {"store": str(self.store), "logs": str(self.folder)}
        return Summary("", blocks, {**numbers, "chunks": [len(there), total], **places, "remarks": remarks})

    def submit(self, job: SweepJob, missing: Sequence[int]) -> str:
        """Submit tasks for missing chunks, and return the number of the job.

        Raises:
            InputError: submitit or SLURM is not installed, or SLURM refuses.
        """
        workers = 0 if json.loads(job.spec)["runtime"] == "cuda" else self.options.cpus
        count = self.options.count_tasks(len(missing))
        tasks = [SlurmTask(job, tuple(missing[k::count]), workers) for k in range(count)]
        core = import_extra("submitit", "slurm").core.utils
        try:
            executor = _import_slurm().SlurmExecutor(self.folder, max_num_timeout=RESTARTS, python=PYTHON)
        except RuntimeError:
            raise InputError("SLURM is not here (no `srun`); `--dry-run` shows what would be submitted.") from None
        executor.update_parameters(**self._settings())
        try:
            return executor.submit_array(tasks)[0].job_id.partition("_")[0]
        except (OSError, core.FailedJobError, core.FailedSubmissionError) as error:
            raise InputError(f"SLURM refuses the array: {_find_reason(error)}") from None

    def find_job(self) -> str | None:
        """Return the number of the last array."""
        numbers = [file.name.partition("_")[0] for file in self.folder.glob("*_submission.sh")]
        return max(filter(str.isdecimal, numbers), key=int, default=None)

    def count_states(self, number: str) -> Counter[str]:
        """Return the number of queued tasks of an array by state; empty for a finished array."""
        words = "squeue", "--noheader", "--array", "--jobs", number, "--format", "%T"
        try:
            answer = subprocess.run(words, capture_output=True, text=True, check=False)
        except OSError:
            return Counter()
        if answer.returncode and "nvalid job id" not in answer.stderr:
            raise StoppedError(f"SLURM does not report the state of job {number}: {_find_reason(answer.stderr)}")
        return Counter(answer.stdout.lower().split())

    def _settings(self) -> dict[str, Any]:
        return {"job_name": f"martensite-{self.store.stem}", "teardown": list(REQUEUE), **self.options.to_submitit()}


def _import_slurm() -> Any:
    import_extra("submitit", "slurm")
    return import_extra("submitit.slurm.slurm", "slurm")


def _find_reason(error: object) -> str:
    """Return the error of SLURM from the output of a command."""
    lines = [line for line in str(error).splitlines() if ": error: " in line] or str(error).splitlines()[:1]
    return lines[-1].rpartition("error: ")[2].rstrip(".") + "." if lines else "no reason given."
