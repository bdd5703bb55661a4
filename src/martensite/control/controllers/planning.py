"""Plans of a predictive controller: what they cost, and how a good one is searched, as a kernel.

A plan is a signal for every drive that is constant over each of N equal blocks of the horizon. Its cost is a mean over
the horizon H,

    J = 1/H ∫ Σ ((r - y)/e)² + p P + w ((T - T_max)₊/1 K)² + w ((σ - σ_max)₊/1 MPa)² dt
        + c/N Σ ((u_j - u_j-1)/(u_high - u_low))²

with references r, known beforehand, what the model says of them y, the error e that costs 1, the power P and its price
p, the price w of an excess, and the price c of changes between the blocks; u_0 is the signal now.

Search: in a round some plans go through the model: the best one so far; the same with one of its signals a little
nearer to the middle of their range; plans that reach far, which is what a dead band needs (one drive with more or less,
up to full or off, in a window of the horizon and else as planned; all drives off); and some along the direction that
the round before has found. The best of all is the next to begin from. The direction is a Gauss-Newton step

    (DᵀD + C + λI) d = -½ ∂J/∂u,    D = ∂(mean errors and excesses of the blocks)/∂u

by the differences between the plans, without signals that stand at a limit and are pushed against it. Differences, not
derivatives: they see across a corner of the hysteresis.

Source of the method: Diehl, Bock and Schlöder (2005), a real-time iteration, with plans that reach far beside it.
"""

import math
from collections.abc import Sequence
from itertools import cycle
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
"""Shares of a direction that are tried."""
WINDOWS = (
    *((0.0, 0.05), (0.0, 0.1), (0.0, 0.2), (0.0, 0.4), (0.0, 1.0)),
    *((0.05, 0.4), (0.1, 0.8), (0.2, 1.0), (0.4, 1.0), (0.6, 1.0)),
)
"""Shares of the horizon in which a drive gets more or less: a while from now on, or later."""
MORE = (-1.0, -0.3, -0.1, 0.1, 0.3, 1.0)
"""Changes that are tried, as fractions of the range; limits turn a change by the whole range into full or zero signal.
"""
FEW_WINDOWS, MUCH_MORE = ((0.0, 0.1), (0.0, 0.3), (0.0, 1.0), (0.3, 1.0), (0.6, 1.0)), (-1.0, -0.3, 0.3, 1.0)
"""Windows and changes for several drives: fewer, so that the computing time of a period grows slowly with their number.
"""
DAMPING = 1e-3
"""λ, as a share of the mean of the diagonal."""
RANGE_TOLERANCE = 1e-9
"""Part of the range that is rounding."""
HUGE = 1e30
"""Cost of a plan under which the model fails."""

Numbers = list[Scalar]


class Price(Parametrised):
    """Prices of errors, energy, changes, and excesses of temperature and stress in a plan."""

    error: Number = param(DIFFERENCE, "error that costs 1", above=0.0, default=1e-4)
    energy: Number = param("1/W", "price of electrical power", low=0.0, default=0.0)
    change: Number = param("1", "price of changes of the signal", low=0.0, default=0.01)
    hottest: Number = param("K", "temperature that costs nothing yet", default=math.inf)
    strongest: Number = param("Pa", "stress that costs nothing yet", default=math.inf)
    excess: Number = param("1", "price of 1 K or 1 MPa more than that", low=0.0, default=1000.0)

    def layout(self) -> tuple[int, ...]:
        """Return whether temperature and stress have a price."""
        return int(math.isfinite(self.hottest)), int(math.isfinite(self.strongest))

    def check(self) -> None:
        """Keep what has a price: it decides on the size of the program."""
        self.__dict__["_bounded"] = self.layout()


class PlanCost(NamedTuple):
    """Cost of a plan."""

    total: Scalar
    linear: Scalar
    """The part that no square makes: energy."""
    residuals: Numbers
    """Means of errors and excesses over every block; their squares add up to about the rest, but for changes."""


