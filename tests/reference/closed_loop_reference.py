"""One-page closed loop of the benchmark of control, written from the equations; shares no code with the march.

Wire (Liang-Rogers, memory `resume`) on a bias spring, heated by a switched voltage, under a sampled PID controller:

    M c dT/dt = u U²/R(ξ) - h A_s (T - T_a) + M λ dξ/dt,        R = (ρ_A + ξ (ρ_M - ρ_A)) l/A
    σ = E(ξ) (ε - ε_L ξ),  E = E_A + ξ (E_M - E_A),             A σ = F₀ + k x,  ε = ε₀ - x/l

ξ follows from T alone within a period, in which T moves one way: H = M (c T - λ ξ) is integrated by SciPy, and ξ(H) is
the root of one equation. The controller reads round((x + s n)/q) q of the period before.
"""

import math
from typing import Any

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import brentq


class Wire:
    """Numbers in SI, by the paths of the plant, and the state T, ξ, branch, progress."""

    def __init__(self, p: dict[str, float]) -> None:
        self.p = p
        d, self.l = p["element.diameter"], p["element.length"]
        self.area, self.skin = 0.25 * math.pi * d * d, math.pi * d * self.l
        mass = p["element.density"] * self.area * self.l
        self.C, self.L = mass * p["element.heat_capacity"], mass * p["element.latent_heat"]
        self.strain = self.stress0() / p["element.law.E_M"] + p["element.law.eps_L"]  # at rest, ξ = 1
        self.T, self.xi, self.branch, self.left = p["environment.temperature"], 1.0, "", 1.0  # 1 - P of the branch
        self.before = self.T, self.stress(1.0)

    def stress0(self) -> float:
        return self.p["mechanism.preload"] / self.area

    def stress(self, xi: float) -> float:
        E = self.p["element.law.E_A"] + xi * (self.p["element.law.E_M"] - self.p["element.law.E_A"])
        k = self.p["mechanism.stiffness"] * self.l / self.area  # σ = σ₀ + k (ε₀ - ε), ε = σ/E + ε_L ξ
        return (self.stress0() + k * (self.strain - self.p["element.law.eps_L"] * xi)) / (1.0 + k / E)

    def position(self) -> float:
        return (self.stress(self.xi) - self.stress0()) * self.area / self.p["mechanism.stiffness"]

    def unchanged(self, process: str, T: float, sigma: float) -> float:
        """1 - p of the forward (F) or reverse (R) process."""
        law = {name: self.p[f"element.law.{name}"] for name in ("A_s", "A_f", "M_s", "M_f", "C_A", "C_M")}
        if process == "F":
            share = (T - sigma / law["C_M"] - law["M_f"]) / (law["M_s"] - law["M_f"])
        else:
            share = (law["A_f"] - T + sigma / law["C_A"]) / (law["A_f"] - law["A_s"])
        return math.sin(0.5 * math.pi * min(max(share, 0.0), 1.0)) ** 2

    def fraction(self, process: str, T: float, xi: float, start: tuple[float, float]) -> float:
        """ξ that a process has reached at T, if the stress is that at ξ."""
        before = self.left if self.branch == process else self.unchanged(process, *start)
        share = min(self.unchanged(process, T, self.stress(xi)) / before, 1.0) if before > 0.0 else 1.0
        return self.xi * share if process == "R" else 1.0 - (1.0 - self.xi) * share

    def solve(self, H: float) -> tuple[float, str]:
        """ξ at an enthalpy, and what acts."""
        T = (H + self.L * self.xi) / self.C
        process = "R" if self.T < T else "F"
        there = self.fraction(process, T, self.xi, self.before)
        if abs(there - self.xi) < 1e-14:
            return self.xi, ""
        ends = (0.0, self.xi) if process == "R" else (self.xi, 1.0)

        def gap(xi: float) -> float:
            return xi - self.fraction(process, (H + self.L * xi) / self.C, xi, self.before)

        if gap(ends[0]) * gap(ends[1]) > 0.0:
            return min(ends, key=lambda end: abs(gap(end))), process
        root: Any = brentq(gap, *ends, xtol=1e-12)
        return float(root), process

    def heat(self, duty: float, dt: float) -> None:
        """One period under a duty."""
        p = self.p

        def slope(_: float, y: Any) -> list[float]:
            xi = self.solve(y[0])[0]
            R = (p["element.resistance.rho_A"] * (1.0 - xi) + p["element.resistance.rho_M"] * xi) * self.l / self.area
            T = (y[0] + self.L * xi) / self.C
            loss = p["environment.cooling.h"] * self.skin * (T - p["environment.temperature"])
            return [duty * p["source.supply"] ** 2 / R - loss]

        H = self.C * self.T - self.L * self.xi
        H = float(solve_ivp(slope, (0.0, dt), [H], method="RK23", rtol=1e-6, atol=1e-9).y[0, -1])
        xi, process = self.solve(H)
        T = (H + self.L * xi) / self.C
        if process:
            now = self.unchanged(process, T, self.stress(xi))
            self.left = min(self.left, now) if self.branch == process else now
            self.branch = process
        self.T, self.xi, self.before = T, xi, (T, self.stress(xi))


def run_loop(wire: Wire, gains: tuple[float, float, float], reference: Any, noise: Any, dt: float, read: Any) -> Any:
    """Positions after every period; `read`: deviation and step of a reading [m]; the noise is standard normal."""
    Kp, Ki, Kd = gains
    lag = max(Kd / Kp / 10.0, dt)
    integral = change = 0.0
    made, found = wire.position() + read[0] * noise[0], np.empty(len(reference))
    arriving = made = round(made / read[1]) * read[1]
    before, found[0] = reference[0] - made, wire.position()
    duty = min(max(Kp * before, 0.0), 1.0)
    for k in range(1, len(reference)):
        wire.heat(duty, dt)
        found[k] = wire.position()
        arriving, made = made, round((found[k] + read[0] * noise[k]) / read[1]) * read[1]
        error = reference[k] - arriving
        change += (error - before - dt * change) / (dt + lag)
        wanted, added = Kp * error + integral + Ki * error * dt + Kd * change, Ki * error * dt
        if not (wanted > 1.0 and added > 0.0) and not (wanted < 0.0 and added < 0.0):
            integral += added
        before, duty = error, min(max(wanted, 0.0), 1.0)
    return found
