"""Batches of states of one system that are advanced step by step from outside.

Every batch element has its own state, which you can read, set and copy, and its own signals in every call.
Applications are plans of a predictive controller, sigma points of a filter and environments of a learner.

With a compiler, one C library per system serves any batch size; otherwise steps run on floats. Failed steps set
`status` and raise no error.
"""

from __future__ import annotations

import ctypes
import math
from collections.abc import Mapping, Sequence
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from martensite.actuators.assembly import AbstractSystem
from martensite.base.errors import InputError, suggest_name
from martensite.base.status import Status
from martensite.kernels.c99_lanes import BLOCK
from martensite.kernels.compiled_program import CompiledProgram, get_address
from martensite.kernels.compiler import find_compiler, read_source
from martensite.simulate.compiled import CompiledSystem, compile_system
from martensite.simulate.march import classify_step

Numbers: TypeAlias = NDArray[np.float64]


FUNCTIONS = ("init", "step", "observe")


class Lanes:
    """Batch of states of one system, for one thread."""

    def __init__(
        self,
        system: AbstractSystem,
        lanes: int,
        values: Mapping[str, Any] | None = None,
        native: bool | None = None,
        soon: bool = False,
    ) -> None:
        """Create a batch in equilibrium.

        Args:
            system: a system, or a bench.
            lanes: batch size.
            values: individual parameters by path, each of shape (lanes,).
            native: True for C; by default if a compiler is available.
            soon: True for C without vectors, at first from the quick compiler, for a few short runs.
        """
        compiled = compile_system(system)
        self._rows = {path: k for k, path in enumerate(compiled.paths)}
        table = np.repeat(np.array(compiled.values(system))[:, None], lanes, axis=1)
        self._fill(table, values or {})
        self.lanes, self.system = lanes, system
        self.names: tuple[str, ...] = compiled.outputs
        self.drives = tuple(drive.name for drive in system.drives())
        self._shape = len(self.drives), lanes
        in_c = find_compiler() is not None if native is None else native
        self._engine = NativeLanes(compiled, table, soon) if in_c else PlainLanes(compiled, table)
        self.state: Numbers = np.zeros((compiled.size, lanes))
        """All state variables, shape (states, lanes); set it to go on from elsewhere."""

    @property
    def worst(self) -> Numbers:
        """Return the worst reports since the last reset, shape (2, lanes)."""
        return self._engine.worst

    def set_values(self, values: Mapping[str, Any]) -> None:
        """Set other parameters from now on.

        States and worst reports remain. Use `reset` for the equilibrium of the new parameters.

        Args:
            values: parameters by path, each a number or of shape (lanes,); others remain unchanged.

        Raises:
            InputError: the parameter does not exist, or its shape is wrong.
        """
        table = self._engine.table.copy()
        self._fill(table, values)
        self._engine.set_table(table)

    def reset(self, signals: Any = 0.0) -> None:
        """Reset all elements to equilibrium under signals, broadcast to (drives, lanes)."""
        self.state = self._engine.begin(self._spread(signals))
        self.worst[:] = 0.0

    def advance(self, signals: Any, dt: float, *, shown: bool = True) -> Numbers:
        """Advance by steps of dt [s].

        Args:
            signals: shape (steps, drives, lanes); drives and lanes may be 1 for all of them.
            dt: length of a step [s]; the sample time of a system in discrete time.
            shown: True to return outputs.

        Returns:
            Outputs after every step, under its signals, shape (steps, outputs, lanes), in the
            order of `names`; without rows if `shown` is False.

        Raises:
            InputError: the shape of the signals is wrong.
        """
        given = np.asarray(signals, float)
        if given.ndim != 3 or given.shape[1:] != self._shape:
            self._require(given)
        self.state, rows = self._engine.advance(self.state, given, dt, shown)
        return rows

    def observe(self, signals: Any) -> Numbers:
        """Return the present outputs under signals, shape (outputs, lanes)."""
        return self._engine.read_outputs(self.state, self._spread(signals))

    def copy_from(self, other: Lanes, lane: int = 0) -> None:
        """Copy the state of one element of another batch of the same system to all elements."""
        self.state = np.repeat(other.state[:, lane : lane + 1], self.lanes, axis=1)
        self.worst[:] = 0.0

    @property
    def status(self) -> list[Status]:
        """Return the worst status of every batch element since the last reset."""
        lost = [bool(np.isnan(column).any()) for column in self.state.T]
        statuses = [classify_step(float(r), float(s)) for r, s in self.worst.T]
        return [Status.NOT_FINITE if n else s for n, s in zip(lost, statuses, strict=True)]

    def _fill(self, table: Numbers, values: Mapping[str, Any]) -> None:
        """Write parameters by path into the rows of a table, shape (parameters, lanes)."""
        for path, value in values.items():
            if path not in self._rows:
                raise InputError(f"There is no parameter `{path}`. {suggest_name(path, self._rows)}")
            given, lanes = np.asarray(value, float), table.shape[1]
            if given.shape not in ((), (1,), (lanes,)):
                raise InputError(
                    f"Values of `{path}` must be one number or of shape ({lanes},), but their shape is {given.shape}."
                )
            table[self._rows[path]] = given

    def _spread(self, signals: Any) -> Numbers:
        """Return the signals of one time, for all drives and batch elements."""
        given = np.asarray(signals, float)
        try:
            return np.broadcast_to(given, self._shape)
        except ValueError:
            raise InputError(
                f"Signals of one time must have the shape (drives, batch) = {self._shape}, but have {given.shape}."
            ) from None

    def _require(self, given: Numbers) -> None:
        """Raise `InputError` unless the signals fit drives and batch size."""
        fits = given.ndim == 3 and all(a in (1, b) for a, b in zip(given.shape[1:], self._shape, strict=True))
        if not fits:
            raise InputError(
                f"Signals must have the shape (steps, drives, batch) = (steps, {self._shape[0]}, {self._shape[1]}), "
                f"but have {given.shape}."
            )


