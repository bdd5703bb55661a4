"""Return points: interruptions of branches, so that nested loops close.

Let y be the remaining fraction of a direction (forward 1 - ξ, reverse ξ), and L = left(v) the value of its curve at the
distance v from its finish line: 1 on the start line, 0 on the finish line. A branch is straight in L,

    y = y_t + s (L - L_t),     s = (y_b - y_t)/(L_b - L_t),

from its beginning (b) to its target (t): the interruption of the previous branch of the same direction, or completion,
L_t = y_t = 0. At its target it continues that branch, and the loop between is wiped out. For strips without overlap
this is a Preisach operator whose weight is a product of two functions, one of each coordinate: everything follows from
the major loop.

A target is passed if L or the remaining fraction is not larger than at the target. All targets are given up, as under
the rule resume, if the remaining fraction exceeds the whole target branch, or if the way back would be `STEEPEST` times
as steep. This requires overlapping strips, C_A ≠ C_M, or a start in the middle of a loop.

The memory is bounded: beyond `DEPTH` branches per direction, a new loop replaces the innermost one, and the resulting
shift of a branch is recorded.

Sources: Mayergoyz (1986), Phys. Rev. Lett. 56, for wiping-out; the straight branches are this package's.
"""

from collections.abc import Callable, Sequence
from typing import NamedTuple

from martensite.kernels.namespace import Flag, Namespace, Scalar
from martensite.kernels.nested import NestedShape, flatten_numbers

DEPTH = 8
"""Remembered interrupted branches per direction."""
SHARE_TOLERANCE = 1e-12
"""Difference of two L or two fractions that counts as zero."""
STEEPEST = 10.0
"""Largest ratio of the slope of the way back to a branch to the slope of the branch."""
NOWHERE = 2.0 * DEPTH
NONE, PASSED = -1.0, 2.0
"""Values below and above all L."""
COMPLETE_REST = 1e-15
"""Remaining fraction that counts as complete."""


class BranchLine(NamedTuple):
    """Remaining fraction on a branch: offset + scale · L."""

    scale: Scalar
    offset: Scalar

    def at(self, share: Scalar) -> Scalar:
        """Return the remaining fraction at L = share [-]."""
        return self.offset + self.scale * share


class Branch(NamedTuple):
    """Branch and its progress."""

    share: Scalar
    """Lowest L reached [-]; negative for an invalid branch."""
    lines: tuple[BranchLine, ...]
    """One line per fraction, martensite first."""


class ReturnPoints(NamedTuple):
    """All remembered branches; interrupted branches from the outermost."""

    branch: Branch
    """Branch in progress."""
    forward: tuple[Branch, ...]
    reverse: tuple[Branch, ...]
    forwards: Scalar
    """Number of valid interrupted forward branches."""
    reverses: Scalar
    forgotten: Scalar
    """Largest change of a fraction on a branch by forgotten loops [-]."""


class BranchCourse(NamedTuple):
    """Branch in progress, and its possible targets."""

    branch: Branch
    outer: tuple[Branch, ...]
    target_count: Scalar
    """Number of valid targets."""


FallTest = Callable[[Sequence[Scalar]], Flag]
"""Test of whether fractions may change by given amounts on the way to a target."""


def start_branch(fractions: int) -> Branch:
    """Return the completed transformation, the target of a branch without interruption."""
    return Branch(0.0, (BranchLine(0.0, 0.0),) * fractions)


def start_points(fractions: int) -> ReturnPoints:
    """Return an empty memory for a number of fractions."""
    branch = start_branch(fractions)
    return ReturnPoints(branch, (branch,) * DEPTH, (branch,) * DEPTH, 0.0, 0.0, 0.0)


def choose_branch(xp: Namespace, flag: Flag, yes: Branch, no: Branch) -> Branch:
    """Return one of two branches."""
    pairs = zip(flatten_numbers(yes), flatten_numbers(no), strict=True)
    return NestedShape(no).rebuild([xp.where(flag, a, b) for a, b in pairs])


