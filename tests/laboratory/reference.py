"""One wire on one load line as ordinary differential equations, by SciPy.

Shares no code with the package. A wire of length l and section A is heated by P(t) = U(t)²/R, I² R
or P, cooled by h S (T - T_a), and pulls on a spring or a weight (k = 0). Kinetics: the cosine of
Liang and Rogers, or the exponential of Tanaka, which go on where they were interrupted.

    C dT/dt = P - h S (T - T_a) + L dξ/dt
    σ = [s₀ + K (e₀ - ε_L ξ + Θ (T - T₀)/E)]/(1 + K/E),      K = k l/A

It is integrated from kink to kink: where a transformation starts, goes on, or is complete, where
the heat flow changes its sign, and at every edge of the drive.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Any

import numpy as np
from scipy.integrate import solve_ivp

RTOL, ATOL = 1e-10, (1e-8, 1e-11)
METHOD = "DOP853"
"""Within a leg nothing is stiff; a test looks at Radau as well."""
INSIDE = 1e-9
"""Share of a piece between two edges by which the drive is read inside of it."""
STILL = 1e-9
"""Difference of temperature [K] whose heat flow is none."""
REACHED = 1e-9
"""Share of a strip that is none."""
Signal = Callable[[float], float]


@dataclass
class Wire:
    """All numbers of a wire and its load line, in SI."""

    kind: str
    """`cosine` or `exponential`."""
    drive: str
    """`voltage`, `current` or `power`."""
    numbers: dict[str, float]
    signal: Signal
    """Continuous from edge to edge; asked inside of an interval only."""
    edges: Sequence[float]
    method: str = METHOD
    xi: float = 1.0
    branch: int = 0
    scale: float = 0.0
    mode: int = 0
    """+1 forward, -1 reverse, 0 nothing transforms."""
    piece: tuple[float, float] = (0.0, 0.0)
    """The edges of the drive around now [s]."""
    rows: list[tuple[float, ...]] = field(default_factory=list)

    def __getattr__(self, name: str) -> float:
        return self.__dict__["numbers"][name]

    def modulus(self, xi: float) -> float:
        return self.E_A + xi * (self.E_M - self.E_A)

    def stress(self, xi: float, T: float) -> float:
        E = self.modulus(xi)
        free = self.eps_L * xi - self.Theta * (T - self.T_ref) / E
        return max((self.s0 + self.K * (self.e0 - free)) / (1.0 + self.K / E), 0.0)

    def slopes(self, xi: float, T: float) -> tuple[float, float]:
        """d(sigma)/d(xi) and d(sigma)/dT, by central differences of a smooth formula."""
        a, b = 1e-6, 1e-3
        return (
            (self.stress(xi + a, T) - self.stress(xi - a, T)) / (2.0 * a),
            (self.stress(xi, T + b) - self.stress(xi, T - b)) / (2.0 * b),
        )

    def strip(self, forward: bool) -> tuple[float, float, float]:
        """Finish temperature, width with its sign, and slope of a strip."""
        if forward:
            return self.M_f, self.M_s - self.M_f, self.C_M
        return self.A_f, self.A_s - self.A_f, self.C_A

    def distance(self, forward: bool, xi: float, T: float) -> float:
        """1 on the start line, 0 on the finish line."""
        finish, width, slope = self.strip(forward)
        return (T - self.stress(xi, T) / slope - finish) / width

    def left(self, v: float) -> tuple[float, float]:
        """What a process leaves at a distance, and its slope."""
        if self.kind == "exponential":
            k = 2.0 * math.log(10.0)
            y = math.exp(-k * (1.0 - v))
            return y, k * y
        v = min(max(v, 0.0), 1.0)
        return math.sin(0.5 * math.pi * v) ** 2, 0.5 * math.pi * math.sin(math.pi * v)

    def heat(self, t: float, xi: float, T: float) -> float:
        """Power less loss [W]."""
        begin, end = self.piece
        inside = min(max(t, begin + INSIDE * (end - begin)), end - INSIDE * (end - begin))
        u, R = self.signal(inside), self.R_A + xi * (self.R_M - self.R_A)
        power = {"voltage": u * u / R, "current": u * u * R, "power": max(u, 0.0)}[self.drive]
        return power - self.hS * (T - self.T_a)

    def rates(self, t: float, y: Sequence[float]) -> list[float]:
        T, xi = y
        net = self.heat(t, xi, T)
        if not self.mode:
            return [net / self.C, 0.0]
        forward = self.mode > 0
        _, width, slope = self.strip(forward)
        v = self.distance(forward, xi, T)
        by_v = self.scale * self.left(v)[1]
        by_xi, by_T = self.slopes(xi, T)
        rest = by_v / width
        sign = -1.0 if forward else 1.0
        change = sign * rest * (1.0 - by_T / slope) / (1.0 + sign * rest * by_xi / slope)
        rate = net / (self.C - self.latent * change)
        return [rate, change * rate]

    def waits(self, forward: bool, T: float) -> float:
        """Falls to 0 where a transformation goes on or starts."""
        v, y = self.distance(forward, self.xi, T), (1.0 - self.xi if forward else self.xi)
        if self.branch == (1 if forward else -1):
            if self.kind == "exponential":
                return v - self.lowest
            return self.scale * self.left(v)[0] - y if v < 1.0 else max(self.scale - y, v - 1.0)
        return v - 1.0

    def begin(self, forward: bool, T: float) -> None:
        """Start or resume a transformation."""
        v, y = self.distance(forward, self.xi, T), (1.0 - self.xi if forward else self.xi)
        self.mode = 1 if forward else -1
        if self.branch != self.mode:
            self.branch = self.mode
            self.scale = y / self.left(min(v, 1.0))[0]

    def run(self, times: Sequence[float]) -> np.ndarray:
        """Rows of T, xi, sigma at ascending times from 0 on."""
        T = self.T_a
        self.rows = [(T, self.xi, self.stress(self.xi, T))]
        cuts = [0.0, *(e for e in self.edges if e < times[-1]), times[-1]]
        for a, b in pairwise(cuts):
            self.piece = a, b
            T = self.through(a, b, T, times)
        return np.array(self.rows)

    def through(self, t: float, end: float, T: float, times: Sequence[float]) -> float:
        """From an edge to the next."""
        while t < end - 1e-13 * end:
            heating = self.heat(t, self.xi, T) > 0.0
            if self.mode and (self.mode < 0) != heating:
                self.stop(T)
            if not self.mode:
                forward = not heating
                y = 1.0 - self.xi if forward else self.xi
                v = self.distance(forward, self.xi, T)
                inside_strip = self.kind == "exponential" or v > 1e-12
                if y > 1e-12 and inside_strip and self.waits(forward, T) <= REACHED:
                    self.begin(forward, T)
            t, T = self.leg(t, end, T, times)
        return T

    def stop(self, T: float) -> None:
        """A transformation is interrupted, or complete."""
        if self.kind == "exponential":
            self.lowest = self.distance(self.mode > 0, self.xi, T)
        self.mode = 0

    def leg(self, t: float, end: float, T: float, times: Sequence[float]) -> tuple[float, float]:
        """To the next kink."""
        heating = self.heat(t, self.xi, T) > 0.0
        beyond = STILL * self.hS * (1.0 if heating else -1.0)
        mode, forward = self.mode, (self.mode > 0 if self.mode else not heating)

        def turn(t: float, y: Sequence[float]) -> float:
            return self.heat(t, y[1], y[0]) + beyond

        def done(t: float, y: Sequence[float]) -> float:
            return self.distance(forward, y[1], y[0])

        def starts(t: float, y: Sequence[float]) -> float:
            return self.waits(forward, y[0])

        events: list[Any] = [turn]
        events[0].direction = -1.0 if heating else 1.0
        left = 1.0 - self.xi if forward else self.xi
        if mode and self.kind == "cosine":
            events.append(done)
        elif not mode and left > 1e-12 and self.waits(forward, T) > REACHED:
            events.append(starts)
        for event in events[1:]:
            event.direction = -1.0
        for event in events:
            event.terminal = True
        found = solve_ivp(
            self.rates,
            (t, end),
            [T, self.xi],
            self.method,
            events=events,
            rtol=RTOL,
            atol=ATOL,
            dense_output=True,
            max_step=self.longest,
        )
        stop = found.t[-1]
        while len(self.rows) < len(times) and times[len(self.rows)] <= stop * (1.0 + 1e-12):
            T1, xi = found.sol(min(times[len(self.rows)], stop))
            self.rows.append((T1, xi, self.stress(xi, T1)))
        T, self.xi = found.y[:, -1]
        if mode and self.kind == "cosine" and found.t_events[1].size:
            self.xi = 1.0 if forward else 0.0
            self.mode = 0
        return stop, T
