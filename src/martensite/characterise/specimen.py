"""Strain and stress of a specimen from the travel and the force of a testing machine."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from martensite.base.errors import DataError
from martensite.logs.layout import list_quantities
from martensite.signals.records import Record


def add_strain_and_stress(record: Record, length: float | None = None, diameter: float | None = None) -> Record:
    """Return a record with strain and stress, from its travel and force where these columns are missing.

    A travel that grows on heating is taken as shortening.

    Args:
        record: columns `temperature` [K], and `strain` [-] or a travel [m].
        length: gauge length [m].
        diameter: diameter of the wire [m].

    Raises:
        DataError: a travel has no gauge length.
    """
    columns, units = dict(record.columns), dict(record.units)
    if "strain" not in columns:
        name = next((one for one in list_quantities("shape") if one in columns), "")
        if name and length is None:
            raise DataError(
                f"Record `{record.name}` has no column `strain` but `{name}`: give the gauge length (`--length`)."
            )
        if name and length is not None:
            travel = columns[name] / length
            falls = float(np.corrcoef(travel, record["temperature"])[0, 1]) <= 0.0
            columns["strain"], units["strain"] = travel if falls else -travel, "1"
    if "stress" not in columns and "force" in columns and diameter is not None:
        area = math.pi / 4.0 * diameter**2
        columns["stress"], units["stress"] = columns["force"] / area, "Pa"
    return replace(record, columns=columns, units=units)
