"""The benchmark section of the throughput still runs, and judges; times say nothing here."""

import numpy as np
import pytest
from benchmarks import roofline, sections_throughput, throughput_runs
from benchmarks.inputs import sine
from benchmarks.roofline import Peaks
from benchmarks.sections import Options

from martensite.kernels.compiler import find_compiler

pytestmark = pytest.mark.skipif(find_compiler() is None, reason="there is no C compiler")
OPTIONS = Options([], repeats=1, sizes=(3,))
SMALL = sections_throughput.Effort(laws=(), most=2, scaling=(20,), peer=1)


@pytest.fixture(autouse=True)
def _short(monkeypatch):
    short = sine(2.0)
    monkeypatch.setattr(throughput_runs, "sine", lambda: short)
    monkeypatch.setattr(sections_throughput, "RTOLS", ("rtol 1e-5",))
    monkeypatch.setattr(sections_throughput, "peaks", lambda: Peaks(1e9, 1e8, 1e9))


@pytest.mark.slow
def test_all_tables():
    batch, scaling, share = sections_throughput.throughput(OPTIONS, SMALL)
    names = [row["engine"] for row in batch.rows]
    assert names == ["C lanes", "C lanes, two threads", "C one by one", "LSODA, odeint", "LSODA, solve_ivp"]
    assert all(0.0 <= row["err"] < 1e-3 for row in batch.rows)
    assert batch.rows[0]["ratio"] == 1.0
    assert [row["runs"] for row in scaling.rows] == [20]
    assert 30 < share.rows[0]["divisions/step"] < 80


@pytest.mark.slow
def test_the_finger_in_lanes_is_the_finger_one_by_one():
    case = throughput_runs.finger("mas-hybrid", 3, duration=5.0)
    error = sections_throughput.apart(case, 2)
    found = throughput_runs.in_lanes(case, 3, threads=2)()
    assert error(found) < 1e-9
    assert error(found._replace(first=1.1 * found.first)) > 0.01
    assert found.strokes.shape == (3,)


@pytest.mark.slow
def test_operations_in_loops_count_as_often_as_they_are_made():
    work = roofline.work(throughput_runs.finger("mas-hybrid", 1).compiled)
    assert work.divisions > 300
    assert np.isfinite(roofline.peaks.__wrapped__(turns=1000, megabytes=1)).all()
