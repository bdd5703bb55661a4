"""One step of a multibody mechanism with its elements.

For one element, the mechanism with all other elements is a spring. Linearised at a trial position, with the others as
their previous tangents F_j + K_j (e - e_j),

    H δ + Σ_j η_j K_j J_j J_jᵀ δ = η_i J_i ΔF_i - r            A = H + Σ_j η_j K_j J_j J_jᵀ

is a straight line between elongation and tension of element i,

    (1 - s K_i) (e - e*) + s (F - F*) = g,      s = η_i J_i·A⁻¹J_i,      g = J_i·A⁻¹r

on which the element solves its own coupled step of law and heat in a bracket. The results give new tangents and, by
Newton's method, the next trial position. This is Newton's method for the mechanism and a bracket for every law; the
last correction of the position is part of the residual of the step. K_i affects the speed of convergence only. H
contains stiffness, damping and inertia of the mechanism, and the rotation of its levers under tension; all derivatives
are exact.

With unilateral constraints (`complementarity`), the constraints that push in a trial hold the load line of the
elements. The set of pushing constraints is determined again with every correction.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

from martensite.actuators.mechanics.complementarity import (
    FARTHEST,
    Constraints,
    hold_touching,
    linearise_gaps,
    measure_mismatch,
    meet_constraints,
)
from martensite.actuators.mechanics.elimination import multiply_inner, solve_linear
from martensite.actuators.mechanics.equal_elements import LoadLineEquation, answer_loads
from martensite.actuators.mechanics.motion import MotionHistory, Numbers, Scheme, move_implicitly, predict_position
from martensite.actuators.mechanisms.base import Column, Load
from martensite.kernels.dual import compute_jacobian
from martensite.kernels.namespace import Namespace, Scalar
from martensite.kernels.nested import NestedShape, find_largest, flatten_numbers
from martensite.physics.laws.coupling import StepReport

if TYPE_CHECKING:
    from martensite.actuators.mechanisms.multibody import AbstractMultibody, MultibodyMemory

PASSES = 24
"""Largest number of passes of a step."""
SETTLED = 1e-11
"""Relative correction of a coordinate that counts as zero."""
FLOOR = 1e-9
"""Relative stiffness of a slack element, which avoids a singular system."""
STILL = 1e-13
"""Smallest change of elongation [m] that gives a tangent; smaller gaps count as zero."""


class Tangent(NamedTuple):
    """Force at an elongation, and force per elongation of an element."""

    force: Scalar
    elongation: Scalar
    stiffness: Scalar


class CondensedSystem(NamedTuple):
    """Mechanism with elements, linearised at a trial position."""

    elongations: Column
    lever: list[list[Scalar]]
    """J."""
    shares: Column
    """η."""
    matrix: list[list[Scalar]]
    """H."""
    missing: Column
    """Demand less the supply by the tangents."""
    forces: Column
    """Forces of the tangents [N]."""
    constraints: Constraints | None
    """Possible contacts."""


class _Turn(NamedTuple):
    """State between passes."""

    offsets: Numbers
    """Position less its prediction."""
    tangents: tuple[Tangent, ...]
    turned: Scalar
    """0 before the first pass, then 1."""
    states: tuple[Any, ...]
    report: StepReport
    relocate: Scalar
    """Largest relative correction of a coordinate."""
    reactions: Numbers
    """Reactions of unilateral constraints [N] or [N m]."""


@dataclass(frozen=True)
class CondensedStep:
    """One step; call `solve_position`."""

    mechanism: AbstractMultibody
    memory: MultibodyMemory
    loads: Sequence[Load]
    signals: Column
    dt: Scalar

    def solve_position(self, xp: Namespace) -> tuple[MotionHistory, list[Scalar], Numbers, list[Any], StepReport]:
        """Return motion, stiffnesses, reactions, final states of the elements, and the report."""
        scheme = self._choose_scheme(xp)
        shape = NestedShape(
            _Turn(
                (0.0,) * len(self.memory.course.position),
                tuple(self._first(xp)),
                0.0,
                tuple(load.state for load in self.loads),
                StepReport(0.0, 0.0),
                0.0,
                self.memory.reactions,
            )
        )

        def turn(_: Scalar, *flat: Scalar) -> list[Scalar]:
            before: _Turn = shape.rebuild(flat)
            after = self._turn(xp, scheme, before)
            going = xp.either(after.relocate > SETTLED, before.turned < 0.5)
            return [xp.where(going, 1.0, 0.0), *flatten_numbers(after)]

        _, *flat = xp.iterate(PASSES, turn, 1.0, *flatten_numbers(shape.example))
        end: _Turn = shape.rebuild(flat)
        residual, course = xp.maximum(end.report.residual, end.relocate), scheme(end.offsets)
        if end.reactions:
            gaps = self.mechanism.gaps(xp, course.position)
            residual = xp.maximum(residual, measure_mismatch(xp, gaps, end.reactions))
        stiffness = [tangent.stiffness for tangent in end.tangents]
        report = end.report._replace(residual=residual)
        return course, stiffness, end.reactions, list(end.states), report

    def _choose_scheme(self, xp: Namespace) -> Scheme:
        """Return the scheme of the mechanism; with inertia, implicit Euler at or just before a contact."""
        mechanism, course = self.mechanism, self.memory.course
        usual = mechanism.scheme(xp, course, self.dt)
        if not (mechanism.moves and self.memory.reactions):
            return usual
        ahead = find_largest(xp, [-gap for gap in mechanism.gaps(xp, predict_position(course, self.dt))])
        touching = xp.either(ahead >= 0.0, find_largest(xp, self.memory.reactions) > 0.0)
        return move_implicitly(xp, course, self.dt, xp.where(touching, 1.0, 0.0), usual)

    def _turn(self, xp: Namespace, scheme: Scheme, before: _Turn) -> _Turn:
        """Return the state after linearisation, responses of all elements, and correction of the position."""
        linear = self._linear(xp, scheme, before)
        responses, states, report = self._answers(xp, _build_lines(xp, linear, before.tangents), before.states)
        tangents = _renew_points(xp, before, responses, linear.elongations)
        change, reactions, unsettled = _compute_correction(xp, linear, tangents)
        sizes = (c.size for c in self.mechanism.coordinates())
        moved = [xp.abs(d) * (1.0 / size) for d, size in zip(change, sizes, strict=True)]
        relocate = find_largest(xp, moved)
        if reactions:
            share = FARTHEST / xp.maximum(relocate, FARTHEST)
            change, relocate = [share * d for d in change], xp.maximum(relocate, unsettled)
        offsets = tuple(o + d for o, d in zip(before.offsets, change, strict=True))
        return _Turn(offsets, tuple(tangents), 1.0, tuple(states), report, relocate, reactions)

    def _first(self, xp: Namespace) -> list[Tangent]:
        """Return all elements in their present state, with the stiffness of the last step."""
        tangents: list[Tangent] = []
        paths = self.mechanism.contraction(xp, self.memory.course.position)
        rows = zip(self.loads, self.memory.stiffness, self.memory.home, paths, strict=True)
        for (element, state, _), last_stiffness, home, path in rows:
            force = element.force(state)
            spring = element.tangent(xp, state, force)
            most = 1.0 / spring.compliance
            elongation = spring.free + spring.compliance * force
            slack = _compute_slack_stiffness(xp, most, home - path, elongation)
            taut = xp.where(last_stiffness > 0.0, xp.minimum(last_stiffness, most), most)
            stiffness = xp.where(force > 0.0, taut, slack)
            tangents.append(Tangent(force, elongation, stiffness))
        return tangents

    def _linear(self, xp: Namespace, scheme: Scheme, before: _Turn) -> CondensedSystem:
        """Return balance and derivatives at a trial position."""
        mechanism, home = self.mechanism, self.memory.home
        tangents, pushed, now = before.tangents, before.reactions, scheme(before.offsets).motion()
        position = now.position
        paths, lever = compute_jacobian(xp, mechanism.contraction, position)
        elongations = [start - path for start, path in zip(home, paths, strict=True)]
        forces = [
            xp.maximum(t.force + t.stiffness * (e - t.elongation), 0.0)
            for t, e in zip(tangents, elongations, strict=True)
        ]

        def balance(xp: Namespace, trial: Column) -> list[Scalar]:
            motion = scheme(tuple(trial)).motion()
            needs = mechanism.demand(xp, motion, self.signals)
            gives = mechanism.supply(xp, motion.position, forces, motion.velocity)
            return [n - g for n, g in zip(needs, gives, strict=True)]

        missing, matrix = compute_jacobian(xp, balance, before.offsets)
        shares = mechanism.transmission(xp, now)
        system = CondensedSystem(elongations, lever, shares, matrix, missing, forces, None)
        if not pushed:
            return system
        touched = linearise_gaps(xp, mechanism.gaps, position, pushed)
        given = [multiply_inner(pushed, column) for column in zip(*touched.slopes, strict=True)]
        missing = [n - g for n, g in zip(missing, given, strict=True)]
        return system._replace(missing=missing, constraints=touched)

    def _answers(
        self, xp: Namespace, lines: Sequence[LoadLineEquation], before: Sequence[Any]
    ) -> tuple[list[Tangent], list[Any], StepReport]:
        """Return the tangent at frozen fractions and the state of each element on its load line."""
        if not lines:
            return [], [], StepReport(0.0, 0.0)
        tangents: list[Tangent] = []
        pairs = zip(self.loads, before, strict=True)
        loads = [load._replace(state=load.element.warm_start(load.state, state)) for load, state in pairs]
        answered = answer_loads(xp, loads, lines, self.dt)
        for _, force, spring, _ in answered:
            elongation = spring.free + spring.compliance * force
            tangents.append(Tangent(force, elongation, 1.0 / spring.compliance))
        columns = zip(*(answer.report for answer in answered), strict=True)
        report = StepReport(*(find_largest(xp, column) for column in columns))
        return tangents, [answer.state for answer in answered], report


def _build_stiffness(linear: CondensedSystem, tangents: Sequence[Tangent]) -> list[list[Scalar]]:
    rows = [list(row) for row in linear.matrix]
    for lever, share, tangent in zip(linear.lever, linear.shares, tangents, strict=True):
        weight = share * tangent.stiffness
        for k, row in enumerate(rows):
            rows[k] = [x + weight * lever[k] * j for x, j in zip(row, lever, strict=True)]
    return rows


def _build_lines(xp: Namespace, linear: CondensedSystem, tangents: Sequence[Tangent]) -> list[LoadLineEquation]:
    """Return the load line of each element."""
    if not tangents:
        return []
    stiffness, touched = _build_stiffness(linear, tangents), linear.constraints
    if touched is None:
        *softs, shift = solve_linear(stiffness, [*linear.lever, linear.missing])
    else:
        *softs, shift = hold_touching(xp, touched, stiffness, linear.lever, linear.missing)
    lines: list[LoadLineEquation] = []
    for i, tangent in enumerate(tangents):
        lever, beta = linear.lever[i], linear.shares[i] * multiply_inner(linear.lever[i], softs[i])
        alpha, offset = 1.0 - beta * tangent.stiffness, multiply_inner(lever, shift)
        lines.append(LoadLineEquation(alpha, beta, offset, linear.elongations[i], linear.forces[i]))
    return lines


def _renew_points(xp: Namespace, before: _Turn, tangents: Sequence[Tangent], elongations: Column) -> list[Tangent]:
    """Return the new tangents, with secant stiffness after the first pass."""
    new, turned = list[Tangent](), before.turned > 0.0
    for last, now, path in zip(before.tangents, tangents, elongations, strict=True):
        most, taut = now.stiffness, last.force > 0.0
        fallback = xp.where(taut, xp.minimum(last.stiffness, most), most)
        apart = now.elongation - last.elongation
        if before.reactions:  # an element held still shows no secant and may be released with any stiffness
            is_held = find_largest(xp, before.reactions) > 0.0
            fallback = xp.where(xp.both(is_held, xp.abs(apart) < STILL), most, fallback)
        has_secant = xp.both(xp.both(turned, taut), xp.abs(apart) > STILL)
        secant = (now.force - last.force) / xp.where(has_secant, apart, 1.0)
        slope = xp.where(has_secant, xp.clip(secant, FLOOR * most, most), fallback)
        slack = _compute_slack_stiffness(xp, most, path, now.elongation)
        new.append(now._replace(stiffness=xp.where(now.force > 0.0, slope, slack)))
    return new


def _compute_slack_stiffness(xp: Namespace, most: Scalar, path: Scalar, own: Scalar) -> Scalar:
    """Return the stiffness of an element without force; it is slack if `path` is below `own` elongation [m]."""
    return xp.where(path > own - STILL, most, FLOOR * most)


def _compute_correction(
    xp: Namespace, linear: CondensedSystem, tangents: Sequence[Tangent]
) -> tuple[list[Scalar], Numbers, Scalar]:
    """Return Newton's correction of the position, the reactions, and their error."""
    side = [-missing for missing in linear.missing]
    for i, tangent in enumerate(tangents):
        apart = linear.elongations[i] - tangent.elongation
        answer = xp.maximum(tangent.force + tangent.stiffness * apart, 0.0)
        weight = linear.shares[i] * (answer - linear.forces[i])
        side = [s + weight * j for s, j in zip(side, linear.lever[i], strict=True)]
    stiffness = _build_stiffness(linear, tangents)
    if linear.constraints is None:
        return solve_linear(stiffness, [side])[0], (), 0.0
    change, reactions, unsettled = meet_constraints(xp, linear.constraints, stiffness, side)
    return change, tuple(reactions), unsettled
