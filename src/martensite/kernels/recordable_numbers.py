"""Functions on floats, on arrays, or on numbers that `record` operations for the drawings of the bench."""

from __future__ import annotations

import math
from functools import cache
from importlib import import_module
from typing import Any

from martensite.kernels import floats
from martensite.kernels.arrays import ArrayNamespace


class RecordableFunctions:
    """Operations of kernels, and functions of `math`."""

    def __getattr__(self, name: str) -> Any:
        plain = getattr(floats, name, None) or getattr(math, name)

        def apply(*numbers: Any) -> Any:
            recorder = next((one for one in numbers if hasattr(one, "record")), None)
            if recorder is not None:
                return recorder.record(name, plain, numbers)
            if any(hasattr(one, "__array_interface__") for one in numbers):
                return getattr(_get_arrays(), name)(*numbers)
            return plain(*numbers)

        self.__dict__[name] = apply
        return apply


@cache
def _get_arrays() -> ArrayNamespace:
    return ArrayNamespace(import_module("numpy"))


xp: Any = RecordableFunctions()
"""Namespace of kernels for any of these numbers."""
