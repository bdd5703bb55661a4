"""Tension and compression: a tension law on either side of zero stress, with separate parameters.

On a leg of stress sign s, the law sees |σ| = sσ and the net fraction n = s·oriented, -ξ ≤ n ≤ ξ, of martensite oriented
along the stress. Unoriented martensite has no strain. Only ratios of its results count: r_S of material not oriented
along the stress, r of austenite, b of martensite,

    forward   1 - n → (1 - n) r_S,    1 - ξ → (1 - ξ) r
    reverse   n → n b, ξ → ξ b,       for martensite oriented along the stress, or unoriented.

Martensite oriented against the stress reverts by the reverse strip of the opposite side at -sσ; its austenite
transforms at once as far as cooling to this point would transform it. One-fraction laws orient new martensite by H(σ) =
ε_L - (ε_L - s H_min) exp(-H_k |σ|) at the middle of the traversed part of the strip. Interrupted transformations are
forgotten when stress reverts martensite or changes sign, except forward ones of one-fraction laws. Source: this
package.
"""

from collections.abc import Callable
from functools import wraps
from typing import Any, NamedTuple, TypeVar, cast

from martensite.kernels.namespace import Flag, Namespace, Scalar
from martensite.kernels.nested import NestedShape, flatten_numbers
from martensite.physics.kinetics.history import RESTART
from martensite.physics.kinetics.strip_legs import PathPoint, find_zero_stress, follow_strip
from martensite.physics.laws.base import Fork, Fractions

NONE = "none"
STOPS, TURNS = 2, 3
"""Largest numbers of process changes and of turns of curved lines on a leg of one sign."""
UNSET = 1.0
Method = TypeVar("Method", bound=Callable[..., Any])


class SidedMemory(NamedTuple):
    """Memory of a law with compression."""

    inner: Any
    """Memory of the tension law at |σ|; only ratios of its fractions count."""
    present: Fractions
    """ξ and n."""
    against: Scalar
    """Fraction oriented against the side [-]; 0 for a law with both orientations."""
    side: Scalar
    """s: +1 in tension, -1 in compression."""
    reach: Scalar
    """Lowest distance of the reverse process of the fraction `against`."""
    stress: Scalar
    temperature: Scalar


class SidedProcess(NamedTuple):
    """Process of the tension law, and reverse process of the fraction oriented against the stress."""

    memory: SidedMemory
    """Memory before the move, on its side."""
    inner: Any
    acts: Scalar
    """1 if the fraction oriented against the stress reverts."""
    reach: Scalar


def by_side(method: Method, other: Callable[..., Any]) -> Method:
    """Return `method`, or `other` for laws with compression."""

    @wraps(method)
    def chosen(law: Any, *arguments: Any) -> Any:
        return (method if law.compression == NONE else other)(law, *arguments)

    return cast("Method", chosen)


def _see_fractions(fractions: Fractions, side: Scalar) -> Fractions:
    return Fractions(fractions.martensite, side * fractions.oriented)


def _init(law: Any, xp: Namespace, fractions: Fractions, stress: Scalar, kelvin: Scalar) -> SidedMemory:
    side = xp.where(stress < 0.0, -1.0, 1.0)
    present = _see_fractions(fractions, side)
    inner = law.on_side(xp, side).init(xp, present, side * stress, kelvin)
    return SidedMemory(inner, present, xp.maximum(-present.oriented, 0.0), side, UNSET, stress, kelvin)


def _fractions(_: Any, memory: SidedMemory) -> Fractions:
    return _see_fractions(memory.present, memory.side)


def _relocate(law: Any, xp: Namespace, memory: SidedMemory, fractions: Fractions, *at: Scalar) -> SidedMemory:
    present, side = _see_fractions(fractions, memory.side), memory.side
    inner = law.on_side(xp, side).relocate(xp, memory.inner, present, side * at[0], at[1])
    against = limit_against(xp, present, memory.against)
    return SidedMemory(inner, present, against, side, memory.reach, *at)


def limit_against(xp: Namespace, present: Fractions, against: Scalar) -> Scalar:
    """Return the fraction oriented against a side, limited so that no fraction is negative."""
    return xp.clip(against, xp.maximum(-present.oriented, 0.0), 0.5 * (present.martensite - present.oriented))


