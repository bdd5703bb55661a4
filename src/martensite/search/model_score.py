"""Agreement of a model with a measured record: size, place and sign of the error.

With e = modelled - measured

    rms = √(Σ e²/n),    fit = 100 % (1 - ‖e‖/‖y - mean(y)‖),    bias = mean(e)

where y is measured (normalised root-mean-square error: Ljung (1999), System Identification).
A fit of 100 % is perfect, one of 0 % no better than the constant mean(y), and below 0 % worse.
"""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from martensite.base.errors import DataError
from martensite.search.quantity_text import format_change, format_number


@dataclass(frozen=True)
class Score:
    """Error of a model in one output of one record."""

    record: str
    output: str
    part: str
    """Use of the record: `training`, or `held-out`."""
    unit: str
    """SI unit of the output."""
    rms: float
    """Root-mean-square error [unit]."""
    fit_percent: float
    """100 % for a perfect model; NaN for a constant output."""
    maximum: float
    """Largest absolute error [unit]."""
    maximum_at: float
    """Time of the largest error [s]."""
    bias: float
    """Mean of modelled minus measured values [unit]."""
    samples: int
    place: str = ""
    """Location of the largest error, if not a time."""

    @property
    def sentence(self) -> str:
        """Return the errors in everyday units."""
        fit = "no fit: it does not vary" if math.isnan(self.fit_percent) else ""
        return (
            f"`{self.record}`, `{self.output}` ({self.part}): "
            f"{fit or f'fit {self.fit_percent:.1f} %'}, rms error {self._amount(self.rms)}, "
            f"at most {self._amount(self.maximum)} at {self.where}, "
            f"bias {self._amount(self.bias)}."
        )

    @property
    def where(self) -> str:
        """Return the place of the largest error, in words."""
        return self.place or f"{format_number(self.maximum_at)} s"

    def to_dict(self) -> dict[str, Any]:
        """Return all fields by name, for JSON."""
        return asdict(self)

    def _amount(self, value: float) -> str:
        return format_change(value, self.unit, 3)


def score_model(
    times: Any, measured: Any, modelled: Any, *, record: str, output: str, unit: str = "1", part: str = "training"
) -> Score:
    """Compare a modelled with a measured output, both in SI, at the same times [s].

    `part` is `training` or `held-out`.

    Raises:
        DataError: the arrays are empty, not finite, or differ in length.
    """
    t, y, model = (np.asarray(row, np.float64) for row in (times, measured, modelled))
    if not 0 < t.size == y.size == model.size:
        raise DataError(
            f"Times, measured and modelled values of `{output}` must have equal lengths, "
            f"but have {t.size}, {y.size} and {model.size}."
        )
    if not np.isfinite([t, y, model]).all():
        raise DataError(f"Measured and modelled values of `{output}` must be finite.")
    error = model - y
    worst = int(np.argmax(np.abs(error)))
    varied = float(np.linalg.norm(y - y.mean()))
    size = float(np.linalg.norm(error))
    return Score(
        record,
        output,
        part,
        unit,
        rms=size / math.sqrt(y.size),
        fit_percent=100.0 * (1.0 - size / varied) if varied else math.nan,
        maximum=float(abs(error[worst])),
        maximum_at=float(t[worst]),
        bias=float(error.mean()),
        samples=y.size,
    )
