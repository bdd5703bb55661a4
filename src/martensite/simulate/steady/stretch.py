"""Several steps of a system as a function of the initial state, with exact derivatives.

The traced kernels are generated in C with derivatives (`martensite.kernels.slopes`) by state, drive inputs, step
lengths and selected parameters. One simulation returns the final state and its Jacobian.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from martensite.actuators.assembly import AbstractSystem
from martensite.base.errors import CompileError, SolveError
from martensite.base.lazy import write_install_line
from martensite.kernels import floats
from martensite.kernels.c99 import WIDTHS, slopes_source
from martensite.kernels.compiler import call_compiled, find_compiler, load_library
from martensite.kernels.compute_once import cache_answers
from martensite.kernels.nested import NestedShape
from martensite.kernels.slopes import differentiate_program
from martensite.signals.sampling.sampled import Numbers
from martensite.simulate.compiled import FED, CompiledMarch, compile_march
from martensite.simulate.march import classify_step


class StretchEnd(NamedTuple):
    """Result of several steps."""

    states: Numbers
    """States before every step and after the last, (steps + 1, states)."""
    slopes: Numbers
    """Derivatives of the last state, (states, directions)."""


class Stretch:
    """Steps of one system with selected varied parameters."""

    def __init__(self, system: AbstractSystem, moving: Sequence[str] = ()) -> None:
        """Compile a system with derivatives by the given full parameter paths.

        Raises:
            CompileError: no C compiler was found.
        """
        if find_compiler() is None:
            raise CompileError(
                "Steady states are computed in C, and no compiler was found; install gcc or clang, or "
                f"`{write_install_line('cc')}`."
            )
        self.system, self.compiled = system, compile_march(system)
        self.values = np.array(self.compiled.values(system))
        self.moving = tuple(self.compiled.paths.index(path) for path in moving)
        self.size, self.outputs = self.compiled.size, tuple(self.compiled.outputs)

    @property
    def inputs(self) -> int:
        """Return the number of step inputs after the state: drive inputs and step length."""
        return self.compiled.inputs + 1

    def rest(self, signals: Sequence[float]) -> Numbers:
        """Return the equilibrium under initial signals."""
        return np.array(self._functions["init"](*signals))

    @cached_property
    def _functions(self) -> Any:
        return self.compiled.program.bind_floats(*self.values)

    def place(self, pick: Any) -> list[int]:
        """Return the indices in the flat state of the values that `pick` selects."""
        drives = [0.0] * self.compiled.drives
        shape = NestedShape(self.system.init(floats, *drives))
        return [int(i) for i in pick(shape.rebuild([float(i) for i in range(self.size)]))]

    def set_moving(self, values: Sequence[float]) -> None:
        """Set the varied parameters."""
        self.values[list(self.moving)] = values

    def march(self, state: Numbers, given: Numbers, seeds: Numbers, dgiven: Numbers, moves: Numbers) -> StretchEnd:
        """Compute the final state and its derivatives.

        Args:
            state: initial state, (states,).
            given: drive inputs and step lengths, (steps, inputs).
            seeds: derivatives of `state`, (states, directions).
            dgiven: derivatives of `given`, (steps, inputs, directions).
            moves: derivatives of the varied parameters, (parameters, directions).

        Raises:
            SolveError: a step failed.
        """
        count = seeds.shape[1]
        width = next((w for w in WIDTHS if w >= count), WIDTHS[-1])
        library = _load_library(self.compiled, self.moving, width)
        states, columns = np.empty((len(given) + 1, self.size)), [np.zeros((self.size, 0))]
        for k in range(0, max(count, 1), width):
            cut = slice(k, min(k + width, count))
            dp = _pad(moves[:, cut] if self.moving else np.zeros((1, 0)), width)
            last, worst = np.empty((self.size, width)), np.empty(len(self.compiled.report))
            arrays = (self.values, dp, np.ascontiguousarray(state), _pad(seeds[:, cut], width))
            arrays += (np.ascontiguousarray(given), _pad(dgiven[:, :, cut], width), states, last, worst)
            call_compiled(library.march_stretch, len(given), *arrays)
            columns.append(last[:, : cut.stop - k])
            status = classify_step(float(worst[0]), float(worst[1]))
            if status.failed or not np.isfinite(states).all():
                raise SolveError(f"A step towards the steady state failed. {status.sentence}")
        return StretchEnd(states, np.concatenate(columns, axis=1))

    def observe(self, states: Numbers, signals: Numbers) -> dict[str, Numbers]:
        """Return the outputs for states, (count, states), and signals, (count, drives)."""
        library = _load_library(self.compiled, self.moving, WIDTHS[0])
        rows = np.empty((len(states), len(self.outputs)))
        dp = np.zeros((max(len(self.moving), 1), WIDTHS[0]))
        arrays = (self.values, dp, np.ascontiguousarray(states), np.ascontiguousarray(signals), rows)
        call_compiled(library.observe_states, len(states), *arrays)
        return dict(zip(self.outputs, rows.T, strict=True))

    def observe_slopes(self, name: str, state: Numbers, signals: Numbers, seeds: Numbers) -> Numbers:
        """Return derivatives of an output, (directions,), from state derivatives, (states, directions)."""
        place, columns, width = self.outputs.index(name), list[Numbers](), WIDTHS[-1]
        library = _load_library(self.compiled, self.moving, width)
        for k in range(0, seeds.shape[1], width):
            cut = _pad(seeds[:, k : k + width], width)
            rows, dp = np.empty((len(self.outputs), width)), np.zeros((max(len(self.moving), 1), width))
            arrays = (self.values, dp, np.ascontiguousarray(state), np.ascontiguousarray(signals), cut, rows)
            call_compiled(library.observe_slopes, *arrays)
            columns.append(rows[place])
        return np.concatenate(columns)[: seeds.shape[1]]

    def signal_inputs(self) -> list[list[int]]:
        """Return the indices of each drive among the step inputs."""
        places, begin = list[list[int]](), 0
        for width in self.compiled.widths:
            places.append(list(range(begin, begin + width)))
            begin += width
        return places

    def hold(self, signals: Numbers) -> tuple[Numbers, Numbers]:
        """Return the step inputs of constant signals, and their derivatives, (inputs - 1, drives)."""
        row, slopes = np.zeros(self.inputs - 1), np.zeros((self.inputs - 1, len(signals)))
        for k, (places, u) in enumerate(zip(self.signal_inputs(), signals, strict=True)):
            level = [u, u * u, u, u, *[0.0] * (len(FED) - 4)] if len(places) > 1 else [u]
            change = [1.0, 2.0 * u, 1.0, 1.0, *[0.0] * (len(FED) - 4)] if len(places) > 1 else [1.0]
            row[places], slopes[places, k] = level, change
        return row, slopes


def _pad(array: Numbers, width: int) -> Numbers:
    """Return the array padded with zeros for unused directions."""
    more = [(0, 0)] * (array.ndim - 1) + [(0, width - array.shape[-1])]
    return np.ascontiguousarray(np.pad(array, more))


@cache_answers(32)
def _load_library(compiled: CompiledMarch, moving: tuple[int, ...], width: int) -> Any:
    size, inputs = compiled.size, compiled.inputs + 1
    places = range(len(compiled.outputs))
    states = {"step": size + inputs, "observe": size + compiled.drives}
    program = differentiate_program(compiled.program, moving, states, places)
    constants = {
        "CONSTANTS": program.constants,
        "CONSTANT_SLOPES": program.constant_slopes,
        "SIZE": size,
        "INPUTS": size + inputs,
        "RESULTS": size + len(compiled.report),
        "DRIVES": compiled.drives,
        "OUTPUTS": len(compiled.outputs),
        "REPORTS": len(compiled.report),
    }
    functions = list(program.functions.values())
    defined = "".join(f"#define {key} {value}\n" for key, value in constants.items())
    loop = Path(__file__).with_name("period.c").read_text(encoding="utf-8")
    return load_library(slopes_source(program, functions, moving, width) + defined + loop)
