"""Doubts about records and their models, one sentence each: copied inputs, exchanged columns, initial motion."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from martensite.base.errors import MartensiteError
from martensite.identify.blocks.base import Numbers
from martensite.identify.blocks.transfer_function import TransferFunction
from martensite.identify.chains.best_linear import fit_linear_model, polish_linear
from martensite.identify.chains.decimation import coarsen_records
from martensite.identify.chains.residuals import RecordResidual, ResidualSquares, settle_states
from martensite.identify.chains.scores import fit_percent
from martensite.signals.sampling.sampled import Sampled

EXACT = 1e-6
"""Relative residual of a line in the input below which an output is a copy."""
POOR = 80.0
"""Fit below which exchanged columns are tested [%]."""
BETTER = 20.0
"""Least improvement of the fit by exchanged columns [points]."""
MOVING = 0.8
"""Squared error of a linear model from the best state, over the steady state, below which a record starts in motion."""


def describe_copies(records: Sequence[Sampled]) -> Iterator[str]:
    """Yield a sentence for every output that is a copy of an input."""
    for record in records:
        for source, u in zip(record.input_names, record.inputs.T, strict=True):
            for name, y in zip(record.output_names, record.outputs.T, strict=True):
                finite_rows = np.isfinite(y)
                if (
                    finite_rows.sum() > 2
                    and np.ptp(u[finite_rows]) > 0.0
                    and _measure_rest(u[finite_rows], y[finite_rows]) < EXACT
                ):
                    yield (
                        f"{record.name}: output `{name}` is input `{source}` again, but for a factor and an offset; "
                        "there is nothing to be found. Is it the column that was meant?"
                    )


def _measure_rest(u: Numbers, y: Numbers) -> float:
    spread = float(np.std(y))
    left = y - np.polyval(np.polyfit(u, y, 1), u)
    return float(np.std(left)) / spread if spread > 0.0 else 1.0


def describe_exchange(records: Sequence[Sampled], fit: float) -> Iterator[str]:
    """Yield a sentence for every record whose output explains the input better than the input the output."""
    if fit >= POOR or any(r.inputs.shape[1] != 1 or r.outputs.shape[1] != 1 for r in records):
        return
    for record in coarsen_records(records):
        if not np.all(np.isfinite(record.outputs)) or np.ptp(record.outputs) == 0.0 or np.ptp(record.inputs) == 0.0:
            continue
        turned = Sampled(
            record.name, record.interval, record.outputs, record.inputs, record.output_names, record.input_names
        )
        ahead, back = _fit_linear(record), _fit_linear(turned)
        if back > max(ahead, fit) + BETTER:
            input_name, name = record.input_names[0], record.output_names[0]
            yield (
                f"{record.name}: a linear model gives `{input_name}` from `{name}` with a fit of {back:.0f} %, but "
                f"`{name}` from `{input_name}` with {ahead:.0f} %: are input and output exchanged?"
            )


def describe_motion(records: Sequence[Sampled]) -> Iterator[str]:
    """Yield a sentence for every record that a linear model fits much better from a non-steady state."""
    for record in coarsen_records(records) if records else ():
        if (record.inputs.shape[1], record.outputs.shape[1]) != (1, 1):
            continue
        errors: list[float] = []
        for start in ("rest", "estimate"):
            try:
                model = polish_linear(TransferFunction(nb=2, nf=2, nk=1), [record], start, iterations=30)
            except MartensiteError:
                break
            squares = ResidualSquares(model.engine, [RecordResidual(record, start=start)])
            errors.append(settle_states(squares, model.theta, 10).value)
        if len(errors) == 2 and errors[1] < MOVING * errors[0]:
            yield (
                f"{record.name}: it does not begin at rest, as a linear model repeats it much better from another "
                "state; let the state be found with the model (--initial auto or estimate)."
            )


def _fit_linear(record: Sampled) -> float:
    """Return the fit of a linear model of second order [%]."""
    try:
        model = fit_linear_model(record, 2, iterations=20)
    except MartensiteError:
        return -np.inf
    return float(fit_percent(record.outputs, model.simulate(record.inputs))[0])
