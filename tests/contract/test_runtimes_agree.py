"""Every kernel of every registered class means the same on floats, arrays and in C."""

import builders
import kernels
import numpy as np
import pytest
from builders import label
from kernels import (
    KERNELS,
    RUNTIMES,
    Kernel,
    disagreement,
    on_c,
    on_floats,
    on_kernel_itself,
    on_lanes,
    on_numpy,
    traced,
)

from martensite.base.parameters import Parametrised
from martensite.kernels.c99 import c_source
from martensite.kernels.dual import value_and_slope
from martensite.kernels.program import Program
from martensite.physics.laws.strip_laws import LiangRogers

TOLERANCE = 1e-12
SOLVED_TWICE = {"element": 5.0}
"""Kinds whose start is a solve as well, from which the step goes on: so many times the tolerance."""


@pytest.fixture(params=[*RUNTIMES, "c lanes"])
def runtime(request):
    if request.param.startswith("c"):
        request.getfixturevalue("c_compiler")
    return {**RUNTIMES, "c lanes": on_lanes}[request.param]


EVERY = [(kind, cls, f"{kind}-{cls.registered_name}") for kind in KERNELS for cls in builders.registered(kind)]
CLASSES = [pytest.param(kind, cls, id=name) for kind, cls, name in EVERY]
VARIED = [row for row in EVERY if any(one.kind == "option" for one in row[1].declarations.values())]
"""Classes of several forms."""
LONG = {"axial-wire", "ribbon", "hand"}
"""Of many elements: what only traces in long, and what C says of it, is enough."""
FEW = 24
"""Lanes on which kernels are tried untraced, one by one."""


def require_agreement(thing, kind, name, runtime, meaning=on_kernel_itself, lanes=None):
    """Raise unless a kernel on a runtime means what it does untraced, on plain floats or arrays."""
    kernel = KERNELS[kind][name]
    inputs = kernel.inputs()[:, :lanes]
    meant = meaning(thing, kernel, inputs)
    assert np.isfinite(meant).all(), (label(thing), name)
    found = runtime(thing, kernel, inputs)
    assert disagreement(meant, found) <= SOLVED_TWICE.get(kind, 1.0) * TOLERANCE, (label(thing), name)
    program = traced(thing, kernel)
    assert all(node.graph is program.graph for node in program.functions["kernel"].outputs)


@pytest.mark.parametrize(("kind", "cls"), CLASSES)
def test_every_kernel_is_the_same_traced_on_arrays_and_in_c(kind, cls, c_compiler):
    """Of the first form of a class. On all lanes arrays say what C is to say, for on some they are what floats say."""
    thing, long = builders.variants(cls)[0], cls.registered_name in LONG
    for name in KERNELS[kind]:
        for runtime in () if long else (on_floats, on_numpy):
            require_agreement(thing, kind, name, runtime, lanes=FEW)
        require_agreement(thing, kind, name, on_c, on_kernel_itself if long else on_numpy)


@pytest.mark.parametrize(("kind", "cls"), [pytest.param(k, c, marks=pytest.mark.slow, id=i) for k, c, i in VARIED])
def test_kernels_of_other_forms_are_the_same_in_c(kind, cls, c_compiler):
    meaning = on_kernel_itself if cls.registered_name in LONG else on_numpy
    for thing in builders.variants(cls)[1:]:
        for name in KERNELS[kind]:
            require_agreement(thing, kind, name, on_c, meaning)


@pytest.mark.slow
@pytest.mark.parametrize(("kind", "cls"), [pytest.param(k, c, id=i) for k, c, i in VARIED])
def test_kernels_of_other_forms_are_the_same_traced(kind, cls):
    """What is printed in Python is printed in C: operations are compared above, one by one."""
    for thing in builders.variants(cls)[1:] if cls.registered_name not in LONG else []:
        for name in KERNELS[kind]:
            require_agreement(thing, kind, name, on_floats, on_numpy, lanes=FEW)


