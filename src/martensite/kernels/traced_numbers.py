"""Operations that traced numbers reject, because their values do not exist yet.

Python and NumPy may ask graph nodes and dual numbers for a value, a truth value or a comparison. Each such operation
raises an error with the kernel, the reason and the replacement. Kernels called with plain floats are not checked.
"""

from __future__ import annotations

import linecache
import re
import sys
from collections.abc import Callable
from itertools import islice
from pathlib import Path
from types import FrameType
from typing import Any, ClassVar, NoReturn

from martensite.base.errors import KernelError, UnknownOperationError, suggest_name
from martensite.kernels.floats import expand_power, find_whole_exponent
from martensite.kernels.namespace import OPERATIONS

BRANCH = "a kernel must not branch on a value, as `if`, `while`, `and`, `or`, `not`, `a < b < c`, `min` and `max` do"
CHOICES = "`xp.where(condition, a, b)`, `xp.both`, `xp.either`, `xp.negate`, `xp.minimum` or `xp.maximum`"
VALUE = "a number of a kernel has no value that `float`, `int` or a function of `math` could take"
COUNT = "a kernel must not count or choose by a value: loops are of fixed count"
ROUND = "a kernel does not round in Python's way"
ITEMS = "a number of a kernel is one number and has no items"
EQUAL = "numbers of a kernel are not compared by `==` and `!=`, which rounding would decide"
WHOLE = "only whole numbers that are written down, as in `x ** 3`, are exponents behind `**`"
POWER = "`xp.power(x, y)`, for x above 0"
BITS = "`&`, `|`, `^` and `~` are not for the conditions of a kernel"
ARRAYS = "functions and arrays of NumPy are not for numbers of a kernel"
LOOPS = "a loop over a tuple of numbers, with operations such as `xp.sin`"
_REFLECTED = {
    "add": "__radd__",
    "subtract": "__rsub__",
    "multiply": "__rmul__",
    "divide": "__rtruediv__",
    "less": "__gt__",
    "less_equal": "__ge__",
    "greater": "__lt__",
    "greater_equal": "__le__",
}
"""NumPy operator with a NumPy number on the left -> reflected operator."""
_FUNCTIONS = ("abs", "cos", "exp", "log", "maximum", "minimum", "nearest", "power", "sin", "sqrt")
"""Functions among the operations."""
_SAME = {
    "max": "maximum",
    "min": "minimum",
    "fmax": "maximum",
    "fmin": "minimum",
    "fabs": "abs",
    "absolute": "abs",
    "round": "nearest",
    "rint": "nearest",
    "pow": "power",
    "logical_and": "both",
    "logical_or": "either",
    "logical_not": "negate",
}
"""Functions of Python, `math` and NumPy -> their names in kernels."""
_CALL = re.compile(r"(?!xp\.)(?:\w+\.)*(\w+)\(")
_STANDARD = str(Path(linecache.__file__).parent)


def make_kernel_error(reason: str, instead: str = "", called: str = "") -> KernelError:
    """Return an error about an unsupported operation of the running kernel.

    The message has a replacement, unless kernels also have the function. A missing function name is read from the
    source.
    """
    place, text = _find_place()
    call = _CALL.match(text)
    called = called or (call[1] if call else "")
    name = _SAME.get(called, called)
    if name in OPERATIONS:
        instead = f"`xp.{name}`"
    elif not instead:
        instead = f"one of {', '.join(f'`xp.{one}`' for one in _FUNCTIONS)}"
    location = f"`{text}` in {place}" if text else f"In {place}"
    return KernelError(f"{location}: {reason}; write {instead}.")


def make_operation_error(name: str) -> UnknownOperationError:
    """Return an error about an operation that kernels do not have."""
    place, _ = _find_place()
    valid = suggest_name(name, [_SAME[name]] if name in _SAME else OPERATIONS)
    return UnknownOperationError(f"Kernels have no operation `{name}`, used in {place}. {valid}")


