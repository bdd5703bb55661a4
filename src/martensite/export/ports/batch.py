"""Many points of a port at once, on NumPy arrays: for hosts in Python.

`PortBatch` tries a step of every point: states and inputs in, states, answers and slopes out. `UniaxialModel` is a
material in the manner of `IncrSmallStrainModel` of fenics-constitutive, constraint `UNIAXIAL_STRESS`: gradients of the
displacement increment in, stress, tangent and history updated in place. Whoever calls it keeps what is committed and
calls it on copies as often as an iteration needs.
"""

from __future__ import annotations

import ctypes
import math
from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from martensite.actuators.assembly import AbstractSystem
from martensite.base.errors import InputError, SolveError
from martensite.export.ports.element import ElementPort
from martensite.export.ports.kernel import PortKernel, compile_port
from martensite.export.ports.material import MaterialPort, build_material_port
from martensite.kernels.compiler import find_compiler, load_library
from martensite.scenario.scenario import Scenario

Array = NDArray[np.float64]
RUNTIMES = ("auto", "c", "floats")


class PortAnswers(NamedTuple):
    """Results of a step of many points."""

    states: Array
    """(points, numbers of a state)"""
    values: Array
    """(points, answers), in SI."""
    slopes: Array
    """(points, answers, inputs), through the solve of the step."""


class PortBatch:
    """Steps of many points of one port, each tried from a state that stays as it is."""

    def __init__(self, system: ElementPort | MaterialPort, *, runtime: str = "auto") -> None:
        """Trace a port, and compile it unless `runtime` is `floats` or a compiler is missing."""
        if runtime not in RUNTIMES:
            raise InputError(f"No runtime named `{runtime}`. Known are {', '.join(RUNTIMES)}.")
        self.kernel: PortKernel = compile_port(system)
        native = runtime == "c" or (runtime == "auto" and find_compiler() is not None)
        self._library = _NativePort(self.kernel) if native else None

    def start(self, inputs: Any) -> Array:
        """Return the states at rest under inputs (points, inputs) [SI]."""
        rows = self._checked(inputs)
        begin = self.kernel.functions["init"]
        return np.array([begin(*row) for row in rows.tolist()], float).reshape(len(rows), self.kernel.size)

    def step(self, states: Any, inputs: Any, dt: float) -> PortAnswers:
        """Return the states, answers and slopes after a step of dt [s], at whose end the inputs (points, inputs) hold.

        Raises:
            InputError: a number is not finite, or arrays do not fit.
            SolveError: the step of a point was not solved; none is taken.
        """
        rows, held = self._checked(inputs), np.ascontiguousarray(states, float)
        if held.shape != (len(rows), self.kernel.size):
            raise InputError(f"States must be of shape {(len(rows), self.kernel.size)}, but are of {held.shape}.")
        if not 0.0 <= dt < math.inf:
            raise InputError(f"Argument `dt` must be at least 0 s, but is {dt}.")
        return (self._try_floats if self._library is None else self._library.try_all)(held, rows, dt)

    def _checked(self, inputs: Any) -> Array:
        rows = np.ascontiguousarray(inputs, float)
        if rows.ndim != 2 or rows.shape[1] != len(self.kernel.inputs):
            raise InputError(
                f"Inputs must be of shape (points, {len(self.kernel.inputs)}) for {', '.join(self.kernel.inputs)}, but "
                f"are of {rows.shape}."
            )
        if not np.all(np.isfinite(rows)):
            raise InputError("Inputs of a port must be finite.")
        return rows

    def _try_floats(self, states: Array, inputs: Array, dt: float) -> PortAnswers:
        size, count = self.kernel.size, len(self.kernel.answers)
        table = np.empty((len(inputs), size + 2 + count * (1 + inputs.shape[1])))
        for place, (state, row) in enumerate(zip(states.tolist(), inputs.tolist(), strict=True)):
            table[place], solved = self.kernel.try_step(state, row, dt)
            if not solved:
                raise _make_error(place)
        values, slopes = table[:, size + 2 : size + 2 + count], table[:, size + 2 + count :]
        return PortAnswers(table[:, :size], values, slopes.reshape(len(inputs), count, -1))


def _make_error(place: int) -> SolveError:
    return SolveError(f"The step of point {place} was not solved to its tolerance; make a shorter one.")


