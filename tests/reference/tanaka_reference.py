"""One-page Tanaka kinetics, written from the equations; shares no code with the package.

    u = T - σ/C_M, forward for du < 0, u < M_s:  1 - ξ₁ = (1 - ξ₀) exp[-a_M (u₀ - u₁)]
    w = T - σ/C_A, reverse for dw > 0, w > A_s:      ξ₁ = ξ₀ exp[-a_A (w₁ - w₀)]

with a = 2 ln 10 per strip. restart: u₀, u₁ are the ends of the increment, cut off at M_s (w: at
A_s). resume: they are the extremes (lowest u, highest w) since the branch was opened. A straight
leg is cut where u = M_s, M_f and w = A_s, A_f. Where both could act on a piece, the branch in
progress does while it is before its finish line, else the other while that one is, else reverse.
No branch yet counts as reverse, or as forward if there is no martensite.
"""

import math
from dataclasses import dataclass, replace
from itertools import pairwise

EPS = 2.0**-52


@dataclass(frozen=True)
class Parameters:
    A_s: float  # [K]
    A_f: float
    M_s: float
    M_f: float
    C_A: float  # [Pa/K]
    C_M: float


@dataclass(frozen=True)
class State:
    xi: float
    T: float  # [K]
    sigma: float  # [Pa]
    branch: str = ""  # "", "F" or "R"
    extreme: float | None = None  # [K] lowest u or highest w of the branch in progress


def crossings(start, end, lines):
    """Shares of the way at which a coordinate meets lines."""
    return [(line - start) / (end - start) for line in lines if (line - start) * (line - end) < 0]


def snapped(x, lines, zero):
    """A coordinate within rounding of a line is on it."""
    return next((line for line in lines if abs(x - line) <= zero), x)


def acting(p, state, forward, reverse, u, w):
    """The process of a piece whose middle lies at (u, w); it may have nothing to transform."""
    if not (forward and reverse):
        return "F" if forward else "R" if reverse else ""
    able = {"F": u > p.M_f, "R": w < p.A_f}
    first = state.branch or ("R" if state.xi > 0 else "F")
    second = "R" if first == "F" else "F"
    return first if able[first] else second if able[second] else "R"


def advance(p, rule, state, sigma, T):
    """The state after a straight leg to (σ, T)."""
    zero = 8 * EPS * (state.T + T + (state.sigma + sigma) / min(p.C_A, p.C_M))
    ends = (state.T, state.sigma), (T, sigma)
    u0, u1 = (snapped(t - f / p.C_M, (p.M_s, p.M_f), zero) for t, f in ends)
    w0, w1 = (snapped(t - f / p.C_A, (p.A_s, p.A_f), zero) for t, f in ends)
    falls, rises = u0 - u1 > zero, w1 - w0 > zero
    cuts = crossings(u0, u1, (p.M_s, p.M_f)) + crossings(w0, w1, (p.A_s, p.A_f))
    for a, b in pairwise(sorted([0.0, *cuts, 1.0])):
        middle = 0.5 * (a + b)
        u, w = u0 + middle * (u1 - u0), w0 + middle * (w1 - w0)
        acts = acting(p, state, falls and u < p.M_s, rises and w > p.A_s, u, w)
        if (acts == "F" and state.xi < 1) or (acts == "R" and state.xi > 0):
            ends = [(u0 + s * (u1 - u0)) if acts == "F" else (w0 + s * (w1 - w0)) for s in (a, b)]
            state = transform(p, rule, state, acts, *ends)
    return replace(state, T=T, sigma=sigma)


def transform(p, rule, state, acts, start, end):
    """Fraction and memory after a piece on which one process acts from `start` to `end` [K]."""
    sign, width = (-1.0, p.M_s - p.M_f) if acts == "F" else (1.0, p.A_f - p.A_s)
    since = start
    if rule == "resume" and state.branch == acts and state.extreme is not None:
        since = state.extreme
    way = max(0.0, sign * (end - since))  # [K] beyond the extreme
    left = math.exp(-2.0 * math.log(10.0) * way / width)
    xi = 1.0 - (1.0 - state.xi) * left if acts == "F" else state.xi * left
    return replace(state, xi=xi, branch=acts, extreme=since + sign * way)