def operations(_, xp, a, b, share):
    """Every operation a kernel may use, on its whole domain and beyond."""
    flag, other = a < b, xp.negate(b <= 0.0)
    return (
        a + b,
        a - b,
        a * b,
        a / (1.0 + b * b),
        -a,
        xp.where(flag, a, b),
        xp.where(xp.both(flag, other), a, b),
        xp.where(xp.either(flag, other), a, b),
        xp.where(a > b, 1.0, b),
        xp.where(a >= b, a, 0.0),
        xp.minimum(a, b),
        xp.maximum(a, b),
        xp.clip(a, -1.0, share),
        xp.abs(a),
        xp.sqrt(a),
        xp.exp(0.1 * a),
        xp.exp(1e3 * a),
        xp.log(a),
        xp.sin(a),
        xp.cos(a),
        xp.tanh(b),
        xp.nearest(3.0 * a),
        xp.quarter_sine(share),
        xp.detach(a),
        xp.erfcx(share),
        xp.erfcx(9.0 * xp.abs(a)),
        xp.power(share, b),
        xp.power(a, 0.5 * b),
        xp.power(a, share),
        xp.power(xp.abs(a), -0.3),
        xp.power(9.0 + a, 200.0 * b),
        xp.power(a, 3),
        a**2,
        b**7,
        (1.0 + b * b) ** -3,
        a**0,
        rows(xp, a, b, share),
        value_and_slope(xp, lambda xp, x: rows(xp, a, x, share), b),
    )


def rows(xp, a, b, share):
    """A loop over rows that uses constants, inputs and numbers from around it, twice."""

    def body(number, x):
        bell = xp.exp(-(x + number * share) * (x + number * share))
        return bell * b + xp.sin(a), xp.where(x > share, bell, 0.0), a * b

    first, second, same = xp.each(body, (-1.0, 0.0, 2.0), (a, b, a * b))
    again, _, _ = xp.each(body, (-1.0, 0.0, 2.0), (a, b, a * b))
    return sum(first) + 2.0 * sum(second) + same[1] + again[2]


def test_operations_agree(runtime):
    kernel = Kernel({"a": (-9.0, 9.0), "b": (-5.0, 5.0), "share": (0.0, 1.0)}, operations)
    inputs = kernel.inputs()
    inputs[0, :8], inputs[1, :8] = 0.0, -0.0
    meant = on_kernel_itself(Parametrised(), kernel, inputs)
    assert np.isfinite(meant).all()
    assert disagreement(meant, runtime(Parametrised(), kernel, inputs)) <= 2e-15


def test_loops_over_rows_are_traced_once():
    kernel = Kernel({"a": (-2.0, 2.0), "b": (-2.0, 2.0), "share": (0.0, 1.0)}, lambda _, *x: rows(*x))
    program = traced(Parametrised(), kernel)
    assert program.graph.operations.count("each") == 1
    assert program.graph.operations.count("exp") == 1


def table(_, xp, a, b):
    """A loop over rows inside another, with numbers of both, of the outer one and from outside."""

    def outer(x, n):
        def inner(y):
            return xp.exp(-(x - y) * (x - y)) + n * b, xp.sin(x) + y

        first, second = xp.each(inner, (a, 2.0, x))
        return sum(first) * first[1], second[2], n

    columns = xp.each(outer, (a, b, a * b, 1.0), (1.0, 2.0, 3.0, b))
    again, _, _ = xp.each(outer, (b, 2.0), (1.0, 3.0))
    return (*columns[0], *columns[1], *columns[2], *again)


def test_loops_over_rows_may_nest(runtime):
    kernel = Kernel({"a": (-2.0, 2.0), "b": (-2.0, 2.0)}, table)
    inputs = kernel.inputs()
    meant = on_kernel_itself(Parametrised(), kernel, inputs)
    assert disagreement(meant, runtime(Parametrised(), kernel, inputs)) <= 1e-14
    program = traced(Parametrised(), kernel)
    assert program.graph.operations.count("exp") == 1


def root(_, xp, a, b):
    """A loop over a state, with a loop over rows inside."""

    def turn(x, step):
        first, _ = xp.each(lambda n, y: (n * y + x, x * b), (1.0, 2.0, 3.0), (a, b, x))
        value, slope = value_and_slope(xp, lambda xp, x: x * x * x + x - a, x)
        return x - value / slope + 0.0 * sum(first), step + 1.0

    return tuple(xp.repeat(9, turn, b, 0.0)) + tuple(xp.repeat(2, turn, b, a))


def test_loops_over_states_agree(runtime):
    kernel = Kernel({"a": (-2.0, 2.0), "b": (-2.0, 2.0)}, root)
    inputs = kernel.inputs()
    meant = on_kernel_itself(Parametrised(), kernel, inputs)
    assert (meant[1] == 9.0).all()
    assert disagreement(meant, runtime(Parametrised(), kernel, inputs)) <= 1e-14
    program = traced(Parametrised(), kernel)
    assert program.graph.operations.count("repeat") == 2


