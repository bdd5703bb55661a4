"""Angles of a pulley or lever as travel of the element: position = radius × angle."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from martensite.base import units
from martensite.fit.experiment_kinds.survey import DEFORMATIONS, LogSurvey
from martensite.fit.experiment_kinds.values import with_column, write_value
from martensite.signals.records import Record

RADIUS, ASSUMED = "mechanism.radius", 10e-3
"""Setting of the radius on which an element is wound, and its assumed value [m]."""


def wind_angles(
    records: Sequence[Record], settings: Mapping[str, Any]
) -> tuple[list[Record], dict[str, Any], list[str]]:
    """Return records with a position from their angle, if it is their only shape.

    Args:
        records: records in SI.
        settings: values by dotted path; `mechanism.radius` is the radius.

    Returns:
        The records, the settings without the radius if it was used, and notes.
    """
    varying = LogSurvey(records).varying
    angled = all("angle" in one.columns for one in records) and "angle" in varying
    if not angled or any(name in one.columns for one in records for name in DEFORMATIONS):
        return list(records), dict(settings), []
    given = RADIUS in settings
    radius = units.parse_quantity(str(settings[RADIUS]), "m") if given else ASSUMED
    wound = [with_column(one, "position", "m", radius * np.asarray(one["angle"], float)) for one in records]
    if given:
        return wound, {path: text for path, text in settings.items() if path != RADIUS}, []
    effect = "travel, transformation strain and length are counted from it"
    return wound, dict(settings), [f"`{RADIUS}` is assumed to be {write_value(ASSUMED, 'm')}: {effect}."]
