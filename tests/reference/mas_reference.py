"""The Müller–Achenbach–Seelecke equations on one page; shares no code with the package.

    dx₊/dt = A p(σ) - x₊ q(σ),   dx₋/dt = A p(-σ) - x₋ q(-σ),   A = 1 - x₊ - x₋
    ε = ε_T (x₊ - x₋) + σ [(x₊ + x₋)/E_M + A/E_A]
    s_A = max(least, σ_L + s (T - T_L)),  s_M = s_A - Δσ,  λ = V/(k_B T)

with the rates p from austenite to M+ and q back, in three forms: `barrier` (height of the saddle,
case by case), `edge` (the same with a rigid bridge), `well` (layers at the edge of their well,
least = 0.05 w_A). The equations are stiff: they go to Radau of SciPy or Kvaerno5 of diffrax, in
pieces between the kinks of the input.

`p` is anything with the fields of `benchmarks.problem_b.Wire`; `np` is numpy or jax.numpy.
"""

from functools import cache
from itertools import pairwise

import numpy
from scipy import special
from scipy.integrate import solve_ivp

BOLTZMANN = 1.380649e-23  # [J/K]


def rates(np, sp, p, stress, T, form):
    """Rates [1/s] of A → M+ and M+ → A; `sp` has erf, erfc and erfcx."""
    T = np.maximum(T, 100.0)  # solvers visit absurd points
    lam = p.layer_volume / (BOLTZMANN * T)
    w_A, w_M = np.sqrt(2 * p.E_A / lam), np.sqrt(2 * p.E_M / lam)
    s_A = p.sigma_L + p.dsigma_dT * (T - p.T_L)
    s_A = np.maximum(s_A, 0.05 * w_A if form == "well" else 0.0)
    s_M = s_A - p.Delta_sigma
    if form == "well":
        p_A = out_of_well(np, sp, (s_A - stress) / w_A, (s_A + stress) / w_A)
        p_M = np.sqrt(p.E_M / p.E_A) * out_of_half_line(np, sp, (s_M - stress) / w_M)
        return p_A / p.layer_time, p_M / p.layer_time
    if form == "edge":
        up = np.maximum(s_A - stress, 0.0) ** 2 / (2 * p.E_A)
        down = np.maximum(stress - s_M, 0.0) ** 2 / (2 * p.E_M)
    else:
        up, down = saddle(np, p, stress, s_A, s_M)
    return np.exp(-lam * up) / p.layer_time, np.exp(-lam * down) / p.layer_time


def saddle(np, p, stress, s_A, s_M):
    """Barriers [J/m³] from A to M+ and back; where a well is gone, the difference of the wells."""
    gap = p.eps_T + s_M / p.E_M - s_A / p.E_A
    per_K = gap / p.Delta_sigma
    left, right = (s_A - stress) ** 2, (stress - s_M) ** 2
    beyond = np.where(stress < -s_A, (stress + s_A) ** 2 / (2 * p.E_A), 0.0)
    over = (stress - (s_A + s_M) / 2) * gap
    up = np.where(stress <= s_M, left / (2 * p.E_A) - over - beyond, left * (1 / p.E_A + per_K) / 2)
    down = np.where(stress >= s_A, right / (2 * p.E_M) + over, right * (1 / p.E_M + per_K) / 2)
    return np.where(stress >= s_A, 0.0, up), np.where(stress <= s_M, 0.0, down)


def out_of_well(np, sp, u, v):
    """exp(-u²)/[erf(u) + erf(v)], also where one of them is far below zero."""
    a, b = np.abs(u), np.abs(v)
    fade = np.exp(-np.abs(v * v - u * u))
    inside = np.exp(-u * u) / np.maximum(sp.erf(a) + sp.erf(b), 1e-300)
    past = 1 / np.maximum(sp.erfcx(a) - fade * sp.erfcx(b), 1e-300)
    behind = fade / np.maximum(sp.erfcx(b) - fade * sp.erfcx(a), 1e-300)
    return np.where(u < 0, past, np.where(v < 0, behind, inside))


def out_of_half_line(np, sp, z):
    """exp(-z²)/erfc(z)."""
    below = np.minimum(z, 0.0)
    return np.where(z >= 0, 1 / sp.erfcx(np.abs(z)), np.exp(-below * below) / sp.erfc(below))


