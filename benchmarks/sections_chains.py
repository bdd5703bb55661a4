"""Sections of the benchmark on chains of blocks: simulation, derivatives, searches, memory.

What: `poly2 | oe(3,3,1) | pwl10` with moving knots, 25 free numbers, 40 000 samples: outputs with
all derivatives, in one compiled pass; as differences of our own compiled simulation; and as
differences of the same chain written with NumPy and SciPy. Then a
search from 24 starts, and 500 000 samples with about 300 numbers, judged by their memory.
Derivatives are judged by central differences of the compiled simulation.
"""

from __future__ import annotations

import json
import resource
import sys
from collections.abc import Callable
from typing import Any

import numpy as np
from scipy.signal import lfilter

from benchmarks.harness import Candidate, measure
from benchmarks.process import run_process
from benchmarks.report import Table
from benchmarks.sections import Options, rows_of, section
from martensite.identify.chains.chain import Chain, build_untrained
from martensite.identify.chains.chain_text import parse_chain
from martensite.identify.chains.estimate import Options as Search
from martensite.identify.chains.estimate import estimate_chain
from martensite.identify.chains.residuals import RecordResidual, ResidualSquares
from martensite.identify.operators import sections
from martensite.kernels import floats
from martensite.signals.sampling.sampled import Sampled

TEXT = "poly2 | oe(3,3,1) | pwl10"
LONG = "wavelet(88) | oe(3,3,1) | sigmoid(10)"
SAMPLES, INTERVAL = 40_000, 2e-3
STEP = 1e-6
Function = Callable[[np.ndarray], np.ndarray]


