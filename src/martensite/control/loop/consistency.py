"""Consistency test of a filter: many runs of a bench with different noise.

    e = x - x̂,    NEES = eᵀ P⁻¹ e,    x = (T, ξ) of every port

For a consistent filter, N times the mean over N runs is chi-square distributed with N n degrees of freedom; for the NIS
n is the number of readings. The noise must be the noise of the filter model: a plant with the same random walk is a
`ProcessNoisePlant`.

Source: Bar-Shalom, Li and Kirubarajan (2001), section 5.4.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from martensite.base.errors import InputError, suggest_name
from martensite.control.loop.bench import Bench
from martensite.control.loop.run import simulate_bench
from martensite.control.observers import hidden_states
from martensite.control.observers.base import ESTIMATED
from martensite.control.observers.filter import CORRELATION, AbstractFilter
from martensite.signals.base import AbstractWaveform
from martensite.simulate.result import Result

Numbers = NDArray[Any]
CERTAIN = 1e-9
"""Least standard deviation."""


@dataclass(frozen=True)
class Consistency:
    """Normalised errors of a filter in many runs."""

    times: Numbers
    """[s]"""
    nees: Numbers
    """(samples, runs)"""
    nis: Numbers
    """(samples, runs)"""
    degrees: int
    """Degrees of freedom of the NEES: number of hidden values."""
    readings: int
    error: dict[str, Numbers]
    """Estimate less truth by name, (samples, runs)."""

    @property
    def runs(self) -> int:
        """Return the number of runs."""
        return self.nees.shape[1]

    def band(self, probability: float = 0.95) -> tuple[float, float]:
        """Return the band that contains the mean NEES of a sample over the runs with a probability."""
        from scipy.stats import chi2

        ends = chi2.ppf([0.5 - 0.5 * probability, 0.5 + 0.5 * probability], self.degrees * self.runs) / self.runs
        return float(ends[0]), float(ends[1])

    def inside(self, probability: float = 0.95) -> float:
        """Return the fraction of samples whose mean NEES is in its band; `probability` for a consistent filter."""
        low, high = self.band(probability)
        mean = self.nees.mean(axis=1)
        return float(np.mean((mean >= low) & (mean <= high)))


def check_consistency(
    bench: Bench,
    duration: float,
    *,
    observer: str | None = None,
    runs: int = 50,
    seed: int = 0,
    waveforms: Mapping[str, AbstractWaveform] | None = None,
) -> Consistency:
    """Run a bench many times with different noise.

    Args:
        bench: bench with a Kalman filter among its observers.
        duration: duration of a run [s].
        observer: name of the filter; default: the only filter.
        runs: number of runs.
        seed: seed of the first run; later runs have the next numbers.
        waveforms: signals of drives without a controller, equal in all runs.

    Raises:
        InputError: the filter does not exist.
    """
    chosen, hidden = _find_filter(bench, observer), hidden_states.list_names(bench.plant)
    rows = [
        _judge_run(simulate_bench(bench, duration, waveforms=waveforms, seed=seed + k).require(), hidden)
        for k in range(runs)
    ]
    nees, nis, error = zip(*rows, strict=True)
    errors = {name: np.stack([one[name] for one in error], axis=1) for name in hidden}
    times = bench.period * np.arange(1, len(nees[0]) + 1)
    nees, nis = np.stack(nees, axis=1), np.stack(nis, axis=1)
    return Consistency(times, nees, nis, len(hidden), len(chosen.reads()), errors)


def _judge_run(run: Result, hidden: list[str]) -> tuple[Numbers, Numbers, dict[str, Numbers]]:
    """Return NEES, NIS and errors of a run, without its initial sample."""
    columns = {name: np.asarray(column)[1:] for name, column in run.columns.items()}
    error = {name: columns[ESTIMATED + name] - columns[name] for name in hidden}
    e = np.stack([error[name] for name in hidden], axis=-1)
    sized = np.linalg.solve(_collect_covariance(columns, hidden), e[..., None])[..., 0]
    return np.sum(e * sized, axis=-1), columns[f"{ESTIMATED}nis"], error


def _find_filter(bench: Bench, name: str | None) -> AbstractFilter:
    members = bench.observers.members()
    filters = {n: one for n, one in members.items() if isinstance(one, AbstractFilter)}
    chosen = name or (next(iter(filters)) if len(filters) == 1 else "")
    if chosen not in filters:
        raise InputError(f"There is no Kalman filter `{chosen}`. {suggest_name(chosen, filters)}")
    return filters[chosen]


def _collect_covariance(columns: Mapping[str, Any], hidden: list[str]) -> Numbers:
    """Return P of every sample, shape (samples, n, n)."""
    size = [np.maximum(columns[f"{ESTIMATED}{name}_std"], CERTAIN) for name in hidden]
    rows = [[a * b for b in size] for a in size]
    for i, a in enumerate(hidden):
        for j, b in enumerate(hidden[i + 1 :], i + 1):
            rows[i][j] = rows[i][j] * columns[f"{ESTIMATED}{CORRELATION}.{a}.{b}"]
            rows[j][i] = rows[i][j]
    return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)
