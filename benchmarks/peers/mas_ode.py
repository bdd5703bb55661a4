"""Problem B as a stiff ODE: LSODA and Radau of SciPy, right-hand side in plain Python.

What: the equations of `problem_b` with the barrier as `edge` (the problem as posed) or as `barrier`
(height of the saddle, the form of the hybrid law). The solvers look for no kinks of the input and
are restarted at each. Exponents are limited: stages of a step visit absurd temperatures, where
`math.exp` would raise. Written from the equations; shares no code with the library.
"""

from __future__ import annotations

import importlib.util
from collections.abc import Callable
from itertools import pairwise
from math import exp
from typing import Any

from benchmarks.problem_b import DURATION, OUTPUT_INTERVAL, POWER, Wire, lumped

BOLTZMANN = 1.380649e-23  # [J/K]
START = (1.0, 0.0, 293.0)  # x₊, x₋, T [K]
SCALE = (0.1, 0.1, 10.0)  # atol/rtol of the three
LOWEST = 1.0  # [K]

Rate = Callable[[float, float, float, float], tuple[float, float]]
Rhs = Callable[[float, Any], tuple[float, float, float]]


def make_barriers(p: Wire, form: str) -> Rate:
    """(stress, σ_A, σ_M, λ) -> exponents of A -> M+ and M+ -> A."""
    E_A, E_M, eps_T, width = p.E_A, p.E_M, p.eps_T, p.Delta_sigma

    def edge(stress: float, s_A: float, s_M: float, lam: float) -> tuple[float, float]:
        up, down = max(s_A - stress, 0.0), max(stress - s_M, 0.0)
        return -lam * up * up / (2 * E_A), -lam * down * down / (2 * E_M)

    def saddle(stress: float, s_A: float, s_M: float, lam: float) -> tuple[float, float]:
        up, down = s_A - stress, stress - s_M
        gap = eps_T + s_M / E_M - s_A / E_A
        if up > 0 and down > 0:
            soft = gap / width
            return -lam * up * up * (1 / E_A + soft) / 2, -lam * down * down * (1 / E_M + soft) / 2
        over = (stress - (s_A + s_M) / 2) * gap
        if up <= 0:
            return 0.0, -lam * (down * down / (2 * E_M) + over)
        beyond = (stress + s_A) ** 2 / (2 * E_A) if stress < -s_A else 0.0
        return -lam * (up * up / (2 * E_A) - over - beyond), 0.0

    return edge if form == "edge" else saddle


def make_rhs(p: Wire, form: str) -> Callable[[float, float, float], Rhs]:
    """(time, power, slope of the power) at a kink -> right-hand side behind it."""
    d, barriers = lumped(p), make_barriers(p, form)
    per_heat, loss, latent = 1 / (d.M * p.c), p.h * d.S, d.M * p.latent
    lam_T, speed, load = p.layer_volume / BOLTZMANN, 1 / p.layer_time, d.sigma0 + d.K * d.eps0
    eps_T, sigma_L, slope_T, T_L = p.eps_T, p.sigma_L, p.dsigma_dT, p.T_L
    K, soft_A, soft_M, width, T_a = d.K, 1 / p.E_A, 1 / p.E_M, p.Delta_sigma, p.T_a

    def rates(stress: float, s_A: float, lam: float) -> tuple[float, float]:
        up, down = barriers(stress, s_A, s_A - width, lam)
        return speed * exp(min(up, 700.0)), speed * exp(min(down, 700.0))

    def behind(begin: float, power: float, slope: float) -> Rhs:
        def f(t: float, y: Any) -> tuple[float, float, float]:
            plus, minus, T = y.tolist()
            A, known = 1 - plus - minus, max(T, LOWEST)
            soft = (plus + minus) * soft_M + A * soft_A
            stress = (load - K * eps_T * (plus - minus)) / (1 + K * soft)
            s_A, lam = max(sigma_L + slope_T * (known - T_L), 0.0), lam_T / known
            p_A, p_M = rates(stress, s_A, lam)
            m_A, m_M = rates(-stress, s_A, lam)
            x1, x2 = A * p_A - plus * p_M, A * m_A - minus * m_M
            heat = power + slope * (t - begin) - loss * (T - T_a) + latent * (x1 + x2)
            return x1, x2, heat * per_heat

        return f

    return behind


