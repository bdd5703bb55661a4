"""Lanes: many states of one system side by side, taken forward step by step from outside.

Where a march goes its way from rest to the end, lanes are pushed: each has a state of its own
that can be read, set and copied, and in every call its own signals. A predictive controller
tries its plans in them, a filter its sigma points, a learner its environments.

In C if there is a compiler: one library per system, for any number of lanes; else on floats.
Lanes whose step fails are named by `status`, and no error is raised, for lanes are there to try
things.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from martensite.actuators.assembly import AbstractSystem
from martensite.base.errors import InputError, suggest_name
from martensite.base.status import Status
from martensite.kernels.compiler import find_compiler
from martensite.simulate.compiled import compile_system
from martensite.simulate.lanes_native import NativeLanes, Numbers
from martensite.simulate.lanes_plain import PlainLanes
from martensite.simulate.march import classify_step


class Lanes:
    """States of one system side by side; for one thread."""

    def __init__(
        self, system: AbstractSystem, lanes: int, values: Mapping[str, Any] | None = None, native: bool | None = None
    ) -> None:
        """Lanes of a system; `reset` puts them at rest.

        Args:
            system: a system, or a bench.
            lanes: how many.
            values: parameters by path that differ from lane to lane, each of shape (lanes,).
            native: whether to run in C; by default if there is a compiler.
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
        self._engine = NativeLanes(compiled, table) if in_c else PlainLanes(compiled, table)
        self.state: Numbers = np.zeros((compiled.size, lanes))
        """All state variables, shape (states, lanes); set it to go on from elsewhere."""

    @property
    def worst(self) -> Numbers:
        """Worst reports since the last reset, shape (2, lanes)."""
        return self._engine.worst

    def set_values(self, values: Mapping[str, Any]) -> None:
        """Other parameters from now on, as if the lanes had been made with them.

        States and worst reports stay: `reset` puts the lanes at the rest of their new parameters.

        Args:
            values: parameters by path, each a number or of shape (lanes,); what is not named
                stays as it is.

        Raises:
            InputError: there is no such parameter, or it has another shape.
        """
        table = self._engine.table.copy()
        self._fill(table, values)
        self._engine.set_table(table)

    def reset(self, signals: Any = 0.0) -> None:
        """All lanes at rest under first signals, shape (drives, lanes) or what spreads to it."""
        self.state = self._engine.begin(self._spread(signals))
        self.worst[:] = 0.0

    def advance(self, signals: Any, dt: float, *, shown: bool = True) -> Numbers:
        """Go on through steps of dt [s].

        Args:
            signals: shape (steps, drives, lanes); drives and lanes may be 1 for all of them.
            dt: length of a step [s]; that of the system in discrete time.
            shown: whether outputs are wanted.

        Returns:
            Outputs after every step, under its signals, shape (steps, outputs, lanes), in the
            order of `names`; with no rows if they are not wanted.

        Raises:
            InputError: signals of another shape.
        """
        given = np.asarray(signals, float)
        if given.ndim != 3 or given.shape[1:] != self._shape:
            self._require(given)
        self.state, rows = self._engine.advance(self.state, given, dt, shown)
        return rows

    def observe(self, signals: Any) -> Numbers:
        """Outputs now under signals, shape (outputs, lanes)."""
        return self._engine.read_outputs(self.state, self._spread(signals))

    def copy_from(self, other: Lanes, lane: int = 0) -> None:
        """Put all lanes into the state of one lane of others of the same system."""
        self.state = np.repeat(other.state[:, lane : lane + 1], self.lanes, axis=1)
        self.worst[:] = 0.0

    @property
    def status(self) -> list[Status]:
        """How the steps of every lane ended since the last reset."""
        lost = [bool(np.isnan(column).any()) for column in self.state.T]
        found = [classify_step(float(r), float(s)) for r, s in self.worst.T]
        return [Status.NOT_FINITE if n else s for n, s in zip(lost, found, strict=True)]

    def _fill(self, table: Numbers, values: Mapping[str, Any]) -> None:
        """Put parameters by path into the rows of a table, shape (parameters, lanes)."""
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
        """Signals of one moment, for all drives and lanes."""
        given = np.asarray(signals, float)
        try:
            return np.broadcast_to(given, self._shape)
        except ValueError:
            raise InputError(
                f"Signals of one moment must spread to {self._shape} (drives, lanes), but their shape is {given.shape}."
            ) from None

    def _require(self, given: Numbers) -> None:
        """Raise `InputError` unless signals of some steps spread over drives and lanes."""
        fits = given.ndim == 3 and all(a in (1, b) for a, b in zip(given.shape[1:], self._shape, strict=True))
        if not fits:
            raise InputError(
                f"Signals must be of shape (steps, drives, lanes) = (steps, "
                f"{self._shape[0]}, {self._shape[1]}), but theirs is {given.shape}."
            )
