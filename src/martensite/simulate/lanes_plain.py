"""Lanes one after the other on floats, where there is no compiler."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from martensite.simulate.compiled import Compiled
from martensite.simulate.lanes_native import Numbers


class PlainLanes:
    """Lanes one after the other on floats."""

    def __init__(self, compiled: Compiled, table: Numbers) -> None:
        self.compiled, self.table = compiled, np.array(table)
        self.functions = [compiled.program.bind_floats(*column) for column in table.T.tolist()]
        self.worst = np.zeros((2, table.shape[1]))

    def set_table(self, table: Numbers) -> None:
        """Other parameters, shape (parameters, lanes)."""
        changed = np.flatnonzero((table != self.table).any(axis=0))
        self.table = np.array(table)
        for lane in changed.tolist():
            self.functions[lane] = self.compiled.program.bind_floats(*table[:, lane].tolist())

    def begin(self, signals: Numbers) -> Numbers:
        """The state at rest."""
        rows = zip(self.functions, signals.T.tolist(), strict=True)
        return np.array([functions["init"](*u) for functions, u in rows]).T

    def advance(self, state: Numbers, signals: Numbers, dt: float, shown: bool) -> tuple[Numbers, Numbers]:
        """State after some steps, and outputs; signals may spread over drives and lanes."""
        lanes, size = state.shape[1], self.compiled.size
        drives = np.broadcast_to(signals, (len(signals), self.compiled.drives, lanes))
        rows = np.empty((len(drives) if shown else 0, len(self.compiled.outputs), lanes))
        after = np.empty_like(state)
        for lane, now in enumerate(state.T.tolist()):
            for k, u in enumerate(drives[:, :, lane].tolist()):
                found = self._step(lane, [*now, *u, dt])
                now = list(found[:size])
                self.worst[:, lane] = np.maximum(self.worst[:, lane], found[size : size + 2])
                if shown:
                    rows[k, :, lane] = self.functions[lane]["observe"](*now, *u)
            after[:, lane] = now
        return after, rows

    def read_outputs(self, state: Numbers, signals: Numbers) -> Numbers:
        """Outputs in a state."""
        rows = zip(self.functions, state.T.tolist(), signals.T.tolist(), strict=True)
        return np.array([functions["observe"](*now, *u) for functions, now, u in rows]).T

    def _step(self, lane: int, arguments: Sequence[float]) -> Sequence[float]:
        try:
            return self.functions[lane]["step"](*arguments)
        except ArithmeticError:  # a division by zero or an overflow
            return [*arguments[: self.compiled.size], math.inf, 0.0]
