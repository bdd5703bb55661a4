"""Sweeps in several processes: some die, some are killed, and two commands share a store.

Sources of truth: the same sweep in this process, undisturbed; jobs whose runs double their number.
"""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import pytest
from sweep_cases import OVER, WIRE, Doubling, arrays, ran, undisturbed, wanted

from martensite.base.status import Status
from martensite.design.sweep.api import SweepExecution, begin_sweep
from martensite.design.sweep.backends.processes import Processes
from martensite.design.sweep.store import Store
from martensite.scenario.scenario import load

PATIENCE = 60.0


# ---------------------------------------------------------------- processes that die


def test_a_run_that_kills_its_process_is_the_only_one_lost(tmp_path: Path) -> None:
    found = ran(Processes(1), Doubling(tmp_path, size=8, chunk=2, deadly=(3,)))
    assert found.status == {Status.OK: 7, Status.LOST: 1}
    assert any("run 3 (RuntimeError: its process died)" in remark for remark in found.remarks)
    assert any("A process died at chunk 1" in remark for remark in found.remarks)


def test_a_process_that_dies_once_costs_nothing(tmp_path: Path) -> None:
    found = ran(Processes(1), Doubling(tmp_path, size=4, chunk=2, deadly=(0,), once=True))
    assert (found.status, found.done) == ({Status.OK: 4}, 4)
    assert "which was made again" in found.remarks[0]


def test_a_process_that_cannot_start_is_no_lost_run(tmp_path: Path) -> None:
    """A script without its guard is run again by every process that it starts."""
    script = tmp_path / "script.py"
    script.write_text(
        "from pathlib import Path\n"
        "from sweep_cases import Doubling\n"
        "from martensite.design.sweep.backends.processes import Processes\n"
        f"list(Processes(1).run(Doubling(Path({str(tmp_path)!r}), size=4), [0]))\n"
    )
    done = subprocess.run(
        [sys.executable, str(script)],
        capture_output=True,
        text=True,
        check=False,
        env=os.environ | {"PYTHONPATH": os.pathsep.join(sys.path)},
    )
    assert done.returncode != 0
    assert 'under `if __name__ == "__main__":`' in done.stderr.splitlines()[-1]
    assert list(tmp_path.glob("*.npy")) == []


# ---------------------------------------------------------------- commands that are killed


def command(folder: Path, *words: str) -> subprocess.Popen[str]:
    """The whole command, in a process group of its own."""
    (folder / "wire.toml").write_text(WIRE, encoding="utf-8")
    program = "from martensite.cli import main; main()"
    arguments = "sweep", "wire.toml", "--out", "s.zarr", "--runtime", "floats", *words
    return subprocess.Popen(
        [sys.executable, "-c", program, *arguments],
        cwd=folder,
        start_new_session=True,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )


def when(true: Callable[[], bool]) -> None:
    """Wait until something is so."""
    end = time.monotonic() + PATIENCE
    while not true():
        assert time.monotonic() < end
        time.sleep(0.02)


def chunks_in(path: Path) -> int:
    return len(list((path / "made" / "c").glob("[0-9]*"))) if path.exists() else 0


def killed(folder: Path, least: int, *words: str) -> int:
    """Chunks that are there when a command was killed, and all processes of it are gone."""
    running = command(folder, *words)
    when(lambda: chunks_in(folder / "s.zarr") >= least)
    os.kill(running.pid, signal.SIGKILL)
    running.communicate()
    when(lambda: not alive(running.pid))
    return chunks_in(folder / "s.zarr")


def alive(group: int) -> bool:
    """Whether any process of a group is left."""
    try:
        os.killpg(group, 0)
    except ProcessLookupError:
        return False
    return True


