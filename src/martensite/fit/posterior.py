"""Posterior samples of the fitted parameters: how they vary together, beyond a linear picture.

With residuals r of noise s, uniform priors within the bounds of the search and n_eff of n samples
that are independent,

    -log p(u | data) = ½ (n_eff/n) Σ r²/s² + constant,        0 < u < 1,

sampled by the No-U-Turn sampler (Hoffman and Gelman (2014), JMLR 15) of NumPyro, with the exact
Jacobian of the residuals. Numbers u are sampled as logits, so that no step leaves the bounds.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from importlib import import_module
from typing import Any

import numpy as np

from martensite.base.confidence import LEVEL, Interval
from martensite.base.errors import MartensiteError, ParameterError
from martensite.fit.fit import Fit
from martensite.kernels.jax_setup import jax_namespace

FORBIDDEN = 1e10
"""Potential where a run fails."""
SPLIT = 1.05
"""Split R̂ above which chains have not met."""


@dataclass(frozen=True)
class Posterior:
    """Samples of the free parameters."""

    samples: dict[str, Any]
    """Name -> (draws,) in SI, all chains one after the other."""
    chains: int
    r_hat: dict[str, float]
    """Split R̂: 1 where chains agree."""
    effective: dict[str, float]
    """Independent draws that say as much."""
    divergences: int
    """Draws at which the sampler lost its way; none if all is well."""

    def interval(self, name: str, level: float = LEVEL) -> Interval:
        """Central interval of a parameter in SI that holds a share `level` of the draws."""
        ends = (0.5 - 0.5 * level, 0.5 + 0.5 * level)
        low, high = np.quantile(self.samples[name], ends)
        return float(low), float(high)

    @property
    def settled(self) -> bool:
        """Whether chains agree and none diverged."""
        return self.divergences == 0 and all(r <= SPLIT for r in self.r_hat.values())

    @property
    def sentence(self) -> str:
        """How far the samples can be trusted."""
        worst = max(self.r_hat, key=lambda name: self.r_hat[name])
        least = min(self.effective.values())
        draws = len(next(iter(self.samples.values())))
        found = (
            f"{draws} draws of {self.chains} chains, at least {least:.0f} independent; "
            f"split R-hat at most {self.r_hat[worst]:.3f} (`{worst}`), "
            f"{self.divergences} divergences."
        )
        return found if self.settled else f"{found} Not settled: draw more, or free less."


def sample_posterior(
    fit: Fit, *, draws: int = 500, warmup: int = 300, chains: int = 2, seed: int = 0, progress: bool = False
) -> Posterior:
    """Sample the parameters around a fit.

    Args:
        fit: found by least squares; its noise and its effective number of samples are used.
        draws: per chain, after the warm-up.
        warmup: draws of each chain in which step and scales are found.
        chains: independent ones, the first from the optimum, the others from near it.
        seed: of all chance.
        progress: show a bar.

    Raises:
        MartensiteError: NumPyro is not installed.
        ParameterError: no draws or chains are asked for, or the fit has no sample to spare.
    """
    if min(draws, warmup, chains) < 1:
        raise ParameterError("Arguments `draws`, `warmup` and `chains` must be at least 1.")
    noise = fit.uncertainty.noise
    if not 0.0 < noise < math.inf:
        raise ParameterError("The fit has no noise to sample with; it leaves no sample to spare.")
    xp = jax_namespace()
    try:
        infer: Any = import_module("numpyro.infer")
    except ImportError:
        raise MartensiteError(
            "Posterior samples need NumPyro; install it with `pip install 'martensite[posterior]'`."
        ) from None
    potential = _build_potential(xp.jax, fit, 1.0 / (noise * fit.uncertainty.widening) ** 2)
    kernel = infer.NUTS(potential_fn=potential, dense_mass=True)
    sampler = infer.MCMC(
        kernel,
        num_warmup=warmup,
        num_samples=draws,
        num_chains=chains,
        chain_method="sequential",
        progress_bar=progress,
    )
    sampler.run(xp.jax.random.PRNGKey(seed), init_params=_draw_starts(fit, chains, seed), extra_fields=("diverging",))
    return _collect_samples(fit, sampler, chains)


def _build_potential(jax: Any, fit: Fit, weight: float) -> Callable[[Any], Any]:
    """The negative log density over logits z, with its exact gradient."""
    problem, count = fit.problem, len(fit.values)

    def value_and_slope(z: Any) -> tuple[Any, Any]:
        logits = np.asarray(z)
        u = _compute_shares(logits)
        found = problem.evaluate(u.tolist(), slopes=True)
        if found is None:
            return np.float64(FORBIDDEN), np.zeros(count)
        stretch = np.logaddexp(0.0, logits) + np.logaddexp(0.0, -logits)  # -log du/dz
        value = 0.5 * weight * found.residuals @ found.residuals + stretch.sum()
        slope = weight * (found.jacobian.T @ found.residuals) * u * (1.0 - u) - (1.0 - 2.0 * u)
        return np.float64(value), slope

    double = jax.numpy.float64
    shapes = jax.ShapeDtypeStruct((), double), jax.ShapeDtypeStruct((count,), double)

    def both(z: Any) -> Any:
        return jax.pure_callback(value_and_slope, shapes, z, vmap_method="sequential")

    def value(z: Any) -> Any:
        return both(z)[0]

    def forward(z: Any) -> Any:
        return both(z)

    def backward(slope: Any, cotangent: Any) -> Any:
        return (cotangent * slope,)

    potential: Any = jax.custom_vjp(value)
    potential.defvjp(forward, backward)
    return potential


def _compute_shares(logits: Any) -> Any:
    return np.exp(-np.logaddexp(0.0, -logits))


def _draw_starts(fit: Fit, chains: int, seed: int) -> Any:
    u = np.clip(np.array(fit.values), 0.01, 0.99)
    z = np.log(u / (1.0 - u))
    if chains == 1:
        return z
    jitter = 0.02 * np.random.default_rng(seed).standard_normal((chains, z.size))
    jitter[0] = 0.0
    return z + jitter


def _collect_samples(fit: Fit, sampler: Any, chains: int) -> Posterior:
    diagnostics: Any = import_module("numpyro.diagnostics")
    z = np.asarray(sampler.get_samples(group_by_chain=True)).reshape(chains, -1, len(fit.values))
    u = _compute_shares(z)
    samples: dict[str, Any] = {}
    r_hat: dict[str, float] = {}
    effective: dict[str, float] = {}
    for k, free in enumerate(fit.problem.free):
        numbers = np.vectorize(free.value)(u[:, :, k])
        samples[free.name] = numbers.ravel()
        with np.errstate(invalid="ignore", divide="ignore"):  # NaN of draws that are all equal
            r_hat[free.name] = float(diagnostics.split_gelman_rubin(numbers))
            effective[free.name] = float(diagnostics.effective_sample_size(numbers))
    diverging = np.asarray(sampler.get_extra_fields()["diverging"])
    return Posterior(samples, chains, r_hat, effective, int(diverging.sum()))
