"""Experiments in hostile surroundings: folders with modules of known names, and a cache that others may write.

Source of truth: a trace that hostile code leaves where it runs, and the same command in clean surroundings.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

from fault_trials import Outcome, Verdict, judge_command, judge_differences

NOBODY = 65534
TRACE = "trace"
MODULES = (
    *("numpy", "scipy", "h5py", "h5netcdf", "multiprocessing", "json", "random", "signal", "struct", "socket", "types"),
    *("typing", "tempfile", "threading", "pickle", "queue", "selectors", "subprocess", "ziglang", "martensite", "zlib"),
)
READING = (
    "data show log.mat",
    "data show log.nc",
    "identify log.mat --input duty --output position --stage oe(1,1,1) --starts 1",
    "sweep wire.toml --over diameter=0.1..0.2mm:2 --out out.zarr --runtime floats --backend processes --workers 2",
    "run wire.toml --no-figure --out out.nc",
)
"""Commands of which all but the last start further processes of Python."""
PLANTED = """#include <stdio.h>
__attribute__((constructor)) static void speak(void) {{ FILE *f = fopen("{trace}", "w"); if (f) fclose(f); }}
"""


def run_safely(command: str, **environment: str) -> tuple[int, str, str]:
    """A command by its console script; `python -P` would hand its caution on to all processes that it starts."""
    words = [str(Path(sys.executable).with_name("martensite")), *command.split()]
    done = subprocess.run(words, capture_output=True, text=True, check=False, env=os.environ | environment, timeout=240)
    return done.returncode, done.stdout, done.stderr


def judge_trace(done: tuple[int, str, str], trace: Path) -> Verdict:
    """Hostile code that ran is a loss, whatever the command answers."""
    return (Outcome.LOSS, f"hostile code ran: {done[2][-500:]}") if trace.exists() else judge_command(*done)


def run_in_hostile_folder(seed: int, folder: Path, write_inputs: Callable[[], None]) -> Verdict:
    """A command in a folder with a module of every known name."""
    write_inputs()
    trace = folder.parent / TRACE
    trace.unlink(missing_ok=True)
    for name in MODULES:
        Path(f"{name}.py").write_text(f"with open({str(trace)!r}, 'w') as file:\n    file.write({name!r})\n")
    command = READING[seed % len(READING)]
    outcome, words = judge_trace(run_safely(command), trace)
    return outcome, f"{command}: {words}"


def own_library(path: Path) -> None:
    os.chown(path, NOBODY, NOBODY)


def own_folder(path: Path) -> None:
    os.chown(path.parent, NOBODY, NOBODY)


def open_library(path: Path) -> None:
    path.chmod(0o666)


def open_folder(path: Path) -> None:
    path.parent.chmod(0o777)


WAYS = (open_folder, open_library, own_folder, own_library)
"""How others get at a library; to give files away takes root."""


def run_with_foreign_cache(seed: int, write_inputs: Callable[[], None]) -> Verdict:
    """A command whose compiled programs others have replaced by their own, with the right digests."""
    from martensite.kernels import compiler

    write_inputs()
    share = WAYS[seed % len(WAYS if os.geteuid() == 0 else WAYS[:2])]
    cache, trace, command = Path("cache").absolute(), Path(TRACE).absolute(), "run wire.toml --runtime c --no-figure"
    shutil.rmtree(cache, ignore_errors=True)
    clean = run_safely(f"{command} --out clean.nc", XDG_CACHE_HOME=str(cache), MARTENSITE_CFLAGS="-O0")
    if clean[0]:
        return judge_command(*clean)
    for path in sorted((cache / "martensite/c").glob("*.so")):
        compiler._compile_source(compiler._build_command(()), PLANTED.format(trace=trace), path)
        share(path)
    done = run_safely(f"{command} --out out.nc", XDG_CACHE_HOME=str(cache), MARTENSITE_CFLAGS="-O0")
    outcome, words = judge_trace(done, trace)
    if outcome is Outcome.ANSWERED:
        outcome, words = judge_differences(read_numbers("out.nc"), read_numbers("clean.nc"))
    return outcome, f"{share.__name__}: {words}"


def read_numbers(name: str) -> dict[str, bytes]:
    """Numbers of a saved result, by name."""
    from martensite.scenario.netcdf import read_labelled

    variables = read_labelled(name).variables
    return {key: one.values.tobytes() for key, one in variables.items() if one.values.dtype.kind == "f"}
