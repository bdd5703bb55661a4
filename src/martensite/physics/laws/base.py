"""The contract of every one-dimensional law, explicit in stress and temperature.

A law has a memory, selects the process that a move of stress and temperature starts (`select`), follows it to the end
of the move (`follow`), and stores the result (`commit`); `kinetics` combines the three. Strain follows in closed form,
affine in stress at frozen fractions. A solver can call `follow` many times after one `select`.

Sign convention: tension and elongation positive; strain counted from unloaded austenite at the reference temperature.
"""

from __future__ import annotations

from abc import abstractmethod
from typing import Any, ClassVar, NamedTuple, Self

from martensite.base.interfaces import make_missing_error, override
from martensite.base.parameters import Parametrised
from martensite.base.registry import Registry
from martensite.kernels.namespace import Namespace, Scalar
from martensite.kernels.nested import choose_tuple

LAWS: Registry[AbstractLaw] = Registry("law", "martensite.physics.laws", typical="liang-rogers")

COLD = 100.0
"""Temperature [K] from which a wire is warmed to the start of a run: the lowest transformation temperature of laws."""
SHELF_TIME = 1e5
"""Time [s], about a day, in which a rate-dependent law reaches its steady state before a run."""
TURNED = 1e-6
"""Change of the net oriented fraction [-] that counts as reorientation by stress."""


class Fractions(NamedTuple):
    """Phase state of every law."""

    martensite: Scalar
    """Total martensite fraction ξ in [0, 1], for resistance, latent heat and modulus."""
    oriented: Scalar
    """Net oriented (detwinned) fraction in [-ξ, ξ], for transformation strain."""

    @property
    def rphase(self) -> Scalar:
        """Return the R-phase as a fraction of the material that is not martensite [-]."""
        return 0.0

    @property
    def rphase_fraction(self) -> Scalar:
        """Return the R-phase fraction ξ_R in [0, 1 - ξ]."""
        return 0.0


class RPhaseFractions(Fractions):
    """Phase state with an R-phase; other laws keep two values.

    The third value is not ξ_R but a fraction of the remaining material, which stays constant while martensite forms.
    """

    def __new__(cls, martensite: Scalar, oriented: Scalar, rphase: Scalar) -> Self:
        """Return a phase state of three values."""
        return super(Fractions, cls).__new__(cls, (martensite, oriented, rphase))

    __repr__ = tuple[Scalar].__repr__

    @property
    @override
    def rphase(self) -> Scalar:
        return self[-1]

    @property
    @override
    def rphase_fraction(self) -> Scalar:
        return self.rphase * (1.0 - self.martensite)


class Fork(NamedTuple):
    """Branch in progress, and the surface on which the law forgets it.

    A branch with `rest` < `bound` waits: it continues where `bound` has fallen to `rest`. A law that forgot it would
    continue at once.
    """

    branch: Scalar
    """+1 forward, -1 reverse, 0 before the first transformation."""
    own: Scalar
    """Distance [K] before the start of this direction; negative inside its strip."""
    other: Scalar
    """Distance [K] before the start of the opposite direction."""
    rest: Scalar
    """Remaining fraction of the branch [-]."""
    bound: Scalar
    """Remaining fraction that the branch allows at this point, at least `rest` [-]."""


class Doubt(NamedTuple):
    """Range in which a law is not reliable."""

    stress: float
    """Lower limit of the range [Pa]."""
    sentence: str


