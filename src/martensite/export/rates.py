"""Rate-dependent systems as ordinary differential equations for an external integrator.

In addition to `init`, `step` and `observe` their program has a function

    differentiate(state, inputs) -> state', d(continuous numbers)/dt

with the right-hand side of the Rosenbrock steps (`martensite.physics.laws.rosenbrock`). Continuous states are the
populations of all groups of layers and, unless prescribed, the temperature; the rest of the state follows from them and
the inputs.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from martensite.actuators.assembly import AbstractSystem
from martensite.actuators.assembly.base import AbstractAssembly
from martensite.base.errors import InputError
from martensite.base.parameters import Keyed
from martensite.export.c_core import CCore, core_of, describe_drives, list_outputs
from martensite.export.c_rates import DIFFERENTIATE
from martensite.export.ports.element import ElementPort
from martensite.export.ports.kernel import extend_program
from martensite.kernels import floats
from martensite.kernels.compute_once import cache_answers
from martensite.kernels.nested import NestedShape, flatten_numbers
from martensite.kernels.program import Program
from martensite.simulate.compiled import compile_system


@dataclass(frozen=True)
class ContinuousState:
    """A continuous number of a state."""

    name: str
    unit: str
    words: str
    nominal: float
    """Nominal value."""
    place: int
    """Index in the flat state."""


def gives_rates(system: AbstractSystem) -> bool:
    """Return whether a system is a closed set of ordinary differential equations."""
    return _explain_no_rates(system) == ""


def require_rates(system: AbstractSystem) -> None:
    """Raise `InputError`, with the reason, for a system without rates."""
    why = _explain_no_rates(system)
    if why:
        raise InputError(f"There is no model exchange of this model: {why} Co-simulation is for every model.")


def _explain_no_rates(system: AbstractSystem) -> str:
    if system.sample_time():
        return "a loop goes on in periods of its own."
    if not isinstance(system, AbstractAssembly):
        return "it is no system of elements and a mechanism."
    elements = [one.element for one in system.actuators().values()]
    for element in elements:
        law = element.law.registered_name
        if not element.law.rate_dependent:
            return f"law `{law}` has no rates, and what it remembers of its turns is discrete."
        if not element.exchanges:
            return f"element `{element.registered_name}` with law `{law}` is not one phase state that nothing wears."
    if isinstance(system, ElementPort) or system.exchanges():
        return ""
    return "its rates are known of one element on a static load line alone, or of the element by its ports."


def list_continuous(system: AbstractSystem) -> tuple[ContinuousState, ...]:
    """Return the continuous states of a system with rates, in the order of the rates."""
    size = compile_system(system).size
    (actuator,) = system.actuators().values()
    shape = NestedShape(system.init(floats, *[300.0] * len(system.drives())))
    memory = shape.rebuild(range(size)).elements[0].memory
    law: Any = actuator.element.law
    states: list[ContinuousState] = []
    for variant, column in zip(("plus", "minus"), law.populations(memory), strict=True):
        for k, place in enumerate(column):
            name = f"variant_{variant}" + (f"[{k}]" if len(column) > 1 else "")
            states.append(ContinuousState(name, "1", f"population of the {variant} variant of martensite", 1.0, place))
    if not actuator.source.sets_temperature:
        words = "temperature as a continuous state"
        states.append(ContinuousState("temperature", "K", words, 100.0, memory.temperature))
    return tuple(states)


def trace_rates(system: AbstractSystem) -> Program:
    """Return the program of a rate-dependent system with `differentiate`; equal structures share it."""
    return _trace_keyed(Keyed(system))


@cache_answers(32)
def _trace_keyed(keyed: Keyed[AbstractSystem]) -> Program:
    program, system, shape, names = extend_program(keyed.part)
    size = compile_system(keyed.part).size

    def differentiate(xp: Any, *given: Any) -> list[Any]:
        state, rates = system.differentiate(xp, shape.rebuild(given[:size]), *given[size:])
        return [*flatten_numbers(state), *rates]

    program.add(DIFFERENTIATE, names, differentiate)
    return program


def build_rates_core(system: AbstractSystem, *, name: str | None = None) -> CCore:
    """Return a rate-dependent system as C, with `NAME_differentiate`."""
    compiled = compile_system(system)
    return core_of(
        system,
        trace_rates(system),
        compiled.size,
        describe_drives(system),
        list_outputs(system, compiled.outputs),
        name=name,
        precision="float64",
        reports=True,
        continuous=tuple(one.place for one in list_continuous(system)),
    )
