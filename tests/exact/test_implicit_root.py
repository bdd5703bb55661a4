"""Roots that are differentiated as one step of Newton's method, on every runtime.

Sources of truth: the derivatives of implicit functions in closed form: where x³ + a x = b,

    ∂x/∂a = -x/(3 x² + a),        ∂x/∂b = 1/(3 x² + a)

and differences where roots are part of a longer calculation. Derivatives in C are those of
fits: printed by `slopes_source`, in four directions beside the values.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import pytest

from martensite.kernels import floats
from martensite.kernels.arrays import ArrayNamespace
from martensite.kernels.bracketed_newton import solve_bracketed
from martensite.kernels.c99 import slopes_source
from martensite.kernels.compiler import call_compiled, load_library
from martensite.kernels.dual import DualNamespace, value_and_slope, values_and_slopes
from martensite.kernels.program import Program
from martensite.kernels.slopes import differentiate_program

TURNS = 24
Kernel = Callable[..., Sequence[Any]]
"""(namespace, a, b) -> numbers."""


# ---------------------------------------------------------------- kernels


def newton_step(xp: Any, x: Any, a: Any, b: Any) -> Any:
    return x - (x * x * x + a * x - b) / (3.0 * x * x + a)


def cube(xp: Any, a: Any, b: Any, count: int = TURNS) -> Any:
    """The root of x³ + a x = b."""
    (root,) = xp.repeat(count, lambda x: (newton_step(xp, x, a, b),), 1.0)
    at = xp.detach(root)
    slope = xp.detach(3.0 * at * at + a)
    return xp.implicit_root(root, at - (at * at * at + a * at - b) / slope)


def plain(xp: Any, a: Any, b: Any) -> Sequence[Any]:
    return (cube(xp, a, b),)


def bracketed(xp: Any, a: Any, b: Any, iterations: int = TURNS) -> Sequence[Any]:
    def function(xp: Any, x: Any) -> Any:
        return x * x * x + a * x - b

    return (solve_bracketed(xp, function, 0.5, (0.0, 3.0), iterations),)


def beside(xp: Any, a: Any, b: Any) -> Sequence[Any]:
    """A root that is wanted beside one that is not."""
    (root,) = bracketed(xp, a, b)
    none = solve_bracketed(xp, lambda xp, x: x - a, 0.0, (0.0, 9.0), wanted=a < 0.0)
    return (root + xp.where(a < 0.0, none, 0.0),)


def in_rows(xp: Any, a: Any, b: Any) -> Sequence[Any]:
    """Roots of several rows, one of which has no derivative in b."""
    roots, twice = xp.each(lambda p, q: (cube(xp, p, q), 2.0 * p * cube(xp, a, q)), (a, 2.0 * a, 3.0), (b, b * b, 1.5))
    return [*roots, sum(twice)]


def in_turns(xp: Any, a: Any, b: Any) -> Sequence[Any]:
    """A root in every turn of a loop, which also moves what is constant at first."""
    return xp.repeat(TURNS, lambda x, y: (0.3 * y + cube(xp, a + 0.1 * x, b, 8), 0.5 * (x + y)), 0.0, 1.0)


def of_a_slope(xp: Any, a: Any, b: Any) -> Sequence[Any]:
    """A root of a function that contains a slope: dual numbers inside."""

    def function(xp: Any, x: Any) -> Any:
        _, slope = value_and_slope(xp, lambda xp, y: 0.25 * y * y * y * y + 0.5 * a * y * y, x)
        return slope - b

    return (solve_bracketed(xp, function, 0.5, (0.0, 3.0), TURNS),)


ROOTS: dict[str, Kernel] = {"repeat": plain, "bracket": bracketed, "beside": beside, "slope": of_a_slope}
LONGER: dict[str, Kernel] = {"each": in_rows, "in turns": in_turns}


# ---------------------------------------------------------------- derivatives on runtimes


def on_duals(kernel: Kernel, a: float, b: float) -> tuple[np.ndarray, np.ndarray]:
    found = [values_and_slopes(floats, lambda xp, x: kernel(xp, x, b), a)]
    found += [values_and_slopes(floats, lambda xp, x: kernel(xp, a, x), b)]
    return np.array(found[0][0]), np.array([slopes for _, slopes in found]).T


def on_dual_arrays(kernel: Kernel, a: float, b: float) -> tuple[np.ndarray, np.ndarray]:
    xp: Any = ArrayNamespace(np)
    here: Any = np.array([a, 2.0])
    there: Any = np.array([b, 1.0])
    values, by_a = values_and_slopes(xp, lambda xp, x: kernel(xp, x, there), here)
    _, by_b = values_and_slopes(xp, lambda xp, x: kernel(xp, here, x), there)
    first = [[np.broadcast_to(x, 2)[0] for x in row] for row in (values, by_a, by_b)]
    return np.array(first[0]), np.array(first[1:]).T


_ENTRY = """
void run(const double *p, const slopes *dp, const double *x, const slopes *dx,
         double *y, slopes *dy) {{
    double c[{}];
    slopes dc[{}];
    k_prepare(p, dp, c, dc);
    k_kernel(c, dc, x, dx, y, dy);
}}
"""
WIDTH = 4


def on_c(kernel: Kernel, a: float, b: float) -> tuple[np.ndarray, np.ndarray]:
    """With `a` as a parameter and `b` as an input."""
    program = Program()
    node = program.parameter("a")
    program.add("kernel", ["b"], lambda xp, b: kernel(xp, node, b))
    twin = differentiate_program(program, [0], {"kernel": 1}, ())
    entry = _ENTRY.format(twin.constants, twin.constant_slopes)
    functions = list(twin.functions.values())
    library = load_library(slopes_source(twin, functions, [0], WIDTH) + entry)
    outputs = len(program.functions["kernel"].outputs)
    y, dy = np.empty(outputs), np.empty((outputs, WIDTH))
    directions = np.eye(2, WIDTH)
    arrays = (np.array([a]), directions[:1].copy(), np.array([b]), directions[1:].copy(), y, dy)
    call_compiled(library.run, *arrays)
    return y, dy[:, :2]


RUNTIMES = {"duals": on_duals, "arrays": on_dual_arrays, "c": on_c}
PLACES = [(1.0, 2.0), (0.3, 0.1), (2.0, 5.0)]


@pytest.fixture(params=list(RUNTIMES))
def runtime(request: pytest.FixtureRequest) -> Any:
    if request.param == "c":
        request.getfixturevalue("c_compiler")
    return RUNTIMES[request.param]


def exact(a: float, b: float) -> tuple[float, list[float]]:
    """Root, and its derivatives in a and b."""
    roots = np.roots([1.0, 0.0, a, -b])
    x = float(roots[np.abs(roots.imag) < 1e-9].real[0])
    return x, [-x / (3.0 * x * x + a), 1.0 / (3.0 * x * x + a)]


@pytest.mark.parametrize("name", ROOTS)
def test_a_root_has_the_derivatives_of_an_implicit_function(name: str, runtime: Any) -> None:
    for a, b in PLACES:
        root, slopes = exact(a, b)
        values, found = runtime(ROOTS[name], a, b)
        assert values == pytest.approx([root], rel=1e-12)
        assert found[0] == pytest.approx(slopes, rel=1e-12)


@pytest.mark.parametrize("name", LONGER)
def test_roots_in_loops_have_the_derivatives_of_differences(name: str, runtime: Any) -> None:
    kernel, (a, b) = LONGER[name], PLACES[0]

    def run(a: float, b: float) -> np.ndarray:
        return np.array(kernel(floats, a, b))

    h = 1e-3
    ways = [(h, 0.0), (0.0, h)]
    one, two = (
        np.array([(run(a + s * p, b + s * q) - run(a - s * p, b - s * q)) / (2 * s * h) for p, q in ways]).T
        for s in (1.0, 2.0)
    )
    values, found = runtime(kernel, a, b)
    assert values == pytest.approx(run(a, b), rel=1e-13)
    assert found == pytest.approx((4.0 * one - two) / 3.0, abs=1e-9)
    assert np.median(np.abs(found)) > 0.1


def test_the_value_is_the_root_wherever_the_step_leads(runtime: Any) -> None:
    def kernel(xp: Any, a: Any, b: Any) -> Sequence[Any]:
        return (xp.implicit_root(a * b, 7.0 * a - b), xp.implicit_root(3.0, b), xp.implicit_root(b, 3.0))

    values, found = runtime(kernel, 2.0, 5.0)
    assert values.tolist() == [10.0, 3.0, 5.0]
    assert found[0].tolist() == [7.0, -1.0]
    assert found[2].tolist() == [0.0, 0.0]


def test_what_leads_to_a_root_is_not_differentiated(runtime: Any) -> None:
    """The iterations may have any slope."""

    def kernel(xp: Any, a: Any, b: Any) -> Sequence[Any]:
        root, _ = xp.repeat(TURNS, lambda x, y: (x + 1e9 * b * (y - a), a), 0.5 * a * b, a)
        return (xp.implicit_root(root, xp.detach(root) + 0.5 * b),)

    values, found = runtime(kernel, 2.0, 5.0)
    assert values.tolist() == [5.0]
    assert found[0].tolist() == [0.0, 0.5]


# ---------------------------------------------------------------- derivatives of derivatives


def marked(xp: Any, a: Any, b: Any) -> Any:
    """A root whose step has known derivatives of every order."""
    return xp.implicit_root(xp.detach(a + b), xp.sin(a * b))


def by_a(xp: Any, a: Any, b: Any) -> Sequence[Any]:
    """Value and slope in a, by dual numbers."""
    return value_and_slope(xp, lambda xp, a: marked(xp, a, b), a)


def test_derivatives_nest(runtime: Any) -> None:
    """∂N/∂a, and of it ∂/∂a and ∂/∂b, for N = sin ab."""
    a, b = 0.7, 1.3
    values, found = runtime(by_a, a, b)
    s, c = np.sin(a * b), np.cos(a * b)
    assert values == pytest.approx([a + b, b * c], rel=1e-14)
    assert found[0] == pytest.approx([b * c, a * c], rel=1e-14)
    assert found[1] == pytest.approx([-b * b * s, c - a * b * s], rel=1e-14)


def test_each_level_of_duals_has_its_own_slope() -> None:
    """The root of one level is a constant to the other."""
    inner: Any = DualNamespace(floats)
    outer: Any = DualNamespace(inner)
    a, b = PLACES[0]
    x = cube(outer, inner.pair(a, 1.0), outer.pair(b, 1.0))
    value, by_outer = outer.parts(x)
    value, by_inner = inner.parts(value)
    root, slopes = exact(a, b)
    assert value == pytest.approx(root, rel=1e-13)
    assert [by_inner, inner.parts(by_outer)[0]] == pytest.approx(slopes, rel=1e-13)
