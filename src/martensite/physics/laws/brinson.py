"""Brinson law: detwinned and twinned martensite, cosine kinetics, admissible dual region.

ξ = ξ_S + ξ_T. Stress forms ξ_S from austenite and twinned martensite, cooling forms ξ_T from austenite, heating reverts
both in proportion. With s = σ - C_M max(T - M_s, 0):

    S  ds > 0   1 - p = cos²(φ/2),  φ = π (s - σ_s)/(σ_f - σ_s)
    T  dT < 0   1 - p = sin²(ψ/2),  ψ = π (T - M_f)/(M_s - M_f)
    R  dw > 0   1 - p = cos²(θ/2),  θ = π (w - A_s)/(A_f - A_s),   w = T - σ/C_A

Each process multiplies the remaining fraction by its (1 - P₁)/(1 - P₀); S and T together by the product (see
`two_fractions`), which keeps ξ ≤ 1, unlike the published sum. Integrated constitutive equation:

    ε = [σ - Θ (T - T_ref)]/E(ξ) + ε_L ξ_S,   E(ξ) = E_A + ξ (E_M - E_A)

Sources: Brinson (1993), J. Intell. Mater. Syst. Struct. 4; for the dual region Chung, Heo and Lee (2007), Smart Mater.
Struct. 16. Ratio form and history rules are this package's. Tension positive; Θ > 0 means that a free bar shrinks on
heating.
"""

from martensite.base.errors import ParameterError
from martensite.base.interfaces import override
from martensite.base.parameters import Number, param
from martensite.kernels import floats
from martensite.kernels.namespace import Namespace, Scalar
from martensite.physics.kinetics import two_fraction_legs, two_fractions
from martensite.physics.kinetics.asymmetry import NONE
from martensite.physics.kinetics.diagram import WIDTHS, AbstractSidedDiagram
from martensite.physics.kinetics.strip_legs import Strip, compute_cosine_rest
from martensite.physics.kinetics.two_fraction_legs import Diagram, TwoFractionMemory
from martensite.physics.kinetics.two_fractions import TwoFractionDirection
from martensite.physics.laws.base import LAWS, Doubt, Fork, Fractions

PIECES = 3
"""Largest number of processes on a leg: S, reverse and T in some order."""