def compliance(p, plus, minus):
    """Elastic strain per stress [1/Pa]."""
    return (plus + minus) / p.E_M + (1 - plus - minus) / p.E_A


def flow(np, sp, p, plus, minus, stress, T, form):
    """dx₊/dt and dx₋/dt [1/s]."""
    up, down = rates(np, sp, p, stress, T, form)
    over, back = rates(np, sp, p, -stress, T, form)
    A = 1 - plus - minus
    return A * up - plus * down, A * over - minus * back


def bare(p, form, at):
    """f(t, (x₊, x₋)) of a material whose stress [Pa] and temperature [K] are at(t, x₊, x₋)."""

    def f(t, y):
        plus, minus = y
        stress, T = at(t, plus, minus)
        return numpy.array(flow(numpy, special, p, plus, minus, stress, T, form))

    return f


def strained(p, strain, T):
    """`at` of a strain-driven test: strain(t) [-] at constant temperature [K]."""

    def at(t, plus, minus):
        return (strain(t) - p.eps_T * (plus - minus)) / compliance(p, plus, minus), T

    return at


def actuator(p, d, form, watts, np=numpy, sp=special):
    """f(t, (x₊, x₋, T)) of the heated wire on its spring; `d` = lumped(p)."""

    def f(t, y):
        plus, minus, T = y
        stress = spring_stress(p, d, plus, minus)
        x1, x2 = flow(np, sp, p, plus, minus, stress, T, form)
        heat = watts(t) - p.h * d.S * (T - p.T_a) + d.M * p.latent * (x1 + x2)
        return np.stack([x1, x2, heat / (d.M * p.c)])

    return f


def spring_stress(p, d, plus, minus):
    """Stress [Pa] at which wire and spring are in balance."""
    free = d.sigma0 + d.K * (d.eps0 - p.eps_T * (plus - minus))
    return free / (1 + d.K * compliance(p, plus, minus))


def displacement(p, d, y):
    """x [m] of rows (x₊, x₋, T)."""
    return p.length * (spring_stress(p, d, y[0], y[1]) - d.sigma0) / d.K


def radau(f, y0, times, kinks, rtol=1e-9):
    """States (components, times) by SciPy."""
    y0 = numpy.asarray(y0, float)
    atol = rtol * numpy.array([0.01, 0.01, 1.0][: len(y0)])
    ends = [times[0], *(k for k in kinks if times[0] < k < times[-1]), times[-1]]
    found = numpy.empty((len(y0), len(times)))
    found[:, 0] = y = y0
    for a, b in pairwise(ends):
        here = (times > a + 1e-9) & (times < b - 1e-9)
        done = solve_ivp(f, (a, b), y, "Radau", t_eval=[*times[here], b], rtol=rtol, atol=atol, max_step=(b - a) / 20)
        assert done.success, done.message
        found[:, here], y = done.y[:, :-1], done.y[:, -1]
        found[:, abs(times - b) <= 1e-9] = y[:, None]
    return found


@cache
def kvaerno_solver(form, rtol):
    """Compiled function (p, d, y0, times, kinks, watts) -> states, by diffrax."""
    import diffrax
    import jax
    import jax.numpy as jnp

    jax.config.update("jax_enable_x64", True)

    @jax.jit
    def run(p, d, y0, times, kinks, watts):
        def power(t):
            return jnp.interp(t, kinks, watts)

        f = actuator(p, d, form, power, jnp, jax.scipy.special)
        size = rtol * jnp.array([0.01, 0.01, 1.0])
        control = diffrax.ClipStepSizeController(diffrax.PIDController(rtol, size, dtmax=0.25), jump_ts=kinks[1:-1])
        return diffrax.diffeqsolve(
            diffrax.ODETerm(lambda t, y, _: f(t, y)),
            diffrax.Kvaerno5(),
            times[0],
            times[-1],
            1e-4,
            y0,
            saveat=diffrax.SaveAt(ts=times),
            stepsize_controller=control,
            max_steps=100_000,
        ).ys

    return run


def kvaerno(p, d, form, y0, times, inputs, rtol=1e-8):
    """States (components, times) of the actuator; `inputs` are the kinks [s] and powers [W]."""
    arrays = (numpy.asarray(column, float) for column in (y0, times, *inputs))
    return numpy.asarray(kvaerno_solver(form, rtol)(p, d, *arrays)).T
