"""Shared fixtures; the plain constructors live in `builders.py` and `kernels.py`."""

import functools
import gc
import os
import signal
import sys
import time
from collections.abc import Generator
from pathlib import Path

import pytest
import typer.main
import typer.testing
from hypothesis import settings
from hypothesis.internal.conjecture import providers

from martensite.kernels.compiler import find_compiler
from martensite.logs import binary_files, container_files
from martensite.scenario import netcdf

# measured data may lie in a folder `shared/data` beside the checkout; else such tests skip
HERE = Path(__file__).resolve().parent
BESIDE = HERE.parents[1] / "shared" / "data"
if "MARTENSITE_DATA" not in os.environ and BESIDE.is_dir():
    os.environ["MARTENSITE_DATA"] = str(BESIDE)

# tests start no compiler in the background
os.environ.setdefault("MARTENSITE_QUICK_C", "off")

# a shell lets what it starts in the background ignore Ctrl-C, and so all that is started from there
if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    signal.signal(signal.SIGINT, signal.default_int_handler)

# where bytecode is forbidden, every process that a test starts compiles all that it imports, for seconds
sys.dont_write_bytecode = False
os.environ.pop("PYTHONDONTWRITEBYTECODE", None)

# traced graphs are full of cycles: looked for as often as usual, they take an eighth of the time
gc.set_threshold(20_000, 20, 25)

# the tree of commands is always the same, and building it takes longer than most calls of one
PATCH = pytest.MonkeyPatch()
PATCH.setattr(typer.testing, "_get_command", functools.cache(typer.main.get_command))

# a process of its own for every binary file takes half a second, of which most tests want nothing
READERS = (binary_files, container_files, netcdf)
READ_APART = binary_files.read_apart
for module in READERS:
    PATCH.setattr(module, "read_apart", lambda path, reader, size: binary_files._read_columns(reader, path))

# Hypothesis draws from the constants of all imported files. It parses them for seconds, and the drawn inputs would
# depend on the imports of earlier tests.
PATCH.setattr(providers, "_get_local_constants", lambda: providers._local_constants)

settings.register_profile("reproducible", deadline=None, derandomize=True, database=None, max_examples=50)
settings.load_profile("reproducible")


@pytest.fixture
def apart(monkeypatch: pytest.MonkeyPatch) -> None:
    """Read binary files in a process of their own, as users do."""
    for module in READERS:
        monkeypatch.setattr(module, "read_apart", READ_APART)


@pytest.fixture(scope="session")
def c_compiler() -> str:
    """The C compiler of this machine; tests that need one skip without."""
    found = find_compiler()
    if found is None:
        pytest.skip("no C compiler on this machine (install gcc or clang)")
    return found


@pytest.hookimpl(optionalhook=True, wrapper=True)
def pytest_xdist_auto_num_workers() -> Generator[None, int, int]:
    """One worker more than there are cores: some tests wait, for a browser, a board or a process."""
    return 1 + (yield)


@pytest.hookimpl(tryfirst=True)
def pytest_collection(session: pytest.Session) -> None:
    """In a fresh checkout one worker compiles what all import, and the others wait; each would compile it anew."""
    config, last = session.config, max(HERE.glob("*/test_*.py"))
    first = getattr(config, "workerinput", {}).get("workerid", "gw0") == "gw0"
    patience = time.monotonic() + 120.0
    if first or sys.dont_write_bytecode or config.args != config.getini("testpaths"):
        return
    while not any(last.parent.glob(f"__pycache__/{last.stem}.*")) and time.monotonic() < patience:
        time.sleep(0.2)


def pytest_collection_finish() -> None:
    """What was collected stays until the end: it need not be looked through for garbage."""
    gc.collect()
    gc.freeze()
