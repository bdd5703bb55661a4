"""A value that no batch element wants costs nothing."""

from __future__ import annotations

import pytest

from martensite.kernels import floats
from martensite.kernels.c99_lanes import lanes_source
from martensite.kernels.namespace import Namespace, Scalar
from martensite.kernels.nested import compute_if
from martensite.kernels.program import Program


@pytest.mark.parametrize("wanted", [True, False])
def test_the_function_is_called_where_it_is_wanted(wanted: bool) -> None:
    arguments: list[float] = []

    def double(x: float) -> float:
        arguments.append(x)
        return 2.0 * x

    assert compute_if(floats, wanted, double, 7.0, 3.0) == (6.0 if wanted else 7.0)
    assert arguments == [3.0] * wanted


def test_code_evaluates_the_function_inside_a_loop() -> None:
    def kernel(xp: Namespace, x: Scalar) -> list[Scalar]:
        return [compute_if(xp, x > 0.0, lambda y: xp.exp(y), 0.0, x)]

    program = Program()
    program.add("step", ["x"], kernel)
    step = program.bind_floats()["step"]
    assert [step(x)[0] for x in (-1.0, 0.0, 1.0)] == [0.0, 0.0, floats.exp(1.0)]
    text = lanes_source(program, [program.functions["step"]])
    text = text[text.index("k_step") :]
    assert text.index("exp_of") > text.index("for (int")
