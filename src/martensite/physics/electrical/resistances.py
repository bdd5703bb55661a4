"""Resistance of a phase mixture.

Resistivities of both phases are parameters because published values disagree even on the sign of their difference.
"""

from martensite.base.interfaces import override
from martensite.base.parameters import Number, param
from martensite.kernels.namespace import Namespace, Scalar
from martensite.physics.electrical.base import RESISTANCES, AbstractResistance, Conductor

RESISTIVITY = 8.4e-7
"""Resistivity of NiTi [ohm m], measured on Flexinol; wires in the sources have 0.8 to 2 times this value."""
CONTRADICTION = 2.0
"""Factor beyond which a resistance contradicts length and cross-section."""


def describe_contradiction(given: float, expected: float, length: float, source: str) -> str:
    """Return a sentence, without a full stop, if a resistance contradicts the wire; else an empty text.

    Args:
        given: resistance per length [ohm/m].
        expected: resistance per length [ohm/m] from a source.
        length: length of the wire [m].
        source: clause about the source of the expected resistance.
    """
    factor = max(given / expected, expected / given)
    if not factor > CONTRADICTION * (1.0 + 1e-9):
        return ""
    side = f"{factor:.3g} times" if given > expected else f"1/{factor:.3g} of"
    return (
        f"{given * length:.3g} ohm contradict {1e3 * length:.4g} mm of this wire: they are {side} the "
        f"{expected * length:.3g} ohm that {source} (limit: a factor of {CONTRADICTION:g}); check diameter, length and "
        "resistance, which excludes leads and contacts"
    )


@RESISTANCES.register("per-length")
class PerLengthResistance(AbstractResistance):
    """Linear mixture of two resistances per metre, as in wire tables; independent of the diameter."""

    r_A: Number = param("ohm/m", "resistance per metre of austenite", above=0.0, high=1e6, typical="20 ohm/m")
    r_M: Number = param("ohm/m", "resistance per metre of martensite", above=0.0, high=1e6, typical="23 ohm/m")

    @override
    def resistance(
        self, xp: Namespace, fraction: Scalar, strain: Scalar, temperature: Scalar, shape: Conductor
    ) -> Scalar:
        return (self.r_A + fraction * (self.r_M - self.r_A)) * shape.length


@RESISTANCES.register("mixture")
class MixtureResistance(AbstractResistance):
    """Linear mixture of two resistivities, R = [ρ_A + ξ (ρ_M - ρ_A)] l/A, at nominal geometry."""

    rho_A: Number = param("ohm*m", "resistivity of austenite", above=0.0, high=1e-4, typical="8e-7 ohm m")
    rho_M: Number = param("ohm*m", "resistivity of martensite", above=0.0, high=1e-4, typical="9e-7 ohm m")

    @override
    def resistance(
        self, xp: Namespace, fraction: Scalar, strain: Scalar, temperature: Scalar, shape: Conductor
    ) -> Scalar:
        return (self.rho_A + fraction * (self.rho_M - self.rho_A)) * (shape.length / shape.area)


@RESISTANCES.register("furst-seelecke")
class FurstSeeleckeResistance(MixtureResistance):
    """Mixture of two temperature-dependent resistivities, in the strained geometry.

        ρ = ξ ρ_M [1 + a_M (T - T_ρ)] + (1 - ξ) ρ_A [1 + a_A (T - T_ρ)]
        R = ρ l (1 + ε)/[A (1 - ν ε)²]

    A stretched wire is longer by 1 + ε and thinner by 1 - ν ε; l and A hold at zero strain, tension is positive.

    Source: Furst and Seelecke (2012), J. Intell. Mater. Syst. Struct. 23, in the form of a publicly posted wire model
    (Ullrich, 2014); the original was not seen.
    """

    cites = ("furst2012", "ullrich2014")

    a_rho_A: Number = param(
        "1/K", "temperature coefficient of the resistivity of austenite", low=-1e-3, high=5e-3, typical="5e-4 1/K"
    )
    a_rho_M: Number = param(
        "1/K", "temperature coefficient of the resistivity of martensite", low=-1e-3, high=5e-3, typical="1e-3 1/K"
    )
    T_rho: Number = param("K", "temperature of both resistivities", low=100.0, high=1000.0, typical="20 degC")
    nu: Number = param("1", "Poisson's ratio", low=0.0, high=0.5, typical=0.33)

    def resistivity(self, xp: Namespace, fraction: Scalar, temperature: Scalar) -> Scalar:
        """Return the resistivity [ohm m] at martensite `fraction` and `temperature` [K]."""
        rise = temperature - self.T_rho
        austenite = self.rho_A * (1.0 + self.a_rho_A * rise)
        martensite = self.rho_M * (1.0 + self.a_rho_M * rise)
        return austenite + fraction * (martensite - austenite)

    @override
    def resistance(
        self, xp: Namespace, fraction: Scalar, strain: Scalar, temperature: Scalar, shape: Conductor
    ) -> Scalar:
        width = 1.0 - self.nu * strain
        stretched = shape.length * (1.0 + strain) / (shape.area * width * width)
        return self.resistivity(xp, fraction, temperature) * stretched


@RESISTANCES.register("three-phase")
class ThreePhaseResistance(FurstSeeleckeResistance):
    """Model `furst-seelecke` with a resistivity of the R-phase.

        ρ = ξ ρ_M [1 + a_M (T - T_ρ)] + ξ_R ρ_R [1 + a_R (T - T_ρ)] + (1 - ξ - ξ_R) ρ_A [1 + a_A (T - T_ρ)]

    It needs a law with an R-phase; otherwise it equals `furst-seelecke`. The R-phase usually has the highest
    resistivity, which causes the bump on cooling; this is not assumed here. The linear mixture is a choice of this
    package.
    """

    three_phases = True

    rho_R: Number = param("ohm*m", "resistivity of the R-phase", above=0.0, high=1e-4, typical="1e-6 ohm m")
    a_rho_R: Number = param(
        "1/K", "temperature coefficient of the resistivity of the R-phase", low=-1e-3, high=5e-3, typical="3e-4 1/K"
    )

    @override
    def mix_phases(
        self, xp: Namespace, fraction: Scalar, rphase: Scalar, strain: Scalar, temperature: Scalar, shape: Conductor
    ) -> Scalar:
        rise = temperature - self.T_rho
        more = self.rho_R * (1.0 + self.a_rho_R * rise) - self.rho_A * (1.0 + self.a_rho_A * rise)
        share = 1.0 + rphase * more / self.resistivity(xp, fraction, temperature)
        return share * self.resistance(xp, fraction, strain, temperature, shape)
