"""Rate form R of problem A: the right-hand side for ODE solvers, in Python or compiled by numba.

What: the "restart" rule as an ordinary differential equation in (T, xi), branch by the sign of
the net heat Q_net = V^2/R - loss, with v the progress through the zone, 0 < v < 1:
    heating d ln xi = d ln w_A:        G = -xi (pi/W) tan(pi v/2)
    cooling d ln(1 - xi) = d ln w_M:   G = -(1 - xi) (pi/W) tan(pi v/2)
    H = dxi/dT = G (1 - sigma_T/C)/(1 + G sigma_xi/C),   dT/dt = Q_net/[M (c - latent H)]
The tangent, singular at the end of the zone, is capped at 300. After the zone the rate is zero: a
rest of 1e-5 stays untransformed (5e-7 of the range beside the uncapped rule), nothing is stiff
there, and a solver that steps over the whole zone misses the transformation. `beyond` keeps the
capped rate instead: 3e-9 beside the rule and safe with strong pulses, but stiff, eight times as
costly for explicit solvers.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

from benchmarks.inputs import Drive, level
from benchmarks.problem_a import Wire, lumped

CAP = 300.0


def make_rates(p: Wire, beyond: bool = False) -> Callable[[float, float, float], tuple[float, float]]:
    """(T, xi, V^2) -> (dT/dt, dxi/dt) for one parameter set; plain scalars, fit for numba."""
    d = lumped(p)
    h0, h1, A_s, M_s, C_A, C_M, T_a = p.h0, p.h1, p.A_s, p.M_s, p.C_A, p.C_M, p.T_a
    M, S, K, R0, eps0, kappa, Theta = d.M, d.S, d.K, d.R0, d.eps0, p.kappa, p.Theta
    W_A, W_M, c, latent, E_A, dE = p.A_f - p.A_s, p.M_s - p.M_f, p.c, p.latent, p.E_A, p.E_M - p.E_A
    eps_L, sigma0, base = p.eps_L, d.sigma0, d.sigma0 + d.K * d.eps0
    pi, tan, after = math.pi, math.tan, CAP if beyond else 0.0

    def rates(T: float, xi: float, U: float) -> tuple[float, float]:
        above = T - T_a
        E = E_A + xi * dE
        eps = (base + E * eps_L * xi - Theta * above) / (E + K)
        sigma = sigma0 + K * (eps0 - eps)
        net = U / (R0 * (1 + kappa * xi)) - (h0 + h1 * above) * S * above
        if net > 0:
            C, W, left, v = C_A, W_A, xi, (T - sigma / C_A - A_s) / W_A
        else:
            C, W, left, v = C_M, W_M, 1 - xi, (M_s - T + sigma / C_M) / W_M
        tangent = 0.0 if v <= 0 else after if v >= 1 else min(tan(0.5 * pi * v), CAP)
        G = -left * pi / W * tangent
        s_xi = -K * (dE * eps_L * xi + E * eps_L - dE * eps) / (E + K)
        H = G * (1 - K * Theta / (E + K) / C) / (1 + G * s_xi / C)
        rate = net / (M * (c - latent * H))
        return rate, H * rate

    return rates


def make_rhs(p: Wire, drive: Drive, beyond: bool = False) -> Callable[[float, Any], Any]:
    """(t, y) -> dy/dt in Python, with the input looked up at t."""
    rates = make_rates(p, beyond)
    if not drive.edges:
        cos, w = math.cos, 2 * math.pi

        def smooth(t: float, y: Any) -> tuple[float, float]:
            T, xi = y.tolist()
            V = 2.8 * (0.66 - 0.34 * cos(0.10 * w * t) - 0.20 * cos(0.023 * w * t))
            return rates(T, xi, V * V)

        return smooth

    def table(t: float, y: Any) -> tuple[float, float]:
        T, xi = y.tolist()
        return rates(T, xi, level(drive, t))

    return table


def make_compiled_rhs(p: Wire, drive: Drive, beyond: bool = False) -> Callable[[float, Any], Any]:
    """The same, compiled by numba."""
    import numba
    import numpy

    rates = numba.njit(make_rates(p, beyond))
    edges, levels = numpy.array(drive.edges or (0.0,)), numpy.array(drive.levels or (0.0,))
    is_sine, w = not drive.edges, 2 * math.pi

    @numba.njit
    def rhs(t: float, y: Any) -> Any:
        if is_sine:
            V = 2.8 * (0.66 - 0.34 * math.cos(0.10 * w * t) - 0.20 * math.cos(0.023 * w * t))
            U = V * V
        else:
            U = levels[max(numpy.searchsorted(edges, t, side="right") - 1, 0)]
        rate_T, rate_xi = rates(y[0], y[1], U)
        return numpy.array([rate_T, rate_xi])

    return rhs
