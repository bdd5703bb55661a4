"""Noise in a followed column, such as a measured temperature, and its effect on fit and intervals.

A model that follows a measured column X = x + v also sees the noise v. The sensitivity B = ∂y/∂x of the compared
outputs is taken about estimates x̂ of the true rows. To first order, the residuals have the covariance V:

    d = f(p, x̂) + B (X - x̂) - y,    V = s² I + C Cᵀ,    C = B diag(σ)

The fit of p to V^(-1/2) d alternates with x̂ = X - σ Cᵀ V⁻¹ d until p converges. This is the Gauss-Newton method for
errors in variables (Britt and Luecke (1973), Technometrics 15; Fuller (1987), Measurement Error Models, ch. 3). On
steep rows it is a regression of the column on the output. On flat rows it is a regression of the output on the
column, so that steep loops are not flattened. With C = U δ Wᵀ

    s V^(-1/2) d = d - U (1 - s/√(s² + δ²)) Uᵀ d

keeps residuals in their units. B comes from central differences in batches, with steps of ±σ in the first rounds and
±σ/4 in the last. A record of more than 200 rows is cut into pieces, and one run moves one row of each piece. If the
model has a longer memory, blocks of rows are moved together and represent their mean.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from martensite.base.errors import SolveError
from martensite.fit.column_noise import FollowedNoise, find_input_noise
from martensite.fit.evaluation import Evaluation, InputCorrection
from martensite.fit.problem import Problem
from martensite.search.batch_runner import LANES

MOST_ROWS = 200
"""Largest number of rows that are moved separately."""
STEPS = (1.0, 1.0, 0.5)
"""Steps of the first rounds, in standard deviations of the noise, wide enough to reach beyond a kink.

