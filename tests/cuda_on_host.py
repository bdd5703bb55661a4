"""A GPU that is the processor: CUDA C made by the C compiler, one thread after another.

Addresses on the device are addresses of this process; the host side of a march is the true one.
"""

from __future__ import annotations

import ctypes
from collections.abc import Sequence
from typing import Any, ClassVar

import numpy as np

from martensite.kernels.compiler import load_library
from martensite.simulate.cuda.source import THREADS

WORDS = """
#include <math.h>
#include <stdbool.h>
#include <string.h>
#define __device__
#define __global__
#define __constant__
#define __forceinline__ inline
#define __launch_bounds__(threads)
struct index_of_thread { unsigned x; } blockIdx, blockDim, threadIdx;
"""


class HostProgram:
    """Does on the processor what a `DeviceProgram` does on a GPU."""

    seconds = 0.0

    def __init__(self, text: str, more: tuple[str, ...] = ()) -> None:
        self.library = load_library(WORDS + text)

    def locate(self, name: str) -> int:
        """Address of a variable."""
        return ctypes.addressof(ctypes.c_char.in_dll(self.library, name))

    def launch(self, name: str, threads: int, arguments: Sequence[Any]) -> None:
        """All threads of all blocks, those without a run too."""
        kernel, places = getattr(self.library, name), ("blockIdx", "blockDim", "threadIdx")
        block, size, thread = (ctypes.c_uint.in_dll(self.library, one) for one in places)
        size.value = THREADS
        for k in range(-(-threads // THREADS) * THREADS):
            block.value, thread.value = divmod(k, THREADS)
            kernel(*arguments)


class HostMemory:
    """Arrays of this process, in place of `DeviceMemory`."""

    free: ClassVar[int] = 1 << 30

    def __init__(self) -> None:
        self._taken: list[Any] = []

    def __enter__(self) -> HostMemory:
        return self

    def __exit__(self, *_: object) -> None:
        self._taken.clear()

    def count_free(self) -> int:
        """Bytes for arrays."""
        return self.free

    def take(self, size: int, fill: int | None = None) -> int:
        """What was not written is what no run brings."""
        array = np.full(max(size, 1), 0x7A if fill is None else fill, np.uint8)
        self._taken.append(array)
        return int(array.ctypes.data)

    def give(self, array: Any) -> int:
        """A copy."""
        place = self.take(array.nbytes)
        self.move(array.ctypes.data, place, array.nbytes)
        return place

    def move(self, source: int, target: int, size: int) -> None:
        """Copy bytes."""
        ctypes.memmove(target, source, size)

    def fetch(self, place: int, array: Any) -> None:
        """Fill an array."""
        self.move(place, array.ctypes.data, array.nbytes)
