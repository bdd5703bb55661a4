"""History of transformations with two strips: who acts, from where, and the new memory.

A process multiplies the remaining fraction by left(v₁)/left(v₀), where v is the distance to its finish line as a
fraction of the strip (1 at the start line, 0 at the finish line) of the coordinate T - σ/C. Forward (austenite →
martensite) works on y = 1 - ξ, reverse on y = ξ. Three rules define the memory; the first two differ in v₀ alone:

- resume: the v at which the branch was opened, and y never grows on it; an interrupted
  transformation waits until the path passes the point where it stopped. Opening the opposite
  branch, by an actual opposite move inside its strip, forgets it. One memory level, not
  return-point memory: inner loops do not close as in a Preisach model.
- restart: v at the start of every increment, the literal reading of the papers; small cycles
  inside one strip ratchet.
- return-point: as resume, but a branch leads back to where the one before of its direction was
  interrupted, so that loops close within loops (see `return_points`).

Where both processes could act (strips overlap when C_A and C_M differ) the branch in progress goes on, else the one met
first, else reverse. The result does not depend on how a straight leg is cut into increments.

A strip may be endless: its process goes on beyond the finish line, where v < 0, and forgets
where it began, left(a)/left(b) = left(1 - (b - a)). The memory then holds the lowest v reached
on the branch (resume) instead of a scale, so that no tail underflows. Where both processes
could act, one that is past its finish line yields to one that is not, else to reverse.
"""

from collections.abc import Callable
from typing import Any, NamedTuple, TypeAlias

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

RESUME, RESTART, RETURN_POINT = "resume", "restart", "return-point"
LEAST_REST = 1e-3
"""Part of a transformation below which nothing is left of it."""

FARTHEST = 60.0
"""Strip widths beyond its finish line from which on an endless process is complete, for return points."""


class BranchedLeft(NamedTuple):
    """Remaining fraction of a process, which depends on the direction of the process."""

    find: Callable[[Namespace, Scalar, Flag], Scalar]


Left: TypeAlias = Callable[[Namespace, Scalar], Scalar] | BranchedLeft
"""Fraction that a process leaves at a distance from its finish line."""


def find_left(left: Left, xp: Namespace, distance: Scalar, ahead: Flag) -> Scalar:
    """Return the fraction that the forward process leaves where `ahead`, else the reverse one."""
    return left.find(xp, distance, ahead) if isinstance(left, BranchedLeft) else left(xp, distance)


LegStart: TypeAlias = Any
"""Start of a leg, a memory or a place on the way: it has a `stress` [Pa] and a `temperature` [K]."""


class PathPoint(NamedTuple):
    """A point on the way."""

    stress: Scalar
    temperature: Scalar


class StripCurve(NamedTuple):
    """Tension adds bend · σ (σ - 2 calm) [K/Pa², Pa] to the middle of a strip, growth · σ [K/Pa] to start - finish."""

    bend: Scalar
    calm: Scalar
    growth: Scalar


STRAIGHT = StripCurve(0.0, 0.0, 0.0)


