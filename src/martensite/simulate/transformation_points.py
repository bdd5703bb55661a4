"""Transformation points of a law, from simulated isobars and isothermal loading.

Only the kinetics are used, so the method applies to every law. A coarse step with a level crossing is refined three
times by a factor of ten. An isobar is one thermal cycle that starts with cooling of austenite.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import NamedTuple

from martensite.physics.laws.base import AbstractLaw, Fractions
from martensite.simulate.compiled_law import AUSTENITE, ROW, compile_law

COLDEST, HOTTEST = 100.0, 800.0
"""Limits of a thermal sweep [K]."""
STRONGEST = 3e9
"""End of a loading sweep [Pa]."""
PIECES, SMALLER, DEPTH = 70, 10, 3
HEATING, LOADING = 1.0, 10e6
"""Rates of the sweeps [K/s], [Pa/s], for rate-dependent laws."""
LEVEL = 0.01
"""Transformed fraction at the start, and remaining fraction at the end."""
MARTENSITE, ORIENTED, STRAIN = (ROW.index(n) for n in ("martensite", "oriented", "strain"))

State = tuple[float, ...]
Test = Callable[[State], bool]


class Marks(NamedTuple):
    """Start and finish temperatures at one stress [K]; NaN if missing."""

    A_s: float
    A_f: float
    M_s: float
    M_f: float


class LoadingPoint(NamedTuple):
    """Point on a loading sweep."""

    stress: float
    """[Pa]"""
    strain: float
    """[-]"""


class PlanePoint(NamedTuple):
    """Point in the plane of stress and temperature."""

    stress: float
    """[Pa]"""
    temperature: float
    """[K]"""


@dataclass(frozen=True)
class Fulfilment:
    """First fulfilment of a test, as a fraction of a sweep, and the row there."""

    share: float
    row: State


@dataclass(frozen=True)
class Explorer:
    """Law on straight lines in the plane of stress and temperature."""

    law: AbstractLaw

    @cached_property
    def _bound(self) -> tuple[Callable[..., State], Callable[..., State], int]:
        compiled = compile_law(self.law)
        functions = compiled.program.bind_floats(*compiled.values(self.law))
        return functions["init"], functions["stress_step"], compiled.size

    def start(self, fractions: Fractions, at: PlanePoint) -> State:
        """Return the memory in a phase state without history."""
        init, _, size = self._bound
        return init(*fractions, *at)[:size]

    def sweep(
        self, state: State, begin: PlanePoint, end: PlanePoint, duration: float, tests: Sequence[Test]
    ) -> tuple[list[Fulfilment | None], State]:
        """Return the first fulfilments of the tests on a sweep, and the memory at its end."""
        fulfilments: list[Fulfilment | None] = [None] * len(tests)
        for k in range(PIECES):
            shares = k / PIECES, (k + 1) / PIECES
            after, row = self._step(state, begin, end, duration, shares)
            for i, test in enumerate(tests):
                if fulfilments[i] is None and test(row):
                    fulfilments[i] = self._closer(state, begin, end, duration, shares, test, DEPTH)
            state = after
        return fulfilments, state

    def _step(
        self, state: State, begin: PlanePoint, end: PlanePoint, duration: float, shares: tuple[float, float]
    ) -> tuple[State, State]:
        _, step, size = self._bound
        x, y = (a + shares[1] * (b - a) for a, b in zip(begin, end, strict=True))
        after = step(*state, x, y, (shares[1] - shares[0]) * duration)
        return after[:size], after[size:]

    def _closer(
        self,
        state: State,
        begin: PlanePoint,
        end: PlanePoint,
        duration: float,
        shares: tuple[float, float],
        test: Test,
        depth: int,
    ) -> Fulfilment:
        """Return the refined fulfilment within a part of a sweep, by smaller steps."""
        low, high = shares
        pieces = [(low + (high - low) * k / SMALLER, low + (high - low) * (k + 1) / SMALLER) for k in range(SMALLER)]
        row: State = ()
        for piece in pieces:
            after, row = self._step(state, begin, end, duration, piece)
            if test(row) or piece is pieces[-1]:
                if depth > 1:
                    return self._closer(state, begin, end, duration, piece, test, depth - 1)
                return Fulfilment(0.5 * (piece[0] + piece[1]), row)
            state = after
        return Fulfilment(high, row)


@lru_cache(maxsize=256)
def find_isobar(law: AbstractLaw, stress: float = 0.0, level: float = LEVEL) -> Marks:
    """Find the start and finish temperatures at a constant stress [Pa] for a transformed fraction `level`."""
    explorer = Explorer(law)
    hot, cold = PlanePoint(stress, HOTTEST), PlanePoint(stress, COLDEST)
    duration = (HOTTEST - COLDEST) / HEATING

    def above(share: float) -> Test:
        return lambda row: row[MARTENSITE] >= share

    def below(share: float) -> Test:
        return lambda row: row[MARTENSITE] <= share

    state = explorer.start(AUSTENITE, hot)
    tests = above(level), above(1.0 - level)
    cooling, state = explorer.sweep(state, hot, cold, duration, tests)
    tests = below(1.0 - level), below(level)
    heating, _ = explorer.sweep(state, cold, hot, duration, tests)
    span = HOTTEST - COLDEST
    M_s, M_f = (math.nan if p is None else HOTTEST - p.share * span for p in cooling)
    A_s, A_f = (math.nan if p is None else COLDEST + p.share * span for p in heating)
    if math.isnan(M_s):  # no formed phase that could return
        A_f = math.nan
    if math.isnan(M_f):  # incomplete martensite has no start of its return
        A_s = math.nan
    return Marks(A_s, A_f, M_s, M_f)


@lru_cache(maxsize=256)
def find_loaded(
    law: AbstractLaw, temperature: float, fractions: Fractions = AUSTENITE, share: float = 1.0 - LEVEL
) -> LoadingPoint | None:
    """Find the loading point at a temperature [K] with a given fraction of oriented or formed martensite.

    None above 3 GPa. The martensite fraction is evaluated if it is initially 0, else its orientation.
    """
    explorer = Explorer(law)
    begin, end = PlanePoint(0.0, temperature), PlanePoint(STRONGEST, temperature)
    counted = ORIENTED if fractions.martensite > 0.5 else MARTENSITE
    state = explorer.start(fractions, begin)
    (fulfilment,), _ = explorer.sweep(state, begin, end, STRONGEST / LOADING, (lambda row: row[counted] >= share,))
    if fulfilment is None:
        return None
    return LoadingPoint(fulfilment.share * STRONGEST, fulfilment.row[STRAIN])
