"""Fine-step solutions that every error is measured against, kept on disk.

What: rule P by the hand-written return map (steps of 0.1 ms on the edges of the input, about
1e-10 of the range), rule R by LSODA at rtol 1e-11. Both are independent of the library.
They are stored in `.cache/benchmarks` under a hash of the problem and of the code that made them.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.inputs import Drive, aligned
from benchmarks.objective import differences
from benchmarks.peers import ode, rate_form, return_map
from benchmarks.problem_a import Wire, one_set, scaled

ROOT = Path(__file__).resolve().parent
STORE = ROOT.parent / ".cache" / "benchmarks"
MADE_BY = ("problem_a", "inputs", "objective", "references", "peers/return_map", "peers/ode")


def kept(key: Any, compute: Callable[[], Any]) -> Any:
    """The array for that key, computed once per version of the code."""
    code = b"".join((ROOT / f"{name}.py").read_bytes() for name in MADE_BY)
    code += Path(rate_form.__file__).read_bytes()
    path = STORE / (hashlib.sha256(code + repr(key).encode()).hexdigest()[:24] + ".npy")
    if not path.exists():
        STORE.mkdir(parents=True, exist_ok=True)
        np.save(path, np.asarray(compute(), dtype=float))
    return np.load(path)


def reference(rule: str, p: Wire, drive: Drive, dt: float = 1e-4) -> Any:
    """x [mm] on the output grid by rule "P" or "R"."""

    def compute() -> Any:
        if rule == "P":
            return return_map.single(p, drive, dt)()
        return ode.record(ode.by_odeint, p, drive, ode.TIGHT)

    return kept((rule, p, drive, dt), compute)


def batch_reference(rule: str, sets: Wire, drive: Drive, count: int) -> list[Any]:
    """x [mm] of the first `count` sets (rule P with steps of 1 ms, about 1e-8)."""
    return [reference(rule, one_set(sets, i), drive, 1e-3) for i in range(count)]


def gradient_reference(rule: str, p: Wire, drive: Drive) -> Any:
    """dJ/dq by central differences of the return map with steps of 1 ms (1e-5 of the rule R)."""
    rows = aligned(drive, 1e-3)

    def simulate(q: list[float]) -> list[float]:
        return return_map.displacements(scaled(p, q), rows, restart=rule == "R")

    return kept(("gradient", rule, p, drive), lambda: differences(simulate)())
