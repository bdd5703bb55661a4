"""Commands that are interrupted: by Ctrl-C or SIGTERM, heard or not heard.

Source of truth: what a shell sees of the process: its exit code, what it has said, the files that it leaves, and
the processes that are left of its group.
"""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from contextlib import suppress
from pathlib import Path

import pytest

from martensite.base.interrupts import InterruptError, rescue_answer

PATIENCE = 60.0
LATEST = 2.5
"""How late a process may end [s]: about a second, on a machine that does other things."""
SENTENCE = "error: Interrupted; the best so far is kept.\n"
PROGRAM = """
import hashlib, sys, time
from pathlib import Path
from martensite.base.errors import MartensiteError
from martensite.base.interrupts import accept_interrupt, handle_signals, hold_interrupts, rescue_answer

def keep():
    Path("kept").write_text("best so far")
    return "Interrupted; the best so far is kept."

def tell():
    print("ready", flush=True)

def work():
    {work}

with handle_signals():
    try:
        with rescue_answer(keep):
            work()
    except MartensiteError as error:
        print("error:", error, file=sys.stderr)
        sys.exit(error.exit_code)
"""
SLEEPING = "tell(); time.sleep(60)"
DEAF = "tell(); hashlib.pbkdf2_hmac('sha256', b'', b'', 10**8)"
"""A minute in C, in which no signal is heard."""
SWALLOWING = """
    tell()
    while True:
        try:
            time.sleep(60)
        except KeyboardInterrupt:
            pass"""
BOTH = signal.SIGINT, signal.SIGTERM


class Running:
    """A process in a group of its own, and how it ends."""

    def __init__(self, folder: Path, *words: str) -> None:
        self.process = subprocess.Popen(
            [sys.executable, *words],
            cwd=folder,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            start_new_session=True,
            env=os.environ | {"PYTHONPATH": os.pathsep.join(sys.path)},
        )

    def wait_for(self, word: str) -> None:
        """Until it says so."""
        assert self.process.stdout
        for line in self.process.stdout:
            if line.strip() == word:
                return
        raise AssertionError(self.process.communicate()[1])

    def end(self, number: signal.Signals) -> tuple[int, str]:
        """Its exit code, and what it said; it ends in time, and none of its group is left."""
        begin = time.monotonic()
        if number is signal.SIGINT:  # a terminal sends it to the whole group
            os.killpg(self.process.pid, number)
        else:
            self.process.send_signal(number)
        try:
            said = self.process.communicate(timeout=PATIENCE)[1]
            took = time.monotonic() - begin
            assert took < LATEST, f"{took:.1f} s, {said}"
            while _is_alive(self.process.pid):
                assert time.monotonic() < begin + LATEST, "a process is left"
                time.sleep(0.02)
        finally:
            with suppress(ProcessLookupError):
                os.killpg(self.process.pid, signal.SIGKILL)
        return self.process.returncode, said


def _is_alive(group: int) -> bool:
    with suppress(ProcessLookupError):
        os.killpg(group, 0)
        return True
    return False


def begin(folder: Path, work: str) -> Running:
    """A program that works, inside of a block that keeps the best so far."""
    running = Running(folder, "-c", PROGRAM.format(work=work))
    running.wait_for("ready")
    return running


@pytest.mark.parametrize("number", BOTH)
@pytest.mark.parametrize("work", [SLEEPING, DEAF, SWALLOWING], ids=["sleeping", "deaf", "swallowing"])
def test_the_best_so_far_is_kept_and_said_once(tmp_path: Path, work: str, number: signal.Signals) -> None:
    assert begin(tmp_path, work).end(number) == (130, SENTENCE)
    assert (tmp_path / "kept").read_text() == "best so far"


def test_a_block_that_writes_is_not_cut_in_two(tmp_path: Path) -> None:
    written = """
    with hold_interrupts():
        tell()
        time.sleep(0.4)
        Path("whole").touch()
    Path("after").touch()"""
    assert begin(tmp_path, written).end(signal.SIGTERM) == (130, SENTENCE)
    assert sorted(one.name for one in tmp_path.iterdir()) == ["kept", "whole"]


def test_who_goes_on_with_the_best_so_far_is_let(tmp_path: Path) -> None:
    goes_on = """
    try:
        tell()
        time.sleep(60)
    except KeyboardInterrupt:
        accept_interrupt()
    time.sleep(1.2)
    Path("after").touch()"""
    assert begin(tmp_path, goes_on).end(signal.SIGTERM) == (0, "")
    assert [one.name for one in tmp_path.iterdir()] == ["after"]


def test_a_signal_that_comes_twice_is_one(tmp_path: Path) -> None:
    """`timeout` sends its own to the process and to the group."""
    slow = """
    try:
        tell()
        time.sleep(60)
    finally:
        time.sleep(0.2)
        Path("closed").touch()"""
    running = begin(tmp_path, slow)
    running.process.send_signal(signal.SIGTERM)
    time.sleep(0.05)
    assert running.end(signal.SIGTERM) == (130, SENTENCE)
    assert sorted(one.name for one in tmp_path.iterdir()) == ["closed", "kept"]


def test_an_ignored_signal_stays_ignored(tmp_path: Path) -> None:
    """As under `nohup`."""
    program = "import signal; signal.signal(signal.SIGTERM, signal.SIG_IGN)" + PROGRAM.format(
        work="tell(); time.sleep(0.5)"
    )
    running = Running(tmp_path, "-c", program)
    running.wait_for("ready")
    assert running.end(signal.SIGTERM) == (0, "")


def test_what_cannot_be_saved_is_said() -> None:
    def full() -> str:
        raise OSError("no space left")

    with pytest.raises(OSError, match="no space left"), rescue_answer(full):
        raise KeyboardInterrupt


def test_blocks_around_are_asked_where_one_has_nothing_to_say() -> None:
    asked: list[str] = []

    def clear() -> str:
        asked.append("inner")
        return ""

    with pytest.raises(InterruptError, match=r"^Kept\.$"), rescue_answer(lambda: "Kept."), rescue_answer(clear):
        raise KeyboardInterrupt
    assert asked == ["inner"]


@pytest.mark.parametrize("work", [SLEEPING, DEAF], ids=["sleeping", "deaf"])
def test_no_part_of_a_file_is_left(tmp_path: Path, work: str) -> None:
    writing = f"""
    from martensite.base.files import replace_file, replace_together
    with replace_together(), replace_file(Path("x.nc")) as part:
        part.touch()
        {work}"""
    assert begin(tmp_path, writing).end(signal.SIGTERM) == (130, SENTENCE)
    assert [one.name for one in tmp_path.iterdir()] == ["kept"]


@pytest.mark.parametrize("number", BOTH)
def test_a_command_ends_with_a_sentence(tmp_path: Path, number: signal.Signals) -> None:
    running = Running(tmp_path, "-X", "importtime", "-m", "martensite", "demo")
    assert running.process.stderr
    for line in running.process.stderr:  # it has begun
        if line.endswith(" martensite.scenario.examples\n"):
            break
    code, said = running.end(number)
    lines = [line for line in said.splitlines() if not line.startswith("import time:")]
    assert (code, lines) == (130, ["error: Interrupted; no file was written."])
    assert list(tmp_path.iterdir()) == []
