"""Plans of a predictive controller: what they cost, and how a good one is searched.

A plan is a signal that is constant over each of some equal blocks of the horizon. Its cost is a
mean over the horizon H,

    J = 1/H ∫ ((r - y)/e)² + p P + w ((T - T_max)₊/1 K)² + w ((σ - σ_max)₊/1 MPa)² dt
        + c/N Σ ((u_j - u_j-1)/(u_high - u_low))²

with the reference r, known beforehand, what the model says of it y, the error e that costs 1, the power P and its price
p, the price w of an excess, and the price c of changes between the N blocks; u_0 is the signal now.

Search: many plans are simulated side by side, in rounds. First come plans that reach far, which is what a dead band
needs (all signals that stay, all that are full or none for a while and then as planned before), and plans drawn around
the one before; then the best eighth of all decides around what, and how far around it, the next ones are drawn: the
cross-entropy method, whose numbers are drawn with a correlation from block to block.

Source of the method: de Boer, Kroese, Mannor and Rubinstein (2005).
"""

import math
from collections.abc import Sequence
from functools import cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from martensite.actuators.assembly import AbstractSystem
from martensite.base.errors import ParameterError
from martensite.base.parameters import Parametrised, param, part
from martensite.base.units import DIFFERENCE
from martensite.simulate.api import longest_step
from martensite.simulate.lanes import Lanes, Numbers
from martensite.simulate.march import SOLVED

KELVIN, MEGAPASCAL = 1.0, 1e6
ELITE = 8
"""Of so many plans, one decides on the next round."""
LEAST = 0.01
"""Least standard deviation of plans, as a share of the range of signals."""
LEVELS = 9
"""Signals that stay, among the first plans."""
KEPT = (0.0, 0.5, 0.8, 0.95)
"""Correlations from block to block of the plans that are drawn."""
WHILES = (1, 2, 4, 8)
"""Blocks for which the signal is full or none, among the first plans."""
LEAST_PLANS = 1 + LEVELS + 2 * len(WHILES)
"""Plans that are always among the first ones."""


class Price(Parametrised):
    """What a plan is charged for."""

    error: float = param(DIFFERENCE, "error that costs 1", above=0.0, default=1e-4)
    energy: float = param("1/W", "price of electrical power", low=0.0, default=0.0)
    change: float = param("1", "price of changes of the signal", low=0.0, default=0.01)
    hottest: float = param("K", "temperature that costs nothing yet", default=math.inf)
    strongest: float = param("Pa", "stress that costs nothing yet", default=math.inf)
    excess: float = param("1", "price of 1 K or 1 MPa more than that", low=0.0, default=1000.0)


class PlanSearch(Parametrised):
    """How plans are searched."""

    plans: int = part("plans in a round", default=64)
    rounds: int = part("rounds in a period", default=4)
    spread: float = param(
        "1",
        "standard deviation of the first plans, as a share of the range of signals",
        above=0.0,
        high=1.0,
        default=0.25,
    )
    seed: int = part("of the random numbers; the same one gives the same signals", default=0)

    def check(self) -> None:
        """Raise `ParameterError` where nothing could be searched."""
        for name, least in (("plans", LEAST_PLANS), ("rounds", 1), ("seed", 0)):
            value = self.__dict__[name]
            if not isinstance(value, int) or value < least:
                raise ParameterError(
                    f"`{name}` of a search must be a whole number, at least {least}, but is {value!r}."
                )


class Moment(NamedTuple):
    """What plans start from."""

    state: Numbers
    """Of the model, shape (states, 1)."""
    signal: float
    """That of the last period."""
    wanted: Numbers
    """Reference less what the model is known to lack, after every step of the horizon."""


