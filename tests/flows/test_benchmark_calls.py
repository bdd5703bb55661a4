"""Run the benchmark sections of user calls once. The problems are too small for timing."""

import pytest
from benchmarks import sections_calls
from benchmarks.engines import available
from benchmarks.sections import Options, single

from martensite.kernels.compiler import find_compiler

OURS = Options(available(["ours-call", "ours-march"]), repeats=1)
pytestmark = pytest.mark.skipif(find_compiler() is None, reason="there is no C compiler")


def test_a_call_is_more_accurate_than_its_march() -> None:
    """`simulate` marches to a finer local tolerance than a single march to the same one."""
    (table,) = single(OURS)
    call, march = (row["err"] for row in table.rows)
    assert call < march < 1e-3


@pytest.mark.slow
def test_runs_and_commands() -> None:
    (table,) = sections_calls.calls(OURS, names=("constant_power",))
    assert [row["example"] for row in table.rows] == ["constant_power"]
    (table,) = sections_calls.commands(OURS, first=("constant_power",))
    assert [row["cache"] for row in table.rows] == ["warm"] * 4 + ["empty"]
    assert all(row["cpu [ms]"] > 0.0 for row in table.rows)
