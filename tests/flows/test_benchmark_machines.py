"""The benchmark section of the mechanisms still runs, and judges; times say nothing here."""

import pytest
from benchmarks import sections_machines
from benchmarks.engines import available
from benchmarks.sections import Options

from martensite.kernels.compiler import find_compiler

OURS = Options(available(["ours"]), repeats=1)


@pytest.mark.slow
@pytest.mark.skipif(find_compiler() is None, reason="there is no C compiler")
def test_machines(monkeypatch):
    monkeypatch.setattr(sections_machines, "RUNTIMES", ("c",))
    (table,) = sections_machines.machines(OURS)
    names = [row["engine"] for row in table.rows]
    assert names == ["bias-spring", "finger", "finger, dynamic", "pulley"]
    assert all(0.0 <= row["err"] < 0.02 for row in table.rows)
    assert table.rows[0]["ratio"] == 1.0
