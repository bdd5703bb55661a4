"""Random strips and paths, and a law followed beside its one-page reference.

A reference is a module with `Parameters`, `State` and `advance(parameters, rule, state, σ, T)`.
"""

from typing import Any

import numpy as np

from martensite.kernels import floats
from martensite.physics.laws.base import Fractions

RULES = ("resume", "restart")
CASES = {"usual": 0, "equal slopes": 1, "overlapping strips": 2, "A_s below M_s": 3}
TOP = 600e6
MODULI = {"E_A": 75e9, "E_M": 28e9, "eps_L": 0.04, "Theta": 0.055e6}


def random_parameters(rng, kind) -> dict[str, Any]:
    """Temperatures at zero stress, and slopes; `kind` chooses how the strips lie."""
    M_f = rng.uniform(280, 300)
    M_s = M_f + rng.uniform(2, 25)
    A_s = rng.uniform(M_f - 5, M_s) if kind == 3 else M_s + rng.uniform(0, 20)
    A_f = A_s + rng.uniform(2, 25)
    C_M = rng.uniform(3e6, 12e6)
    C_A = {0: C_M * rng.uniform(0.5, 1.0), 1: C_M}.get(kind, C_M * rng.uniform(1.0, 3.0))
    return {"A_s": A_s, "A_f": A_f, "M_s": M_s, "M_f": M_f, "C_A": C_A, "C_M": C_M}


def random_path(rng, p, points=9):
    """(σ, T) points; legs at constant σ, T, u or w, and points exactly on strip lines, included."""
    lines = [(p[n], p["C_M"]) for n in ("M_s", "M_f")] + [(p[n], p["C_A"]) for n in ("A_s", "A_f")]
    path = []
    for _ in range(points):
        sigma = float(rng.uniform(0, TOP) * (rng.random() > 0.2))
        T = float(rng.uniform(p["M_f"] - 20, p["A_f"] + sigma / p["C_M"] + 20))
        kind = rng.integers(10)
        if path and kind == 0:
            sigma = path[-1][0]
        if path and kind == 1:
            T = path[-1][1]
        if path and kind in (2, 3):
            C = p["C_M"] if kind == 2 else p["C_A"]
            T = path[-1][1] + (sigma - path[-1][0]) / C
        if kind == 4:
            line, C = lines[rng.integers(4)]
            T = line + sigma / C
        path.append((sigma, T))
    return path


def random_case(seed, kind) -> tuple[dict[str, Any], list[tuple[float, float]], float]:
    """Strip numbers, a path and a start fraction."""
    rng = np.random.default_rng(seed)
    p = random_parameters(rng, kind)
    xi = float(rng.choice([0.0, 1.0, rng.random()]))
    return p, random_path(rng, p), xi


def followed(reference, law, numbers, rule, path, xi):
    """ξ after every leg by the reference and by a law, and the branch in progress there."""
    p = reference.Parameters(**numbers)
    sigma, T = path[0]
    state, memory = reference.State(xi, T, sigma), law.init(floats, Fractions(xi, xi), sigma, T)
    wanted, found, branches = [], [], []
    for sigma, T in path[1:]:
        state = reference.advance(p, rule, state, sigma, T)
        memory, fractions = law.kinetics(floats, memory, sigma, T, 0.0)
        wanted.append(state.xi)
        found.append(fractions.martensite)
        branches.append(state.branch)
    return wanted, found, branches


def worst(reference, cls, kind, rule, count, change=None):
    """Largest difference over `count` random paths; `change` perturbs the law's parameters."""
    found = 0.0
    for seed in range(count):
        numbers, path, xi = random_case(seed, kind)
        law = cls(**(MODULI | numbers | (change(numbers) if change else {})), history=rule)
        wanted, got, _ = followed(reference, law, numbers, rule, path, xi)
        found = max(found, *(abs(a - b) for a, b in zip(wanted, got, strict=True)))
    return found
