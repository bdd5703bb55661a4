"""Sums of squared residuals of a chain over records, in bounded memory.

    V = Σ_records Σ_t w² |L(q) (y - ŷ)|² + ρ N |θ - θ_ref|²

Missing and skipped samples do not count. L(q) = 1 is the simulation error; a monic filter L makes it the prediction
error under coloured noise v = e/L.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from threading import Event
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from martensite.base.errors import ParameterError
from martensite.identify.blocks.base import Numbers
from martensite.identify.chains.engine import ChainEngine, ChainStart
from martensite.search.levenberg_marquardt import CostMinimum, Normal, minimise_cost
from martensite.signals.sampling.sampled import Sampled

STARTS = ("rest", "zero", "estimate")
PIECE = 32_256
"""Samples per simulation, between tests for a halt."""


@dataclass(frozen=True, eq=False)
class RecordResidual:
    """A record and the weights of its residuals."""

    record: Sampled
    skip: int = 0
    """Samples at the start that do not count."""
    weights: Numbers | None = None
    """Weights of the outputs, 1/σ; default: 1 over the standard deviation of each output."""
    start: str = "rest"
    """State at the first sample: rest, zero, or estimate."""
    whitening: Numbers = field(default_factory=lambda: np.ones(1))
    """Coefficients 1, l_1, … of L(q)."""

    def __post_init__(self) -> None:
        if self.start not in STARTS:
            raise ParameterError(
                f"The state at the start is {', '.join(STARTS[:-1])} or {STARTS[-1]}, not `{self.start}`."
            )

    def scale(self) -> Numbers:
        """Return the weights of the outputs."""
        return self._scale

    @cached_property
    def _scale(self) -> Numbers:
        if self.weights is not None:
            return np.asarray(self.weights, dtype=float)
        spread = np.nanstd(self.record.outputs, axis=0)
        return 1.0 / np.where(spread > 0.0, spread, 1.0)

    def counted_outputs(self) -> int:
        """Return the number of counted outputs."""
        return int(np.isfinite(self.record.outputs[self.skip :]).sum())


class Part(NamedTuple):
    """Weighted residuals of some samples, with derivatives by θ."""

    rows: slice
    residuals: Numbers
    """Shape (samples, outputs); 0 where not counted."""
    slopes: Numbers
    """Derivatives of ŷ, shape (samples, outputs, columns)."""


Memory = tuple[Numbers, Numbers]
"""Memory of the filter: residuals and slopes."""


class HaltedSearchError(Exception):
    """A search was halted from another thread."""


class ResidualSquares:
    """Sum of squares of a chain over records, for `levenberg_marquardt.minimise_cost`.

    The numbers are θ of the chain, then the estimated initial states as deviations from the steady state.
    """

    def __init__(
        self,
        engine: ChainEngine,
        aims: Sequence[RecordResidual],
        ridge: float = 0.0,
        reference: Numbers | None = None,
        priors: Numbers | None = None,
        halt: Event | None = None,
    ) -> None:
        """Take a chain, records, the pull ρ per sample towards θ_ref, and 1/σ of priors around it.

        If `halt` is set, computing ends with `HaltedSearchError`.
        """
        self.engine, self.aims, self._halt = engine, tuple(aims), halt or Event()
        self.columns, self.states = engine.plan.columns, engine.plan.states
        self.count = sum(aim.counted_outputs() for aim in self.aims)
        self.reference = np.zeros(self.columns) if reference is None else reference
        pull = np.full(self.columns, ridge * self.count)
        self.pull = pull if priors is None else pull + priors**2

    @property
    def size(self) -> int:
        """Return the number of all numbers, including initial states."""
        return self.columns + self.states * sum(aim.start == "estimate" for aim in self.aims)

    def extend_parameters(self, theta: Numbers) -> Numbers:
        """Return θ of the chain with steady initial states."""
        return np.concatenate([theta, np.zeros(self.size - len(theta))])

    def value(self, theta: Numbers) -> float:
        """Return the sum of squares; infinite for a run that is not finite."""
        total = float(self.pull @ (theta[: self.columns] - self.reference) ** 2)
        with np.errstate(all="ignore"):
            for aim, place in self._place_states():
                start = self._start(aim, theta, place, slopes=False)
                y = self._simulate(theta[: self.columns], aim.record.inputs, start.state.copy())
                total += float(np.sum(_filter_residuals(aim, _weigh_residuals(aim, y, slice(None))) ** 2))
        return total if np.isfinite(total) else np.inf

    def _simulate(self, theta: Numbers, u: Numbers, state: Numbers) -> Numbers:
        """Return the outputs in pieces, so that a search can be halted."""
        pieces = [np.empty((0, len(self.engine.taps)))]
        for first in range(0, len(u), PIECE):
            self._check_halt()
            pieces.append(self.engine.simulate(theta, u[first : first + PIECE], state))
        return np.concatenate(pieces)

    def _check_halt(self) -> None:
        if self._halt.is_set():
            raise HaltedSearchError

    def normal(self, theta: Numbers) -> Normal:
        """Return the sum of squares with gradient and JᵀJ; infinite for a run that is not finite."""
        with np.errstate(all="ignore"):
            return self._normal(theta)

    def _normal(self, theta: Numbers) -> Normal:
        away = theta[: self.columns] - self.reference
        value = float(self.pull @ away**2)
        gradient, hessian = np.zeros(self.size), np.zeros((self.size, self.size))
        gradient[: self.columns] += self.pull * away
        hessian[range(self.columns), range(self.columns)] += self.pull
        for aim, place in self._place_states():
            where = self._where(place)
            record_gradient, square = np.zeros(len(where)), np.zeros((len(where), len(where)))
            for part in self._parts(aim, theta, place, reuse=True):
                value += float(np.vdot(part.residuals, part.residuals))
                for k, weight in enumerate(aim.scale()):
                    rows = part.slopes[:, k]
                    record_gradient -= weight * (rows.T @ part.residuals[:, k])
                    square += weight**2 * (rows.T @ rows)
            gradient[where] += record_gradient
            hessian[np.ix_(where, where)] += square
        return Normal(value if np.isfinite(value) else np.inf, gradient, hessian)

    def parts(self, theta: Numbers) -> Iterator[tuple[int, Part]]:
        """Yield the number of the record and its weighted residuals with derivatives, in pieces."""
        theta = self.extend_parameters(theta) if len(theta) == self.columns else theta
        for number, (aim, place) in enumerate(self._place_states()):
            for part in self._parts(aim, theta, place):
                extra = part.slopes.shape[2] - self.columns
                slopes = part.slopes[:, :, extra:] * aim.scale()[:, None]
                yield number, part._replace(slopes=slopes)

    def initial(self, theta: Numbers) -> list[Numbers]:
        """Return the state at the first sample of every record."""
        return [self._start(aim, theta, place, False).state for aim, place in self._place_states()]

    def _place_states(self) -> Iterator[tuple[RecordResidual, int | None]]:
        """Yield the records with the place of their initial states among the numbers."""
        place = self.columns
        for aim in self.aims:
            estimated = aim.start == "estimate"
            yield aim, place if estimated else None
            place += self.states * estimated

    def _where(self, place: int | None) -> Numbers:
        """Return the numbers that a record depends on, in the order of its columns."""
        theta = np.arange(self.columns)
        if place is None:
            return theta
        return np.concatenate([np.arange(place, place + self.states), theta])

    def _start(self, aim: RecordResidual, theta: Numbers, place: int | None, slopes: bool) -> ChainStart:
        own, first = theta[: self.columns], aim.record.inputs[0]
        if aim.start == "zero":
            return ChainStart(np.zeros(self.states), np.zeros((self.states, self.columns)))
        away = None if place is None else theta[place : place + self.states]
        start = self.engine.rest(own, first, away)
        return start if slopes or place is None else start._replace(slopes=start.slopes[:, :0])

    def _parts(self, aim: RecordResidual, theta: Numbers, place: int | None, reuse: bool = False) -> Iterator[Part]:
        """Yield weighted residuals and unweighted slopes; with `reuse` overwritten by the next."""
        start = self._start(aim, theta, place, slopes=True)
        memory: Memory | None = None
        own, inputs = theta[: self.columns], aim.record.inputs
        for chunk in self.engine.sensitivities(own, inputs, start, reuse=reuse):
            self._check_halt()
            residuals, slopes = _weigh_residuals(aim, chunk.outputs, chunk.rows), chunk.slopes
            counts = _find_counted(aim, chunk.rows)
            if not counts.all():
                slopes[~counts] = 0.0
            if len(aim.whitening) > 1:
                residuals, slopes, memory = _whiten_piece(aim.whitening, residuals, slopes, memory)
            yield Part(chunk.rows, residuals, slopes)


def settle_states(squares: ResidualSquares, theta: Numbers, steps: int) -> CostMinimum:
    """Return the best initial states for fixed θ of the chain."""
    theta = squares.extend_parameters(theta)
    return minimise_cost(squares, theta, steps, free=np.arange(squares.size) >= squares.columns)


def _weigh_residuals(aim: RecordResidual, y: Numbers, rows: slice) -> Numbers:
    return np.where(_find_counted(aim, rows), (aim.record.outputs[rows] - y) * aim.scale(), 0.0)


def _find_counted(aim: RecordResidual, rows: slice) -> NDArray[np.bool_]:
    """Return which outputs of some samples count."""
    counts = np.isfinite(aim.record.outputs[rows])
    counts[: max(aim.skip - (rows.start or 0), 0)] = False
    return counts


def _filter_residuals(aim: RecordResidual, residuals: Numbers) -> Numbers:
    if len(aim.whitening) == 1:
        return residuals
    from scipy.signal import lfilter  # its import takes a second

    return np.asarray(lfilter(aim.whitening, [1.0], residuals, axis=0))


def _whiten_piece(
    whitening: Numbers, residuals: Numbers, slopes: Numbers, memory: Memory | None
) -> tuple[Numbers, Numbers, Memory]:
    """Return residuals and slopes through L(q), continued from the samples before."""
    from scipy.signal import lfilter

    order = len(whitening) - 1
    if memory is None:
        memory = np.zeros((order, *residuals.shape[1:])), np.zeros((order, *slopes.shape[1:]))
    residuals, first = lfilter(whitening, [1.0], residuals, axis=0, zi=memory[0])
    slopes, second = lfilter(whitening, [1.0], slopes, axis=0, zi=memory[1])
    return residuals, slopes, (first, second)
