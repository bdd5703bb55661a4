"""Every registered block of a dynamic model is the same in C and JAX, with its derivatives.

Source of truth: central differences of the simulation for derivatives, JAX for those of the bare
kernel, plain Python for C. What the interface promises is in `martensite.testing.blocks`.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from martensite.identify.blocks.base import BLOCKS
from martensite.identify.blocks.polynomial import Polynomial
from martensite.identify.blocks.side_by_side import SideBySide
from martensite.identify.chains.engine import ChainEngine
from martensite.kernels.jax_setup import jax_namespace
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
SIMPLE = {"transfer-function", "prandtl-ishlinskii", "polynomial", "sigmoid-network"}
"""Blocks of every sort that JAX is quick with."""


SMOOTH = pytest.mark.parametrize("name", [n for n in BLOCKS.names() if n not in KINKED])
IN_JAX = pytest.mark.parametrize(
    "name",
    [pytest.param(n, marks=[] if n in SIMPLE else pytest.mark.slow) for n in BLOCKS.names() if example(n).numbers()],
)


class TestDerivatives:
    @SMOOTH
    def test_smooth_ones_are_those_of_the_simulation_to_the_ends(self, name):
        assert find_slope_error(lead_block(example(name))) <= 1e-7

    @IN_JAX
    def test_jax_finds_the_same_in_the_kernel(self, name):
        block = example(name)
        theta, u = draw_numbers(block), make_record(block.inputs)[5:36:15]
        xp = jax_namespace()

        def run(theta):
            own = [theta[i] for i in range(len(block.numbers()))]
            rows, state = [], block.rest(xp, own, list(u[0]), DT)
            for x in u:
                y, state = block.step(xp, own, state, list(x), DT)
                rows.append(xp.np.stack([xp.np.asarray(v) for v in y]))
            return xp.np.stack(rows)

        meant = np.asarray(xp.jax.jacfwd(run)(xp.np.asarray(theta)))
        found = ChainEngine([block], DT, compiled=False).jacobian(theta, u)[1]
        assert np.abs(found - meant).max() <= 1e-11 * max(1.0, np.abs(meant).max())


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
