"""Fences around the records: nonlinear terms go no further than they went there.

Source of truth: the same model without fences, along its record; a linear system with a bounded input beyond it.
"""

from __future__ import annotations

import numpy as np
import pytest

from martensite.identify.blocks.base import Numbers
from martensite.identify.chains.chain import Chain, build_untrained
from martensite.identify.chains.chain_text import parse_chain
from martensite.identify.chains.fences import fence_chain
from martensite.signals.sampling.sampled import Sampled

DT = 0.1
TIMES = DT * np.arange(6000)


def driven(text: str, terms: dict[str, float]) -> tuple[Chain, Sampled]:
    """A resonance at 1 rad/s with nonlinear terms, and a record of noise that hardly excites it."""
    u = np.clip(np.random.default_rng(1).normal(0.0, 0.3, len(TIMES)), -1.0, 1.0)
    record = Sampled("noise", DT, u, u, ("u",), ("y",))
    chain = build_untrained(parse_chain(text), record)
    theta = dict(zip(chain.names(), chain.theta, strict=True))
    theta |= {"1.log_omega1": 0.0, "1.log_zeta1": np.log(0.05)} | {f"1.{name}": value for name, value in terms.items()}
    return chain.with_theta(np.array(list(theta.values()))), record


def run(chain: Chain, u: Numbers) -> float:
    with np.errstate(all="ignore"):
        return float(np.nan_to_num(np.abs(chain.simulate(u)), nan=np.inf, posinf=np.inf).max())


@pytest.mark.parametrize(
    ("text", "terms"), [("nlss(2,3,1,1)", {"e1_000": 2.0, "e1_001": 2.0}), ("fb(2,3,1)", {"c30": -0.3})]
)
def test_a_resonance_within_the_range_of_the_input_stays_near_the_records(text: str, terms: dict[str, float]) -> None:
    chain, record = driven(text, terms)
    rest = chain.engine.rest(chain.theta, record.inputs[0]).state
    fenced = fence_chain(chain, [record], [rest])
    before = chain.simulate(record, rest)
    np.testing.assert_array_equal(fenced.simulate(record, rest), before)
    resonant = np.sin(TIMES)
    largest = float(np.abs(before).max())
    linear = chain.with_theta(np.where(np.isin(chain.names(), [f"1.{name}" for name in terms]), 0.0, chain.theta))
    assert run(chain, resonant) > 3.0 * run(linear, resonant)
    assert run(fenced, resonant) < 1.5 * run(linear, resonant) + 3.0 * largest
