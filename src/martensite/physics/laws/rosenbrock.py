"""Rosenbrock step of a rate-dependent law, coupled with heat and mechanism.

The populations x of all groups of layers and the temperature T follow

    dx/dt = f(x, σ, T),     C dT/dt = P(ξ, T, t) - Q(T) + Λ(σ, T) dξ/dt,     σ = S(ξ, oriented, T)

with the stress S on the load line. Rodas4 needs six linear solves with the matrix I/(γ Δt) - J; it is stiffly accurate,
L-stable and of order four, and an embedded solution of order three gives the error. The matrix is never assembled:
groups are coupled through stress and temperature only, so each is a 2 × 2 system, and one equation gives the
temperature.

Long steps may leave fractions outside 0 to 1. The result is limited, the embedded solution is not, so that the error
control detects the excess.

Sources: Hairer and Wanner (1996), Solving Ordinary Differential Equations II, section IV.7 and their code RODAS for the
coefficients and the continuous output.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

from martensite.kernels.dual import compute_jacobian
from martensite.kernels.namespace import Namespace, Scalar
from martensite.kernels.nested import sum_column
from martensite.physics.kinetics.exchange import AbstractExchange, Flows
from martensite.physics.laws.base import Fractions

Column = Sequence[Scalar]

GAMMA = 0.25
POINTS = (
    (),
    (1.544,),
    (0.9466785280815826, 0.2557011698983284),
    (3.314825187068521, 2.896124015972201, 0.9986419139977817),
    (1.221224509226641, 6.019134481288629, 12.53708332932087, -0.6878860361058950),
    (1.221224509226641, 6.019134481288629, 12.53708332932087, -0.6878860361058950, 1.0),
)
"""Coefficients of previous stages in the state of each stage."""
CARRIED = (
    (),
    (-5.6688,),
    (-2.430093356833875, -0.2063599157091915),
    (-0.1073529058151375, -9.594562251023355, -20.47028614809616),
    (7.496443313967647, -10.24680431464352, -33.99990352819905, 11.70890893206160),
    (8.083246795921522, -7.981132988064893, -31.52159432874371, 16.31930543123136, -6.058818238834054),
)
"""Coefficients of previous stages in the equation of each stage, per step."""
TIMES = (0.0, 0.386, 0.21, 0.63, 1.0, 1.0)
SLOPES = (0.25, -0.1043, 0.1035, -0.0362, 0.0, 0.0)
"""Factors of the explicit time derivative."""
INNER = (10.12623508344586, -7.487995877610167, -34.80091861555747, -7.992771707568823, 1.025137723295662)
OUTER = (-0.6762803392801253, 6.087714651680015, 16.43084320892478, 24.76722511418386, -6.594389125716872)
"""Coefficients of the continuous output."""


class Coupling(NamedTuple):
    """Coupling of a rate-dependent law; `at` is (ξ, oriented fraction, temperature [K])."""

    stress: Callable[[Namespace, Column], Scalar]
    """Stress on the load line [Pa]."""
    power: Callable[[Namespace, Column], Column]
    """Net heat flow in the middle of the step [W], and its time derivative [W/s]."""
    latent: Callable[[Namespace, Scalar, Scalar], Scalar]
    """Heat of the whole forward transformation [J] at (stress [Pa], temperature [K])."""
    capacity: Scalar
    """[J/K]"""


class _Group(NamedTuple):
    """Population of each variant in a group, or its change."""

    plus: Scalar
    minus: Scalar


class _Linear(NamedTuple):
    """Linearised rates of all groups; one entry per group."""

    rates: _Columns
    inverse: tuple[Column, Column, Column, Column]
    """Inverse of I/(γ Δt) - J within a group."""
    response: _Columns
    """That inverse times the rates."""
    by_stress: _Columns
    """That inverse times the derivative with respect to stress."""
    by_temperature: _Columns


class _Columns(NamedTuple):
    """Populations of all groups, or their changes."""

    plus: Column
    minus: Column

    def mean(self) -> tuple[Scalar, Scalar]:
        """Return the mean martensite and oriented fractions."""
        share = 1.0 / len(self.plus)
        a, b = share * sum_column(self.plus), share * sum_column(self.minus)
        return a + b, a - b


class _Stage(NamedTuple):
    """Change of the whole system."""

    groups: _Columns
    martensite: Scalar
    oriented: Scalar
    temperature: Scalar

    def scalars(self) -> list[Scalar]:
        return [self.martensite, self.oriented, self.temperature]


def advance_rosenbrock(
    xp: Namespace, law: AbstractExchange, memory: Any, coupling: Coupling, dt: Scalar
) -> tuple[Any, Any, Any]:
    """Return the memory after a step of dt > 0 [s], in its middle, and after it to the lower order."""
    start = _Columns(*law.populations(memory))
    at = [*start.mean(), memory.temperature]
    stages = _Stages(xp, law, coupling, start, at, dt).solve()
    begin = _Stage(start, *at)
    coarse = _sum_stages(xp, begin, stages[:5], POINTS[5])
    fine = _sum_stages(xp, coarse, stages[5:], (1.0,))
    bend = [a + 0.5 * b for a, b in zip(INNER, OUTER, strict=True)]
    mean = _sum_stages(xp, _sum_stages(xp, begin, [begin], (-0.5,)), [fine], (0.5,))
    middle = _sum_stages(xp, mean, stages[:5], [0.25 * x for x in bend])
    settle = _make_settle(xp, law, coupling)
    return settle(fine, True), settle(middle, True), settle(coarse, False)


class _Stages:
    """The six linear solves of a step."""

    def __init__(
        self,
        xp: Namespace,
        law: AbstractExchange,
        coupling: Coupling,
        start: _Columns,
        at: Sequence[Scalar],
        dt: Scalar,
    ) -> None:
        self.xp, self.law, self.coupling, self.dt = xp, law, coupling, dt
        self.begin = _Stage(start, *at)
        self.per_step = 1.0 / dt
        self.diagonal = self.per_step * (1.0 / GAMMA)
        stress, self.by_state = self._stress(at)
        self.linear = self._linearise(stress)
        self.moved = self.linear.rates.mean()[0]
        """Rate of ξ at the start."""
        self._close(at)

    def solve(self) -> list[_Stage]:
        stages: list[_Stage] = []
        for k in range(6):
            stages.append(self._solve_stage(k, stages))
        return stages

    def _stress(self, at: Sequence[Scalar]) -> tuple[Scalar, list[Scalar]]:
        """Return the stress on the load line, and its derivatives."""

        def stress(xp: Namespace, at: Column) -> Column:
            return [self.coupling.stress(xp, at)]

        (value,), (slopes,) = compute_jacobian(self.xp, stress, at)
        return value, slopes

    def _linearise(self, stress: Scalar) -> _Linear:
        xp, law, diagonal = self.xp, self.law, self.diagonal
        temperature = self.begin.temperature

        def group(quantile: Scalar, plus: Scalar, minus: Scalar) -> list[Scalar]:
            def jumps(xp: Namespace, at: Column) -> Column:
                return law.jumps(xp, at[0], at[1])(quantile)

            flows, slopes = compute_jacobian(xp, jumps, [stress, temperature])
            here, rates = _Group(plus, minus), Flows(*flows)
            by_stress, by_temperature = (Flows(*column) for column in zip(*slopes, strict=True))
            up, over = rates.to_plus, rates.to_minus
            a, d = diagonal + up + rates.from_plus, diagonal + over + rates.from_minus
            share = 1.0 / (a * d - up * over)
            inverse = [share * x for x in (d, -up, -over, a)]
            changes = (_sum_flows(rates, here), _sum_flows(by_stress, here), _sum_flows(by_temperature, here))
            products = (number for change in changes for number in _multiply_matrix(inverse, change))
            return [*changes[0], *inverse, *products]

        columns = _map_rows(xp, group, law.quantiles(), *self.begin.groups)
        a, b, c, d = columns[2:6]
        rates, *products = (_Columns(*columns[k : k + 2]) for k in (0, 6, 8, 10))
        return _Linear(rates, (a, b, c, d), *products)

    def _close(self, at: Sequence[Scalar]) -> None:
        """Compute the response of stress and temperature to a change within the groups."""
        xp, coupling, moved = self.xp, self.coupling, self.moved

        def balance(xp: Namespace, at: Column) -> Column:
            latent = coupling.latent(xp, coupling.stress(xp, at), at[2])
            net, slope = coupling.power(xp, at)
            return [net - 0.5 * self.dt * slope + latent * moved, slope, latent]

        (self.heat, self.slope, self.latent), (by_state, *_) = compute_jacobian(xp, balance, at)
        (by_m, by_o, by_T), (ms, os) = self.by_state, self.linear.by_stress.mean()
        mT, oT = self.linear.by_temperature.mean()
        yields = 1.0 / (1.0 - by_m * ms - by_o * os)
        self.stress_by_m, self.stress_by_o = yields * by_m, yields * by_o
        self.of_stress = (ms, os)
        stress_by_T = yields * (by_m * mT + by_o * oT + by_T)

        def both(one: Scalar, other: Scalar) -> list[Scalar]:
            return [other + one * stress_by_T]

        columns = zip(self.linear.by_stress, self.linear.by_temperature, strict=True)
        self.by_temperature = _Columns(*(_map_rows(xp, both, *pair)[0] for pair in columns))
        self.of_temperature = (m, o) = (mT + ms * stress_by_T, oT + os * stress_by_T)
        by_m, by_o, by_T = by_state
        rest = self.diagonal * (coupling.capacity - self.latent * m) - by_m * m - by_o * o - by_T
        self.share = 1.0 / rest
        by_m = by_m + self.latent * self.diagonal
        by_stress = by_m * ms + by_o * os
        self.heated_by_m = self.share * (by_m + by_stress * self.stress_by_m)
        self.heated_by_o = self.share * (by_o + by_stress * self.stress_by_o)

    def _evaluate(self, k: int, before: Sequence[_Stage]) -> tuple[_Columns, Scalar, Scalar]:
        """Return the response of the groups at frozen stress and temperature, their gain, and the heat [W]."""
        if k == 0:
            return self.linear.response, self.moved, self.heat
        xp, coupling = self.xp, self.coupling
        at = self._state(POINTS[k], before)
        stress = coupling.stress(xp, at)
        response, gained, moved = self._ask_groups(k, stress, at[2], before)
        power, slope = coupling.power(xp, at)
        heat = power + (TIMES[k] - 0.5) * self.dt * slope
        heat = heat + coupling.latent(xp, stress, at[2]) * moved
        own = _weigh_numbers(CARRIED[k], [one.temperature for one in before])
        return response, gained, heat + coupling.capacity * self.per_step * own

    def _solve_stage(self, k: int, before: Sequence[_Stage]) -> _Stage:
        xp = self.xp
        response, gained, heat = self._evaluate(k, before)
        heat = heat + SLOPES[k] * self.dt * self.slope
        m, o = response.mean()
        change = self.share * (heat - self.latent * gained) + self.heated_by_m * m + self.heated_by_o * o
        stress = self.stress_by_m * m + self.stress_by_o * o

        def group(*row: Scalar) -> list[Scalar]:
            return [a + b * stress + c * change for a, b, c in zip(row[:2], row[2:4], row[4:], strict=True)]

        groups = _map_rows(xp, group, *response, *self.linear.by_stress, *self.by_temperature)
        (ms, os), (mT, oT) = self.of_stress, self.of_temperature
        return _Stage(_Columns(*groups), m + ms * stress + mT * change, o + os * stress + oT * change, change)

    def _state(self, weights: Sequence[float], before: Sequence[_Stage]) -> list[Scalar]:
        """Return fractions and temperature at a stage."""
        changes = zip(*(one.scalars() for one in (self.begin, *before)), strict=True)
        return [x + _weigh_numbers(weights, rest) for x, *rest in changes]

    def _ask_groups(
        self, k: int, stress: Scalar, temperature: Scalar, before: Sequence[_Stage]
    ) -> tuple[_Columns, Scalar, Scalar]:
        """Return the response of the groups at frozen stress and temperature, their gain and rate of ξ."""
        xp, law, begin = self.xp, self.law, self.begin.groups
        per_step, count = self.per_step, len(before)
        jumps = law.jumps(xp, stress, temperature)

        def group(quantile: Scalar, *row: Scalar) -> list[Scalar]:
            inverse, here, rest = row[:4], row[4:6], row[6:]
            plus, minus = rest[:count], rest[count:]
            point = _Group(here[0] + _weigh_numbers(POINTS[k], plus), here[1] + _weigh_numbers(POINTS[k], minus))
            rates = _sum_flows(jumps(quantile), point)
            gain = _Group(
                rates.plus + per_step * _weigh_numbers(CARRIED[k], plus),
                rates.minus + per_step * _weigh_numbers(CARRIED[k], minus),
            )
            return [*_multiply_matrix(inverse, gain), gain.plus + gain.minus, rates.plus + rates.minus]

        columns = _map_rows(
            xp,
            group,
            law.quantiles(),
            *self.linear.inverse,
            *begin,
            *(one.groups.plus for one in before),
            *(one.groups.minus for one in before),
        )
        share = 1.0 / len(columns[0])
        gained, moved = (share * sum_column(column) for column in columns[2:])
        return _Columns(*columns[:2]), gained, moved


def _sum_flows(flows: Flows, at: _Group) -> _Group:
    austenite = 1.0 - at.plus - at.minus
    return _Group(
        flows.to_plus * austenite - flows.from_plus * at.plus, flows.to_minus * austenite - flows.from_minus * at.minus
    )


def _multiply_matrix(matrix: Sequence[Scalar], change: _Group) -> _Group:
    a, b, c, d = matrix
    return _Group(a * change.plus + b * change.minus, c * change.plus + d * change.minus)


def _weigh_numbers(weights: Sequence[float], numbers: Sequence[Scalar]) -> Scalar:
    result: Scalar = 0.0
    for weight, number in zip(weights, numbers, strict=True):
        result = result + weight * number
    return result


def _map_rows(xp: Namespace, body: Callable[..., Sequence[Scalar]], *columns: Column) -> tuple[Column, ...]:
    """Return columns of results; a single row needs no loop."""
    if len(columns[0]) > 1:
        return tuple(xp.each(body, *columns))
    return tuple((x,) for x in body(*(column[0] for column in columns)))


def _sum_stages(xp: Namespace, begin: _Stage, stages: Sequence[_Stage], weights: Sequence[float]) -> _Stage:

    def add(x: Scalar, *more: Scalar) -> list[Scalar]:
        return [x + _weigh_numbers(weights, more)]

    groups = (
        _map_rows(xp, add, column, *(one.groups[i] for one in stages))[0] for i, column in enumerate(begin.groups)
    )
    scalars = [one.scalars() for one in stages]
    rest = (add(x, *column)[0] for x, *column in zip(begin.scalars(), *scalars, strict=True))
    return _Stage(_Columns(*groups), *rest)


def _make_settle(xp: Namespace, law: AbstractExchange, coupling: Coupling) -> Callable[[_Stage, bool], Any]:
    """Return a function that makes a memory of a state, optionally with limited populations."""

    def limit(plus: Scalar, minus: Scalar) -> list[Scalar]:
        plus = xp.clip(plus, 0.0, 1.0)
        return [plus, xp.clip(minus, 0.0, 1.0 - plus)]

    def settle(state: _Stage, limited: bool) -> Any:
        groups = state.groups
        if limited:
            groups = _Columns(*_map_rows(xp, limit, *groups))
        fractions = Fractions(*groups.mean())
        stress = coupling.stress(xp, [*fractions, state.temperature])
        return law.remember(xp, *groups, stress, state.temperature)

    return settle
