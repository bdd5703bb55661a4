"""Problem B by LSODA in C with a right-hand side in C (see `lsoda_c`), restarted at the kinks of the power.

The equations are those of `mas_ode` with barriers of the form `edge`.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from benchmarks.peers.lsoda_c import bind_solver
from benchmarks.peers.mas_ode import BOLTZMANN, LOWEST, SCALE, integrate_pieces
from benchmarks.problem_b import Wire, lumped

NUMBERS = ("sigma_L", "dsigma_dT", "T_L", "Delta_sigma", "eps_T", "T_a", "soft_A", "soft_M")
MORE = ("lam_T", "speed", "load", "K", "loss", "per_heat", "latent", "start", "power", "slope")
SOURCE = f"""
#include <math.h>
enum {{ {", ".join([*NUMBERS, *MORE])} }};
static double rate(const double *p, double up, double soft, double lam) {{
    const double over = up > 0.0 ? up : 0.0;
    return p[speed] * exp(-lam * over * over * soft / 2.0);
}}
void rates(double t, const double *y, double *dy, const double *p) {{
    const double A = 1.0 - y[0] - y[1], T = y[2] > {LOWEST} ? y[2] : {LOWEST};
    const double soft = (y[0] + y[1]) * p[soft_M] + A * p[soft_A];
    const double stress = (p[load] - p[K] * p[eps_T] * (y[0] - y[1])) / (1.0 + p[K] * soft);
    const double high = p[sigma_L] + p[dsigma_dT] * (T - p[T_L]), s_A = high > 0.0 ? high : 0.0;
    const double s_M = s_A - p[Delta_sigma], lam = p[lam_T] / T;
    dy[0] = A * rate(p, s_A - stress, p[soft_A], lam) - y[0] * rate(p, stress - s_M, p[soft_M], lam);
    dy[1] = A * rate(p, s_A + stress, p[soft_A], lam) - y[1] * rate(p, -stress - s_M, p[soft_M], lam);
    const double heat = p[power] + p[slope] * (t - p[start]) - p[loss] * (y[2] - p[T_a]);
    dy[2] = (heat + p[latent] * (dy[0] + dy[1])) * p[per_heat];
}}
"""


def list_numbers(p: Wire) -> list[float]:
    """Return the numbers of the right-hand side in the order of its names; the last three change at every kink."""
    d = lumped(p)
    named = [p.sigma_L, p.dsigma_dT, p.T_L, p.Delta_sigma, p.eps_T, p.T_a, 1 / p.E_A, 1 / p.E_M]
    load = d.sigma0 + d.K * d.eps0
    return [*named, p.layer_volume / BOLTZMANN, 1 / p.layer_time, load, d.K, p.h * d.S, 1 / (d.M * p.c), d.M * p.latent]


def trajectory(p: Wire, rtol: float) -> Callable[[], Any]:
    """Return a run of x₊, x₋, T on the output grid, (3, outputs); not numbers where the solver gave up."""
    import numpy as np

    solve, numbers = bind_solver(SOURCE, rtol, rtol * min(SCALE)), np.array([*list_numbers(p), 0.0, 0.0, 0.0])

    def solve_piece(kink: tuple[float, float, float], y: Any, times: Any) -> Any:
        numbers[-3:] = kink
        return solve(y, numbers, times)

    return integrate_pieces(solve_piece)
