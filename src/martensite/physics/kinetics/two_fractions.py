"""Kinetics of two martensite fractions: detwinned by stress (S), twinned by cooling (T).

The strips are in `two_fraction_legs`; the rules resume and restart are those of `history`. S and T may act together in
any order (product law): with r = (1 - P₁)/(1 - P₀) of each,

    forward   1 - ξ_S = (1 - ξ_S0) r_S,   1 - ξ = (1 - ξ₀) r_S r_T
    reverse   ξ_S = ξ_S0 r,               ξ = ξ₀ r

The memory is the smallest distance of each process from its finish line since the branch was opened.

Under the rule return-point (`return_points`) both fractions are straight in L of the active process, 1 - ξ and 1 - ξ_S
forward, ξ and ξ_S in reverse, from the beginning of a branch to its target. Forward return points belong to one
process, S or T: the first to act (S if both act). The other process then follows the rule resume and multiplies the
remaining fraction, also at these points. A target is also given up if reverse would increase a fraction, or S the
twins.
"""

from collections.abc import Sequence
from typing import NamedTuple

from martensite.kernels.namespace import Flag, Namespace, Scalar
from martensite.physics.kinetics.history import LEAST_REST, RESTART, RESUME, RETURN_POINT, compare_parts
from martensite.physics.kinetics.return_points import (
    COMPLETE_REST,
    SHARE_TOLERANCE,
    Branch,
    BranchCourse,
    BranchLine,
    ReturnPoints,
    choose_branch,
    commit_course,
    compute_rests,
    draw_line,
    scale_points,
    select_course,
    start_points,
)
from martensite.physics.kinetics.strip_legs import PathPoint, Strip, compute_cosine_rest, round_off
from martensite.physics.kinetics.two_fraction_legs import (
    UNSET,
    Courses,
    Diagram,
    TwinPoints,
    TwoFractionMemory,
    find_kink,
)
from martensite.physics.laws.base import Fork, Fractions


class TwoFractionDirection(NamedTuple):
    """Direction selected for a leg."""

    direction: Scalar
    martensite: Scalar
    oriented: Scalar
    stress: Scalar
    """At the start of the leg [Pa]."""
    temperature: Scalar
    finish: Scalar
    """Finish line of the strip of S or reverse, whichever acts; also for the next two fields."""
    per_width: Scalar
    per_slope: Scalar
    bend: Scalar
    """Temperature below which the lines of that strip are horizontal [K]."""
    reach: Scalar
    """Distance below which S or reverse transforms."""
    cooling: Scalar
    """Reach of T."""
    course: BranchCourse | tuple[()] = ()
    """Used by the rule return-point."""
    twinned: Scalar = 0.0
    """1 for a course of T."""

    def strip(self) -> Strip:
        """Return the strip of S or of reverse, whichever acts."""
        return Strip(self.finish, self.per_width, self.per_slope)


def start_memory(rule: str, fractions: Fractions, stress: Scalar, temperature: Scalar) -> TwoFractionMemory:
    """Return the memory of a phase state without history."""
    reaches, points = (UNSET, UNSET, UNSET), TwinPoints(start_points(2), 0.0) if rule == RETURN_POINT else ()
    return TwoFractionMemory(fractions.martensite, fractions.oriented, 0.0, *reaches, stress, temperature, points)


def relocate_memory(
    xp: Namespace,
    diagram: Diagram,
    memory: TwoFractionMemory,
    fractions: Fractions,
    stress: Scalar,
    temperature: Scalar,
) -> TwoFractionMemory:
    """Return the memory at other fractions and another point, on the same branch.

    Reaches shift with the distances: an active process continues, and a waiting process keeps its distance.
    """

    def shift_reach(strip: Strip, reach: Scalar, bend: Scalar) -> Scalar:
        before = strip.distance(memory.stress, xp.maximum(memory.temperature, bend))
        after = strip.distance(stress, xp.maximum(temperature, bend))
        return xp.where(reach < UNSET, xp.clip(reach + (after - before), 0.0, UNSET), reach)

    reaches = (
        shift_reach(diagram.loading, memory.loading, diagram.bend),
        shift_reach(diagram.cooling, memory.cooling, 0.0),
        shift_reach(diagram.reverse, memory.reverse, 0.0),
    )
    if not memory.recalled:
        return TwoFractionMemory(*fractions, memory.branch, *reaches, stress, temperature)
    of_twins, origin = memory.recalled.twinned > 0.5, (memory.stress, memory.temperature)

    def compare_shares(main: Strip, bend: Scalar) -> Scalar:
        distances = (main.distance(s, xp.maximum(t, bend)) for s, t in (origin, (stress, temperature)))
        before, after = (compute_cosine_rest(xp, xp.clip(v, 0.0, 1.0)) for v in distances)
        return compare_parts(xp, before, after, LEAST_REST)

    changes = list(zip((memory.martensite, memory.oriented), fractions, strict=True))
    forth = xp.where(of_twins, compare_shares(diagram.cooling, 0.0), compare_shares(diagram.loading, diagram.bend))
    forward = [forth, *(compare_parts(xp, 1.0 - a, 1.0 - b, LEAST_REST) for a, b in changes)]
    reverse = [compare_shares(diagram.reverse, 0.0), *(compare_parts(xp, a, b, LEAST_REST) for a, b in changes)]
    points = scale_points(xp, memory.recalled.points, memory.branch > 0.0, forward, reverse)
    recalled = memory.recalled._replace(points=points)
    return TwoFractionMemory(*fractions, memory.branch, *reaches, stress, temperature, recalled)


