"""Trials of steps with step size control: their kinks and extremes, and states within them."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from itertools import pairwise
from typing import NamedTuple

from martensite.signals.moments import Moments
from martensite.simulate.marching import STEP_TOLERANCE, Row

EDGE = 0.05
"""Fraction of a step next to its ends within which halves and whole miss a bend alike."""
BESIDE = 1e-3
"""Margin for a turn at the ends of a step, as a fraction of the step."""
LEAST_FALL = 1e-9
"""Distance from a kink that counts as zero."""
EVENT_TURNS = 4
"""Iterations for the place of a kink in a step of order five."""
NEAREST = 1e-6
"""Margin for a kink at the end of a step of order five, as a fraction of the step."""
REACH = 0.1
"""Margin for the extreme of a parabola through both ends and the middle, as a fraction of its second difference."""
LINES = 4
"""Numbers of both strips among the events of a law: before both start lines, then before both finish lines."""


class Node(NamedTuple):
    """Point of the time integration."""

    time: float
    state: Row
    judged_outputs: Row
    """Judged outputs."""


class StepTrial(NamedTuple):
    """Step that was computed and may be accepted."""

    length: float
    """[s]"""
    halves: Sequence[Row]
    """Drive inputs of each half."""
    half: Row
    """State in the middle."""
    full: Row
    """State at the end."""
    judged_outputs: Row
    """Judged outputs at the end."""
    points: tuple[Row, Row]
    """States of rate-independent laws, in the middle and at the end."""
    owed: tuple[float, ...]
    """Heat [J] missing in the halves, by drive."""
    error: float
    """Error as a fraction of the tolerance."""
    ripple: float
    residual: float
    lapse: float
    surface: SurfaceTrial | None = None
    """Details of a step of order five."""


class SurfaceTrial(NamedTuple):
    """Details of a step of order five."""

    begin: Row
    """State at the start, in the process of the step."""
    slopes: tuple[Row, Row]
    """Changes of the state over the step, at the slopes at its start and its end."""
    path: Row
    """Temperature [K], stress [Pa] and martensite fraction: start, middle, end, and changes by both slopes."""
    unsettled: float
    """Mismatch of the fraction at the end."""
    accurate: bool = False
    """True if the temperature is within the tolerance, and places of kinks are therefore reliable."""

    def follow_path(self, share: float) -> Row:
        """Return temperature, stress and martensite fraction at a fraction of the step."""
        rows = zip(*(self.path[k : k + 3] for k in range(0, 15, 3)), strict=True)
        return tuple(blend_quartic(share, *row) for row in rows)

    def find_turn(self) -> float:
        """Return the place in the step at which the temperature turns; 0.5 if it does not."""
        start, middle, end, first, last = self.path[0::3]
        middle, end, sign = middle - start, end - start, math.copysign(1.0, first)
        if not self.turns:
            return 0.5
        a = 2.0 * (16.0 * middle - 5.0 * end - 4.0 * first + last)
        b = 3.0 * (14.0 * end - 32.0 * middle + 5.0 * first - 3.0 * last)
        c = 4.0 * (16.0 * middle - 8.0 * end - 2.0 * first + 2.0 * last)
        bracket = RootBracket(0.0, 1.0, sign * first, sign * last)
        return bracket.find_root(lambda x: sign * (first + x * (a + x * (b + x * c))), first / (first - last))

    @property
    def turns(self) -> bool:
        """Return whether the temperature turns within the step."""
        return self.path[9] * self.path[12] < 0.0

    def find_event(self, ask: Callable[..., Row], rows: Sequence[Row], turn: float, seen: bool) -> float:
        """Return the place in the step where a process begins or ends, if it counts; else 1.

        It counts if the error shows it, or if the temperature turns behind it. If the temperature turns before it, it
        counts if the line was also passed before the turn.

        Args:
            ask: function for events, from a state, temperature and stress.
            rows: events at the start, at the turn and at the end.
            turn: place where the temperature turns, or the middle.
            seen: True if the error of the step is too large.
        """
        brackets = list[tuple[float, int, RootBracket]]()
        asked = False
        for k, (a, b, c) in enumerate(zip(*rows, strict=True)):
            if a > LEAST_FALL and b <= 0.0:
                bracket, counts = RootBracket(0.0, turn, a, b), self.turns or c > 0.0
            elif max(a, b) > LEAST_FALL and c <= 0.0 < b:
                bracket, counts = RootBracket(turn, 1.0, b, c), a <= LEAST_FALL
            else:
                continue
            asked = asked or seen or counts
            brackets.append((bracket.cut_chord(), k, bracket))
        if not asked:
            return 1.0
        share, k, bracket = min(brackets)
        share = bracket.find_root(lambda x: ask(*self.begin, *self.follow_path(x)[:2])[k], share)
        return share if share < 1.0 - (NEAREST if seen else BESIDE) else 1.0

    def find_reversal(self, rows: Sequence[Row], turn: float, allowed: float) -> float:
        """Return a place just behind the turn if a process acts before or behind it; else 1.

        Args:
            rows: events at the start, at the turn and at the end.
            turn: place where the temperature turns, or the middle.
            allowed: smallest change of the fraction, or of the distance in a strip, that counts.
        """
        share = (1.0 + BESIDE) * turn
        if not self.turns or share >= 1.0 - BESIDE:
            return 1.0
        back = abs(self.follow_path(turn)[2] - self.path[8]) > allowed
        return share if back or acts_at_turn(rows, allowed) else 1.0


def acts_at_turn(rows: Sequence[Row], allowed: float) -> bool:
    """Return whether a process acts before or behind the place where the temperature turns inside its strip.

    A process that waits for its interrupted branch has an event, a number between 0 and 1 behind those of the lines.

    Args:
        rows: events at the start, at the turn and at the end.
        allowed: smallest change of the distance in a strip that counts.
    """
    start, turn, end = rows
    if any(0.0 < wait < 1.0 for wait in turn[LINES : LINES + 1]):
        return False
    inside = [k for k in (0, 1) if turn[k] <= 0.0 < turn[k + 2]]
    return any(max(start[k] - turn[k], turn[k] - end[k]) > allowed for k in inside)


def find_touch(ask: Callable[..., Row], state: Row, rows: Sequence[Row], ratio: float, allowed: float) -> float:
    """Return the place in a step in halves where the temperature turns, if an unseen process acts there; else 1.

    A turn near the start is on the parabola through the start, the middle and the point half a step earlier.

    Args:
        ask: function for events, from a state, temperature and stress.
        state: state at the start.
        rows: temperature, stress, two fractions and events half a step earlier, at the start, in the middle and at the
            end.
        ratio: length of a half over the length of the half before the step; 0 behind an edge of a drive.
        allowed: smallest change of the distance in a strip that counts.
    """
    columns = [[row[k] for row in rows] for k in (0, 1)]
    around, behind = map(fit_around, columns), (fit_behind(column, ratio) for column in columns)
    for fits, most in ((list(around), 1.0 - BESIDE), (list(behind), 0.5)):
        (slope, bend), _ = fits
        share = -0.5 * slope / bend if bend else 1.0
        if BESIDE < share < most:
            tops = [x + share * u + (share * share - 0.5 * REACH) * v for x, (u, v) in zip(rows[1], fits, strict=False)]
            turn = ask(*state, *tops)
            numbers = zip(turn, *(row[4:] for row in rows[1:]), strict=True)
            touches = any(n <= 0.0 and n < a and min(b, c) > LEAST_FALL for n, a, b, c in numbers)
            return share if touches or acts_at_turn((turn, turn, rows[3][4:]), allowed) else 1.0
    return 1.0


def fit_around(values: Sequence[float]) -> tuple[float, float]:
    """Return the slope at the start and the curvature over a step of the parabola through the last three values."""
    _, first, middle, last = values
    bend = 2.0 * (first - 2.0 * middle + last)
    return last - first - bend, bend


def fit_behind(values: Sequence[float], ratio: float) -> tuple[float, float]:
    """Return the slope at the start and the curvature over a step of the parabola through the first three values."""
    earlier, first, middle, _ = values
    before, after = ratio * (first - earlier), middle - first
    bend = 4.0 * ratio * (after - before) / (1.0 + ratio)
    return 2.0 * after - 0.5 * bend, bend


class TakenStep(NamedTuple):
    """Accepted step."""

    begin: float
    """[s]"""
    state: Row
    """State at its start."""
    owed: Sequence[float]
    """Heat [J] of the previous step that this step corrects, by drive."""
    trial: StepTrial


def join_halves(first: Moments, last: Moments, length: float) -> Moments:
    """Return moments of an interval [s] from the moments of its halves, without the lapse."""
    slopes = (
        1.5 * (b - a) / length + 0.125 * (c + d)
        for a, b, c, d in (
            (first.mean, last.mean, first.slope, last.slope),
            (first.square, last.square, first.square_slope, last.square_slope),
        )
    )
    mean, square = 0.5 * (first.mean + last.mean), 0.5 * (first.square + last.square)
    return Moments(mean, square, min(first.low, last.low), max(first.high, last.high), 0.0, *slopes)


def stretch_length(length: float, end: float) -> float:
    """Return a length that reaches an end without a short remainder."""
    if length >= (1.0 - STEP_TOLERANCE) * end:
        return end
    return 0.5 * end if length > 0.6 * end else length


def find_extreme(first: float, middle: float, last: float) -> tuple[float, float]:
    """Return the relative position of a parabola's turn and its height beyond the points; 1 without a turn."""
    one, two = middle - first, last - middle
    bend, rise = two - one, one + two
    if not abs(rise) < 2.0 * abs(bend):
        return 1.0, 0.0
    top = middle - rise * rise / (8.0 * bend)
    apart = min(abs(top - first), abs(top - middle), abs(top - last))
    return 0.5 - 0.25 * rise / bend, apart


