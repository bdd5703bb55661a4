"""Regimes of records: records unlike the first are set apart, predicted and not fitted.

A regime is defined by sample time, range and level of signals, and the best linear approximation of the dynamics.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from martensite.base.errors import MartensiteError
from martensite.identify.chains.best_linear import fit_linear_model
from martensite.identify.chains.decimation import coarsen_records
from martensite.identify.chains.goals import AUTO
from martensite.identify.chains.scores import fit_percent, free_run
from martensite.search.quantity_text import format_number
from martensite.signals.sampling.sampled import Sampled

RATIO = 2.0
"""Ratio of the ranges of an input above which the amplitude differs."""
SHIFT = 0.5
"""Shift of the middle of a signal, over the larger range, above which its level differs."""
FOREIGN = 2.0
"""Ratio of the errors of the linear models of another record and of the same record above which dynamics differ."""
POOR = 0.25
"""Least error over the spread of the output that counts as poor."""


def set_apart(records: Sequence[Sampled]) -> tuple[list[Sampled], dict[int, str]]:
    """Return the records of the regime of the first, and the reasons against the others, by their place."""
    first, together, apart = records[0], [records[0]], dict[int, str]()
    for place, record in enumerate(records[1:], start=1):
        reason = _explain_range(first, record) or _explain_dynamics(first, record)
        if reason:
            apart[place] = f"`{record.name}` is set apart from `{first.name}`: {reason}. It is predicted, not fitted."
        else:
            together.append(record)
    return together, apart


def _explain_range(first: Sampled, record: Sampled) -> str:
    """Describe differences in sample time, amplitude and level; empty if they agree."""
    if abs(record.interval / first.interval - 1.0) > 1e-6:
        return f"its sample time is {record.interval:.4g} s, not {first.interval:.4g} s"
    pairs = zip((*first.inputs.T, *first.outputs.T), (*record.inputs.T, *record.outputs.T), strict=True)
    names = (*first.input_names, *first.output_names)
    for k, (name, (a, b)) in enumerate(zip(names, pairs, strict=True)):
        low, high = ((float(np.nanmin(x)), float(np.nanmax(x))) for x in (a, b))
        ranges = f"{_write_range(high)}, not {_write_range(low)}"
        wide = sorted((low[1] - low[0], high[1] - high[0]))
        if k < len(first.input_names) and wide[1] > RATIO * wide[0]:
            return f"the amplitude of `{name}` is another, {ranges}"
        if abs(sum(low) - sum(high)) / 2.0 > SHIFT * max(wide[1], 1e-300):
            return f"the level of `{name}` is another, {ranges}"
    return ""


def _write_range(ends: tuple[float, float]) -> str:
    return " to ".join(format_number(end, 3) for end in ends)


def _explain_dynamics(first: Sampled, record: Sampled) -> str:
    """Describe different dynamics; empty if the linear models agree."""
    try:
        ours, its = coarsen_records([first, record], 2000)
        model, its_model = (fit_linear_model(one, 2, iterations=20) for one in (ours, its))
        fits = [float(np.mean(fit_percent(its.outputs, free_run(m, its, AUTO)))) for m in (model, its_model)]
    except MartensiteError:
        return ""
    errors = [1.0 - fit / 100.0 for fit in fits]
    if errors[0] > FOREIGN * errors[1] and errors[0] > POOR:
        return (
            f"its dynamics are others: the linear model of `{first.name}` fits it to {fits[0]:.0f} %, one of its own "
            f"to {fits[1]:.0f} %"
        )
    return ""
