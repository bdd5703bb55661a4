"""Steps on plain floats: quick ones, and again with patience where one stays unsolved."""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property

from martensite.runtimes.bracket import ITERATIONS
from martensite.simulate.compiled import compile_system
from martensite.simulate.march import SOLVED, Functions
from martensite.system import AbstractSystem

THOROUGH = 24
"""Iterations of the solve when the usual few leave a step unsolved: kinks, strong pulses."""

Row = tuple[float, ...]


class Patient:
    """The step of a system; one that stays unsolved is made once more, thoroughly."""

    def __init__(self, system: AbstractSystem) -> None:
        self.system = system
        compiled = compile_system(system, ITERATIONS)
        self.size, self.outputs = compiled.size, compiled.outputs
        self.functions: Functions = compiled.program.bind_floats(*compiled.values(system))
        self.quick: Callable[..., Row] = self.functions["step"]

    def __call__(self, *arguments: float) -> Row:
        """State and report after a step."""
        after = self.quick(*arguments)
        return after if after[self.size] <= SOLVED else self.thorough(*arguments)

    @cached_property
    def thorough(self) -> Callable[..., Row]:
        """The step with more iterations, traced when it is first needed."""
        compiled = compile_system(self.system, THOROUGH)
        return compiled.program.bind_floats(*compiled.values(self.system))["step"]


def patient(system: AbstractSystem) -> tuple[Functions, int]:
    """The functions of a system on floats, with patient steps, and its number of states."""
    step = Patient(system)
    return {**step.functions, "step": step}, step.size
