"""Is a filter as wrong as it says? Many runs of a bench with other noise.

    e = x - x̂,    NEES = eᵀ P⁻¹ e,    x = (T, ξ) of every port

Of a consistent filter the mean over N runs, times N, is chi-square distributed with N n degrees of freedom. So is that
of the NIS, with as many per run as there are readings. The noise must be the one that the filter reckons with: a plant
that does the same random walk is a `ProcessNoisePlant`.

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
"""Standard deviation below which nothing is unknown."""


@dataclass(frozen=True)
class Consistency:
    """Errors of a filter in many runs, as shares of what it says of them."""

    times: Numbers
    """[s]"""
    nees: Numbers
    """(samples, runs)"""
    nis: Numbers
    """(samples, runs)"""
    degrees: int
    """Degrees of freedom of the NEES: number of hidden values."""
    readings: int
    """Number of readings in the NIS."""
    error: dict[str, Numbers]
    """Estimate less truth by name, (samples, runs)."""

    @property
    def runs(self) -> int:
        """Return the number of runs."""
        return self.nees.shape[1]

    def band(self, share: float = 0.95) -> tuple[float, float]:
        """Return the band that contains the mean NEES of a sample over the runs with a given probability."""
        from scipy.stats import chi2

        ends = chi2.ppf([0.5 - 0.5 * share, 0.5 + 0.5 * share], self.degrees * self.runs) / self.runs
        return float(ends[0]), float(ends[1])

    def inside(self, share: float = 0.95) -> float:
        """Return the share of samples whose mean NEES lies in its band; `share` if all is well."""
        low, high = self.band(share)
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
    """Run a bench many times with other noise.

    Args:
        bench: with a Kalman filter among its observers.
        duration: of a run [s].
        observer: name of the filter; by default the only one.
        runs: how many.
        seed: of all noise of the first run; the next ones have the next numbers.
        waveforms: those of drives of the plant that no controller has, the same in all runs.

    Raises:
        InputError: no filter has that name.
    """
    chosen, unknown = _find_filter(bench, observer), hidden_states.list_names(bench.plant)
    found = [
        _judge_run(simulate_bench(bench, duration, waveforms=waveforms, seed=seed + k).require(), unknown)
        for k in range(runs)
    ]
    nees, nis, error = zip(*found, strict=True)
    errors = {name: np.stack([one[name] for one in error], axis=1) for name in unknown}
    times = bench.period * np.arange(1, len(nees[0]) + 1)
    nees, nis = np.stack(nees, axis=1), np.stack(nis, axis=1)
    return Consistency(times, nees, nis, len(unknown), len(chosen.reads()), errors)


def _judge_run(run: Result, unknown: list[str]) -> tuple[Numbers, Numbers, dict[str, Numbers]]:
    """NEES, NIS and errors of a run, without its start at rest."""
    columns = {name: np.asarray(column)[1:] for name, column in run.columns.items()}
    error = {name: columns[ESTIMATED + name] - columns[name] for name in unknown}
    e = np.stack([error[name] for name in unknown], axis=-1)
    sized = np.linalg.solve(_collect_covariance(columns, unknown), e[..., None])[..., 0]
    return np.sum(e * sized, axis=-1), columns[f"{ESTIMATED}nis"], error


def _find_filter(bench: Bench, name: str | None) -> AbstractFilter:
    members = bench.observers.members()
    found = {n: one for n, one in members.items() if isinstance(one, AbstractFilter)}
    chosen = name or (next(iter(found)) if len(found) == 1 else "")
    if chosen not in found:
        raise InputError(f"There is no Kalman filter `{chosen}`. {suggest_name(chosen, found)}")
    return found[chosen]


def _collect_covariance(columns: Mapping[str, Any], unknown: list[str]) -> Numbers:
    """P of every sample, (samples, n, n)."""
    size = [np.maximum(columns[f"{ESTIMATED}{name}_std"], CERTAIN) for name in unknown]
    rows = [[a * b for b in size] for a in size]
    for i, a in enumerate(unknown):
        for j, b in enumerate(unknown[i + 1 :], i + 1):
            rows[i][j] = rows[i][j] * columns[f"{ESTIMATED}{CORRELATION}.{a}.{b}"]
            rows[j][i] = rows[i][j]
    return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)