def _find_place() -> tuple[str, str]:
    """Return the running kernel, its location, and its source line."""
    frame: FrameType = sys._getframe(2)
    while frame.f_back and not _is_kernel(frame):
        frame = frame.f_back
    code = frame.f_code
    name = code.co_qualname.replace(".<locals>", "")
    place = f"`{name}` ({Path(code.co_filename).name}, line {frame.f_lineno})"
    return place, _read_expression(frame)


def _is_kernel(frame: FrameType) -> bool:
    """Return whether a frame belongs to a kernel, and not to a runtime or library."""
    file = frame.f_code.co_filename
    is_library = file.startswith(_STANDARD) and "site-packages" not in file
    module = str(frame.f_globals.get("__name__"))
    return not (is_library or module.startswith(("martensite.kernels", "numpy")))


def _read_expression(frame: FrameType) -> str:
    """Return the source expression of a frame; empty if unknown."""
    places = islice(frame.f_code.co_positions(), frame.f_lasti // 2, None)
    line, last, start, end = next(places, (None,) * 4)
    if line is None or line != last:
        return ""
    text = linecache.getline(frame.f_code.co_filename, line)
    return text.encode()[start:end].decode().strip()


def refuse(reason: str, instead: str = "") -> Callable[..., Any]:
    """Return a special method that raises the error for its operation."""

    def refused(*_: Any, **__: Any) -> NoReturn:
        raise make_kernel_error(reason, instead)

    return refused


class TracedNumber:
    """Number with an unknown value while a kernel is traced."""

    __slots__ = ()
    takes_arrays: ClassVar[bool] = False
    """True if arrays may be operands."""

    __bool__ = refuse(BRANCH, CHOICES)
    __float__ = __complex__ = refuse(VALUE)
    __int__ = refuse(VALUE, "`xp.nearest(x)`")
    __index__ = refuse(COUNT, "`for i in range(8)` with a count of your own, and `xp.where(condition, a, b)`")
    __round__ = __trunc__ = refuse(ROUND, "`xp.nearest(x)`")
    __floor__ = refuse(ROUND, "`xp.nearest(x - 0.5)`")
    __ceil__ = refuse(ROUND, "`xp.nearest(x + 0.5)`")
    __floordiv__ = __rfloordiv__ = refuse("kernels have no `//` and no `%`", "`xp.nearest(x / y)`")
    __mod__ = __rmod__ = __divmod__ = __rdivmod__ = __floordiv__
    __abs__ = refuse("kernels take sizes by an operation of their own", "`xp.abs(x)`")
    __rpow__ = refuse(WHOLE, POWER)
    __eq__ = refuse(EQUAL, "`xp.abs(a - b) <= limit`")
    __ne__ = refuse(EQUAL, "`xp.abs(a - b) > limit`")
    __hash__ = object.__hash__
    __and__ = refuse(BITS, "`xp.both(a, b)`, `xp.either(a, b)` or `xp.negate(a)`")
    __rand__ = __or__ = __ror__ = __xor__ = __rxor__ = __and__
    __invert__ = refuse(BITS, "`xp.negate(a)`")
    __iter__ = __len__ = __getitem__ = refuse(ITEMS, "a tuple of numbers")
    __array__ = refuse(ARRAYS, LOOPS)

    def __pow__(self, exponent: Any) -> Any:
        whole = None if isinstance(exponent, TracedNumber) else find_whole_exponent(exponent)
        if whole is None:
            raise make_kernel_error(WHOLE, POWER)
        return expand_power(self, whole)

    def __format__(self, form: str) -> str:
        if not form:
            return repr(self)
        raise make_kernel_error(VALUE, "`{x}` without a format")

    def __array_ufunc__(self, ufunc: Any, method: str, *inputs: Any, **options: Any) -> Any:
        """Apply an operator with a NumPy number on the left, or a function of NumPy."""
        reflected = _REFLECTED.get(ufunc.__name__)
        if reflected is None or method != "__call__" or options:
            raise make_kernel_error(ARRAYS, called=ufunc.__name__)
        if self.takes_arrays or getattr(inputs[0], "shape", None) == ():
            return getattr(self, reflected)(inputs[0])
        raise make_kernel_error(ARRAYS, LOOPS)
