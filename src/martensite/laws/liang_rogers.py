r"""Liang–Rogers law: one martensite fraction, cosine kinetics.

With u = T - σ/C_M and w = T - σ/C_A, forward in M_f < u < M_s, reverse in A_s < w < A_f:

    forward  1 - ξ = (1 - ξ₀) sin²(θ_M/2)/sin²(θ_M0/2),   θ_M = π (u - M_f)/(M_s - M_f)
    reverse      ξ = ξ₀ cos²(θ_A/2)/cos²(θ_A0/2),         θ_A = π (w - A_s)/(A_f - A_s)

which is the ratio form of the published cosines (exact, and free of 0/0 at the strip ends).
Forward needs du < 0, reverse dw > 0: the sign of dT alone never decides. Constitutive
equation in integrated form, so that elastic loops close:

    ε = [σ - Θ (T - T_ref)]/E + ε_L ξ

Source: Liang and Rogers (1990), J. Intell. Mater. Syst. Struct. 1. The history rules
`resume` and `restart` are this package's. Θ > 0 means that a free bar shrinks on heating.
"""

from __future__ import annotations

from martensite.errors import ParameterError
from martensite.laws import history
from martensite.laws.base import LAWS, AbstractLaw, Fractions
from martensite.laws.history import Memory, Move, Strip
from martensite.parameters import option, param
from martensite.runtimes.namespace import Namespace, Scalar


def left(xp: Namespace, distance: Scalar) -> Scalar:
    """What a cosine process leaves to transform at a distance from its finish line."""
    sine = xp.quarter_sine(distance)
    return sine * sine


@LAWS.register("liang-rogers")
class LiangRogers(AbstractLaw):
    """Liang–Rogers kinetics with a constant or ξ-dependent Young's modulus."""

    cites = ("liang1990",)

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
    modulus: str = option(
        "Young's modulus: constant, or the mixture E_A + ξ (E_M - E_A)",
        "austenite", "martensite", "mixture", default="austenite",
    )  # fmt: skip

    def check(self) -> None:
        """Raise `ParameterError` if a strip has no width."""
        for low, high in (("M_f", "M_s"), ("A_s", "A_f")):
            if not getattr(self, low) < getattr(self, high):
                raise ParameterError(
                    f"Parameter `{low}` of `liang-rogers` must be below `{high}`, but is "
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

    def forward(self) -> Strip:
        """The strip of the forward transformation."""
        return Strip(self.M_f, 1.0 / (self.M_s - self.M_f), 1.0 / self.C_M)

    def reverse(self) -> Strip:
        """The strip of the reverse transformation."""
        return Strip(self.A_f, 1.0 / (self.A_s - self.A_f), 1.0 / self.C_A)

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
        strips = self.forward(), self.reverse()
        return history.select(xp, self.history, left, *strips, memory, stress, temperature)

    def follow(
        self, xp: Namespace, move: Move, stress: Scalar, temperature: Scalar, dt: Scalar
    ) -> Fractions:
        """Fractions if the move ends at (stress, temperature); independent of dt."""
        fraction = history.follow(xp, left, move, stress, temperature)
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
        return history.commit(xp, memory, move, fractions.martensite, stress, temperature)

    def kinetics(
        self, xp: Namespace, memory: Memory, stress: Scalar, temperature: Scalar, dt: Scalar
    ) -> tuple[Memory, Fractions]:
        """Advance along a straight leg; both processes may act, one after the other."""
        strips = self.forward(), self.reverse()
        between = history.handover(xp, *strips, memory, stress, temperature)
        halfway, _ = super().kinetics(xp, memory, *between, dt)
        return super().kinetics(xp, halfway, stress, temperature, dt)

    def free_strain(self, xp: Namespace, fractions: Fractions, temperature: Scalar) -> Scalar:
        """ε_L ξ - Θ (T - T_ref)/E [-]."""
        thermal = self.Theta * (temperature - self.T_ref) / self.young(fractions)
        return self.eps_L * fractions.oriented - thermal

    def compliance(self, xp: Namespace, fractions: Fractions) -> Scalar:
        """1/E [1/Pa]."""
        return 1.0 / self.young(fractions)

    def young(self, fractions: Fractions) -> Scalar:
        """Young's modulus [Pa] by the chosen rule."""
        if self.modulus == "mixture":
            return self.E_A + fractions.martensite * (self.E_M - self.E_A)
        return self.E_A if self.modulus == "austenite" else self.E_M

    def crossing(
        self, xp: Namespace, memory: Memory, move: Move, stress: Scalar, temperature: Scalar
    ) -> Scalar:
        """Share of the selected strip crossed by the move [-]."""
        strip = Strip(move.finish, move.per_width, move.per_slope)
        start = strip.distance(memory.stress, memory.temperature)
        crossed = xp.abs(start - strip.distance(stress, temperature))
        return xp.where(xp.abs(move.direction) > 0.0, crossed, 0.0)
