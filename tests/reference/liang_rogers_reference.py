"""One-page Liang–Rogers kinetics, written from the equations; shares no code with the package.

    u = T - σ/C_M, forward for du < 0:  1 - p = sin²(θ/2), θ = π (u - M_f)/(M_s - M_f)
    w = T - σ/C_A, reverse for dw > 0:  1 - p = cos²(θ/2), θ = π (w - A_s)/(A_f - A_s)
    forward  1 - ξ₁ = (1 - ξ₀) (1 - P₁)/(1 - P₀),   reverse  ξ₁ = ξ₀ (1 - P₁)/(1 - P₀)

restart: P₀, P₁ belong to the ends of the increment. resume: they are the largest progress since
the branch was opened. A straight leg is cut where u = M_s, M_f and w = A_s, A_f; on every piece at
most one process acts: the branch in progress while it has something to transform, else the other
one, and reverse if there is no branch. Memories hold 1 - P, exact near the finish lines.
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


@dataclass
class State:
    xi: float
    T: float  # [K]
    sigma: float  # [Pa]
    branch: str = ""  # "", "F" or "R"
    left_F: float | None = None  # 1 - P of the forward branch; None: unset
    left_R: float | None = None


def left_forward(p: Parameters, u: float) -> float:
    """1 - p of the forward process."""
    if u <= p.M_f or u >= p.M_s:
        return 0.0 if u <= p.M_f else 1.0
    return math.sin(0.5 * math.pi * (u - p.M_f) / (p.M_s - p.M_f)) ** 2


def left_reverse(p: Parameters, w: float) -> float:
    """1 - p of the reverse process; the cosine written as a sine of the complement."""
    if w <= p.A_s or w >= p.A_f:
        return 1.0 if w <= p.A_s else 0.0
    return math.sin(0.5 * math.pi * (p.A_f - w) / (p.A_f - p.A_s)) ** 2


def snapped(x: float, lines: tuple[float, ...], zero: float) -> float:
    """A coordinate within rounding of a line is on it."""
    return next((line for line in lines if abs(x - line) <= zero), x)


def pieces(p: Parameters, leg: tuple[float, float, float, float]) -> list[tuple[float, ...]]:
    """(u, w) at all cuts of a leg, coordinates exactly on the line where they cross it."""
    u0, u1, w0, w1 = leg
    cuts: dict[float, dict[str, float]] = {0.0: {"u": u0, "w": w0}, 1.0: {"u": u1, "w": w1}}
    for name, a, b, lines in (("u", u0, u1, (p.M_s, p.M_f)), ("w", w0, w1, (p.A_s, p.A_f))):
        for line in lines:
            if min(a, b) < line < max(a, b):
                cuts.setdefault((line - a) / (b - a), {}).update({name: line})
    points: list[tuple[float, ...]] = []
    for s in sorted(cuts):
        u = cuts[s].get("u", u0 + s * (u1 - u0))
        w = cuts[s].get("w", w0 + s * (w1 - w0))
        points.append((u, w))
    return points


def which(state: State, forward: bool, reverse: bool) -> str:
    """The one process that acts on a piece."""
    if forward and reverse:
        return state.branch or "R"
    return "F" if forward else "R" if reverse else ""


def advance(p: Parameters, rule: str, state: State, sigma: float, T: float) -> State:
    """The state after a straight leg to (σ, T)."""
    s = State(**vars(state))
    zero = 8 * EPS * (abs(s.T) + abs(T) + (abs(s.sigma) + abs(sigma)) / min(p.C_A, p.C_M))
    ends = (s.T, s.sigma), (T, sigma)
    u0, u1 = (snapped(t - f / p.C_M, (p.M_s, p.M_f), zero) for t, f in ends)
    w0, w1 = (snapped(t - f / p.C_A, (p.A_s, p.A_f), zero) for t, f in ends)
    leg = u0, u1, w0, w1
    cooling, heating = leg[0] - leg[1] > zero, leg[3] - leg[2] > zero
    points = pieces(p, leg)
    for (u0, w0), (u1, w1) in pairwise(points):
        f0, f1 = left_forward(p, u0), left_forward(p, u1)
        r0, r1 = left_reverse(p, w0), left_reverse(p, w1)
        acts = which(s, cooling and f1 < f0 and s.xi < 1, heating and r1 < r0 and s.xi > 0)
        if acts and acts != s.branch:
            s.branch, s.left_F, s.left_R = acts, None, None
        if acts == "F":
            before = f0 if rule == "restart" or s.left_F is None else s.left_F
            s.left_F = min(before, f1)
            s.xi = 1 - (1 - s.xi) * (s.left_F / before if before > 0 else 1.0)
        if acts == "R":
            before = r0 if rule == "restart" or s.left_R is None else s.left_R
            s.left_R = min(before, r1)
            s.xi = s.xi * (s.left_R / before if before > 0 else 1.0)
    s.T, s.sigma = T, sigma
    return s
