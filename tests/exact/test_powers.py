"""Powers: values, edges and slopes on every runtime, against those in closed form."""

from __future__ import annotations

import math

import numpy as np
import pytest
from kernels import RUNTIMES, Kernel, on_lanes, traced

from martensite.base.parameters import Parametrised
from martensite.export.c_kernels import count_operations, precision_of
from martensite.kernels import floats
from martensite.kernels.dual import compute_jacobian, value_and_slope
from martensite.kernels.floats import expand_power, find_whole_exponent
from martensite.kernels.graph import VARYING
from martensite.kernels.partials import compute_gradient, compute_partials
from martensite.kernels.printer import Printer
from martensite.kernels.program import Program
from martensite.kernels.slopes import differentiate_program

RNG = np.random.default_rng(5)
POINTS = np.column_stack([RNG.uniform(0.05, 20.0, 48), RNG.uniform(-4.0, 4.0, 48)])
EDGES = [
    (0.0, 0.5, 0.0),
    (0.0, 0.0, 0.0),
    (0.0, -1.0, 0.0),
    (-2.0, 2.0, 0.0),
    (-2.0, -1.0, 0.0),
    (1.0, 1e9, 1.0),
    (10.0, 400.0, floats.LARGEST),
    (0.1, -400.0, floats.LARGEST),
    (10.0, -400.0, 0.0),
    (1e-300, 0.5, 1e-150),
    (5.0, 0.0, 1.0),
]
"""Base, exponent, power."""


@pytest.fixture(params=[*RUNTIMES, "c lanes"])
def runtime(request: pytest.FixtureRequest):
    if request.param.startswith("c"):
        request.getfixturevalue("c_compiler")
    return {**RUNTIMES, "c lanes": on_lanes}[request.param]


def one_power(_, xp, base, exponent):
    return (xp.power(base, exponent),)


KERNEL = Kernel({"base": (0.0, 20.0), "exponent": (-4.0, 4.0)}, one_power)


def test_values(runtime) -> None:
    found = runtime(Parametrised(), KERNEL, np.ascontiguousarray(POINTS.T))
    assert found[0] == pytest.approx(np.power(*POINTS.T), rel=2e-15)


def test_edges(runtime) -> None:
    bases, exponents, meant = np.resize(EDGES, (16, 3)).T  # lanes come in sixteens
    found = runtime(Parametrised(), KERNEL, np.array([bases, exponents]))
    assert found[0] == pytest.approx(meant, rel=1e-12, abs=0.0)


@pytest.mark.parametrize("runtime", [r for r in [*RUNTIMES, "c lanes"] if r != "numpy"], indirect=True)
def test_whole_powers_are_products_to_the_last_bit(runtime) -> None:
    """Where a kernel is traced; arrays and floats by themselves have a power of their own."""

    def both_ways(_, xp, a, b):
        written = a**3, a**-2, b**5, a**0 + b, xp.power(b, 3), xp.power(a, -1), a**2.0
        c, d = a * a, b * b
        return (*written, a * c, 1.0 / c, b * (d * d), 1.0 + b, b * d, 1.0 / a, c)

    kernel = Kernel({"a": (0.1, 9.0), "b": (-9.0, 9.0)}, both_ways)
    found = runtime(Parametrised(), kernel, kernel.inputs())
    assert (found[:7] == found[7:]).all()


@pytest.mark.parametrize("exponent", range(-9, 10))
def test_whole_powers_are_powers(exponent: int) -> None:
    assert expand_power(1.7, exponent) == pytest.approx(1.7**exponent, rel=1e-15)
    assert expand_power(-1.7, exponent) == pytest.approx((-1.7) ** exponent, rel=1e-15)
    assert floats.power(-1.7, exponent) == expand_power(-1.7, exponent)


def test_whole_exponents_are_found() -> None:
    given = [3, 3.0, np.int64(3), np.float64(3.0), 0.5, math.inf, math.nan, "3"]
    assert [find_whole_exponent(x) for x in given] == [3, 3, 3, 3, None, None, None, None]


# ---------------------------------------------------------------- slopes


def slopes(base: float, exponent: float) -> tuple[float, float]:
    """∂/∂b and ∂/∂e of b^e, in closed form."""
    return exponent * base ** (exponent - 1.0), base**exponent * math.log(base)


MEANT = np.array([slopes(*point) for point in POINTS.tolist()])


