"""Shared fixtures; the plain constructors live in `builders.py` and `kernels.py`."""

import os
from pathlib import Path

import pytest
from hypothesis import settings

from martensite.kernels.c99 import find_compiler

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
UNCOMPILED = ("jax", "numpy", "traced floats")


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Mark as slow what is so for its parameters; the same kernels run in C all the same."""
    compiled: set[tuple[str, type, str]] = set()
    for item in items:
        given = getattr(getattr(item, "callspec", None), "params", {})
        name, runtime = item.name.partition("[")[2], given.get("runtime")
        if runtime == "jax" and {"kind", "thing", "name"} <= given.keys():
            case = given["kind"], type(given["thing"]), given["name"]
            if case in compiled:  # JAX compiles one variant of every class and kernel
                item.add_marker(pytest.mark.slow)
            compiled.add(case)
        long = runtime in UNCOMPILED and any(words in name for words in SLOW)
        varied = VARIED in name and PLAIN not in name
        if long or (runtime == "jax" and (varied or "-kalman-" in name)):
            item.add_marker(pytest.mark.slow)


@pytest.fixture(scope="session")
def c_compiler() -> str:
    """The C compiler of this machine; tests that need one skip without."""
    found = find_compiler()
    if found is None:
        pytest.skip("no C compiler on this machine (install gcc or clang)")
    return found
