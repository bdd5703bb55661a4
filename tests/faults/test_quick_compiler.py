"""First answers come from a quick compiler, and the optimised library is compiled in the background.

Source of truth: which compiler made a library is a number that it returns; results are those of the usual compiler.
"""

from __future__ import annotations

import os
import subprocess
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from builders import hanging_wire

from martensite.base import files
from martensite.base.errors import InputError
from martensite.identify.blocks.polynomial import Polynomial
from martensite.identify.chains.engine import SHORT, ChainEngine
from martensite.kernels import compile_jobs
from martensite.kernels.compiler import find_compiler, is_compiled, load_library
from martensite.kernels.quick_compiler import find_tcc
from martensite.signals.step import Step
from martensite.simulate import march_kernel, marching_native
from martensite.simulate.api import simulate

SOURCE = "#ifndef QUICK\n#define QUICK 0\n#endif\nlong quick(void) { return QUICK; }\n"
VECTORS = "typedef double vector __attribute__((vector_size(16)));\n"
PATIENCE = 120.0
"""Longest time [s] that a test waits for the background."""
pytestmark = pytest.mark.skipif(find_compiler() is None or os.name != "posix", reason="no C compiler, or no tcc")


@pytest.fixture
def cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """A separate cache, and a `tcc` that marks what it compiles; waits until no process uses the cache."""
    programs, calls = tmp_path / "programs", tmp_path / "calls"
    programs.mkdir()
    monkeypatch.setenv("CC", str(find_compiler()))
    (programs / "tcc").write_text(f'#!/bin/sh\necho "$@" >> "{calls}"\nexec "{find_compiler()}" -DQUICK=1 "$@"\n')
    (programs / "tcc").chmod(0o700)
    monkeypatch.setenv("PATH", f"{programs}{os.pathsep}{os.environ['PATH']}")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    monkeypatch.setattr(files, "_TOLD", set())
    yield tmp_path / "cache" / "martensite" / "c"
    wait_for_background(tmp_path / "cache" / "martensite" / "c")


def wait_for_background(folder: Path) -> list[str]:
    """Return the names of the files in a cache when no job is left."""
    end = time.monotonic() + PATIENCE
    while folder.is_dir() and time.monotonic() < end:
        with compile_jobs._lock(folder) as free:
            if free and not list(folder.glob("*.job")):
                break
        time.sleep(0.05)
    return sorted(one.name for one in folder.glob("*.*")) if folder.is_dir() else []


