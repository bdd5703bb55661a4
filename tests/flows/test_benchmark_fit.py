"""The benchmark sections of the fits still run, and judge; times say nothing here."""

import pytest
from benchmarks import sections_fit
from benchmarks.engines import available
from benchmarks.sections import Options

from martensite.kernels.compiler import find_compiler

OURS = Options(available(["ours"]), repeats=1)


@pytest.mark.slow
@pytest.mark.skipif(find_compiler() is None, reason="there is no C compiler")
def test_derivatives_are_those_of_differences(monkeypatch):
    name, case = next(iter(sections_fit.CASES.items()))
    monkeypatch.setattr(sections_fit, "CASES", {name: case})
    (table,) = sections_fit.derivatives(OURS)
    plain, slopes = table.rows
    assert plain["ratio"] == 1.0
    assert slopes["err"] < 1e-3
    assert len(case[2]) == 12
    assert len(case[1]) == 5


def test_fits_are_left_out_without_the_measurements(monkeypatch):
    monkeypatch.setattr(sections_fit.datasets, "is_here", lambda name: False)
    assert sections_fit.fits(OURS) == []
