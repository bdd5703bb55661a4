"""Runs with step size control on a GPU, with the C code of `martensite.simulate.marching_native`.

Each thread runs one simulation. NVRTC compiles the unchanged code for the device. The compiler interleaves local
memory for coalesced access.
"""

from __future__ import annotations

import ctypes
import re
from dataclasses import replace
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np

from martensite.base.errors import ParameterError
from martensite.simulate.compiled import CompiledMarch
from martensite.simulate.cuda import device
from martensite.simulate.cuda.source import THREADS, WORDS
from martensite.simulate.ledger import EMPTY
from martensite.simulate.march_kernel import MarchKernel, kernel_of
from martensite.simulate.marching_native import MarchArrays, MarchRows, Runs

FLAGS = ("-default-device", "-diag-suppress=177")
"""NVRTC options: compile for the device by default, without warnings on unused functions."""
NAMES = """
#ifdef __CUDACC__
#define restrict __restrict__
#define _Bool bool
#define inline __noinline__
#define INLINE static __forceinline__
#endif
"""


def march_to_ends(runs: Runs) -> MarchRows:
    """Simulate runs to their ends with individual step size control.

    Raises:
        ParameterError: a drive has too many segments.
        InputError: no device was found.
    """
    runs = runs._replace(plan=runs.plan._replace(recorded=False))
    arrays = MarchArrays(runs)
    if not arrays.knows_all():
        raise ParameterError("A drive has too many pieces for the runtime `cuda`; use the runtime `c`.")
    kernel = kernel_of(runs.plan._replace(compiled=_leave_out_ledger(runs.plan.compiled)), runs.outputs, 1, runs.own)
    program = load_program(kernel)
    with device.DeviceMemory() as memory:

        def locate(array: Any) -> int:
            """Return the device address of an array; empty rows need no copy."""
            return memory.take(array.nbytes, EMPTY_BYTE) if array is arrays.rows else memory.give(array)

        march = arrays.describe(locate)
        place = memory.give(np.frombuffer(memoryview(march), np.uint8))
        program.launch("march_to_ends", runs.size, [ctypes.c_longlong(place)])
        memory.fetch(march.rows, arrays.rows)
        memory.fetch(march.numbers, arrays.numbers)
        if runs.plan.totalled:
            memory.fetch(march.totals, arrays.totals)
    return MarchRows(arrays.rows, arrays.numbers, arrays.record, arrays.totals, arrays.states, arrays.extremes)


EMPTY_BYTE = 0xFF
"""Fill byte; eight of them are NaN."""


def print_source(kernel: MarchKernel) -> str:
    """Return the CUDA C of a time integration."""
    text = re.sub(r"^#include .*$", "", kernel.source(), flags=re.MULTILINE)
    return f"#define THREADS {THREADS}\n{WORDS}{NAMES}{text}{_read_kernel()}"


def _read_kernel() -> str:
    return Path(__file__).with_suffix(".cu").read_text(encoding="utf-8")


@lru_cache(maxsize=32)
def load_program(kernel: MarchKernel) -> Any:
    """Return the compiled program, cached."""
    return device.DeviceProgram(print_source(kernel), FLAGS)


@lru_cache(maxsize=32)
def _leave_out_ledger(compiled: CompiledMarch) -> CompiledMarch:
    """Return the system without ledger, since batches report no balance."""
    return replace(compiled, book=EMPTY)
