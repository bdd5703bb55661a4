"""Return map of problem A on plain floats, branched by hand: the independent reference of rule P.

What: two surfaces bound the state, xi <= m w_A(T_A) and 1 - xi <= a w_M(T_M). Inside both xi is
frozen. If a step with frozen xi leaves the set, one scalar equation in the new xi, with latent
heat and spring stress inside, returns it to the surface. Second order, A-stable, no sign of dT.
    T(x) = T + D {dt [V^2/R(mean xi) - Q] + M latent (x - xi)},  D = 1/(M c + dt Q'/2)
    heating: x = m w_A(T(x) - sigma/C_A);  cooling: 1 - x = a w_M(T(x) - sigma/C_M)
The scalar solve is a strictly bracketed Newton method, iterated until |g| <= 1e-14 (g' >= 1, so
|g| bounds the error of xi). `restart` re-anchors both memories after every step (rule R).
It shares no code with the library, only the parameters and inputs of the problem. The zones of
the two surfaces must not overlap along the path.
"""

from __future__ import annotations

import math
from collections.abc import Callable

from benchmarks.engines import Engine
from benchmarks.inputs import Drive, Rows, aligned
from benchmarks.objective import differences
from benchmarks.problem_a import THETA, Wire, displacement, lumped, one_set, scaled

State = tuple[float, float, float, float]  # T [degC], xi, memory m, memory a
Step = Callable[[State, float, float], State]
TOLERANCE = 1e-14


def start(p: Wire) -> State:
    """Cold, fully martensitic wire."""
    return (p.T_a, 1.0, 1.0, 0.0)


def make_step(p: Wire, restart: bool = False, limit: int = 100) -> Step:
    """The step (state, V^2 [V^2], dt [s]) -> state for one parameter set."""
    d = lumped(p)
    h0, A_s, M_f, C_A, C_M, T_a, h1 = p.h0, p.A_s, p.M_f, p.C_A, p.C_M, p.T_a, p.h1
    M, S, sigma0, K, R0, kappa, Theta = d.M, d.S, d.sigma0, d.K, d.R0, p.kappa, p.Theta
    W_A, W_M, Mc, heat_of = p.A_f - p.A_s, p.M_s - p.M_f, M * p.c, M * p.latent
    E_A, dE, eps_L, eps0 = p.E_A, p.E_M - p.E_A, p.eps_L, d.eps0
    base, pi, cos, sin = sigma0 + K * eps0, math.pi, math.cos, math.sin

    def solve(state: tuple[float, float], load: tuple[float, ...], side: tuple[float, ...]) -> tuple[float, float]:
        (T, xi), (U, dt, Q, D), (s, z, C, T0, W) = state, load, side
        lo, hi, x = (-1.0, xi, xi) if s > 0 else (xi, 2.0, xi)
        for _ in range(limit):
            R = R0 * (1 + kappa * 0.5 * (xi + x))
            Tx = T + D * (dt * (U / R - Q) + heat_of * (x - xi))
            E = E_A + x * dE
            eps = (base + E * eps_L * x - Theta * (Tx - T_a)) / (E + K)
            u = (Tx - (base - K * eps) / C - T0) / W
            u = 0.0 if u < 0 else 1.0 if u > 1 else u
            g = s * ((x if s > 0 else 1 - x) - z * (0.5 + 0.5 * s * cos(pi * u)))
            if -TOLERANCE <= g <= TOLERANCE:
                break
            T_x = D * (heat_of - dt * U * 0.5 * kappa * R0 / (R * R))
            s_x = -K * (dE * eps_L * x + E * eps_L - dE * eps) / (E + K)
            s_T = K * Theta / (E + K)
            slope = 1 + z * pi / (2 * W) * sin(pi * u) * (T_x - (s_x + s_T * T_x) / C)
            lo, hi = (lo, x) if g > 0 else (x, hi)
            new = x - g / slope
            if not (lo < new < hi) and not -TOLERANCE <= new - x <= TOLERANCE:
                new = 0.5 * (lo + hi)
            if new == x:
                break
            x = new
        R = R0 * (1 + kappa * 0.5 * (xi + x))
        return x, T + D * (dt * (U / R - Q) + heat_of * (x - xi))

    def zones(T: float, xi: float) -> tuple[float, float]:
        E = E_A + xi * dE
        sigma = base - K * (base + E * eps_L * xi - Theta * (T - T_a)) / (E + K)
        return (T - sigma / C_A - A_s) / W_A, (T - sigma / C_M - M_f) / W_M

    def step(state: State, U: float, dt: float) -> State:
        T, xi, m, a = state
        above = T - T_a
        Q = (h0 + h1 * above) * S * above
        D = 1 / (Mc + 0.5 * dt * (h0 + 2 * h1 * above) * S)
        end = T + D * dt * (U / (R0 * (1 + kappa * xi)) - Q)
        u_A, u_M = zones(end, xi)
        if u_A > 0 and xi > m * (0.5 + 0.5 * cos(pi * u_A) if u_A < 1 else 0.0):
            xi, end = solve((T, xi), (U, dt, Q, D), (1.0, m, C_A, A_s, W_A))
            a = 1 - xi
        elif u_M < 1 and 1 - xi > a * (0.5 - 0.5 * cos(pi * u_M) if u_M > 0 else 0.0):
            xi, end = solve((T, xi), (U, dt, Q, D), (-1.0, a, C_M, M_f, W_M))
            m = xi
        return (end, xi, *(anchored(end, xi, m, a) if restart else (m, a)))

    def anchored(T: float, xi: float, m: float, a: float) -> tuple[float, float]:
        u_A, u_M = zones(T, xi)
        w_A = 0.5 + 0.5 * cos(pi * min(max(u_A, 0.0), 1.0))
        w_M = 0.5 - 0.5 * cos(pi * min(max(u_M, 0.0), 1.0))
        return (xi / w_A if w_A > 0 else m), ((1 - xi) / w_M if w_M > 0 else a)

    return step


