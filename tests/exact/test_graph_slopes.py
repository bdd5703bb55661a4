"""Derivatives of a traced graph, in both directions, are those of dual numbers on floats."""

import numpy as np
import pytest

from martensite.identify.blocks.polynomial import Polynomial
from martensite.kernels import floats
from martensite.kernels.bracketed_newton import solve_bracketed
from martensite.kernels.dual import compute_jacobian
from martensite.kernels.graph import VARYING
from martensite.kernels.partials import compute_gradient, compute_partials
from martensite.kernels.program import Function, Program

RNG = np.random.default_rng(1)


def everything(xp, v):
    """All operations, kinks and choices among them."""
    a, b, c = v
    choice = xp.where(a < b, xp.sin(a * b), xp.cos(c) / (1.0 + b * b))
    smooth = xp.exp(-a * a) + xp.log(1.0 + c * c) + xp.tanh(b - c) + xp.sqrt(xp.abs(a) + 0.1)
    kinked = xp.minimum(a, c) * xp.maximum(b, 0.0) + xp.clip(c, -0.5, 0.5)
    inside = xp.clip(0.5 + 0.2 * a, 0.0, 1.0)
    special = xp.quarter_sine(inside) + xp.erfcx(xp.abs(b))
    special = special + xp.power(inside, b) + xp.power(c, 1.5) + a**3 * b**-2
    held = xp.detach(a) * b + c * a
    return [choice + smooth - kinked + special + held + xp.implicit_root(a, a - (a * a - b) / 2.0)]


def both_ways(kernel, count):
    program = Program()
    moving = [program.graph.input(f"x{i}", VARYING) for i in range(count)]
    values, (ahead,) = compute_partials(kernel(program.xp, moving), moving)
    back = compute_gradient(values[0], moving)
    assert back is not None
    for name, slopes in (("ahead", ahead), ("back", back)):
        row = tuple(slopes.get(i, program.graph.constant(0.0)) for i in range(count))
        program.functions[name] = Function(name, tuple(f"x{i}" for i in range(count)), row)
    functions = program.bind_floats()
    return functions["ahead"], functions["back"]


def test_all_operations():
    ahead, back = both_ways(everything, 3)
    for point in RNG.uniform(-2.0, 2.0, (50, 3)):
        assert back(*point) == pytest.approx(ahead(*point), rel=1e-12, abs=1e-13)


def looped(xp, v):
    """Rows, turns and a search for a root, in and around each other."""
    a, b = v
    turned = list(xp.repeat(3, lambda s, t: [0.5 * s + a, xp.sin(t) * b], a, 1.0))
    (still,) = xp.repeat(2, lambda s: [xp.exp(s)], 0.1)

    def row(x, y):
        root = solve_bracketed(xp, lambda xp, z: z * z * z + (1.0 + x * x) * z - y * b, 0.0, (-20.0, 20.0))
        return [root * a, xp.repeat(2, lambda s: [s * y + root], x)[0]]

    first, second = xp.each(row, [a, 2.0, turned[0]], [0.5, b, turned[1]])
    return [first[0] + first[2] * still, second[0] * second[1] + second[2], *turned]


def test_loops_are_written_out():
    program = Program()
    moving = [program.graph.input(f"x{i}", VARYING) for i in range(2)]
    values, rows = compute_partials(list(looped(program.xp, moving)), moving)
    zero = program.graph.constant(0.0)
    slopes = tuple(row.get(i, zero) for row in rows for i in range(2))
    program.functions["f"] = Function("f", ("x0", "x1"), (*values, *slopes))
    found = program.bind_floats()["f"]
    for point in RNG.uniform(0.2, 1.5, (20, 2)).tolist():
        meant, jacobian = compute_jacobian(floats, looped, point)
        numbers = found(*point)
        assert numbers[:4] == pytest.approx(meant, rel=1e-12)
        assert np.reshape(numbers[4:], (4, 2)) == pytest.approx(np.array(jacobian), rel=1e-9)


def test_what_does_not_count_is_left_out():
    program = Program()
    a, b = (program.graph.input(name, VARYING) for name in "ab")
    found = compute_gradient(program.graph.apply("exp", a), [a, b])
    assert found is not None
    assert set(found) == {0}
    assert compute_gradient(program.graph.constant(2.0), [a, b]) == {}


def test_loops_are_not_gone_through():
    program = Program()
    a = program.graph.input("a", VARYING)
    (value,) = program.xp.repeat(3, lambda x: [0.5 * x + a], a)
    assert compute_gradient(value, [a]) is None


def test_a_block():
    block = Polynomial(degree=4, low=-1.0, high=2.0)

    def kernel(xp, v):
        return [block.value(xp, v[1:], v[0])]

    ahead, back = both_ways(kernel, 6)
    point = RNG.uniform(-1.0, 1.0, 6)
    assert back(*point) == pytest.approx(ahead(*point), rel=1e-12)