def draw_line(xp: Namespace, share: Scalar, rest: Scalar, target: Scalar, aim: Scalar) -> BranchLine:
    """Return the line through (share, rest) and (target, aim)."""
    apart = share - target
    scale = xp.where(apart > 0.0, (rest - aim) / xp.where(apart > 0.0, apart, 1.0), 0.0)
    return BranchLine(scale, aim - scale * target)


def select_course(
    xp: Namespace,
    points: ReturnPoints,
    ahead: Flag,
    turns: Flag,
    share: Scalar,
    rest: Sequence[Scalar],
    admits: FallTest | None = None,
) -> BranchCourse:
    """Return the course of a direction: the branch in progress, or a new branch from (share, rest) if it `turns`."""
    stack = [choose_branch(xp, ahead, *both) for both in zip(points.forward, points.reverse, strict=True)]
    count, complete = count_places(xp, points, ahead, turns), start_branch(len(rest))
    above = xp.where(turns, share, PASSED)
    met = [xp.both(count > float(k), above > one.share) for k, one in enumerate(stack)]
    target, valid = complete, 0.0
    for k, one in enumerate(stack):
        target, valid = choose_branch(xp, met[k], one, target), xp.where(met[k], k + 1.0, valid)
    closes = xp.either(xp.negate(turns), find_closing(xp, target, share, rest, admits))
    target, valid = choose_branch(xp, closes, target, complete), xp.where(closes, valid, 0.0)
    ends = [(target.share, line.at(target.share)) for line in target.lines]
    lines = tuple(draw_line(xp, share, a, *end) for a, end in zip(rest, ends, strict=True))
    outer = [one._replace(share=xp.where(valid > float(k), one.share, NONE)) for k, one in enumerate(stack)]
    return BranchCourse(choose_branch(xp, turns, Branch(share, lines), points.branch), tuple(outer), valid)


def count_places(xp: Namespace, points: ReturnPoints, ahead: Flag, turns: Flag) -> Scalar:
    """Return the number of branches of a direction, without the branch dropped by a turn."""
    own, other = (points.forwards, points.reverses), (points.reverses, points.forwards)
    full = xp.both(turns, xp.where(ahead, *other) >= DEPTH)
    return xp.where(ahead, *own) - xp.where(full, 1.0, 0.0)


def find_closing(xp: Namespace, target: Branch, share: Scalar, rest: Sequence[Scalar], admits: FallTest | None) -> Flag:
    """Return whether a branch from (share, rest) may lead back to its target."""
    falls = [a - line.at(target.share) for a, line in zip(rest, target.lines, strict=True)]
    line = target.lines[0]
    gentle = falls[0] <= STEEPEST * line.scale * (share - target.share)
    closes = xp.both(xp.both(falls[0] >= 0.0, gentle), rest[0] <= line.at(1.0) + SHARE_TOLERANCE)
    return xp.both(closes, admits(falls)) if admits else closes


def compute_rests(xp: Namespace, course: BranchCourse, share: Scalar, rest: Sequence[Scalar]) -> list[Scalar]:
    """Return the remainder of each fraction at L = share, at most `rest`."""
    lines = follow_lines(xp, course, share)
    return [xp.minimum(line.at(share), one) for line, one in zip(lines, rest, strict=True)]


def follow_lines(xp: Namespace, course: BranchCourse, share: Scalar) -> tuple[BranchLine, ...]:
    """Return the lines of the outermost branch met above L = share, or of the branch in progress."""
    branch = course.branch
    for one in reversed(course.outer):
        branch = choose_branch(xp, share < one.share, one, branch)
    return branch.lines


