"""Sentences for what a kernel cannot do: where it stands, why not, what to write instead."""

from __future__ import annotations

import linecache
import re
import sys
from itertools import islice
from pathlib import Path
from types import FrameType

from martensite.base.errors import KernelError, UnknownOperationError, suggest_name
from martensite.kernels.namespace import OPERATIONS

_FUNCTIONS = ("abs", "cos", "exp", "log", "maximum", "minimum", "nearest", "power", "sin", "sqrt")
"""The operations that are functions of numbers, the usual ones."""
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
"""Functions of Python, `math` and NumPy -> what kernels call them."""
_CALL = re.compile(r"(?!xp\.)(?:\w+\.)*(\w+)\(")
_STANDARD = str(Path(linecache.__file__).parent)


def make_kernel_error(reason: str, instead: str = "", called: str = "") -> KernelError:
    """An error about what the kernel that is running just did.

    Args:
        reason: why that cannot be.
        instead: what to write, unless a function is called that kernels have too.
        called: name of that function, if it is not to be read from the source.
    """
    place, text = _find_place()
    call = _CALL.match(text)
    called = called or (call[1] if call else "")
    name = _SAME.get(called, called)
    if name in OPERATIONS:
        instead = f"`xp.{name}`"
    elif not instead:
        instead = f"one of {', '.join(f'`xp.{one}`' for one in _FUNCTIONS)}"
    shown = f"`{text}` in {place}" if text else f"In {place}"
    return KernelError(f"{shown}: {reason}; write {instead}.")


def make_operation_error(name: str) -> UnknownOperationError:
    """An error about an operation that kernels have not."""
    place, _ = _find_place()
    valid = suggest_name(name, [_SAME[name]] if name in _SAME else OPERATIONS)
    return UnknownOperationError(f"Kernels have no operation `{name}`, used in {place}. {valid}")


def _find_place() -> tuple[str, str]:
    """Where the kernel is that runs, and what is written there."""
    frame: FrameType = sys._getframe(2)  # pyright: ignore[reportPrivateUsage]
    while frame.f_back and not _is_kernel(frame):
        frame = frame.f_back
    code = frame.f_code
    name = code.co_qualname.replace(".<locals>", "")
    place = f"`{name}` ({Path(code.co_filename).name}, line {frame.f_lineno})"
    return place, _read_expression(frame)


def _is_kernel(frame: FrameType) -> bool:
    """Whether what runs is neither a runtime nor a library that the kernel calls."""
    file = frame.f_code.co_filename
    is_library = file.startswith(_STANDARD) and "site-packages" not in file
    module = str(frame.f_globals.get("__name__"))
    return not (is_library or module.startswith(("martensite.kernels", "numpy")))


def _read_expression(frame: FrameType) -> str:
    """The expression that a frame is in, as it is written; empty if that is not known."""
    places = islice(frame.f_code.co_positions(), frame.f_lasti // 2, None)
    line, last, start, end = next(places, (None,) * 4)
    if line is None or line != last:
        return ""
    text = linecache.getline(frame.f_code.co_filename, line)
    return text.encode()[start:end].decode().strip()