def test_a_killed_command_goes_on_to_the_same_bits(tmp_path: Path) -> None:
    small = OVER[0], "high=2..4 V:7"
    expected = undisturbed(tmp_path / "whole.zarr", *small, chunk=1)
    words = "--over", small[0], "--over", small[1], "--chunk-size", "1", "--backend", "serial"
    assert 3 <= killed(tmp_path, 3, *words) < 21
    path, scenario = tmp_path / "s.zarr", load(tmp_path / "wire.toml")
    assert 0 < begin_sweep(scenario, wanted(*small, chunk=1), path, SweepExecution("serial")).run().new_runs < 21
    assert dict(arrays(path)) == expected


MANY = "diameter=0.12..0.2 mm", "high=2..4 V"
LONG = ("--over", MANY[0], "--over", MANY[1], "--sample", "sobol:100", "--chunk-size", "2")


@pytest.mark.slow
def test_killed_processes_go_on_to_the_same_bits(tmp_path: Path) -> None:
    expected = undisturbed(tmp_path / "whole.zarr", *MANY, sample="sobol:100", chunk=2)
    for least in (5, 20):
        assert least <= killed(tmp_path, least, *LONG, "--workers", "2") < 50
    done = command(tmp_path, *LONG, "--workers", "2")
    assert done.communicate()[1] == ""
    assert dict(arrays(tmp_path / "s.zarr")) == expected


@pytest.mark.parametrize("number", [signal.SIGINT, pytest.param(signal.SIGTERM, marks=pytest.mark.slow)])
def test_an_interrupted_command_ends_with_a_sentence(tmp_path: Path, number: signal.Signals) -> None:
    """A terminal sends Ctrl-C to the whole group, others their signal to the command alone."""
    running = command(tmp_path, *LONG, "--workers", "2")
    when(lambda: chunks_in(tmp_path / "s.zarr") >= 4)
    begin = time.monotonic()
    (os.killpg if number is signal.SIGINT else os.kill)(running.pid, number)
    _, said = running.communicate()
    assert time.monotonic() - begin < 2.5
    assert running.returncode == 130
    assert said.startswith("error: Interrupted when ")
    assert said.count("\n") == 1
    when(lambda: not alive(running.pid))
    kept = chunks_in(tmp_path / "s.zarr")
    assert 4 <= kept < 50
    assert Store(tmp_path / "s.zarr").find_damaged() == []


def test_a_process_whose_parent_is_killed_ends(tmp_path: Path) -> None:
    script = tmp_path / "script.py"
    script.write_text(
        "import os, sys, time\n"
        "from martensite.design.sweep.backends.processes import _open_pool\n"
        'if __name__ == "__main__":\n'
        "    with _open_pool(1) as pool:\n"
        "        print(pool.submit(os.getpid).result(), flush=True)\n"
        "        pool.submit(time.sleep, 600)\n"
        "        time.sleep(600)\n"
    )
    parent = subprocess.Popen([sys.executable, str(script)], stdout=subprocess.PIPE, text=True)
    assert parent.stdout
    child = int(parent.stdout.readline())
    parent.kill()
    parent.wait()
    parent.stdout.close()

    def gone() -> bool:
        try:
            return "State:\tZ" in Path(f"/proc/{child}/status").read_text()
        except (FileNotFoundError, ProcessLookupError):
            return True

    when(gone)


# ---------------------------------------------------------------- several at a time


def test_two_commands_share_a_store_from_its_beginning(tmp_path: Path) -> None:
    small = "diameter=0.12..0.2 mm:2", "high=2..4 V:3"
    expected = undisturbed(tmp_path / "whole.zarr", *small, chunk=1)
    words = "--over", small[0], "--over", small[1], "--chunk-size", "1", "--step", "0.1 s", "--backend", "serial"
    both = [command(tmp_path, *words, "--chunk", f"{i}/2") for i in (1, 2)]
    for running in both:
        assert running.communicate()[1] == ""
        assert running.returncode == 0
    assert dict(arrays(tmp_path / "s.zarr")) == expected
    assert sorted(p.name for p in tmp_path.iterdir()) == ["s.zarr", "whole.zarr", "wire.toml"]