class Strip(NamedTuple):
    """One process: coordinate T - σ·per_slope runs from its start to its finish line."""

    finish: Scalar
    """Finish temperature at zero stress [K]."""
    per_width: Scalar
    """1/(start - finish) [1/K]; negative for the reverse process."""
    per_slope: Scalar
    """1/C [K/Pa]."""
    endless: bool = False
    """The process goes on beyond its finish line; a word of the law, not a value."""
    curve: StripCurve | tuple[()] = ()
    """Curve of the lines, if they are not straight."""

    def distance(self, stress: Scalar, temperature: Scalar, xp: Namespace = floats) -> Scalar:
        """Return the unlimited distance to the finish line in widths of the strip [-]; `xp` serves curved lines."""
        straight = (temperature - stress * self.per_slope - self.finish) * self.per_width
        if not self.curve:
            return straight
        tension, width = xp.maximum(stress, 0.0), 1.0 / self.per_width
        bend = self.curve.bend * tension * (tension - 2.0 * self.curve.calm)
        return 0.5 + ((straight - 0.5) * width - bend) / (width + self.curve.growth * tension)

    def find_level(
        self, xp: Namespace, start: LegStart, stress: Scalar, ends: tuple[Scalar, Scalar], level: Scalar
    ) -> Scalar:
        """Return the share of a leg after which a distance that falls all along it comes down to a level; 1 if nowhere.

        It is the root of (distance - level) · width, a parabola over the leg.
        """
        before, after, square = self._describe_leg(xp, start.stress, stress)
        above, below = (ends[0] - level) * before, (ends[1] - level) * after
        slope = below - above - square
        root, falls = xp.sqrt(xp.maximum(slope * slope - 4.0 * above * square, 0.0)), slope < 0.0
        late = (slope + root) / xp.where(square < 0.0, -2.0 * square, 1.0)
        share = xp.where(falls, 2.0 * above / xp.where(falls, root - slope, 1.0), late)
        return xp.where(ends[0] > level, xp.where(ends[1] < level, xp.clip(share, 0.0, 1.0), 1.0), 0.0)

    def find_turn(self, xp: Namespace, start: LegStart, stress: Scalar, temperature: Scalar) -> Scalar:
        """Return the share of a leg of one sign after which the distance may turn; 1 if nowhere.

        There (distance - ½) = N/W is level, N'W = N W'; of both roots the one on this side of W = 0.
        """
        before, after, square = self._describe_leg(xp, start.stress, stress)
        here = (self.distance(start.stress, start.temperature, xp) - 0.5) * before
        there, bent = (self.distance(stress, temperature, xp) - 0.5) * after, square * before
        level = (there - here - square) * before - (after - before) * here
        root = xp.sqrt(xp.maximum(bent * bent - square * (after - before) * level, 0.0))
        down = bent + xp.where(square < 0.0, -root, root)
        share = -level / xp.where(xp.abs(down) > 0.0, down, 1.0)
        return xp.where(xp.both(share > 0.0, xp.abs(down) > 0.0), xp.minimum(share, 1.0), 1.0)

    def _describe_leg(self, xp: Namespace, before: Scalar, stress: Scalar) -> tuple[Scalar, Scalar, Scalar]:
        """Return the widths at both ends of a leg, positive, and what is square in the share of it of N [K]."""
        curve, first, last = self.curve or STRAIGHT, xp.maximum(before, 0.0), xp.maximum(stress, 0.0)
        one, other = (xp.abs(1.0 / self.per_width + curve.growth * tension) for tension in (first, last))
        return one, other, xp.where(self.per_width > 0.0, -1.0, 1.0) * curve.bend * (last - first) * (last - first)


class OneFractionMemory(NamedTuple):
    """All that a one-fraction law remembers."""

    fraction: Scalar
    branch: Scalar
    """+1 forward, -1 reverse in progress, 0 none yet."""
    scale: Scalar
    """Remaining fraction at the start line of this branch [-].

    Of an endless process: the lowest distance it has reached on this branch.
    """
    stress: Scalar
    temperature: Scalar
    points: ReturnPoints | tuple[()] = ()
    """Under the rule return-point, instead of a scale."""


class OneFractionProcess(NamedTuple):
    """The process selected for an increment, and all that `follow` needs of it."""

    direction: Scalar
    scale: Scalar
    remaining: Scalar
    """Remaining fraction before the move [-]."""
    finish: Scalar
    per_width: Scalar
    per_slope: Scalar
    course: BranchCourse | tuple[()] = ()
    """Under the rule return-point."""
    curve: StripCurve | tuple[()] = ()
    """Curve of the lines, if they are not straight."""

    def distance(self, stress: Scalar, temperature: Scalar, xp: Namespace = floats) -> Scalar:
        """Return the distance to the finish line of the process in widths of its strip [-]; unlimited."""
        strip = Strip(self.finish, self.per_width, self.per_slope, curve=self.curve)
        return strip.distance(stress, temperature, xp)


def compute_cosine_rest(xp: Namespace, distance: Scalar) -> Scalar:
    """Return the fraction that a cosine process leaves at a distance from its finish line."""
    sine = xp.quarter_sine(distance)
    return sine * sine


