"""Isobaric loops whose temperature is noisy, fitted again and again: how often intervals hold the truth.

`python tests/input_noise_cases.py 0 200` prints the coverage that docs/explanation/fitting.md tells.
"""

from __future__ import annotations

import sys
import time
from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
from fit_cases import ISOBARIC

from martensite.base.confidence import interval_contains
from martensite.fit.experiment import Experiment
from martensite.fit.fit import Fit
from martensite.fit.problem import Problem, build_problem
from martensite.fit.solve import solve_problem
from martensite.scenario.scenario import read_scenario
from martensite.signals.records import Record

FREE = ("A_s", "A_f", "M_s", "M_f", "eps_L", "C_A", "C_M")
STRESSES = (50e6, 100e6, 200e6)
ROWS = 81
STRAIN_NOISE = 2e-4


@cache
def build_loops() -> tuple[tuple[Experiment, ...], tuple[Any, ...], dict[str, float]]:
    """Experiments without noise, the strains of the model, and its numbers."""
    half = (ROWS - 1) / 2
    made, strains = [], []
    for stress in STRESSES:
        columns = {
            "time": [float(k) for k in range(ROWS)],
            "temperature": [298.15 + 110.0 * (1.0 - abs(k - half) / half) for k in range(ROWS)],
            "stress": [stress] * ROWS,
            "strain": [1e-3 * k for k in range(ROWS)],
        }
        log = Record(f"{stress / 1e6:g} MPa", columns, {"time": "s", "temperature": "K", "stress": "Pa", "strain": "1"})
        scenario = read_scenario(ISOBARIC, log=log)
        one = Experiment(
            log.name, scenario.system, scenario.waveform, log, {"strain": "strain"}, follows=scenario.follows
        )
        runner = one.runner()
        strain = runner.run_one(runner.base)
        assert strain is not None
        made.append(one)
        strains.append(strain[:, 0])
    truth = {leaf.path.rpartition(".")[2]: float(leaf.value) for leaf in made[0].system.leaves()}
    return tuple(made), tuple(strains), {name: truth[name] for name in FREE}


def draw_problem(seed: int, noise: float) -> Problem:
    """The loops as measured: temperatures with so much noise [K], strains with 0.02 %."""
    chance, measured = np.random.default_rng(seed), []
    experiments, strains, _ = build_loops()
    for one, strain in zip(experiments, strains, strict=True):
        temperature = np.array(one.record["temperature"]) + noise * chance.standard_normal(ROWS)
        seen = strain + STRAIN_NOISE * chance.standard_normal(ROWS)
        columns = one.record.columns | {"temperature": temperature.tolist(), "strain": seen.tolist()}
        record = replace(one.record, columns=columns)
        measured.append(replace(one.with_inputs({"drive": temperature}), record=record))
    return build_problem(measured, FREE)


@cache
def fit_loops(seed: int, noise: float, inputs: bool = True) -> Fit:
    """A fit from the true numbers on, with the noise of the temperature in it or not."""
    return solve_problem(draw_problem(seed, noise), inputs=inputs)


def judge_fits(fits: list[Fit]) -> tuple[Any, Any]:
    """Whether intervals hold the truth (fits, numbers), and errors over standard errors."""
    truth = build_loops()[2]
    held = [[interval_contains(fit.uncertainty.widen_interval(name), truth[name]) for name in FREE] for fit in fits]
    apart = [[(fit[name] - truth[name]) / fit.uncertainty.errors[k] for k, name in enumerate(FREE)] for fit in fits]
    return np.array(held), np.array(apart)


def main(first: int, count: int, levels: list[float]) -> None:
    """Print coverage, bias and scatter of so many fits at every level of noise."""
    for noise in levels:
        begun = time.process_time()
        held, apart = judge_fits([fit_loops(seed, noise) for seed in range(first, first + count)])
        each = ", ".join(f"{name} {100 * share:.1f}" for name, share in zip(FREE, held.mean(axis=0), strict=True))
        print(  # noqa: T201
            f"{noise:g} K: {held.sum()} of {held.size}, {100 * held.mean():.1f} % ({each}), "
            f"bias {apart.mean(axis=0).round(2).tolist()}, "
            f"scatter {apart.std(axis=0).round(2).tolist()}; "
            f"{time.process_time() - begun:.0f} s",
            flush=True,
        )


if __name__ == "__main__":
    main(int(sys.argv[1]), int(sys.argv[2]), [float(level) for level in sys.argv[3:]] or [0.0, 0.1, 0.3, 1.0])
