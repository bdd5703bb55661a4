"""Lanes: many states of one system side by side, taken forward step by step from outside.

Where a march goes its way from rest to the end, lanes are pushed: each has a state of its own
that can be read, set and copied, and in every call its own signals. A predictive controller
tries its plans in them, a filter its sigma points, a learner its environments.

In C if there is a compiler: one library per system, for any number of lanes; else on floats. A
step that stays unsolved is made once more with more iterations; lanes whose step still fails are
named by `status`, and no error is raised, for lanes are there to try things.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from martensite.errors import InputError, suggestion
from martensite.runtimes.bracket import ITERATIONS
from martensite.runtimes.c99 import compiler
from martensite.simulate.compiled import compile_system
from martensite.simulate.lanes_native import NativeLanes, Numbers
from martensite.simulate.lanes_plain import PlainLanes
from martensite.simulate.march import classify
from martensite.status import Status
from martensite.system import AbstractSystem


class Lanes:
    """States of one system side by side."""

    def __init__(
        self, system: AbstractSystem, lanes: int, values: Mapping[str, Any] | None = None,
        native: bool | None = None,
    ) -> None:  # fmt: skip
        """Lanes of a system; `reset` puts them at rest.

        Args:
            system: a system, or a bench.
            lanes: how many.
            values: parameters by path that differ from lane to lane, each of shape (lanes,).
            native: whether to run in C; by default if there is a compiler.
        """
        quick = compile_system(system, ITERATIONS)
        given = dict(values or {})
        known = {leaf.path: leaf.value for leaf in system.leaves()}
        for path in given:
            if path not in known:
                raise InputError(f"There is no parameter `{path}`. {suggestion(path, known)}")
        rows = [np.broadcast_to(np.asarray(given.get(path, known[path]), float), lanes)
                for path in quick.paths]  # fmt: skip
        self.lanes, self.system = lanes, system
        self.names: tuple[str, ...] = quick.outputs
        self.drives = tuple(drive.name for drive in system.drives())
        table = np.array(rows).reshape(len(quick.paths), lanes)
        in_c = compiler() is not None if native is None else native
        self._engine = (
            NativeLanes(quick, table, system) if in_c else PlainLanes(quick, table, system)
        )
        self.state: Numbers = np.zeros((quick.size, lanes))
        """All state variables, shape (states, lanes); set it to go on from elsewhere."""
        self.worst: Numbers = np.zeros((2, lanes))
        """Worst reports since the last reset."""

    def reset(self, signals: Any = 0.0) -> None:
        """All lanes at rest under first signals, shape (drives, lanes) or what spreads to it."""
        self.state = self._engine.begin(self._spread(signals))
        self.worst[:] = 0.0

    def advance(self, signals: Any, dt: float, *, shown: bool = True) -> Numbers:
        """Go on through steps of dt [s].

        Args:
            signals: shape (steps, drives, lanes), or what spreads to it.
            dt: length of a step [s]; that of the system in discrete time.
            shown: whether outputs are wanted.

        Returns:
            Outputs after every step, under its signals, shape (steps, outputs, lanes), in the
            order of `names`; with no rows if they are not wanted.
        """
        given = np.asarray(signals, float)
        steps = given.shape[0]
        shape = steps, len(self.drives), self.lanes
        drives = np.ascontiguousarray(np.broadcast_to(given, shape))
        self.state, rows = self._engine.advance(self.state, drives, dt, shown, self.worst)
        return rows

    def observe(self, signals: Any) -> Numbers:
        """Outputs now under signals, shape (outputs, lanes)."""
        return self._engine.seen(self.state, self._spread(signals))

    def copy_from(self, other: Lanes, lane: int = 0) -> None:
        """Put all lanes into the state of one lane of others of the same system."""
        self.state = np.repeat(other.state[:, lane : lane + 1], self.lanes, axis=1)
        self.worst[:] = 0.0

    @property
    def status(self) -> list[Status]:
        """How the steps of every lane ended since the last reset."""
        return [classify(float(r), float(s)) for r, s in self.worst.T]

    def _spread(self, signals: Any) -> Numbers:
        shape = len(self.drives), self.lanes
        return np.ascontiguousarray(np.broadcast_to(np.asarray(signals, float), shape))
