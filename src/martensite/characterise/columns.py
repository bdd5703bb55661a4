"""Checks that all tests share: columns of equal length, enough rows, finite numbers."""

from __future__ import annotations

import math
from collections.abc import Sequence

from martensite.base.errors import DataError


def check_columns(test: str, rows: str, fewest: int, **columns: Sequence[float]) -> None:
    """Raise `DataError` unless columns are equally long, long enough and finite.

    Args:
        test: what is computed from them, as "a time constant".
        rows: what a row is called, in the plural.
        fewest: least number of rows.
        columns: the columns by their names.
    """
    lengths = [len(numbers) for numbers in columns.values()]
    names = " and ".join(columns).replace("_", " ")
    if len(set(lengths)) > 1:
        listed = " and ".join(map(str, lengths))
        raise DataError(f"The {names} of {test} must be equally many, but are {listed}.")
    if lengths[0] < fewest:
        raise DataError(f"A fit of {test} needs at least {fewest} {rows}, but has {lengths[0]}.")
    if not all(math.isfinite(number) for column in columns.values() for number in column):
        raise DataError(f"The {names} of {test} must be finite, but are not all.")
