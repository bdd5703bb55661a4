"""Numbers of the model, without a fit and with three calibrated parameters."""

from __future__ import annotations

from functools import cache
from typing import Any

from martensite.studies.electrothermal import model, record
from martensite.studies.electrothermal.model import RecordCalibration
from martensite.studies.electrothermal.record import RecordStaircase
from martensite.studies.tables import Printed

KEPT = (1.3, 4.5)
"""Compared plateaus [V]: all but the three lowest."""


@cache
def calibrate_numbers(stated: Printed) -> RecordCalibration:
    """Return the calibrated parameters."""
    return model.calibrate_model(RecordStaircase(stated))


def compute_model(stated: Printed) -> dict[str, Any]:
    """Return numbers that need no record, then calibration and differences."""
    start, end = model.find_span(model.predict_plateaus("maker", stated))
    per_ohm = model.get_wire().length / model.get_wire().section()
    horizontal, vertical = model.free_films()
    with_record = record.has_files(record.UNTRAINED, record.WARMTH)
    return {
        "maker_martensite": float(model.read_number("rho_M") * per_ohm),
        "maker_austenite": float(model.read_number("rho_A") * per_ohm),
        "maker_start": start,
        "maker_end": end,
        "film_horizontal": horizontal,
        "film_vertical": vertical,
        "differences": [
            {"key": key, "meaning": meaning} | ({"rms": compute_rms(key, stated)} if with_record else {})
            for key, meaning in model.VARIANTS.items()
        ],
    } | (compute_calibrated(stated) if with_record else {})


def compute_calibrated(stated: Printed) -> dict[str, float]:
    """Return resistivities, film coefficient, and the resulting currents."""
    calibration = calibrate_numbers(stated)
    start, end = model.find_span(model.predict_plateaus("calibrated", stated, calibration))
    return {
        "rho_martensite": calibration.rho_M,
        "rho_austenite": calibration.rho_A,
        "film": calibration.h,
        "calibrated_start": start,
        "calibrated_end": end,
    }


def compute_rms(key: str, stated: Printed) -> float:
    """Return the RMS difference of the resistance of a variant from the record [ohm]."""
    fitted = calibrate_numbers(stated) if key == "calibrated" else None
    return model.resistance_rms(model.predict_plateaus(key, stated, fitted), RecordStaircase(stated), *KEPT)
