"""The benchmark sections of chains still run, and judge; times say nothing here."""

import tracemalloc
from typing import Any

import numpy as np
import pytest
from benchmarks import sections_chains, sections_records
from benchmarks.peers import jaxsysid_fit

from martensite.base.errors import DataError
from martensite.identify.chains.estimate import Options as Search
from martensite.identify.chains.residuals import RecordResidual, ResidualSquares


@pytest.mark.slow
def test_ways_to_derivatives(c_compiler, monkeypatch):
    monkeypatch.setattr(sections_chains, "SAMPLES", 400)
    chain, record = sections_chains.first_stage(400)
    assert len(chain.theta) == 25
    found = {c.name: c for c in sections_chains.candidates(chain, record)}
    errors = {name: c.error(c.run()) for name, c in found.items() if c.error}
    assert errors["one pass"] < 1e-4  # of differences over a short record
    plain = found["simulation alone, NumPy, SciPy"].run()
    assert plain == pytest.approx(chain.simulate(record)[:, 0], abs=1e-3)
    assert np.ptp(plain) > 1.0


def test_normal_equations_take_bounded_memory(c_compiler):
    chain, record = sections_chains.first_stage(60_000)
    squares = ResidualSquares(chain.engine, [RecordResidual(record)])
    squares.normal(chain.theta)
    whole = 8 * len(record) * len(chain.theta)
    tracemalloc.start()
    squares.normal(chain.theta)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.reset_peak()
    kept = chain.engine.jacobian(chain.theta, record.inputs)
    at_once = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < 0.2 * whole
    assert at_once > whole
    assert len(kept[0]) == len(record)


def split() -> dict[str, Any]:
    _, record = sections_chains.first_stage(600)
    return {"estimation": record.rows(0, 400), "test": record.rows(400, None)}


@pytest.mark.slow
def test_records_beside_a_peer(c_compiler):
    ours = sections_records.searched("oe(1,1,1) | poly2", Search(starts=1, iterations=5))
    budget = jaxsysid_fit.Budget(2, 3, adam=2, lbfgs=2)
    peers = {"linear": budget, "sandwich": budget, "network": budget}
    task = sections_records.Task(split, [ours], peers)
    there = jaxsysid_fit.available()
    found = sections_records.compared("made up", task, there)
    assert len(found.rows) == 1 + 3 * there
    assert found.rows[0]["error ratio"] == found.rows[0]["cpu ratio"] == 1.0
    assert all(np.isfinite(row["test [mV]"]) for row in found.rows)
    assert there or jaxsysid_fit.VARIABLE in found.note


def test_what_is_not_there_is_said(monkeypatch):
    def read() -> dict[str, Any]:
        raise DataError("The record is elsewhere.")

    task = sections_records.Task(read, [], {})
    assert sections_records.compared("made up", task, False).note == "The record is elsewhere."
    monkeypatch.setenv(jaxsysid_fit.VARIABLE, "/nowhere/python")
    jaxsysid_fit.available.cache_clear()
    assert not jaxsysid_fit.available()
    jaxsysid_fit.available.cache_clear()
