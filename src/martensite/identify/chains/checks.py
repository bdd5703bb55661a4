"""What records must hold before a chain is estimated from them; one clear sentence if not."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from martensite.base.errors import InputError
from martensite.identify.chains.chain import Chain
from martensite.signals.sampling.sampled import Sampled


def check_records(records: Sequence[Sampled]) -> None:
    """Raise `InputError` unless the records can be fitted together."""
    if not records:
        raise InputError("An estimation needs at least one record.")
    first = records[0]
    for record in records[1:]:
        if abs(record.interval / first.interval - 1.0) > 1e-6:
            raise InputError(
                f"Records fitted together need one sample time, but `{first.name}` has "
                f"{first.interval:.6g} s and `{record.name}` {record.interval:.6g} s."
            )
        if (record.input_names, record.output_names) != (first.input_names, first.output_names):
            raise InputError(f"Records `{first.name}` and `{record.name}` have different inputs or outputs.")


def check_informative(records: Sequence[Sampled], skip: int, start: str) -> None:
    """Raise `InputError` if a signal says nothing: an input that never moves, an empty output.

    Inputs may be constant where initial states are estimated: a free motion says something.
    """
    first = records[0]
    u = np.concatenate([record.inputs for record in records])
    y = np.concatenate([record.outputs[skip:] for record in records])
    for name, column in zip(first.input_names, u.T, strict=True):
        if start != "estimate" and np.ptp(column) == 0.0:
            raise InputError(
                f"Input `{name}` is {column[0]:g} throughout; nothing can be found from an input that never changes."
            )
    for name, column in zip(first.output_names, y.T, strict=True):
        known = column[np.isfinite(column)]
        if not len(known):
            raise InputError(f"Output `{name}` has no known samples that count.")
        if np.ptp(known) == 0.0:
            raise InputError(f"Output `{name}` is {known[0]:g} throughout; there is nothing to fit.")


def check_enough(chain: Chain, records: Sequence[Sampled], skip: int) -> None:
    """Raise `InputError` if there are fewer known outputs than free numbers."""
    known = sum(int(np.isfinite(r.outputs[skip:]).sum()) for r in records)
    if known < len(chain.theta):
        raise InputError(
            f"`{chain.text()}` has {len(chain.theta)} free numbers, but the records hold {known} "
            "known outputs that count; take longer records or a smaller structure."
        )
