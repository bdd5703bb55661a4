"""Every registered block of a dynamic model is the same in C, with its derivatives.

Source of truth: central differences of the simulation for derivatives, plain Python for C. What
the interface promises is in `martensite.testing.blocks`.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from martensite.identify.blocks.base import BLOCKS
from martensite.identify.blocks.polynomial import Polynomial
from martensite.identify.blocks.side_by_side import SideBySide
from martensite.identify.chains.engine import ChainEngine
from martensite.testing import build_example
from martensite.testing.blocks import DT, draw_numbers, find_slope_error, lead_block, make_record

KINKED = {
    "bouc-wen",
    "dead-zone",
    "duhem",
    "feedback-loop",
    "generalised-prandtl-ishlinskii",
    "heated-duhem",
    "piecewise-linear",
    "play",
    "prandtl-ishlinskii",
    "preisach",
    "saturation",
}
"""Blocks whose output bends, where differences are less exact."""


def example(name: str) -> Any:
    """A small block of that name; side by side stand two that differ."""
    if name == "side-by-side":
        return SideBySide(blocks=(Polynomial(degree=3.0), BLOCKS["transfer-function"]()))
    return build_example(BLOCKS[name])


UNBOUNDED = {name for name in BLOCKS.names() if not BLOCKS[name].bounded}
SMOOTH = pytest.mark.parametrize("name", [n for n in BLOCKS.names() if n not in KINKED])


@SMOOTH
def test_derivatives_of_smooth_blocks_are_those_of_the_simulation_to_the_ends(name):
    assert find_slope_error(lead_block(example(name))) <= 1e-7


def groups() -> list[list[str]]:
    """Blocks that are compiled together: those without memory, which run in tiles, apart."""
    names = [n for n in BLOCKS.names() if n != "side-by-side" and n not in UNBOUNDED]
    parts = [[n for n in names if bool(example(n).states()) is memory] for memory in (True, False)]
    return [sorted(UNBOUNDED), *(part[i : i + 5] for part in parts for i in range(0, len(part), 5))]


@pytest.mark.parametrize("names", groups(), ids="+".join)
def test_c_runs_as_plain_python(names, c_compiler):
    blocks = lead_block(SideBySide(blocks=tuple(example(name) for name in names)))
    u = make_record(blocks[0].inputs)
    fast, plain = ChainEngine(blocks, DT, compiled=True), ChainEngine(blocks, DT, compiled=False)
    theta = np.concatenate([draw_numbers(block) for block in blocks])
    for found, meant in zip(fast.jacobian(theta, u), plain.jacobian(theta, u), strict=True):
        scale = np.abs(meant).max(axis=0)
        assert (np.abs(found - meant).max(axis=0) <= 1e-12 * (1.0 + scale)).all()
    if not UNBOUNDED & set(names):
        for seed in range(5):
            wild = np.random.default_rng(seed).uniform(-30.0, 30.0, len(theta))
            assert all(np.isfinite(part).all() for part in fast.jacobian(wild, u))
