"""Peer for identification: jax-sysid on public records, one fit with a fixed budget.

What: jax-sysid (Bemporad 2024, Apache-2.0) minimises the simulation error of state-space models by
Adam and then L-BFGS-B, on gradients of a JAX scan. It needs an older JAX and SciPy than martensite,
so it runs in a process and an interpreter of its own. Signals are scaled to mean 0 and standard
deviation 1, as in its examples. Three models: `linear`; `sandwich`, two linear systems around one
layer of sigmoids, our own structure; `network`, its recurrent network, one hidden layer for the
next state and one for the output. Tests run free from the zero state. CPU seconds are those of
`fit`, compilation included; reading and imports are not.

Interpreter: `MARTENSITE_JAXSYSID_PYTHON` names one that has jax-sysid; else this one. To make one:
`python -m venv DIR && DIR/bin/pip install jax-sysid`.
"""

from __future__ import annotations

import contextlib
import io
import json
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Mapping, Sequence
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from benchmarks.process import run_process

VARIABLE = "MARTENSITE_JAXSYSID_PYTHON"
ONE_THREAD = {"XLA_FLAGS": "--xla_cpu_multi_thread_eigen=false intra_op_parallelism_threads=1"}


class Budget(NamedTuple):
    """How long it may search, and how large the model is."""

    states: int = 6
    units: int = 16
    adam: int = 100
    lbfgs: int = 200
    seed: int = 0


class Fit(NamedTuple):
    """What a fit took and gave."""

    seconds: float
    """CPU time [s]."""
    wall: float
    """Time [s]."""
    numbers: int
    """Free numbers."""
    errors: list[float]
    """Root mean square of the free run on every test, in its unit."""


@cache
def available() -> bool:
    """Whether the chosen interpreter imports jax-sysid."""
    try:
        done = subprocess.run([_python(), "-c", "import jax_sysid.models"], capture_output=True, check=False)
    except OSError:
        return False
    return done.returncode == 0


def fit(
    model: str,
    estimation: tuple[np.ndarray, np.ndarray],
    tests: Sequence[tuple[np.ndarray, np.ndarray]],
    skip: int,
    budget: Budget,
) -> Fit:
    """Fit a model to inputs and outputs (samples, 1), then run it on every test."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "records.npz"
        signals = [signal for pair in (estimation, *tests) for signal in pair]
        np.savez(path, *signals)
        order = {"model": model, "path": str(path), "skip": skip, **budget._asdict()}
        command = [_python(), "-m", "benchmarks.peers.jaxsysid_fit", json.dumps(order)]
        return Fit(**run_process(command, ONE_THREAD).answer)


def _python() -> str:
    return os.environ.get(VARIABLE) or sys.executable


# ---------------------------------------------------------------- in the other process


def _linear(order: Mapping[str, Any]) -> Any:
    """A linear state-space model with feed-through."""
    from jax_sysid.models import LinearModel

    model = LinearModel(order["states"], 1, 1, feedthrough=True)
    model.init(seed=order["seed"])
    return model


def _sandwich(order: Mapping[str, Any]) -> Any:
    """A linear system, a line with sigmoids, a linear system; half of the states each."""
    import jax.numpy as jnp
    from jax_sysid.models import Model

    half, rng = order["states"] // 2, np.random.default_rng(order["seed"])

    def times(matrix: Any, x: Any) -> Any:  # small products are several times slower with @
        return (matrix * x).sum(axis=1)

    def between(x: Any, u: Any, p: Any) -> Any:
        w = times(p[2], x[:half]) + times(p[3], u)
        units = 1.0 / (1.0 + jnp.exp(-(times(p[6], w) + p[7])))
        return times(p[4], w) + times(p[5], units) + p[8]

    def state(x: Any, u: Any, p: Any) -> Any:
        first = times(p[0], x[:half]) + times(p[1], u)
        return jnp.hstack([first, times(p[9], x[half:]) + times(p[10], between(x, u, p))])

    def output(x: Any, u: Any, p: Any) -> Any:
        return times(p[11], x[half:]) + times(p[12], between(x, u, p))

    def system() -> list[np.ndarray]:
        small = 0.3 * rng.normal(size=(2, half))
        poles = np.diag(np.linspace(0.3, 0.8, half))
        return [poles, small[0][:, None], small[1][None, :], np.ones((1, 1))]

    units = order["units"]
    steep, places = 2.0 * np.ones((units, 1)), np.linspace(-4.0, 4.0, units)
    layer = [np.ones((1, 1)), 0.1 * rng.normal(size=(1, units)), steep, places, np.zeros(1)]
    model = Model(order["states"], 1, 1, state_fcn=state, output_fcn=output)
    model.init([*system(), *layer, *system()])
    return model


def _network(order: Mapping[str, Any]) -> Any:
    """A recurrent network."""
    from flax import linen
    from jax_sysid.models import RNN

    def layers(count: int, line: bool) -> Any:
        class Layers(linen.Module):
            @linen.compact
            def __call__(self, x: Any) -> Any:
                hidden = linen.swish(linen.Dense(order["units"])(x))
                return linen.Dense(count, use_bias=line)(hidden)

        return Layers

    states = order["states"]
    return RNN(states, 1, 1, FX=layers(states, True), FY=layers(1, True), seed=order["seed"])


def _solve(order: Mapping[str, Any]) -> Fit:
    """Fit, then run on the tests."""
    import jax

    jax.config.update("jax_enable_x64", True)  # before any model, as its examples do
    with np.load(order["path"]) as kept:
        signals = [kept[name] for name in kept.files]
    pairs = list(zip(signals[0::2], signals[1::2], strict=True))
    means = [signal.mean() for signal in pairs[0]]
    spreads = [signal.std() for signal in pairs[0]]
    scaled = [[(s - m) / d for s, m, d in zip(pair, means, spreads, strict=True)] for pair in pairs]
    model = {"linear": _linear, "sandwich": _sandwich, "network": _network}[order["model"]](order)
    model.loss(rho_x0=1e-6, rho_th=1e-8, train_x0=True)
    model.optimization(adam_epochs=order["adam"], lbfgs_epochs=order["lbfgs"], iprint=-1)
    wall, cpu = time.perf_counter(), time.process_time()
    with contextlib.redirect_stdout(io.StringIO()):
        model.fit(scaled[0][1], scaled[0][0])
    cpu, wall = time.process_time() - cpu, time.perf_counter() - wall
    errors: list[float] = []
    for u, y in scaled[1:]:
        run = np.asarray(model.predict(np.zeros(order["states"]), u)[0])
        away = (run - y)[order["skip"] :]
        errors.append(float(spreads[1] * np.sqrt(np.mean(away**2))))
    return Fit(cpu, wall, sum(int(np.size(p)) for p in model.params), errors)


if __name__ == "__main__":
    print(json.dumps(_solve(json.loads(sys.argv[1]))._asdict()))