def find_fall(ahead: float, first: float, middle: float, last: float) -> float:
    """Return the fraction of a step at which a value falls to 0; else 1.

    The three values are half steps apart, and `ahead` is the extrapolated fall per half step. A chord replaces an
    inconsistent extrapolation.
    """
    if not (first > LEAST_FALL and min(middle, last) <= 0.0):
        return 1.0
    begin, top, bottom = (0.0, first, middle) if middle <= 0.0 else (0.5, middle, last)
    ahead = ahead if middle <= 0.0 else first - middle
    return begin + 0.5 * (top / ahead if ahead > top else top / (top - bottom))


class RootBracket(NamedTuple):
    """Interval in which a function falls to 0 or below."""

    low: float
    high: float
    above: float
    """Value at `low`."""
    below: float
    """Value at `high`."""

    def cut_chord(self) -> float:
        """Return the place of the zero on the chord."""
        return self.low + (self.high - self.low) * self.above / (self.above - self.below)

    def find_root(self, function: Callable[[float], float], first: float) -> float:
        """Return the place of the zero by the rule of Illinois, from a first guess."""
        (low, high, above, below), share, side = self, first, 0
        for _ in range(EVENT_TURNS):
            value = function(share)
            if value <= 0.0:
                high, below = share, value
                above *= 0.5 if side == 1 else 1.0
            else:
                low, above = share, value
                below *= 0.5 if side == 2 else 1.0
            side = 1 if value <= 0.0 else 2
            share = low + (high - low) * above / (above - below) if above > below else high
        return share


