"""Sweeps as job arrays of SLURM: what is asked for, and tasks that are ended and started again.

SLURM is played by four programs of a line or two: the script is what `sbatch` would have been given, and runs as it
stands.
Source of truth: the same sweep in this process, undisturbed.
"""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
from command import Command
from sweep_cases import WIRE, arrays, undisturbed

from martensite.base.errors import InputError, StoppedError
from martensite.design.sweep import slurm_array
from martensite.design.sweep.slurm_options import SlurmOptions, parse_slurm_options
from martensite.design.sweep.store import MADE, Store

submitit: Any = pytest.importorskip("submitit")
SWEEP = Command("sweep")
MANY = "diameter=0.12..0.2 mm:6", "high=2..4 V:6"
WORDS = ("wire.toml", "--over", MANY[0], "--over", MANY[1], "--chunk-size", "1", "--runtime", "floats")
SLURM = (*WORDS, "--slurm", "partition=short, time=2 h, tasks=2, memory=2 GB")
PROGRAMS = {
    "sbatch": 'cp "$1" job.sh; echo "Submitted batch job 7"',
    "srun": 'while [ "${1#-}" != "$1" ]; do case $1 in --unbuffered) shift;; *) shift 2;; esac; done\n'
    'echo $$ > pid; exec "$@"',
    "scontrol": 'echo "$@" >> asked',
    "squeue": "cat queue",
}

TASK = {"SLURM_ARRAY_JOB_ID": "7", "SLURM_ARRAY_TASK_ID": "0", "SLURM_JOB_ID": "7"}


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder with the scenario, which is the present one, and a SLURM that does nothing by itself."""
    (tmp_path / "bin").mkdir()
    for name, text in PROGRAMS.items():
        (tmp_path / "bin" / name).write_text(f"#!/bin/sh\n{text}\n")
        (tmp_path / "bin" / name).chmod(0o755)
    (tmp_path / "wire.toml").write_text(WIRE, encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("PATH", f"{tmp_path / 'bin'}{os.pathsep}{os.environ['PATH']}")
    return tmp_path


def start(least: int, number: signal.Signals) -> int:
    """The first task of the array, sent a signal when so many chunks are there; how its script ends."""
    same = os.environ | TASK | {"PYTHONPATH": os.pathsep.join(sys.path)}
    with subprocess.Popen(["sh", "job.sh"], env=same, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL) as running:
        end = time.monotonic() + 60.0
        while len(list(Path("wire.zarr/made/c").glob("[0-9]*"))) < least:
            assert running.poll() is None and time.monotonic() < end
            time.sleep(0.02)
        os.kill(int(Path("pid").read_text()), number)
    return running.returncode


def test_a_task_that_is_killed_and_one_whose_time_is_up_go_on_to_the_same_bits(
    here: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    expected = undisturbed(here / "whole.zarr", *MANY, chunk=36)
    script = SWEEP.fine(*SLURM, "--dry-run")
    assert not (here / "wire.zarr").exists()
    told = SWEEP.report(*SLURM)
    assert (told["job"], told["tasks"], told["chunks"]) == ("7", {"submitted": 2}, [0, 36])
    assert (here / "job.sh").read_text() == script.removesuffix("\n")
    (here / "queue").write_text("RUNNING\n")
    assert start(2, signal.SIGKILL) == 128 + signal.SIGKILL
    assert (here / "asked").read_text() == "requeue 7_0\n"
    start(4, signal.SIGUSR2)
    assert (here / "asked").read_text() == 2 * "requeue 7_0\n"
    there = SWEEP.report(*SLURM)
    assert (there["job"], there["tasks"]) == ("7", {"running": 1}) and 4 <= there["done"] < 18
    assert "Job 7 still writes into `wire.zarr`" in SWEEP.refused(*SLURM, "--force")
    said = go_on(here, monkeypatch)
    assert said == f"18 of 18 runs of this task are there, {18 - there['done']} of them now."
    (here / "queue").write_text("")
    assert SWEEP.report(*SLURM)["remarks"] == ["Job 7 has ended before all was made; its logs say why."]
    assert SWEEP.report(*WORDS, "--backend", "serial")["made"] == 18
    found = dict(arrays(here / "wire.zarr"))
    assert found | {MADE: expected[MADE]} == expected  # in other chunks, whose checksums are others
    assert Store(here / "wire.zarr").find_damaged() == []
    assert "36 of 36 runs, 0 of them now" in SWEEP.fine(*SLURM)
    with pytest.raises(StoppedError, match="holds another sweep now"):
        go_on(here, monkeypatch, seed=1)


def go_on(here: Path, monkeypatch: pytest.MonkeyPatch, **other: Any) -> str:
    """What the task says that was requeued, started once more: in this process, which is quicker."""
    folder = here / "wire.zarr.slurm"
    for name, value in (TASK | {"SUBMITIT_EXECUTOR": "slurm", "SUBMITIT_FOLDER": str(folder)}).items():
        monkeypatch.setenv(name, value)
    task = submitit.core.utils.DelayedSubmission.load(folder / "7_0_submitted.pkl").function
    before = signal.getsignal(signal.SIGTERM)
    try:
        return replace(task, workers=0, job=replace(task.job, spec=json.dumps(json.loads(task.job.spec) | other)))()
    finally:
        signal.signal(signal.SIGTERM, before)


def test_a_task_that_is_ended_in_vain_gives_up(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    paths = SimpleNamespace(folder=tmp_path, job_id="7_0")
    monkeypatch.setattr(submitit, "JobEnvironment", lambda: SimpleNamespace(paths=paths))
    for there in (0, 0, 0, 0, 2, 2, 2, 2, 2):
        slurm_array._count_starts(there)
    with pytest.raises(StoppedError, match="ended 5 times before it had made a chunk more"):
        slurm_array._count_starts(2)


def test_words_are_what_sbatch_is_given() -> None:
    words = "partition=short, time=90 s, cpus=8, nodelist=n[1,3], memory=1.5 GB, parallel=4"
    asked = parse_slurm_options(words).to_submitit()
    assert asked == {
        "time": 2,
        "cpus_per_task": 8,
        "array_parallelism": 4,
        "signal_delay_s": 30,
        "additional_parameters": {"requeue": True, "partition": "short", "nodelist": "n[1,3]", "mem": "1536M"},
    }
    assert parse_slurm_options("") == SlurmOptions()
    times = {"2 h": 7200, "1:30": 90, "1:30:00": 5400, "1-02:00:00": 93600, "1-02:30": 95400}
    assert {one: parse_slurm_options(f"time={one}").time for one in times} == times


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        ("partitoin=a", "Did you mean `partition`"),
        ("partition", "is no option of SLURM"),
        ("time=2", "has no unit"),
        ("time=0 h", "must be above 0"),
        ("cpus=0", "from 1 to"),
        ("memory=4", "is written `4 GB`"),
        ("cpus=1, cpus=2", "given twice"),
    ],
)
def test_it_refuses_words(words: str, sentence: str) -> None:
    with pytest.raises(InputError, match=sentence):
        parse_slurm_options(words)


def test_it_refuses(here: Path) -> None:
    assert "`--workers` has no effect with `--slurm`" in SWEEP.refused(*SLURM, "--workers", "2")
    assert "which is not given" in SWEEP.refused(*WORDS, "--dry-run")
    (here / "bin" / "sbatch").write_text("#!/bin/sh\necho 'sbatch: error: invalid partition' >&2; exit 1\n")
    done = SWEEP(*SLURM)
    assert done.exit_code == 2 and "SLURM refuses the array: invalid partition." in done.output
