"""What numbers in a trace refuse: everything that would need their value, which they have not got.

Nodes of a graph and dual numbers stand for numbers that come later. Python and NumPy would ask them
for a value, take them for true, or compare them as objects; each such question is answered by a
sentence that says what to write instead. Plain floats answer Python's way: a kernel that is called
with floats by hand is not looked at.
"""

from __future__ import annotations

from typing import Any, ClassVar, NoReturn

from martensite.kernels.kernel_errors import make_kernel_error
from martensite.kernels.powers import expand_power, find_whole_exponent

BRANCH = "a kernel must not branch on a value, as `if`, `while`, `and`, `or`, `not`, `a < b < c`, `min` and `max` do"
CHOICES = "`xp.where(condition, a, b)`, `xp.both`, `xp.either`, `xp.negate`, `xp.minimum` or `xp.maximum`"
VALUE = "a number of a kernel has no value that `float`, `int` or a function of `math` could take"
COUNT = "a kernel must not count or choose by a value: loops are of fixed count"
ROUND = "a kernel does not round in Python's way"
ITEMS = "a number of a kernel is one number and has no items"
EQUAL = "numbers of a kernel are not compared by `==` and `!=`, which rounding would decide"
WHOLE = "only whole numbers that are written down, as in `x ** 3`, are exponents behind `**`"
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
"""Operators of NumPy with one of its numbers on their left -> what answers on the right."""


class TracedNumber:
    """A number whose value is not known while a kernel is traced."""

    __slots__ = ()
    takes_arrays: ClassVar[bool] = False
    """Whether arrays may be numbers beside it."""

    def __bool__(self) -> bool:
        raise make_kernel_error(BRANCH, CHOICES)

    # ---------------------------------------------------------------- powers

    def __pow__(self, exponent: Any) -> Any:
        whole = None if isinstance(exponent, TracedNumber) else find_whole_exponent(exponent)
        if whole is None:
            raise make_kernel_error(WHOLE, "`xp.power(x, y)`, for x above 0")
        return expand_power(self, whole)

    def __rpow__(self, base: Any) -> NoReturn:
        raise make_kernel_error(WHOLE, "`xp.power(x, y)`, for x above 0")

    # ---------------------------------------------------------------- values

    def __float__(self) -> float:
        raise make_kernel_error(VALUE)

    def __int__(self) -> int:
        raise make_kernel_error(VALUE, "`xp.nearest(x)`")

    def __complex__(self) -> complex:
        raise make_kernel_error(VALUE)

    def __index__(self) -> int:
        raise make_kernel_error(COUNT, "`for i in range(8)` with a count of your own, and `xp.where(condition, a, b)`")

    def __round__(self, digits: Any = None) -> NoReturn:
        raise make_kernel_error(ROUND, "`xp.nearest(x)`")

    def __floor__(self) -> NoReturn:
        raise make_kernel_error(ROUND, "`xp.nearest(x - 0.5)`")

    def __ceil__(self) -> NoReturn:
        raise make_kernel_error(ROUND, "`xp.nearest(x + 0.5)`")

    def __trunc__(self) -> NoReturn:
        raise make_kernel_error(ROUND, "`xp.nearest(x)`")

    def __floordiv__(self, other: Any) -> NoReturn:
        raise make_kernel_error("kernels have no `//` and no `%`", "`xp.nearest(x / y)`")

    __rfloordiv__ = __mod__ = __rmod__ = __divmod__ = __rdivmod__ = __floordiv__

    def __abs__(self) -> NoReturn:
        raise make_kernel_error("kernels take sizes by an operation of their own", "`xp.abs(x)`")

    def __format__(self, form: str) -> str:
        if not form:
            return repr(self)
        raise make_kernel_error(VALUE, "`{x}` without a format")

    # ---------------------------------------------------------------- comparisons and conditions

    def __eq__(self, other: object) -> bool:
        raise make_kernel_error(EQUAL, "`xp.abs(a - b) <= limit`")

    def __ne__(self, other: object) -> bool:
        raise make_kernel_error(EQUAL, "`xp.abs(a - b) > limit`")

    __hash__ = object.__hash__

    def __and__(self, other: Any) -> NoReturn:
        raise make_kernel_error(BITS, "`xp.both(a, b)`, `xp.either(a, b)` or `xp.negate(a)`")

    __rand__ = __or__ = __ror__ = __xor__ = __rxor__ = __and__

    def __invert__(self) -> NoReturn:
        raise make_kernel_error(BITS, "`xp.negate(a)`")

    # ---------------------------------------------------------------- items and arrays

    def __iter__(self) -> NoReturn:
        raise make_kernel_error(ITEMS, "a tuple of numbers")

    def __len__(self) -> int:
        raise make_kernel_error(ITEMS, "a tuple of numbers")

    def __getitem__(self, place: Any) -> NoReturn:
        raise make_kernel_error(ITEMS, "a tuple of numbers")

    def __array__(self, *_: Any, **__: Any) -> NoReturn:
        raise make_kernel_error(ARRAYS, LOOPS)

    def __array_ufunc__(self, ufunc: Any, method: str, *inputs: Any, **options: Any) -> Any:
        """What NumPy's numbers, on the left of an operator, or its functions make of it."""
        reflected = _REFLECTED.get(ufunc.__name__)
        if reflected is None or method != "__call__" or options:
            raise make_kernel_error(ARRAYS, called=ufunc.__name__)
        if self.takes_arrays or getattr(inputs[0], "shape", None) == ():
            return getattr(self, reflected)(inputs[0])
        raise make_kernel_error(ARRAYS, LOOPS)
