"""The benchmark sections of the laws still run, and judge; so small that times say nothing."""

import math

import numpy as np
import pytest
from benchmarks import law_paths, mas_batches, mas_runs, sections_laws, sections_mas
from benchmarks.engines import available
from benchmarks.peers import mas_ode, simcoon_path
from benchmarks.problem_b import Wire
from benchmarks.sections import Options

from martensite.kernels.compiler import find_compiler
from martensite.physics.laws.base import LAWS

OURS = Options(available(["ours"]), repeats=1, sizes=(8,))
SOME = ("liang-rogers", "mas-hybrid")
LITTLE = sections_mas.Effort(
    floats=(100,),
    c=(100, 50),
    rtols=(4, 6),
    kvaerno=(),
    simd_batch=(),
    kvaerno_batch=(),
    hybrid=(100,),
    march=(1e-3, 1e-4),
    march_batch=(1e-3,),
)
needs_c = pytest.mark.skipif(find_compiler() is None, reason="there is no C compiler")


def row(table, **wanted):
    found = [r for r in table.rows if all(r[k] == v for k, v in wanted.items())]
    assert len(found) == 1
    return found[0]


@needs_c
@pytest.mark.slow
def test_laws():
    *loops, verdict = sections_laws.laws(OURS, 20, SOME)
    for table in loops:
        for law in SOME:
            for engine in (*sections_laws.SINGLE, *sections_laws.BATCH):
                found = row(table, law=law, engine=engine)
                assert found["err"] < 1e-12
                assert found["cpu [us]"] > 0.0
        if simcoon_path.available():
            assert row(table, engine="simcoon")["ratio to simcoon"] == 1.0
            assert all(found["ratio to simcoon"] > 0.0 for found in table.rows)
    assert [r["law"] for r in verdict.rows] == list(SOME)


@needs_c
@pytest.mark.slow
def test_memory_of_a_law():
    (table,) = sections_laws.history(OURS, 16, 2.0)
    rules = [r["rule"] for r in table.rows]
    assert rules == ["resume", "restart", "return-point"] * 3
    assert all(r["cpu [us]"] > 0.0 for r in table.rows)


@pytest.mark.slow
@pytest.mark.parametrize("loop", sections_laws.LOOPS)
@pytest.mark.parametrize("name", LAWS.names())
def test_every_law_transforms_wholly_and_back(name, loop):
    """Otherwise a time would be that of an elastic line."""
    given = law_paths.case(name, loop, 400)
    compiled, values = law_paths.lanes_of(given, 1)
    strain = np.array(law_paths.judged(given, compiled, values[:, 0]))
    assert strain.max() - strain.min() > 0.03
    assert abs(strain[-1] - strain[0]) < 0.2 * np.ptp(strain)
    there, back = strain[: given.half - 1], strain[-2 : given.half - 1 : -1]
    assert np.abs(there - back).max() > 0.02  # the loop is open


def test_the_lanes_differ_and_the_first_is_nominal():
    given = law_paths.case("liang-rogers", "thermal", 20)
    compiled, values = law_paths.lanes_of(given, 8)
    assert values[:, 0].tolist() == compiled.values(given.law)
    assert np.ptp(values, axis=1)[values[:, 0] != 0.0].min() > 0.0


@needs_c
@pytest.mark.slow
def test_mas():
    tables = {table.title: table for table in sections_mas.mas(OURS, LITTLE)}
    for wire in sections_mas.WIRES:
        table = tables[f"Problem B, {wire}: single runs"]
        coarse, fine = (row(table, engine="ours, C", setting=f"dt {ms} ms")["err"] for ms in (100, 50))
        assert 1e-6 < fine < coarse < 1e-3
        assert row(table, engine="ours, floats")["err"] == pytest.approx(coarse, rel=1e-6)
        assert row(table, engine="LSODA", setting="rtol 1e-6")["err"] < 1e-5
        assert row(table, engine="ours, march", setting="tol 1e-04")["err"] < 1e-4
        batch = tables[f"Problem B, {wire}: batch of 8"]
        assert row(batch, engine="LSODA", setting="rtol 1e-6")["failed"] == 0
        assert row(batch, engine="ours, march")["err"] < 1e-3
    hybrid = tables["Problem B with mas-hybrid against its stiff equations"]
    assert sections_mas.good(row(hybrid, engine="ours, C"))
    bars = tables["mas-hybrid: times faster than its stiff equations"]
    assert row(bars, engine="ours, C", beside="Radau")["rtol 1e-6 / this"] > 0.0


@needs_c
@pytest.mark.slow
def test_both_batches_agree():
    problem, sets = mas_runs.Problem(Wire(), "mas-hybrid"), mas_runs.parameter_sets(Wire(), 8)
    found = mas_runs.simd_batch(problem, sets, 0.1)()
    assert found.shape == (8, mas_runs.SAMPLES)
    assert np.isfinite(found).all()
    marched = mas_runs.adaptive_batch(problem, sets, 1e-4)()
    assert np.abs(found - marched).max() < 1e-2 * np.ptp(found)


def test_a_batch_with_a_failed_set_has_failed():
    judge = mas_batches.Judge(mas_runs.parameter_sets(Wire(), 2))
    found = np.array(judge.exact)
    candidate = judge.candidate("ours", "", lambda: found, 2)
    assert candidate.error is not None
    assert candidate.error(found) == 0.0
    found[1, 3] = np.nan
    assert math.isnan(candidate.error(found))
    assert judge.failed["ours", ""] == 1


@pytest.mark.slow
@pytest.mark.parametrize("form", ["edge", "barrier"])
def test_kvaerno_agrees_with_radau(form):
    pytest.importorskip("diffrax")
    from benchmarks.peers import mas_diffrax

    found = mas_ode.outcome(Wire(), mas_diffrax.trajectory(Wire(), form, 1e-6)())
    assert mas_batches.errors(found[0], mas_batches.reference(Wire(), form)[0])[1] < 1e-5


def test_a_wrong_barrier_is_an_error():
    wrong = mas_ode.trajectory(mas_ode.by_odeint, Wire(Delta_sigma=53e6), "edge", 1e-6)()
    found = mas_ode.outcome(Wire(), wrong)
    assert mas_batches.errors(found[0], mas_batches.reference(Wire(), "edge")[0])[0] > 1e-3