Later rounds use `LAST_STEP`.
"""
LAST_STEP = 0.25
MOVES = (-3.0, -2.0, -1.2, -0.6, 0.6, 1.2, 2.0, 3.0)
"""Trial moves of single rows across a kink, in standard deviations of the noise."""
WORTHWHILE = 1.0
"""Least decrease of the sum of squares that justifies such a move."""
MOST_ROUNDS = 16
"""Largest number of linearisations."""
RESTING = 0.05
"""Change of all parameters, in standard errors, at which rounds end."""
SETTLED_NOISE = 0.03
"""Relative change of the noise of the output at which rounds end."""
SHARES = (1.0, 0.5, 0.25, 0.1, 0.03)
"""Fractions of a step, tried in order until the cost improves."""
NEGLIGIBLE = 0.1
"""Largest negligible effect of the noise, as a fraction of the noise of the output."""
EXPLAINED = 0.5
"""Least fraction of the total noise effect that pieces must explain; otherwise blocks are moved."""
Descend = Callable[[Problem, Any, Evaluation], Any]


class _FollowedRuns:
    """Runs of an experiment with changed rows in its followed columns."""

    def __init__(self, problem: Problem, k: int, noise: Sequence[FollowedNoise]) -> None:
        self.problem, self.k, self.one = problem, k, problem.experiments[k]
        self.drives = [one for one in noise if one.drive in self.one.follows]
        self.tables = [self.one.find_followed_waveform(one.drive) for one in self.drives]
        sizes = [len(table.times) for table in self.tables]
        self.ends = np.cumsum([0, *sizes])
        self.logged = np.concatenate([np.asarray(table.values, float) for table in self.tables] or [np.zeros(0)])
        self.sigma = np.repeat([one.sigma for one in self.drives], sizes)
        self.times = np.concatenate([np.asarray(table.times, float) for table in self.tables] or [np.zeros(0)])
        self.rows = self.logged.copy()
        """Estimates of the true rows."""
        self.pieces = list[tuple[Any, Any, Any]]()
        """Used residuals, rows of columns, and C between them."""
        self.blocks = False
        self.step = 1.0
        """Step of the rows, in standard deviations of their noise."""
        used = problem.training_rows[k]
        self.used_places = np.nonzero(used.T)
        """Output and row of every used residual."""
        self.at = self.one.times[self.used_places[1]] + self.one.lead
        self.sizes = problem.residual_sizes(k)[self.used_places[0]]
        self.measured = self.one.measured[self.used_places[1], self.used_places[0]] * self.sizes

    def inputs(self, rows: Any) -> dict[str, Any]:
        """Return the rows of all columns by drive."""
        return {one.drive: rows[a:b] for one, a, b in zip(self.drives, self.ends, self.ends[1:], strict=False)}

    def run(self, u: Any, variants: Any) -> Any:
        """Return the compared outputs (variants, used residuals), in units of residuals; NaN for a failed run."""
        runner, values = self.problem.runners[self.k], self.problem.change_values(self.k, u)
        answers = list[Any]()
        for k in range(0, len(variants), LANES):
            some = variants[k : k + LANES]
            padded = np.concatenate([some, np.repeat(some[-1:], LANES - len(some), axis=0)])
            answers.append(
                runner.run_driven(
                    values, self.one.driven_grid([self.inputs(row) for row in padded], self.problem.step)
                )[: len(some)]
            )
        outputs = np.concatenate(answers)
        delayed = [self.problem.shift_model(self.k, one, u, None)[0] for one in outputs]
        return np.stack(delayed)[:, self.used_places[1], self.used_places[0]] * self.sizes

    def linearise(self, u: Any, seed: int = 0) -> None:
        """Compute C about the estimated rows."""
        count = len(self.rows)
        if not self.blocks and count <= MOST_ROWS:
            groups = [np.array([k]) for k in range(count)]
            self.pieces = [(np.arange(len(self.at)), np.arange(count), self._move(u, groups, self.sigma).T)]
        elif not self.blocks:
            self._linearise_pieces(u)
            moved = np.random.default_rng(seed).standard_normal(count)
            base, shaken = self.run(u, np.stack([self.rows, self.rows + self.sigma * moved]))
            prediction = np.zeros(len(self.at))
            for samples, rows, part in self.pieces:
                prediction[samples] += part @ moved[rows]
            if np.sum((shaken - base - prediction) ** 2) > EXPLAINED * np.sum((shaken - base) ** 2):
                self.blocks = True
                self.linearise(u)
        else:
            groups = [g for a, b in zip(self.ends, self.ends[1:], strict=False) for g in _cut_blocks(a, b)]
            mean = np.array([self.sigma[g[0]] / math.sqrt(len(g)) for g in groups])
            self.pieces = [(np.arange(len(self.at)), np.array([g[0] for g in groups]), self._move(u, groups, mean).T)]

    def _linearise_pieces(self, u: Any) -> None:
        """Compute pieces of one column, moving the same row of every piece in one run."""
        self.pieces = []
        for a, b in zip(self.ends, self.ends[1:], strict=False):
            groups = [np.arange(a + k, b, MOST_ROWS) for k in range(min(MOST_ROWS, b - a))]
            moved = self._move(u, groups, self.sigma[[g[0] for g in groups]])
            for begin in range(a, b, MOST_ROWS):
                rows = np.arange(begin, min(begin + MOST_ROWS, b))
                until = self.times[rows[-1] + 1] if rows[-1] + 1 < b else math.inf
                samples = np.flatnonzero((self.at >= self.times[rows[0]]) & (self.at < until))
                part = moved[: len(rows), samples].T.copy()
                part[self.at[samples][:, None] < self.times[rows][None, :]] = 0.0
                self.pieces.append((samples, rows, part))

    def _move(self, u: Any, groups: Sequence[Any], by: Any) -> Any:
        """Return half the difference of runs with groups of rows moved up and down, (groups, used residuals)."""
        moves = np.zeros((len(groups), len(self.rows)))
        for k, (rows, amount) in enumerate(zip(groups, by, strict=True)):
            moves[k, rows] = self.step * amount
        outputs = self.run(u, np.concatenate([self.rows + moves, self.rows - moves]))
        half = 0.5 / self.step * (outputs[: len(groups)] - outputs[len(groups) :])
        return np.where(np.isfinite(half), half, 0.0)

    def shift(self) -> Any:
        """Compute C/σ (X - x̂), (used residuals,)."""
        shift = np.zeros(len(self.at))
        if not self.blocks:
            for samples, rows, part in self.pieces:
                shift[samples] += part @ ((self.logged - self.rows)[rows] / self.sigma[rows])
        return shift

    def correct(self, noise: float) -> InputCorrection:
        """Return the correction of the experiment for noise s of its residuals."""
        parts = list[tuple[Any, Any, Any]]()
        for samples, _, part in self._merge_pieces():
            left, sizes, _ = np.linalg.svd(part, full_matrices=False)
            parts.append((samples, left, 1.0 - noise / np.hypot(noise, sizes)))
        return InputCorrection(self.inputs(self.rows), self.shift(), tuple(parts))

    def _merge_pieces(self) -> list[tuple[Any, Any, Any]]:
        """Merge the pieces of several columns over the same residuals."""
        joined: dict[bytes, tuple[Any, list[Any], list[Any]]] = {}
        for samples, rows, part in self.pieces:
            _, places, parts = joined.setdefault(samples.tobytes(), (samples, [], []))
            places.append(rows)
            parts.append(part)
        return [(s, np.concatenate(places), np.concatenate(parts, axis=1)) for s, places, parts in joined.values()]

    def spectrum(self, residuals: Any) -> tuple[Any, Any, float]:
        """Return the variances δ² along directions, squared residuals along them, and the squares of the remainder."""
        sizes, along = list[Any](), list[Any]()
        for samples, _, part in self._merge_pieces():
            left, singular_values, _ = np.linalg.svd(part, full_matrices=False)
            sizes.append(singular_values**2)
            along.append((left.T @ residuals[samples]) ** 2)
        squares, total = np.concatenate(along), float(residuals @ residuals)
        return np.concatenate(sizes), squares, max(total - float(squares.sum()), 0.0)

    def estimate_rows(self, correction: InputCorrection, whitened: Any, noise: float) -> Any:
        """Compute x̂ = X - σ Cᵀ V⁻¹ d from whitened residuals."""
        rows = self.logged.copy()
        if not self.blocks:
            twice = correction.whiten(whitened) / noise**2
            for samples, places, part in self.pieces:
                rows[places] -= self.sigma[places] * (part.T @ twice[samples])
        return rows

    def search_rows(self, u: Any, noise: float) -> float:
        """Move single rows if this lowers the sum of squares noticeably, and return the decrease.

        The derivative of a row on the wrong side of a kink does not lead back.
        """
        count = len(self.rows)
        if self.blocks or count > MOST_ROWS:
            return 0.0
        moves = np.concatenate([np.diag(share * self.sigma) for share in MOVES])
        outputs = self.run(u, np.concatenate([self.rows[None], self.rows + moves]))
        squares = np.sum((outputs - self.measured) ** 2, axis=1) / noise**2
        apart = (self.logged - self.rows) / self.sigma
        shares = np.asarray(MOVES)[:, None]
        costs = np.reshape(squares[1:] - squares[0], (len(MOVES), count)) + (apart - shares) ** 2 - apart**2
        costs = np.where(np.isfinite(costs), costs, math.inf)
        best = np.argmin(costs, axis=0)
        gains = -costs[best, np.arange(count)]
        for chosen in (np.flatnonzero(gains > WORTHWHILE), np.array([np.argmax(gains)])):
            if not np.any(gains[chosen] > WORTHWHILE):
                return 0.0
            trial = self.rows.copy()
            trial[chosen] += np.asarray(MOVES)[best[chosen]] * self.sigma[chosen]
            trial_squares = np.sum((self.run(u, trial[None])[0] - self.measured) ** 2) / noise**2
            fallen = squares[0] + self.misfit(self.rows) - trial_squares - self.misfit(trial)
            if fallen > WORTHWHILE:
                self.rows = trial
                return float(fallen)
        return 0.0

    def misfit(self, rows: Any) -> float:
        """Return the deviation of rows from the logged rows, Σ (X - x̂)²/σ²."""
        return float(np.sum(((self.logged - rows) / self.sigma) ** 2))


def _cut_blocks(first: int, last: int) -> list[Any]:
    return [piece for piece in np.array_split(np.arange(first, last), MOST_ROWS) if len(piece)]


def correct_for_inputs(
    problem: Problem, u: Any, descend: Descend
) -> tuple[Problem, Any, list[FollowedNoise], list[str]]:
    """Return the problem with the noise of its drives, its optimum, the relevant noise, and remarks.

    Args:
        problem: problem with the fitted records.
        u: optimum without this noise.
        descend: local search of a problem from a point.

    Raises:
        SolveError: a run with the estimated drive rows fails.
    """
    noise, notes = find_input_noise(problem)
    if not noise:
        return problem, u, [], notes
    plain = _require_run(problem, u)
    runs = [_FollowedRuns(problem, k, noise) for k in range(len(problem.experiments))]
    size = _estimate_output_noise(problem, plain.residuals)
    if not size > 0.0 or not _is_felt(runs, u, size):
        return problem, u, [], notes
    return *_iterate(problem, runs, u, descend), noise, notes


def _estimate_output_noise(problem: Problem, residuals: Any) -> float:
    if problem.knows_noise:
        return 1.0
    return math.sqrt(float(residuals @ residuals) / max(len(residuals) - len(problem.free), 1))


def _is_felt(runs: Sequence[_FollowedRuns], u: Any, size: float) -> bool:
    """Return whether noise in the columns moves anything that is compared by more than a tenth of its noise."""
    chance = np.random.default_rng(0)
    for one in runs:
        shaken = one.rows + one.sigma * chance.standard_normal((4, len(one.rows)))
        outputs = one.run(u, np.concatenate([one.rows[None], shaken]))
        if np.nanmax(np.abs(outputs[1:] - outputs[0]), initial=0.0) > NEGLIGIBLE * size:
            return True
    return False


def _iterate(problem: Problem, runs: Sequence[_FollowedRuns], u: Any, descend: Descend) -> tuple[Problem, Any]:
    """Linearise, fit and estimate the rows of the drives until the parameters rest."""
    u, noise = np.asarray(u, float), math.inf
    current, end = problem, u
    for count in range(MOST_ROUNDS):
        step = STEPS[count] if count < len(STEPS) else LAST_STEP
        before, current = noise, _linearise(problem, runs, u, step)
        noise = _balance_noise(problem, runs, current.split(_require_run(current, u).residuals))
        current = problem.with_corrections([one.correct(noise) for one in runs])
        end = np.asarray(descend(current, u, _require_run(current, u)))
        after = _require_run(current, end)
        if count == MOST_ROUNDS - 1:
            break
        settled = abs(noise - before) <= SETTLED_NOISE * noise and _is_resting(after, end - u, noise)
        if settled and step == LAST_STEP:
            if not _search_rows(runs, end, noise):
                break
            u = end
            continue
        parts = zip(runs, current.split(after.residuals), current.corrections, strict=True)
        old_point, wanted = u, [one.estimate_rows(fix, part, noise) for one, part, fix in parts]
        u = _step_towards(problem, runs, u, end, wanted, noise)
        if u is old_point and step == LAST_STEP and not _search_rows(runs, u, noise):
            break  # no step helps any more
    return current, end


def _linearise(problem: Problem, runs: Sequence[_FollowedRuns], u: Any, step: float) -> Problem:
    """Return the problem with the shift of all runs at a point, without whitening."""
    for one in runs:
        one.step = step
        one.linearise(u)
    return problem.with_corrections([InputCorrection(one.inputs(one.rows), one.shift(), ()) for one in runs])


def _is_resting(after: Evaluation, moved: Any, noise: float) -> bool:
    """Return whether the parameters moved by a small part of their standard errors."""
    errors = noise * np.sqrt(np.diag(np.linalg.pinv(after.jacobian.T @ after.jacobian)))
    return bool(np.all(np.abs(moved) <= RESTING * errors))


def _search_rows(runs: Sequence[_FollowedRuns], u: Any, noise: float) -> float:
    """Move single rows of all runs; return by how much the sum of squares falls."""
    return sum(one.search_rows(u, noise) for one in runs)


def _require_run(problem: Problem, u: Any) -> Evaluation:
    evaluation = problem.evaluate(u, slopes=True)
    if evaluation is None:
        raise SolveError("The runs fail with the estimated inputs.")
    return evaluation


def _step_towards(
    problem: Problem, runs: Sequence[_FollowedRuns], u: Any, end: Any, wanted: Sequence[Any], noise: float
) -> Any:
    """Step parameters and rows as far as the sum of all squares falls, and return the parameters."""
    old_rows = [one.rows for one in runs]
    least = _sum_squares(problem, runs, u, old_rows, noise)
    for share in SHARES:
        point = u + share * (end - u)
        rows = [a + share * (b - a) for a, b in zip(old_rows, wanted, strict=True)]
        if _sum_squares(problem, runs, point, rows, noise) < least:
            break
    else:
        return u
    for one, new_rows in zip(runs, rows, strict=True):
        one.rows = new_rows
    return point


def _sum_squares(problem: Problem, runs: Sequence[_FollowedRuns], u: Any, rows: Sequence[Any], noise: float) -> float:
    """Return the squares of outputs and of drives, each divided by its noise."""
    fixes = (InputCorrection(one.inputs(x), np.zeros(len(one.at)), ()) for one, x in zip(runs, rows, strict=True))
    evaluation = problem.with_corrections(list(fixes)).evaluate(u)
    if evaluation is None:
        return math.inf
    apart = sum(one.misfit(x) for one, x in zip(runs, rows, strict=True))
    return float(evaluation.residuals @ evaluation.residuals) / noise**2 + apart


def _balance_noise(problem: Problem, runs: Sequence[_FollowedRuns], residuals: Sequence[Any]) -> float:
    """Return the noise s of the output with which Σ dᵀ V⁻¹ d = n - p; 1 where it is declared."""
    total = np.concatenate(residuals)
    spare = max(len(total) - len(problem.free), 1)
    if problem.knows_noise:
        return 1.0
    spectra = [one.spectrum(part) for one, part in zip(runs, residuals, strict=True)]
    sizes, along = (np.concatenate([row[k] for row in spectra]) for k in (0, 1))
    rest, high = sum(row[2] for row in spectra), math.sqrt(float(total @ total) / spare)
    low = 1e-3 * high
    for _ in range(50):
        middle = math.sqrt(low * high)
        if np.sum(along / (middle**2 + sizes)) + rest / middle**2 > spare:
            low = middle
        else:
            high = middle
    return high
