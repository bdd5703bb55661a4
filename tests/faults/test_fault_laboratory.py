"""Thousands of inputs and files with a fault: each is answered, refused in a sentence, or fails with a status.

Nothing ends in a traceback, hangs, gives a number that is none, or loses something in silence. The
experiments are those of `fault_experiments.py`; `python tests/fault_experiments.py NAME SEED` makes one again.

Source of truth: the same work undisturbed, to the last bit; or a sentence.
"""

from __future__ import annotations

import shutil
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
from fault_experiments import EXPERIMENTS, LARGE, can_mount, list_wanted
from fault_trials import FINE, HOSTILE, Outcome, Trial, count_trials, run_trials

SMALL = {
    "scenarios": 16,
    "commands": 3,
    "logs": 8,
    "models": 6,
    "materials": 6,
    "saved results": 1,
    "binary logs": 2,
    "stores": 4,
    "kills": 1,
    "clocks": 1,
    "full disks": 1,
    "read-only folders": 1,
    "exported C": 1,
    "titles": 6,
    "hostile folders": 1,
    "foreign caches": 1,
}
"""Trials of each experiment in the small run; the seeds are the first ones."""
FIRST = {"foreign caches": 1}
"""First seed, if not 0: a writable library (`test_compiled_cache.py` opens its folder)."""
CHUNK = 500
"""Trials of a test of the large run."""
NEEDS_ROOT = ("full disks", "read-only folders", "read-only caches")
PATIENCE = 300.0


