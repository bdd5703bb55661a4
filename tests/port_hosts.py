"""Hosts of ports that are as small as can be: programs that call a UMAT or an OpenSees package as the large ones do."""

from __future__ import annotations

import ctypes
import subprocess
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from martensite.export.ports.kernel import PortKernel, compile_port
from martensite.export.ports.material import MaterialPort
from martensite.export.ports.opensees import write_opensees
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


_OPENSEES = """
#include <stdlib.h>
#include <string.h>

/* What OpenSees does with a material of its C interface (WrapperUniaxialMaterial), around one of them. */
typedef struct { double time, dt; } modelState;
typedef struct matObject {
    int tag, matType, nParam, nState;
    double *theParam, *cState, *tState;
    void (*matFunctPtr)(struct matObject *, modelState *, double *, double *, double *, int *, int *);
    void *matObjectPtr;
} matObj;
void sma(matObj *, modelState *, double *, double *, double *, int *, int *);

static const double *words;
static int count, at;
static modelState now;
int ops_error_(char *text, int length) { (void)text, (void)length; return 0; }
int ops_getintinput_(int *n, int *data) {
    int i;
    if (at + *n > count) return -1;
    for (i = 0; i < *n; i++) data[i] = (int)words[at++];
    return 0;
}
int ops_getdoubleinput_(int *n, double *data) {
    int i;
    if (at + *n > count) return -1;
    for (i = 0; i < *n; i++) data[i] = words[at++];
    return 0;
}
int ops_allocatematerial_(matObj *m) {
    m->theParam = calloc((size_t)m->nParam, sizeof(double));
    m->cState = calloc((size_t)m->nState, sizeof(double));
    m->tState = calloc((size_t)m->nState, sizeof(double));
    return 0;
}
static int call(matObj *m, int isw, double *strain, double *tangent, double *stress) {
    int error = 0;
    m->matFunctPtr(m, &now, strain, tangent, stress, &isw, &error);
    return error;
}
void *host_create(const double *input, int n) {
    matObj *m = calloc(1, sizeof *m);
    words = input, count = n, at = 0;
    m->matFunctPtr = sma;
    return call(m, 0, 0, 0, 0) == 1 ? m : NULL;
}
void host_time(double time) { now.dt = time - now.time, now.time = time; }
int host_trial(matObj *m, double strain, double *stress, double *tangent) {
    return call(m, 3, &strain, tangent, stress);
}
int host_call(matObj *m, int isw) { double a = 0, b = 0, c = 0; return call(m, isw, &a, &b, &c); }
void *host_copy(const matObj *m) {
    matObj *copy = calloc(1, sizeof *copy);
    copy->tag = m->tag, copy->nParam = m->nParam, copy->nState = m->nState;
    ops_allocatematerial_(copy);
    memcpy(copy->theParam, m->theParam, sizeof(double) * (size_t)m->nParam);
    memcpy(copy->cState, m->cState, sizeof(double) * (size_t)m->nState);
    memcpy(copy->tState, m->tState, sizeof(double) * (size_t)m->nState);
    copy->matFunctPtr = m->matFunctPtr;
    return copy;
}
"""
COMMIT, REVERT, TO_START = 1, 2, 5


class OpenseesHost:
    """A package of OpenSees and the little of OpenSees that it needs."""

    def __init__(self, folder: Path, port: MaterialPort) -> None:
        text = write_opensees(compile_port(port), "sma")["_opensees.c"]
        self._library = compile_texts(folder, "sma_ops", {"sma_opensees.c": text, "host.c": _OPENSEES})
        self._library.host_create.restype = self._library.host_copy.restype = ctypes.c_void_p

    def create(self, *words: float) -> int | None:
        """`uniaxialMaterial sma WORDS`; None if it is refused."""
        row = np.array(words, float)
        return self._library.host_create(ctypes.c_void_p(row.ctypes.data), len(row))

    def set_time(self, time: float) -> None:
        """The time of the model [s]."""
        self._library.host_time(ctypes.c_double(time))

    def trial(self, material: int, strain: float) -> tuple[float, float]:
        """`setTrialStrain`, then `getStress` and `getTangent`."""
        stress, tangent = ctypes.c_double(), ctypes.c_double()
        error = self._library.host_trial(
            ctypes.c_void_p(material), ctypes.c_double(strain), ctypes.byref(stress), ctypes.byref(tangent)
        )
        assert error == 0
        return stress.value, tangent.value

    def call(self, material: int, what: int) -> None:
        """`commitState`, `revertToLastCommit` or `revertToStart`."""
        assert self._library.host_call(ctypes.c_void_p(material), what) == 0

    def copy(self, material: int) -> int:
        """`getCopy`."""
        return self._library.host_copy(ctypes.c_void_p(material))
