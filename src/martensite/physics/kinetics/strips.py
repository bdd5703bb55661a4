"""Base of laws with one martensite fraction and two transformation strips.

With u = T - σ/C_M and w = T - σ/C_A, forward (austenite → martensite) runs in M_f < u < M_s for du < 0 and reverse in
A_s < w < A_f for dw > 0. A law defines the fraction left at a distance from the finish line, and Young's modulus
(`kinetics.diagram`); the history rules are in `kinetics.history`. All martensite counts as oriented.
"""

from abc import abstractmethod
from typing import ClassVar, TypeAlias

from martensite.base.interfaces import override
from martensite.base.parameters import Number, param
from martensite.kernels.namespace import Flag, Namespace, Scalar
from martensite.physics.kinetics import history, strip_legs
from martensite.physics.kinetics.asymmetry import NONE, TURNS, compare_parts_left
from martensite.physics.kinetics.diagram import AbstractSidedDiagram
from martensite.physics.kinetics.history import (
    RESUME,
    RETURN_POINT,
    BranchedLeft,
    OneFractionMemory,
    OneFractionProcess,
)
from martensite.physics.kinetics.return_points import start_points
from martensite.physics.kinetics.strip_legs import STRAIGHT, Strip, StripCurve
from martensite.physics.laws.base import Doubt, Fork, Fractions

Point: TypeAlias = tuple[Scalar, Scalar]
UNLIMITED = 1e30
"""Remaining fraction that limits no process."""
RESUMED = 1e-9
"""Distance [-] of the remaining fraction from its branch below which an interrupted process resumes."""
LEAST_LEFT = 1e-300
"""Smallest fraction left by a wait of an endless process."""