def nest(_, xp, a, b):
    """Loops over states inside others, and inside loops over rows."""

    def row(x, start):
        def slow(y, count):
            def quick(z, w):
                return 0.5 * (z + (x + y) * b), w + z

            z, w = xp.repeat(8, quick, 0.0, count)
            return 0.5 * y + 0.1 * z * a, 0.01 * w + start

        return xp.repeat(9, slow, start, 0.0)

    first, second = xp.each(row, (a, b, 1.0), (0.0, b, a))
    constant = xp.repeat(8, lambda y: (0.5 * y + 1.0,), 0.0)
    return *first, *second, *row(a, b), *constant


def test_loops_over_states_may_nest(runtime):
    kernel = Kernel({"a": (-2.0, 2.0), "b": (-2.0, 2.0)}, nest)
    inputs = kernel.inputs()
    meant = on_kernel_itself(Parametrised(), kernel, inputs)
    assert np.ptp(meant[:6], axis=1).min() > 0.1
    assert disagreement(meant, runtime(Parametrised(), kernel, inputs)) <= 1e-14


def carried(_, xp, a, b):
    """Loops over rows with a state: columns that are read forwards, backwards and shifted, and last states."""

    def walk(xp, start, first, second):
        def step(total, most, x, y):
            now = xp.maximum(most, x * y)
            return total + x * b, now, xp.exp(-total * total) + now

        return xp.scan(step, start, first, second)

    first = [a, b, a * b, 1.0, a - b, 2.0]
    totals, largest, seen = walk(xp, (0.0, b), first, first[::-1])
    (again,) = xp.scan(lambda s, x, y: (0.5 * s + x * y,), (seen[-1],), totals[:-1], seen[:0:-1])
    slopes = value_and_slope(xp, lambda xp, x: walk(xp, (x, 0.0), first, [x] * 6)[2][-1], b)
    return *totals, largest[-1], *seen, again[-1], again[2], *slopes


def test_loops_over_rows_may_have_a_state(runtime):
    kernel = Kernel({"a": (-2.0, 2.0), "b": (-2.0, 2.0)}, carried)
    inputs = kernel.inputs()
    meant = on_kernel_itself(Parametrised(), kernel, inputs)
    assert np.ptp(meant, axis=1).min() > 0.1
    assert disagreement(meant, runtime(Parametrised(), kernel, inputs)) <= 1e-14


def test_the_source_does_not_grow_with_the_rows():
    """Columns are read in place, so that the compile time of a fine mesh is that of a coarse one."""

    def source(count):
        def kernel(xp, *x):
            (made,) = xp.each(lambda y, z: (y * z,), x[::2], x[1::2])
            mixed = [0.5 * (one - other) for one, other in zip(made, made[::-1], strict=True)]
            sums, seen = xp.scan(lambda s, y, z: (s + y, s * z), (0.0,), mixed, made)
            state = xp.repeat(3, lambda *s: [0.5 * one for one in s], *seen)
            return *state, sums[-1]

        program = Program()
        program.add("f", [f"x{k}" for k in range(2 * count)], kernel)
        return c_source(program, [program.functions["f"]])

    assert source(400).count("\n") == source(40).count("\n")


def test_a_missing_operation_is_named():
    with pytest.raises(AttributeError, match="no operation `arctan`"):
        traced(Parametrised(), Kernel({"a": (0.0, 1.0)}, lambda _, xp, a: xp.arctan(a)))


@pytest.mark.parametrize("perturbed", ["C_A", "M_s", "eps_L"])
def test_a_perturbed_constant_is_noticed(perturbed, runtime):
    law, kernel = builders.example(LiangRogers), KERNELS["law"]["path"]
    inputs = kernel.inputs()
    other = law.with_values({perturbed: getattr(law, perturbed) * (1 + 1e-9)})
    meant = on_kernel_itself(law, kernel, inputs)
    assert disagreement(meant, runtime(other, kernel, inputs)) > TOLERANCE


def test_the_sampled_paths_do_transform():
    law, kernel = builders.example(LiangRogers), KERNELS["law"]["path"]
    meant = on_kernel_itself(law, kernel, kernel.inputs())
    start, first, second = meant[0], meant[2], meant[4]
    assert np.mean(np.abs(first - start) > 1e-3) > 0.3
    assert np.mean(np.abs(second - first) > 1e-3) > 0.3


def test_every_kind_has_kernels():
    assert set(kernels.KERNELS) == set(builders.REGISTRIES) - {"waveform"}
