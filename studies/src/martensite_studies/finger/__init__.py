"""Study `finger`: a robotic finger bent by a shape-memory wire against a spring."""

from __future__ import annotations

from martensite_studies.finger.study import FingerStudy

__all__ = ["FingerStudy"]