def _forget_history(xp: Namespace, plain: Any, forget: Flag, inner_memory: Any, present: Fractions) -> Any:
    """Return the memory of the tension law, without history where `forget`."""
    fresh = plain.init(xp, present, inner_memory.stress, inner_memory.temperature)
    pairs = zip(flatten_numbers(fresh), flatten_numbers(inner_memory), strict=True)
    return NestedShape(inner_memory).rebuild([xp.where(forget, a, b) for a, b in pairs])


def _turn_side(law: Any, xp: Namespace, memory: SidedMemory, stress: Scalar) -> SidedMemory:
    """Return the memory on the side of the largest part of a leg."""
    middle = memory.stress + stress
    side = xp.where(middle > 0.0, 1.0, xp.where(middle < 0.0, -1.0, memory.side))
    turns, present = side * memory.side < 0.0, _see_fractions(memory.present, side * memory.side)
    inner_memory = memory.inner._replace(stress=side * memory.stress)
    forget = xp.both(turns, xp.negate(inner_memory.branch > 0.0)) if law.keeps_forward else turns
    inner = _forget_history(xp, law.on_side(xp, side), forget, inner_memory, present)
    reach = xp.where(turns, UNSET, memory.reach)
    against = limit_against(xp, present, memory.against + xp.where(turns, memory.present.oriented, 0.0))
    return SidedMemory(inner, present, against, side, reach, memory.stress, memory.temperature)


def _select(law: Any, xp: Namespace, memory: SidedMemory, stress: Scalar, kelvin: Scalar) -> SidedProcess:
    memory = _turn_side(law, xp, memory, stress)
    side = memory.side
    inner = law.on_side(xp, side).select(xp, memory.inner, side * stress, kelvin)
    if not law.by_ratios:
        return SidedProcess(memory, inner, 0.0, UNSET)
    start, strip = PathPoint(-side * memory.stress, memory.temperature), law.on_side(xp, -side).reverse_strip()
    leg = follow_strip(xp, strip, start, -side * stress, kelvin, memory.against)
    begin = leg.begin if strip.endless else xp.where(leg.ahead, leg.begin, 0.0)
    reach = begin if law.history == RESTART else xp.minimum(memory.reach, begin)
    return SidedProcess(memory, inner, xp.where(leg.acts, 1.0, 0.0), reach)


def _find_reach(law: Any, xp: Namespace, move: SidedProcess, stress: Scalar, kelvin: Scalar) -> Scalar:
    """Return the lowest distance of the fraction oriented against the stress, after the move."""
    side = move.memory.side
    strip = law.on_side(xp, -side).reverse_strip()
    distance = strip.distance(-side * stress, kelvin, xp)
    low = xp.minimum(distance if strip.endless else xp.maximum(distance, 0.0), move.reach)
    return xp.where(move.acts > 0.0, low, move.memory.reach)


def compare_parts_left(xp: Namespace, rest: Scalar, before: Scalar, nothing: Scalar = 1.0) -> Scalar:
    """Return rest/before [-], or `nothing` if before is 0."""
    some = before > 0.0
    return xp.where(some, rest / xp.where(some, before, 1.0), nothing)


def _follow(law: Any, xp: Namespace, move: SidedProcess, *end: Scalar) -> Fractions:
    return _see_fractions(_follow_parts(law, xp, move, *end)[0], move.memory.side)