def test_slopes_are_those_of_differences() -> None:
    step = 1e-6
    for (base, exponent), (by_base, by_exponent) in zip(POINTS.tolist(), MEANT, strict=True):
        h = step * base
        along = (floats.power(base + h, exponent) - floats.power(base - h, exponent)) / (2.0 * h)
        up = floats.power(base, exponent + step) - floats.power(base, exponent - step)
        assert along == pytest.approx(by_base, rel=1e-7, abs=1e-9)
        assert up / (2.0 * step) == pytest.approx(by_exponent, rel=1e-7, abs=1e-9)


def by_duals(base: float, exponent: float) -> list[float]:
    _, rows = compute_jacobian(floats, lambda xp, x: [xp.power(x[0], x[1])], [base, exponent])
    return rows[0]


def test_dual_numbers() -> None:
    assert np.array([by_duals(*p) for p in POINTS.tolist()]) == pytest.approx(MEANT, rel=1e-13)


def traced_slopes(backwards: bool):
    program = Program()
    moving = [program.graph.input(f"k_{name}", VARYING) for name in "be"]
    (value,), (ahead,) = compute_partials([program.xp.power(*moving)], moving)
    row = compute_gradient(value, moving) if backwards else ahead
    assert row is not None
    program.add("k", ("b", "e"), lambda xp, b, e: (row[0], row[1]))
    return program.bind_floats()["k"]


@pytest.mark.parametrize("backwards", [False, True], ids=["partials", "adjoint"])
def test_traced_slopes(backwards: bool) -> None:
    function = traced_slopes(backwards)
    found = np.array([function(*point) for point in POINTS.tolist()])
    assert found == pytest.approx(MEANT, rel=1e-13)
    assert function(0.0, 0.5) == function(-1.0, 2.0) == (0.0, 0.0)


def test_slopes_ahead_of_a_traced_function() -> None:
    program = Program()
    program.add("step", ("b", "e"), lambda xp, b, e: (xp.power(b, e),))
    twin = differentiate_program(program, [], {"step": 2}, [])
    function = twin.functions["step"]
    function.inputs = ("step_b", "step_e", "dstep_b", "dstep_e")
    program.functions = {"step": function}
    step = program.bind_floats()["step"]
    for point, (by_base, by_exponent) in zip(POINTS.tolist(), MEANT, strict=True):
        assert step(*point, 1.0, 0.0)[1] == pytest.approx(by_base, rel=1e-13)
        assert step(*point, 0.0, 1.0)[1] == pytest.approx(by_exponent, rel=1e-13)


def test_slopes_are_none_where_the_base_is_not_positive() -> None:
    for base in (0.0, -3.0):
        for exponent in (0.5, 1.0, 2.0, -1.0):
            assert by_duals(base, exponent) == [0.0, 0.0]


def test_second_slopes() -> None:
    def slope(xp, x):
        return value_and_slope(xp, lambda xp, x: xp.power(x, 2.5), x)[1]

    for x in (0.3, 1.0, 7.0):
        found = value_and_slope(floats, slope, x)
        assert found == pytest.approx((2.5 * x**1.5, 3.75 * x**0.5), rel=1e-13)


def test_slopes_of_whole_powers() -> None:
    for x in (-2.0, -0.1, 3.0):
        for n in (-2, 1, 2, 5):
            found = value_and_slope(floats, lambda xp, x, n=n: x**n, x)
            assert found == pytest.approx((x**n, n * x ** (n - 1)), rel=1e-14)


# ---------------------------------------------------------------- traced, printed, counted


def test_a_power_is_one_operation_and_a_constant_one_none() -> None:
    program = traced(Parametrised(), KERNEL)
    assert program.graph.operations.count("power") == 1
    counted = count_operations(program.graph, program.functions["kernel"].outputs)
    assert counted == {"power": 1, "compare": 2, "select": 2}
    folded = Program()
    folded.add("k", (), lambda xp: (xp.power(2.0, 0.5), xp.power(3.0, 2)))
    values = [folded.graph.value_of(node) for node in folded.functions["k"].outputs]
    assert values == [math.sqrt(2.0), 9.0]


@pytest.mark.parametrize(("precision", "word"), [("float64", "pow("), ("float32", "powf(")])
def test_c_for_controllers_takes_the_function_of_its_type(precision: str, word: str) -> None:
    program = traced(Parametrised(), KERNEL)
    printer = Printer(program.graph, precision_of(precision).dialect("x_"))
    _, (text,) = printer.block(program.functions["kernel"].outputs)
    assert text.count(word) == 1
