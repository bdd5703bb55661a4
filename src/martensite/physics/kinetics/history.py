"""History of transformations with two strips: active process, its start, and the new memory.

A process multiplies the remaining fraction by left(v₁)/left(v₀), with the distance v to its finish line
(`strip_legs`). Forward (austenite → martensite) acts on y = 1 - ξ, reverse on y = ξ. Three rules define the memory; the
first two differ in v₀ only:

- resume: v₀ is the v at which the branch was opened, and y never grows on it. An interrupted transformation continues
  when the path passes the point of interruption. An opposite move inside the opposite strip forgets it. This is one
  memory level: inner loops do not close as in a Preisach model.
- restart: v₀ is v at the start of each increment, the literal reading of the papers; small cycles inside one strip
  ratchet.
- return-point: as resume, but a branch leads back to the interruption of the previous branch of its direction, so that
  nested loops close (see `return_points`).

If both processes could act (strips overlap for C_A ≠ C_M), the branch in progress continues, else the process met
first, else reverse. The result does not depend on the increments of a straight leg.

An endless strip continues beyond the finish line (v < 0) and forgets its start, left(a)/left(b) = left(1 - (b - a)).
The memory is then the lowest v reached on the branch (resume) instead of a scale, so that no tail underflows. If both
processes could act, the process past its finish line yields to the other, else to reverse.
"""

from collections.abc import Callable
from typing import NamedTuple, TypeAlias

from martensite.kernels import floats
from martensite.kernels.namespace import Flag, Namespace, Scalar
from martensite.physics.kinetics.return_points import (
    COMPLETE_REST,
    BranchCourse,
    ReturnPoints,
    commit_course,
    compute_rests,
    find_next,
    scale_points,
    select_course,
)
from martensite.physics.kinetics.strip_legs import Strip, StripCurve, StripLeg, follow_strip, turning_point

RESUME, RESTART, RETURN_POINT = "resume", "restart", "return-point"
MOST_SCALE = 1e9
"""Largest scale after a relocation; observers relocate in every sample, and the factors must not overflow."""
LEAST_REST = 1e-3
"""Fraction of a transformation below which it counts as complete."""

FARTHEST = 60.0
"""Strip widths beyond the finish line at which an endless process counts as complete, for return points."""


class BranchedLeft(NamedTuple):
    """Remaining fraction that depends on the direction of the process."""

    find: Callable[[Namespace, Scalar, Flag], Scalar]


Left: TypeAlias = Callable[[Namespace, Scalar], Scalar] | BranchedLeft
"""Remaining fraction as a function of the distance from the finish line."""


def find_left(left: Left, xp: Namespace, distance: Scalar, ahead: Flag) -> Scalar:
    """Return the fraction left by the forward process where `ahead`, else by the reverse process."""
    return left.find(xp, distance, ahead) if isinstance(left, BranchedLeft) else left(xp, distance)


class OneFractionMemory(NamedTuple):
    """Memory of a one-fraction law."""

    fraction: Scalar
    branch: Scalar
    """+1 forward, -1 reverse in progress, 0 initially."""
    scale: Scalar
    """Remaining fraction at the start line of this branch [-]; for endless processes the lowest distance reached."""
    stress: Scalar
    temperature: Scalar
    points: ReturnPoints | tuple[()] = ()
    """Used by the rule return-point instead of a scale."""


class OneFractionProcess(NamedTuple):
    """Process selected for an increment."""

    direction: Scalar
    scale: Scalar
    remaining: Scalar
    """Remaining fraction before the move [-]."""
    finish: Scalar
    per_width: Scalar
    per_slope: Scalar
    course: BranchCourse | tuple[()] = ()
    """Used by the rule return-point."""
    curve: StripCurve | tuple[()] = ()
    """Curvature of the lines; empty for straight lines."""

    def distance(self, stress: Scalar, temperature: Scalar, xp: Namespace = floats) -> Scalar:
        """Return the unlimited distance to the finish line in strip widths [-]."""
        strip = Strip(self.finish, self.per_width, self.per_slope, curve=self.curve)
        return strip.distance(stress, temperature, xp)


