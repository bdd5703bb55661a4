"""A host of ports that is as small as can be: it calls a UMAT as the large programs do."""

from __future__ import annotations

import ctypes
import subprocess
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from martensite.export.ports.kernel import PortKernel, compile_port
from martensite.export.ports.material import MaterialPort
from martensite.export.ports.umat import count_state_variables, write_umat
from martensite.kernels.compiler import find_compiler
from martensite.physics.laws.base import AbstractLaw

FLAGS = ("-std=c99", "-O0", "-Wall", "-Wextra", "-Werror", "-fPIC", "-shared", "-ffp-contract=off")
ZERO = 273.15
Array = Any


def material_of(law: AbstractLaw, **changed: Any) -> MaterialPort:
    """A bar of a law, austenite at the start."""
    from builders import wire_a

    return MaterialPort(element=wire_a(law=law, initial_fraction=0.0), **changed)


def compile_texts(folder: Path, name: str, texts: Mapping[str, str]) -> ctypes.CDLL:
    """A library of files of C, by their names."""
    for file, text in texts.items():
        (folder / file).write_text(text)
    library = folder / f"lib{name}.so"
    command = [str(find_compiler()), *FLAGS, "-o", str(library), *(str(folder / file) for file in texts), "-lm"]
    done = subprocess.run(command, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return ctypes.CDLL(str(library), mode=ctypes.RTLD_LOCAL)


class UmatHost:
    """One material point behind `UMAT`, with units of MPa and degrees Celsius; arguments as Abaqus gives them."""

    def __init__(self, folder: Path, port: MaterialPort, components: int = 1) -> None:
        self.kernel: PortKernel = compile_port(port)
        text = write_umat(self.kernel, "sma")["_umat.c"]
        self._call = compile_texts(folder, "sma", {"sma_umat.c": text}).umat_
        self._call.restype = None
        self.components, self.states = components, count_state_variables(self.kernel)
        self.props = [1e6, ZERO]
        self.answer: dict[str, Array] = {}

    def call(
        self, statev: Array, strain: Array, change: Array, temperature: float, warming: float, dt: float
    ) -> tuple[Array, Array, Array]:
        """Stress [MPa], tangent and state variables after an increment; the first temperature is that before it."""
        n = self.components
        stress, state, tangent = np.zeros(n), np.array(statev, float), np.zeros((n, n))
        rpl, drpldt, pnewdt = np.zeros(1), np.zeros(1), np.ones(1)
        ddsddt, drplde = np.zeros(n), np.zeros(n)
        unused = np.zeros(16)

        def real(value: Any) -> Any:
            held.append(np.atleast_1d(np.asarray(value, float)))
            return ctypes.c_void_p(held[-1].ctypes.data)

        def whole(value: int) -> Any:
            return ctypes.byref(ctypes.c_int(value))

        held: list[Any] = []
        given = [stress, state, tangent, unused, unused, unused, rpl, ddsddt, drplde, drpldt, strain, change, [0, 0]]
        given += [dt, temperature, warming, unused, unused]
        counts = (min(n, 3), n - min(n, 3), n, self.states)
        numbers = [whole(1)] * 7
        self._call(
            *(ctypes.c_void_p(one.ctypes.data) if isinstance(one, np.ndarray) else real(one) for one in given),
            ctypes.c_char_p(b"SMA".ljust(80)),
            *(whole(count) for count in counts),
            real(self.props),
            whole(len(self.props)),
            *(real(unused) for _ in range(2)),
            ctypes.c_void_p(pnewdt.ctypes.data),
            *(real(unused) for _ in range(3)),
            *numbers[:6],
            ctypes.c_int(80),
        )
        self.answer = {"rpl": rpl, "ddsddt": ddsddt, "drplde": drplde, "drpldt": drpldt, "pnewdt": pnewdt}
        return stress, tangent, state