@LAWS.register("brinson")
class Brinson(AbstractSidedDiagram):
    """Brinson kinetics with two martensite fractions and a ξ-dependent Young's modulus."""

    cites = ("brinson1993", "chung2007")
    orders = (*WIDTHS, ("sigma_s", "sigma_f"))
    has_twins = True
    one_way = False

    sigma_s: Number = param("Pa", "start stress of detwinning below M_s", above=0.0, high=1e10, typical="80 MPa")
    sigma_f: Number = param("Pa", "finish stress of detwinning below M_s", above=0.0, high=1e10, typical="150 MPa")

    sigma_s_compression: Number = param(
        "Pa", "sigma_s in compression; 0: as in tension", low=0.0, high=1e10, default=0.0
    )
    sigma_f_compression: Number = param(
        "Pa", "sigma_f in compression; 0: as in tension", low=0.0, high=1e10, default=0.0
    )
    sided = (*AbstractSidedDiagram.sided, "sigma_s", "sigma_f")

    @override
    def check(self) -> None:
        super().check()
        for side in (1.0, -1.0):
            law = self.on_side(floats, side)
            if not law.sigma_s < law.sigma_f:
                raise ParameterError(
                    f"Parameter `sigma_s` of `brinson` must be below `sigma_f`, but is {law.sigma_s / 1e6:.4g} MPa "
                    f"against {law.sigma_f / 1e6:.4g} MPa{' in compression' if side < 0.0 else ''}."
                )

    @override
    def cautions(self) -> list[str]:
        cautions = super().cautions()
        if self.A_s < self.M_s:
            cautions.append("A_s is below M_s: cooling and heating transform at the same temperature.")
        return cautions

    @override
    def doubt(self) -> Doubt | None:
        if not self.C_A > self.C_M:
            return None
        return Doubt(
            self.overlap(),
            f"C_A > C_M: the strips overlap above {self.overlap() / 1e6:.4g} MPa, and a loop at constant temperature "
            f"creates work above {self.workless() - 273.15:.4g} degC; prefer equal slopes there.",
        )

    def overlap(self) -> Scalar:
        """Return the stress [Pa] at which the start lines of S and reverse meet."""
        ends = self.sigma_s + self.C_A * self.A_s - self.C_M * self.M_s
        return max(self.sigma_s, self.C_A * (ends / (self.C_A - self.C_M) - self.A_s))

    def workless(self) -> Scalar:
        """Return the temperature [K] at which a full isothermal loop does no work at constant modulus."""
        ends = 0.5 * (self.sigma_s + self.sigma_f) + 0.5 * self.C_A * (self.A_s + self.A_f)
        return (ends - self.C_M * self.M_s) / (self.C_A - self.C_M)

    def diagram(self) -> Diagram:
        """Return the strips of the three processes."""
        per_slope = 1.0 / self.C_M
        width = self.sigma_f - self.sigma_s
        return Diagram(
            loading=Strip(self.M_s - self.sigma_f * per_slope, self.C_M / width, per_slope),
            cooling=Strip(self.M_f, 1.0 / (self.M_s - self.M_f), 0.0),
            reverse=Strip(self.A_f, 1.0 / (self.A_s - self.A_f), 1.0 / self.C_A),
            bend=self.M_s,
        )

    def reverse_strip(self) -> Strip:
        """Return the reverse strip."""
        return self.diagram().reverse

    def find_stop(
        self, xp: Namespace, memory: TwoFractionMemory, stress: Scalar, temperature: Scalar
    ) -> tuple[Scalar, Scalar]:
        """Return the point of a leg where the direction may change; else its end."""
        courses = two_fraction_legs.follow_all_strips(xp, self.diagram(), memory, stress, temperature)
        return two_fraction_legs.find_handover(xp, courses, memory, stress, temperature)

    def compare_rests(self, xp: Namespace, distance: Scalar, reach: Scalar) -> Scalar:
        """Return the fraction that reverse transformation leaves between two distances."""
        return two_fractions.compute_rest_ratio(xp, reach, distance)

    def find_rests(self, xp: Namespace, stress: Scalar, temperature: Scalar) -> tuple[Scalar, Scalar]:
        """Return the fractions that S, and S and T, leave at a point reached by cooling [-]."""
        diagram = self.diagram()
        places = (diagram.loading, xp.maximum(temperature, diagram.bend)), (diagram.cooling, temperature)
        distances = (xp.clip(strip.distance(stress, kelvin), 0.0, 1.0) for strip, kelvin in places)
        loading, cooling = (compute_cosine_rest(xp, v) for v in distances)
        return loading, loading * cooling

    def orient_martensite(self, xp: Namespace, side: Scalar, *_: object) -> tuple[Scalar, Scalar]:
        """Return the oriented fractions [-] of S and T: 1 and H_min/ε_L along tension."""
        return 1.0, side * self.H_min / self.eps_L

    def init(self, xp: Namespace, fractions: Fractions, stress: Scalar, temperature: Scalar) -> TwoFractionMemory:
        """Return the memory of a phase state without history; needs 0 ≤ ξ_S ≤ ξ ≤ 1."""
        return two_fractions.start_memory(self.history, fractions, stress, temperature)

    @override
    def relocate(
        self, xp: Namespace, memory: TwoFractionMemory, fractions: Fractions, stress: Scalar, temperature: Scalar
    ) -> TwoFractionMemory:
        return two_fractions.relocate_memory(xp, self.diagram(), memory, fractions, stress, temperature)

    @override
    def find_forgotten_change(self, memory: TwoFractionMemory) -> Scalar | None:
        return memory.recalled.points.forgotten if self.compression == NONE and memory.recalled else None

    @override
    def fractions(self, memory: TwoFractionMemory) -> Fractions:
        return Fractions(memory.martensite, memory.oriented)

    @override
    def select(
        self, xp: Namespace, memory: TwoFractionMemory, stress: Scalar, temperature: Scalar
    ) -> TwoFractionDirection:
        diagram = self.diagram()
        courses = two_fraction_legs.follow_all_strips(xp, diagram, memory, stress, temperature)
        return two_fractions.select_direction(xp, self.history, diagram, memory, courses)

    @override
    def follow(
        self, xp: Namespace, move: TwoFractionDirection, stress: Scalar, temperature: Scalar, dt: Scalar
    ) -> Fractions:
        return two_fractions.follow_direction(xp, self.diagram(), move, stress, temperature)

    @override
    def commit(
        self,
        xp: Namespace,
        memory: TwoFractionMemory,
        move: TwoFractionDirection,
        fractions: Fractions,
        stress: Scalar,
        temperature: Scalar,
        dt: Scalar,
    ) -> TwoFractionMemory:
        end = fractions, stress, temperature
        return two_fractions.commit_move(xp, self.history, self.diagram(), memory, move, *end)

    def kinetics(
        self, xp: Namespace, memory: TwoFractionMemory, stress: Scalar, temperature: Scalar, dt: Scalar
    ) -> tuple[TwoFractionMemory, Fractions]:
        """Advance along a straight leg; both directions may act in succession."""
        diagram = self.diagram()
        for _ in range(PIECES - 1):
            courses = two_fraction_legs.follow_all_strips(xp, diagram, memory, stress, temperature)
            move = two_fractions.select_direction(xp, self.history, diagram, memory, courses)
            between = two_fraction_legs.find_handover(xp, courses, memory, stress, temperature)
            fractions = self.follow(xp, move, *between, dt)
            memory = self.commit(xp, memory, move, fractions, *between, dt)
        return super().kinetics(xp, memory, stress, temperature, dt)

    @override
    def kinks(self, xp: Namespace, memory: TwoFractionMemory) -> list[Scalar]:
        return two_fraction_legs.list_kinks(xp, self.history, self.diagram(), memory)

    @override
    def forks(self, xp: Namespace, memory: TwoFractionMemory) -> list[Fork]:
        return two_fractions.list_forks(xp, self.history, self.diagram(), memory)

    def young(self, fractions: Fractions) -> Scalar:
        """Return E(ξ) = E_A + ξ (E_M - E_A) [Pa]."""
        return self.mixture(fractions)

    @override
    def crossing(
        self, xp: Namespace, memory: TwoFractionMemory, move: TwoFractionDirection, stress: Scalar, temperature: Scalar
    ) -> Scalar:
        return two_fractions.compute_crossing(xp, self.diagram(), memory, move, stress, temperature)
