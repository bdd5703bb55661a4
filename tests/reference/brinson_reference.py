"""One-page Brinson kinetics, written from the equations; shares no code with the package.

    s = σ - C_M max(T - M_s, 0),  S for ds > 0:  1 - p = cos²(φ/2), φ = π (s - σ_s)/(σ_f - σ_s)
                                  T for dT < 0:  1 - p = sin²(ψ/2), ψ = π (T - M_f)/(M_s - M_f)
    w = T - σ/C_A,                R for dw > 0:  1 - p = cos²(θ/2), θ = π (w - A_s)/(A_f - A_s)

With r = (1 - P₁)/(1 - P₀) of each process and the austenite fraction A = 1 - ξ_S - ξ_T:

    S and T    ξ_S = 1 - (1 - ξ_S0) r_S,   A = A₀ r_S r_T,   ξ_T = r_S [ξ_T0 + A₀ (1 - r_T)]
    R          ξ_S = ξ_S0 r,               ξ_T = ξ_T0 r

restart: P₀, P₁ belong to the ends of the increment. resume: they are the largest progress since
the branch was opened. A straight leg is cut where T = M_s, M_f, then where s = σ_s, σ_f and
w = A_s, A_f; on every piece either the forward pair or R acts: the branch in progress while it
has something to transform, else the other one, and R if there is no branch.
"""

import math
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

EPS = np.finfo(float).eps


@dataclass
class Parameters:
    A_s: float  # [K]
    A_f: float
    M_s: float
    M_f: float
    C_A: float  # [Pa/K]
    C_M: float
    sigma_s: float  # [Pa]
    sigma_f: float


@dataclass
class State:
    xi_S: float
    xi_T: float
    T: float  # [K]
    sigma: float  # [Pa]
    branch: str = ""  # "", "F" or "R"
    left_S: float | None = None  # 1 - P on the branch; None: unset
    left_T: float | None = None
    left_R: float | None = None
    A: float = math.nan

    def __post_init__(self) -> None:
        if math.isnan(self.A):
            self.A = 1 - self.xi_S - self.xi_T


def left(x: float, start: float, finish: float) -> float:
    """1 - p of a cosine process between two lines, written as a sine from the finish line."""
    share = (x - finish) / (start - finish)
    if x == finish or share <= 0:
        return 0.0
    return 1.0 if x == start or share >= 1 else math.sin(0.5 * math.pi * share) ** 2


def snapped(x: float, lines: tuple[float, float], zero: float) -> float:
    """A coordinate within rounding of a line is on it."""
    return next((line for line in lines if abs(x - line) <= zero), x)


def cut(ends: list[dict[str, float]], lines: dict[str, tuple[float, float]]) -> list[dict]:
    """A straight piece cut where its coordinates meet lines, which they do exactly there."""
    a, b = ends
    found: dict[float, dict[str, float]] = {0.0: a, 1.0: b}
    for name, both in lines.items():
        for line in both:
            if min(a[name], b[name]) < line < max(a[name], b[name]):
                share = (line - a[name]) / (b[name] - a[name])
                between = {k: a[k] + share * (b[k] - a[k]) for k in a}
                found[share] = found.get(share, between) | {name: line}
    return [found[share] for share in sorted(found)]


def pieces(p: Parameters, state: State, sigma: float, T: float, zero: float) -> list[list[dict]]:
    """The parts of a leg between lines of T, each a list of points at lines of s and w."""
    ends = [
        {"T": snapped(t, (p.M_s, p.M_f), zero), "sigma": f, "w": t - f / p.C_A}
        for t, f in ((state.T, state.sigma), (T, sigma))
    ]
    points = cut(ends, {"T": (p.M_s, p.M_f)})
    for q in points:
        s = q["sigma"] - p.C_M * max(q["T"] - p.M_s, 0)
        q["s"] = snapped(s, (p.sigma_s, p.sigma_f), zero * p.C_M)
        q["w"] = snapped(q["w"], (p.A_s, p.A_f), zero)
    lines = {"s": (p.sigma_s, p.sigma_f), "w": (p.A_s, p.A_f)}
    return [cut([a, b], lines) for a, b in pairwise(points)]


def which(state: State, forward: bool, reverse: bool) -> str:
    """What acts on a piece."""
    if forward and reverse:
        return state.branch or "R"
    return "F" if forward else "R" if reverse else ""


def progress(rule: str, before: float | None, start: float, end: float, moves: bool):
    """The ratio r and the memory after a process went from `start` to `end`, both 1 - p."""
    if not moves:
        return 1.0, before
    first = start if rule == "restart" or before is None else before
    last = min(first, end)
    return (last / first if first > 0 else 1.0), last


def advance(p: Parameters, rule: str, state: State, sigma: float, T: float) -> State:
    """The state after a straight leg to (σ, T)."""
    s = State(**vars(state))
    zero = 8 * EPS * (abs(s.T) + abs(T) + (abs(s.sigma) + abs(sigma)) / min(p.C_A, p.C_M))
    parts = pieces(p, s, sigma, T, zero)
    heating = parts[-1][-1]["w"] - parts[0][0]["w"] > zero
    cooling = s.T - T > zero
    for part in parts:
        loading = part[-1]["s"] - part[0]["s"] > zero * p.C_M
        for a, b in pairwise(part):
            S0, S1 = (left(q["s"], p.sigma_s, p.sigma_f) for q in (a, b))
            T0, T1 = (left(q["T"], p.M_s, p.M_f) for q in (a, b))
            R0, R1 = (left(q["w"], p.A_s, p.A_f) for q in (a, b))
            S, C, R = loading and S1 < S0, cooling and T1 < T0, heating and R1 < R0
            forward = (S and s.xi_S < 1) or (C and s.A > 0)
            acts = which(s, forward, R and s.xi_S + s.xi_T > 0)
            if acts and acts != s.branch:
                s.branch, s.left_S, s.left_T, s.left_R = acts, None, None, None
            if acts == "F":
                r_S, s.left_S = progress(rule, s.left_S, S0, S1, S)
                r_T, s.left_T = progress(rule, s.left_T, T0, T1, C)
                s.xi_S = 1 - (1 - s.xi_S) * r_S
                s.xi_T = r_S * (s.xi_T + s.A * (1 - r_T))
                s.A = s.A * r_S * r_T
            if acts == "R":
                r, s.left_R = progress(rule, s.left_R, R0, R1, True)
                s.A = s.A + (s.xi_S + s.xi_T) * (1 - r)
                s.xi_S, s.xi_T = s.xi_S * r, s.xi_T * r
    s.T, s.sigma = T, sigma
    return s


def literal_sum(p: Parameters, xi_S: float, xi_T: float, sigma: float, T: float) -> float:
    """ξ_S + ξ_T of the formulas of 1993 for M_f < T < M_s, σ_s < σ < σ_f, from (ξ_S0, ξ_T0)."""
    a_M = math.pi / (p.M_s - p.M_f)
    angle = math.pi / (p.sigma_s - p.sigma_f) * (sigma - p.sigma_f)
    stressed = 0.5 * (1 - xi_S) * math.cos(angle) + 0.5 * (1 + xi_S)
    delta = 0.5 * (1 - xi_T) * (math.cos(a_M * (T - p.M_f)) + 1)
    return stressed + xi_T - xi_T / (1 - xi_S) * (stressed - xi_S) + delta