def _follow_parts(
    law: Any, xp: Namespace, move: SidedProcess, stress: Scalar, kelvin: Scalar, dt: Scalar
) -> tuple[Fractions, Scalar]:
    """Return ξ and n at the end of a move, and the fraction oriented against its side."""
    memory, side = move.memory, move.memory.side
    plain, start, at = law.on_side(xp, side), (side * memory.stress, memory.temperature), (side * stress, kelvin)
    before, after = plain.fractions(memory.inner), plain.follow(xp, move.inner, *at, dt)
    if not law.by_ratios:
        return after, 0.0
    share, twinned = plain.orient_martensite(xp, side, move.inner, start, at)
    left = law.compare_rests(xp, _find_reach(law, xp, move, stress, kelvin), move.reach)
    lost, (alone, both) = move.acts * memory.against * (1.0 - left), plain.find_rests(xp, *at)
    xi, n = memory.present.martensite, memory.present.oriented + lost
    most, against, austenite = 1.0 - lost, memory.against - lost, 1.0 - xi
    first = compare_parts_left(xp, 1.0 - after.oriented, 1.0 - before.oriented)
    rest = compare_parts_left(xp, 1.0 - after.martensite, 1.0 - before.martensite, first)
    factor, back = compare_parts_left(xp, after.martensite, before.martensite), after.martensite < before.martensite
    ahead = xp.either(after.martensite > before.martensite, after.oriented > before.oriented)
    along, astray = (xp.where(ahead, (1.0 - first) * xp.maximum(x, 0.0), 0.0) for x in (share, -share))
    grown = n + along * (most - n) - astray * (most + n) + twinned * austenite * (first - rest)
    n = xp.where(back, (n + against) * factor - against, xp.where(ahead, grown, n))
    whole = xp.where(back, (xi - lost - against) * factor + against + lost, xp.where(ahead, 1.0 - austenite * rest, xi))
    xi, n = whole - lost * both, n + share * lost * (1.0 - alone)
    fractions = Fractions(xi, xp.clip(n, -xi, xi))
    return fractions, limit_against(xp, fractions, against * (1.0 - along) + astray * (most - against))


def _commit(
    law: Any, xp: Namespace, _: SidedMemory, move: SidedProcess, fractions: Fractions, *end: Scalar
) -> SidedMemory:
    stress, kelvin, dt = end
    memory, side, at = move.memory, move.memory.side, (move.memory.side * stress, kelvin, dt)
    plain, present = law.on_side(xp, side), _see_fractions(fractions, side)
    if not law.by_ratios:
        inner = plain.commit(xp, memory.inner, move.inner, present, *at)
        return SidedMemory(inner, present, 0.0, side, memory.reach, stress, kelvin)
    inner = plain.commit(xp, memory.inner, move.inner, plain.follow(xp, move.inner, *at), *at)
    inner = _forget_history(xp, plain, move.acts > 0.0, inner, present)
    against = limit_against(xp, present, _follow_parts(law, xp, move, *end)[1])
    return SidedMemory(inner, present, against, side, _find_reach(law, xp, move, stress, kelvin), stress, kelvin)


def _kinetics(
    law: Any, xp: Namespace, memory: SidedMemory, stress: Scalar, kelvin: Scalar, dt: Scalar
) -> tuple[SidedMemory, Fractions]:
    """Advance along a leg, cut at sign changes of stress and at process changes."""
    stops = STOPS + (TURNS if getattr(law, "surfaces", "") == "curved" else 0)
    for at in (find_zero_stress(xp, memory, stress, kelvin), (stress, kelvin)):
        for k in range(stops + 1 if law.by_ratios else 1):
            memory = _turn_side(law, xp, memory, at[0])
            plain, side = law.on_side(xp, memory.side), memory.side
            to: tuple[Scalar, Scalar] = at
            if not law.by_ratios:
                inner, present = plain.kinetics(xp, memory.inner, side * at[0], at[1], dt)
                memory = SidedMemory(inner, present, 0.0, side, memory.reach, *at)
                continue
            if k < stops:
                to = plain.find_stop(xp, memory.inner, side * at[0], at[1])
                to = side * to[0], to[1]
            move = _select(law, xp, memory, *to)
            memory = _commit(law, xp, memory, move, _follow(law, xp, move, *to, dt), *to, dt)
    return memory, _fractions(law, memory)


def _kinks(law: Any, xp: Namespace, memory: SidedMemory) -> list[Scalar]:
    return law.on_side(xp, memory.side).kinks(xp, memory.inner)


def _forks(law: Any, xp: Namespace, memory: SidedMemory) -> list[Fork]:
    return law.on_side(xp, memory.side).forks(xp, memory.inner)


def _crossing(law: Any, xp: Namespace, _: Any, move: SidedProcess, stress: Scalar, kelvin: Scalar) -> Scalar:
    memory = move.memory
    inner = law.on_side(xp, memory.side).crossing(xp, memory.inner, move.inner, memory.side * stress, kelvin)
    far = move.reach - _find_reach(law, xp, move, stress, kelvin) if law.by_ratios else 0.0
    return xp.maximum(inner, move.acts * far)


SIDED_METHODS: dict[str, Callable[..., Any]] = {
    one.__name__[1:]: one
    for one in (_init, _fractions, _relocate, _select, _follow, _commit, _kinetics, _kinks, _forks, _crossing)
}