def follow_both_strips(
    xp: Namespace, forward: Strip, reverse: Strip, memory: OneFractionMemory, stress: Scalar, temperature: Scalar
) -> tuple[StripLeg, StripLeg, Flag]:
    """Return both strips along a leg, and whether the reverse process acts first."""
    f = follow_strip(xp, forward, memory, stress, temperature, 1.0 - memory.fraction)
    r = follow_strip(xp, reverse, memory, stress, temperature, memory.fraction)
    if forward.endless:
        return endless_turns(xp, f, r, memory.branch)
    tie = xp.both(r.enters <= f.enters, memory.branch <= 0.0)
    earlier = xp.either(r.enters < f.enters, tie)
    return f, r, xp.both(r.acts, xp.either(xp.negate(f.acts), earlier))


def endless_turns(xp: Namespace, f: StripLeg, r: StripLeg, branch: Scalar) -> tuple[StripLeg, StripLeg, Flag]:
    """Return both strips and whether reverse acts first, for endless processes.

    A process in progress always has something left, even below rounding. If both could act, the process past its finish
    line waits.
    """
    f_acts = xp.either(f.acts, xp.both(f.passes, branch > 0.0))
    r_acts = xp.either(r.acts, xp.both(r.passes, branch < 0.0))
    r_turn = xp.either(xp.negate(f.ahead), xp.both(xp.both(branch <= 0.0, r.ahead), r_acts))
    level = xp.both(r.enters <= f.enters, f.enters <= r.enters)
    level = xp.both(level, xp.both(f.passes, r.passes))
    first = xp.either(xp.negate(f_acts), r.enters < f.enters)
    r_first = xp.either(xp.both(level, r_turn), xp.both(xp.negate(level), first))
    f = f._replace(acts=xp.both(f_acts, xp.negate(xp.both(level, r_turn))))
    return f, r, xp.both(r_acts, r_first)


def select_process(
    xp: Namespace,
    rule: str,
    left: Left,
    forward: Strip,
    reverse: Strip,
    memory: OneFractionMemory,
    stress: Scalar,
    temperature: Scalar,
) -> OneFractionProcess:
    """Return the process that a straight leg to (stress, temperature) starts first."""
    f, r, back = follow_both_strips(xp, forward, reverse, memory, stress, temperature)
    direction = xp.where(back, -1.0, xp.where(f.acts, 1.0, 0.0))
    ahead = direction > 0.0
    begin = xp.where(ahead, f.begin, r.begin)
    remaining = xp.where(ahead, 1.0 - memory.fraction, memory.fraction)
    scale, course = begin, ()
    if memory.points:
        turns = xp.both(xp.abs(direction) > 0.0, memory.branch * direction <= 0.0)
        share = find_left(left, xp, limit_distance(xp, begin, forward.endless), ahead)
        scale, course = memory.scale, select_course(xp, memory.points, ahead, turns, share, [remaining])
    elif not forward.endless:
        share = find_left(left, xp, begin, ahead)
        usable = share > 0.0
        scale = xp.where(usable, remaining / xp.where(usable, share, 1.0), 0.0)
    if rule == RESUME:
        scale = xp.where(memory.branch * direction > 0.0, memory.scale, scale)
    return OneFractionProcess(
        direction=direction,
        scale=scale,
        remaining=remaining,
        finish=xp.where(ahead, forward.finish, reverse.finish),
        per_width=xp.where(ahead, forward.per_width, reverse.per_width),
        per_slope=xp.where(ahead, forward.per_slope, reverse.per_slope),
        course=course,
        curve=choose_curve(xp, ahead, forward, reverse),
    )


def choose_curve(xp: Namespace, ahead: Flag, forward: Strip, reverse: Strip) -> StripCurve | tuple[()]:
    """Return the curve of one of two strips; empty for straight strips."""
    pairs = zip(forward.curve, reverse.curve, strict=True)
    return StripCurve(*(xp.where(ahead, *pair) for pair in pairs)) if forward.curve else ()


def limit_distance(xp: Namespace, distance: Scalar, endless: bool) -> Scalar:
    """Return the distance limited for processes with return points."""
    return xp.clip(distance, -FARTHEST if endless else 0.0, 1.0)