def list_forks(xp: Namespace, rule: str, diagram: Diagram, memory: TwoFractionMemory) -> list[Fork]:
    """Return the branch of S or reverse, and the branch of T, which reverse forgets under the rule resume."""
    if rule != RESUME:
        return []
    ahead = memory.branch > 0.0
    strips = diagram.loading, diagram.cooling, diagram.reverse
    kelvins = xp.maximum(memory.temperature, diagram.bend), memory.temperature, memory.temperature
    distances = [one.distance(memory.stress, kelvin) for one, kelvin in zip(strips, kelvins, strict=True)]
    s, t, r = ((v - 1.0) / xp.abs(one.per_width) for v, one in zip(distances, strips, strict=True))
    reaches = memory.loading, memory.cooling, memory.reverse
    left = [compute_rest_ratio(xp, xp.clip(v, 0.0, 1.0), reach) for v, reach in zip(distances, reaches, strict=True)]

    def wait(rest: Scalar, share: Scalar) -> tuple[Scalar, Scalar]:
        return rest, xp.where(share > 0.0, rest / xp.where(share > 0.0, share, 1.0), rest)

    rest = xp.where(ahead, 1.0 - memory.oriented, memory.martensite)
    forward, back = xp.minimum(s, t), xp.where(ahead, 1.0 - memory.martensite, 0.0)
    distances = xp.where(ahead, forward, r), xp.where(ahead, r, forward)
    waits = wait(rest, xp.where(ahead, left[0], left[2])), wait(back, left[1])
    return [Fork(memory.branch, *distances, *one) for one in waits]


def select_direction(
    xp: Namespace, rule: str, diagram: Diagram, memory: TwoFractionMemory, courses: Courses
) -> TwoFractionDirection:
    """Return the first direction of a leg, and its start."""
    course, twinned = select_points(xp, memory, courses)
    whole = courses.loading, courses.cooling, courses.reverse
    s, t, r = (xp.where(one.ahead, one.begin, 0.0) for one in whole)
    if rule != RESTART:
        s, t = xp.minimum(memory.loading, s), xp.minimum(memory.cooling, t)
        r = xp.minimum(memory.reverse, r)
    ahead = courses.ahead
    main, back = diagram.loading, diagram.reverse
    return TwoFractionDirection(
        xp.where(courses.back, -1.0, xp.where(ahead, 1.0, 0.0)),
        memory.martensite,
        memory.oriented,
        memory.stress,
        memory.temperature,
        finish=xp.where(ahead, main.finish, back.finish),
        per_width=xp.where(ahead, main.per_width, back.per_width),
        per_slope=xp.where(ahead, main.per_slope, back.per_slope),
        bend=xp.where(ahead, diagram.bend, 0.0),
        reach=xp.where(ahead, s, r),
        cooling=t,
        course=course,
        twinned=twinned,
    )


def turn_points(
    xp: Namespace, memory: TwoFractionMemory, recalled: TwinPoints, direction: Scalar
) -> tuple[ReturnPoints, Flag]:
    """Return the return points at the start of a move, empty after a complete branch; and whether it interrupts one.

    Forward is complete without twins and austenite: twins that complete the martensite interrupt a branch of S.
    """
    points, turned = recalled.points, memory.branch * direction < 0.0
    goes_on = xp.where(direction > 0.0, memory.martensite, 1.0 - memory.oriented) > COMPLETE_REST
    forget = xp.both(turned, xp.negate(goes_on))
    forwards, reverses = (xp.where(forget, 0.0, one) for one in (points.forwards, points.reverses))
    return points._replace(forwards=forwards, reverses=reverses), xp.both(turned, goes_on)