class _NativePort:
    """A port in C."""

    def __init__(self, kernel: PortKernel) -> None:
        core = kernel.write_core(name="port")
        source = core.source.replace('#include "port.h"', core.header)
        self._library, self._core, self._kernel = load_library(source + _BATCH), core, kernel
        self._values = np.array([kernel.values[i] for i in core.kept] or [0.0], float)

    def try_all(self, states: Array, inputs: Array, dt: float) -> PortAnswers:
        """Return all points, one after the other."""
        points, answers = len(inputs), len(self._kernel.answers)
        after = np.empty_like(states)
        values = np.empty((points, answers))
        slopes = np.empty((points, answers, inputs.shape[1]))
        arrays = (self._values, states, inputs, after, values, slopes)
        try_points = self._library.port_try_points
        try_points.restype = ctypes.c_long
        bad = try_points(
            ctypes.c_long(points), ctypes.c_double(dt), *(ctypes.c_void_p(one.ctypes.data) for one in arrays)
        )
        if bad >= 0:
            raise _make_error(bad)
        if bad == _REFUSED:
            raise InputError("The parameters of this port contradict each other.")
        return PortAnswers(after, values, slopes)


_REFUSED = -2
_BATCH = """
#include <string.h>

/* The first point whose step fails; -1 if there is none, -2 if the parameters are refused. */
long port_try_points(long count, double dt, const double *p, const double *x, const double *u, double *after,
    double *y, double *dy) {
    port_model start, now;
    long k;
    port_defaults(&start);
    memcpy(start.p, p, sizeof start.p);
    if (port_prepare(&start) >= port_UNSOLVED) return -2;
    for (k = 0; k < count; k++) {
        now = start;
        memcpy(now.x, x + k * port_STATES, sizeof(double) * port_STATES);
        if (port_try(&now, u + k * port_INPUTS, dt, &now, y + k * port_ANSWERS,
                     dy + k * port_ANSWERS * port_INPUTS) >= port_UNSOLVED) return k;
        memcpy(after + k * port_STATES, now.x, sizeof(double) * port_STATES);
    }
    return -1;
}
"""


class UniaxialModel:
    """A shape-memory material under uniaxial stress for a finite-element program in Python.

    Arrays are flat, point after point, as fenics-constitutive has them. `temperature` [K], one number or one per point,
    is what holds at the end of the step; set it before `evaluate`. After it `stress_by_temperature` [Pa/K] and `heat`
    [J/m³], the latent heat that the step released, are those of the step.
    """

    constraint = "UNIAXIAL_STRESS"
    geometric_dim = 1
    stress_strain_dim = 1

    def __init__(
        self,
        model: Scenario | AbstractSystem,
        *,
        temperature: float | Array,
        port: str | None = None,
        preload: float = 0.0,
        compressed: str = "carries",
        runtime: str = "auto",
    ) -> None:
        """The material of an element of a scenario or a system.

        Args:
            model: whose elements there are to choose from.
            temperature: at the start [K].
            port: where the element stands, if there are several.
            preload: stress where strain is zero [Pa].
            compressed: `carries` compression as a bar does, or goes `slack` as a wire does.
            runtime: `c`, `floats`, or `auto`: C where there is a compiler.
        """
        system = model if isinstance(model, AbstractSystem) else model.system
        made = build_material_port(system, port=port, preload=preload, compressed=compressed)
        self._batch = PortBatch(made, runtime=runtime)
        self.temperature: float | Array = temperature
        self.stress_by_temperature: Array = np.empty(0)
        self.heat: Array = np.empty(0)

    @property
    def history_dim(self) -> dict[str, int]:
        """Return the numbers per point of every array of the history."""
        return {"strain": 1, "state": self._batch.kernel.size}

    def create_history(self, points: int) -> dict[str, Array]:
        """Return the history of points that begin at zero strain, at the temperature set."""
        inputs = np.column_stack([np.zeros(points), np.broadcast_to(self.temperature, (points,))])
        return {"strain": np.zeros(points), "state": self._batch.start(inputs).ravel()}

    def evaluate(
        self, t: float, del_t: float, grad_del_u: Array, stress: Array, tangent: Array, history: Mapping[str, Array]
    ) -> None:
        """Stress, tangent and history after a step from t over del_t [s], in place.

        Args:
            t: time at the start of the step [s]; nothing depends on it.
            del_t: length of the step [s]; matters for laws with rates.
            grad_del_u: strain increments [-].
            stress: at the end [Pa]; what it held does not matter.
            tangent: dσ/dε of the step [Pa].
            history: `strain` and `state`, as `create_history` makes them.

        Raises:
            InputError: arrays do not fit.
            SolveError: the step of a point was not solved; nothing is changed.
        """
        strain = history["strain"] + np.ravel(grad_del_u)
        points = len(strain)
        states = history["state"].reshape(points, -1)
        inputs = np.column_stack([strain, np.broadcast_to(self.temperature, (points,))])
        found = self._batch.step(states, inputs, del_t)
        stress[:], self.heat = found.values[:, 0], found.values[:, 1].copy()
        tangent[:], self.stress_by_temperature = found.slopes[:, 0, 0], found.slopes[:, 0, 1].copy()
        history["strain"][:] = strain
        history["state"][:] = found.states.ravel()
