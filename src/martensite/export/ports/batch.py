"""Many points of a port at once, on NumPy arrays, for hosts in Python.

`PortBatch` tries a step of each point: states and inputs in, states, answers and derivatives out. `UniaxialModel` is a
material in the style of `IncrSmallStrainModel` of fenics-constitutive, constraint `UNIAXIAL_STRESS`: it takes gradients
of the displacement increment, and updates stress, tangent and history in place. The host keeps the committed arrays and
calls it on copies in each iteration.
"""

from __future__ import annotations

import ctypes
import math
from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from martensite.actuators.assembly import AbstractSystem
from martensite.base.errors import InputError, SolveError, require_known
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
    """Shape (points, states)."""
    values: Array
    """Shape (points, answers) [SI]."""
    slopes: Array
    """Shape (points, answers, inputs), derivatives through the solution of the step."""


class PortBatch:
    """Trial steps of many points of one port. The given states are not changed."""

    def __init__(self, system: ElementPort | MaterialPort, *, runtime: str = "auto") -> None:
        """Trace a port, and compile it unless `runtime` is `floats` or a compiler is missing."""
        require_known("runtime", runtime, RUNTIMES)
        self.kernel: PortKernel = compile_port(system)
        native = runtime == "c" or (runtime == "auto" and find_compiler() is not None)
        self._library = _NativePort(self.kernel) if native else None

    def start(self, inputs: Any) -> Array:
        """Return the steady states under inputs of shape (points, inputs) [SI]."""
        rows = self._check_inputs(inputs)
        begin = self.kernel.functions["init"]
        return np.array([begin(*row) for row in rows.tolist()], float).reshape(len(rows), self.kernel.size)

    def step(self, states: Any, inputs: Any, dt: float) -> PortAnswers:
        """Return states, answers and derivatives after a step of dt [s] to the inputs (points, inputs).

        Raises:
            InputError: a number is not finite, or arrays do not fit.
            SolveError: the step of a point was not solved.
        """
        rows, before = self._check_inputs(inputs), np.ascontiguousarray(states, float)
        if before.shape != (len(rows), self.kernel.size):
            raise InputError(f"States must be of shape {(len(rows), self.kernel.size)}, but are of {before.shape}.")
        if not 0.0 <= dt < math.inf:
            raise InputError(f"Argument `dt` must be at least 0 s, but is {dt}.")
        return (self._try_floats if self._library is None else self._library.try_all)(before, rows, dt)

    def _check_inputs(self, inputs: Any) -> Array:
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
    def __init__(self, kernel: PortKernel) -> None:
        core = kernel.write_core(name="port")
        source = core.source.replace('#include "port.h"', core.header)
        self._library, self._core, self._kernel = load_library(source + _BATCH), core, kernel
        self._values = np.array([kernel.values[i] for i in core.parameter_indices] or [0.0], float)

    def try_all(self, states: Array, inputs: Array, dt: float) -> PortAnswers:
        """Return the results of all points."""
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

    Arrays are flat, point after point, as in fenics-constitutive. Set `temperature` [K] at the end of the step, one
    value or one per point, before `evaluate`. Afterwards `stress_by_temperature` [Pa/K] and `heat` [J/m³], the latent
    heat released in the step, are available.
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
        """Create the material of an element of a scenario or a system.

        Args:
            model: the scenario or system with the element.
            temperature: at the start [K].
            port: port of the element, if there are several.
            preload: stress at zero strain [Pa].
            compressed: `carries` compression as a bar does, or goes `slack` as a wire does.
            runtime: `c`, `floats`, or `auto`: C if there is a compiler.
        """
        system = model if isinstance(model, AbstractSystem) else model.system
        material_port = build_material_port(system, port=port, preload=preload, compressed=compressed)
        self._batch = PortBatch(material_port, runtime=runtime)
        self.temperature: float | Array = temperature
        self.stress_by_temperature: Array = np.empty(0)
        self.heat: Array = np.empty(0)

    @property
    def history_dim(self) -> dict[str, int]:
        """Return the numbers per point in each array of the history."""
        return {"strain": 1, "state": self._batch.kernel.size}

    def create_history(self, points: int) -> dict[str, Array]:
        """Return the history of points at zero strain and the present temperature."""
        inputs = np.column_stack([np.zeros(points), np.broadcast_to(self.temperature, (points,))])
        return {"strain": np.zeros(points), "state": self._batch.start(inputs).ravel()}

    def evaluate(
        self, t: float, del_t: float, grad_del_u: Array, stress: Array, tangent: Array, history: Mapping[str, Array]
    ) -> None:
        """Update stress, tangent and history in place, for a step from t over del_t [s].

        Args:
            t: time at the start of the step [s]; unused.
            del_t: length of the step [s]; matters for rate-dependent laws.
            grad_del_u: strain increments [-].
            stress: output, stress at the end [Pa].
            tangent: output, dσ/dε of the step [Pa].
            history: `strain` and `state`, as from `create_history`.

        Raises:
            InputError: arrays do not fit.
            SolveError: the step of a point was not solved; no array is changed.
        """
        strain = history["strain"] + np.ravel(grad_del_u)
        points = len(strain)
        states = history["state"].reshape(points, -1)
        inputs = np.column_stack([strain, np.broadcast_to(self.temperature, (points,))])
        results = self._batch.step(states, inputs, del_t)
        stress[:], self.heat = results.values[:, 0], results.values[:, 1].copy()
        tangent[:], self.stress_by_temperature = results.slopes[:, 0, 0], results.slopes[:, 0, 1].copy()
        history["strain"][:] = strain
        history["state"][:] = results.states.ravel()
