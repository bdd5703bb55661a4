"""Study `hammerstein-wiener`: a wire identified in two stages, and a PID controller tuned on it."""

from __future__ import annotations

from martensite_studies.hammerstein_wiener.study import HammersteinWiener

__all__ = ["HammersteinWiener"]
