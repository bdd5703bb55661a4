"""Suite for blocks of a model: sizes, derivatives, steady state, parameters of a fit.

Derivatives are compared with central differences of the simulation, sizes with the declarations.
"""

import numpy as np
from numpy.typing import NDArray

from martensite.identify.blocks.base import AbstractBlock, AbstractStatic
from martensite.identify.blocks.polynomial import Polynomial
from martensite.identify.blocks.side_by_side import SideBySide
from martensite.identify.chains.chain_text import parse_block
from martensite.identify.chains.engine import ChainEngine
from martensite.kernels import floats
from martensite.testing.conformance import require_condition

DT, SAMPLES = 0.05, 40
RANGES = ((1.0, 300.0), (0.0, 4.0), (0.0, 0.0), (1e6, 0.0))
"""Scale and offset of records on which a block must be able to start."""
Array = NDArray[np.float64]


def make_record(channels: int) -> Array:
    """Return inputs (sample, channel) that reverse several times, at different times in each channel."""
    t = np.arange(SAMPLES)[:, None] + 0.3
    k = np.arange(channels)
    return 0.8 * np.sin(0.41 * t + k) + 0.37 * np.sin(0.17 * t + 2.0 * k) + 0.05 * k


def draw_numbers(block: AbstractBlock, seed: int = 3) -> Array:
    """Return random free parameters, all different from the start values."""
    rng = np.random.default_rng(seed)
    parameters = block.sample_parameters(rng, SAMPLES * DT, DT)
    return parameters + 0.03 * rng.uniform(0.5, 1.0, len(parameters))


def lead_block(block: AbstractBlock, share: float = 1.0) -> list[AbstractBlock]:
    """Return polynomials followed by the block, which is adapted to a multiple of its input.

    With 1 the extreme inputs are the ends of its range; with less they lie outside.
    """
    first = SideBySide(blocks=(Polynomial(degree=2.0),) * block.inputs)
    engine = ChainEngine([first], DT, compiled=False)
    reaching = engine.simulate(draw_numbers(first), make_record(block.inputs))
    return [first, block.adapt_to(share * reaching, DT)]


def find_slope_error(blocks: list[AbstractBlock]) -> float:
    """Return the largest relative error of a derivative, compared with central differences."""
    theta = np.concatenate([draw_numbers(block) for block in blocks])
    engine, u = ChainEngine(blocks, DT, compiled=False), make_record(blocks[0].inputs)
    exact = engine.jacobian(theta, u)[1]
    differences = np.empty_like(exact)
    for i, value in enumerate(theta):
        step = 3e-6 * max(1.0, abs(value))
        ends = [theta.copy(), theta.copy()]
        ends[0][i] += step
        ends[1][i] -= step
        high, low = (engine.simulate(end, u) for end in ends)
        differences[:, :, i] = (high - low) / (ends[0][i] - ends[1][i])
    sizes = np.abs(differences).max(axis=(0, 1))
    return float((np.abs(exact - differences).max(axis=(0, 1)) / (sizes + 1e-2 * sizes.max())).max())


def list_unusual(block: AbstractBlock) -> set[str]:
    """Return the names of options that differ from their defaults."""
    options = {n: d.default for n, d in block.declarations.items() if d.kind == "option"}
    return {name for name, usual in options.items() if getattr(block, name) != usual}


def check_sizes(block: AbstractBlock) -> None:
    """A block has the declared number of outputs, states and parameters."""
    theta, x = draw_numbers(block).tolist(), [0.2] * block.inputs
    state = block.rest(floats, theta, x, DT)
    y, after = block.step(floats, theta, state, x, DT)
    sizes = {
        "outputs": (len(y), block.outputs),
        "states at rest": (len(state), block.states()),
        "states after a sample": (len(after), block.states()),
        "names of numbers": (len(set(block.numbers())), len(theta)),
        "numbers to start with": (len(block.start()), len(theta)),
        "fixed numbers": (len(block.fixed_values()), len(block.fixed)),
        "priors": (len(block.priors()[0]), len(theta)),
        "weights of priors": (len(block.priors()[1]), len(theta)),
        "gains": (len(block.gains()), block.outputs),
    }
    for name, (one, other) in sizes.items():
        require_condition(one == other, f"There are {one} {name}, but it says {other}.")
    unknown = set(block.gains()) - {"", *block.numbers()}
    require_condition(not unknown, f"Its gain {', '.join(unknown)} is none of its numbers.")


def check_slopes(block: AbstractBlock) -> None:
    """Its derivatives are the derivatives of the simulation."""
    error = find_slope_error(lead_block(block, 0.9))
    require_condition(error <= 1e-6, f"A slope is wrong by {error:.2g} of its size.")


