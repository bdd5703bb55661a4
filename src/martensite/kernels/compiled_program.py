"""Traced programs in C, called from Python with arrays as inputs and outputs.

Arrays have the layout [variable][batch element], with one element for a single run. Time integration adds C code that
calls the functions of the program as `k_NAME(n, c, x, y)`.
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
    """Compiled functions of a program, for a table of parameters.

    The batch must be smaller than `BLOCK` or a multiple of it, so that vectors are full.
    """

    def __init__(
        self, program: Program, names: tuple[str, ...], table: Any, added: str = "", soon: bool = False
    ) -> None:
        """Compile named functions and further C for a table (parameters, batch), or reuse the compiled library.

        With `soon`, C without vectors is used, at first from the quick compiler, for short runs.
        """
        self.lanes = table.shape[1]
        self.library = _load_program(program, names, added, min(self.lanes, BLOCK), soon)
        self.constants = np.empty((program.constants, self.lanes))
        """Values that depend on the parameters alone."""
        self.set_table(table)

    def set_table(self, table: Any) -> None:
        """Replace the values of the parameters, (parameters, batch)."""
        contiguous_table = np.ascontiguousarray(table, float)
        lanes, (values, constants) = self.lanes, map(get_address, (contiguous_table, self.constants))
        self.library.call_prepare(ctypes.c_long(lanes), values, constants, constants)

    def bind(self, name: str, x: Any, y: Any) -> Callable[[], None]:
        """Return a function that computes results y, (results, batch), from the present inputs x."""
        function = getattr(self.library, f"call_{name}")
        arrays = map(get_address, (self.constants, x, y))
        return partial(function, ctypes.c_long(self.lanes), *arrays)


def get_address(array: Any) -> ctypes.c_void_p:
    """Return the address of a C-contiguous array, which keeps the array alive."""
    return array.ctypes.data_as(ctypes.c_void_p)


@cache_answers(64)
def _load_program(program: Program, names: tuple[str, ...], added: str, lanes: int, soon: bool) -> Any:
    """Load the program for a single run, a small batch, or with vectors for full blocks."""
    calls = [_CALL.format(name=name) for name in names]
    prepare = _CALL.format(name="prepare").replace("k_prepare(n, c, x, y)", "k_prepare(n, c, y)")
    functions = [program.functions[name] for name in names]
    if soon or lanes < BLOCK:
        source = c_source(program, functions, single=lanes == 1)
    else:
        source = lanes_source(program, functions)
    return load_library("\n".join([source, prepare, *calls, added]), soon=soon)
