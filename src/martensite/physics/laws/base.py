"""The contract of every one-dimensional law, explicit in stress and temperature.

A law remembers (`memory`), decides which process a move of stress and temperature sets off
(`select`), says how far that process gets (`follow`), and stores what happened (`commit`).
`kinetics` is the three in a row. Strain follows in closed form, affine in stress at frozen
fractions. The split lets a solver ask `follow` many times at the price of one `select`.

Sign convention: tension and elongation positive; strain counted from unloaded austenite at the reference temperature.
"""

from __future__ import annotations

from abc import abstractmethod
from typing import Any, ClassVar, NamedTuple, Self

from martensite.base.parameters import Parametrised
from martensite.base.registry import Registry
from martensite.kernels.namespace import Namespace, Scalar
from martensite.kernels.nested import choose_tuple

LAWS: Registry[AbstractLaw] = Registry("law", "martensite.physics.laws", typical="liang-rogers")

COLD = 100.0
"""Temperature [K] from which a wire is warmed to the start of a run: the least transformation temperature of laws."""
SHELF_TIME = 1e5
"""Time [s] that a law with rates has had to come to rest at the start of a run: about a day."""
TURNED = 1e-6
"""Change of the net oriented fraction [-] from which on a wire was turned by the stress."""


class Fractions(NamedTuple):
    """Phase state as every law reports it."""

    martensite: Scalar
    """Total martensite fraction ξ in [0, 1]: resistance, latent heat, modulus depend on it."""
    oriented: Scalar
    """Net oriented (detwinned) fraction in [-ξ, ξ]: transformation strain depends on it."""

    @property
    def rphase(self) -> Scalar:
        """Return the R-phase as a share of what is not martensite [-]; 0 unless a law says otherwise."""
        return 0.0

    @property
    def rphase_fraction(self) -> Scalar:
        """Return the R-phase fraction ξ_R in [0, 1 - ξ]."""
        return 0.0


class RPhaseFractions(Fractions):
    """With a third number; laws that know no R-phase keep two and pay nothing for it.

    The share is the third number, and not ξ_R, since it stays as it is while martensite takes from both phases.
    """

    def __new__(cls, martensite: Scalar, oriented: Scalar, rphase: Scalar) -> Self:
        """Return all three of them."""
        return super(Fractions, cls).__new__(cls, (martensite, oriented, rphase))

    __repr__ = tuple[Scalar].__repr__

    @property
    def rphase(self) -> Scalar:
        """Return the R-phase as a share of what is not martensite [-]."""
        return self[-1]

    @property
    def rphase_fraction(self) -> Scalar:
        """Return the R-phase fraction ξ_R in [0, 1 - ξ]."""
        return self.rphase * (1.0 - self.martensite)


class Doubt(NamedTuple):
    """Range in which a law is not reliable."""

    stress: float
    """From this stress on [Pa]."""
    sentence: str


class AbstractLaw(Parametrised):
    """Interface of a law. Memory and move are NamedTuples of scalars of the law's own.

    Every memory holds at least `stress` [Pa] and `temperature` [K] of the last accepted point.
    """

    twins: ClassVar[bool] = False
    """True if martensite may be present that is not oriented; else all of it counts."""
    rphase: ClassVar[bool] = False
    """True if its fractions are `RPhaseFractions`."""
    one_way: ClassVar[bool] = True
    """True if one move changes both fractions in a fixed proportion, wherever it ends."""
    steep: ClassVar[bool] = False
    """True if the law offers `drive`."""
    orders: ClassVar[tuple[tuple[str, str], ...]] = ()
    """Pairs of parameters of which the first must be below the second: searches keep them in order."""
    rate_dependent: ClassVar[bool] = False
    """True if time acts, not only the path of stress and temperature."""
    grouped: ClassVar[bool] = False
    """True if the law divides the material into groups, each with a separate phase state."""

    @property
    def tension_only(self) -> bool:
        """Return True if all its martensite is that of tension, which compression drives back."""
        return False

    @property
    def constant_heat(self) -> bool:
        """Return True if the heat of transformation is the latent heat of the element, whatever else."""
        return True

    def doubt(self) -> Doubt | None:
        """Return a stress beyond which the law is doubtful, if there is one: a run near it says so."""
        return None

    def find_forgotten_change(self, memory: Any) -> Scalar | None:
        """Return the largest change [-] of a fraction by a forgotten loop of a bounded memory; None if none occurs."""
        return None

    @abstractmethod
    def init(self, xp: Namespace, fractions: Fractions, stress: Scalar, temperature: Scalar) -> Any:
        """Return the memory of a wire in a phase state that has no history."""

    def trained_share(self, xp: Namespace, stress: Scalar) -> Scalar:
        """Return the share of martensite that is oriented once it has formed under a stress [Pa].

        That of a wire that was cooled under this stress before: 1 unless the law says otherwise.
        """
        return 1.0

    def warm_up(self, xp: Namespace, fractions: Fractions, stress: Scalar, temperature: Scalar) -> Any:
        """Return the memory of a trained wire that was warmed from cold martensite under a constant stress.

        Martensite that the law does not keep at the end of the way is austenite there.

        Args:
            xp: namespace of the runtime.
            fractions: phase state that the wire has if the law keeps it.
            stress: at the end of the way, and all along it [Pa].
            temperature: at the end of the way [K]. A law with rates waits there for `SHELF_TIME` instead.
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

        The history moves along: an active transformation continues from there, because only the estimate is corrected
        and the wire does not change. By default the history is empty.
        """
        return self.init(xp, fractions, stress, temperature)

    @abstractmethod
    def select(self, xp: Namespace, memory: Any, stress: Scalar, temperature: Scalar) -> Any:
        """Return the process that a straight move to (stress [Pa], temperature [K]) sets off."""

    @abstractmethod
    def follow(self, xp: Namespace, move: Any, stress: Scalar, temperature: Scalar, dt: Scalar) -> Fractions:
        """Return the fractions at the end of the move if it ends at (stress, temperature) after dt [s].

        The oriented fraction must not fall with stress, nor the total rise with temperature.
        """

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
        """Return the heat released per volume by the whole forward transformation [J/m³].

        It is the constant `latent` heat of the element unless the law says otherwise.
        """
        return latent

    def released(self, fractions: Fractions) -> Scalar:
        """Return the share of that heat which has been released in a phase state [-]."""
        return fractions.martensite

    def drive(self, xp: Namespace, move: Any, stress: Scalar, temperature: Scalar, dt: Scalar) -> Scalar:
        """Return the distance of the selected process beyond balance at the end, on any scale.

        Nearly linear in (stress, temperature), 0 where it would come to rest: from it the solve
        of a `steep` law, whose answer changes within a small part of a move, guesses its start.
        """
        return 0.0

    def kinks(self, xp: Namespace, memory: Any) -> list[Scalar]:
        """Return the numbers that fall through 0 where a transformation starts or ends on the way on [-].

        Smooth on both sides, for a march that ends a step there. None where that is not known, or where nothing bends.
        """
        return []

    @abstractmethod
    def crossing(self, xp: Namespace, memory: Any, move: Any, stress: Scalar, temperature: Scalar) -> Scalar:
        """Return the share of a transformation strip that a move crosses [-]: for the step control."""