class Planner:
    """Plans of one controller, side by side in lanes of its model."""

    def __init__(
        self, lanes: Lanes, output: str, price: Price, search: PlanSearch, limits: tuple[float, float]
    ) -> None:
        self.lanes, self.price, self.search, self.limits = lanes, price, search, limits
        self.range = limits[1] - limits[0]
        names = lanes.names
        self.followed_output = names.index(output)
        self.powers, self.temperatures, self.stresses = (
            [i for i, name in enumerate(names) if name.rpartition(".")[2] == kind]
            for kind in ("power", "hottest", "stress")
        )

    def best(self, moment: Moment, guess: Numbers, dt: float, rng: np.random.Generator) -> tuple[Numbers, float]:
        """The best plan, shape (blocks,), and its cost, from the last one, moved on; `dt` [s] is that of the model."""
        spread = np.full(len(guess), self.search.spread * self.range)
        plans = self._full([self._far(guess), self._sample_plans(guess, spread, rng)])
        best, least = guess, math.inf
        for k in range(self.search.rounds):
            costs = self.costs(moment, plans, dt)
            order = np.argsort(costs, kind="stable")
            if costs[order[0]] < least:
                best, least = plans[:, order[0]], float(costs[order[0]])
            if k + 1 < self.search.rounds:
                elite = plans[:, order[: max(2, self.search.plans // ELITE)]]
                centre = elite.mean(axis=1)
                spread = np.maximum(elite.std(axis=1), LEAST * self.range)
                known = np.array([best, centre]).T
                plans = self._full([known, self._sample_plans(best, spread, rng)])
        return best, least

    def costs(self, moment: Moment, plans: Numbers, dt: float) -> Numbers:
        """What plans of shape (blocks, plans) cost; infinite where the model fails."""
        turns = len(moment.wanted) // len(plans)
        self.lanes.state = np.repeat(moment.state, self.lanes.lanes, axis=1)
        self.lanes.worst[:] = 0.0
        with np.errstate(all="ignore"):
            rows = self.lanes.advance(np.repeat(plans, turns, axis=0)[:, None, :], dt)
            error = (moment.wanted[:, None] - rows[:, self.followed_output]) / self.price.error
            found = np.mean(error * error, axis=0) + self._charge_plan(rows)
        before = np.vstack([np.full((1, plans.shape[1]), moment.signal), plans[:-1]])
        changes = (plans - before) / self.range
        found += self.price.change * np.mean(changes * changes, axis=0)
        solved = np.isfinite(found) & (self.lanes.worst[0] <= SOLVED)
        return np.where(solved, found, np.inf)

    def _charge_plan(self, rows: Numbers) -> Numbers:
        """Power and excess, mean over the horizon."""
        price, found = self.price, np.zeros(rows.shape[2])
        if price.energy > 0.0:
            found += price.energy * _average_rows(rows, self.powers)
        bounds = ((price.hottest, KELVIN, self.temperatures), (price.strongest, MEGAPASCAL, self.stresses))
        for bound, unit, which in bounds:
            if math.isfinite(bound):
                over = np.maximum(rows[:, which] - bound, 0.0) / unit
                found += price.excess * _average_rows(over * over)
        return found

    def _full(self, kinds: Sequence[Numbers]) -> Numbers:
        """As many plans as there are lanes, the first kinds first, the rest evenly."""
        known, drawn = kinds
        room = self.search.plans - known.shape[1]
        which = np.linspace(0, drawn.shape[1] - 1, room).astype(int)
        return np.hstack([known, drawn[:, which]])

    def _far(self, guess: Numbers) -> Numbers:
        """Plans that reach far, the guess first, shape (blocks, plans)."""
        low, high = self.limits
        stays = [np.full_like(guess, level) for level in np.linspace(low, high, LEVELS)]
        bursts = [np.where(np.arange(len(guess)) < blocks, level, guess) for blocks in WHILES for level in (low, high)]
        return np.column_stack([guess, *stays, *bursts])

    def _sample_plans(self, centre: Numbers, spread: Numbers, rng: np.random.Generator) -> Numbers:
        """Plans around one, within the limits, shape (blocks, plans)."""
        each = -(-self.search.plans // len(KEPT))
        numbers = rng.standard_normal((len(KEPT), len(centre), each))
        drawn = np.hstack(list(_build_filters(len(centre)) @ numbers))
        return np.clip(centre[:, None] + spread[:, None] * drawn, *self.limits)


@cache
def _build_filters(blocks: int) -> Numbers:
    """What makes numbers correlated from block to block, shape (kinds, blocks, blocks)."""
    apart = np.subtract.outer(np.arange(blocks), np.arange(blocks))
    found = []
    for kept in KEPT:
        powers = np.where(apart >= 0, kept ** np.maximum(apart, 0.0), 0.0)
        powers[:, 1:] *= math.sqrt(1.0 - kept * kept)
        found.append(powers)
    return np.array(found)


def _average_rows(rows: Numbers, which: Sequence[int] = ()) -> Numbers:
    chosen = rows[:, which] if which else rows
    return np.mean(np.sum(chosen, axis=1), axis=0)


def shift_plan(plan: Numbers, share: float) -> Numbers:
    """A plan as it looks a share of a block later; its last signal stays."""
    while share > 1.0:
        plan, share = np.append(plan[1:], plan[-1]), share - 1.0
    return (1.0 - share) * plan + share * np.append(plan[1:], plan[-1])


FIRST, DOUBLINGS = 64, 8
"""Steps of the first look, and how often it is made twice as long."""
BEGUN, HALF, MOST, SETTLED = 0.1, 0.5, 0.9, 0.01


class TimeScales(NamedTuple):
    """Times of a system [s]."""

    start: float
    """Until full signal, from rest, has made a tenth of the travel."""
    up: float
    """Until it has made half of it."""
    down: float
    """From nine tenths of it, until no signal has left half."""


def measure_reach(system: AbstractSystem, output: str, low: float, high: float) -> TimeScales:
    """How long full signal and none need.

    Args:
        system: a system with one drive.
        output: what shall move.
        low: least signal.
        high: largest signal.

    Raises:
        ParameterError: full signal does not move the output.
    """
    dt = 0.5 * longest_step(system)
    lanes = Lanes(system, 1)
    lanes.reset(low)
    index = lanes.names.index(output)
    rest = float(lanes.observe(low)[index, 0])
    up = _settle_output(lanes, high, dt, index, rest)
    top = float(up[-1])
    if not np.isfinite(top) or abs(top - rest) <= 1e-12 * max(abs(rest), 1e-9):
        raise ParameterError(f"The signal {high:g} does not move `{output}` of the model.")
    share = (up - rest) / (top - rest)
    lanes.reset(low)
    lanes.advance(np.full((_count_until(share >= MOST), 1, 1), high), dt)
    down = (_settle_output(lanes, low, dt, index, top) - rest) / (top - rest)
    return TimeScales(
        dt * _count_until(share >= BEGUN), dt * _count_until(share >= HALF), dt * _count_until(down <= HALF)
    )


def _settle_output(lanes: Lanes, signal: float, dt: float, index: int, before: float) -> Numbers:
    """An output under one signal until it hardly changes."""
    found = np.array([before])
    steps = FIRST
    for _ in range(DOUBLINGS):
        more = lanes.advance(np.full((steps, 1, 1), signal), dt)[:, index, 0]
        found = np.concatenate([found, more])
        steps = len(found)
        change = abs(more[-1] - more[0])
        if change <= SETTLED * np.ptp(found) and np.ptp(found) > 0.0:
            break
    return found[1:]


def _count_until(flags: NDArray[np.bool_]) -> int:
    """After how many steps flags are up for the first time; all of them, if never."""
    return 1 + int(np.argmax(flags)) if np.any(flags) else len(flags)
