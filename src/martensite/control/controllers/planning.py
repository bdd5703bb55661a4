"""Plans of a predictive controller: their cost and their search, as a kernel.

A plan is a signal for every drive that is constant over each of N equal blocks of the horizon H. Its cost is

    J = 1/H ∫ Σ ((r - y)/e)² + p P + w ((T - T_max)₊/1 K)² + w ((σ - σ_max)₊/1 MPa)² dt
        + c/N Σ ((u_j - u_j-1)/(u_high - u_low))²

with known references r, outputs y of the model, the error e that costs 1, the power P and its price p, the price w of
an excess, and the price c of changes between blocks; u_0 is the present signal.

A round of the search rates several plans on the model: the best plan so far; plans with one signal moved a little
towards the middle of its range; plans that reach far, as a dead band requires (one drive changed, up to full or off,
in a window of the horizon; all drives off); and plans along the direction of the previous round. The best plan starts
the next round. Costs only grow along the horizon, so plans that reach far stop after the block in which their cost
exceeds the least so far. The direction is a Gauss-Newton step

    (DᵀD + C + λI) d = -½ ∂J/∂u,    D = ∂(mean errors and excesses of the blocks)/∂u

by differences between the plans, without signals that are pushed against a limit. Differences, unlike derivatives, see
across a corner of the hysteresis.

Source: real-time iteration, Diehl, Bock and Schlöder (2005), extended by plans that reach far.
"""

import math
from collections.abc import Sequence
from itertools import cycle, islice
from typing import Any, NamedTuple

from martensite.actuators.assembly import AbstractSystem
from martensite.actuators.mechanics.elimination import multiply_inner, solve_linear
from martensite.base.parameters import Number, Parametrised, param
from martensite.base.units import DIFFERENCE
from martensite.kernels.namespace import Namespace, Scalar
from martensite.kernels.nested import NestedShape, flatten_numbers, sum_column
from martensite.simulate.march import SOLVED

KELVIN, MEGAPASCAL = 1.0, 1e6
APART = 0.03
"""Step of a signal for slopes of the cost, as a fraction of the range."""
ALONG = (0.1, 0.3, 0.6, 1.0, 1.5)
"""Fractions of the direction in the search."""
WINDOWS = (
    *((0.0, 0.05), (0.0, 0.1), (0.0, 0.2), (0.0, 0.4), (0.0, 1.0)),
    *((0.05, 0.4), (0.1, 0.8), (0.2, 1.0), (0.4, 1.0), (0.6, 1.0)),
)
"""Windows of the horizon in which a drive is changed, as fractions."""
MORE = (-1.0, -0.3, -0.1, 0.1, 0.3, 1.0)
"""Changes of a signal as fractions of the range; limits turn the whole range into full or zero signal."""
FEW_WINDOWS, MUCH_MORE = ((0.0, 0.1), (0.0, 0.3), (0.0, 1.0), (0.3, 1.0), (0.6, 1.0)), (-1.0, -0.3, 0.3, 1.0)
"""Windows and changes for several drives: fewer, to limit the computing time."""
DAMPING = 1e-3
"""λ as a fraction of the mean of the diagonal."""
RANGE_TOLERANCE = 1e-9
"""Fraction of the range that is rounding."""
HUGE = 1e30
"""Cost of a plan under which the model fails."""

Numbers = list[Scalar]


class Price(Parametrised):
    """Prices of errors, energy, changes, and excesses of temperature and stress in a plan."""

    error: Number = param(DIFFERENCE, "error that costs 1", above=0.0, default=1e-4)
    energy: Number = param("1/W", "price of electrical power", low=0.0, default=0.0)
    change: Number = param("1", "price of changes of the signal", low=0.0, default=0.01)
    hottest: Number = param("K", "highest temperature without a cost", default=math.inf)
    strongest: Number = param("Pa", "highest stress without a cost", default=math.inf)
    excess: Number = param("1", "price of an excess of 1 K or 1 MPa", low=0.0, default=1000.0)

    def layout(self) -> tuple[int, ...]:
        return int(math.isfinite(self.hottest)), int(math.isfinite(self.strongest))

    def check(self) -> None:
        self.__dict__["_bounded"] = self.layout()