class AbstractLaw(Parametrised):
    """Interface of a law; memory and move are NamedTuples of scalars.

    Each memory has at least `stress` [Pa] and `temperature` [K] of the last accepted point.
    """

    has_twins: ClassVar[bool] = False
    """True if unoriented martensite is possible; else all martensite is oriented."""
    has_rphase: ClassVar[bool] = False
    """True if its fractions are `RPhaseFractions`."""
    one_way: ClassVar[bool] = True
    """True if a move changes both fractions in a fixed proportion."""
    has_drive: ClassVar[bool] = False
    """True if the law has `drive`."""
    orders: ClassVar[tuple[tuple[str, str], ...]] = ()
    """Pairs of parameters, the first below the second; searches keep the order."""
    rate_dependent: ClassVar[bool] = False
    """True if the result depends on time."""
    has_groups: ClassVar[bool] = False
    """True if the law has groups with separate phase states."""

    @property
    def tension_only(self) -> bool:
        """Return True if compression reverts all martensite."""
        return False

    @property
    def constant_heat(self) -> bool:
        """Return True if the heat of transformation is the latent heat of the element."""
        return True

    def doubt(self) -> Doubt | None:
        """Return the stress range in which the law is doubtful; runs near it report it."""
        return None

    def find_forgotten_change(self, memory: Any) -> Scalar | None:
        """Return the largest change [-] of a fraction by a forgotten loop; None for unbounded memories."""
        return None

    @abstractmethod
    def init(self, xp: Namespace, fractions: Fractions, stress: Scalar, temperature: Scalar) -> Any:
        """Return the memory of a phase state without history."""

    def trained_share(self, xp: Namespace, stress: Scalar) -> Scalar:
        """Return the oriented fraction of martensite that formed under a stress [Pa]; 1 by default."""
        return 1.0

    def warm_up(self, xp: Namespace, fractions: Fractions, stress: Scalar, temperature: Scalar) -> Any:
        """Return the memory of a trained wire that was warmed from cold martensite under a constant stress.

        Martensite that the law does not keep at the end is austenite there.

        Args:
            xp: namespace of the runtime.
            fractions: phase state, if the law keeps it.
            stress: constant stress [Pa].
            temperature: final temperature [K]. A rate-dependent law stays there for `SHELF_TIME` instead.
        """
        given = self.init(xp, fractions, stress, temperature)
        some = fractions.martensite > 0.0
        share = xp.where(some, fractions.oriented / xp.where(some, fractions.martensite, 1.0), 1.0)
        begin = temperature if self.rate_dependent else COLD
        cold = self.init(xp, Fractions(1.0, share), stress, begin)
        warm, left = self.kinetics(xp, cold, stress, temperature, SHELF_TIME)
        turns = xp.abs(left.oriented - share * left.martensite) > TURNED
        loses = left.martensite < fractions.martensite
        turns = xp.both(turns, left.martensite <= fractions.martensite)
        return choose_tuple(xp, xp.either(loses, turns), warm, given)

    @abstractmethod
    def fractions(self, memory: Any) -> Fractions:
        """Return the phase state stored in a memory."""

    def relocate(self, xp: Namespace, memory: Any, fractions: Fractions, stress: Scalar, temperature: Scalar) -> Any:
        """Return a memory moved to another point, as an observer corrects it; the same point changes nothing.

        An active transformation continues from there, because only the estimate changes. By default the history is
        empty.
        """
        return self.init(xp, fractions, stress, temperature)

    @abstractmethod
    def select(self, xp: Namespace, memory: Any, stress: Scalar, temperature: Scalar) -> Any:
        """Return the process that a straight move to (stress [Pa], temperature [K]) starts."""

    @abstractmethod
    def follow(self, xp: Namespace, move: Any, stress: Scalar, temperature: Scalar, dt: Scalar) -> Fractions:
        """Return the fractions if the move ends at (stress, temperature) after dt [s].

        The oriented fraction must not fall with stress, nor the total rise with temperature.
        """

    @property
    def has_surface(self) -> bool:
        """Return True if the law has `continue_process`: one fraction, a smooth function of stress and temperature."""
        return False

    def continue_process(self, xp: Namespace, memory: Any, move: Any) -> Any:
        """Return a move that follows its process in both directions if it acts from the start on; else an idle move."""
        raise make_missing_error(type(self), ["continue_process"])

    @abstractmethod
    def commit(
        self,
        xp: Namespace,
        memory: Any,
        move: Any,
        fractions: Fractions,
        stress: Scalar,
        temperature: Scalar,
        dt: Scalar,
    ) -> Any:
        """Return the memory after the accepted move."""

    def kinetics(
        self, xp: Namespace, memory: Any, stress: Scalar, temperature: Scalar, dt: Scalar
    ) -> tuple[Any, Fractions]:
        """Advance along a straight leg to (stress, temperature) in dt [s]."""
        move = self.select(xp, memory, stress, temperature)
        fractions = self.follow(xp, move, stress, temperature, dt)
        return self.commit(xp, memory, move, fractions, stress, temperature, dt), fractions

    @abstractmethod
    def free_strain(self, xp: Namespace, fractions: Fractions, temperature: Scalar) -> Scalar:
        """Return the strain [-] at zero stress: transformation + thermal."""

    @abstractmethod
    def compliance(self, xp: Namespace, fractions: Fractions) -> Scalar:
        """Return the elastic strain per stress [1/Pa]."""

    def strain(self, xp: Namespace, fractions: Fractions, stress: Scalar, temperature: Scalar) -> Scalar:
        """Return the total strain [-], affine in stress [Pa] at frozen fractions."""
        free = self.free_strain(xp, fractions, temperature)
        return free + self.compliance(xp, fractions) * stress

    def heat(self, xp: Namespace, latent: Scalar, stress: Scalar, temperature: Scalar) -> Scalar:
        """Return the heat released by the whole forward transformation [J/m³]; by default `latent`."""
        return latent

    def released_fraction(self, fractions: Fractions) -> Scalar:
        """Return the released fraction of that heat in a phase state [-]."""
        return fractions.martensite

    def drive(self, xp: Namespace, move: Any, stress: Scalar, temperature: Scalar, dt: Scalar) -> Scalar:
        """Return the distance of the selected process beyond balance at the end, on any scale.

        It is nearly linear in (stress, temperature) and 0 in equilibrium. The solver of a law with `has_drive` takes
        its first guess from it.
        """
        return 0.0

    def kinks(self, xp: Namespace, memory: Any) -> list[Scalar]:
        """Return numbers that fall through 0 where a transformation starts or ends, smooth on both sides.

        The time integration ends a step there. The list is empty for laws without known kinks.
        """
        return []

    def forks(self, xp: Namespace, memory: Any) -> list[Fork]:
        """Return the branches that a law forgets on a surface; a small change of the path may then change the result.

        The list is empty for laws whose result is a continuous function of the path.
        """
        return []

    @abstractmethod
    def crossing(self, xp: Namespace, memory: Any, move: Any, stress: Scalar, temperature: Scalar) -> Scalar:
        """Return the fraction of a transformation strip that a move crosses [-], for the step control."""