def find_missed(rows: Sequence[Row], ratio: float, share: float) -> float:
    """Return the change of derivative at a bend near a step end times its distance from that end; else 0.

    Args:
        rows: points half a step earlier, at the start, in the middle and at the end.
        ratio: length of a half over the length of the half before the step.
        share: place of the bend as a fraction of the step.
    """
    p, q, a, z = rows
    if 0.0 < share < EDGE:
        return 2.0 * share * max(abs(a[k] - q[k] - ratio * (q[k] - p[k])) for k in (2, 3))
    late = 1.0 - EDGE < share < 1.0 - BESIDE
    return max(abs(z[k] - a[k] - (a[k] - q[k])) for k in (2, 3)) if late else 0.0


def find_dip(first: float, middle: float, last: float) -> float:
    """Return the fraction of a step at which a value turns and passes 0 nowhere else; else 1."""
    share, below = find_extreme(first, middle, last)
    least = min(first, middle, last)
    return share if middle - first < 0.5 * (last - first) and LEAST_FALL < least < 2.0 * below else 1.0


def divided_difference(times: Sequence[float], values: Sequence[float]) -> float:
    """Return the divided difference of the highest order."""
    differences = list(values)
    for order in range(1, len(times)):
        spans = [last - first for first, last in zip(times, times[order:], strict=False)]
        differences = [(b - a) / span for (a, b), span in zip(pairwise(differences), spans, strict=True)]
    return differences[0]


def interpolate_state(nodes: Sequence[Node], time: float) -> Row:
    """Return the state on the polynomial through the nodes."""
    weights: list[float] = []
    for i, node in enumerate(nodes):
        others = [other.time for j, other in enumerate(nodes) if j != i]
        weights.append(math.prod((time - t) / (node.time - t) for t in others))
    columns = zip(*(node.state for node in nodes), strict=True)
    return tuple(sum(w * x for w, x in zip(weights, column, strict=True)) for column in columns)


def interpolate_step(step: TakenStep, share: float) -> Row:
    """Return the state within a step of order five, by its ends, its middle and the slopes at its ends."""
    trial, surface = step.trial, step.trial.surface
    slopes = surface.slopes if surface else ()
    rows = zip(step.state, trial.half, trial.full, *slopes, strict=True)
    return tuple(blend_quartic(share, *row) for row in rows)


def blend_quartic(x: float, start: float, middle: float, end: float, first: float, last: float) -> float:
    """Return a polynomial on [0, 1] with given values at the ends and in the middle, and slopes at the ends."""
    x2 = x * x
    moved = x2 * (16.0 + x * (16.0 * x - 32.0)) * (middle - start) + x2 * (x * (14.0 - 8.0 * x) - 5.0) * (end - start)
    turned = x * (1.0 + x * (x * (5.0 - 2.0 * x) - 4.0)) * first + x2 * (1.0 + x * (2.0 * x - 3.0)) * last
    return start + (moved + turned)