def follow_process(
    xp: Namespace, left: Left, move: OneFractionProcess, stress: Scalar, temperature: Scalar, endless: bool = False
) -> Scalar:
    """Return the martensite fraction if the move ends at (stress, temperature)."""
    distance, ahead = move.distance(stress, temperature, xp), move.direction > 0.0
    if move.course:
        share = find_left(left, xp, limit_distance(xp, distance, endless), ahead)
        (wanted,) = compute_rests(xp, move.course, share, [move.remaining])
    elif endless:
        wanted = move.remaining * find_left(left, xp, 1.0 - xp.maximum(move.scale - distance, 0.0), ahead)
    else:
        wanted = move.scale * find_left(left, xp, xp.clip(distance, 0.0, 1.0), ahead)
        wanted = xp.minimum(wanted, move.remaining)
    remaining = xp.where(xp.abs(move.direction) > 0.0, wanted, move.remaining)
    return xp.where(ahead, 1.0 - remaining, remaining)


def drop_idle_move(
    xp: Namespace, memory: OneFractionMemory, move: OneFractionProcess, stress: Scalar, temperature: Scalar
) -> OneFractionProcess:
    """Return a move without its process if that process did not act up to the end of the leg.

    A second transformation may hold the end of a step before a strip that the elastic trial entered.
    """
    first, last = (
        xp.clip(move.distance(*at, xp), 0.0, 1.0) for at in ((memory.stress, memory.temperature), (stress, temperature))
    )
    return move._replace(direction=xp.where(first > last, move.direction, 0.0))


def commit_move(
    xp: Namespace,
    memory: OneFractionMemory,
    move: OneFractionProcess,
    fraction: Scalar,
    stress: Scalar,
    temperature: Scalar,
    endless: bool = False,
) -> OneFractionMemory:
    """Return the memory after the accepted move, with unchanged return points (see `remember_points`)."""
    acted = xp.abs(move.direction) > 0.0
    scale = move.scale
    if endless and not move.course:
        scale = xp.minimum(scale, move.distance(stress, temperature, xp))
    return OneFractionMemory(
        fraction=fraction,
        branch=xp.where(acted, move.direction, memory.branch),
        scale=xp.where(acted, scale, memory.scale),
        stress=stress,
        temperature=temperature,
        points=memory.points,
    )


def remember_points(
    xp: Namespace,
    left: Left,
    before: OneFractionMemory,
    move: OneFractionProcess,
    after: OneFractionMemory,
    endless: bool = False,
) -> OneFractionMemory:
    """Return the memory after a move with its return points, for the rule return-point."""
    if not before.points or not move.course:
        return after
    ahead = move.direction > 0.0
    share = find_left(left, xp, limit_distance(xp, move.distance(after.stress, after.temperature, xp), endless), ahead)
    turned, other = before.branch * move.direction < 0.0, xp.where(ahead, before.fraction, 1.0 - before.fraction)
    rest = xp.where(ahead, 1.0 - after.fraction, after.fraction)
    interrupts = xp.both(turned, other > COMPLETE_REST)
    points = commit_course(xp, before.points, move.course, move.direction, interrupts, share, rest)
    return after._replace(points=points)


def relocate_memory(
    xp: Namespace,
    left: Left,
    strips: tuple[Strip, Strip],
    memory: OneFractionMemory,
    fraction: Scalar,
    stress: Scalar,
    temperature: Scalar,
) -> OneFractionMemory:
    """Return the memory at another fraction and another point, on the same branch.

    The ratio of the remaining fraction y to its bound, y ≤ scale · left(v), is kept: an active process continues, and a
    waiting process keeps its distance.
    """
    ahead = memory.branch > 0.0
    before, after = (
        xp.where(ahead, f.distance(*point, xp), r.distance(*point, xp))
        for f, r in [strips]
        for point in ((memory.stress, memory.temperature), (stress, temperature))
    )
    if strips[0].endless:
        scale = memory.scale + (after - before)
    else:
        was = xp.where(ahead, 1.0 - memory.fraction, memory.fraction)
        now = xp.where(ahead, 1.0 - fraction, fraction)
        then, there = (find_left(left, xp, xp.clip(v, 0.0, 1.0), ahead) for v in (before, after))
        some = xp.both(was > LEAST_REST, now > LEAST_REST)
        grown = xp.where(some, now / xp.maximum(was, LEAST_REST), 1.0)
        inside = xp.both(then > LEAST_REST, there > LEAST_REST)
        scale = memory.scale * grown * xp.where(inside, then / xp.maximum(there, LEAST_REST), 1.0)
        scale = xp.minimum(scale, MOST_SCALE)
    scale = xp.where(xp.abs(memory.branch) > 0.0, scale, memory.scale)
    return OneFractionMemory(fraction, memory.branch, scale, stress, temperature)


