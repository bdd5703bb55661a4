"""Law with an R-phase between austenite and martensite: two transformations with the kinetics of Liang and Rogers.

    ξ   martensite fraction                           T - σ/C_M from M_s to M_f, T - σ/C_A from A_s to A_f
    ρ   R-phase fraction of the rest                  T - σ/C_R from R_s to R_f, and back dT_R higher

so that ξ_R = ρ (1 - ξ). Martensite takes from austenite and R in proportion, which keeps ρ, and reverts into the phase
that is stable there: R below its strips, austenite above. C_R is two to three times C_M, so that the start lines meet
at a stress beyond which martensite forms first and little austenite remains for R.

    ε = [σ - Θ (T - T_ref)]/E + ε_L ξ + ε_R ξ_R,     E = E_A + ξ (E_M - E_A) + ξ_R (E_R - E_A)

All R-phase and all martensite count as oriented. By Clausius and Clapeyron the latent heat of A → R would be the
fraction C_R ε_R/(C_M ε_L) of the whole; it is a parameter. ε grows with ξ and ρ, and both lag behind the stress, so an
isothermal loop creates work only if the strips of martensite overlap.
"""

from typing import NamedTuple

from martensite.base.errors import ParameterError
from martensite.base.interfaces import override
from martensite.base.parameters import Number, param
from martensite.base.units import DEGREES
from martensite.kernels.namespace import Namespace, Scalar
from martensite.physics.kinetics import history
from martensite.physics.kinetics.diagram import WIDTHS, AbstractPhaseDiagram, require_order
from martensite.physics.kinetics.history import OneFractionMemory, OneFractionProcess
from martensite.physics.kinetics.strips import AbstractCosineLaw
from martensite.physics.laws.base import LAWS, Doubt, Fork, Fractions, RPhaseFractions


class RPhaseMemory(NamedTuple):
    """Memory of both transformations."""

    martensite: OneFractionMemory
    rphase: OneFractionMemory
    """Memory of ρ."""

    @property
    def stress(self) -> Scalar:
        """Return the stress of the last accepted point [Pa]."""
        return self.martensite.stress

    @property
    def temperature(self) -> Scalar:
        """Return the temperature of the last accepted point [K]."""
        return self.martensite.temperature


class RPhaseMove(NamedTuple):
    """Process of each transformation."""

    martensite: OneFractionProcess
    rphase: OneFractionProcess


class CosineStrips(AbstractCosineLaw):
    """One transformation of a law with two."""