def select_points(
    xp: Namespace, memory: TwoFractionMemory, courses: Courses
) -> tuple[BranchCourse | tuple[()], Scalar]:
    """Return the course to return points, and 1 if it belongs to T."""
    if not memory.recalled:
        return (), 0.0
    before = memory.recalled.twinned
    points, _ = turn_points(
        xp, memory, memory.recalled, xp.where(courses.ahead, 1.0, xp.where(courses.back, -1.0, 0.0))
    )
    s, t, r = courses.loading, courses.cooling, courses.reverse
    ahead, acts = courses.ahead, xp.either(courses.ahead, courses.back)
    turns = xp.both(acts, memory.branch * xp.where(ahead, 1.0, -1.0) <= 0.0)
    free = xp.both(xp.both(ahead, turns), points.forwards < 0.5)
    alone = xp.where(xp.both(t.acts, xp.negate(s.acts)), 1.0, 0.0)
    twinned = xp.where(free, alone, before)
    begin = xp.where(ahead, xp.where(twinned > 0.5, t.begin, s.begin), r.begin)

    def admits_falls(falls: Sequence[Scalar]) -> Flag:
        all_of_it, oriented = falls
        forth = xp.either(twinned > 0.5, all_of_it <= oriented + SHARE_TOLERANCE)
        back = xp.both(oriented >= -SHARE_TOLERANCE, oriented <= all_of_it + SHARE_TOLERANCE)
        return xp.either(xp.both(ahead, forth), xp.both(courses.back, back))

    rest = [xp.where(ahead, 1.0 - one, one) for one in (memory.martensite, memory.oriented)]
    return select_course(xp, points, ahead, turns, compute_cosine_rest(xp, begin), rest, admits_falls), twinned


def compute_distances(
    xp: Namespace, diagram: Diagram, move: TwoFractionDirection, stress: Scalar, temperature: Scalar
) -> tuple[Scalar, Scalar]:
    """Return the smallest distance of S or reverse on a leg that ends there, and the final distance of T."""
    strip = move.strip()
    crosses, _, turn = find_kink(xp, move.bend, PathPoint(move.stress, move.temperature), stress, temperature)
    end = strip.distance(stress, xp.maximum(temperature, move.bend))
    least = xp.where(crosses, xp.minimum(end, strip.distance(turn, move.bend)), end)
    cooling = diagram.cooling.distance(stress, temperature)
    return xp.clip(least, 0.0, 1.0), xp.clip(cooling, 0.0, 1.0)


def compute_rest_ratio(xp: Namespace, reach: Scalar, distance: Scalar) -> Scalar:
    """Return (1 - P₁)/(1 - P₀) of a cosine process; 1 if it is complete."""
    left = reach > 0.0
    share = xp.quarter_sine(xp.minimum(reach, distance))
    share = share / xp.quarter_sine(xp.where(left, reach, 1.0))
    return xp.where(left, share * share, 1.0)


def follow_direction(
    xp: Namespace, diagram: Diagram, move: TwoFractionDirection, stress: Scalar, temperature: Scalar
) -> Fractions:
    """Return the fractions if the move ends at (stress, temperature)."""
    distance, cooled = compute_distances(xp, diagram, move, stress, temperature)
    first, second = (compute_rest_ratio(xp, move.reach, distance), compute_rest_ratio(xp, move.cooling, cooled))
    oriented = move.oriented + (1.0 - move.oriented) * (1.0 - first)
    martensite = move.martensite + (1.0 - move.martensite) * (1.0 - first * second)
    martensite = xp.maximum(martensite, oriented)
    ahead, back = move.direction > 0.0, move.direction < 0.0
    rest = xp.where(back, first, 1.0)
    if move.course:
        twinned, left = move.twinned > 0.5, [xp.where(ahead, 1.0 - x, x) for x in (move.martensite, move.oriented)]
        share = compute_cosine_rest(xp, xp.where(xp.both(ahead, twinned), cooled, distance))
        whole, part = compute_rests(xp, move.course, share, left)
        forward = 1.0 - whole * xp.where(twinned, first, second)
        oriented = xp.where(twinned, oriented, 1.0 - part)
        reduced = Fractions(xp.where(back, whole, move.martensite), xp.where(back, part, move.oriented))
        return Fractions(
            xp.where(ahead, xp.maximum(forward, oriented), reduced.martensite),
            xp.where(ahead, oriented, xp.minimum(reduced.oriented, reduced.martensite)),
        )
    return Fractions(
        xp.where(ahead, martensite, move.martensite * rest), xp.where(ahead, oriented, move.oriented * rest)
    )


