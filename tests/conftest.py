"""Shared fixtures; the plain constructors live in `builders.py` and `kernels.py`."""

import functools
import gc
import os
import signal
from pathlib import Path

import pytest
import typer.testing
from hypothesis import settings

from martensite.kernels.compiler import find_compiler

# measured data may lie in a folder `shared/data` beside the checkout; else such tests skip
BESIDE = Path(__file__).resolve().parents[2] / "shared" / "data"
if "MARTENSITE_DATA" not in os.environ and BESIDE.is_dir():
    os.environ["MARTENSITE_DATA"] = str(BESIDE)

# a shell lets what it starts in the background ignore Ctrl-C, and so all that is started from there
if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    signal.signal(signal.SIGINT, signal.default_int_handler)

# traced graphs are full of cycles: looked for as often as usual, they take an eighth of the time
gc.set_threshold(20_000, 20, 25)

# the tree of commands is always the same, and building it takes longer than most calls of one
typer.testing._get_command = functools.cache(typer.testing._get_command)

settings.register_profile("reproducible", deadline=None, derandomize=True, database=None)
settings.load_profile("reproducible")


@pytest.fixture(scope="session")
def c_compiler() -> str:
    """The C compiler of this machine; tests that need one skip without."""
    found = find_compiler()
    if found is None:
        pytest.skip("no C compiler on this machine (install gcc or clang)")
    return found


def pytest_collection_finish() -> None:
    """What was collected stays until the end: it need not be looked through for garbage."""
    gc.collect()
    gc.freeze()
