"""Trials with a fault in them: what becomes of each, in classes; judges, mutators, and a time cap.

A trial is an experiment of `fault_experiments.py`, a function of a seed, so that every finding is
made again by two words:

    python tests/fault_experiments.py scenarios 4711

Trials run one after another in a process of their own. One that kills it, or that takes longer than
its cap, is noticed from outside, and the next process goes on with those that are left.
"""

from __future__ import annotations

import json
import math
import os
import random
import re
import select
import signal
import subprocess
import sys
import tempfile
import time
import traceback
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import asdict, dataclass
from enum import StrEnum
from pathlib import Path
from typing import Any

from martensite.base.errors import MartensiteError

LONGEST_SENTENCE = 3000
"""Letters of the longest sentence that is still one."""
MEMORY = 6 * 2**30
"""Address space [bytes] of the process in which trials run."""
PATIENCE = 60.0
"""Wall time [s] for starting, and beside the CPU time of a trial: the machine may be busy."""


class Outcome(StrEnum):
    """What becomes of a trial."""

    ANSWERED = "answered"
    REFUSED = "refused"
    """By a sentence, as bad input."""
    FAILED = "failed"
    """A run was begun and failed: a status, and a sentence."""
    LEFT_OUT = "left out"
    """Sound, but millions of steps long: it was not run."""
    TRACEBACK = "traceback"
    """An error that nobody meant, or a process that died."""
    HANG = "hang"
    NAN = "nan"
    LOSS = "silent loss"
    """Something is missing or changed, and nothing says so."""


FINE = frozenset({Outcome.ANSWERED, Outcome.REFUSED, Outcome.FAILED, Outcome.LEFT_OUT})
Verdict = tuple[Outcome, str]
"""What became of a trial, and the words that show it."""
Experiment = Callable[[int], Verdict]


@dataclass(frozen=True)
class Trial:
    """An experiment with a seed, and what became of it."""

    experiment: str
    seed: int
    outcome: Outcome
    words: str

    @property
    def fine(self) -> bool:
        return self.outcome in FINE

    def __str__(self) -> str:
        return f"{self.experiment} {self.seed}: {self.outcome}: {self.words[-1500:]}"


# ---------------------------------------------------------------- judges


def judge_error(error: BaseException) -> Verdict:
    """An error on purpose is a sentence; any other is a traceback."""
    if not isinstance(error, MartensiteError):
        return Outcome.TRACEBACK, "".join(traceback.format_exception(error))[-3000:]
    said = str(error)
    if not said.strip() or len(said) > LONGEST_SENTENCE:
        return Outcome.TRACEBACK, f"no sentence ({len(said)} letters): {said[:200]}"
    return (Outcome.REFUSED if error.exit_code == 2 else Outcome.FAILED), said


def judge_call(call: Callable[[], Verdict]) -> Verdict:
    """What a call answers, or the verdict on its error."""
    try:
        return call()
    except Exception as error:
        return judge_error(error)


def judge_result(result: Any, duration: float, samples: int | None) -> Verdict:
    """Every number of a run is one, and all that was asked for is there, unless it says that it failed."""
    for name, column in result.columns.items():
        rows = column if len(column) and hasattr(column[0], "__len__") else [column]
        if not all(math.isfinite(value) for row in rows for value in row):
            return Outcome.NAN, f"column {name}, status {result.status.name}"
        if len(column) != len(result.times):
            return Outcome.LOSS, f"column {name} has {len(column)} of {len(result.times)} samples"
    if result.accuracy is not None and not math.isfinite(result.accuracy):
        return Outcome.NAN, f"accuracy {result.accuracy}, status {result.status.name}"
    if result.status.failed:
        return Outcome.FAILED, result.status.sentence
    if samples is not None and len(result.times) != samples:
        return Outcome.LOSS, f"{len(result.times)} of {samples} samples"
    told = any(f"instead of {duration:.6g} s" in warning for warning in result.warnings)
    if not told and not math.isclose(result.times[-1], duration, rel_tol=1e-6):
        return Outcome.LOSS, f"ends at {result.times[-1]} s of {duration} s"
    return Outcome.ANSWERED, f"{len(result.times)} samples"


def judge_command(code: int, out: str, err: str, files: Sequence[Path] = ()) -> Verdict:
    """A command that has ended: its exit code, what it printed, and the files that it promised."""
    shown = f"exit {code}; {err[-1500:]}"
    if "Traceback" in out + err or code not in (0, 1, 2):
        return Outcome.TRACEBACK, shown
    if code == 0:
        if odd := find_nan(out):
            return Outcome.NAN, odd
        absent = [str(path) for path in files if not path.exists() or path.stat().st_size == 0]
        return (Outcome.LOSS, f"exit 0 without {absent}") if absent else (Outcome.ANSWERED, out[-200:])
    if not err.strip() and not (code == 1 and out.strip()):
        return Outcome.LOSS, f"exit {code} without a word"
    if len(err) > LONGEST_SENTENCE:
        return Outcome.TRACEBACK, f"no sentence ({len(err)} letters): {err[:200]}"
    return (Outcome.REFUSED if code == 2 else Outcome.FAILED), err.strip()


