"""Posterior samples of the fitted parameters, beyond the linear approximation.

With residuals r of noise s, uniform priors within the search bounds, and n_eff independent of n samples,

    -log p(u | data) = ½ (n_eff/n) Σ r²/s² + constant,        0 < u < 1,

sampled by an ensemble of walkers (emcee: Foreman-Mackey et al. (2013), PASP 125), which needs no derivatives and is
affine-invariant. Steps are differences of other walkers (ter Braak and Vrugt (2008), Stat. Comput. 18). One half of the
ensemble moves at a time, as a batch in C.

Draws of a walker are correlated over the autocorrelation time τ [steps]. Estimates of τ are reliable from 50 τ on
(Sokal (1997), Functional Integration); a shorter chain has not converged.
"""

from __future__ import annotations

import io
import math
from collections.abc import Callable
from contextlib import redirect_stdout
from dataclasses import dataclass
from typing import Any

import numpy as np

from martensite.base.confidence import LEVEL, Interval
from martensite.base.errors import ParameterError
from martensite.base.lazy import import_extra
from martensite.fit.fit import Fit
from martensite.search.batch_runner import LANES

LONG_ENOUGH = 50.0
"""Chain length, in autocorrelation times, from which it has converged."""
WALKERS_PER_PARAMETER = 4
WIDEST_START = 0.3
"""Largest standard deviation of the starts, as a fraction of the search range."""


@dataclass(frozen=True)
class Posterior:
    """Samples of the free parameters."""

    samples: dict[str, Any]
    """Name -> (draws x walkers,) in SI, with consecutive walkers of each step."""
    walkers: int
    draws: int
    """Steps of every walker."""
    times: dict[str, float]
    """Name -> autocorrelation time [steps]; NaN if the draws do not differ."""

    def interval(self, name: str, level: float = LEVEL) -> Interval:
        """Return the central interval of a parameter in SI that holds a fraction `level` of the draws."""
        ends = (0.5 - 0.5 * level, 0.5 + 0.5 * level)
        low, high = np.quantile(self.samples[name], ends)
        return float(low), float(high)

    @property
    def effective(self) -> dict[str, float]:
        """Return the number of independent draws with the same information, by name."""
        return {name: self.walkers * self.draws / time for name, time in self.times.items()}

    @property
    def converged(self) -> bool:
        """Return whether the chain is long enough for every parameter."""
        return all(self.draws >= LONG_ENOUGH * time for time in self.times.values())

    @property
    def sentence(self) -> str:
        """Describe the convergence of the chain, and the action if it has not converged."""
        slowest = max(self.times, key=lambda name: (not math.isfinite(self.times[name]), self.times[name]))
        time = self.times[slowest]
        size = f"{self.walkers} walkers made {self.draws} steps each"
        if not math.isfinite(time):
            return f"Not converged: {size}, and `{slowest}` did not move; take more steps."
        words = (
            f"{size}: at least {self.effective[slowest]:.0f} independent draws; longest autocorrelation time "
            f"{time:.1f} steps (`{slowest}`)."
        )
        if self.converged:
            return words
        return f"Not converged: {words} Take at least {math.ceil(LONG_ENOUGH * time)} steps, or free fewer parameters."


def sample_posterior(fit: Fit, *, draws: int = 500, warmup: int = 200, seed: int = 0) -> Posterior:
    """Sample the parameters around a fit.

    Args:
        fit: fit by least squares, with its noise and its effective number of samples.
        draws: number of kept steps of every walker after the warm-up.
        warmup: number of first steps of every walker, which are discarded.
        seed: seed of all random numbers.

    Returns:
        The samples, with their autocorrelation times.

    Raises:
        InputError: emcee is not installed.
        ParameterError: `draws` or `warmup` is below 1, or the fit has no degrees of freedom.
    """
    if min(draws, warmup) < 1:
        raise ParameterError("Arguments `draws` and `warmup` must be at least 1.")
    noise = fit.uncertainty.noise
    if not 0.0 < noise < math.inf:
        raise ParameterError("The fit has no noise to sample with; it leaves no sample to spare.")
    emcee = import_extra("emcee", "posterior")
    free = len(fit.values)
    walkers = 2 * LANES * math.ceil(WALKERS_PER_PARAMETER * free / (2 * LANES))
    moves = [(emcee.moves.DEMove(), 0.8), (emcee.moves.DESnookerMove(), 0.2)]
    density = _build_density(fit, 1.0 / (noise * fit.uncertainty.widening) ** 2)
    sampler = emcee.EnsembleSampler(walkers, free, density, moves=moves, vectorize=True)
    chance = np.random.RandomState(seed).get_state()
    state = emcee.State(_draw_starts(fit, walkers, seed), random_state=chance)
    with redirect_stdout(io.StringIO()):  # emcee prints the traceback of an interruption
        state = sampler.run_mcmc(state, warmup, skip_initial_state_check=True)
        sampler.reset()
        sampler.run_mcmc(state, draws, skip_initial_state_check=True)
    return _collect_samples(fit, sampler.get_chain(), emcee.autocorr)


def _build_density(fit: Fit, weight: float) -> Callable[[Any], Any]:
    """Return the function from points (m, free) to log densities (m,); -inf beyond a bound and for failed runs."""
    factor = -0.5 * weight * len(fit.evaluation.residuals)

    def compute_density(points: Any) -> Any:
        density = np.full(len(points), -np.inf)
        inside = ((points > 0.0) & (points < 1.0)).all(axis=1)
        if inside.any():
            density[inside] = factor * fit.problem.costs(points[inside])
        return density

    return compute_density


def _draw_starts(fit: Fit, count: int, seed: int) -> Any:
    """Draw starts (count, free) from the linearised posterior, mirrored at the bounds."""
    uncertainty, u = fit.uncertainty, np.array(fit.values)
    per_share = np.array([abs(free.slope(x)) for free, x in zip(fit.problem.free, u, strict=True)])
    errors = np.array(uncertainty.errors) * uncertainty.widening / per_share
    errors = np.where(errors < WIDEST_START, errors, WIDEST_START)
    correlation = np.array(uncertainty.correlation)
    correlation[~np.isfinite(correlation)] = 0.0
    np.fill_diagonal(correlation, 1.0)
    draws = np.random.default_rng(seed).multivariate_normal(np.zeros_like(u), correlation, count, method="eigh")
    return 1.0 - np.abs(1.0 - np.abs(u + errors * draws))


def _collect_samples(fit: Fit, chain: Any, autocorr: Any) -> Posterior:
    """Return the posterior of a chain (draws, walkers, free)."""
    draws, walkers, _ = chain.shape
    with np.errstate(invalid="ignore", divide="ignore"):  # NaN of draws that are all equal
        times = autocorr.integrated_time(chain, tol=0)
    samples = {free.name: np.vectorize(free.value)(chain[..., k]).ravel() for k, free in enumerate(fit.problem.free)}
    return Posterior(samples, walkers, draws, dict(zip(samples, map(float, times), strict=True)))
