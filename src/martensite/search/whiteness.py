"""Whether anything is left in the residuals of a record that a model could still explain.

White residuals of n samples have autocorrelations ρ_k that lie within ±z/√n in the share
`level` of all lags, z being the quantile of the normal distribution, and

    Q = n (n + 2) Σ_{k=1..L} ρ_k²/(n - k)

is distributed as χ² with L degrees of freedom (Ljung and Box (1978), Biometrika 65). The mean is
not taken off (see `autocorrelation`): a model that is off by a constant is not white.
"""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass
from importlib import import_module
from statistics import NormalDist
from typing import Any

from martensite.base.confidence import LEVEL
from martensite.base.errors import DataError, ParameterError
from martensite.search.autocorrelation import compute_autocorrelation
from martensite.search.quantity_text import format_number

FEWEST = 10
"""Samples below which whiteness is not tested."""
LAGS = 20
"""Lags tested, if the record is five times as long."""


@dataclass(frozen=True)
class Whiteness:
    """Autocorrelation of the residuals of one record, and the test on it."""

    record: str
    autocorrelation: tuple[float, ...]
    """ρ_1 … ρ_L."""
    band: float
    """Half width within which the share `level` of ρ_k lies if the residuals are white."""
    statistic: float
    """Q of Ljung and Box."""
    p_value: float
    """Probability of so large a Q, were the residuals white."""
    samples: int
    level: float

    @property
    def white(self) -> bool:
        """Whether the test finds nothing at its level."""
        return self.p_value >= 1.0 - self.level

    @property
    def memory(self) -> int | None:
        """First lag at which the autocorrelation is within the band; None if beyond the last."""
        lags = enumerate(self.autocorrelation, 1)
        return next((k for k, rho in lags if abs(rho) <= self.band), None)

    @property
    def sentence(self) -> str:
        """The verdict with its numbers."""
        outside = sum(abs(rho) > self.band for rho in self.autocorrelation)
        test = "p < 0.0001" if self.p_value < 1e-4 else f"p = {self.p_value:.2g}"
        counted = f"{outside} of {len(self.autocorrelation)} autocorrelations outside"
        numbers = f"(Ljung–Box {test}; {counted} ±{format_number(self.band, 2)})"
        if self.white:
            return f"`{self.record}`: residuals are white {numbers}; nothing is left to explain."
        first = format_number(self.autocorrelation[0], 2)
        lasting = f"past lag {len(self.autocorrelation)}"
        if self.memory is not None:
            lasting = f"until lag {self.memory}"
        return (
            f"`{self.record}`: residuals are not white {numbers}: {first} from one sample to the "
            f"next, felt {lasting}; the model misses something, or the noise has a memory, and "
            "intervals for independent samples are too narrow."
        )

    def to_dict(self) -> dict[str, Any]:
        """All fields by name and the verdict, for JSON."""
        return asdict(self) | {"white": self.white, "sentence": self.sentence}


def assess_whiteness(
    residuals: Any, record: str = "record", *, lags: int | None = None, level: float = LEVEL
) -> Whiteness:
    """Test the residuals of one record.

    Args:
        residuals: (samples,), equally spaced in time.
        record: its name, for the verdict.
        lags: number L of lags; 20, or a fifth of a shorter record, if left out.
        level: of the band and of the test.

    Raises:
        DataError: the residuals are fewer than 10, or not finite.
        ParameterError: there are not as many lags, or the level is not between 0 and 1.
    """
    count = len(residuals)
    if count < FEWEST:
        raise DataError(f"Whiteness takes at least {FEWEST} residuals, but there are {count}.")
    most = min(LAGS, count // 5) if lags is None else lags
    if not 1 <= most < count:
        raise ParameterError(f"Argument `lags` must be 1 to {count - 1}, but is {most}.")
    if not 0.0 < level < 1.0:
        raise ParameterError(f"Argument `level` must be between 0 and 1, but is {level:g}.")
    rho = [float(one) for one in compute_autocorrelation(residuals)[1 : most + 1]]
    weighted = sum(r * r / (count - k) for k, r in enumerate(rho, 1))
    statistic = count * (count + 2) * weighted
    chi2: Any = import_module("scipy.stats").chi2
    return Whiteness(
        record,
        tuple(rho),
        NormalDist().inv_cdf(0.5 + 0.5 * level) / math.sqrt(count),
        statistic,
        float(chi2.sf(statistic, most)),
        count,
        level,
    )
