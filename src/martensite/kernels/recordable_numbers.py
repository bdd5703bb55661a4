"""Functions on floats, or on numbers that `record` what is done with them: by these the bench draws in the browser."""

from __future__ import annotations

import math
from typing import Any

from martensite.kernels import floats


class RecordableFunctions:
    """The operations of kernels, and the functions of `math`."""

    def __getattr__(self, name: str) -> Any:
        plain = getattr(floats, name, None) or getattr(math, name)

        def apply(*numbers: Any) -> Any:
            recorder = next((one for one in numbers if hasattr(one, "record")), None)
            return plain(*numbers) if recorder is None else recorder.record(name, plain, numbers)

        self.__dict__[name] = apply
        return apply


xp: Any = RecordableFunctions()
"""A namespace of kernels that does not mind which of both it gets."""