def march(p: Wire, rows: Rows, restart: bool = False) -> list[State]:
    """States on the output grid, the start included."""
    step, state = make_step(p, restart), start(p)
    states = [state]
    for row in rows:
        for U, dt in row:
            state = step(state, U, dt)
        states.append(state)
    return states


def displacements(p: Wire, rows: Rows, restart: bool = False) -> list[float]:
    """x [mm] on the output grid."""
    d = lumped(p)
    return [displacement(p, d, T, xi) for T, xi, _, _ in march(p, rows, restart)]


def single(p: Wire, drive: Drive, dt: float) -> Callable[[], list[float]]:
    """A run with steps of at most dt [s] that land on the edges of the input."""
    rows = aligned(drive, dt)
    return lambda: displacements(p, rows)


def batch(sets: Wire, drive: Drive, dt: float) -> Callable[[], list[list[float]]]:
    """The sets one after another."""
    rows = aligned(drive, dt)
    wires = [one_set(sets, i) for i in range(len(getattr(sets, THETA[0])))]
    return lambda: [displacements(p, rows) for p in wires]


def gradient(p: Wire, drive: Drive, dt: float) -> Callable[[], list[float]]:
    """dJ/dq by central differences, 20 runs; sound because the steps are fixed."""
    rows = aligned(drive, dt)
    return differences(lambda q: displacements(scaled(p, q), rows))


def control_step(p: Wire, dt: float) -> tuple[State, Callable[[State, float], State]]:
    """One step of a control loop with period dt [s]."""
    step = make_step(p)
    return start(p), lambda state, U: step(state, U, dt)


STEPS = {f"dt {dt:g} ms": dt * 1e-3 for dt in (50, 20, 10, 5, 1)}

ENGINES = (
    Engine(
        name="floats",
        rule="P",
        settings=STEPS,
        usual="dt 10 ms",
        single=single,
        batch=batch,
        gradient=gradient,
        step=control_step,
        batch_limit=16,
    ),
)
