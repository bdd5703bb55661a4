"""Study `platform`: a parallel platform turned about two axes by shape-memory springs."""

from __future__ import annotations

from martensite_studies.platform.study import Platform

__all__ = ["Platform"]
