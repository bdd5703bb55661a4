"""Numbers of the record: offset, counter, and the resistance of run 5."""

from __future__ import annotations

from typing import Any

from martensite.studies.electrothermal import record
from martensite.studies.electrothermal.record import RecordStaircase
from martensite.studies.tables import Printed

ALL_COLD = (1.0, 2.2)
"""All plateaus below the drop [V]."""
SHORTER = (1.3, 2.0)
MILD, STEEP = (2.5, 3.5), (4.4, 5.4)
"""Two ranges of the trained run [V]."""


def compute_record(stated: Printed) -> dict[str, Any]:
    """Return the numbers of all available files."""
    numbers = compute_run_5(stated) if record.has_files(record.UNTRAINED, record.WARMTH) else {}
    return numbers | (compute_trained() if record.has_files(record.TRAINED) else {})


def compute_run_5(stated: Printed) -> dict[str, float]:
    """Return the offset, resistances and drop of run 5."""
    run = RecordStaircase(stated)
    offset, (low, high) = run.offset(*stated.cold), run.extremes(*stated.cold)
    start, end = run.drop()
    austenite = run.mean(*stated.hot)
    return {
        "offset": offset.offset,
        "offset_error": offset.offset_error,
        "offset_shorter": run.offset(*SHORTER).offset,
        "offset_all": run.offset(*ALL_COLD).offset,
        "counter": float(run.jumps()),
        "martensite_low": low,
        "martensite_high": high,
        "martensite_lowest": run.extremes(*ALL_COLD)[0],
        "austenite": austenite,
        "per_metre_highest": high / stated.length,
        "per_metre_lowest": low / stated.length,
        "per_metre_austenite": austenite / stated.length,
        "drop_start": start,
        "drop_end": end,
        "rise": run.rise(),
    }


def compute_trained() -> dict[str, float]:
    """Return the offset and slopes of the trained wire."""
    mild, steep = record.trained_slopes(MILD, STEEP)
    return {"trained_offset": mild.offset, "trained_slope_low": mild.resistance, "trained_slope_high": steep.resistance}
