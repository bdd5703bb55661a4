"""LSODA in C with a right-hand side in C, on the rate form R of problem A: the solver of an expert.

What: numbalsoda calls a C++ port of LSODA with the address of a compiled function. The same library is called here by
ctypes, with `rate_form` as C, so that neither numba nor Python runs inside a solve. Like the other solvers, it is
restarted at every edge of a table; it has no largest step.
"""

from __future__ import annotations

import ctypes
import importlib.util
from collections.abc import Callable
from pathlib import Path
from typing import Any

from benchmarks.engines import Engine
from benchmarks.inputs import Drive
from benchmarks.peers.ode import Setting, spans
from benchmarks.peers.rate_form import CAP
from benchmarks.problem_a import Wire, displacement, lumped, one_set
from martensite.kernels.compiler import load_library

TOLERANCES = {f"rtol 1e-{k}": Setting(10.0**-k) for k in range(3, 11)}
MOST_STEPS = 100_000_000
NAMES = ("h0", "h1", "A_s", "M_s", "C_A", "C_M", "T_a", "kappa", "Theta", "c", "latent", "E_A", "eps_L")
MORE = ("W_A", "W_M", "dE", "M", "S", "K", "R0", "eps0", "sigma0", "level")
SOURCE = f"""
#include <math.h>
enum {{ {", ".join([*NAMES, *MORE])} }};
void rates(double t, const double *y, double *dy, const double *p) {{
    const double pi = 3.14159265358979323846, T = y[0], xi = y[1], above = T - p[T_a];
    double U = p[level];
    if (U < 0.0) {{
        const double V = 2.8 * (0.66 - 0.34 * cos(0.2 * pi * t) - 0.20 * cos(0.046 * pi * t));
        U = V * V;
    }}
    const double E = p[E_A] + xi * p[dE], per = 1.0 / (E + p[K]);
    const double eps = (p[sigma0] + p[K] * p[eps0] + E * p[eps_L] * xi - p[Theta] * above) * per;
    const double sigma = p[sigma0] + p[K] * (p[eps0] - eps);
    const double net = U / (p[R0] * (1.0 + p[kappa] * xi)) - (p[h0] + p[h1] * above) * p[S] * above;
    const int heats = net > 0.0;
    const double C = heats ? p[C_A] : p[C_M], W = heats ? p[W_A] : p[W_M], left = heats ? xi : 1.0 - xi;
    const double v = (heats ? T - sigma / C - p[A_s] : p[M_s] - T + sigma / C) / W;
    const double tangent = v <= 0.0 || v >= 1.0 ? 0.0 : fmin(tan(0.5 * pi * v), {CAP});
    const double G = -left * pi / W * tangent;
    const double s_xi = -p[K] * (p[dE] * p[eps_L] * xi + E * p[eps_L] - p[dE] * eps) * per;
    const double H = G * (1.0 - p[K] * p[Theta] * per / C) / (1.0 + G * s_xi / C);
    dy[0] = net / (p[M] * (p[c] - p[latent] * H));
    dy[1] = H * dy[0];
}}
"""


def _find_solver() -> Any:
    """Return `lsoda_wrapper` of numbalsoda, without an import of numba."""
    spec = importlib.util.find_spec("numbalsoda")
    folder = Path(next(iter(spec.submodule_search_locations or ()))) if spec else Path()
    solver = ctypes.CDLL(str(next(folder.glob("liblsoda.*")))).lsoda_wrapper
    pointer, number = ctypes.c_void_p, ctypes.c_double
    solver.argtypes = [pointer, ctypes.c_int, *[pointer] * 2, ctypes.c_int, *[pointer] * 2, number, number]
    solver.argtypes += [ctypes.c_int, pointer]
    solver.restype = None
    return solver


def list_numbers(p: Wire) -> list[float]:
    """Return the numbers of the right-hand side in the order of its names; the level is negative for the sine."""
    d = lumped(p)
    more = (p.A_f - p.A_s, p.M_s - p.M_f, p.E_M - p.E_A, d.M, d.S, d.K, d.R0, d.eps0, d.sigma0, -1.0)
    return [*(float(getattr(p, name)) for name in NAMES), *more]


def bind_solver(source: str, rtol: float, atol: float) -> Callable[[Any, Any, Any], Any]:
    """Return a function of first state, numbers and times: states at the times, or None where LSODA gave up.

    Args:
        source: C of `rates(time, state, slope of the state, numbers)`.
        rtol: relative tolerance.
        atol: absolute tolerance of every state.
    """
    import numpy as np

    solver, rates = _find_solver(), ctypes.cast(load_library(source).rates, ctypes.c_void_p)
    worked = ctypes.c_int(0)
    end = (rtol, atol, MOST_STEPS, ctypes.addressof(worked))

    def solve(y: Any, numbers: Any, times: Any) -> Any:
        states = np.empty((len(times), len(y)))
        pointers = (y.ctypes.data, numbers.ctypes.data, len(times), times.ctypes.data, states.ctypes.data)
        solver(rates, len(y), *pointers, *end)
        return states if worked.value == 1 else None

    return solve


def single(p: Wire, drive: Drive, s: Setting) -> Callable[[], Any]:
    """Return one run, displacement [mm] included."""
    import numpy as np

    solve, d, numbers = bind_solver(SOURCE, s.rtol, s.rtol), lumped(p), np.array(list_numbers(p))
    parts = list(spans(drive, s, np.arange(round(drive.duration * 10) + 1) / 10))
    levels = drive.levels or (-1.0,)

    def go() -> Any:
        y, rows = np.array([p.T_a, 1.0]), []
        for (times, on_grid), level in zip(parts, levels, strict=True):
            numbers[-1] = level
            states = solve(y, numbers, times)
            if states is None:
                return np.full(round(drive.duration * 10) + 1, np.nan)
            y = states[-1].copy()
            rows.append(states[:-1][on_grid[:-1]])
        return displacement(p, d, *np.concatenate([*rows, y[None]]).T)

    return go


def batch(sets: Wire, drive: Drive, s: Setting) -> Callable[[], list[Any]]:
    """Return the runs of all sets, one after another."""
    runs = [single(one_set(sets, i), drive, s) for i in range(len(sets.h0))]
    return lambda: [run() for run in runs]


ENGINES = (Engine("lsoda-c", "R", TOLERANCES, "rtol 1e-6", single=single, batch=batch, optional="numbalsoda"),)
