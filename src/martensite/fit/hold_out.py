"""What is kept back from a fit, to see how well it predicts.

auto     3 or more records: the middle one of the list, whole; fewer: four stretches of each,
the fifth, tenth, fifteenth and last of twenty equally long ones
none     nothing
25 %     the last quarter of each record (any share below 100 %)
A, B     records of these names
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from martensite.base.errors import InputError, UnknownNameError
from martensite.fit.free_parameters import split_list

Stretches = tuple[tuple[float, float], ...]
AUTO, NONE = "auto", "none"
ALL: Stretches = ((-math.inf, math.inf),)
MANY_RECORDS = 3
"""Records from which on a whole one is kept back."""
STRETCHES, KEPT = 20, (4, 9, 14, 19)


def choose_held_out(
    hold_out: str | Sequence[str], names: Sequence[str], times: Sequence[Sequence[float]]
) -> list[Stretches]:
    """Stretches of time that are kept back, for every record.

    Args:
        hold_out: see above.
        names: of the records.
        times: of their rows [s].

    Raises:
        InputError: a share that is none, an unknown record, or nothing left to fit.
    """
    if hold_out == AUTO:
        if len(names) >= MANY_RECORDS:
            return [ALL if k == len(names) // 2 else () for k in range(len(names))]
        return [_choose_stretches(rows) for rows in times]
    if hold_out == NONE:
        return [() for _ in names]
    if isinstance(hold_out, str) and hold_out.strip().endswith("%"):
        share = _read_share(hold_out)
        return [((rows[-1] - share * (rows[-1] - rows[0]), math.inf),) for rows in times]
    asked = split_list(hold_out)
    for name in asked:
        if name not in names:
            raise UnknownNameError("record to hold out", name, [*names, AUTO, NONE, "25 %"])
    if len(set(asked)) == len(names):
        raise InputError("All records are held out, and none is left to be fitted.")
    return [ALL if name in asked else () for name in names]


def _choose_stretches(times: Sequence[float]) -> Stretches:
    first, length = times[0], times[-1] - times[0]
    return tuple((first + k / STRETCHES * length, first + (k + 1) / STRETCHES * length) for k in KEPT)


def _read_share(text: str) -> float:
    try:
        share = float(text.strip().removesuffix("%")) / 100.0
    except ValueError:
        share = math.nan
    if not 0.0 < share < 1.0:
        raise InputError(f"A share to hold out must be between 0 and 100 %, but is `{text}`.")
    return share
