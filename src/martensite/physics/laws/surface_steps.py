r"""Step of order five of a rate-independent law with one fraction, coupled with heat and mechanism.

While one process acts, the fraction is a function f of stress and temperature, and the stress a function S of fraction
and temperature on the load line. With heat capacity C, latent heat λ, heating P and heat loss Q,

    ξ = f(S(ξ, T), T),     dξ/dT = (f_σ S_T + f_T)/(1 - f_σ S_ξ) = H,     dT/dt = (P - Q)/(C - λ H)

An explicit Runge–Kutta pair of order 5(4) follows this equation over the step, as if the process at its start lasted.
The law then judges the end: it selects the process of the whole move anew, by the end without transformation, and its
fraction replaces the integrated one. A process that begins, ends or turns within the step makes both differ, so that
the error estimate sees it. The path as if the process lasted is smooth; the time integration locates kinks on it.

Sources: Dormand and Prince (1980), J. Comput. Appl. Math. 6, for the pair; Shampine (1986), Math. Comput. 46, for its
middle.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

from martensite.kernels.dual import compute_jacobian, value_and_slope
from martensite.kernels.namespace import Namespace, Scalar
from martensite.kernels.nested import NestedShape, flatten_numbers
from martensite.physics.laws.base import AbstractLaw
from martensite.signals.moments import Moments

Column = Sequence[Scalar]

TIMES = (0.0, 1 / 5, 3 / 10, 4 / 5, 8 / 9, 1.0, 1.0)
"""Places of the stages as fractions of the step."""
STAGES = (
    (),
    (1 / 5,),
    (3 / 40, 9 / 40),
    (44 / 45, -56 / 15, 32 / 9),
    (19372 / 6561, -25360 / 2187, 64448 / 6561, -212 / 729),
    (9017 / 3168, -355 / 33, 46732 / 5247, 49 / 176, -5103 / 18656),
    (35 / 384, 0.0, 500 / 1113, 125 / 192, -2187 / 6784, 11 / 84),
)
"""Weights of earlier slopes in the state of each stage; the last stage is the end."""
ERROR = (71 / 57600, 0.0, -71 / 16695, 71 / 1920, -17253 / 339200, 22 / 525, -1 / 40)
"""Weights of the slopes in the difference of both orders."""
MIDDLE = (
    *(6025192743 / 60171106304, 0.0, 51252292925 / 130801643196, -2691868925 / 90256659456),
    *(187940372067 / 3189068634112, -1776094331 / 39487288512, 11237099 / 470086768),
)
"""Weights of the slopes in the state in the middle."""


class SurfaceCoupling(NamedTuple):
    """Coupling of a law; `at` is (ξ, temperature [K])."""

    stress: Callable[[Namespace, Column], Scalar]
    """Stress on the load line [Pa]."""
    power: Callable[[Namespace, Column, float], Scalar]
    """Net heat flow [W] at a fraction of the step."""
    latent: Scalar
    """Heat of the whole forward transformation [J]."""
    capacity: Scalar
    """[J/K]"""


class PathPoints(NamedTuple):
    """Temperature [K], stress [Pa] and ξ over a step in which the process at its start lasts."""

    start: Column
    middle: Column
    end: Column
    first: Column
    """Changes over the step at the slopes at its start."""
    last: Column
    """Changes over the step at the slopes at its end."""


class SurfaceStep(NamedTuple):
    """Memories and slopes of a step."""

    end: Any
    """Memory after the step."""
    middle: Any
    """Memory in the middle, if the process at the start lasts."""
    coarse: Any
    """Memory after the step, to order four."""
    begin: Any
    """Memory at the start, in the process of the step."""
    slopes: tuple[Any, Any]
    """Changes of the memory over the step, at the slopes at its start and its end."""
    path: PathPoints
    residual: Scalar
    """Mismatch of the fraction at the end that Newton's method leaves, estimated from its last step."""
    decay: Scalar
    """Length of the step over the time constant of the heat balance [-]."""

    def convert(self, state: Callable[[Any], Any], slope: Callable[[Any, Any], Any]) -> SurfaceStep:
        """Return the step in states of a larger system, from functions for states and for their changes."""
        states = {name: state(getattr(self, name)) for name in ("end", "middle", "coarse", "begin")}
        first, last = self.slopes
        return self._replace(**states, slopes=(slope(self.begin, first), slope(self.end, last)))


def fit_drive(first: Moments, last: Moments, dt: Scalar) -> Callable[[float], Scalar]:
    """Return the cubic with the means and slopes of a smooth drive in both halves of a step, over [0, 1]."""
    rise = last.mean - first.mean
    line = 1.5 * rise + 0.125 * dt * (first.slope + last.slope)
    weights = 0.5 * (first.mean + last.mean), line, dt * (last.slope - first.slope), 40.0 * line - 80.0 * rise

    def read(share: float) -> Scalar:
        x = share - 0.5
        return _weigh((1.0, x, x * x - 1.0 / 12.0, x * (x * x - 0.15)), weights)

    return read


