"""One move of a law whose end feeds back on the stress and temperature that drive it.

Let z be the phase fractions at the end of a step. Load line and heat balance give stress and temperature as functions
of z, and the law gives fractions f(σ, T): the step is the fixed point z = f(σ(z), T(z)). With frozen fractions the move
ends at the elastic trial, where the law overshoots to f₀, because feedback restrains every transformation: more
martensite means a hotter and less stressed wire. On the chord from the present fractions z₀ to f₀,

    z(q) = (1 - q) z₀ + q f₀,        g(q) = q - n·[f(σ(z(q)), T(z(q))) - z₀],   n·(f₀ - z₀) = 1,

g rises from -1 to at least 0 between q = 0 and 1, with g' ≥ 1: a bracketed Newton iteration cannot diverge. For laws
whose fractions change in a fixed proportion the chord contains the solution. For other laws the solution is near, and
Newton's method in all fractions follows. An R-phase is a third fraction with the same restraint.
"""

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

from martensite.kernels.bracketed_newton import SMALL, solve_bracketed
from martensite.kernels.dual import compute_jacobian, value_and_slope
from martensite.kernels.namespace import Namespace, Scalar
from martensite.kernels.nested import find_largest, sum_column
from martensite.physics.laws.base import AbstractLaw, Fractions

Settle = Callable[[Namespace, Fractions], tuple[Scalar, Scalar]]
"""Stress [Pa] and temperature [K] at the end of the step, as a function of the fractions there."""

REFINED = 2
"""Newton steps of the first guess, without calls of the law."""
LEAST_OVERSHOOT = 1e-30
"""Overshoot [-] below which nothing transforms."""
POLISHING_STEP = 1e-3
"""Step on the chord below which Newton's method in all fractions takes over."""
WHOLE = 4.0
"""Distance from the end of the chord, in roundings, that counts as the end."""
POLISHED = 1e-13
"""Mismatch of the fractions [-] that counts as zero."""
MOST_STEPS = 24
"""Steps of Newton's method in all fractions."""


class StepReport(NamedTuple):
    """Accuracy of a step, the basis of its status."""

    residual: Scalar
    """Largest mismatch |z - f| of a fraction at the end of the step."""
    crossing: Scalar
    """Fraction of a transformation strip crossed by the elastic trial."""
    ripple: Scalar = 0.0
    """Temperature [K] that the mean drive neglects."""


def advance_memory(
    xp: Namespace, law: AbstractLaw, memory: Any, settle: Settle, dt: Scalar, change: Scalar = 0.0
) -> tuple[Any, StepReport]:
    """Return the memory after a step of dt [s] and its report; `change` of martensite is a first guess only."""
    start = law.fractions(memory)
    trial = settle(xp, start)
    move = law.select(xp, memory, *trial)

    def answer(xp: Namespace, fractions: Fractions) -> Fractions:
        return law.follow(xp, move, *settle(xp, fractions), dt)

    def drive(xp: Namespace, q: Scalar) -> Scalar:
        return law.drive(xp, move, *settle(xp, _blend_fractions(start, aim, q)), dt)

    aim = type(start)(*answer(xp, start))
    guess = _guess_place(xp, drive) if law.has_drive else _expect_place(xp, start, aim, change)
    enough = SMALL if law.one_way or law.has_drive else POLISHING_STEP
    end = _seek_on_chord(xp, answer, start, aim, guess, enough, not law.has_drive)
    if not law.one_way:
        end = _polish_fractions(xp, answer, end)
    response = answer(xp, end)
    stress, temperature = settle(xp, end)
    residual = find_largest(xp, [xp.abs(a - b) for a, b in zip(end, response, strict=True)])
    after = law.commit(xp, memory, move, end, stress, temperature, dt)
    return after, StepReport(residual, law.crossing(xp, memory, move, *trial))


def _blend_fractions(start: Fractions, aim: Fractions, q: Scalar) -> Fractions:
    """Return the point at a fraction q of the chord; exact at both ends."""
    rest = 1.0 - q
    return type(start)(*(q * b + rest * a for a, b in zip(start, aim, strict=True)))


def _guess_place(xp: Namespace, drive: Callable[[Namespace, Scalar], Scalar]) -> Scalar:
    """Return the zero of the drive of a steep law on the chord, by secant and Newton steps."""
    first, last = drive(xp, 0.0), drive(xp, 1.0)
    falls = first > last
    q = xp.clip(first / xp.where(falls, first - last, 1.0), 0.0, 1.0)
    for _ in range(REFINED):
        value, slope = value_and_slope(xp, drive, q)
        q = xp.clip(q - value / xp.where(slope < 0.0, slope, -1e30), 0.0, 1.0)
    return xp.where(falls, q, 0.0)


def _expect_place(xp: Namespace, start: Fractions, aim: Fractions, change: Scalar) -> Scalar:
    """Return the place on the chord with a given change of martensite; its start if there is none."""
    way = aim.martensite - start.martensite
    there = xp.both(xp.abs(way) > xp.abs(change), way * change > 0.0)
    return xp.where(there, change / xp.where(there, way, 1.0), 0.0)