class StripLeg(NamedTuple):
    """One strip along one straight leg."""

    begin: Scalar
    """Distance at the start, limited to [0, 1], or to at most 1 if endless."""
    ahead: Flag
    """The finish line is not reached yet at the start."""
    passes: Flag
    """The leg moves towards the finish line inside the strip, from a point not on that line."""
    acts: Flag
    """True if the process acts, and some fraction remains."""
    enters: Scalar
    """Share of the leg after which the strip is entered."""
    leaves: Scalar
    """Share of the leg after which the finish line is reached."""


def round_off(xp: Namespace, strip: Strip, start: LegStart, stress: Scalar, temperature: Scalar) -> Scalar:
    """Return the rounding error of the distance [-] travelled on a leg."""
    size = xp.abs(start.temperature) + xp.abs(temperature)
    size = size + (xp.abs(start.stress) + xp.abs(stress)) * strip.per_slope
    if strip.curve:
        most = xp.maximum(xp.maximum(start.stress, stress), 0.0)
        size = size + xp.abs(strip.curve.bend) * most * (most + 2.0 * strip.curve.calm)
    return 8.0 * xp.eps() * size * xp.abs(strip.per_width)


def follow_strip(
    xp: Namespace, strip: Strip, start: LegStart, stress: Scalar, temperature: Scalar, left: Scalar
) -> StripLeg:
    """Follow one strip's coordinate along the leg from its starting point.

    What differs by rounding alone is equal: a point so near to the start line lies on it, and
    a leg that gets no further into the strip does not pass.
    """
    first = strip.distance(start.stress, start.temperature, xp)
    last = strip.distance(stress, temperature, xp)
    travel, hair = first - last, round_off(xp, strip, start, stress, temperature)
    moving = travel > hair
    safe = xp.where(moving, travel, 1.0)
    enters = xp.clip((first - 1.0 - hair) / safe, 0.0, 1.0)
    leaves = xp.clip(first / safe, 0.0, 1.0)
    if strip.curve:
        enters, leaves = (strip.find_level(xp, start, stress, (first, last), level) for level in (1.0 + hair, 0.0))
    if strip.endless:
        before = xp.where(xp.abs(first - 1.0) > hair, first - 1.0, 0.0)
        begin, enters = 1.0 + xp.minimum(before, 0.0), xp.clip(before / safe, 0.0, 1.0)
        passes = xp.both(moving, last + hair < 1.0)
        return StripLeg(begin, begin > hair, passes, xp.both(passes, left > 0.0), enters, leaves)
    begin, end = xp.clip(first, 0.0, 1.0), xp.clip(last, 0.0, 1.0)
    ahead = begin > hair
    passes = xp.both(begin - end > hair, ahead)
    return StripLeg(begin, ahead, passes, xp.both(passes, left > 0.0), enters, leaves)


def follow_both_strips(
    xp: Namespace, forward: Strip, reverse: Strip, memory: OneFractionMemory, stress: Scalar, temperature: Scalar
) -> tuple[StripLeg, StripLeg, Flag]:
    """Return both courses of a leg, and whether the reverse process acts first."""
    f = follow_strip(xp, forward, memory, stress, temperature, 1.0 - memory.fraction)
    r = follow_strip(xp, reverse, memory, stress, temperature, memory.fraction)
    if forward.endless:
        return endless_turns(xp, f, r, memory.branch)
    tie = xp.both(r.enters <= f.enters, memory.branch <= 0.0)
    earlier = xp.either(r.enters < f.enters, tie)
    return f, r, xp.both(r.acts, xp.either(xp.negate(f.acts), earlier))


