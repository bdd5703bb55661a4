"""Every registered block of a dynamic model keeps the promises of its interface.

Source of truth: central differences of the simulation for derivatives, JAX for those of the bare
kernel, plain Python for C, and what the interface declares.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from martensite.identify.blocks.base import BLOCKS, AbstractBlock, AbstractStatic
from martensite.identify.blocks.polynomial import Polynomial
from martensite.identify.blocks.side_by_side import SideBySide
from martensite.identify.chains.engine import Engine
from martensite.identify.chains.written import parse_block
from martensite.kernels import floats
from martensite.kernels.jax_setup import jax_namespace

DT, SAMPLES = 0.05, 40
SMALL = {
    "nonlinear-state-space": {"degree": 2.0},
    "piecewise-linear": {"knots": 4.0},
    "generalised-prandtl-ishlinskii": {"plays": 3.0, "knots": 3.0},
    "prandtl-ishlinskii": {"plays": 4.0},
    "preisach": {"levels": 3.0, "knots": 3.0},
    "sigmoid-network": {"units": 2.0},
    "spline": {"knots": 4.0},
    "state-space": {"order": 3.0, "ins": 2.0, "outs": 2.0},
    "tanh-network": {"units": 2.0},
    "transfer-function": {"nb": 3.0, "nf": 3.0},
    "wavelet-network": {"units": 2.0},
}
"""Structures that are quick and not trivial."""
KINKED = {
    "bouc-wen", "dead-zone", "duhem", "generalised-prandtl-ishlinskii", "heated-duhem",
    "piecewise-linear", "play", "prandtl-ishlinskii", "preisach", "saturation",
}  # fmt: skip
"""Blocks whose output bends, where differences are less exact."""


def example(name: str) -> Any:
    """A small block of that name; side by side stand two that differ."""
    if name == "side-by-side":
        return SideBySide(blocks=(Polynomial(degree=3.0), BLOCKS["transfer-function"]()))
    return BLOCKS[name](**SMALL.get(name, {}))


UNBOUNDED = {"feedback"}
"""Blocks that say of themselves that they may grow without bound."""
SIMPLE = {"transfer-function", "prandtl-ishlinskii"}
"""Blocks with memory that JAX is quick with."""


BLOCK = pytest.mark.parametrize("name", BLOCKS.names())
STATIC = pytest.mark.parametrize(
    "name", [n for n in BLOCKS.names() if issubclass(BLOCKS[n], AbstractStatic)]
)
QUICK = [n for n in BLOCKS.names() if n in SIMPLE or not example(n).states()]
IN_JAX = pytest.mark.parametrize(
    "name",
    [
        pytest.param(n, marks=[] if n in QUICK else pytest.mark.slow)
        for n in BLOCKS.names()
        if example(n).numbers()
    ],
)


def record(channels: int) -> np.ndarray:
    """Inputs that turn back several times, at other places in every channel."""
    t = np.arange(SAMPLES)[:, None] + 0.3
    k = np.arange(channels)
    return 0.8 * np.sin(0.41 * t + k) + 0.37 * np.sin(0.17 * t + 2.0 * k) + 0.05 * k


def led(block: AbstractBlock, share: float = 1.0) -> list[AbstractBlock]:
    """The block adapted to a share of what polynomials before it make of the record.

    With 1 the greatest and least inputs are the ends of its range, with less they are beyond.
    """
    first = SideBySide(blocks=(Polynomial(degree=2.0),) * block.inputs)
    reaching = Engine([first], DT, compiled=False).simulate(numbers(first), record(block.inputs))
    return [first, block.adapted(share * reaching, DT)]


def numbers(block: AbstractBlock, seed: int = 3) -> np.ndarray:
    """Drawn free numbers, none of them exactly where a start leaves it."""
    rng = np.random.default_rng(seed)
    made = block.drawn(rng, SAMPLES * DT, DT)
    return made + 0.03 * rng.uniform(0.5, 1.0, len(made))


def error(blocks: list[AbstractBlock]) -> float:
    """Greatest difference of a derivative from a central difference, over those of its number."""
    theta = np.concatenate([numbers(block) for block in blocks])
    engine, u = Engine(blocks, DT, compiled=False), record(blocks[0].inputs)
    found = engine.jacobian(theta, u)[1]
    meant = np.empty_like(found)
    for i, number in enumerate(theta):
        step = 3e-6 * max(1.0, abs(number))
        ends = [theta.copy(), theta.copy()]
        ends[0][i] += step
        ends[1][i] -= step
        high, low = (engine.simulate(end, u) for end in ends)
        meant[:, :, i] = (high - low) / (ends[0][i] - ends[1][i])
    sizes = np.abs(meant).max(axis=(0, 1))
    return float((np.abs(found - meant).max(axis=(0, 1)) / (sizes + 1e-2 * sizes.max())).max())


class TestDerivatives:
    @BLOCK
    def test_they_are_those_of_the_simulation(self, name):
        if name in KINKED:
            assert error(led(example(name), 0.9)) <= 1e-6
        else:
            assert error(led(example(name))) <= 1e-7

    def test_one_that_is_left_out_is_noticed(self):
        class Deaf(Polynomial):
            def value(self, xp, theta, x):
                return super().value(xp, theta, xp.detach(x))

        assert error(led(Deaf())) > 0.1

    @IN_JAX
    def test_jax_finds_the_same_in_the_kernel(self, name):
        block = example(name)
        theta, u = numbers(block), record(block.inputs)[5:36:15]
        xp = jax_namespace()

        def run(theta):
            own = [theta[i] for i in range(len(block.numbers()))]
            rows, state = [], block.rest(xp, own, list(u[0]), DT)
            for x in u:
                y, state = block.step(xp, own, state, list(x), DT)
                rows.append(xp.np.stack([xp.np.asarray(v) for v in y]))
            return xp.np.stack(rows)

        meant = np.asarray(xp.jax.jacfwd(run)(xp.np.asarray(theta)))
        found = Engine([block], DT, compiled=False).jacobian(theta, u)[1]
        assert np.abs(found - meant).max() <= 1e-11 * max(1.0, np.abs(meant).max())


def groups() -> list[list[str]]:
    """Blocks that are compiled together: those without memory, which run in tiles, apart."""
    names = [n for n in BLOCKS.names() if n != "side-by-side" and n not in UNBOUNDED]
    parts = [[n for n in names if bool(example(n).states()) is memory] for memory in (True, False)]
    return [sorted(UNBOUNDED), *(part[i : i + 5] for part in parts for i in range(0, len(part), 5))]


@pytest.mark.parametrize("names", groups(), ids="+".join)
def test_c_runs_as_plain_python(names, c_compiler):
    blocks = led(SideBySide(blocks=tuple(example(name) for name in names)))
    u = record(blocks[0].inputs)
    fast, plain = Engine(blocks, DT, compiled=True), Engine(blocks, DT, compiled=False)
    theta = np.concatenate([numbers(block) for block in blocks])
    for found, meant in zip(fast.jacobian(theta, u), plain.jacobian(theta, u), strict=True):
        scale = np.abs(meant).max(axis=0)
        assert (np.abs(found - meant).max(axis=0) <= 1e-12 * (1.0 + scale)).all()
    if not UNBOUNDED & set(names):
        for seed in range(5):
            wild = np.random.default_rng(seed).uniform(-30.0, 30.0, len(theta))
            assert all(np.isfinite(part).all() for part in fast.jacobian(wild, u))


@BLOCK
class TestPromises:
    def test_sizes_are_as_declared(self, name):
        block = example(name)
        theta, x = list(numbers(block)), [0.2] * block.inputs
        state = block.rest(floats, theta, x, DT)
        y, after = block.step(floats, theta, state, x, DT)
        assert (len(y), len(state), len(after)) == (block.outputs, block.states(), block.states())
        assert len(set(block.numbers())) == len(theta) == len(block.start())
        assert len(block.given()) == len(block.fixed)
        assert [len(part) for part in block.priors()] == [len(theta)] * 2
        assert len(block.gains()) == block.outputs
        assert set(block.gains()) <= {"", *block.numbers()}

    def test_shown_are_words_numbers_and_units(self, name):
        block = example(name)
        for word, value, unit in block.shown(numbers(block)):
            assert word
            assert np.isfinite(value)
            assert unit

    def test_its_text_is_read_as_itself(self, name):
        assert parse_block(example(name).text()) == example(name)

    def test_fixed_numbers_are_no_structure(self, name):
        block = example(name)
        moved = block.adapted(3.0 + 2.0 * record(block.inputs), DT)
        assert moved.structure() == block.structure()
        assert moved.with_given(block.given()) == block

    def test_rest_stays_and_so_do_its_derivatives(self, name):
        blocks = led(example(name))
        theta = np.concatenate([numbers(block) for block in blocks])
        held = np.repeat(record(blocks[0].inputs)[7:8], 6, axis=0)
        for part in Engine(blocks, DT, compiled=False).jacobian(theta, held):
            assert np.abs(part - part[0]).max() <= 1e-9 * (1.0 + np.abs(part).max())

    def test_whatever_a_fit_proposes_can_be_simulated(self, name):
        if name in UNBOUNDED:
            pytest.skip("it may grow without bound, and says so")
        block = led(example(name))[-1]
        engine, u = Engine([block], DT, compiled=False), record(block.inputs)[:15]
        for seed in range(8):
            wild = np.random.default_rng(seed).uniform(-30.0, 30.0, len(block.numbers()))
            assert all(np.isfinite(part).all() for part in engine.jacobian(wild, u))

    @pytest.mark.parametrize(("factor", "level"), [(1.0, 300.0), (0.0, 4.0), (0.0, 0.0), (1e6, 0)])
    def test_it_starts_on_any_range(self, name, factor, level):
        block = example(name)
        u = level + factor * record(block.inputs)[:10]
        block = block.adapted(u, DT)
        engine = Engine([block], DT, compiled=False)
        assert all(np.isfinite(part).all() for part in engine.jacobian(block.start(), u))

    def test_draws_are_those_of_their_seed(self, name):
        block = example(name)
        draws = [block.drawn(np.random.default_rng(s), 10.0, DT) for s in (1, 1, 2)]
        assert np.array_equal(draws[0], draws[1])
        assert all(len(drawn) == len(block.numbers()) for drawn in draws)
        assert np.isfinite(draws).all()


@STATIC
class TestStatic:
    def test_a_line_is_that_line(self, name):
        block = example(name).with_parts(low=-2.0, high=5.0)
        theta = list(block.line(-1.7, 0.4))
        worst = 0.0
        for x in np.linspace(-2.0, 5.0, 15):
            (y,), _ = block.step(floats, theta, block.rest(floats, theta, [x], DT), [x], DT)
            worst = max(worst, abs(y - (0.4 - 1.7 * x)))
        assert worst <= (1e-5 if name == "dead-zone" else 1e-12)

    def test_without_offset_nothing_comes_of_nothing(self, name):
        block = example(name).with_parts(low=-2.0, high=5.0, offset="no")
        theta = list(numbers(block))
        state = block.rest(floats, theta, [0.0], DT)
        assert block.step(floats, theta, state, [0.0], DT)[0] == (0.0,)
        with_offset = block.with_parts(offset="yes")
        assert len(with_offset.numbers()) == len(theta) + 1

    def test_a_departure_is_scaled_with_the_line(self, name):
        block = example(name).with_parts(low=-2.0, high=5.0, offset="no")
        drawn = block.drawn(np.random.default_rng(5), 10.0, DT)
        line = block.line(1.0, 0.0)
        moved = block.line(-3.0, 0.0) + block.scaled(drawn - line, -3.0)
        x = np.linspace(-2.0, 5.0, 9)[:, None]
        first, second = (Engine([block], DT, compiled=False).simulate(t, x) for t in (drawn, moved))
        assert second == pytest.approx(-3.0 * first, abs=1e-12)
