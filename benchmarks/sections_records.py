"""The section `records`: identification on public records, beside jax-sysid.

What: Wiener-Hammerstein 2009 and Silverbox, on the published splits, free runs, root mean squares
in millivolts with the first 50 samples left out. A search is run once, a whole one with
compilation: seconds differ from run to run, errors do not. jax-sysid gets a fixed budget of
iterations from one start; a longer one may end lower. A data set or an interpreter that is not
there leaves its rows out, and the note says how to get it.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from benchmarks.peers import jaxsysid_fit
from benchmarks.report import Table
from benchmarks.sections import Options, section
from martensite.base.errors import DataError
from martensite.identify.blocks.feedback import Feedback
from martensite.identify.chains.best_linear import fit_linear_model
from martensite.identify.chains.chain import Chain
from martensite.identify.chains.estimate import Options as Search
from martensite.identify.chains.estimate import estimate_chain, refine_chain
from martensite.identify.chains.scores import compute_rms
from martensite.signals.sampling.sampled import Sampled
from martensite.studies.public_benchmarks import SKIP, read_silverbox, read_wiener_hammerstein

PEER = "jax-sysid"
Records = Mapping[str, Sampled]


class Ours(NamedTuple):
    """One of our models."""

    name: str
    fit: Callable[[Sampled], Chain]


class Task(NamedTuple):
    """A public record: how it is read, our models, and the peer's with their sizes."""

    read: Callable[[], dict[str, Sampled]]
    ours: Sequence[Ours]
    peers: Mapping[str, jaxsysid_fit.Budget]


def searched(text: str, options: Search) -> Ours:
    """A chain from a search."""
    return Ours(text, lambda record: estimate_chain(text, record, options).chain)


def fed_back(record: Sampled) -> Chain:
    """A resonance with a polynomial of its output fed back, from the linear model."""
    linear = estimate_chain("oe(3,2,0) | poly1", record, Search(skip=SKIP)).chain
    poles, line = linear.split()
    before: Any = linear.blocks[0]
    first = Feedback(order=2, degree=3).adapt_to(record.inputs, record.interval)
    begun = np.concatenate([first.like(before, poles, record.interval), line])
    chain = replace(linear, blocks=(first, linear.blocks[1]), theta=begun)
    return chain.with_theta(refine_chain(chain, [record], Search(skip=SKIP)).theta)


WIENER_HAMMERSTEIN = "oe(4,3,0) | sigmoid16 | oe(4,3,0)"
TASKS = {
    "Wiener-Hammerstein 2009": Task(
        read_wiener_hammerstein,
        [
            Ours("oe(6,6,1) | poly1", lambda record: fit_linear_model(record, 6, skip=SKIP)),
            searched(WIENER_HAMMERSTEIN, Search(starts=9, refined=2, iterations=60, skip=SKIP)),
        ],
        {"linear": jaxsysid_fit.Budget(6), "sandwich": jaxsysid_fit.Budget(6, 16)},
    ),
    "Silverbox": Task(
        read_silverbox,
        [searched("oe(3,2,0) | poly1", Search(skip=SKIP)), Ours("fb(2,3) | poly1", fed_back)],
        {"linear": jaxsysid_fit.Budget(2), "network": jaxsysid_fit.Budget(4, 8)},
    ),
}


def our_row(model: Ours, records: Records) -> dict[str, Any]:
    """A search of ours, and its errors on all tests."""
    wall, cpu = time.perf_counter(), time.process_time()
    chain = model.fit(records["estimation"])
    cpu, wall = time.process_time() - cpu, time.perf_counter() - wall
    errors = [float(compute_rms(r.outputs, chain.simulate(r), SKIP)[0]) for r in tests(records).values()]
    return row(model.name, jaxsysid_fit.Fit(cpu, wall, len(chain.theta), errors), records)


def peer_row(model: str, budget: jaxsysid_fit.Budget, records: Records) -> dict[str, Any]:
    """A fit of the peer on the same samples."""
    pairs = [(r.inputs, r.outputs) for r in (records["estimation"], *tests(records).values())]
    found = jaxsysid_fit.fit(model, pairs[0], pairs[1:], SKIP, budget)
    return row(f"{PEER} {model}", found, records)


def tests(records: Records) -> dict[str, Sampled]:
    """All but the record to estimate from."""
    return {name: record for name, record in records.items() if name != "estimation"}


def row(name: str, found: jaxsysid_fit.Fit, records: Records) -> dict[str, Any]:
    """What is printed of one fit."""
    errors = {f"{test} [mV]": 1e3 * e for test, e in zip(tests(records), found.errors, strict=True)}
    times = {"cpu [s]": found.seconds, "wall [s]": found.wall}
    return {"model": name, "numbers": found.numbers, **errors, **times}


def with_ratios(rows: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """Time and error on the first test over those of our best model."""
    test = next(key for key in rows[0] if key.endswith("[mV]"))
    best = min((r for r in rows if not r["model"].startswith(PEER)), key=lambda r: r[test])
    return [{**r, "cpu ratio": r["cpu [s]"] / best["cpu [s]"], "error ratio": r[test] / best[test]} for r in rows]


def compared(name: str, task: Task, peers: bool) -> Table:
    """All models on one record."""
    try:
        records = task.read()
    except DataError as missing:
        return Table(name, [], str(missing))
    rows = [our_row(model, records) for model in task.ours]
    note = "Ratios to our model with the least error."
    if peers:
        rows += [peer_row(model, budget, records) for model, budget in task.peers.items()]
        counts = {(b.adam, b.lbfgs) for b in task.peers.values()}
        note += "".join(f" {PEER}: one start, Adam {a} steps, L-BFGS-B {b}." for a, b in counts)
    else:
        note += f" {PEER} was not found: name its interpreter in {jaxsysid_fit.VARIABLE}."
    return Table(name, with_ratios(rows), note)


@section
def records(options: Options) -> list[Table]:
    """Public records, beside jax-sysid where it is installed."""
    peers = jaxsysid_fit.available()
    return [compared(name, task, peers) for name, task in TASKS.items()]
