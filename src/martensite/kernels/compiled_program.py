"""Traced programs in C, called from Python: constants once, then arrays in and arrays out.

Arrays are laid out [variable][lane], one lane for a single run. Marches add more C, which calls the functions of the
program as `k_NAME(n, c, x, y)`.
"""

from __future__ import annotations

import ctypes
from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np

from martensite.kernels.c99 import c_source
from martensite.kernels.c99_lanes import BLOCK, lanes_source
from martensite.kernels.compiler import load_library
from martensite.kernels.compute_once import cache_answers
from martensite.kernels.program import Program

_CALL = """
void call_{name}(long n, const double *restrict c, const double *restrict x, double *restrict y) {{
    k_{name}(n, c, x, y);
}}"""


class CompiledProgram:
    """Some functions of a program in C, for a table of parameters.

    The lanes must be fewer than `BLOCK`, or a multiple of it: vectors are full then.
    """

    def __init__(self, program: Program, names: tuple[str, ...], table: Any, added: str = "") -> None:
        """Compile named functions, and C behind them, for a table (parameters, lanes), or take what was compiled."""
        self.lanes = table.shape[1]
        self.library = _load_program(program, names, added, self.lanes >= BLOCK)
        self.constants = np.empty((program.constants, self.lanes))
        """Values that depend on the parameters alone."""
        self.set_table(table)

    def set_table(self, table: Any) -> None:
        """Other values of the parameters, (parameters, lanes)."""
        held = np.ascontiguousarray(table, float)
        lanes, (values, constants) = self.lanes, map(get_address, (held, self.constants))
        self.library.call_prepare(ctypes.c_long(lanes), values, constants, constants)

    def bind(self, name: str, x: Any, y: Any) -> Callable[[], None]:
        """Return a function that computes results y, (results, lanes), from the present inputs x."""
        function = getattr(self.library, f"call_{name}")
        arrays = map(get_address, (self.constants, x, y))
        return partial(function, ctypes.c_long(self.lanes), *arrays)


def get_address(array: Any) -> ctypes.c_void_p:
    """Return the address of an array in C's order, which keeps the array as long as it is there itself."""
    return array.ctypes.data_as(ctypes.c_void_p)


@cache_answers(64)
def _load_program(program: Program, names: tuple[str, ...], added: str, full: bool) -> Any:
    """For few lanes, or for full blocks of them, as vectors."""
    write = lanes_source if full else c_source
    calls = [_CALL.format(name=name) for name in names]
    prepare = _CALL.format(name="prepare").replace("k_prepare(n, c, x, y)", "k_prepare(n, c, y)")
    source = write(program, [program.functions[name] for name in names])
    return load_library("\n".join([source, prepare, *calls, added]))
