"""Problem B as a stiff ODE under diffrax: Kvaerno5, in double precision, single or in a batch.

What: the equations of `mas_ode`, cases as `where`, for JAX; steps end on the kinks of the input.
The wire is traced, so that another set of numbers does not compile again.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import Any

import diffrax
import jax
import jax.numpy as jnp
import numpy as np

from benchmarks.peers.mas_ode import BOLTZMANN, LOWEST, SCALE, START, output_times
from benchmarks.problem_b import DURATION, POWER, Wire, lumped

jax.config.update("jax_enable_x64", True)

MAX_STEPS = 100_000


def barriers(p: Any, form: str, stress: Any, s_A: Any, lam: Any) -> tuple[Any, Any]:
    """Exponents of A -> M+ and M+ -> A."""
    s_M = s_A - p.Delta_sigma
    up, down = jnp.maximum(s_A - stress, 0), jnp.maximum(stress - s_M, 0)
    if form == "edge":
        return -lam * up * up / (2 * p.E_A), -lam * down * down / (2 * p.E_M)
    gap = p.eps_T + s_M / p.E_M - s_A / p.E_A
    soft, over = gap / p.Delta_sigma, (stress - (s_A + s_M) / 2) * gap
    beyond = jnp.where(stress < -s_A, (stress + s_A) ** 2 / (2 * p.E_A), 0)
    out = jnp.where(stress <= s_M, up * up / (2 * p.E_A) - over - beyond, up * up * (1 / p.E_A + soft) / 2)
    back = jnp.where(stress >= s_A, down * down / (2 * p.E_M) + over, down * down * (1 / p.E_M + soft) / 2)
    return -lam * out, -lam * back


def field(form: str) -> Callable[..., Any]:
    """dy/dt of (x₊, x₋, T)."""
    kinks, watts = (jnp.array(column) for column in POWER)

    def f(t: Any, y: Any, p: Any) -> Any:
        d = lumped(p)
        plus, minus, T = y
        A, known = 1 - plus - minus, jnp.maximum(T, LOWEST)
        soft = (plus + minus) / p.E_M + A / p.E_A
        stress = (d.sigma0 + d.K * (d.eps0 - p.eps_T * (plus - minus))) / (1 + d.K * soft)
        s_A = jnp.maximum(p.sigma_L + p.dsigma_dT * (known - p.T_L), 0)
        lam = p.layer_volume / (BOLTZMANN * known)
        p_A, p_M = (jnp.exp(e) / p.layer_time for e in barriers(p, form, stress, s_A, lam))
        m_A, m_M = (jnp.exp(e) / p.layer_time for e in barriers(p, form, -stress, s_A, lam))
        x1, x2 = A * p_A - plus * p_M, A * m_A - minus * m_M
        heat = jnp.interp(t, kinks, watts) - p.h * d.S * (T - p.T_a) + d.M * p.latent * (x1 + x2)
        return jnp.stack([x1, x2, heat / (d.M * p.c)])

    return f


@cache
def solver(form: str, many: bool) -> Any:
    """Jitted (wire, rtol) -> states (outputs, 3), or for a wire of arrays (sets, outputs, 3)."""
    times, jumps = jnp.asarray(output_times()), jnp.array(POWER[0][1:-1])
    term = diffrax.ODETerm(field(form))

    def run(p: Any, rtol: Any) -> Any:
        control = diffrax.ClipStepSizeController(
            diffrax.PIDController(rtol=rtol, atol=rtol * jnp.array(SCALE)), jump_ts=jumps
        )
        return diffrax.diffeqsolve(
            term,
            diffrax.Kvaerno5(),
            0.0,
            DURATION,
            1e-4,
            jnp.array(START),
            args=p,
            saveat=diffrax.SaveAt(ts=times),
            stepsize_controller=control,
            max_steps=MAX_STEPS,
        ).ys

    return jax.jit(jax.vmap(run, in_axes=(0, None)) if many else run)


def trajectory(p: Wire, form: str, rtol: float) -> Callable[[], Any]:
    """Run of x₊, x₋, T on the output grid, (3, outputs)."""
    run = solver(form, many=False)
    return lambda: np.asarray(run(p, rtol)).T


def batch(sets: list[Wire], form: str, rtol: float) -> Callable[[], Any]:
    """All sets at once by vmap, (sets, 3, outputs)."""
    wires = Wire(*(np.array(column) for column in zip(*sets, strict=True)))
    run = solver(form, many=True)
    return lambda: np.asarray(run(wires, rtol)).transpose(0, 2, 1)