def require_means(name: str, folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Skip an experiment that this machine cannot make."""
    monkeypatch.setenv("TMPDIR", str(folder))
    monkeypatch.chdir(folder)
    if name in NEEDS_ROOT and not can_mount():
        pytest.skip("no disk of its own can be mounted here (needs root)")
    if name in ("exported C", "FMUs") and shutil.which("gcc") is None:
        pytest.skip("no gcc with its sanitizers on this machine")
    if name == "FMUs":
        pytest.importorskip("fmpy")
    if name == "clusters":
        pytest.importorskip("distributed")


def list_faults(trials: list[Trial]) -> str:
    """Those that are not fine, in words."""
    return "\n".join(str(trial) for trial in trials if not trial.fine)


@pytest.fixture(scope="module")
def small_run() -> dict[str, list[Trial]]:
    """All experiments that need no means of their own, in one process."""
    counts = {name: count for name, count in SMALL.items() if name not in NEEDS_ROOT}
    wanted = [one for name, count in counts.items() for one in list_wanted(name, count, FIRST.get(name, 0))]
    found = run_trials(wanted, cap=PATIENCE)
    assert [(one.experiment, one.seed) for one in found] == wanted
    return {name: [one for one in found if one.experiment == name] for name in SMALL}


@pytest.mark.parametrize("name", [name for name in SMALL if name not in NEEDS_ROOT])
def test_a_few_of_every_kind(small_run: dict[str, list[Trial]], name: str) -> None:
    assert list_faults(small_run[name]) == ""


@pytest.mark.parametrize("name", [name for name in NEEDS_ROOT if name in SMALL])
def test_disks_of_a_few_kilobytes(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    require_means(name, tmp_path, monkeypatch)
    assert list_faults(run_trials(list_wanted(name, SMALL[name], first=1), cap=PATIENCE)) == ""


def test_the_small_run_tries_something(small_run: dict[str, list[Trial]]) -> None:
    """Faults that are all refused at the door would show little."""
    counts = count_trials(one for trials in small_run.values() for one in trials)
    for name in ("scenarios", "commands", "logs", "models", "materials", "titles"):
        assert counts[name].get(Outcome.ANSWERED, 0) > 0, counts
    assert counts["scenarios"][Outcome.REFUSED] > 5


@pytest.mark.slow
@pytest.mark.parametrize("first", range(0, LARGE["scenarios"], CHUNK))
def test_thousands_of_scenarios(first: int) -> None:
    assert list_faults(run_trials(list_wanted("scenarios", CHUNK, first), cap=PATIENCE)) == ""


@pytest.mark.slow
@pytest.mark.parametrize("name", [name for name in LARGE if name != "scenarios"])
def test_many_of_every_kind(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    require_means(name, tmp_path, monkeypatch)
    assert list_faults(run_trials(list_wanted(name, LARGE[name]), cap=PATIENCE)) == ""


# ---------------------------------------------------------------- steps without end

STEPS = """
import resource
import martensite as ms
from fault_experiments import QUICK
from martensite.scenario.scenario import read_scenario
scenario = read_scenario(QUICK)
ms.run(scenario, step=1e-3, runtime="c")
before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
result = ms.run(scenario, step=2.0 / {steps}, runtime="c")
assert result.steps >= {steps} and result["temperature"].max() > 320.0, (result.steps, result["temperature"].max())
print(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before)
"""


@pytest.mark.parametrize("steps", [3 * 10**5, pytest.param(10**7, marks=pytest.mark.slow)])
def test_memory_does_not_grow_with_the_steps(steps: int, c_compiler: str) -> None:
    """The truth: 21 samples are kept, whatever the steps; a number of each would be 2.4 MB and more."""
    code = f"import sys; sys.path[:0] = {sys.path!r}\n{STEPS.format(steps=steps)}"
    done = subprocess.run([sys.executable, "-W", "ignore", "-c", code], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert int(done.stdout) < 2000, f"{done.stdout} kB"


# ---------------------------------------------------------------- the laboratory itself

WRONG = """
import ctypes, math, os, sys, time
from types import SimpleNamespace
from pathlib import Path
from fault_trials import *
from martensite.base.errors import InputError, SolveError
from martensite.base.status import Status

def raise_bug(seed): return 1 / 0
def raise_sentence(seed): raise InputError("Parameter `x` must be positive, but is -1.")
def raise_failure(seed): raise SolveError("The run failed at 3 s.")
def raise_nothing(seed): raise InputError(" ")
def raise_novel(seed): raise InputError("word " * 2000)
def spin(seed):
    while True: pass
def spin_in_c(seed): sum(range(10**13))
def sleep(seed): time.sleep(600)
def crash(seed): ctypes.string_at(0)
def eat(seed): return bytearray(2**33)
def judge(**changed):
    given = dict(columns={"x": [0.0, 1.0]}, times=[0.0, 2.0], status=Status.OK, accuracy=1e-5, warnings=[])
    return judge_result(SimpleNamespace(**given | changed), 2.0, 2)
def answer(seed): return judge()
def answer_nan(seed): return judge(columns={"x": [0.0, math.nan]})
def answer_no_accuracy(seed): return judge(accuracy=math.nan)
def end_early(seed): return judge(times=[0.0, 1.5])
def end_early_and_say_so(seed): return judge(times=[0.0, 1.5], warnings=["It ends at 1.5 s instead of 2 s."])
def lose_samples(seed): return judge(times=[0.0])
def fail(seed): return judge(status=Status.UNSOLVED)
def write_nothing(seed): return judge_command(0, "wrote out.nc", "", [Path("out.nc")])
def say_nothing(seed): return judge_command(1, "", "")
def print_nan(seed): return judge_command(0, "stroke  nan mm", "")
def print_nan_as_json(seed): return judge_command(0, '{"a": [1, {"b": NaN}]}', "")
def name_nan(seed): return judge_command(0, '{"title": "nan"}', "")
def print_traceback(seed): return judge_command(1, "", "Traceback (most recent call last):")
def die(seed): return judge_command(139, "", "")
def change_bits(seed): return judge_differences({"a": b"1"}, {"a": b"2"})
def lose_array(seed): return judge_differences({}, {"a": b"2"})
work_off({name: one for name, one in globals().items() if callable(one)}, dict.fromkeys(("spin", "spin_in_c"), 0.3),
         os.fdopen(os.dup(1), "w"))
"""
MEANT = {
    Outcome.ANSWERED: ("answer", "end_early_and_say_so", "name_nan"),
    Outcome.REFUSED: ("raise_sentence",),
    Outcome.FAILED: ("raise_failure", "fail"),
    Outcome.TRACEBACK: ("raise_bug", "raise_nothing", "raise_novel", "crash", "eat", "print_traceback", "die"),
    Outcome.HANG: ("spin", "spin_in_c", "sleep"),
    Outcome.NAN: ("answer_nan", "answer_no_accuracy", "print_nan", "print_nan_as_json"),
    Outcome.LOSS: ("end_early", "lose_samples", "write_nothing", "say_nothing", "change_bits", "lose_array"),
}


@pytest.fixture(scope="module")
def wrong_run(tmp_path_factory: pytest.TempPathFactory) -> Iterator[list[Trial]]:
    """Experiments that are wrong on purpose, with sound ones after them."""
    program = tmp_path_factory.mktemp("wrong") / "wrong.py"
    program.write_text(WRONG, encoding="utf-8")
    wanted = [(name, 0) for names in MEANT.values() for name in names]
    yield run_trials([*wanted, ("answer", 1)], str(program), cap=8.0)


@pytest.mark.parametrize("outcome", Outcome)
def test_the_laboratory_notices(wrong_run: list[Trial], outcome: Outcome) -> None:
    names = [trial.experiment for trial in wrong_run if trial.outcome is outcome and trial.seed == 0]
    assert tuple(names) == MEANT.get(outcome, ()), "\n".join(map(str, wrong_run))
    assert all(trial.fine is (trial.outcome in FINE) for trial in wrong_run)


def test_it_goes_on_after_a_trial_that_ends_its_process(wrong_run: list[Trial]) -> None:
    assert len(wrong_run) == sum(map(len, MEANT.values())) + 1
    assert (wrong_run[-1].experiment, wrong_run[-1].seed) == ("answer", 1)
    assert wrong_run[-1].outcome is Outcome.ANSWERED


def test_every_experiment_is_in_the_large_run() -> None:
    assert set(SMALL) < set(LARGE) == set(EXPERIMENTS)
    assert len(HOSTILE) >= 60
