"""Peer for laws: the model core of SMA_REACT, along a thermal path.

What: SMA_REACT (maestrolab/SMA_REACT, BSD-3) is a calibration tool with windows; it is on no
package index. Its model core is two Python files that need NumPy, SciPy and Matplotlib only, so a
checkout runs it without the rest. It is called here through its own function and no code of it is
copied. The model is that of `martensite.physics.laws.lagoudas` with stress and temperature given;
it begins
in martensite, so that a path begins cold. Stress loops from austenite cannot be run with it.

A path runs in a process of its own with one thread. The seconds are CPU time of one whole path,
the median of some repeats after a first one, without interpreter and imports.

Checkout: `MARTENSITE_SMA_REACT` names the folder; there is no default. Tension is positive.
"""

from __future__ import annotations

import json
import os
import statistics
import sys
import time
import tomllib
from contextlib import redirect_stdout
from functools import cache
from pathlib import Path
from typing import Any

from benchmarks.peers.simcoon_path import ALLOY, ONE_THREAD, Alloy, Loop
from benchmarks.process import run_process

CORE = "src/calibration/model_funcs/Full_Model_stress.py"
SMOOTHING, TOLERANCE = 1e-5, 1e-8  # of the corners and of the fraction, as it sets them itself


def checkout() -> Path | None:
    """The folder that was named, if the model core is in it."""
    named = os.environ.get("MARTENSITE_SMA_REACT")
    folder = Path(named) if named else None
    return folder if folder and (folder / CORE).exists() else None


@cache
def version() -> str | None:
    """Of the checkout; None where there is none."""
    folder = checkout()
    if folder is None:
        return None
    project = tomllib.loads((folder / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    return str(project["version"])


def thermal_path(
    steps: int = 1000,
    alloy: Alloy = ALLOY,
    *,
    hot: float = 423.15,
    cold: float = 293.15,
    stress: float = 200e6,
    repeats: int = 5,
) -> Loop:
    """Temperature from `cold` to `hot` [K] and back at constant `stress` [Pa], from martensite.

    Raises:
        ValueError: `steps` is odd or less than 2.
    """
    if steps < 2 or steps % 2:
        raise ValueError(f"`steps` is {steps}, but must be an even number of at least 2.")
    order = {
        "folder": str(checkout()),
        "half": steps // 2,
        "alloy": alloy._asdict(),
        "hot": hot,
        "cold": cold,
        "stress": stress,
        "repeats": repeats,
    }
    command = [sys.executable, "-m", "benchmarks.peers.sma_react_path", json.dumps(order)]
    return Loop(**run_process(command, {**ONE_THREAD, "MPLBACKEND": "Agg"}).answer)


# ---------------------------------------------------------------- in the other process


def _properties(a: Alloy) -> dict[str, float]:
    """The numbers of its model, by its names, in SI."""
    corners = {f"n_{i}": a.exponent for i in (1, 2, 3, 4)}
    return corners | {
        "E_A": a.E_A,
        "E_M": a.E_M,
        "M_s": a.M_s,
        "M_f": a.M_f,
        "A_s": a.A_s,
        "A_f": a.A_f,
        "C_A": a.C_A,
        "C_M": a.C_M,
        "H_min": a.H_min,
        "H_sat": a.H_max,
        "k": a.k,
        "sig_crit": 0.0,
        "sig_cal": a.calibration,
        "alpha": 0.0,
        "delta": SMOOTHING,
        "MVF_tolerance": TOLERANCE,
    }


def _solve(order: dict[str, Any]) -> Loop:
    """Time the path and read the strain."""
    import numpy as np

    sys.path.insert(0, str(Path(order["folder"]) / "src/calibration"))
    from model_funcs.Full_Model_stress import Full_Model_stress

    away = np.linspace(order["cold"], order["hot"], order["half"] + 1)
    path = np.concatenate([away, away[-2::-1]])
    stress, numbers = np.full_like(path, order["stress"]), _properties(Alloy(**order["alloy"]))

    def once() -> tuple[float, Any]:
        begin = time.process_time()
        found = Full_Model_stress(path, stress, numbers, "N", "I")
        return time.process_time() - begin, found

    _, found = once()
    seconds = statistics.median(once()[0] for _ in range(order["repeats"]))
    return Loop(seconds, path[1:].tolist(), found[0][1:].tolist())


if __name__ == "__main__":
    with redirect_stdout(sys.stderr):  # it may print
        answer = _solve(json.loads(sys.argv[1]))
    print(json.dumps(answer._asdict()))