class PlanCost(NamedTuple):
    """Cost of a plan."""

    total: Scalar
    linear: Scalar
    """Cost of energy, which is not a square."""
    residuals: Numbers
    """Means of errors and excesses of every block; the sum of their squares approximates the rest without changes."""


class PlanStart(NamedTuple):
    """Start of the next search, for all drives in every block."""

    plan: tuple[Scalar, ...]
    origin: tuple[Scalar, ...]
    """Plan at which the direction begins."""
    direction: tuple[Scalar, ...]


class Planner(NamedTuple):
    """Data of the search in one sample."""

    model: AbstractSystem
    outputs: Sequence[str]
    """Outputs that follow references."""
    price: Price
    limits: tuple[Scalar, Scalar]
    blocks: int
    turns: int
    """Steps of the model in a block."""
    length: Scalar
    """Duration of a block [s]."""
    state: Any
    signals: Sequence[Scalar]
    """Signals of the last period."""
    targets: Sequence[Scalar]
    """References less offsets, now and at the end of every block, in succession."""
    shifts: Sequence[Scalar] = ()
    """Signal that is added in the model, by drive; empty for zero."""

    @property
    def drives(self) -> int:
        """Return the number of drives."""
        return len(self.signals)

    def search(self, xp: Namespace, rounds: int, begin: PlanStart) -> PlanStart:
        """Return the best plan after several rounds."""
        shape = NestedShape(begin)

        def turn(*numbers: Scalar) -> Numbers:
            return flatten_numbers(self.improve(xp, shape.rebuild(numbers)))

        flat = flatten_numbers(begin)
        return shape.rebuild(turn(*flat) if rounds == 1 else xp.repeat(rounds, turn, *flat))

    def improve(self, xp: Namespace, best_so_far: PlanStart) -> PlanStart:
        """Return the result of one round."""
        count = len(best_so_far.plan)
        middle = 0.5 * (self.limits[0] + self.limits[1])
        step = APART * (self.limits[1] - self.limits[0])
        steps = [xp.where(u > middle, -step, step) for u in best_so_far.plan]
        near = [[u + s if i == j else u for j, u in enumerate(best_so_far.plan)] for i, s in enumerate(steps)]
        complete = [list(best_so_far.plan), *near]
        plans = [*complete, *self._follow_line(xp, best_so_far), *self._reach_far(xp, best_so_far.plan)]
        limits = [math.inf if k < len(complete) else 0.0 for k in range(len(plans))]

        def rate(least: Scalar, *numbers: Scalar) -> Numbers:
            best, (limit,), plan = cut_pieces(numbers, (count, 1, count))
            apart = [u - v for u, v in zip(plan, best_so_far.plan, strict=True)]
            is_new = multiply_inner(apart, apart) > 0.0
            cost = self.rate_plan(xp, plan, xp.maximum(limit, xp.where(is_new, least, 0.0)))
            chosen = [xp.where(cost.total < least, u, v) for u, v in zip(plan, best, strict=True)]
            return [xp.minimum(least, cost.total), *chosen, cost.linear, *cost.residuals]

        columns = xp.scan(rate, (HUGE, *best_so_far.plan), limits, *zip(*plans, strict=True))
        best, parts = [column[-1] for column in columns[1 : 1 + count]], columns[1 + count :]
        slopes = [[(column[1 + i] - column[0]) / steps[i] for column in parts] for i in range(count)]
        direction = self._find_direction(xp, best_so_far.plan, slopes, [column[0] for column in parts[1:]])
        return PlanStart(tuple(best), best_so_far.plan, tuple(direction))

    def _reach_far(self, xp: Namespace, plan: Sequence[Scalar]) -> list[Numbers]:
        plans: list[Numbers] = [[self.limits[0]] * len(plan)]
        for drive in range(self.drives):
            for first, last in self._list_windows():
                for more in MORE if self.drives == 1 else MUCH_MORE:
                    changed = [xp.clip(u + more * self._range, *self.limits) for u in plan]
                    there = [first <= j // self.drives < last and j % self.drives == drive for j in range(len(plan))]
                    plans.append([v if x else u for x, u, v in zip(there, plan, changed, strict=True)])
        return plans

    def _list_windows(self) -> list[tuple[int, int]]:
        """Return the first block of every window and the block after its last, without repetition."""
        windows = WINDOWS if self.drives == 1 else FEW_WINDOWS
        ends = [(round(a * self.blocks), round(b * self.blocks)) for a, b in windows]
        return list(dict.fromkeys((a, max(b, a + 1)) for a, b in ends))

    def _follow_line(self, xp: Namespace, best_so_far: PlanStart) -> list[Numbers]:
        rows = list(zip(best_so_far.origin, best_so_far.direction, strict=True))
        return [[xp.clip(u + fraction * d, *self.limits) for u, d in rows] for fraction in ALONG]

    def _find_direction(
        self, xp: Namespace, plan: Sequence[Scalar], slopes: Sequence[Numbers], residuals: Numbers
    ) -> Numbers:
        """Return the Gauss-Newton step without signals at a limit; `slopes`: of the energy, then of the residuals."""
        count, kinds = len(plan), len(residuals) // self.blocks
        gradient, matrix = Numbers(), [[0.0] * count for _ in range(count)]
        for i, row in enumerate(slopes):
            before = kinds * (i // self.drives)  # what came before this signal does not depend on it
            gradient.append(0.5 * row[0] + multiply_inner(row[1 + before :], residuals[before:]))
            for j in range(i + 1):
                matrix[i][j] = matrix[j][i] = multiply_inner(row[1 + before :], slopes[j][1 + before :])
        self._charge_changes(plan, gradient, matrix)
        damping = DAMPING * (sum_column([matrix[i][i] for i in range(count)]) / count) + 1e-9
        low, high = self.limits[0] + RANGE_TOLERANCE * self._range, self.limits[1] - RANGE_TOLERANCE * self._range
        free = [
            xp.negate(xp.either(xp.both(u <= low, g > 0.0), xp.both(u >= high, g < 0.0)))
            for u, g in zip(plan, gradient, strict=True)
        ]
        rows = [
            [
                xp.where(xp.both(free[i], free[j]), matrix[i][j], 0.0) + (damping if i == j else 0.0)
                for j in range(count)
            ]
            for i in range(count)
        ]
        (direction,) = solve_linear(rows, [[xp.where(f, -g, 0.0) for f, g in zip(free, gradient, strict=True)]])
        return [xp.where(xp.abs(d) < HUGE, d, 0.0) for d in direction]

    def _charge_changes(self, plan: Sequence[Scalar], gradient: Numbers, matrix: list[Numbers]) -> None:
        """Add the cost of changes to half the gradient and to the matrix."""
        weight = self.price.change / (self.blocks * self._range * self._range)
        for i, u in enumerate(plan):
            before = i - self.drives
            change = weight * (u - (plan[before] if before >= 0 else self.signals[i]))
            gradient[i] = gradient[i] + change
            matrix[i][i] = matrix[i][i] + weight
            if before >= 0:
                gradient[before] = gradient[before] - change
                matrix[before][before] = matrix[before][before] + weight
                matrix[i][before] = matrix[i][before] - weight
                matrix[before][i] = matrix[before][i] - weight

    @property
    def _range(self) -> Scalar:
        return self.limits[1] - self.limits[0]

    # ------------------------------------------------------------ one plan

    def rate_plan(self, xp: Namespace, plan: Sequence[Scalar], limit: Scalar = math.inf) -> PlanCost:
        """Return the cost of a plan; `HUGE` where the model fails or the cost is above `limit`.

        Costs only grow along the horizon, so the model stops after a block with a cost above the limit.
        """
        shape, size, count = NestedShape(self.state), len(flatten_numbers(self.state)), len(plan)
        kinds = self._count_kinds()
        parts = (size, count, len(self.targets), self.drives, kinds * self.blocks, 3)

        def block(_: Scalar, *numbers: Scalar) -> Numbers:
            state, ahead, wanted, before, residuals, (cost, energy, worst) = cut_pieces(numbers, parts)
            now = ahead[: self.drives]
            outputs = len(self.outputs)
            result = self._go_block(xp, shape.rebuild(state), now, (wanted[:outputs], wanted[outputs : 2 * outputs]))
            state, sums, (squares, power, failed) = cut_pieces(result, (size, kinds, 3))
            changes = [((u - v) / self._range) for u, v in zip(now, before, strict=True)]
            cost = cost + (squares + self.price.change * multiply_inner(changes, changes)) / self.blocks
            scale = 1.0 / math.sqrt(self.blocks)
            residuals = [*residuals[kinds:], *(scale * x for x in sums)]
            wanted = [*wanted[outputs:], *wanted[:outputs]]
            energy = energy + self.price.energy * power / self.blocks
            worst = xp.maximum(worst, failed)
            going = xp.where(cost + energy > limit, 0.0, 1.0)
            return [going, *state, *ahead[self.drives :], *now, *wanted, *now, *residuals, cost, energy, worst]

        given = [[u + d for u, d in zip(x, cycle(self.shifts))] if self.shifts else x for x in (plan, self.signals)]
        begin = [*flatten_numbers(self.state), *given[0], *self.targets, *given[1]]
        going, *result = xp.iterate(self.blocks, block, 1.0, *begin, *[0.0] * (kinds * self.blocks), 0.0, 0.0, 0.0)
        *_, residuals, (cost, energy, worst) = cut_pieces(result, parts)
        total = cost + energy
        is_rated = xp.both(going > 0.0, xp.both(total < HUGE, worst <= SOLVED))
        total = xp.where(is_rated, total, HUGE)
        return PlanCost(total, energy, residuals)

    def _go_block(
        self, xp: Namespace, state: Any, signals: Sequence[Scalar], wanted: tuple[Numbers, Numbers]
    ) -> Sequence[Scalar]:
        """Return state, means of errors and excesses, squares, power and worst residual after a block."""
        shape, size, kinds = NestedShape(state), len(flatten_numbers(state)), self._count_kinds()
        part = 1.0 / self.turns

        def step(*numbers: Scalar) -> Numbers:
            flat, means, (squares, power, worst, fraction) = cut_pieces(numbers, (size, kinds, 4))
            after, report = self.model.step(xp, shape.rebuild(flat), *signals, dt=self.length * part)
            outputs = dict(zip(self.model.outputs(), self.model.observe(xp, after, *signals), strict=True))
            fraction = fraction + part
            ahead = [a + fraction * (b - a) for a, b in zip(*wanted, strict=True)]
            errors = [(y - outputs[n]) / self.price.error for y, n in zip(ahead, self.outputs, strict=True)]
            errors += self._list_excesses(xp, outputs)
            squares = squares + part * multiply_inner(errors, errors)
            power = power + part * sum_column([outputs[name] for name in self._list_outputs("power")])
            means = [x + part * e for x, e in zip(means, errors, strict=True)]
            return [*flatten_numbers(after), *means, squares, power, xp.maximum(worst, report.residual), fraction]

        begin = [*flatten_numbers(state), *[0.0] * (kinds + 4)]
        result = step(*begin) if self.turns == 1 else xp.repeat(self.turns, step, *begin)
        return result[:-1]

    def _count_kinds(self) -> int:
        hot, strong = self.price.__dict__["_bounded"]
        return len(self.outputs) + hot * len(self._list_outputs("hottest")) + strong * len(self._list_outputs("stress"))

    def _list_excesses(self, xp: Namespace, outputs: dict[str, Scalar]) -> Numbers:
        """Return the excesses over priced bounds, times the square root of the price."""
        hot, strong = self.price.__dict__["_bounded"]
        weight, excesses = xp.sqrt(self.price.excess), Numbers()
        bounds = ((hot, "hottest", self.price.hottest, KELVIN), (strong, "stress", self.price.strongest, MEGAPASCAL))
        for bounded, kind, bound, unit in bounds:
            if bounded:
                excesses += [weight * xp.maximum(outputs[n] - bound, 0.0) / unit for n in self._list_outputs(kind)]
        return excesses

    def _list_outputs(self, kind: str) -> list[str]:
        return [self.model.label(port, kind) for port in self.model.actuators()]


def cut_pieces(numbers: Sequence[Scalar], sizes: Sequence[int]) -> list[Any]:
    """Return the numbers in pieces of these sizes."""
    rest = iter(numbers)
    return [list(islice(rest, size)) for size in sizes]


def shift_plan(plan: Sequence[Scalar], drives: int, fraction: Scalar) -> Numbers:
    """Return a plan shifted by a fraction of a block; its last signals stay."""
    after = [*plan[drives:], *plan[-drives:]]
    return [(1.0 - fraction) * u + fraction * v for u, v in zip(plan, after, strict=True)]
