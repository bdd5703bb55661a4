"""What JSON can hold of a value."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any, cast


def convert_to_plain(value: Any) -> Any:
    """What JSON can hold: tables, lists, texts, finite numbers, null."""
    if isinstance(value, Mapping):
        return {str(k): convert_to_plain(v) for k, v in cast("Mapping[Any, Any]", value).items()}
    if hasattr(value, "tolist"):  # of NumPy
        return convert_to_plain(value.tolist())
    if isinstance(value, (list, tuple)):
        return [convert_to_plain(item) for item in cast("Sequence[Any]", value)]
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    return value if value is None or isinstance(value, (str, int)) else str(value)