def output_times() -> Any:
    """The output grid [s]."""
    import numpy

    return numpy.linspace(0.0, DURATION, round(DURATION / OUTPUT_INTERVAL) + 1)


def by_odeint(f: Rhs, y: Any, times: Any, rtol: float) -> Any:
    """States at `times` by LSODA through `scipy.integrate.odeint`."""
    from scipy.integrate import odeint

    atol = [rtol * s for s in SCALE]
    return odeint(f, y, times, rtol=rtol, atol=atol, mxstep=1_000_000, tfirst=True)


def by_radau(f: Rhs, y: Any, times: Any, rtol: float) -> Any:
    """States at `times` by Radau IIA of fifth order."""
    from scipy.integrate import solve_ivp

    atol = [rtol * s for s in SCALE]
    span = times[0], times[-1]
    return solve_ivp(f, span, y, "Radau", t_eval=times, rtol=rtol, atol=atol).y.T


def by_cvode(f: Rhs, y: Any, times: Any, rtol: float) -> Any:
    """States at `times` by SUNDIALS CVODE (BDF)."""
    import numpy
    from sksundae.cvode import CVODE

    def fill(t: float, y: Any, yp: Any) -> None:
        yp[:] = f(t, y)

    atol = numpy.array([rtol * s for s in SCALE])
    solver = CVODE(fill, rtol=rtol, atol=atol, method="BDF", max_num_steps=1_000_000)
    found = solver.solve(numpy.asarray(times), numpy.asarray(y)).y
    return found if len(times) > 2 else found[[0, -1]]  # two times ask CVODE for its own steps


def integrate_pieces(solve: Callable[[tuple[float, float, float], Any, Any], Any]) -> Callable[[], Any]:
    """Return a run of x₊, x₋, T on the output grid, (3, outputs); not numbers where the solver gave up.

    Args:
        solve: function of (time, power, slope of the power) at a kink, first state and times; it returns the states at
            the times, or fewer or None where it gives up.
    """
    import numpy

    grid = output_times()
    pieces = [
        (numpy.concatenate(([a], grid[(grid > a + 1e-9) & (grid < b - 1e-9)], [b])), (a, P, (Q - P) / (b - a)))
        for (a, P), (b, Q) in pairwise(zip(*POWER, strict=True))
    ]

    def run() -> Any:
        y, rows = numpy.array(START), []
        for times, kink in pieces:
            states = solve(kink, y, times)
            if states is None or len(states) < len(times):
                return numpy.full((3, len(grid)), numpy.nan)
            y = states[-1].copy()
            rows.append(states[:-1])
        return numpy.concatenate([*rows, y[None]]).T

    return run


def trajectory(solve: Any, p: Wire, form: str, rtol: float) -> Callable[[], Any]:
    """Run of x₊, x₋, T on the output grid with a solver of Python."""
    behind = make_rhs(p, form)
    return integrate_pieces(lambda kink, y, times: solve(behind(*kink), y, times, rtol))


def outcome(p: Wire, states: Any) -> Any:
    """x [mm], stress [Pa] and strain [1] of x₊, x₋, T, one row each."""
    import numpy

    d, (plus, minus, _) = lumped(p), states
    soft = (plus + minus) / p.E_M + (1 - plus - minus) / p.E_A
    stress = (d.sigma0 + d.K * (d.eps0 - p.eps_T * (plus - minus))) / (1 + d.K * soft)
    strain = p.eps_T * (plus - minus) + stress * soft
    return numpy.array([1e3 * p.length * (stress - d.sigma0) / d.K, stress, strain])


SOLVERS = {"LSODA": by_odeint, "Radau": by_radau}
if importlib.util.find_spec("sksundae"):
    SOLVERS["CVODE"] = by_cvode
