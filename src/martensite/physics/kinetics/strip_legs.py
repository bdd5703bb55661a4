"""One strip of a phase diagram along one straight leg: distances to its finish line, entry, exit and turns.

A process runs over the strip between its start and its finish line. Its distance v is 1 at the start line and 0 at the
finish line, as a fraction of the strip in the coordinate T - σ/C; lines may be curved (`StripCurve`). An endless strip
continues beyond the finish line (v < 0). `history` and `two_fractions` decide which strip acts, and what it remembers.
"""

from typing import Any, NamedTuple, TypeAlias

from martensite.kernels import floats
from martensite.kernels.namespace import Flag, Namespace, Scalar

LegStart: TypeAlias = Any
"""Start of a leg: a memory or a point, with `stress` [Pa] and `temperature` [K]."""


class PathPoint(NamedTuple):
    """Point of a path."""

    stress: Scalar
    temperature: Scalar


class StripCurve(NamedTuple):
    """Bending of a strip: bend · σ (σ - 2 calm) [K/Pa², Pa] shifts the middle, growth · σ [K/Pa] widens it."""

    bend: Scalar
    calm: Scalar
    growth: Scalar


STRAIGHT = StripCurve(0.0, 0.0, 0.0)


class Strip(NamedTuple):
    """One process: the coordinate T - σ·per_slope runs from its start to its finish line."""

    finish: Scalar
    """Finish temperature at zero stress [K]."""
    per_width: Scalar
    """1/(start - finish) [1/K]; negative for the reverse process."""
    per_slope: Scalar
    """1/C [K/Pa]."""
    endless: bool = False
    """True if the process continues beyond its finish line; a property of the law."""
    curve: StripCurve | tuple[()] = ()
    """Curvature of the lines; empty for straight lines."""

    def distance(self, stress: Scalar, temperature: Scalar, xp: Namespace = floats) -> Scalar:
        """Return the unlimited distance to the finish line in strip widths [-]; curved lines need `xp`."""
        straight = (temperature - stress * self.per_slope - self.finish) * self.per_width
        if not self.curve:
            return straight
        tension, width = xp.maximum(stress, 0.0), 1.0 / self.per_width
        bend = self.curve.bend * tension * (tension - 2.0 * self.curve.calm)
        return 0.5 + ((straight - 0.5) * width - bend) / (width + self.curve.growth * tension)

    def find_level(
        self, xp: Namespace, start: LegStart, stress: Scalar, ends: tuple[Scalar, Scalar], level: Scalar
    ) -> Scalar:
        """Return the fraction of a leg at which a falling distance reaches a level; 1 if nowhere.

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
        """Return the fraction of a leg of one sign at which the distance may turn; 1 if nowhere.

        There (distance - ½) = N/W is stationary, N'W = N W'; the root on this side of W = 0 is used.
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
        """Return the positive widths at both ends of a leg, and the quadratic coefficient of N [K]."""
        curve, first, last = self.curve or STRAIGHT, xp.maximum(before, 0.0), xp.maximum(stress, 0.0)
        one, other = (xp.abs(1.0 / self.per_width + curve.growth * tension) for tension in (first, last))
        return one, other, xp.where(self.per_width > 0.0, -1.0, 1.0) * curve.bend * (last - first) * (last - first)


def compute_cosine_rest(xp: Namespace, distance: Scalar) -> Scalar:
    """Return the fraction that a cosine process leaves at a distance from its finish line."""
    sine = xp.quarter_sine(distance)
    return sine * sine


class StripLeg(NamedTuple):
    """One strip along one straight leg."""

    begin: Scalar
    """Distance at the start, limited to [0, 1], or to at most 1 if endless."""
    ahead: Flag
    """True if the start lies before the finish line."""
    passes: Flag
    """True if the leg moves towards the finish line inside the strip."""
    acts: Flag
    """True if it passes and some fraction remains."""
    enters: Scalar
    """Fraction of the leg before the strip."""
    leaves: Scalar
    """Fraction of the leg before the finish line."""


def round_off(xp: Namespace, strip: Strip, start: LegStart, stress: Scalar, temperature: Scalar) -> Scalar:
    """Return the rounding error of the distance [-] over a leg."""
    size = xp.abs(start.temperature) + xp.abs(temperature)
    size = size + (xp.abs(start.stress) + xp.abs(stress)) * strip.per_slope
    if strip.curve:
        most = xp.maximum(xp.maximum(start.stress, stress), 0.0)
        size = size + xp.abs(strip.curve.bend) * most * (most + 2.0 * strip.curve.calm)
    return 8.0 * xp.eps() * size * xp.abs(strip.per_width)


def follow_strip(
    xp: Namespace, strip: Strip, start: LegStart, stress: Scalar, temperature: Scalar, left: Scalar
) -> StripLeg:
    """Return one strip along a leg; differences below rounding count as zero."""
    first = strip.distance(start.stress, start.temperature, xp)
    last = strip.distance(stress, temperature, xp)
    travel, rounding = first - last, round_off(xp, strip, start, stress, temperature)
    moving = travel > rounding
    safe = xp.where(moving, travel, 1.0)
    enters = xp.clip((first - 1.0 - rounding) / safe, 0.0, 1.0)
    leaves = xp.clip(first / safe, 0.0, 1.0)
    if strip.curve:
        enters, leaves = (strip.find_level(xp, start, stress, (first, last), level) for level in (1.0 + rounding, 0.0))
    if strip.endless:
        before = xp.where(xp.abs(first - 1.0) > rounding, first - 1.0, 0.0)
        begin, enters = 1.0 + xp.minimum(before, 0.0), xp.clip(before / safe, 0.0, 1.0)
        passes = xp.both(moving, last + rounding < 1.0)
        return StripLeg(begin, begin > rounding, passes, xp.both(passes, left > 0.0), enters, leaves)
    begin, end = xp.clip(first, 0.0, 1.0), xp.clip(last, 0.0, 1.0)
    ahead = begin > rounding
    passes = xp.both(begin - end > rounding, ahead)
    return StripLeg(begin, ahead, passes, xp.both(passes, left > 0.0), enters, leaves)


def find_zero_stress(xp: Namespace, start: LegStart, stress: Scalar, temperature: Scalar) -> tuple[Scalar, Scalar]:
    """Return the point of a leg with zero stress; its end if there is none."""
    crosses = start.stress * stress < 0.0
    share = start.stress / xp.where(crosses, start.stress - stress, 1.0)
    return turning_point(xp, start, stress, temperature, xp.where(crosses, share, 1.0))


def find_turn(
    xp: Namespace, strips: tuple[Strip, Strip], start: LegStart, stress: Scalar, temperature: Scalar
) -> tuple[Scalar, Scalar]:
    """Return the first turn of curved lines or zero stress on a leg; else its end."""
    end = find_zero_stress(xp, start, stress, temperature)
    turns = [strip.find_turn(xp, start, *end) for strip in strips]
    return turning_point(xp, start, *end, xp.minimum(*turns))


def turning_point(
    xp: Namespace, start: LegStart, stress: Scalar, temperature: Scalar, done: Scalar
) -> tuple[Scalar, Scalar]:
    """Return the point some roundings beyond a fraction of a leg."""
    share = xp.minimum(1.0, done + 64.0 * xp.eps())
    whole = share >= 1.0
    turn_stress = start.stress + share * (stress - start.stress)
    turn_temperature = start.temperature + share * (temperature - start.temperature)
    return (xp.where(whole, stress, turn_stress), xp.where(whole, temperature, turn_temperature))