def check_words(block: AbstractBlock) -> None:
    """Its parameters have names, values and units; its text is parsed to the same block."""
    for word, value, unit in block.describe_numbers(draw_numbers(block)):
        whole = bool(word and unit and np.isfinite(value))
        require_condition(whole, f"It shows `{word}`, {value}, `{unit}`.")
    if not list_unusual(block) - set(block.shape):
        same = parse_block(block.text()) == block
        require_condition(same, f"Its text `{block.text()}` is read as another block.")


def check_fixed(block: AbstractBlock) -> None:
    """Values taken from a record do not change its structure."""
    moved = block.adapt_to(3.0 + 2.0 * make_record(block.inputs), DT)
    same = moved.structure() == block.structure() and moved.with_fixed_values(block.fixed_values()) == block
    require_condition(same, "Adapted to a record it has another structure.")


def check_rest(block: AbstractBlock) -> None:
    """Under a constant input from the steady state, output and derivatives are constant."""
    blocks = lead_block(block)
    theta = np.concatenate([draw_numbers(one) for one in blocks])
    inputs = np.repeat(make_record(blocks[0].inputs)[7:8], 6, axis=0)
    for part in ChainEngine(blocks, DT, compiled=False).jacobian(theta, inputs):
        apart = np.abs(part - part[0]).max()
        constant = apart <= 1e-9 * (1.0 + np.abs(part).max())
        require_condition(constant, f"Under a constant input it moves by {apart:.2g}.")


def check_wild_numbers(block: AbstractBlock) -> None:
    """A block that is declared bounded stays finite for any parameters."""
    if not block.bounded:
        return
    led = lead_block(block)[-1]
    engine, u = ChainEngine([led], DT, compiled=False), make_record(block.inputs)[:15]
    for seed in range(8):
        wild = np.random.default_rng(seed).uniform(-30.0, 30.0, len(block.numbers()))
        finite = all(np.isfinite(part).all() for part in engine.jacobian(wild, u))
        require_condition(finite, f"With the numbers {wild.round(2).tolist()} it is not finite.")


def check_start(block: AbstractBlock) -> None:
    """A block starts on any range of its input, and draws the same parameters from the same seed."""
    for factor, level in RANGES:
        u = level + factor * make_record(block.inputs)[:10]
        adapted = block.adapt_to(u, DT)
        engine = ChainEngine([adapted], DT, compiled=False)
        finite = all(np.isfinite(part).all() for part in engine.jacobian(adapted.start(), u))
        require_condition(finite, f"On a record of {level:g} ± {factor:g} it is not finite.")
    draws = [block.sample_parameters(np.random.default_rng(s), 10.0, DT) for s in (1, 1, 2)]
    same = np.array_equal(draws[0], draws[1]) and bool(np.isfinite(draws).all())
    require_condition(same, "Numbers drawn twice from one seed differ, or are not finite.")


def check_line(block: AbstractStatic) -> None:
    """Without memory: a block set to a line is the line; without offset, 0 gives 0."""
    if list_unusual(block):
        return
    block = block.with_parts(low=-2.0, high=5.0)
    theta = block.line(-1.7, 0.4).tolist()
    for x in np.linspace(-2.0, 5.0, 15).tolist():
        (y,), _ = block.step(floats, theta, block.rest(floats, theta, [x], DT), [x], DT)
        equal = abs(y - (0.4 - 1.7 * x)) <= 1e-5
        require_condition(equal, f"As the line 0.4 - 1.7 x it is {y:.6g} at {x:g}.")
    bare = block.with_parts(offset="no")
    numbers = draw_numbers(bare).tolist()
    state = bare.rest(floats, numbers, [0.0], DT)
    (zero,), _ = bare.step(floats, numbers, state, [0.0], DT)
    require_condition(zero == 0.0, f"Without offset an input of 0 gives {zero:.4g}.")
    free = len(block.with_parts(offset="yes").numbers()) == len(numbers) + 1
    require_condition(free, "Its offset is not one more number.")


def check_scaling(block: AbstractStatic) -> None:
    """Without memory: the deviation from a line scales with the line."""
    if list_unusual(block) - {"offset"}:
        return
    block = block.with_parts(low=-2.0, high=5.0, offset="no")
    parameters = block.sample_parameters(np.random.default_rng(5), 10.0, DT)
    moved = block.line(-3.0, 0.0) + block.scale_departure(parameters - block.line(1.0, 0.0), -3.0)
    x = np.linspace(-2.0, 5.0, 9)[:, None]
    first, second = (ChainEngine([block], DT, compiled=False).simulate(t, x) for t in (parameters, moved))
    equal = np.allclose(second, -3.0 * first, rtol=1e-9, atol=1e-12)
    require_condition(equal, "Scaled by -3 its output is not -3 times as large.")