class AbstractStripLaw(AbstractSidedDiagram):
    """Two strips, one fraction; subclasses add `remaining_fraction`, `young` and options."""

    endless: ClassVar[bool] = False
    """True if processes continue beyond their finish lines and forget their start."""
    keeps_forward = True

    H_k: Number = param(
        "1/Pa", "how fast H grows from H_min to eps_L with stress", low=0.0, high=1e-4, default=1e-6, typical=1e-5
    )

    @abstractmethod
    def remaining_fraction(self, xp: Namespace, distance: Scalar) -> Scalar:
        """Return the fraction that a process leaves at a distance from its finish line [-].

        The distance is 1 on the start line and 0 on the finish line. Endless processes also need values below 0, with
        f(a)/f(b) = f(1 - (b - a)) for f = `remaining_fraction`.
        """

    def remaining_fraction_of(self, xp: Namespace, distance: Scalar, ahead: Flag) -> Scalar:
        """Return the fraction left by the forward process where `ahead`, else by the reverse process."""
        return self.remaining_fraction(xp, distance)

    def curves(self) -> tuple[StripCurve | tuple[()], StripCurve | tuple[()]]:
        """Return the bending of both strips; empty for straight strips."""
        return (), ()

    def cautions(self) -> list[str]:
        """Return cautions about the order of temperatures and the sign of Θ."""
        cautions = super().cautions()
        if self.A_s < self.M_s:
            cautions.append("A_s is below M_s: the strips overlap at zero stress already.")
        return cautions

    def doubt(self) -> Doubt | None:
        """Return a doubt if the strips overlap."""
        forward, reverse = (curve or STRAIGHT for curve in self.curves())
        gap, bend = self.A_s - self.M_s, reverse.bend - forward.bend
        slope = 1.0 / self.C_A - 1.0 / self.C_M - 2.0 * bend * forward.calm - 0.5 * (forward.growth - reverse.growth)
        square = slope * slope - 4.0 * bend * gap
        falls = -slope + square**0.5 if square >= 0.0 else 0.0
        if gap < 0.0 or falls <= 0.0:
            return None
        limit = 2.0 * gap / falls
        return Doubt(
            limit,
            f"C_A > C_M: the strips overlap above {limit / 1e6:.4g} MPa, where the loop work "
            "shrinks with temperature; prefer equal slopes there."
            if self.C_A > self.C_M
            else f"the strips overlap above {limit / 1e6:.4g} MPa.",
        )

    def strips(self) -> tuple[Strip, Strip]:
        """Return the forward and reverse strip."""
        forward, reverse = self.curves()
        return (
            Strip(self.M_f, 1.0 / (self.M_s - self.M_f), 1.0 / self.C_M, self.endless, forward),
            Strip(self.A_f, 1.0 / (self.A_s - self.A_f), 1.0 / self.C_A, self.endless, reverse),
        )

    def reverse_strip(self) -> Strip:
        """Return the reverse strip."""
        return self.strips()[1]

    def find_stop(self, xp: Namespace, memory: OneFractionMemory, stress: Scalar, temperature: Scalar) -> Point:
        """Return the point of a leg where the process changes or a line turns; else its end."""
        end = stress, temperature
        if self.curves()[0]:
            end = strip_legs.find_turn(xp, self.strips(), memory, *end)
        return history.find_handover(xp, *self.strips(), memory, *end)

    def compare_rests(self, xp: Namespace, distance: Scalar, reach: Scalar) -> Scalar:
        """Return the fraction that reverse transformation leaves between two distances."""
        if self.endless:
            return self.remaining_fraction_of(xp, 1.0 - (reach - distance), False)
        return compare_parts_left(
            xp, *(self.remaining_fraction_of(xp, xp.clip(v, 0.0, 1.0), False) for v in (distance, reach))
        )

    def find_rests(self, xp: Namespace, stress: Scalar, temperature: Scalar) -> tuple[Scalar, Scalar]:
        """Return the fractions of unoriented material and austenite after cooling to a point [-]."""
        distance = self.strips()[0].distance(stress, temperature, xp)
        rest = self.remaining_fraction_of(xp, history.limit_distance(xp, distance, self.endless), True)
        return rest, rest

    def orient_martensite(
        self, xp: Namespace, side: Scalar, move: OneFractionProcess, start: Point, end: Point
    ) -> tuple[Scalar, Scalar]:
        """Return H/ε_L at the middle of the traversed strip [-], and 0 for thermal martensite."""
        first, last = move.distance(*start, xp), move.distance(*end, xp)
        safe = xp.where(first > last, first - last, 1.0)
        places = [xp.clip((first - level) / safe, 0.0, 1.0) for level in (1.0, -history.FARTHEST * self.endless)]
        middle = start[0] + 0.5 * (places[0] + places[1]) * (end[0] - start[0])
        return self._orient(xp, side, xp.maximum(middle, 0.0)), 0.0

    def _orient(self, xp: Namespace, side: Scalar, size: Scalar) -> Scalar:
        return 1.0 - (1.0 - side * self.H_min / self.eps_L) * xp.exp(-self.H_k * size)

    def trained_share(self, xp: Namespace, stress: Scalar) -> Scalar:
        """Return 1, or H/ε_L along tension with compression [-]."""
        side = xp.where(stress < 0.0, -1.0, 1.0)
        return 1.0 if self.compression == NONE else side * self._orient(xp, side, xp.abs(stress))

    @override
    def init(self, xp: Namespace, fractions: Fractions, stress: Scalar, temperature: Scalar) -> OneFractionMemory:
        points = start_points(1) if self.history == RETURN_POINT else ()
        return OneFractionMemory(fractions.martensite, 0.0, 0.0, stress, temperature, points)

    def relocate(
        self, xp: Namespace, memory: OneFractionMemory, fractions: Fractions, stress: Scalar, temperature: Scalar
    ) -> OneFractionMemory:
        """Return the memory at another fraction and point; the branch continues."""
        there = fractions.martensite, stress, temperature
        after = history.relocate_memory(xp, BranchedLeft(self.remaining_fraction_of), self.strips(), memory, *there)
        return history.relocate_points(xp, BranchedLeft(self.remaining_fraction_of), self.strips(), memory, after)

    def fractions(self, memory: OneFractionMemory) -> Fractions:
        """Return ξ, all of it oriented."""
        return Fractions(memory.fraction, memory.fraction)

    def find_forgotten_change(self, memory: OneFractionMemory) -> Scalar | None:
        """Return the change by forgotten return points [-]."""
        return memory.points.forgotten if self.compression == NONE and memory.points else None

    @override
    def select(
        self, xp: Namespace, memory: OneFractionMemory, stress: Scalar, temperature: Scalar
    ) -> OneFractionProcess:
        rule = self.history
        return history.select_process(
            xp, rule, BranchedLeft(self.remaining_fraction_of), *self.strips(), memory, stress, temperature
        )

    @override
    def follow(
        self, xp: Namespace, move: OneFractionProcess, stress: Scalar, temperature: Scalar, dt: Scalar
    ) -> Fractions:
        fraction = history.follow_process(
            xp, BranchedLeft(self.remaining_fraction_of), move, stress, temperature, self.endless
        )
        return Fractions(fraction, fraction)

    @property
    @override
    def has_surface(self) -> bool:
        return self.one_way and not self.endless

    @override
    def continue_process(
        self, xp: Namespace, memory: OneFractionMemory, move: OneFractionProcess
    ) -> OneFractionProcess:
        at, rest = (memory.stress, memory.temperature), move.remaining
        end = self.follow(xp, move._replace(remaining=UNLIMITED), *at, 0.0).martensite
        left, moves = xp.where(move.direction > 0.0, 1.0 - end, end), xp.abs(move.direction) > 0.0
        inside = move.distance(*at, xp) <= 1.0 + RESUMED
        acts = xp.both(xp.both(left <= rest + RESUMED, inside), moves)
        direction, rest = xp.where(acts, move.direction, 0.0), xp.where(acts, UNLIMITED, memory.fraction)
        return move._replace(direction=direction, remaining=rest)

    @override
    def commit(
        self,
        xp: Namespace,
        memory: OneFractionMemory,
        move: OneFractionProcess,
        fractions: Fractions,
        stress: Scalar,
        temperature: Scalar,
        dt: Scalar,
    ) -> OneFractionMemory:
        fraction = fractions.martensite
        after = history.commit_move(xp, memory, move, fraction, stress, temperature, self.endless)
        return history.remember_points(xp, BranchedLeft(self.remaining_fraction_of), memory, move, after, self.endless)

    def kinetics(
        self, xp: Namespace, memory: OneFractionMemory, stress: Scalar, temperature: Scalar, dt: Scalar
    ) -> tuple[OneFractionMemory, Fractions]:
        """Advance along a straight leg, cut at turns of curved lines; both processes may act."""
        for _ in range(TURNS if self.curves()[0] else 0):
            turn = strip_legs.find_turn(xp, self.strips(), memory, stress, temperature)
            memory, _ = self._advance(xp, memory, *turn, dt)
        return self._advance(xp, memory, stress, temperature, dt)

    def _advance(
        self, xp: Namespace, memory: OneFractionMemory, stress: Scalar, temperature: Scalar, dt: Scalar
    ) -> tuple[OneFractionMemory, Fractions]:
        """Advance along a piece of a leg without turns."""
        for _ in range(2 if self.endless else 1):
            between = history.find_handover(xp, *self.strips(), memory, stress, temperature)
            memory, _ = super().kinetics(xp, memory, *between, dt)
        return super().kinetics(xp, memory, stress, temperature, dt)

    @override
    def kinks(self, xp: Namespace, memory: OneFractionMemory) -> list[Scalar]:
        forward, reverse = self.strips()
        at = memory.stress, memory.temperature
        ahead, back = forward.distance(*at, xp), reverse.distance(*at, xp)
        # a transformation stays complete until its finish line is passed in the other direction
        ahead = xp.where(xp.either(memory.fraction < 1.0, ahead < 0.0), ahead, 2.0)
        back = xp.where(xp.either(memory.fraction > 0.0, back < 0.0), back, 2.0)
        lines = [ahead - 1.0, back - 1.0]
        own = xp.where(memory.branch > 0.0, ahead, back)
        if not self.endless:
            lines += [ahead, back]
        if memory.points:
            return lines + history.find_point_kinks(
                xp, BranchedLeft(self.remaining_fraction_of), self.endless, memory, ahead, back
            )
        if self.endless:
            wait = own - memory.scale
        else:
            left = xp.where(memory.branch > 0.0, 1.0 - memory.fraction, memory.fraction)
            wait = memory.scale * self.remaining_fraction_of(xp, xp.clip(own, 0.0, 1.0), memory.branch > 0.0) - left
        if self.history == RESUME:
            lines.append(xp.where(xp.abs(memory.branch) > 0.0, wait, 1.0))
        return lines

    @override
    def forks(self, xp: Namespace, memory: OneFractionMemory) -> list[Fork]:
        if self.history != RESUME:
            return []
        at, ahead = (memory.stress, memory.temperature), memory.branch > 0.0
        distances = [strip.distance(*at, xp) for strip in self.strips()]
        before = [(v - 1.0) / xp.abs(strip.per_width) for v, strip in zip(distances, self.strips(), strict=True)]
        own, rest = xp.where(ahead, *distances), xp.where(ahead, 1.0 - memory.fraction, memory.fraction)
        if self.endless:
            waits = xp.maximum(xp.minimum(own, 1.0) - memory.scale, 0.0)
            bound = rest / xp.maximum(self.remaining_fraction_of(xp, 1.0 - waits, ahead), LEAST_LEFT)
        else:
            bound = memory.scale * self.remaining_fraction_of(xp, xp.clip(own, 0.0, 1.0), ahead)
        return [Fork(memory.branch, xp.where(ahead, *before), xp.where(ahead, *before[::-1]), rest, bound)]

    def crossing(
        self, xp: Namespace, memory: OneFractionMemory, move: OneFractionProcess, stress: Scalar, temperature: Scalar
    ) -> Scalar:
        """Return the fraction of the selected strip crossed by the move [-], without tails."""
        start = move.distance(memory.stress, memory.temperature, xp)
        end = move.distance(stress, temperature, xp)
        if self.endless:
            start, end = xp.clip(start, 0.0, 1.0), xp.clip(end, 0.0, 1.0)
        return xp.where(xp.abs(move.direction) > 0.0, xp.abs(start - end), 0.0)


class AbstractCosineLaw(AbstractStripLaw):
    """Strips with the cosines of Liang and Rogers, and the modulus of the mixture."""

    def remaining_fraction(self, xp: Namespace, distance: Scalar) -> Scalar:
        """Return sin²(π/2 · distance)."""
        return strip_legs.compute_cosine_rest(xp, distance)

    def young(self, fractions: Fractions) -> Scalar:
        """Return E_A + ξ (E_M - E_A) [Pa]."""
        return self.mixture(fractions)
