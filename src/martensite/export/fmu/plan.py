"""Plan of an FMU: a model in C, its step, and the names of its variables."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

from martensite.actuators.assembly import AbstractSystem
from martensite.base.errors import ParameterError
from martensite.base.parameters import Leaf, describe_structure
from martensite.control.loop.bench import Bench
from martensite.control.loop.run import reference_waveforms
from martensite.export.c_core import CCore, build_c_core
from martensite.export.ports.element import ElementPort, build_element_port
from martensite.scenario.scenario import Scenario
from martensite.simulate.api import longest_step

FREE, CONSTANT, HIDDEN = "FREE", "CONSTANT", "HIDDEN"


@dataclass(frozen=True)
class ModelNumber:
    """A parameter of the system."""

    leaf: Leaf
    name: str
    """Name of `--set` for a scenario, else the path."""
    unit: str
    kind: str
    """FREE to be set, CONSTANT, or HIDDEN if unused or an infinite limit."""
    place: int
    """Index among the parameters of the core."""


@dataclass(frozen=True)
class FmuPlan:
    """A model in C with the metadata of its archive."""

    identifier: str
    title: str
    system: AbstractSystem
    core: CCore
    step: float
    """Inner step, or period in discrete time [s]."""
    numbers: tuple[ModelNumber, ...]
    """All parameters of the system."""
    first: tuple[float, ...]
    """Start values of the inputs."""
    scenario: Scenario | None

    @property
    def period(self) -> float:
        """Return the sample time in discrete time [s]; else 0."""
        return self.system.sample_time()


def plan_port(model: Scenario | AbstractSystem, identifier: str, step: float | None, port: str | None) -> FmuPlan:
    """Return the plan of an element alone; its variables are named by their paths in it."""
    scenario = None if isinstance(model, AbstractSystem) else model
    system = model if isinstance(model, AbstractSystem) else model.system
    alone = build_element_port(system, port=port, velocity="given")
    if step is None:
        step = _choose_step(system, scenario, None)
    plan = plan_of(alone, identifier, step)
    return plan if scenario is None else replace(plan, title=scenario.title or identifier, scenario=scenario)


def plan_of(model: Scenario | AbstractSystem, identifier: str, step: float | None) -> FmuPlan:
    """Return the plan of a scenario or a system."""
    scenario = None if isinstance(model, AbstractSystem) else model
    system = _fix_steps(model if isinstance(model, AbstractSystem) else model.whole)
    chosen = _choose_step(system, scenario, step)
    core = build_c_core(system, name=f"{identifier}_core")
    return FmuPlan(
        identifier=identifier,
        title=identifier if scenario is None else scenario.title,
        system=system,
        core=core,
        step=chosen,
        numbers=_list_numbers(core, system, scenario),
        first=_first_inputs(core, system),
        scenario=scenario,
    )


def _fix_steps(system: AbstractSystem) -> AbstractSystem:
    """Return a bench with a fixed number of steps per period, whatever its parameters become."""
    if isinstance(system, Bench) and not system.substeps:
        return system.with_parts(substeps=system.turns)
    return system


def _choose_step(system: AbstractSystem, scenario: Scenario | None, step: float | None) -> float:
    period = system.sample_time()
    if step is not None and period:
        raise ParameterError(f"This model goes on in samples of {period:g} s; it has no step to choose.")
    if step is not None and not 0.0 < step < math.inf:
        raise ParameterError(f"Argument `step` must be above 0, but is {step}.")
    if step is not None:
        return step
    if period:
        return float(period)
    if scenario is None:
        return longest_step(system)
    if scenario.step is not None:
        return scenario.step
    return float(f"{scenario.equal_step():.9g}")


def _first_inputs(core: CCore, system: AbstractSystem) -> tuple[float, ...]:
    """Return the start of references, ambient temperatures for inputs in kelvin, and 0 for others."""
    levels: dict[str, float] = {}
    if isinstance(system, Bench):
        levels = {name: one.value(0.0) for name, one in reference_waveforms(system).items()}
    if isinstance(system, ElementPort):
        levels["ambient"] = system.environment.temperature
    for port, one in system.actuators().items():
        if one.source.sets_temperature:
            levels.setdefault(system.drive_at(port), one.environment.temperature)
    return tuple(levels.get(one.name, 0.0) for one in core.inputs)


def _list_numbers(core: CCore, system: AbstractSystem, scenario: Scenario | None) -> tuple[ModelNumber, ...]:
    places = {one.name: one.index for one in core.parameters}
    sampled = bool(system.sample_time())
    numbers: list[ModelNumber] = []
    for leaf in system.leaves():
        kind = FREE
        unused = isinstance(system, ElementPort) and leaf.path == "environment.temperature"  # `ambient` is an input
        if unused or leaf.path not in places or not math.isfinite(leaf.value):
            kind = HIDDEN
        elif sampled and _is_structural(system, leaf):
            kind = CONSTANT
        name = leaf.path if scenario is None else scenario.places.path(leaf.path)
        unit = leaf.declared.unit if scenario is None else scenario.places.unit(leaf)
        numbers.append(ModelNumber(leaf, name, unit, kind, places.get(leaf.path, 0)))
    return tuple(numbers)


def _is_structural(system: AbstractSystem, leaf: Leaf) -> bool:
    """Return whether other values of a parameter change the program or the period.

    Examples are the period of a bench and delays of its sensors. Trial values decide.
    """
    usual = describe_structure(system), system.sample_time()
    value, (low, high) = float(leaf.value), leaf.declared.bounds
    for one in {0.25 * value, 0.75 * value, 1.5 * value, 4.0 * value, low, high}:
        if math.isfinite(one) and one != value:
            try:
                other = system.with_values({leaf.path: one})
            except ParameterError:
                continue
            if (describe_structure(other), other.sample_time()) != usual:
                return True
    return False
