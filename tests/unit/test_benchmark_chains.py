"""The benchmark sections of chains still run, and judge; times say nothing here."""

import tracemalloc

import numpy as np
import pytest
from benchmarks import sections_chains
from benchmarks.engines import available
from benchmarks.sections import SECTIONS, Options

from martensite.identify.chains.residuals import Aim, Squares

OURS = Options(available(["ours"]), repeats=1)


def test_the_sections_are_entered():
    assert {"chains", "searches", "chain_memory"} <= set(SECTIONS)


def test_ways_to_derivatives(c_compiler, monkeypatch):
    monkeypatch.setattr(sections_chains, "SAMPLES", 400)
    chain, record = sections_chains.first_stage(400)
    assert len(chain.theta) == 25
    found = {c.name: c for c in sections_chains.candidates(chain, record)}
    errors = {name: c.error(c.run()) for name, c in found.items() if c.error}
    assert errors["one pass"] < 1e-4  # of differences over a short record
    assert errors["jacfwd of a JAX scan"] == pytest.approx(errors["one pass"], rel=1e-3)
    plain = found["simulation alone, NumPy, SciPy"].run()
    assert plain == pytest.approx(chain.simulate(record)[:, 0], abs=1e-3)
    assert np.ptp(plain) > 1.0


def test_normal_equations_take_bounded_memory(c_compiler):
    chain, record = sections_chains.first_stage(60_000)
    squares = Squares(chain.engine, [Aim(record)])
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