class Planned(NamedTuple):
    """Result of a search that the next search starts from, for all drives in every block."""

    plan: tuple[Scalar, ...]
    """The best one."""
    origin: tuple[Scalar, ...]
    """Plan at which the direction begins."""
    direction: tuple[Scalar, ...]


class Planner(NamedTuple):
    """The plans of one sample: what they are tried on."""

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
    """State of the model now."""
    signals: Sequence[Scalar]
    """Signals of the last period."""
    wanted: Sequence[Scalar]
    """References less what the model is known to lack, now and at the end of every block, one after the other."""
    shifts: Sequence[Scalar] = ()
    """Shift that is added to the signal of the model, by drive; zero if empty."""

    @property
    def drives(self) -> int:
        """Return the signals of a block."""
        return len(self.signals)

    def search(self, xp: Namespace, rounds: int, begin: Planned) -> Planned:
        """Return a better plan after some rounds."""
        shape = NestedShape(begin)

        def turn(*numbers: Scalar) -> Numbers:
            return flatten_numbers(self.improve(xp, shape.rebuild(numbers)))

        flat = flatten_numbers(begin)
        return shape.rebuild(turn(*flat) if rounds == 1 else xp.repeat(rounds, turn, *flat))

    def improve(self, xp: Namespace, known: Planned) -> Planned:
        """Improve the plan by one round."""
        count = len(known.plan)
        middle = 0.5 * (self.limits[0] + self.limits[1])
        apart = APART * (self.limits[1] - self.limits[0])
        steps = [xp.where(u > middle, -apart, apart) for u in known.plan]
        near = [[u + s if i == j else u for j, u in enumerate(known.plan)] for i, s in enumerate(steps)]
        plans = [list(known.plan), *near, *self._reach_far(xp, known.plan), *self._follow_line(xp, known)]

        def tell(*plan: Scalar) -> Numbers:
            cost = self.rate_plan(xp, plan)
            return [cost.total, cost.linear, *cost.residuals]

        found = xp.each(tell, *zip(*plans, strict=True))
        best = _choose_plan(xp, plans, found[0])
        slopes = [[(column[1 + i] - column[0]) / steps[i] for column in found[1:]] for i in range(count)]
        direction = self._find_direction(xp, known.plan, slopes, [column[0] for column in found[2:]])
        return Planned(tuple(best), known.plan, tuple(direction))

    def _reach_far(self, xp: Namespace, plan: Sequence[Scalar]) -> list[Numbers]:
        """Return the plans in which one drive gets more, or less, for a while, and one in which all are off."""
        found: list[Numbers] = [[self.limits[0]] * len(plan)]
        for drive in range(self.drives):
            for first, last in self._list_windows():
                for more in MORE if self.drives == 1 else MUCH_MORE:
                    changed = [xp.clip(u + more * self._range, *self.limits) for u in plan]
                    there = [first <= j // self.drives < last and j % self.drives == drive for j in range(len(plan))]
                    found.append([v if x else u for x, u, v in zip(there, plan, changed, strict=True)])
        return found

    def _list_windows(self) -> list[tuple[int, int]]:
        """Return the first block of every window, and the one after its last, each window once."""
        windows = WINDOWS if self.drives == 1 else FEW_WINDOWS
        ends = [(round(a * self.blocks), round(b * self.blocks)) for a, b in windows]
        return list(dict.fromkeys((a, max(b, a + 1)) for a, b in ends))

    def _follow_line(self, xp: Namespace, known: Planned) -> list[Numbers]:
        """Return the plans along the direction."""
        rows = list(zip(known.origin, known.direction, strict=True))
        return [[xp.clip(u + share * d, *self.limits) for u, d in rows] for share in ALONG]

    def _find_direction(
        self, xp: Namespace, plan: Sequence[Scalar], slopes: Sequence[Numbers], residuals: Numbers
    ) -> Numbers:
        """Return the Gauss-Newton step, without signals at a limit; slopes are those of the energy, then residuals."""
        count, kinds = len(plan), len(residuals) // self.blocks
        gradient, matrix = Numbers(), [[0.0] * count for _ in range(count)]
        for i, row in enumerate(slopes):
            before = kinds * (i // self.drives)  # what came before this signal does not depend on it
            gradient.append(0.5 * row[0] + multiply_inner(row[1 + before :], residuals[before:]))
            for j in range(i + 1):
                matrix[i][j] = matrix[j][i] = multiply_inner(row[1 + before :], slopes[j][1 + before :])
        self._charge_changes(plan, gradient, matrix)
        mean = sum_column([matrix[i][i] for i in range(count)]) / count
        low, high = self.limits[0] + RANGE_TOLERANCE * self._range, self.limits[1] - RANGE_TOLERANCE * self._range
        free = [
            xp.negate(xp.either(xp.both(u <= low, g > 0.0), xp.both(u >= high, g < 0.0)))
            for u, g in zip(plan, gradient, strict=True)
        ]
        rows = [
            [
                xp.where(xp.both(free[i], free[j]), matrix[i][j], 0.0) + (self._damp(mean) if i == j else 0.0)
                for j in range(count)
            ]
            for i in range(count)
        ]
        (found,) = solve_linear(rows, [[xp.where(f, -g, 0.0) for f, g in zip(free, gradient, strict=True)]])
        return [xp.where(xp.abs(d) < HUGE, d, 0.0) for d in found]

    @staticmethod
    def _damp(mean: Scalar) -> Scalar:
        return DAMPING * mean + 1e-9

    def _charge_changes(self, plan: Sequence[Scalar], gradient: Numbers, matrix: list[Numbers]) -> None:
        """Add what changes of signals add to half the gradient and to the matrix."""
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

    def rate_plan(self, xp: Namespace, plan: Sequence[Scalar]) -> PlanCost:
        """Return the cost of a plan; `HUGE` where the model fails."""
        shape, size, count = NestedShape(self.state), len(flatten_numbers(self.state)), len(plan)
        kinds = self._count_kinds()
        parts = (size, count, len(self.wanted), self.drives, kinds * self.blocks, 3)

        def block(*numbers: Scalar) -> Numbers:
            state, ahead, wanted, before, residuals, (cost, energy, worst) = cut_pieces(numbers, parts)
            now = ahead[: self.drives]
            outputs = len(self.outputs)
            found = self._go_block(xp, shape.rebuild(state), now, (wanted[:outputs], wanted[outputs : 2 * outputs]))
            state, sums, (squares, power, failed) = cut_pieces(found, (size, kinds, 3))
            changes = [((u - v) / self._range) for u, v in zip(now, before, strict=True)]
            cost = cost + (squares + self.price.change * multiply_inner(changes, changes)) / self.blocks
            share = 1.0 / math.sqrt(self.blocks)
            residuals = [*residuals[kinds:], *(share * x for x in sums)]
            wanted = [*wanted[outputs:], *wanted[:outputs]]
            energy = energy + self.price.energy * power / self.blocks
            worst = xp.maximum(worst, failed)
            return [*state, *ahead[self.drives :], *now, *wanted, *now, *residuals, cost, energy, worst]

        given = [[u + d for u, d in zip(x, cycle(self.shifts))] if self.shifts else x for x in (plan, self.signals)]
        begin = [*flatten_numbers(self.state), *given[0], *self.wanted, *given[1]]
        found = xp.repeat(self.blocks, block, *begin, *[0.0] * (kinds * self.blocks), 0.0, 0.0, 0.0)
        *_, residuals, (cost, energy, worst) = cut_pieces(found, parts)
        total = cost + energy
        total = xp.where(xp.both(total < HUGE, worst <= SOLVED), total, HUGE)
        return PlanCost(total, energy, residuals)

    def _go_block(
        self, xp: Namespace, state: Any, signals: Sequence[Scalar], wanted: tuple[Numbers, Numbers]
    ) -> Sequence[Scalar]:
        """Return the state after a block, means of errors, excesses, squares and power, and the worst report."""
        shape, size, kinds = NestedShape(state), len(flatten_numbers(state)), self._count_kinds()
        part = 1.0 / self.turns

        def step(*numbers: Scalar) -> Numbers:
            flat, means, (squares, power, worst, share) = cut_pieces(numbers, (size, kinds, 4))
            after, report = self.model.step(xp, shape.rebuild(flat), *signals, dt=self.length * part)
            seen = dict(zip(self.model.outputs(), self.model.observe(xp, after, *signals), strict=True))
            share = share + part
            ahead = [a + share * (b - a) for a, b in zip(*wanted, strict=True)]
            errors = [(y - seen[n]) / self.price.error for y, n in zip(ahead, self.outputs, strict=True)]
            errors += self._list_excesses(xp, seen)
            squares = squares + part * multiply_inner(errors, errors)
            power = power + part * sum_column([seen[name] for name in self._list_outputs("power")])
            means = [x + part * e for x, e in zip(means, errors, strict=True)]
            return [*flatten_numbers(after), *means, squares, power, xp.maximum(worst, report.residual), share]

        begin = [*flatten_numbers(state), *[0.0] * (kinds + 4)]
        found = step(*begin) if self.turns == 1 else xp.repeat(self.turns, step, *begin)
        return found[:-1]

    def _count_kinds(self) -> int:
        hot, strong = self.price.__dict__["_bounded"]
        return len(self.outputs) + hot * len(self._list_outputs("hottest")) + strong * len(self._list_outputs("stress"))

    def _list_excesses(self, xp: Namespace, seen: dict[str, Scalar]) -> Numbers:
        """Return the excesses over bounds that have a price, times the square root of the price."""
        hot, strong = self.price.__dict__["_bounded"]
        weight, found = xp.sqrt(self.price.excess), Numbers()
        bounds = ((hot, "hottest", self.price.hottest, KELVIN), (strong, "stress", self.price.strongest, MEGAPASCAL))
        for bounded, kind, bound, unit in bounds:
            if bounded:
                found += [weight * xp.maximum(seen[n] - bound, 0.0) / unit for n in self._list_outputs(kind)]
        return found

    def _list_outputs(self, kind: str) -> list[str]:
        """Return the outputs of all ports that are called so."""
        return [self.model.label(port, kind) for port in self.model.actuators()]


def _choose_plan(xp: Namespace, plans: Sequence[Numbers], costs: Sequence[Scalar]) -> Numbers:
    """Return the plan of least cost, the first of several; what a plan has of the first one is not chosen again."""
    least, chosen = costs[0], 0.0
    for k, cost in enumerate(costs[1:], 1):
        better = cost < least
        least, chosen = xp.where(better, cost, least), xp.where(better, float(k), chosen)
    best = list(plans[0])
    for k, plan in enumerate(plans[1:], 1):
        this = xp.both(chosen > k - 0.5, chosen < k + 0.5)
        best = [y if x is u else xp.where(this, x, y) for x, y, u in zip(plan, best, plans[0], strict=True)]
    return best


def cut_pieces(numbers: Sequence[Scalar], sizes: Sequence[int]) -> list[Any]:
    """Return the numbers in pieces of these sizes."""
    found, start = list[Any](), 0
    for size in sizes:
        found.append(list(numbers[start : start + size]))
        start += size
    return found


def shift_plan(plan: Sequence[Scalar], drives: int, share: Scalar) -> Numbers:
    """Return a plan as it looks a share of a block later; its last signals stay."""
    after = [*plan[drives:], *plan[-drives:]]
    return [(1.0 - share) * u + share * v for u, v in zip(plan, after, strict=True)]