class NativeLanes:
    """Batch in C.

    Buffers have fixed addresses, so that a step of one element takes microseconds. The buffer `x` holds states,
    signals and dt; `y` holds the results of a step.
    """

    def __init__(self, compiled: CompiledSystem, table: Numbers, soon: bool = False) -> None:
        self.compiled = compiled
        size, outputs, self.n = compiled.size, len(compiled.outputs), table.shape[1]
        self._filled_to = n = self.n if self.n < BLOCK else -(-self.n // BLOCK) * BLOCK
        self._table = self._fill_block(table)
        constants = {"SIZE": size, "DRIVES": compiled.drives, "OUTPUTS": outputs}
        added = read_source("simulate", "pushed_lanes.c", constants)
        self.program = CompiledProgram(compiled.program, FUNCTIONS, self._table, added, soon)
        self.x = np.empty((size + compiled.drives + 1, n))
        self.y, self._worst = np.empty((size + len(compiled.report), n)), np.zeros((2, n))
        self._state, self._signals, self._dt = self.x[:size], self.x[size:-1], self.x[-1]
        self._drives, self._rows = np.empty((compiled.drives, n)), np.empty((1, outputs, n))
        self._at_drives, self._at_rows = get_address(self._drives), get_address(self._rows)
        arrays = (self.program.constants, self.x, self.y, self._worst)
        self._addresses = tuple(map(get_address, arrays))
        self._observe = self.program.bind("observe", self.x, self._rows)

    @property
    def table(self) -> Numbers:
        """Return the parameters, shape (parameters, lanes)."""
        return self._table[:, : self.n]

    @property
    def worst(self) -> Numbers:
        """Return the worst reports so far, shape (2, lanes)."""
        return self._worst[:, : self.n]

    def _fill_block(self, given: Numbers) -> Numbers:
        """Return a table padded with copies of the last element to a full block."""
        last = given[..., -1:]
        more = np.broadcast_to(last, (*given.shape[:-1], self._filled_to - given.shape[-1]))
        return np.ascontiguousarray(np.concatenate([given, more], axis=-1))

    def _spread(self, into: Numbers, given: Any) -> None:
        """Write values with broadcasting."""
        into[..., : self.n] = given
        into[..., self.n :] = into[..., self.n - 1 : self.n]

    def set_table(self, table: Numbers) -> None:
        """Set other parameters, shape (parameters, lanes), without compilation."""
        self._spread(self._table, table)
        self.program.set_table(self._table)

    def begin(self, signals: Numbers) -> Numbers:
        """Return the equilibrium state."""
        state, given = np.empty((self.compiled.size, self._filled_to)), self._fill_block(signals)
        self.program.bind("init", given, state)()
        return state[:, : self.n].copy()

    def advance(self, state: Numbers, signals: Numbers, dt: float, shown: bool) -> tuple[Numbers, Numbers]:
        """Return the state and outputs after some steps; signals are broadcast."""
        self._spread(self._state, state)
        self._dt[...] = dt
        steps, drives, rows, n = len(signals), self._at_drives, self._at_rows, self.n
        if steps == 1:
            self._spread(self._drives, signals[0])
            self._go(1, drives, rows if shown else None)
            outputs = self._rows[..., :n].copy() if shown else self._rows[:0, :, :n]
            return self._state[:, :n].copy(), outputs
        spread = np.empty((steps, *self._drives.shape))
        self._spread(spread, signals)
        outputs = np.empty((steps if shown else 0, *self._rows.shape[1:]))
        self._go(steps, get_address(spread), get_address(outputs) if shown else None)
        return self._state[:, :n].copy(), outputs[..., :n]

    def _go(self, steps: int, drives: Any, rows: Any) -> None:
        counts = ctypes.c_long(self._filled_to), ctypes.c_long(steps)
        self.program.library.advance(*counts, *self._addresses, drives, rows)

    def read_outputs(self, state: Numbers, signals: Numbers) -> Numbers:
        """Return the outputs in a state."""
        self._spread(self._state, state)
        self._spread(self._signals, signals)
        self._observe()
        return self._rows[0, :, : self.n].copy()


class PlainLanes:
    """Batch on floats, one element after another."""

    def __init__(self, compiled: CompiledSystem, table: Numbers) -> None:
        self.compiled, self.table = compiled, np.array(table)
        self.functions = [compiled.program.bind_floats(*column) for column in table.T.tolist()]
        self.worst = np.zeros((2, table.shape[1]))

    def set_table(self, table: Numbers) -> None:
        """Set other parameters, shape (parameters, lanes)."""
        changed = np.flatnonzero((table != self.table).any(axis=0))
        self.table = np.array(table)
        for lane in changed.tolist():
            self.functions[lane] = self.compiled.program.bind_floats(*table[:, lane].tolist())

    def begin(self, signals: Numbers) -> Numbers:
        """Return the equilibrium state."""
        rows = zip(self.functions, signals.T.tolist(), strict=True)
        return np.array([functions["init"](*u) for functions, u in rows]).T

    def advance(self, state: Numbers, signals: Numbers, dt: float, shown: bool) -> tuple[Numbers, Numbers]:
        """Return the state and outputs after some steps; signals are broadcast."""
        lanes, size = state.shape[1], self.compiled.size
        drives = np.broadcast_to(signals, (len(signals), self.compiled.drives, lanes))
        rows = np.empty((len(drives) if shown else 0, len(self.compiled.outputs), lanes))
        after = np.empty_like(state)
        for lane, now in enumerate(state.T.tolist()):
            for k, u in enumerate(drives[:, :, lane].tolist()):
                numbers = self._step(lane, [*now, *u, dt])
                now = list(numbers[:size])
                self.worst[:, lane] = np.maximum(self.worst[:, lane], numbers[size : size + 2])
                if shown:
                    rows[k, :, lane] = self.functions[lane]["observe"](*now, *u)
            after[:, lane] = now
        return after, rows

    def read_outputs(self, state: Numbers, signals: Numbers) -> Numbers:
        """Return the outputs in a state."""
        rows = zip(self.functions, state.T.tolist(), signals.T.tolist(), strict=True)
        return np.array([functions["observe"](*now, *u) for functions, now, u in rows]).T

    def _step(self, lane: int, arguments: Sequence[float]) -> Sequence[float]:
        try:
            return self.functions[lane]["step"](*arguments)
        except ArithmeticError:  # division by zero or overflow
            return [*arguments[: self.compiled.size], math.inf, 0.0]
