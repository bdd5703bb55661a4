"""A Hammerstein system of first order, and logs of it: what tests of identification share.

    T' = (23 + 0.5 u + 0.05 u² - T)/τ,    y = 0.1 (T - 23),    τ = 2 s

held inputs, solved exactly from sample to sample, with noise.
"""

from __future__ import annotations

import numpy as np

from martensite.signals.sampling.sampled import Sampled

DT, TAU, AMBIENT = 0.1, 2.0, 23.0
STRUCTURE = "poly2 | oe(1,1,1) -> temperature"
LINE = "poly1 -> position"
SIGNALS = ("duty",), ("temperature", "position")
UNITS = {"duty": "%", "temperature": "degC", "position": "mm"}


def pulses(seed: int, count: int = 300) -> np.ndarray:
    """Pulses of random height and length, after 2 s at rest."""
    rng = np.random.default_rng(seed)
    u, k = np.zeros(count), 20
    while k < count:
        on, off = int(rng.uniform(5, 30)), int(rng.uniform(10, 50))
        u[k : k + on] = rng.uniform(5.0, 30.0)
        k += on + off
    return u


def ramps(count: int = 400) -> np.ndarray:
    """Slow ramps with a minor loop."""
    t = np.linspace(0.0, 1.0, count)
    return np.interp(t, [0.0, 0.05, 0.35, 0.5, 0.6, 0.8, 1.0], [0.0, 0.0, 28.0, 8.0, 18.0, 5.0, 25.0])


def log(name: str, u: np.ndarray, seed: int = 0, noise: float = 0.1) -> Sampled:
    """What the system answers."""
    rng = np.random.default_rng(seed)
    target, temperature = AMBIENT + 0.5 * u + 0.05 * u**2, np.full(len(u), AMBIENT)
    share = 1.0 - np.exp(-DT / TAU)
    for k in range(1, len(u)):
        temperature[k] = temperature[k - 1] + share * (target[k - 1] - temperature[k - 1])
    y = np.stack([temperature, 0.1 * (temperature - AMBIENT)], axis=1)
    y += rng.standard_normal(y.shape) * [noise, 0.1 * noise]
    return Sampled(name, DT, u, y, *SIGNALS, UNITS)