@LAWS.register("r-phase")
class RPhase(AbstractPhaseDiagram):
    """Liang–Rogers kinetics for martensite and, with narrow steep strips, for the R-phase.

    Facts on the R-phase are recalled (review: Otsuka and Ren, 2005). Of the paper that demands three fractions in
    actuator models (2026), only the abstract was read. The interaction of the two transformations is an assumption of
    this package.
    """

    cites = ("liang1990", "otsuka2005", "rphase2026")
    orders = (*WIDTHS, ("R_f", "R_s"))
    has_rphase = True
    one_way = False

    R_s: Number = param(
        "K", "R-phase start temperature on cooling at zero stress", low=100.0, high=1e3, typical="57 degC"
    )
    R_f: Number = param(
        "K", "R-phase finish temperature on cooling at zero stress", low=100.0, high=1e3, typical="52 degC"
    )
    dT_R: Number = param(DEGREES, "hysteresis of the R-phase", low=0.0, high=50.0, typical="3 K")
    C_R: Number = param("Pa/K", "Clausius–Clapeyron slope of the R-phase", low=1e5, high=1e9, typical="17 MPa/K")
    eps_R: Number = param("1", "transformation strain of the R-phase", low=0.0, high=0.05, typical=0.007)
    E_R: Number = param("Pa", "Young's modulus of the R-phase", low=1e8, high=3e11, typical="45 GPa")
    latent_R: Number = param(
        "1", "latent heat of the R-phase as a share of that of martensite", low=0.0, high=1.0, typical=0.25
    )

    @override
    def check(self) -> None:
        super().check()
        require_order(self, ("R_f", "R_s"))
        if not self.eps_R < self.eps_L:
            words = f"must be below `eps_L`, but is {self.eps_R:.4g} against {self.eps_L:.4g}."
            raise ParameterError(f"Parameter `eps_R` of `{self.registered_name}` {words}")

    @override
    def cautions(self) -> list[str]:
        cautions = self.whole().cautions()
        if self.M_s >= self.R_s:
            cautions.append(
                "M_s is not below R_s: martensite forms first, and little R-phase or none is seen on cooling."
            )
        return cautions

    @override
    def doubt(self) -> Doubt | None:
        return self.whole().doubt()

    def highest_stress(self) -> Scalar:
        """Return the stress [Pa] beyond which martensite forms before the R-phase."""
        return (self.R_s - self.M_s) / (1.0 / self.C_M - 1.0 / self.C_R)

    def whole(self) -> CosineStrips:
        """Return the law of martensite."""
        law, own = object.__new__(CosineStrips), self.__dict__
        law.__dict__.update({name: own.get(name, one.default) for name, one in CosineStrips.declarations.items()})
        return law

    def parent(self) -> CosineStrips:
        """Return the law of ρ, as if R were its martensite."""
        law, back = self.whole(), {"A_s": self.R_f + self.dT_R, "A_f": self.R_s + self.dT_R}
        return law.rebuilt(back | {"M_s": self.R_s, "M_f": self.R_f, "C_A": self.C_R, "C_M": self.C_R})

    @override
    def init(self, xp: Namespace, fractions: Fractions, stress: Scalar, temperature: Scalar) -> RPhaseMemory:
        at, parent = (stress, temperature), self.parent()
        share = 1.0 - parent.remaining_fraction(xp, xp.clip(parent.strips()[0].distance(*at), 0.0, 1.0))
        own = self.whole().init(xp, fractions, *at)
        return RPhaseMemory(own, parent.init(xp, Fractions(share, share), *at))

    def relocate(
        self, xp: Namespace, memory: RPhaseMemory, fractions: Fractions, stress: Scalar, temperature: Scalar
    ) -> RPhaseMemory:
        """Return the memory at another point; branches continue, and ρ follows its curve."""
        at, parent, before = (stress, temperature), self.parent(), memory.rphase
        forward, reverse = parent.strips()
        cools = before.branch >= 0.0
        was, now = (
            parent.remaining_fraction(
                xp, xp.clip(xp.where(cools, forward.distance(*one), reverse.distance(*one)), 0.0, 1.0)
            )
            for one in ((memory.stress, memory.temperature), at)
        )
        share = xp.clip(before.fraction + xp.where(cools, was - now, now - was), 0.0, 1.0)
        own = self.whole().relocate(xp, memory.martensite, fractions, *at)
        return RPhaseMemory(own, parent.relocate(xp, before, Fractions(share, share), *at))

    @override
    def find_forgotten_change(self, memory: RPhaseMemory) -> Scalar | None:
        own = self.whole().find_forgotten_change(memory.martensite)
        more = self.parent().find_forgotten_change(memory.rphase)
        return None if own is None or more is None else max(own, more)

    def fractions(self, memory: RPhaseMemory) -> RPhaseFractions:
        """Return ξ, ξ and ρ."""
        return RPhaseFractions(*self.whole().fractions(memory.martensite), memory.rphase.fraction)

    @override
    def select(self, xp: Namespace, memory: RPhaseMemory, stress: Scalar, temperature: Scalar) -> RPhaseMove:
        at = stress, temperature
        return RPhaseMove(self.whole().select(xp, memory.martensite, *at), self.parent().select(xp, memory.rphase, *at))

    @override
    def follow(
        self, xp: Namespace, move: RPhaseMove, stress: Scalar, temperature: Scalar, dt: Scalar
    ) -> RPhaseFractions:
        at = stress, temperature, dt
        share = self.parent().follow(xp, move.rphase, *at).martensite
        return RPhaseFractions(*self.whole().follow(xp, move.martensite, *at), share)

    @override
    def commit(
        self,
        xp: Namespace,
        memory: RPhaseMemory,
        move: RPhaseMove,
        fractions: Fractions,
        stress: Scalar,
        temperature: Scalar,
        dt: Scalar,
    ) -> RPhaseMemory:
        at, share = (stress, temperature, dt), Fractions(fractions.rphase, fractions.rphase)
        pairs = zip(memory, move, strict=True)
        first, second = (history.drop_idle_move(xp, one, its, stress, temperature) for one, its in pairs)
        own = self.whole().commit(xp, memory.martensite, first, fractions, *at)
        return RPhaseMemory(own, self.parent().commit(xp, memory.rphase, second, share, *at))

    def kinetics(
        self, xp: Namespace, memory: RPhaseMemory, stress: Scalar, temperature: Scalar, dt: Scalar
    ) -> tuple[RPhaseMemory, Fractions]:
        """Advance along a straight leg; martensite may have two processes in succession, the R-phase one."""
        between = history.find_handover(xp, *self.whole().strips(), memory.martensite, stress, temperature)
        memory, _ = super().kinetics(xp, memory, *between, dt)
        return super().kinetics(xp, memory, stress, temperature, dt)

    def young(self, fractions: Fractions) -> Scalar:
        """Return E_A + ξ (E_M - E_A) + ξ_R (E_R - E_A) [Pa]."""
        return self.mixture(fractions) + fractions.rphase_fraction * (self.E_R - self.E_A)

    def transformation_strain(self, xp: Namespace, fractions: Fractions) -> Scalar:
        """Return ε_L ξ + ε_R ξ_R [-]."""
        return super().transformation_strain(xp, fractions) + self.eps_R * fractions.rphase_fraction

    @override
    def released_fraction(self, fractions: Fractions) -> Scalar:
        return fractions.martensite + self.latent_R * fractions.rphase_fraction

    @override
    def kinks(self, xp: Namespace, memory: RPhaseMemory) -> list[Scalar]:
        return [*self.whole().kinks(xp, memory.martensite), *self.parent().kinks(xp, memory.rphase)]

    @override
    def forks(self, xp: Namespace, memory: RPhaseMemory) -> list[Fork]:
        return [*self.whole().forks(xp, memory.martensite), *self.parent().forks(xp, memory.rphase)]

    @override
    def crossing(
        self, xp: Namespace, memory: RPhaseMemory, move: RPhaseMove, stress: Scalar, temperature: Scalar
    ) -> Scalar:
        own = self.whole().crossing(xp, memory.martensite, move.martensite, stress, temperature)
        return xp.maximum(own, self.parent().crossing(xp, memory.rphase, move.rphase, stress, temperature))