def commit_course(
    xp: Namespace,
    points: ReturnPoints,
    course: BranchCourse,
    direction: Scalar,
    interrupts: Flag,
    share: Scalar,
    left: Scalar,
) -> ReturnPoints:
    """Return the memory after a move.

    Args:
        xp: namespace.
        points: memory before.
        course: followed course.
        direction: +1 forward, -1 reverse, 0 neither.
        interrupts: true if the move interrupts an incomplete branch of the other direction.
        share: L at the end of the move [-].
        left: remaining fraction there [-].
    """
    ahead, back = direction > 0.0, direction < 0.0
    low = xp.minimum(course.branch.share, share)
    lines = follow_lines(xp, course, low - SHARE_TOLERANCE)
    branch = choose_branch(xp, xp.either(ahead, back), Branch(low, lines), points.branch)
    count = course.target_count
    for k, one in reversed(list(enumerate(course.outer))):
        count = xp.where(low - SHARE_TOLERANCE < one.share, float(k), count)
    own = xp.where(ahead, points.forwards, points.reverses)
    others = xp.where(ahead, points.reverses, points.forwards)
    full = xp.both(interrupts, others >= DEPTH)
    stopped, lost = forget_loop(xp, points, course, ahead)
    slot = xp.where(interrupts, xp.minimum(others, DEPTH - 1.0), NOWHERE)
    # a loop has one branch of each direction: both directions lose the same number
    wiped = own - count - xp.where(full, 1.0, 0.0)
    others = xp.maximum(xp.where(interrupts, slot + 1.0, others) - wiped, 0.0)
    count, others = (xp.where(left > COMPLETE_REST, number, 0.0) for number in (count, others))
    return ReturnPoints(
        branch,
        put_branch(xp, points.forward, xp.where(back, slot, NOWHERE), stopped),
        put_branch(xp, points.reverse, xp.where(ahead, slot, NOWHERE), stopped),
        xp.where(ahead, count, xp.where(back, others, points.forwards)),
        xp.where(back, count, xp.where(ahead, others, points.reverses)),
        xp.maximum(points.forgotten, xp.where(full, lost, 0.0)),
    )


def put_branch(xp: Namespace, stack: tuple[Branch, ...], slot: Scalar, branch: Branch) -> tuple[Branch, ...]:
    """Return the stack with a branch in a slot; later slots become invalid."""
    return tuple(choose_branch(xp, slot <= float(k), branch, one) for k, one in enumerate(stack))


def forget_loop(xp: Namespace, points: ReturnPoints, course: BranchCourse, ahead: Flag) -> tuple[Branch, Scalar]:
    """Return the interrupted branch, without the innermost loop of a full stack, and the resulting change [-]."""
    own, other = (points.forward, points.reverse), (points.reverse, points.forward)
    last, facing = (choose_branch(xp, ahead, yes[-1], no[-1]) for yes, no in (own, other))
    outer, stopped = choose_branch(xp, ahead, other[0][-2], other[1][-2]), points.branch
    lines = tuple(
        draw_line(xp, stopped.share, a.at(stopped.share), outer.share, b.at(outer.share))
        for a, b in zip(stopped.lines, outer.lines, strict=True)
    )
    full = xp.where(ahead, points.reverses, points.forwards) >= DEPTH
    after = choose_branch(xp, full, stopped._replace(lines=lines), stopped)
    changes = (
        xp.abs(new.lines[0].at(old.share) - old.lines[0].at(old.share))
        for new, old in ((after, facing), (course.branch, last))
    )
    return after, xp.maximum(*changes)


def scale_points(
    xp: Namespace, points: ReturnPoints, ahead: Flag, forward: Sequence[Scalar], reverse: Sequence[Scalar]
) -> ReturnPoints:
    """Return the points with L and remaining fractions multiplied by factors per direction."""

    def scale_branch(one: Branch, factors: Sequence[Scalar]) -> Branch:
        share, *rests = factors
        pairs = zip(one.lines, rests, strict=True)
        return Branch(
            one.share * share, tuple(BranchLine(a.scale * rest / share, a.offset * rest) for a, rest in pairs)
        )

    return points._replace(
        branch=choose_branch(xp, ahead, scale_branch(points.branch, forward), scale_branch(points.branch, reverse)),
        forward=tuple(scale_branch(one, forward) for one in points.forward),
        reverse=tuple(scale_branch(one, reverse) for one in points.reverse),
    )


def find_next(xp: Namespace, stack: tuple[Branch, ...], count: Scalar, share: Scalar) -> Scalar:
    """Return L less the L of the innermost valid branch; 1 without one."""
    met = stack[0].share
    for k, one in enumerate(stack[1:], 1):
        met = xp.where(count > float(k), one.share, met)
    return xp.where(count > 0.0, share - met, 1.0)
