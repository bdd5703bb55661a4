"""Parameters and strain of laws with a phase diagram of straight strips.

The constitutive equation is integrated, so that elastic loops close:

    ε = [σ - Θ (T - T_ref)]/E + ε_L ξ_S

with the oriented fraction ξ_S. Tension and elongation are positive; Θ > 0 means that a free bar shrinks on heating.
"""

from __future__ import annotations

from abc import abstractmethod
from typing import ClassVar, Self

from martensite.base.errors import ParameterError
from martensite.base.interfaces import override
from martensite.base.parameters import Number, Parametrised, option, param
from martensite.kernels.namespace import Namespace, Scalar
from martensite.physics.kinetics.asymmetry import NONE, SIDED_METHODS, by_side
from martensite.physics.kinetics.hardening import LEAST_EXPONENT, MOST_WAIST
from martensite.physics.laws.base import AbstractLaw, Fractions

WIDTHS = (("M_f", "M_s"), ("A_s", "A_f"))
"""Temperatures between which a transformation runs."""


def require_order(law: Parametrised, *pairs: tuple[str, str]) -> None:
    """Raise `ParameterError` unless the first temperature of each pair is the lower one."""
    owner = law.registered_name or type(law).__name__
    for low, high in pairs:
        if not getattr(law, low) < getattr(law, high):
            raise ParameterError(
                f"Parameter `{low}` of `{owner}` must be below `{high}`, but is {getattr(law, low) - 273.15:.4g} degC "
                f"against {getattr(law, high) - 273.15:.4g} degC."
            )


def find_side_strain(xp: Namespace, law: AbstractSidedLaw, name: str, fractions: Fractions) -> Scalar:
    """Return the strain [-] of oriented martensite, with a separate parameter in compression."""
    own = getattr(law, name)
    if law.compression == "asymmetric":
        other = getattr(law, f"{name}_compression")
        own = xp.where(fractions.oriented < 0.0, xp.where(other > 0.0, other, own), own)
    return own * fractions.oriented


class AbstractTwoPhaseLaw(AbstractLaw):
    """Moduli of the phases, and transformation temperatures at zero stress."""

    orders: ClassVar[tuple[tuple[str, str], ...]] = WIDTHS

    E_A: Number = param("Pa", "Young's modulus of austenite", low=1e8, high=3e11, typical="70 GPa")
    E_M: Number = param("Pa", "Young's modulus of martensite", low=1e8, high=3e11, typical="30 GPa")
    A_s: Number = param("K", "austenite start temperature at zero stress", low=100.0, high=1000.0, typical="65 degC")
    A_f: Number = param("K", "austenite finish temperature at zero stress", low=100.0, high=1000.0, typical="75 degC")
    M_s: Number = param("K", "martensite start temperature at zero stress", low=100.0, high=1000.0, typical="50 degC")
    M_f: Number = param("K", "martensite finish temperature at zero stress", low=100.0, high=1000.0, typical="40 degC")

    @property
    def tension_only(self) -> bool:
        """Return True."""
        return True


class AbstractSidedLaw(AbstractTwoPhaseLaw):
    """Tension law with optional compression (`kinetics.asymmetry`)."""

    compression: str = option(
        "what stress below zero does: drives martensite of tension back, or forms its own, by equal or own numbers",
        NONE,
        "symmetric",
        "asymmetric",
        default=NONE,
    )
    C_A_compression: Number = param("Pa/K", "C_A in compression; 0: as in tension", low=0.0, high=1e9, default=0.0)
    C_M_compression: Number = param("Pa/K", "C_M in compression; 0: as in tension", low=0.0, high=1e9, default=0.0)

    sided: ClassVar[tuple[str, ...]] = ("C_A", "C_M")
    """Parameters with a separate value in compression, named `…_compression`."""
    by_ratios: ClassVar[bool] = True
    """True if only ratios of the tension law count in compression; False for both orientations."""
    keeps_forward: ClassVar[bool] = False
    """True if a forward transformation survives a sign change of stress."""

    def __init_subclass__(cls, *, init: bool = True) -> None:
        """Wrap the methods of a tension law for both signs of stress."""
        super().__init_subclass__(init=init)
        for name in SIDED_METHODS.keys() & vars(cls).keys():
            if not getattr(vars(cls)[name], "__isabstractmethod__", False):
                setattr(cls, name, by_side(getattr(cls, name), SIDED_METHODS[name]))

    @property
    def tension_only(self) -> bool:
        """Return True without compression."""
        return self.compression == NONE

    def on_side(self, xp: Namespace, side: Scalar) -> Self:
        """Return the law of tension [+1] or compression [-1] in terms of |σ|."""
        values: dict[str, Scalar] = {}
        for name in self.sided if self.compression == "asymmetric" else ():
            own, other = getattr(self, name), getattr(self, f"{name}_compression")
            values[name] = xp.where(side > 0.0, own, xp.where(other > 0.0, other, own))
        law = self.rebuilt(values)
        law.__dict__["compression"] = NONE
        return law