def compare_parts(xp: Namespace, before: Scalar, now: Scalar, least: float) -> Scalar:
    """Return the ratio of two parts if both exceed `least`; else 1."""
    some = xp.both(before > least, now > least)
    return xp.where(some, now / xp.where(some, before, 1.0), 1.0)


def relocate_points(
    xp: Namespace, left: Left, strips: tuple[Strip, Strip], memory: OneFractionMemory, after: OneFractionMemory
) -> OneFractionMemory:
    """Relocate return points: ratios of L and of remaining fractions are kept in both directions."""
    if not memory.points:
        return after

    def compare_rests(strip: Strip, forth: bool, was: Scalar, now: Scalar) -> tuple[Scalar, Scalar]:
        before, there = (
            find_left(left, xp, limit_distance(xp, strip.distance(at.stress, at.temperature, xp), strip.endless), forth)
            for at in (memory, after)
        )
        least = 0.0 if strip.endless else LEAST_REST
        return compare_parts(xp, before, there, least), compare_parts(xp, was, now, LEAST_REST)

    forward = compare_rests(strips[0], True, 1.0 - memory.fraction, 1.0 - after.fraction)
    reverse = compare_rests(strips[1], False, memory.fraction, after.fraction)
    return after._replace(points=scale_points(xp, memory.points, memory.branch > 0.0, forward, reverse))


def find_point_kinks(
    xp: Namespace, left: Left, endless: bool, memory: OneFractionMemory, ahead: Scalar, back: Scalar
) -> list[Scalar]:
    """Return numbers that cross 0 where an interrupted branch continues and where the next loop of a direction closes.

    `ahead` and `back` are the distances to the finish lines at the point of the memory.
    """
    if not memory.points:
        return []
    points, forth = memory.points, memory.branch > 0.0
    pairs = (ahead, True), (back, False)
    shares = [find_left(left, xp, limit_distance(xp, one, endless), forward) for one, forward in pairs]
    rest = xp.where(forth, 1.0 - memory.fraction, memory.fraction)
    wait = points.branch.lines[0].at(xp.where(forth, *shares)) - rest
    return [
        xp.where(xp.abs(memory.branch) > 0.0, wait, 1.0),
        find_next(xp, points.forward, points.forwards, shares[0]),
        find_next(xp, points.reverse, points.reverses, shares[1]),
    ]


def find_handover(
    xp: Namespace, forward: Strip, reverse: Strip, memory: OneFractionMemory, stress: Scalar, temperature: Scalar
) -> tuple[Scalar, Scalar]:
    """Return the point of a leg at which its first process ends and a second may begin.

    The point lies some roundings beyond the finish line, so that the first process is complete. Two endless processes
    may share a leg in three parts: reverse, forward, reverse.
    """
    f, r, back = follow_both_strips(xp, forward, reverse, memory, stress, temperature)
    two = xp.both(f.passes, r.passes)
    first, second = r.leaves, f.leaves
    if forward.endless:  # forward is followed by reverse, reverse by forward
        first = xp.maximum(f.enters, r.leaves)
        first = xp.where(first < f.leaves, first, 1.0)
        second = xp.maximum(r.enters, f.leaves)
    done = xp.where(back, first, second)
    return turning_point(xp, memory, stress, temperature, xp.where(two, done, 1.0))
