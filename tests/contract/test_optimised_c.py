"""C as users compile it: tests compile quickly instead, without optimisation."""

from __future__ import annotations

import numpy as np
import pytest
from builders import SINE_A, problem_a

from martensite.kernels.c99 import c_source
from martensite.kernels.compiler import call_compiled, load_library
from martensite.kernels.program import Program
from martensite.simulate.api import simulate
from martensite.simulate.compiled import compile_march
from martensite.simulate.drive_waveforms import grid_of
from martensite.simulate.native import march_lanes

LANES = 5
"""A number that no other test has, so that the library is made here."""


@pytest.mark.usefixtures("c_compiler")
def test_optimised_lanes_agree_with_floats(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("MARTENSITE_CFLAGS", raising=False)
    monkeypatch.setenv("MARTENSITE_QUICK_C", "off")
    system = problem_a()
    compiled = compile_march(system)
    grid = grid_of(system, SINE_A, 20.0, 101, 0.02)
    outputs = range(len(compiled.outputs))
    rows, _ = march_lanes(compiled, compiled.values(system), grid, LANES, outputs)
    meant = simulate(system, SINE_A, 20.0, step=0.02, samples=101)
    table = np.array([meant[name] for name in compiled.outputs]).T
    span = np.maximum(np.ptp(table, axis=0), 1e-3 * np.abs(table).max(axis=0))
    for lane in range(LANES):
        apart = np.abs(rows[:, :, lane] - table).max(axis=0)
        assert np.all(apart <= 1e-12 * np.maximum(span, 1e-300))
    assert np.ptp(table[:, compiled.outputs.index("martensite_fraction")]) > 0.1


RUN = """
void run(const double *x, double *y) { k_k(1, x, x, y); }
"""


@pytest.mark.usefixtures("c_compiler")
@pytest.mark.parametrize("x", [1.0, 700.5, 740.0, 1000.0])
def test_a_shared_inverse_of_an_exponential_stays_finite(x: float) -> None:
    """exp(-740) is so small a number that its inverse is infinite."""

    def shares(xp, x):
        small = xp.exp(-x)
        return [xp.where(small > 0.0, times * small / xp.where(small > 0.0, small, 1.0), 0.5) for times in (3.0, 5.0)]

    program = Program()
    program.add("k", ("x",), shares)
    library = load_library(c_source(program, program.functions.values(), shares_inverses=True) + RUN)
    found = np.empty(2)
    call_compiled(library.run, np.array([x]), found)
    assert found.tolist() == ([0.5, 0.5] if x > 700.0 else pytest.approx([3.0, 5.0]))
