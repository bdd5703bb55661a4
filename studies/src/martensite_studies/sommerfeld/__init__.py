"""Study `sommerfeld`: a motor on a beam, and a wire against it, Kossoski's thesis."""

from __future__ import annotations

from martensite_studies.sommerfeld.study import Sommerfeld

__all__ = ["Sommerfeld"]
