"""Every process of Python that product code starts is started by `base.child_python`.

Source of truth: the text of all shipped modules. `tests/faults/test_hostile_folder.py` shows that such a process
imports nothing from the current folder.
"""

from __future__ import annotations

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
OWN = ROOT / "src/martensite/base/child_python.py"
ROOTS = [ROOT / "src", *(one.parent / "src" for one in ROOT.glob("[a-z]*/pyproject.toml"))]
INTERPRETER = re.compile(r"\bsys\.(_base_)?executable\b|from sys import .*executable")
LIBRARY = re.compile(
    r"\bProcessPoolExecutor\(|\bLocalCluster\(|\bmultiprocessing\.(Process|Pool|get_context)\b"
    r"|from multiprocessing import .*\b(Process|Pool|get_context)\b"
)
"""Starts of processes whose command a library writes."""


def find_unsafe(text: str) -> str:
    """The first start of Python past the helper; empty without."""
    found = INTERPRETER.search(text) or ("safe_children()" not in text and LIBRARY.search(text))
    return found[0] if found else ""


def test_python_is_started_by_the_helper_alone() -> None:
    paths = [path for root in ROOTS for path in root.rglob("*.py") if path != OWN]
    assert len(paths) > 500
    found = {str(path.relative_to(ROOT)): find_unsafe(path.read_text(encoding="utf-8")) for path in paths}
    assert {path: start for path, start in found.items() if start} == {}


@pytest.mark.parametrize(
    "text",
    [
        "import sys, subprocess\nsubprocess.run([sys.executable, '-m', 'json'])",
        "from sys import executable",
        "from concurrent.futures import ProcessPoolExecutor\nProcessPoolExecutor(2)",
        "import multiprocessing\nmultiprocessing.Process(target=print)",
        "from multiprocessing import Pool",
    ],
)
def test_an_unsafe_start_is_noticed(text: str) -> None:
    assert find_unsafe(text)
