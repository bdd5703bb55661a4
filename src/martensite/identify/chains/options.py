"""How a chain is estimated: what is searched, what counts, and for how long."""

from __future__ import annotations

from dataclasses import dataclass

from martensite.identify.chains.chain import Chain


@dataclass(frozen=True)
class Options:
    """How a chain is estimated."""

    starts: int = 12
    """Searches from different starts; 1 takes the plainest start only."""
    refined: int = 3
    """How many of the best go on with more samples."""
    iterations: int = 100
    """Most steps of these; first searches take half, the last at the full rate a quarter."""
    seed: int = 0
    skip: int = 0
    """Samples at the start of every record that do not count."""
    start: str = "rest"
    """State at the first sample: rest, zero, estimate."""
    anchor: float = 0.0
    """Weight of the first known outputs as those at rest, in shares of all samples."""
    ridge: float = 0.0
    """Pull towards the start of the last search, per sample."""
    sigma: tuple[float, ...] = ()
    """Size of a usual residual of every output, such as 1 K and 0.1 mm; by default its spread."""
    priors: bool = True
    """Whether what blocks expect of their free numbers counts; see `AbstractBlock.priors`."""
    noise: int = 0
    """Order of the noise model; 0 minimises the simulation error, else the prediction error."""
    threads: int = 2
    begin: tuple[Chain, ...] = ()
    """Chains to start from besides, such as an earlier estimate; simpler blocks are taken over."""
