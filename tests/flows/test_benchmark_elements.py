"""The benchmark section of the elements still runs, and judges; so small that times say nothing."""

import pytest
from benchmarks import sections_elements
from benchmarks.engines import available
from benchmarks.sections import Options

from martensite.kernels.compiler import find_compiler

OURS = Options(available(["ours"]), repeats=1)


@pytest.mark.slow
@pytest.mark.skipif(find_compiler() is None, reason="there is no C compiler")
def test_cells():
    floats, native = sections_elements.cells(OURS, counts=("5",))
    for table in (floats, native):
        lumped, axial = table.rows
        assert (lumped["err"], lumped["ratio"]) == (0.0, 1.0)
        assert axial["err"] < 1e-9
        assert axial["ratio"] > 1.0


@pytest.mark.slow
@pytest.mark.skipif(find_compiler() is None, reason="there is no C compiler")
def test_fibres():
    """20 fibres cost less than ten times what one does; a ratio of processor times in one run."""
    (table,) = sections_elements.fibres(OURS, counts=("20",))
    surface, fibres = table.rows
    assert fibres["err"] == 0.0 and surface["err"] > 0.1
    assert 1.0 < fibres["ratio"] < 10.0