def commit_move(
    xp: Namespace,
    rule: str,
    diagram: Diagram,
    memory: TwoFractionMemory,
    move: TwoFractionDirection,
    fractions: Fractions,
    stress: Scalar,
    temperature: Scalar,
) -> TwoFractionMemory:
    """Return the memory after the accepted move; the reach of the other direction is cleared."""
    ahead, back = move.direction > 0.0, move.direction < 0.0
    branch = xp.where(xp.either(ahead, back), move.direction, memory.branch)
    reaches = memory.loading, memory.cooling, memory.reverse
    recalled = memory.recalled
    if rule != RESTART:
        first, cooled = compute_distances(xp, diagram, move, stress, temperature)
        rounding = round_off(xp, move.strip(), memory, stress, temperature)
        falls = move.reach - first > rounding
        cools = move.cooling - cooled > round_off(xp, diagram.cooling, memory, 0.0, temperature)
        loading = xp.where(falls, first, memory.loading)
        cooling = xp.where(cools, cooled, memory.cooling)
        reverse = xp.where(falls, first, memory.reverse)
        reaches = (
            xp.where(ahead, loading, xp.where(back, UNSET, memory.loading)),
            xp.where(ahead, cooling, xp.where(back, UNSET, memory.cooling)),
            xp.where(back, reverse, xp.where(ahead, UNSET, memory.reverse)),
        )
        recalled = remember_points(xp, memory, move, fractions, (first, cooled), reaches[0])
    return TwoFractionMemory(*fractions, branch, *reaches, stress, temperature, recalled)


def remember_points(
    xp: Namespace,
    memory: TwoFractionMemory,
    move: TwoFractionDirection,
    fractions: Fractions,
    distances: tuple[Scalar, Scalar],
    loading: Scalar,
) -> TwinPoints | tuple[()]:
    """Return the return points after a move.

    Args:
        xp: namespace.
        memory: memory before the move.
        move: accepted move.
        fractions: fractions at its end.
        distances: result of `compute_distances`.
        loading: reach of S at its end.
    """
    if not memory.recalled or not move.course:
        return ()
    ahead = move.direction > 0.0
    of_twins = xp.both(ahead, move.twinned > 0.5)
    points, interrupts = turn_points(xp, memory, memory.recalled, move.direction)
    rest = [xp.where(ahead, 1.0 - one, one) for one in fractions]
    first, cooled = distances
    ratios = compute_rest_ratio(xp, move.reach, first), compute_rest_ratio(xp, move.cooling, cooled)
    end, left = compute_cosine_rest(xp, xp.where(of_twins, cooled, first)), xp.where(ahead, rest[1], rest[0])
    points = commit_course(xp, points, move.course, move.direction, interrupts, end, left)
    # the other process multiplies the remaining fraction, so the order of the two does not matter
    ratio = xp.where(ahead, xp.where(of_twins, *ratios), 1.0)
    branch, *forward = (scale_martensite(one, ratio) for one in (points.branch, *points.forward))
    turns_to_s = xp.both(xp.both(of_twins, ratios[0] < 1.0), points.forwards < 0.5)
    share = compute_cosine_rest(xp, loading)
    fresh = Branch(share, tuple(draw_line(xp, share, one, 0.0, 0.0) for one in rest))
    points = points._replace(branch=choose_branch(xp, turns_to_s, fresh, branch), forward=tuple(forward))
    return TwinPoints(points, xp.where(turns_to_s, 0.0, move.twinned))


def scale_martensite(branch: Branch, ratio: Scalar) -> Branch:
    """Return the branch with the remaining martensite fraction multiplied by a ratio."""
    whole, oriented = branch.lines
    return branch._replace(lines=(BranchLine(whole.scale * ratio, whole.offset * ratio), oriented))


def compute_crossing(
    xp: Namespace,
    diagram: Diagram,
    memory: TwoFractionMemory,
    move: TwoFractionDirection,
    stress: Scalar,
    temperature: Scalar,
) -> Scalar:
    """Return the largest fraction of a strip that the selected direction crosses on a move [-]."""
    first, cooled = compute_distances(xp, diagram, move, stress, temperature)
    warm = xp.maximum(memory.temperature, move.bend)
    begin = xp.clip(move.strip().distance(memory.stress, warm), 0.0, 1.0)
    before = xp.clip(diagram.cooling.distance(memory.stress, memory.temperature), 0.0, 1.0)
    crossed = xp.maximum(begin - first, 0.0)
    both = xp.maximum(crossed, before - cooled)
    return xp.where(move.direction > 0.0, both, xp.where(move.direction < 0.0, crossed, 0.0))
