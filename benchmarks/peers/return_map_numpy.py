"""Return map of problem A on numpy arrays, one lane per parameter set, without branches.

What: the map of `return_map`, with both sides of every choice computed and the strictly bracketed
Newton loop run a fixed number of times N:
    hi = x where g > 0, lo = x elsewhere;  xn = x - g/g'
    x = xn where lo < xn < hi or |xn - x| <= tol, else (lo + hi)/2
The starting bracket reaches beyond 0 and 1, so that a complete transformation is hit exactly.
Written for batches: what one gets from numpy alone.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from benchmarks.engines import Engine
from benchmarks.inputs import Drive, aligned
from benchmarks.problem_a import Lumped, Wire, displacement, lumped

TOLERANCE = 1e-14


class State(NamedTuple):
    """T [degC], xi and the two memories, one lane per set."""

    T: Any
    xi: Any
    m: Any
    a: Any


class Side(NamedTuple):
    """The surface that is violated: +1 and the heating zone, or -1 and the cooling zone."""

    s: Any
    z: Any
    C: Any
    T0: Any
    W: Any


def start(p: Wire) -> State:
    """Cold, fully martensitic wires."""
    one = np.ones_like(p.h0)
    return State(p.T_a * one, one, one, 0 * one)


def mechanics(p: Wire, d: Lumped, T: Any, xi: Any) -> tuple[Any, Any, Any]:
    """Stress [Pa] and its derivatives by xi [Pa] and by T [Pa/K]."""
    dE = p.E_M - p.E_A
    E = p.E_A + xi * dE
    soft = 1 / (E + d.K)
    eps = (d.sigma0 + d.K * d.eps0 + E * p.eps_L * xi - p.Theta * (T - p.T_a)) * soft
    by_xi = -d.K * (dE * p.eps_L * xi + E * p.eps_L - dE * eps) * soft
    return d.sigma0 + d.K * (d.eps0 - eps), by_xi, d.K * p.Theta * soft


def weight(s: Any, u: Any) -> Any:
    """Fraction w that is left to transform at the position u of a zone."""
    return 0.5 + 0.5 * s * np.cos(np.pi * np.clip(u, 0, 1))


def advance(p: Wire, d: Lumped, state: State, U: float, dt: float, count: int) -> State:
    """One step of all lanes with V^2 = U [V^2] over dt [s], `count` Newton steps."""
    T, xi, m, a = state
    above = T - p.T_a
    loss = (p.h0 + p.h1 * above) * d.S * above
    D = 1 / (d.M * p.c + 0.5 * dt * (p.h0 + 2 * p.h1 * above) * d.S)
    latent = d.M * p.latent

    def heat(x: Any) -> tuple[Any, Any]:
        R = d.R0 * (1 + p.kappa * 0.5 * (xi + x))
        slope = D * (latent - dt * U * 0.5 * p.kappa * d.R0 / R**2)
        return T + D * (dt * (U / R - loss) + latent * (x - xi)), slope

    trial = heat(xi)[0]
    sigma = mechanics(p, d, trial, xi)[0]
    u_A = (trial - sigma / p.C_A - p.A_s) / (p.A_f - p.A_s)
    u_M = (trial - sigma / p.C_M - p.M_f) / (p.M_s - p.M_f)
    heats = (u_A > 0) & (xi > m * weight(1, u_A))
    cools = ~heats & (u_M < 1) & (1 - xi > a * weight(-1, u_M))
    if not (heats | cools).any():
        return state._replace(T=trial)
    side = Side(
        s=np.where(heats, 1.0, -1.0),
        z=np.where(heats, m, a),
        C=np.where(heats, p.C_A, p.C_M),
        T0=np.where(heats, p.A_s, p.M_f),
        W=np.where(heats, p.A_f - p.A_s, p.M_s - p.M_f),
    )
    x = np.where(heats | cools, solve(p, d, xi, side, heat, count), xi)
    return State(heat(x)[0], x, np.where(cools, x, m), np.where(heats, 1 - x, a))


def solve(p: Wire, d: Lumped, xi: Any, side: Side, heat: Any, count: int) -> Any:
    """The fraction on the violated surface."""
    s, z, C, T0, W = side
    lo, hi, x = np.where(s > 0, -1.0, xi), np.where(s > 0, xi, 2.0), xi
    for _ in range(count):
        T, by_x = heat(x)
        sigma, by_xi, by_T = mechanics(p, d, T, x)
        u = np.clip((T - sigma / C - T0) / W, 0, 1)
        g = s * (np.where(s > 0, x, 1 - x) - z * weight(s, u))
        slope = z * np.pi / (2 * W) * np.sin(np.pi * u) * (by_x - (by_xi + by_T * by_x) / C)
        lo, hi = np.where(g > 0, lo, x), np.where(g > 0, x, hi)
        new = x - g / (1 + slope)
        good = ((lo < new) & (new < hi)) | (np.abs(new - x) <= TOLERANCE)
        x = np.where(good, new, 0.5 * (lo + hi))
    return x


def batch(sets: Wire, drive: Drive, setting: tuple[float, int]) -> Callable[[], Any]:
    """All sets at once; setting = (longest step [s], Newton steps)."""
    rows, d = aligned(drive, setting[0]), lumped(sets)

    def run() -> Any:
        state = start(sets)
        x = [displacement(sets, d, state.T, state.xi)]
        for row in rows:
            for U, dt in row:
                state = advance(sets, d, state, U, dt, setting[1])
            x.append(displacement(sets, d, state.T, state.xi))
        return np.stack(x, axis=1)

    return run


STEPS = {f"dt {dt:g} ms, N {N}": (dt * 1e-3, N) for dt, N in ((50, 8), (20, 4), (10, 3))}

ENGINES = (Engine(name="numpy", rule="P", settings=STEPS, usual="dt 10 ms, N 3", batch=batch, batch_limit=1024),)