def _seek_on_chord(
    xp: Namespace,
    answer: Callable[[Namespace, Fractions], Fractions],
    start: Fractions,
    aim: Fractions,
    guess: Scalar,
    enough: float,
    smooth: bool,
) -> Fractions:
    """Return the fixed point of the law on the chord from `start` through `aim`."""
    ways = [b - a for a, b in zip(start, aim, strict=True)]
    size = sum_column([xp.abs(way) for way in ways])
    moves = size > LEAST_OVERSHOOT
    share = xp.where(moves, 1.0 / xp.where(moves, size, 1.0), 0.0)
    shares = [xp.where(way < 0.0, -share, share) for way in ways]

    def mismatch(xp: Namespace, q: Scalar) -> Scalar:
        fractions = answer(xp, type(start)(*_blend_fractions(start, aim, q)))
        for share, a, b in zip(shares, start, fractions, strict=True):
            q = q - share * (b - a)
        return q

    q = solve_bracketed(xp, mismatch, guess, (0.0, 2.0), wanted=moves, enough=enough, smooth=smooth)
    q = xp.where(xp.abs(q - 1.0) > WHOLE * xp.eps(), q, 1.0)
    return _blend_fractions(start, aim, xp.where(moves, q, 0.0))


def _polish_fractions(
    xp: Namespace, answer: Callable[[Namespace, Fractions], Fractions], start: Fractions
) -> Fractions:
    """Return the fixed point by a damped Newton method in all fractions."""
    size = len(start)

    def move(numbers: Sequence[Scalar], length: Scalar) -> Fractions:
        pairs = zip(numbers[:size], numbers[size:], strict=True)
        return _limit_fractions(xp, type(start)(*(x + length * step for x, step in pairs)))

    def turn(_: Scalar, *numbers: Scalar) -> tuple[Scalar, ...]:
        *before, length, least = numbers
        tried = move(before, length)
        newton, residual = _compute_newton_step(xp, answer, tried)
        better = residual < least
        best_numbers = [xp.where(better, new, old) for new, old in zip((*tried, *newton), before, strict=True)]
        left, length = xp.where(better, residual, least), xp.where(better, 1.0, 0.25 * length)
        far = sum_column([xp.abs(step) for step in best_numbers[size:]]) > SMALL
        more = xp.both(left > POLISHED, xp.both(far, length > SMALL))
        return (xp.where(more, 1.0, 0.0), *best_numbers, length, left)

    begin = 1.0, *start, *[0.0 for _ in start], 1.0, float("inf")
    unfinished, *numbers, length, _ = xp.iterate(MOST_STEPS, turn, *begin)
    end = move(numbers, xp.where(unfinished > 0.0, 0.0, length))
    at = type(start)(*(xp.detach(x) for x in end))
    step, _ = _compute_newton_step(xp, answer, at)
    return type(start)(*(xp.implicit_root(x, y + d) for x, y, d in zip(end, at, step, strict=True)))


def _limit_fractions(xp: Namespace, numbers: Fractions) -> Fractions:
    """Return the nearest valid phase state."""
    martensite = xp.clip(numbers.martensite, 0.0, 1.0)
    oriented = xp.clip(numbers.oriented, -martensite, martensite)
    return type(numbers)(martensite, oriented, *(xp.clip(x, 0.0, 1.0) for x in numbers[2:]))


def _compute_newton_step(
    xp: Namespace, answer: Callable[[Namespace, Fractions], Fractions], at: Fractions
) -> tuple[Fractions, Scalar]:
    """Return the Newton step of z - f(z) = 0, and the size of the mismatch."""
    fractions, slopes = compute_jacobian(xp, lambda xp, x: answer(xp, type(at)(*x)), at)
    rows = [
        [1.0 - xp.detach(slope) if i == k else -xp.detach(slope) for k, slope in enumerate(row)]
        for i, row in enumerate(slopes)
    ]
    short = [x - y for x, y in zip(fractions, at, strict=True)]
    rows = [[*row, x] for row, x in zip(rows, short, strict=True)]
    third = rows.pop() if len(rows) > len(Fractions._fields) else None
    if third:  # eliminated first: the R-phase restrains itself, so its pivot is at least 1
        rows = [[x - row[2] / third[2] * y for x, y in zip(row, third, strict=True)] for row in rows]
    (a, b, *_, short_m), (c, d, *_, short_o) = rows
    determinant = a * d - b * c
    safe = xp.where(xp.abs(determinant) > 0.0, determinant, 1.0)
    step = [(d * short_m - b * short_o) / safe, (a * short_o - c * short_m) / safe]
    if third:
        step.append((third[3] - third[0] * step[0] - third[1] * step[1]) / third[2])
    return type(at)(*step), find_largest(xp, [xp.abs(x) for x in short])
