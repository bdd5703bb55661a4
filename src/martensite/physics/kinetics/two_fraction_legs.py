"""Strips of two martensite fractions along one straight leg: detwinned by stress (S), twinned by cooling (T), reverse.

The strips are `strip_legs.Strip`. S runs along s = σ - C_M max(T - M_s, 0), which is straight on a leg except for a
kink at T = M_s, and never convex: its deepest point is the kink or an end of the leg. `two_fractions` has the kinetics.
"""

from typing import NamedTuple

from martensite.kernels.namespace import Flag, Namespace, Scalar
from martensite.physics.kinetics.history import RESTART
from martensite.physics.kinetics.return_points import ReturnPoints
from martensite.physics.kinetics.strip_legs import PathPoint, Strip, StripLeg, follow_strip, turning_point

UNSET = 1.0
"""Distance to the finish line that no process has reduced."""


class Diagram(NamedTuple):
    """Strips of the three processes, and the bend of S."""

    loading: Strip
    """S, as a strip of T - σ/C_M above the bend."""
    cooling: Strip
    """T, independent of stress."""
    reverse: Strip
    bend: Scalar
    """M_s [K], below which the lines of S are horizontal."""


class TwinPoints(NamedTuple):
    """Return points; forward ones belong to T or S."""

    points: ReturnPoints
    twinned: Scalar
    """1 for T."""


class TwoFractionMemory(NamedTuple):
    """Memory of a law with two fractions; a reach is a distance in [0, 1]."""

    martensite: Scalar
    oriented: Scalar
    branch: Scalar
    """+1 forward, -1 reverse in progress, 0 initially."""
    loading: Scalar
    """Reach of S on this branch [-]."""
    cooling: Scalar
    """Reach of T on this branch [-]."""
    reverse: Scalar
    """Reach of the reverse process on this branch [-]."""
    stress: Scalar
    temperature: Scalar
    recalled: TwinPoints | tuple[()] = ()
    """Used by the rule return-point."""


class Courses(NamedTuple):
    """The three processes along a leg."""

    loading: StripLeg
    cooling: StripLeg
    reverse: StripLeg
    ahead: Flag
    """True if forward (S, T or both) acts first."""
    back: Flag
    """True if reverse acts first."""


def list_kinks(xp: Namespace, rule: str, diagram: Diagram, memory: TwoFractionMemory) -> list[Scalar]:
    """Return the distances to all kinks of the processes [-]: the bend of S, and the starts of S, T and reverse.

    The distance of a complete process is 1.
    """
    at, oriented, twinned = memory.stress, 1.0 - memory.oriented, 1.0 - memory.martensite
    rows = (
        (diagram.loading, xp.maximum(memory.temperature, diagram.bend), memory.loading, oriented),
        (diagram.cooling, memory.temperature, memory.cooling, twinned),
        (diagram.reverse, memory.temperature, memory.reverse, memory.martensite),
    )
    reaches = (UNSET if rule == RESTART else reach for *_, reach, _ in rows)
    ahead = [strip.distance(at, kelvin) - reach for (strip, kelvin, *_), reach in zip(rows, reaches, strict=True)]
    above = (memory.temperature - diagram.bend) * diagram.cooling.per_width
    return [above, -above, *(xp.where(left > 0.0, one, 1.0) for one, (*_, left) in zip(ahead, rows, strict=True))]


def find_kink(
    xp: Namespace, bend: Scalar, start: PathPoint, stress: Scalar, temperature: Scalar
) -> tuple[Flag, Scalar, Scalar]:
    """Return whether a leg crosses the bend, after which fraction of it, and the stress there."""
    before, after = start.temperature - bend, temperature - bend
    crosses = before * after < 0.0
    share = xp.where(crosses, before / xp.where(crosses, before - after, 1.0), 1.0)
    return crosses, share, start.stress + share * (stress - start.stress)


def bent_course(
    xp: Namespace,
    strip: Strip,
    bend: Scalar,
    memory: TwoFractionMemory,
    stress: Scalar,
    temperature: Scalar,
    left: Scalar,
) -> StripLeg:
    """Return S along a leg, a straight piece on each side of the kink."""
    start = PathPoint(memory.stress, memory.temperature)
    crosses, share, turn = find_kink(xp, bend, start, stress, temperature)
    end = PathPoint(stress, xp.maximum(temperature, bend))
    middle = PathPoint(xp.where(crosses, turn, stress), xp.where(crosses, bend, end.temperature))
    start = PathPoint(start.stress, xp.maximum(start.temperature, bend))
    one = follow_strip(xp, strip, start, *middle, left)
    two = follow_strip(xp, strip, middle, *end, left)
    rest = 1.0 - share
    enters = xp.where(one.passes, share * one.enters, share + rest * two.enters)
    leaves = xp.where(two.passes, share + rest * two.leaves, share * one.leaves)
    passes, acts = xp.either(one.passes, two.passes), xp.either(one.acts, two.acts)
    return one._replace(passes=passes, acts=acts, enters=enters, leaves=leaves)


def follow_all_strips(
    xp: Namespace, diagram: Diagram, memory: TwoFractionMemory, stress: Scalar, temperature: Scalar
) -> Courses:
    """Return each process along a leg, and the first to act.

    If reverse may also act, S acts above the bend or on heating, T only below the bend on cooling: T never precedes S.
    """
    to = stress, temperature
    s = bent_course(xp, diagram.loading, diagram.bend, memory, *to, 1.0 - memory.oriented)
    t = follow_strip(xp, diagram.cooling, memory, *to, 1.0 - memory.martensite)
    r = follow_strip(xp, diagram.reverse, memory, *to, memory.martensite)
    forward = xp.either(s.acts, t.acts)
    enters = xp.where(s.acts, s.enters, t.enters)
    tie = xp.both(r.enters <= enters, memory.branch <= 0.0)
    earlier = xp.either(r.enters < enters, tie)
    back = xp.both(r.acts, xp.either(xp.negate(forward), earlier))
    return Courses(s, t, r, xp.both(forward, xp.negate(back)), back)


def find_handover(
    xp: Namespace, courses: Courses, memory: TwoFractionMemory, stress: Scalar, temperature: Scalar
) -> tuple[Scalar, Scalar]:
    """Return the point of a leg, some roundings late, at which the first direction ends and the other may begin."""
    s, t, r = courses.loading, courses.cooling, courses.reverse
    two = xp.both(r.passes, xp.either(s.passes, t.passes))
    forward = xp.where(s.acts, s.leaves, t.leaves)
    done = xp.where(courses.back, r.leaves, forward)
    return turning_point(xp, memory, stress, temperature, xp.where(two, done, 1.0))