def endless_turns(xp: Namespace, f: StripLeg, r: StripLeg, branch: Scalar) -> tuple[StripLeg, StripLeg, Flag]:
    """Decide the turns of endless processes.

    One in progress has always something left to transform, though rounding may hide it. From
    where both could act, one that is past its finish line waits for the other.
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
    """Return the process that a straight leg to (stress, temperature) sets off first."""
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
    """Return the curve of one of two strips; none if they are straight."""
    pairs = zip(forward.curve, reverse.curve, strict=True)
    return StripCurve(*(xp.where(ahead, *pair) for pair in pairs)) if forward.curve else ()


def limit_distance(xp: Namespace, distance: Scalar, endless: bool) -> Scalar:
    """Return the distance at which a process is looked at that remembers return points."""
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


def commit_move(
    xp: Namespace,
    memory: OneFractionMemory,
    move: OneFractionProcess,
    fraction: Scalar,
    stress: Scalar,
    temperature: Scalar,
    endless: bool = False,
) -> OneFractionMemory:
    """Return the memory after the accepted move; return points are those of before (`remember_points`)."""
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
    """Return the memory after a move with its return points, if its rule has them."""
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

    Its scale keeps the ratio of the remaining fraction y to its bound, y ≤ scale · left(v): an active process
    continues, and a waiting process keeps its distance.
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
    scale = xp.where(xp.abs(memory.branch) > 0.0, scale, memory.scale)
    return OneFractionMemory(fraction, memory.branch, scale, stress, temperature)


def compare_parts(xp: Namespace, before: Scalar, now: Scalar, least: float) -> Scalar:
    """By how much a part has grown, if there was and is more than a least one of it; else 1."""
    some = xp.both(before > least, now > least)
    return xp.where(some, now / xp.where(some, before, 1.0), 1.0)


def relocate_points(
    xp: Namespace, left: Left, strips: tuple[Strip, Strip], memory: OneFractionMemory, after: OneFractionMemory
) -> OneFractionMemory:
    """Relocate a memory under the rule return-point: L and remaining fractions of both directions keep their ratios."""
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

    The two distances to the finish lines are those at the point of the memory.
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
    """Return the point of a leg at which its first process is done and a second may begin.

    It lies some roundings beyond the finish line, so that the first process is complete. The
    second needs nothing to transform before: the first one makes it. Two endless processes may
    share a leg in three parts: reverse, forward, reverse.
    """
    f, r, back = follow_both_strips(xp, forward, reverse, memory, stress, temperature)
    two = xp.both(f.passes, r.passes)
    first, second = r.leaves, f.leaves
    if forward.endless:  # see courses: forward is followed by reverse, reverse by forward
        first = xp.maximum(f.enters, r.leaves)
        first = xp.where(first < f.leaves, first, 1.0)
        second = xp.maximum(r.enters, f.leaves)
    done = xp.where(back, first, second)
    return turning_point(xp, memory, stress, temperature, xp.where(two, done, 1.0))


def find_zero_stress(xp: Namespace, start: LegStart, stress: Scalar, temperature: Scalar) -> tuple[Scalar, Scalar]:
    """Return the point of a leg where its stress changes sign; its end if nowhere."""
    crosses = start.stress * stress < 0.0
    share = start.stress / xp.where(crosses, start.stress - stress, 1.0)
    return turning_point(xp, start, stress, temperature, xp.where(crosses, share, 1.0))


def find_turn(
    xp: Namespace, strips: tuple[Strip, Strip], start: LegStart, stress: Scalar, temperature: Scalar
) -> tuple[Scalar, Scalar]:
    """Return the first point of a leg where curved lines turn it, or tension begins or ends; else its end."""
    end = find_zero_stress(xp, start, stress, temperature)
    turns = [strip.find_turn(xp, start, *end) for strip in strips]
    return turning_point(xp, start, *end, xp.minimum(*turns))


def turning_point(
    xp: Namespace, start: LegStart, stress: Scalar, temperature: Scalar, done: Scalar
) -> tuple[Scalar, Scalar]:
    """Return the point of a leg some roundings beyond a share of it; its end exactly at the end."""
    share = xp.minimum(1.0, done + 64.0 * xp.eps())
    whole = share >= 1.0
    turn_stress = start.stress + share * (stress - start.stress)
    turn_temperature = start.temperature + share * (temperature - start.temperature)
    return (xp.where(whole, stress, turn_stress), xp.where(whole, temperature, turn_temperature))