def advance_on_surface(
    xp: Namespace, law: AbstractLaw, memory: Any, coupling: SurfaceCoupling, dt: Scalar
) -> SurfaceStep:
    """Return the memories of a step.

    Args:
        xp: namespace.
        law: law with `has_surface`.
        memory: memory at the start.
        coupling: load line and heat balance of the element.
        dt: length of the step [s], above 0.
    """
    begin: Column = [law.fractions(memory).martensite, memory.temperature]
    phases = type(law.fractions(memory))
    net, (by_fraction, by_temperature) = _differentiate(xp, lambda xp, at: coupling.power(xp, at, 0.0), begin)
    # by the slope at the start: a turn later in the step is found on the path
    trial = begin[1] + dt * net / (coupling.capacity - dt * xp.minimum(by_temperature, 0.0))
    selected = law.select(xp, memory, coupling.stress(xp, [begin[0], trial]), trial)
    move = law.continue_process(xp, memory, selected)

    def gap(xp: Namespace, at: Column) -> Scalar:
        return law.follow(xp, move, coupling.stress(xp, at), at[1], dt).martensite - at[0]

    def find_slope(at: Column, share: float) -> Column:
        """Return the changes of ξ and temperature over the step at their slopes."""
        _, (own, other) = _differentiate(xp, gap, at)  # dξ/dT is -other/own
        change = dt * coupling.power(xp, at, share) / (coupling.capacity * own + coupling.latent * other)
        return [-other * change, own * change]

    slopes: list[Column] = []
    for share, weights in zip(TIMES, STAGES, strict=True):
        slopes.append(find_slope(_move(begin, slopes, weights), share))
    _, (own, other) = _differentiate(xp, gap, begin)
    decay = dt * (by_fraction * other - by_temperature * own) / (coupling.capacity * own + coupling.latent * other)
    fine = _move(begin, slopes, STAGES[-1])

    def commit(process: Any, at: Column) -> Any:
        stress = coupling.stress(xp, at)
        return law.commit(xp, memory, process, phases(at[0], at[0]), stress, at[1], dt)

    def settle(at: Column) -> tuple[Any, Scalar]:
        """Return the memory at the end, and the expected mismatch of its fraction."""
        untransformed = at[1] - coupling.latent / coupling.capacity * (at[0] - begin[0])
        process = law.select(xp, memory, coupling.stress(xp, [begin[0], untransformed]), untransformed)

        def miss(xp: Namespace, x: Scalar) -> Scalar:
            return law.follow(xp, process, coupling.stress(xp, [x, at[1]]), at[1], dt).martensite - x

        # Ostrowski's method: as accurate as two steps of Newton's method, with one slope
        short, slope = value_and_slope(xp, miss, at[0])
        first = xp.clip(at[0] - short / slope, 0.0, 1.0)
        rest = miss(xp, first)
        falls = 4.0 * xp.abs(rest) < xp.abs(short)
        left = xp.where(falls, short, 1.0) * rest / (slope * xp.where(falls, short - 2.0 * rest, 1.0))
        return commit(process, [xp.clip(first - left, 0.0, 1.0), at[1]]), left * left

    def incline(at: Column, slope: Column) -> tuple[Any, Column]:
        """Return the change of the memory, and of temperature, stress and ξ, over the step at a slope."""
        _, by_place = _differentiate(xp, coupling.stress, at)
        pressed = _weigh(by_place, slope)
        shape = NestedShape(memory)
        still = shape.rebuild([0.0] * len(flatten_numbers(memory)))
        return still._replace(fraction=slope[0], stress=pressed, temperature=slope[1]), (slope[1], pressed, slope[0])

    def show(at: Column) -> Column:
        return at[1], coupling.stress(xp, at), at[0]

    coarse = [x - _weigh(ERROR, [one[i] for one in slopes]) for i, x in enumerate(fine)]
    middle = _move(begin, slopes, MIDDLE)
    (first, rise), (last, fall) = incline(begin, slopes[0]), incline(fine, slopes[-1])
    path = PathPoints(show(begin), show(middle), show(fine), rise, fall)
    end, residual = settle(fine)
    return SurfaceStep(
        end=end,
        middle=commit(move, middle),
        coarse=commit(move, coarse),
        begin=commit(selected, begin),
        slopes=(first, last),
        path=path,
        residual=residual,
        decay=decay,
    )


def _weigh(weights: Sequence[float], numbers: Column) -> Scalar:
    result: Scalar = 0.0
    for weight, number in zip(weights, numbers, strict=True):
        result = result + weight * number
    return result


def _move(begin: Column, slopes: Sequence[Column], weights: Sequence[float]) -> Column:
    return [x + _weigh(weights, [one[i] for one in slopes[: len(weights)]]) for i, x in enumerate(begin)]


def _differentiate(
    xp: Namespace, function: Callable[[Namespace, Column], Scalar], at: Column
) -> tuple[Scalar, list[Scalar]]:
    (value,), (slopes,) = compute_jacobian(xp, lambda xp, x: [function(xp, x)], at)
    return value, slopes
