"""The C core of every law, and of parts of every other kind, goes the way of plain floats.

Source of truth: the traced kernels on floats. Steps that stay unsolved are taken by neither.
"""

from __future__ import annotations

import random
from pathlib import Path
from typing import Any

import pytest
from builders import example, example_system, registered
from c_cores import LONG_STEP, UNSOLVED, Called, compiled

from martensite.base.parameters import Parametrised
from martensite.export.c_core import build_c_core
from martensite.scenario.scenario import load
from martensite.simulate.compiled import compile_system
from martensite.simulate.march import SOLVED

pytestmark = pytest.mark.usefixtures("c_compiler")

STEPS, ROOT = 150, Path(__file__).parents[2]
CHOSEN = {
    "cooling": ("churchill-bernstein",),
    "element": ("coil-spring",),
    "mechanism": ("antagonistic-pulley",),
    "drive": ("current",),
}
"""Parts of other kinds; all of them run in C in other tests."""


LONG = ("lagoudas", "mas-polycrystal")
"""What takes long to trace."""


def things() -> list[Any]:
    """All laws, and what was chosen."""
    others = [cls for kind, names in CHOSEN.items() for cls in registered(kind) if cls.registered_name in names]
    return [
        pytest.param(
            example(cls), id=cls.registered_name, marks=pytest.mark.slow if cls.registered_name in LONG else ()
        )
        for cls in (*registered("law"), *others)
    ]


def test_its_numbers_are_what_they_are_for_the_processor_at_hand(tmp_path: Path) -> None:
    """gcc 12 made of a row `1, 1, 1, 1, 0, 0, 0, 0` of the table eight ones, for processors with AVX-512."""
    core = build_c_core(load(ROOT / "examples" / "closed_loop.toml").system, name="core")
    defaults = [one.default for one in core.parameters]
    assert "1.0, 1.0, 1.0, 1.0, 0.0, 0.0, 0.0, 0.0" in str(defaults)
    assert list(Called(core, tmp_path, "-O2", "-march=native").model.p) == defaults


@pytest.mark.parametrize("thing", things())
def test_it_goes_the_way_of_floats(thing: Parametrised, tmp_path: Path) -> None:
    system = example_system(thing)
    compiled_ = compile_system(system)
    functions = compiled_.program.bind_floats(*compiled_.values(system))
    called = Called(build_c_core(system, name="core"), tmp_path)
    rng, size, taken = random.Random(0), compiled_.size, 0
    most = 0.8 if thing.registered_name == "current" else 4.0
    rest = (0.0,) * compiled_.drives
    state = functions["init"](*rest)
    assert (called.start(*rest), called.state) == (0, state)
    for _ in range(STEPS):
        inputs = tuple(most * rng.choice((0.0, rng.random())) for _ in rest)
        dt = 10.0 ** rng.uniform(-3.0, -0.5)
        after = functions["step"](*state, *inputs, dt)
        solved = after[size] <= SOLVED
        state, taken = (after[:size] if solved else state), taken + solved
        status = called.step(*inputs, dt=dt)
        assert status <= LONG_STEP if solved else status == UNSOLVED
        assert called.state == state
        assert called.observe(*inputs) == (0, functions["observe"](*state, *inputs))
    assert taken > STEPS // 2


@pytest.mark.parametrize("thing", things())
def test_in_float_it_compiles_without_warnings(thing: Parametrised, tmp_path: Path) -> None:
    core = build_c_core(example_system(thing), name="core", precision="float32")
    compiled(core, tmp_path, "-fsyntax-only")
