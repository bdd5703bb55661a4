"""Records of systems whose structure is known, for the ladder of structures."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy.signal import lfilter

from martensite.signals.sampling.sampled import Sampled

NOISE = 0.01
"""Of the output, over its spread."""


def excite(rng: np.random.Generator, count: int, low: float = -1.0, high: float = 1.0, hold: int = 25) -> np.ndarray:
    """Ramps and holds between random levels, of random lengths; at rest first."""
    corners, levels = [0, 40], [0.0, 0.0]
    while corners[-1] < count:
        level = rng.uniform(low, high)
        for length in (rng.integers(2, 2 * hold), rng.integers(2, hold)):
            corners.append(corners[-1] + int(length))
            levels.append(level)
    return np.interp(np.arange(count), corners, levels)


def record(name: str, u: np.ndarray, y: np.ndarray, rng: np.random.Generator, interval: float = 0.1) -> Sampled:
    noisy = y + NOISE * np.std(y) * rng.normal(size=len(y))
    return Sampled(name, interval, u[:, None], noisy[:, None], ("u",), ("y",), {"u": "V", "y": "mm"})


def low_pass(w: np.ndarray) -> np.ndarray:
    """A resonance of second order, unit gain, delayed by two samples."""
    a = np.poly(np.exp(np.array([-0.08 + 0.22j, -0.08 - 0.22j])))
    return np.asarray(lfilter([0.0, 0.0, a.sum().real], a.real, w))


def linear(seed: int, count: int = 3000) -> Sampled:
    rng = np.random.default_rng(seed)
    u = excite(rng, count)
    return record("linear", u, 2.0 + 3.0 * low_pass(u), rng)


def hammerstein(seed: int, count: int = 3000) -> Sampled:
    rng = np.random.default_rng(seed)
    u = excite(rng, count)
    return record("hammerstein", u, low_pass(np.tanh(2.5 * u) + 0.5 * u**2), rng)


def wiener(seed: int, count: int = 3000) -> Sampled:
    rng = np.random.default_rng(seed)
    u = excite(rng, count)
    return record("wiener", u, np.exp(1.3 * low_pass(u)), rng)


def bouc_wen(seed: int, count: int = 4000) -> Sampled:
    """A mass on a line and a Bouc–Wen element, integrated in twenty steps a sample: no block of ours."""
    rng = np.random.default_rng(seed)
    u = excite(rng, count, hold=20)
    x = v = z = 0.0
    y = np.empty(count)
    step = 0.05 / 20
    for k in range(count):
        y[k] = x
        for _ in range(20):
            v += step * (80.0 * u[k] - 1.2 * v - 12.0 * x - 40.0 * z)
            x += step * v
            z += step * (v - 0.8 * abs(v) * z - 0.2 * v * abs(z))
    return record("bouc-wen", u, y, rng, 0.05)


def noise(seed: int, count: int = 3000) -> Sampled:
    """An output that has nothing to do with its input."""
    rng = np.random.default_rng(seed)
    y = np.asarray(lfilter([1.0], [1.0, -0.8], rng.normal(size=count)))
    return record("noise", excite(rng, count), y, rng)


SYSTEMS: dict[str, Callable[[int], Sampled]] = {
    "linear": linear,
    "hammerstein": hammerstein,
    "wiener": wiener,
    "bouc-wen": bouc_wen,
    "noise": noise,
}
