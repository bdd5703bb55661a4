"""Study `finger-calibration`: what the calibration test of the finger can and cannot tell."""

from __future__ import annotations

from martensite_studies.finger_calibration.study import FingerCalibration

__all__ = ["FingerCalibration"]
