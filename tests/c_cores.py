"""A C core, compiled to a library and called from Python."""

from __future__ import annotations

import ctypes
import os
import subprocess
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from martensite.export.c_core import CCore
from martensite.kernels.compiler import find_compiler

STRICT = ("-std=c99", "-pedantic", "-Wall", "-Wextra", "-Wconversion", "-Wdouble-promotion", "-Wshadow", "-Werror")
OK, LONG_STEP, UNSOLVED, OUT_OF_RANGE, NOT_FINITE, BAD_INPUT = range(6)


def compiled(core: CCore, folder: Path, *arguments: str) -> Path:
    """What the compiler makes of a core, with strict warnings.

    `MARTENSITE_CFLAGS` has the last word on optimisation.
    """
    core.write(folder)
    path = folder / f"{core.name}.out"
    built([*arguments, str(folder / f"{core.name}.c")], path)
    return path


def built(arguments: Sequence[str], path: Path) -> None:
    """Run the compiler."""
    flags = os.environ.get("MARTENSITE_CFLAGS", "").split()
    command = [find_compiler() or "cc", *STRICT, "-O2", *flags, *arguments, "-o", str(path), "-lm"]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr[:2000]


class Called:
    """One model of a compiled core."""

    def __init__(self, core: CCore, folder: Path, *arguments: str) -> None:
        self.core = core
        self.path = compiled(core, folder, "-fPIC", "-shared", *arguments)
        library = ctypes.CDLL(str(self.path))
        number: Any = ctypes.c_double if core.precision == "float64" else ctypes.c_float
        counts = {"p": len(core.parameters), "c": core.constants, "x": core.states}
        arrays = [(name, number * max(1, count)) for name, count in counts.items()]

        class Model(ctypes.Structure):
            _fields_ = [*arrays, ("residual", number), ("crossing", number)]

        self.model, self.number = Model(), number
        self.functions = {
            name: getattr(library, f"{core.name}_{name}")
            for name in ("defaults", "prepare", "start", "step", "observe")
        }
        self.functions["step"].argtypes = [ctypes.c_void_p, ctypes.c_void_p, number]
        self.call("defaults")

    def call(self, name: str, *arguments: Any) -> int:
        return self.functions[name](ctypes.byref(self.model), *arguments)

    def prepare(self) -> int:
        return self.call("prepare")

    def start(self, *inputs: float) -> int:
        return self.call("start", self._numbers(inputs))

    def step(self, *inputs: float, dt: float) -> int:
        return self.call("step", self._numbers(inputs), dt)

    def observe(self, *inputs: float) -> tuple[int, tuple[float, ...]]:
        seen = self._numbers([0.0] * len(self.core.outputs))
        return self.call("observe", self._numbers(inputs), seen), tuple(seen)

    def set(self, name: str, value: float) -> None:
        """Set a parameter by its path in Python."""
        index = next(one.index for one in self.core.parameters if one.name == name)
        self.model.p[index] = value

    @property
    def state(self) -> tuple[float, ...]:
        return tuple(self.model.x)[: self.core.states]

    @property
    def everything(self) -> bytes:
        """All numbers of the model."""
        return bytes(self.model)

    def _numbers(self, values: Sequence[float]) -> Any:
        return (self.number * max(1, len(values)))(*values)