def find_nan(out: str) -> str:
    """The place of a number in an answer that is none: in JSON by its path, in text by its line."""
    try:
        tree = json.loads(out)
    except ValueError:
        return next((line for line in out.splitlines() if re.search(r"(?<![\w`\"])nan(?![\w`\"])", line)), "")
    for path in list_places(tree):
        value = tree
        for key in path:
            value = value[key]
        if isinstance(value, float) and not math.isfinite(value):
            return ".".join(map(str, path))
    return ""


def judge_differences(found: Mapping[str, bytes], expected: Mapping[str, bytes]) -> Verdict:
    """Arrays by name, which must be those of the undisturbed work to the last bit."""
    odd = sorted(name for name in {*found, *expected} if found.get(name) != expected.get(name))
    return (Outcome.LOSS, f"differs: {', '.join(odd)}") if odd else (Outcome.ANSWERED, "equal bit for bit")


# ---------------------------------------------------------------- mutators

HOSTILE: tuple[Any, ...] = (
    *("", " ", "x", "nan", "inf", "-inf mm", "nan degC", "-1 mm", "0 mm", "0 s", "1e400 mm", "1e-300 mm", "1 furlong"),
    *("20 degC", "1 V", "1 A", "1 W", "1 K", "1 s", "1 Hz", "-300 degC", "5 %", "\0", "\n", "'", '"', "=1+1", "../x"),
    *("/etc/passwd", "data:x/y", "x.toml", "𝒳" * 50, "x" * 2000, "1 mm mm", "1e5", "{}", "%s%n", "${HOME}", "true"),
    *(True, False, 0, -1, 1, 2**63, 10**300, 1e308, -0.0, 5e-324, math.nan, math.inf, -math.inf),
    *([], {}, [[]], [1, "x"], {"kind": "x"}, {"kind": []}, {"": ""}, {"file": "/etc/passwd"}),
)
FACTORS = (
    *(0.01, 0.1, 0.3, 0.5, 0.7, 0.9, 0.99, 1.01, 1.1, 1.5, 2.0, 3.0, 10.0, 100.0),
    *(0.0, -1.0, 1e-9, 1e-3, 1e3, 1e9, 1e300, math.nan, math.inf),
)
NUMBER = re.compile(r"[-+]?\d+\.?\d*(?:[eE][-+]?\d+)?")


def spoil_bytes(raw: bytes, rng: random.Random, within: int = 2**30) -> bytes:
    """Cut, flipped bits, noise at the beginning, a hole, or something twice."""
    size = min(len(raw), within)
    if size == 0:
        return rng.randbytes(20)
    at, length = rng.randrange(size), rng.randrange(1, max(2, size // 4))
    match rng.choice(("cut", "flip", "flip", "noise", "zero", "twice", "drop")):
        case "cut":
            return raw[: rng.randrange(len(raw))]
        case "noise":
            return rng.randbytes(min(200, size)) + raw[200:]
        case "zero":
            return raw[:at] + bytes(length) + raw[at + length :]
        case "twice":
            return raw[: at + length] + raw[at:]
        case "drop":
            return raw[:at] + raw[at + length :]
        case _:
            spoilt = bytearray(raw)
            for _ in range(rng.choice((1, 1, 3, 40))):
                spoilt[rng.randrange(size)] ^= 1 << rng.randrange(8)
            return bytes(spoilt)


def list_places(node: Any, path: tuple[str | int, ...] = ()) -> Iterator[tuple[str | int, ...]]:
    """Paths to every value of a document, tables and lists too."""
    entries: Iterable[tuple[str | int, Any]] = ()
    if isinstance(node, dict):
        entries = node.items()
    elif isinstance(node, list):
        entries = enumerate(node)
    for key, below in entries:
        yield (*path, key)
        yield from list_places(below, (*path, key))


def spoil_value(value: Any, rng: random.Random, words: Sequence[str]) -> Any:
    """A number times a factor, a name of the same kind, or something hostile."""
    pick = rng.random()
    if pick < 0.7 and isinstance(value, str) and (found := NUMBER.search(value)):
        number = float(found[0]) * rng.choice(FACTORS)
        return f"{value[: found.start()]}{number!r}{value[found.end() :]}"
    if pick < 0.7 and isinstance(value, int | float):
        return value * rng.choice(FACTORS)
    if pick < 0.85 and isinstance(value, str) and words:
        return rng.choice(words)
    return rng.choice(HOSTILE)


def spoil_document(document: Any, rng: random.Random, words: Sequence[str]) -> str:
    """Change one place of a document in place: what is there, that it is there, or its name."""
    places = list(list_places(document))
    places = [path for path in places if path != ("title",)] or [("title",)]
    *above, last = rng.choice(places)
    box: Any = document
    for key in above:
        box = box[key]
    pick = rng.random()
    if pick < 0.8 or not isinstance(box, dict):
        box[last] = spoil_value(box[last], rng, words)
    elif pick < 0.9:
        del box[last]
    elif pick < 0.95:
        box[f"{last}x"] = box.pop(last)
    else:
        box[rng.choice(words)] = rng.choice(HOSTILE)
    return ".".join(map(str, (*above, last)))


# ---------------------------------------------------------------- a process of its own


def work_off(experiments: Mapping[str, Experiment], caps: Mapping[str, float], out: Any) -> None:
    """Do the trials that come on standard input, and write what becomes of each as a line.

    The system itself ends the process when the CPU time of a trial is spent, in C code too.
    """
    import gc
    import resource

    gc.set_threshold(20_000, 20, 25)  # as in conftest.py
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY, resource.getrlimit(resource.RLIMIT_AS)[1]))
    for name, seed in json.loads(sys.stdin.read()):
        signal.setitimer(signal.ITIMER_PROF, caps.get(name, 10.0))
        outcome, words = judge_call(lambda name=name, seed=seed: experiments[name](seed))
        signal.setitimer(signal.ITIMER_PROF, 0.0)
        out.write(json.dumps([name, seed, outcome, words]) + "\n")
        out.flush()


