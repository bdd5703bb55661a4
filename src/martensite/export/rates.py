"""Rate-dependent systems as ordinary differential equations for an external integrator.

In addition to `init`, `step` and `observe` their program has a function

    differentiate(state, inputs) -> state', d(continuous numbers)/dt

with the right-hand side of the Rosenbrock steps (`martensite.physics.laws.rosenbrock`). Continuous are the populations
of all groups of layers and, unless it is prescribed, the temperature; all else in the state follows from them and from
the inputs. It is printed for Python floats and for C from the same trace.
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
from martensite.kernels import floats
from martensite.kernels.compute_once import cache_answers
from martensite.kernels.graph import PARAMETER
from martensite.kernels.nested import NestedShape, flatten_numbers
from martensite.kernels.program import Program
from martensite.simulate.compiled import compile_system


@dataclass(frozen=True)
class ContinuousState:
    """A number of a state that has a rate in time."""

    name: str
    unit: str
    words: str
    nominal: float
    """A usual size of it."""
    place: int
    """In the flat state."""


def gives_rates(system: AbstractSystem) -> bool:
    """Return whether a system is one of ordinary differential equations in closed form."""
    return _explain_no_rates(system) == ""


def require_rates(system: AbstractSystem) -> None:
    """Say why a system cannot be integrated by others.

    Raises:
        InputError: it has no rates.
    """
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
    """Return the continuous numbers of the state of a system that gives rates, in the order of their rates."""
    size = compile_system(system).size
    (actuator,) = system.actuators().values()
    shape = NestedShape(system.init(floats, *[300.0] * len(system.drives())))
    memory = shape.rebuild(range(size)).elements[0].memory
    law: Any = actuator.element.law
    found: list[ContinuousState] = []
    for variant, column in zip(("plus", "minus"), law.populations(memory), strict=True):
        for k, place in enumerate(column):
            name = f"variant_{variant}" + (f"[{k}]" if len(column) > 1 else "")
            found.append(ContinuousState(name, "1", f"population of the {variant} variant of martensite", 1.0, place))
    if not actuator.source.sets_temperature:
        words = "temperature as a continuous state"
        found.append(ContinuousState("temperature", "K", words, 100.0, memory.temperature))
    return tuple(found)


def trace_rates(system: AbstractSystem) -> Program:
    """Return the program of a rate-dependent system, with `differentiate`; equal structures share it."""
    return _trace_keyed(Keyed(system))


@cache_answers(32)
def _trace_keyed(keyed: Keyed[AbstractSystem]) -> Program:
    compiled, count = compile_system(keyed.part), len(keyed.part.drives())
    known, size = compiled.program, compiled.size
    program = Program(known.graph, list(known.parameters), dict(known.functions))
    numbers = {path: program.graph.input(f"p{i}", PARAMETER) for i, path in enumerate(compiled.paths)}
    system: Any = keyed.part.rebuilt(numbers)
    shape = NestedShape(system.init(program.xp, *program.functions["init"].outputs[:count]))

    def differentiate(xp: Any, *given: Any) -> list[Any]:
        state, rates = system.differentiate(xp, shape.rebuild(given[:size]), *given[size:])
        return [*flatten_numbers(state), *rates]

    names = [f"s{i}" for i in range(size)] + [f"u{i}" for i in range(count)]
    program.add(DIFFERENTIATE, names, differentiate)
    return program


def build_rates_core(system: AbstractSystem, *, name: str | None = None) -> CCore:
    """Return a rate-dependent system as C, with `NAME_differentiate`.

    Raises:
        ParameterError: the name is not an identifier.
    """
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
