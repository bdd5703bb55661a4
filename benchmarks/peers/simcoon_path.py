"""Peer for laws: the unified transformation model SMADI of simcoon, along uniaxial paths.

What: simcoon is a C++ library with a Python interface (GPL-3); it is driven here through its
public interface and no code of it is copied. The model is the three-dimensional, rate-independent
one of Chatziathanasiou and Chemisky, of the Lagoudas family; under uniaxial stress it is compared
with one-dimensional laws. A path runs in a process of its own with one thread: left alone, the
linear algebra starts threads that double the CPU time of its 6 x 6 systems. The seconds are CPU
time of one whole path, the median of some repeats after a first one, without interpreter and
imports.

Caution: with few increments (here 100 or fewer) and smooth corners it can miss a transformation
and stay in martensite, yet report success. Look at the strain before quoting the seconds.

Interpreter: `MARTENSITE_SIMCOON_PYTHON` names one that has simcoon 2.2 or newer; else this one.
Units here are Pa and K; simcoon's are MPa and K. Tension is positive.
"""

from __future__ import annotations

import json
import os
import statistics
import subprocess
import sys
import time
from functools import cache
from typing import Any, NamedTuple

from benchmarks.process import run_process

MODEL, STATES = "SMADI", 17
ONE_THREAD = {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}
NEEDED = "from simcoon.solver import Block, StepMeca, solve"


class Alloy(NamedTuple):
    """A synthetic NiTi, chosen for this project; the fields in the order of simcoon's list.

    With equal moduli, H_min = H_max and exponents of 1 it is bilinear, and the transformation
    starts and ends on the straight lines M_s + σ/C_M, ...; otherwise the slopes hold at
    `calibration` and smooth corners begin before those lines.
    """

    E_A: float = 70e9  # [Pa]
    E_M: float = 30e9  # [Pa]
    nu_A: float = 0.33
    nu_M: float = 0.33
    alpha_A: float = 0.0  # [1/K] thermal expansion, zero at the start temperature
    alpha_M: float = 0.0  # [1/K]
    H_min: float = 0.0  # transformation strain H = H_min + (H_max - H_min) (1 - exp(-k σ))
    H_max: float = 0.05
    k: float = 0.02e-6  # [1/Pa]
    C_A: float = 7e6  # [Pa/K]
    C_M: float = 7e6  # [Pa/K]
    M_s: float = 338.15  # [K]
    M_f: float = 318.15  # [K]
    A_s: float = 343.15  # [K]
    A_f: float = 363.15  # [K]
    exponent: float = 0.5  # of all four corners of the hardening
    calibration: float = 300e6  # [Pa] stress at which C_A and C_M hold


class Loop(NamedTuple):
    """What a path took and gave, one value per increment."""

    seconds: float
    """CPU time [s] of the whole path."""
    driven: list[float]
    """Stress [Pa] of the superelastic path, temperature [K] of the thermal path."""
    strain: list[float]


ALLOY = Alloy()


@cache
def available() -> bool:
    """Whether the chosen interpreter imports a simcoon with the solver that is called here."""
    try:
        done = subprocess.run([interpreter(), "-c", NEEDED], capture_output=True, check=False)
    except OSError:
        return False
    return done.returncode == 0


def superelastic_path(
    steps: int = 1000, alloy: Alloy = ALLOY, *, temperature: float = 383.15, top: float = 900e6, repeats: int = 5
) -> Loop:
    """Stress from 0 to `top` [Pa] and back at `temperature` [K], from austenite."""
    return _run("superelastic", steps, alloy, temperature, top, repeats)


def thermal_path(
    steps: int = 1000,
    alloy: Alloy = ALLOY,
    *,
    hot: float = 423.15,
    cold: float = 293.15,
    stress: float = 200e6,
    repeats: int = 5,
) -> Loop:
    """Temperature from `hot` to `cold` [K] and back at constant `stress` [Pa], from austenite.

    One elastic increment in front, which loads the wire, is timed but not returned.
    """
    return _run("thermal", steps, alloy, hot, stress, repeats, cold)


def interpreter() -> str:
    """The interpreter that has simcoon, or is taken to have it."""
    return os.environ.get("MARTENSITE_SIMCOON_PYTHON") or sys.executable


def _run(
    name: str, steps: int, alloy: Alloy, start: float, stress: float, repeats: int, cold: float | None = None
) -> Loop:
    """Ask a process of its own for a path."""
    if steps < 2 or steps % 2:
        raise ValueError(f"`steps` is {steps}, but must be an even number of at least 2.")
    order = {
        "path": name,
        "half": steps // 2,
        "alloy": alloy._asdict(),
        "start": start,
        "stress": stress,
        "cold": cold,
        "repeats": repeats,
    }
    command = [interpreter(), "-m", "benchmarks.peers.simcoon_path", json.dumps(order)]
    return Loop(**run_process(command, ONE_THREAD).answer)


# ---------------------------------------------------------------- in the other process


def _properties(alloy: Alloy) -> list[float]:
    """The 28 numbers of the model, in MPa."""
    a = alloy
    mpa = [a.E_A / 1e6, a.E_M / 1e6]
    elastic = [a.nu_A, a.nu_M, a.alpha_A, a.alpha_M]
    strain = [a.H_min, a.H_max, a.k * 1e6, 0.0]
    slopes = [a.C_A / 1e6, a.C_M / 1e6]
    temperatures = [a.M_s, a.M_f, a.A_s, a.A_f]
    symmetric = [0.0, 2.0]  # no difference between tension and compression
    penalties = [1e-6, 1e-3, 1.0, 1e8]  # as in simcoon's own example
    corners = [a.exponent] * 4
    calibration = [a.calibration / 1e6]
    rest = [*slopes, *temperatures, *corners, *calibration, *symmetric, *penalties]
    return [0.0, *mpa, *elastic, *strain, *rest]


def _steps(order: dict[str, Any]) -> list[Any]:
    """The path as simcoon's loading steps."""
    from simcoon.solver import StepMeca

    def to(stress: float, count: int, temperature: float) -> Any:
        axial = [stress / 1e6, 0.0, 0.0, 0.0, 0.0, 0.0]
        return StepMeca(control="stress", value=axial, ninc=count, T_final=temperature)

    start, stress, half = order["start"], order["stress"], order["half"]
    if order["path"] == "superelastic":
        return [to(stress, half, start), to(0.0, half, start)]
    return [to(stress, 1, start), to(stress, half, order["cold"]), to(stress, half, start)]


def _solve(order: dict[str, Any]) -> Loop:
    """Time the path and read stress or temperature, and strain."""
    from simcoon.solver import Block, solve

    blocks, properties = [Block(steps=_steps(order))], _properties(Alloy(**order["alloy"]))

    def once() -> tuple[float, Any]:
        begin = time.process_time()
        found = solve(blocks, MODEL, properties, STATES, T_init=order["start"], record_tangent=False)
        return time.process_time() - begin, found

    _, found = once()
    seconds = statistics.median(once()[0] for _ in range(order["repeats"]))
    thermal = order["path"] == "thermal"
    driven = found["Temp"] if thermal else found["Stress"][0] * 1e6
    first = 1 if thermal else 0
    return Loop(seconds, driven[first:].tolist(), found["Strain"][0][first:].tolist())


if __name__ == "__main__":
    print(json.dumps(_solve(json.loads(sys.argv[1]))._asdict()))