def run_trials(wanted: Iterable[tuple[str, int]], program: str = "", cap: float = PATIENCE) -> list[Trial]:
    """Do trials in processes of their own, and look at these from outside.

    Args:
        wanted: experiments and seeds.
        program: the program that does them: `fault_experiments.py`, or a wrong one.
        cap: wall time [s] without news from which on a trial hangs.
    """
    left, found = list(wanted), list[Trial]()
    program = program or str(Path(__file__).with_name("fault_experiments.py"))
    while left:
        done, word = _run_some(left, program, cap)
        found += done
        left = left[len(done) :]
        if left:
            found.append(Trial(*left.pop(0), *word))
    return found


def _run_some(left: Sequence[tuple[str, int]], program: str, cap: float) -> tuple[list[Trial], Verdict]:
    """The trials until one ends the process, and how that one ends it."""
    done = list[Trial]()
    with tempfile.TemporaryDirectory() as folder, tempfile.TemporaryFile("w+") as errors:
        process = subprocess.Popen(
            [sys.executable, program, "work"],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=errors,
            cwd=folder,
            start_new_session=True,
            env=os.environ | {"PYTHONPATH": os.pathsep.join(filter(None, sys.path)), "TMPDIR": folder},
        )
        assert process.stdin and process.stdout
        process.stdin.write(json.dumps(list(left)).encode())
        process.stdin.close()
        word: Verdict = Outcome.HANG, f"no news for {cap:g} s"
        while select.select([process.stdout], [], [], cap)[0]:
            if not (line := process.stdout.readline()):
                break
            name, seed, outcome, words = json.loads(line)
            done.append(Trial(name, seed, Outcome(outcome), words))
        else:
            os.killpg(process.pid, signal.SIGKILL)
        process.stdout.close()
        code = process.wait()
        with suppress(ProcessLookupError):
            os.killpg(process.pid, signal.SIGKILL)  # what it began and left behind
        if code == -signal.SIGPROF:
            word = Outcome.HANG, "its CPU time is spent"
        elif code != -signal.SIGKILL or word[0] is not Outcome.HANG:
            errors.seek(0)
            word = Outcome.TRACEBACK, f"the process ended with {code}: {errors.read()[-2000:]}"
    return done, word


def wait_until(true: Callable[[], bool], patience: float = PATIENCE) -> bool:
    """Wait until something is so; whether it came."""
    end = time.monotonic() + patience
    while not true():
        if time.monotonic() > end:
            return False
        time.sleep(0.02)
    return True


def count_trials(trials: Iterable[Trial]) -> dict[str, dict[str, int]]:
    """How many trials of each experiment came out how."""
    table: dict[str, dict[str, int]] = {}
    for trial in trials:
        row = table.setdefault(trial.experiment, {})
        row[trial.outcome] = row.get(trial.outcome, 0) + 1
    return table


def write_trials(trials: Sequence[Trial], path: Path) -> None:
    """Every trial as a line of JSON."""
    path.write_text("".join(json.dumps(asdict(trial)) + "\n" for trial in trials), encoding="utf-8")
