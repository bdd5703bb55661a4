"""Shared fixtures; the plain constructors live in `builders.py` and `kernels.py`."""

import os
from pathlib import Path

import pytest
from hypothesis import settings

from martensite.runtimes.c99 import compiler

# measured data may lie in a folder `shared/data` beside the checkout; else such tests skip
BESIDE = Path(__file__).resolve().parents[2] / "shared" / "data"
if "MARTENSITE_DATA" not in os.environ and BESIDE.is_dir():
    os.environ["MARTENSITE_DATA"] = str(BESIDE)

settings.register_profile("reproducible", deadline=None, derandomize=True, database=None)
settings.load_profile("reproducible")


SLOW = ("axial-wire-5-step", "ribbon-2-step", "hand-")
"""Cases of many elements whose kernels take long to trace, or to compile for JAX."""
VARIED, PLAIN = "coil-spring-", "coil-spring-mean-small-none-none"
"""An element of many forms, of which JAX compiles one; its compiler takes long over each.

So it does over Kalman filters, of which it compiles none.
"""
UNCOMPILED = ("jax-", "numpy-", "traced floats-")


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Mark as slow what is so for its parameters; the same kernels run in C all the same."""
    for item in items:
        case = item.name.partition("[")[2]
        long = case.startswith(UNCOMPILED) and any(words in case for words in SLOW)
        varied = VARIED in case and PLAIN not in case
        if long or (case.startswith("jax-") and (varied or "-kalman-" in case)):
            item.add_marker(pytest.mark.slow)


@pytest.fixture(scope="session")
def c_compiler() -> str:
    """The C compiler of this machine; tests that need one skip without."""
    found = compiler()
    if found is None:
        pytest.skip("no C compiler on this machine (install gcc or clang)")
    return found
