"""What laws with one martensite fraction and two transformation strips have in common.

With u = T - σ/C_M and w = T - σ/C_A, forward (austenite → martensite) runs in M_f < u < M_s for
du < 0 and reverse in A_s < w < A_f for dw > 0: the sign of dT alone never decides. Constitutive
equation in integrated form, so that elastic loops close:

    ε = [σ - Θ (T - T_ref)]/E + ε_L ξ

A law says what a process leaves to transform at a distance from its finish line, and Young's
modulus. The history rules are those of `martensite.laws.shared.history`. Tension and elongation are
positive; all martensite counts as oriented. Θ > 0 means that a free bar shrinks on heating.
"""

from __future__ import annotations

from typing import ClassVar

from martensite.errors import ParameterError
from martensite.laws.base import AbstractLaw, Fractions
from martensite.laws.shared import history
from martensite.laws.shared.history import Memory, Move, Strip
from martensite.parameters import option, param
from martensite.runtimes.namespace import Namespace, Scalar


def cosine(xp: Namespace, distance: Scalar) -> Scalar:
    """What a cosine process leaves to transform at a distance from its finish line."""
    sine = xp.quarter_sine(distance)
    return sine * sine


class AbstractStripLaw(AbstractLaw):
    """Two strips, one fraction; a law adds `left`, `young` and its options."""

    endless: ClassVar[bool] = False
    """True if processes go on beyond their finish lines and forget where they began."""

    E_A: Scalar = param("Pa", "Young's modulus of austenite", low=1e8, high=3e11)
    E_M: Scalar = param("Pa", "Young's modulus of martensite", low=1e8, high=3e11)
    eps_L: Scalar = param("1", "maximum recoverable strain", above=0.0, high=0.2)
    A_s: Scalar = param("K", "austenite start temperature at zero stress", low=100.0, high=1000.0)
    A_f: Scalar = param("K", "austenite finish temperature at zero stress", low=100.0, high=1000.0)
    M_s: Scalar = param("K", "martensite start temperature at zero stress", low=100.0, high=1000.0)
    M_f: Scalar = param("K", "martensite finish temperature at zero stress", low=100.0, high=1000.0)
    C_A: Scalar = param("Pa/K", "Clausius–Clapeyron slope of the reverse strip", low=1e5, high=1e9)
    C_M: Scalar = param("Pa/K", "Clausius–Clapeyron slope of the forward strip", low=1e5, high=1e9)
    Theta: Scalar = param(
        "Pa/K", "thermoelastic modulus; -E times the expansion", low=-1e7, high=1e7, default=0.0
    )
    T_ref: Scalar = param(
        "K", "temperature of zero thermal strain", low=0.0, high=1000.0, default=293.15
    )
    history: str = option(
        "what happens to an interrupted transformation", "resume", "restart", default="resume"
    )

    # ---------------------------------------------------------------- what a law adds

    def left(self, xp: Namespace, distance: Scalar) -> Scalar:
        """What a process leaves at a distance from its finish line, as a share of all [-].

        The distance is 1 on the start line and 0 on the finish line. Endless processes are
        asked below 0 too and must fulfil left(a)/left(b) = left(1 - (b - a)).
        """
        raise NotImplementedError

    def young(self, fractions: Fractions) -> Scalar:
        """Young's modulus [Pa]."""
        raise NotImplementedError

    # ---------------------------------------------------------------- values

    def check(self) -> None:
        """Raise `ParameterError` if a strip has no width."""
        for low, high in (("M_f", "M_s"), ("A_s", "A_f")):
            if not getattr(self, low) < getattr(self, high):
                owner = self.registered_name or type(self).__name__
                raise ParameterError(
                    f"Parameter `{low}` of `{owner}` must be below `{high}`, but is "
                    f"{getattr(self, low) - 273.15:.4g} degC against "
                    f"{getattr(self, high) - 273.15:.4g} degC."
                )

    def cautions(self) -> list[str]:
        """Unusual orders of temperatures, loops that would create work, the sign of Θ."""
        found: list[str] = []
        if self.Theta > 0.0:
            found.append("Theta > 0: a free bar shrinks on heating (the expansion enters as -E α).")
        if self.A_s < self.M_s:
            found.append("A_s is below M_s: the strips overlap at zero stress already.")
        elif self.C_A > self.C_M:
            limit = (self.A_s - self.M_s) / (1.0 / self.C_M - 1.0 / self.C_A)
            found.append(
                f"C_A > C_M: the strips overlap above {limit / 1e6:.4g} MPa, where the loop "
                "work shrinks with temperature; prefer equal slopes there."
            )
        return found

    # ---------------------------------------------------------------- kinetics

    def strips(self) -> tuple[Strip, Strip]:
        """The strips of the forward and of the reverse transformation."""
        return (
            Strip(self.M_f, 1.0 / (self.M_s - self.M_f), 1.0 / self.C_M, self.endless),
            Strip(self.A_f, 1.0 / (self.A_s - self.A_f), 1.0 / self.C_A, self.endless),
        )

    def init(
        self, xp: Namespace, fractions: Fractions, stress: Scalar, temperature: Scalar
    ) -> Memory:
        """Memory of a wire that has no history; all martensite counts as oriented."""
        return Memory(fractions.martensite, 0.0, 0.0, stress, temperature)

    def fractions(self, memory: Memory) -> Fractions:
        """All martensite counts as oriented."""
        return Fractions(memory.fraction, memory.fraction)

    def select(self, xp: Namespace, memory: Memory, stress: Scalar, temperature: Scalar) -> Move:
        """The process set off by a straight move to (stress [Pa], temperature [K])."""
        rule = self.history
        return history.select(xp, rule, self.left, *self.strips(), memory, stress, temperature)

    def follow(
        self, xp: Namespace, move: Move, stress: Scalar, temperature: Scalar, dt: Scalar
    ) -> Fractions:
        """Fractions if the move ends at (stress, temperature); independent of dt."""
        fraction = history.follow(xp, self.left, move, stress, temperature, self.endless)
        return Fractions(fraction, fraction)

    def commit(
        self,
        xp: Namespace,
        memory: Memory,
        move: Move,
        fractions: Fractions,
        stress: Scalar,
        temperature: Scalar,
        dt: Scalar,
    ) -> Memory:
        """The memory after the accepted move."""
        fraction = fractions.martensite
        return history.commit(xp, memory, move, fraction, stress, temperature, self.endless)

    def kinetics(
        self, xp: Namespace, memory: Memory, stress: Scalar, temperature: Scalar, dt: Scalar
    ) -> tuple[Memory, Fractions]:
        """Advance along a straight leg; both processes may act, one after the other."""
        for _ in range(2 if self.endless else 1):
            between = history.handover(xp, *self.strips(), memory, stress, temperature)
            memory, _ = super().kinetics(xp, memory, *between, dt)
        return super().kinetics(xp, memory, stress, temperature, dt)

    def crossing(
        self, xp: Namespace, memory: Memory, move: Move, stress: Scalar, temperature: Scalar
    ) -> Scalar:
        """Share of the selected strip crossed by the move [-]; tails do not count."""
        start = move.distance(memory.stress, memory.temperature)
        end = move.distance(stress, temperature)
        if self.endless:
            start, end = xp.clip(start, 0.0, 1.0), xp.clip(end, 0.0, 1.0)
        return xp.where(xp.abs(move.direction) > 0.0, xp.abs(start - end), 0.0)

    # ---------------------------------------------------------------- strain

    def free_strain(self, xp: Namespace, fractions: Fractions, temperature: Scalar) -> Scalar:
        """ε_L ξ - Θ (T - T_ref)/E [-]."""
        thermal = self.Theta * (temperature - self.T_ref) / self.young(fractions)
        return self.eps_L * fractions.oriented - thermal

    def compliance(self, xp: Namespace, fractions: Fractions) -> Scalar:
        """1/E [1/Pa]."""
        return 1.0 / self.young(fractions)