class AbstractShapes(Parametrised):
    """Parameters of rounded, waisted and curved ranges; options of the laws select them."""

    n_1: Number = param("1", "roundness of the forward start", low=LEAST_EXPONENT, high=1.0, default=1.0)
    n_2: Number = param("1", "roundness of the forward end", low=LEAST_EXPONENT, high=1.0, default=1.0)
    n_3: Number = param("1", "roundness of the reverse end", low=LEAST_EXPONENT, high=1.0, default=1.0)
    n_4: Number = param("1", "roundness of the reverse start", low=LEAST_EXPONENT, high=1.0, default=1.0)
    waist_f: Number = param(
        "1", "waist of the forward range, if waisted", low=0.0, high=MOST_WAIST, default=0.0, typical=0.8
    )
    waist_r: Number = param(
        "1", "waist of the reverse range, if waisted", low=0.0, high=MOST_WAIST, default=0.0, typical=0.9
    )
    curvature_f: Number = param("K/Pa^2", "bend of the forward line, if curved", low=-1e-14, high=1e-14, default=0.0)
    curvature_r: Number = param("K/Pa^2", "bend of the reverse line, if curved", low=-1e-14, high=1e-14, default=0.0)
    widening_f: Number = param("K/Pa", "growth of the forward range, if curved", low=0.0, high=1e-6, default=0.0)
    widening_r: Number = param("K/Pa", "growth of the reverse range, if curved", low=0.0, high=1e-6, default=0.0)

    def describe_unused(self, hardening: str, surfaces: str) -> list[str]:
        """Return sentences about parameters that these options do not use."""
        sentences: list[str] = []
        if hardening != "waisted" and max(self.waist_f, self.waist_r) > 0.0:
            sentences.append('A waist counts only with the option `hardening = "waisted"` of the law.')
        if surfaces != "curved" and any((self.curvature_f, self.curvature_r, self.widening_f, self.widening_r)):
            sentences.append('A curvature or widening counts only with the option `surfaces = "curved"` of the law.')
        return sentences


class AbstractPhaseDiagram(AbstractTwoPhaseLaw):
    """Strips shifted by stress; subclasses choose Young's modulus."""

    eps_L: Number = param("1", "maximum recoverable strain", above=0.0, high=0.2, typical=0.04)
    C_A: Number = param("Pa/K", "Clausius–Clapeyron slope of the reverse strip", low=1e5, high=1e9, typical="8 MPa/K")
    C_M: Number = param("Pa/K", "Clausius–Clapeyron slope of the forward strip", low=1e5, high=1e9, typical="8 MPa/K")
    Theta: Number = param("Pa/K", "thermoelastic modulus; -E times the expansion", low=-1e7, high=1e7, default=0.0)
    T_ref: Number = param("K", "temperature of zero thermal strain", low=0.0, high=1000.0, default=293.15)
    history: str = option(
        "what happens to an interrupted transformation", "resume", "restart", "return-point", default="resume"
    )

    @abstractmethod
    def young(self, fractions: Fractions) -> Scalar:
        """Return Young's modulus [Pa]."""

    def mixture(self, fractions: Fractions) -> Scalar:
        """Return E_A + ξ (E_M - E_A) [Pa]."""
        return self.E_A + fractions.martensite * (self.E_M - self.E_A)

    @override
    def check(self) -> None:
        require_order(self, *WIDTHS)

    def cautions(self) -> list[str]:
        """Return a caution about the sign of Θ; laws add cautions about strips."""
        return ["Theta > 0: a free bar shrinks on heating (the expansion enters as -E α)."] * (self.Theta > 0.0)

    def free_strain(self, xp: Namespace, fractions: Fractions, temperature: Scalar) -> Scalar:
        """Return ε_L ξ_S - Θ (T - T_ref)/E [-]."""
        thermal = self.Theta * (temperature - self.T_ref) / self.young(fractions)
        return self.transformation_strain(xp, fractions) - thermal

    def transformation_strain(self, xp: Namespace, fractions: Fractions) -> Scalar:
        """Return ε_L ξ_S [-]."""
        return self.eps_L * fractions.oriented

    @override
    def compliance(self, xp: Namespace, fractions: Fractions) -> Scalar:
        return 1.0 / self.young(fractions)


class AbstractSidedDiagram(AbstractPhaseDiagram, AbstractSidedLaw):
    """Phase diagram with optional compression."""

    eps_L_compression: Number = param("1", "eps_L in compression; 0: as in tension", low=0.0, high=0.2, default=0.0)
    H_min: Number = param("1", "two-way strain: of martensite formed at no stress", low=-0.2, high=0.2, default=0.0)

    @override
    def check(self) -> None:
        super().check()
        if self.compression == NONE:
            return
        self.__dict__.update(twins=True, one_way=False)  # the oriented fraction changes separately
        if self.history == "return-point":
            raise ParameterError('`compression` knows no return points; take `history = "resume"` or `"restart"`.')
        if abs(self.H_min) > self.eps_L:
            raise ParameterError(
                f"Parameter `H_min` must not exceed `eps_L`, but is {self.H_min} against {self.eps_L}."
            )

    def transformation_strain(self, xp: Namespace, fractions: Fractions) -> Scalar:
        """Return ε_L ξ_S [-] with ε_L of the sign of stress."""
        return find_side_strain(xp, self, "eps_L", fractions)