def test_a_first_library_is_quick_and_the_next_one_optimised(cache: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("MARTENSITE_QUICK_C", "first")
    assert not is_compiled(SOURCE, soon=True)
    assert load_library(SOURCE, soon=True).quick() == 1
    assert is_compiled(SOURCE, soon=True)
    kept = wait_for_background(cache)
    assert len(kept) == 3 and kept[-1] == compile_jobs.LOCK  # library and digest: the quick ones are gone
    assert {one.stat().st_mode & 0o777 for one in cache.iterdir()} == {0o600}
    assert load_library(SOURCE, soon=True).quick() == 0
    assert load_library(f"/* many runs */ {SOURCE}").quick() == 0


def test_a_library_that_cannot_be_optimised_is_tried_once(cache: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("MARTENSITE_QUICK_C", "first")
    source = f"#if !QUICK\n#error\n#endif\n{SOURCE}"
    for _ in range(2):
        assert load_library(source, soon=True).quick() == 1
        (failed,) = (name for name in wait_for_background(cache) if name.endswith(".failed"))
    assert "failed" in (cache / failed).read_text()


def test_one_process_does_all_jobs(cache: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """While another process holds the lock, none is started; a process that finds it held ends at once."""
    monkeypatch.setenv("MARTENSITE_QUICK_C", "first")
    load_library(SOURCE, soon=True)
    wait_for_background(cache)
    done: list[Path] = []
    with compile_jobs._lock(cache) as free:
        assert free
        monkeypatch.setattr(compile_jobs, "_start", lambda *_: pytest.fail("a second process was started"))
        for number in range(3):
            assert load_library(f"/* {number} */ {SOURCE}", soon=True).quick() == 1
        compile_jobs.do_jobs(lambda path, *_: done.append(path))
        assert not done and len(list(cache.glob("*.job"))) == 3
    compile_jobs.do_jobs(lambda path, *_: done.append(path))
    assert len(done) == 3 and not list(cache.glob("*.job"))


def test_without_a_cache_nothing_is_done_in_the_background(
    cache: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("MARTENSITE_QUICK_C", "first")
    monkeypatch.setattr(compile_jobs, "_start", lambda *_: pytest.fail("a process was started"))
    cache.parents[1].write_text("a file where the folder should be")
    assert load_library(SOURCE, soon=True).quick() == 0
    assert "cannot be kept in the cache folder" in capsys.readouterr().err


def test_tcc_alone_compiles_what_it_supports(cache: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A tcc that fails, and vectors, which it may not know, are left to the usual compiler."""
    monkeypatch.setenv("MARTENSITE_QUICK_C", "only")
    assert load_library(SOURCE).quick() == 1
    assert load_library(VECTORS + SOURCE).quick() == 0
    (called,) = (tmp_path / "calls").read_text().splitlines()
    assert called.startswith("-shared")
    (tmp_path / "programs" / "tcc").write_text("#!/bin/sh\nexit 1\n")
    assert load_library(f"/* fails */ {SOURCE}").quick() == 0
    monkeypatch.setenv("MARTENSITE_QUICK_C", "off")
    assert load_library(SOURCE, soon=True).quick() == 0
    monkeypatch.setenv("MARTENSITE_QUICK_C", "never")
    with pytest.raises(InputError, match="must be first, only or off, but is `never`"):
        load_library(SOURCE)
    assert not list(cache.glob("*.job"))


def test_short_logs_need_no_optimised_model(cache: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The optimiser compiles for long logs alone, and nothing in the background; both give the same outputs."""
    monkeypatch.setenv("MARTENSITE_QUICK_C", "first")
    monkeypatch.setattr(compile_jobs, "_start", lambda *_: pytest.fail("a process was started"))
    u = np.sin(np.arange(SHORT + 1) / 30.0)[:, None]
    block = Polynomial(degree=9, low=-1.0, high=1.0)  # no other test loads its library
    model, theta = ChainEngine([block], 0.1), block.sample_parameters(np.random.default_rng(0), 10.0, 0.1)
    short = model.simulate(theta, u[:-1])
    assert len((tmp_path / "calls").read_text().splitlines()) == 1
    long = model.simulate(theta, u)
    assert len((tmp_path / "calls").read_text().splitlines()) == 1 and len(list(cache.glob("*.so"))) == 2
    assert long[:-1] == pytest.approx(short, rel=1e-12)


def test_runs_of_both_compilers_agree_to_their_accuracy(monkeypatch: pytest.MonkeyPatch) -> None:
    if not find_tcc():
        pytest.skip("there is no tcc")
    made: list[tuple[str, str]] = []

    def load(mode: str) -> None:
        def fresh(kernel: march_kernel.MarchKernel) -> object:
            monkeypatch.setenv("MARTENSITE_QUICK_C", mode)
            monkeypatch.setattr(compile_jobs, "order_library", lambda path, *_: made.append((mode, path.name)))
            return original(kernel)

        original = marching_native.load_kernel.__wrapped__  # type: ignore[attr-defined]
        monkeypatch.setattr(marching_native, "load_kernel", fresh)

    system, waveform = hanging_wire(mass=0.6), Step(high=1.3, at=0.5, until=4.0)
    keep, runs = marching_native.load_kernel, []
    for mode in ("off", "first"):
        monkeypatch.setattr(marching_native, "load_kernel", keep)
        load(mode)
        runs.append(simulate(system, waveform, 8.0, samples=201, runtime="c"))
    usual, quick = runs
    assert usual.accuracy and quick.accuracy
    for name in system.convergence_scales():
        span = max(float(np.ptp(usual[name])), system.convergence_scales()[name])
        assert np.abs(usual[name] - quick[name]).max() <= (usual.accuracy + quick.accuracy) * span


def test_the_interruption_of_a_run_does_not_reach_the_background(cache: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The process is in a session of its own, where no terminal sends signals."""
    started: list[dict[str, object]] = []
    original = subprocess.run

    def watch(command: list[str], **settings: object) -> object:
        started.append({"command": command, **settings})
        return original(command, **settings)  # type: ignore[call-overload]

    monkeypatch.setenv("MARTENSITE_QUICK_C", "first")
    monkeypatch.setattr(compile_jobs.subprocess, "run", watch)
    load_library(SOURCE, soon=True)
    (one,) = (call for call in started if call["command"][0] == "/bin/sh")  # type: ignore[index]
    assert one["start_new_session"] is True
