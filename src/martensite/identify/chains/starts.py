"""Where searches for a chain begin: random dynamics, then a straight line through the data.

Whatever the random numbers are, two of the static block that carries the gain follow from least
squares: its line is fitted to the outputs over what reaches it.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from martensite.identify.blocks.base import AbstractStatic, Numbers
from martensite.identify.chains.chain import Chain
from martensite.signals.sampling.sampled import Sampled


def draw_numbers(chain: Chain, rng: np.random.Generator, record: Sampled) -> Numbers:
    """Random free numbers of all blocks."""
    parts = [b.sample_parameters(rng, record.duration, record.interval) for b in chain.blocks]
    return np.concatenate([np.zeros(0), *parts])


def align_chain(chain: Chain, records: Sequence[Sampled]) -> Chain:
    """The chain with the line of its last static block fitted to the outputs.

    If linear blocks follow it, which have unit gain, the outputs are those of a slow system and
    the same line serves. Outputs that are proportional to a number of the last block get that
    number by least squares. A chain with neither stays as it is.
    """
    with np.errstate(all="ignore"):  # a drawn chain may grow without bound
        return _align_last(_fit_gains(chain, records), records)


def _align_last(chain: Chain, records: Sequence[Sampled]) -> Chain:
    static = [(i, b) for i, b in enumerate(chain.blocks) if isinstance(b, AbstractStatic)]
    if not static or len(chain.output_names) != 1:
        return chain
    place, block = static[-1]
    pairs = [(_find_reaching(chain, place, record), record.outputs[:, 0]) for record in records]
    x, y = (np.concatenate(columns) for columns in zip(*pairs, strict=True))
    known = np.isfinite(x) & np.isfinite(y)
    slope, offset = _fit_line(x[known], y[known])
    parts = chain.split()
    parts[place] = _curve_around(parts[place], block, slope, offset)
    return chain.with_theta(np.concatenate(parts))


def _fit_gains(chain: Chain, records: Sequence[Sampled]) -> Chain:
    """The chain with the gains of the outputs of its last block fitted, one by one."""
    block = chain.blocks[-1]
    if not any(block.gains()) or chain.taps is not None:
        return chain
    computed = np.concatenate([chain.simulate(record) for record in records])
    measured = np.concatenate([record.outputs for record in records])
    theta = chain.theta.copy()
    first = len(theta) - len(block.numbers())
    for name, y, own in zip(block.gains(), measured.T, computed.T, strict=True):
        known = np.isfinite(y)
        square = float(own[known] @ own[known])
        if name and 0.0 < square < np.inf:
            theta[first + block.numbers().index(name)] *= float(own[known] @ y[known]) / square
    return chain.with_theta(theta)


def _find_reaching(chain: Chain, place: int, record: Sampled) -> Numbers:
    """What enters a block, delayed as much as the linear blocks after it delay."""
    own = chain.before(place, record)[:, 0]
    after = chain.blocks[place + 1 :]
    if not after:
        return own
    rest = Chain(after, np.concatenate(chain.split()[place + 1 :]), chain.interval)
    return rest.simulate(own)[:, 0]


def _fit_line(x: Numbers, y: Numbers) -> tuple[float, float]:
    spread = float(np.var(x))
    if not spread > 0.0 or not np.isfinite(spread):
        return 0.0, float(np.mean(y)) if len(y) else 0.0
    slope = float(np.mean((x - x.mean()) * (y - y.mean()))) / spread
    return slope, float(y.mean() - slope * x.mean())


def _curve_around(theta: Numbers, block: AbstractStatic, slope: float, offset: float) -> Numbers:
    """The drawn departure from the identity, scaled with the slope, around the line."""
    departure = theta - block.line(1.0, 0.0)
    scaled = block.scale_departure(departure, slope)
    return block.line(slope, offset if block.offset == "yes" else 0.0) + scaled
