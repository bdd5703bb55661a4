"""Rate form R of problem A under diffrax: Tsit5 with step-size control, batches, gradients.

What: the equations of `rate_form` for JAX in float64, the branches as `where` with the unused side
made safe, output by the solver's own interpolation, steps ending on the edges of the input. The
ten varied parameters are traced, so that a new set does not compile again. Tsit5 (explicit) is
the fastest of diffrax's methods here: the problem is not stiff between its kinks.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import diffrax
import jax
import jax.numpy as jnp
import numpy as np

from benchmarks.engines import Engine
from benchmarks.inputs import Drive, sine_squared
from benchmarks.peers.rate_form import CAP
from benchmarks.problem_a import THETA, Wire, displacement, lumped, scaled, target_factors

jax.config.update("jax_enable_x64", True)

MAX_STEPS = 65536
CHUNK = 1024  # sets per vmap; larger batches go through it piece by piece


def input_of(drive: Drive) -> Callable[[Any], Any]:
    """V^2 [V^2] at a traced time [s]."""
    if not drive.edges:
        return lambda t: sine_squared(t, jnp.cos)
    edges, levels = jnp.array(drive.edges), jnp.array(drive.levels)
    return lambda t: levels[jnp.searchsorted(edges, t, side="right") - 1]


def rates(p: Wire, T: Any, xi: Any, U: Any) -> tuple[Any, Any]:
    """(dT/dt [K/s], dxi/dt [1/s]) at V^2 = U [V^2]."""
    d = lumped(p)
    above = T - p.T_a
    dE = p.E_M - p.E_A
    E = p.E_A + xi * dE
    eps = (d.sigma0 + d.K * d.eps0 + E * p.eps_L * xi - p.Theta * above) / (E + d.K)
    sigma = d.sigma0 + d.K * (d.eps0 - eps)
    net = U / (d.R0 * (1 + p.kappa * xi)) - (p.h0 + p.h1 * above) * d.S * above
    heats = net > 0
    C = jnp.where(heats, p.C_A, p.C_M)
    W = jnp.where(heats, p.A_f - p.A_s, p.M_s - p.M_f)
    u = jnp.where(heats, T - sigma / C - p.A_s, p.M_s - T + sigma / C) / W  # progress in the zone
    inside = (u > 0) & (u < 1)
    tangent = jnp.where(inside, jnp.minimum(jnp.tan(0.5 * jnp.pi * jnp.where(inside, u, 0)), CAP), 0)
    G = -jnp.where(heats, xi, 1 - xi) * jnp.pi / W * tangent
    by_xi = -d.K * (dE * p.eps_L * xi + E * p.eps_L - dE * eps) / (E + d.K)
    H = G * (1 - d.K * p.Theta / (E + d.K) / C) / (1 + G * by_xi / C)
    rate = net / (d.M * (p.c - p.latent * H))
    return rate, H * rate


def make_run(drive: Drive, rtol: float, adjoint: Any = None) -> Callable[[Wire], Any]:
    """Traceable wire -> x [mm] on the output grid."""
    power = input_of(drive)
    control: Any = diffrax.PIDController(rtol=rtol, atol=jnp.array([10 * rtol, 0.1 * rtol]), dtmax=0.5)
    jumps = [t for t in drive.edges if 0 < t < drive.duration]
    if jumps:
        control = diffrax.ClipStepSizeController(control, jump_ts=jnp.array(jumps))
    times = jnp.arange(round(drive.duration * 10) + 1) / 10
    term = diffrax.ODETerm(lambda t, y, p: jnp.stack(rates(p, y[0], y[1], power(t))))

    def run(p: Wire) -> Any:
        y0 = jnp.array([p.T_a, 1.0])
        solution = diffrax.diffeqsolve(
            term,
            diffrax.Tsit5(),
            0.0,
            drive.duration,
            None,
            y0,
            args=p,
            saveat=diffrax.SaveAt(ts=times),
            stepsize_controller=control,
            max_steps=MAX_STEPS,
            adjoint=adjoint or diffrax.RecursiveCheckpointAdjoint(),
        )
        ys: Any = solution.ys
        return displacement(p, lumped(p), ys[:, 0], ys[:, 1])

    return run


def theta_of(p: Wire) -> Any:
    """The varied parameters as an array, the parameters along the last axis."""
    return jnp.stack([jnp.asarray(getattr(p, name)) for name in THETA], axis=-1)


def with_theta(p: Wire, theta: Any) -> Wire:
    """The wire with these varied parameters."""
    return p._replace(**{name: theta[i] for i, name in enumerate(THETA)})


def single(p: Wire, drive: Drive, rtol: float) -> Callable[[], Any]:
    """One run."""
    run, theta = make_run(drive, rtol), theta_of(p)
    solve = jax.jit(lambda theta: run(with_theta(p, theta)))
    return lambda: np.asarray(solve(theta))


def batch(sets: Wire, drive: Drive, rtol: float) -> Callable[[], Any]:
    """All sets by vmap, in chunks."""
    run, theta = make_run(drive, rtol), theta_of(sets)
    one = Wire()._replace(**{n: v for n, v in sets._asdict().items() if n not in THETA})
    each = jax.vmap(lambda theta: run(with_theta(one, theta)))
    size = min(len(theta), CHUNK)
    if len(theta) % size:
        raise ValueError(f"A batch must be a multiple of {CHUNK} sets, but has {len(theta)}.")
    solve = jax.jit(lambda theta: jax.lax.map(each, theta.reshape(-1, size, len(THETA))))
    return lambda: np.asarray(solve(theta)).reshape(len(theta), -1)


def gradient_by(forward: bool) -> Callable[..., Callable[[], Any]]:
    """Gradient of J by forward or by reverse mode, through the solver's steps."""

    def gradient(p: Wire, drive: Drive, rtol: float) -> Callable[[], Any]:
        run = make_run(drive, rtol, diffrax.ForwardMode() if forward else None)
        x_d = jnp.asarray(single(scaled(p, target_factors()), drive, rtol)())

        def mismatch(q: Any) -> Any:
            return jnp.mean((run(scaled(p, q)) - x_d) ** 2) / jnp.ptp(x_d) ** 2

        slope = jax.jit(jax.jacfwd(mismatch) if forward else jax.grad(mismatch))
        q = jnp.ones(len(THETA))
        return lambda: np.asarray(slope(q))

    return gradient


TOLERANCES = {f"rtol 1e-{k}": 10.0**-k for k in range(4, 9)}
DISK = {
    "JAX_COMPILATION_CACHE_DIR": "CACHE",
    "JAX_PERSISTENT_CACHE_MIN_COMPILE_TIME_SECS": "0",
    "JAX_PERSISTENT_CACHE_MIN_ENTRY_SIZE_BYTES": "-1",
}
ENVIRONMENTS = {"no cache": {}, "disk cache": DISK, "disk cache, EQX_ON_ERROR=nan": {**DISK, "EQX_ON_ERROR": "nan"}}

ENGINES = (
    Engine(
        name="diffrax",
        rule="R",
        settings=TOLERANCES,
        usual="rtol 1e-7",
        single=single,
        batch=batch,
        gradient=gradient_by(forward=False),
        environments=ENVIRONMENTS,
        optional="diffrax",
    ),
    Engine(
        name="diffrax-forward",
        rule="R",
        settings=TOLERANCES,
        usual="rtol 1e-7",
        gradient=gradient_by(forward=True),
        optional="diffrax",
    ),
)
