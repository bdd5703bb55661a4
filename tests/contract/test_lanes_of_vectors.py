"""Lanes that fill vectors: they agree with one lane at a time, wherever they stand."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from builders import SINE_A, problem_a

from martensite.kernels.c99_lanes import BLOCK, lanes_source
from martensite.simulate.compiled import compile_march
from martensite.simulate.drive_waveforms import grid_of
from martensite.simulate.native import march_lanes

pytestmark = pytest.mark.usefixtures("c_compiler")


def marched(lanes: int, order: np.ndarray) -> np.ndarray:
    """Positions of wires that differ in their heat loss, (samples, lanes)."""
    system = problem_a()
    compiled = compile_march(system)
    values: list[Any] = list(compiled.values(system))
    place = compiled.paths.index("environment.cooling.h0")
    values[place] = values[place] * (1.0 + 0.01 * order)
    grid = grid_of(system, SINE_A, 20.0, 51, 0.02)
    output = compiled.outputs.index("position")
    return march_lanes(compiled, values, grid, lanes, [output])[0][:, 0]


@pytest.fixture(scope="module")
def block() -> np.ndarray:
    return marched(BLOCK, np.arange(float(BLOCK)))


def test_a_lane_is_the_run_alone(block: np.ndarray) -> None:
    alone = marched(1, np.array([3.0]))[:, 0]
    assert np.ptp(alone) > 1e-3
    assert np.abs(block[:, 3] - alone).max() <= 1e-12 * np.ptp(alone)
    assert np.abs(block[:, 4] - alone).max() > 1e-4 * np.ptp(alone)


def test_a_lane_is_the_same_wherever_it_stands(block: np.ndarray) -> None:
    order = np.random.default_rng(1).permutation(BLOCK)
    assert np.array_equal(marched(BLOCK, order.astype(float)), block[:, order])


def test_divisions_by_one_number_share_its_inverse() -> None:
    compiled = compile_march(problem_a())
    text = lanes_source(compiled.program, [compiled.program.functions["step"]])
    kernel = text[text.index("k_step") :]
    assert kernel.count("over(all(1.0), ") > 8
    assert kernel.count("over(") < 40