def first_stage(samples: int = SAMPLES, text: str = TEXT) -> tuple[Chain, Sampled]:
    """The chain with drawn numbers, and a record of another that it is compared with."""
    rng = np.random.default_rng(0)
    held = max(samples // 40, 1)
    u = np.repeat(rng.choice([0.0, 1.0], 41) * rng.uniform(18.0, 38.0, 41), held)[:samples]
    record = Sampled("made up", INTERVAL, u, np.zeros(samples), ("duty",), ("temperature",))
    chain = build_untrained(parse_chain(text), record)
    drawn = [
        np.concatenate([b.sample_parameters(rng, record.duration, INTERVAL) for b in chain.blocks]) for _ in range(2)
    ]
    y = chain.with_theta(drawn[0]).simulate(record)
    noise = 0.01 * float(np.std(y)) * rng.normal(size=y.shape)
    return chain.with_theta(drawn[1]), record.with_outputs(y + noise)


def in_numpy(chain: Chain, u: np.ndarray) -> Function:
    """The chain as polyval, lfilter and interp: what one writes without a library."""
    curve, linear, knots = chain.blocks

    def run(theta: np.ndarray) -> np.ndarray:
        own, poles, last = chain.split(theta)
        low, high = curve.fixed_values()[:2]
        r, zero = (2.0 * u - low - high) / (high - low), -(low + high) / (high - low)
        powers = np.array([own[1], own[0], 0.0])
        w = np.polyval(powers, r) - np.polyval(powers, zero)
        b, a = fraction(linear, poles)
        x = w[0] + lfilter(b, a, w - w[0])  # from rest; its gain there is 1
        shown = np.array([value for _, value, _ in knots.describe_numbers(last)])
        return extended(x, shown[0::2], shown[1::2])

    return run


def fraction(block: Any, theta: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Coefficients of B and F from the numbers of `oe`: expanded, as is usual."""
    order, delay, zeros = int(block.nf), int(block.nk), int(block.nb)
    d = np.poly(sections.find_poles(order, theta[:order], INTERVAL)).real
    state: list[float] = [0.0] * block.states()
    response: list[float] = []
    for k in range(delay + zeros):
        y, after = block.step(floats, list(map(float, theta)), state, (float(k == 0),), INTERVAL)
        response.append(float(y[0]))
        state = list(after)
    return np.convolve(response, d)[: delay + zeros], d


def extended(x: np.ndarray, knots: np.ndarray, values: np.ndarray) -> np.ndarray:
    """`interp`, with its end segments going on straight."""
    y = np.interp(x, knots, values)
    slopes = np.diff(values) / np.diff(knots)
    y = np.where(x < knots[0], values[0] + slopes[0] * (x - knots[0]), y)
    return np.where(x > knots[-1], values[-1] + slopes[-1] * (x - knots[-1]), y)


def differences(run: Function, theta: np.ndarray, central: bool) -> np.ndarray:
    """Derivatives (samples, numbers) by differences, steps relative to the numbers."""
    base = run(theta)
    made = np.empty((len(base), len(theta)))
    for i, value in enumerate(theta):
        away = np.zeros(len(theta))
        away[i] = STEP * max(abs(value), 1.0)
        below = run(theta - away) if central else base
        made[:, i] = (run(theta + away) - below) / ((1 + central) * away[i])
    return made


def candidates(chain: Chain, record: Sampled) -> list[Candidate]:
    """All ways to outputs and derivatives."""
    u, engine = record.inputs, chain.engine
    compiled: Function = lambda theta: engine.simulate(theta, u)[:, 0]  # noqa: E731
    plain = in_numpy(chain, u[:, 0])
    exact = differences(compiled, chain.theta, True)
    size = np.abs(exact).max(axis=0)
    size = np.maximum(size, 1e-6 * size.max())  # of what hardly counts differences are noise

    def error(found: np.ndarray) -> float:
        return float((np.abs(found - exact).max(axis=0) / size).max())

    def one_pass() -> np.ndarray:
        return engine.jacobian(chain.theta, u)[1][:, 0]

    def in_chunks() -> None:
        for _ in engine.sensitivities(chain.theta, u, reuse=True):
            pass

    by = {"compiled": compiled, "NumPy, SciPy": plain}
    found = [Candidate("one pass", one_pass, error), Candidate("one pass, in chunks", in_chunks)]
    found += [Candidate(f"simulation alone, {name}", lambda run=run: run(chain.theta)) for name, run in by.items()]
    for name, run in by.items():
        for central in (False, True):
            kind = "central" if central else "2-point"
            found.append(
                Candidate(
                    f"{kind} differences, {name}",
                    lambda run=run, central=central: differences(run, chain.theta, central),
                    error,
                )
            )
    return found


@section
def chains(options: Options) -> list[Table]:
    """Outputs and all derivatives of a chain of 25 numbers."""
    chain, record = first_stage()
    timings = measure(candidates(chain, record), options.repeats, options.base or "one pass")
    note = f"{len(chain.theta)} numbers. err: largest, of the largest derivative of each."
    return [Table(f"Derivatives of {TEXT}, {SAMPLES} samples", rows_of(timings, "ms", 1e3), note)]


@section
def searches(options: Options) -> list[Table]:
    """A search from 24 starts, two at a time, the best three refined at the full rate."""
    chain, record = first_stage()
    fits: list[tuple[float, ...]] = []

    def run() -> None:
        fits.append(estimate_chain(chain.blocks, record, Search(starts=24, threads=2)).fits)

    timings = measure([Candidate("24 starts", run)], min(options.repeats, 2))
    note = "Ends of the refined searches [%]: " + ", ".join(f"{fit:.2f}" for fit in fits[-1])
    return [Table(f"Search for {TEXT}, {SAMPLES} samples", rows_of(timings, "s", 1.0), note)]


def large(samples: int = 500_000) -> dict[str, float]:
    """Peak memory [MB] before and in one evaluation of the normal equations."""
    chain, record = first_stage(samples, LONG)
    squares = ResidualSquares(chain.engine, [RecordResidual(record)])
    unit = 1 if sys.platform == "darwin" else 1024
    squares.value(chain.theta)
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * unit / 1e6
    squares.normal(chain.theta)
    after = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * unit / 1e6
    return {"numbers": len(chain.theta), "before": before, "after": after}


@section
def chain_memory(options: Options) -> list[Table]:
    """Half a million samples and some 300 numbers, in a process of their own."""
    code = "import json; from benchmarks.sections_chains import large; print(json.dumps(large()))"
    used = run_process([sys.executable, "-c", code])
    found = used.answer if isinstance(used.answer, dict) else json.loads(str(used.answer))
    row = {
        "numbers": found["numbers"],
        "before [MB]": found["before"],
        "peak [MB]": found["after"],
        "all derivatives [MB]": 8e-6 * 500_000 * found["numbers"],
    }
    return [Table(f"Normal equations of {LONG}, 500000 samples", [row])]
