"""From the sections of a scenario to a bench: what is around the system that it describes.

    [sensor]      or [sensors.NAME]       kind, its parameters, and how it is mounted
    [observer]    or [observers.NAME]     kind and parameters; `model` is what it believes
    [controller]  or [controllers.DRIVE]  kind and parameters; period, limits
    [reference]   or [references.DRIVE]   a waveform in any unit of what is measured
    [supervisor], [faults.NAME]           kind and parameters
    [bench]                               period, steps, switching, seed

The model of an observer, or of a controller that has one, is the system of the scenario itself;
`model = { "element.diameter" = "0.37 mm" }` makes it another one. A controller that is no kernel
runs outside of the bench.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from martensite.base.errors import ParameterError, suggest_name
from martensite.base.parameters import Parametrised, option, param
from martensite.kernels.namespace import Scalar
from martensite.scenario.assemble import Assembly, section_of
from martensite.scenario.bench_controllers import ControllersBuilder
from martensite.scenario.bench_parts import PartsBuilder
from martensite.scenario.bench_tables import (
    BENCH,
    FAULTS,
    PAIRS,
    PERIOD,
    RUN,
    SECTIONS,
    SUPERVISOR,
    list_named,
    list_rows,
)
from martensite.scenario.build import Builder, Table
from martensite.scenario.places import Places

if TYPE_CHECKING:
    from martensite.actuators.assembly import AbstractSystem
    from martensite.control.controllers.base import AbstractController
    from martensite.control.loop.bench import Bench

MAKING = (
    "sensor",
    "sensors",
    "observer",
    "observers",
    "controller",
    "controllers",
    SUPERVISOR,
    FAULTS,
)
"""Sections that make a bench of a scenario."""


class Conduct(Parametrised):
    """How a bench runs."""

    period: Scalar = param("s", "time from one sample to the next", above=0.0, default=math.inf)
    substeps: Scalar = param(
        "1",
        "steps of the system in a period; 0: as many as it needs",
        low=0.0,
        high=1e6,
        default=0.0,
    )
    switching: str = option(
        "a switch (`pwm-voltage`): averaged over the period, or closed from its start for the "
        "share of it that the signal says",
        "averaged",
        "pulses",
        default="averaged",
    )
    noise: str = option("random numbers of the sensors", "drawn", "none", default="drawn")
    seed: Scalar = param("1", "where they begin, a whole number", low=0.0, high=2**53, default=0)

    def check(self) -> None:
        """Raise `ParameterError` where a count is no whole number."""
        for name in ("substeps", "seed"):
            value = getattr(self, name)
            if value != int(value):
                raise ParameterError(f"`{name}` must be a whole number, but is {value}.")


@dataclass(frozen=True)
class Closed:
    """A bench, and what a run of it needs beside."""

    bench: Bench
    outside: dict[str, AbstractController]
    """Controllers that are no kernels, by drive."""
    seed: int | None


def is_bench(document: Table) -> bool:
    """Whether a scenario describes a bench."""
    return any(name in document for name in MAKING)


def check_sections(document: Table) -> None:
    """Raise `ParameterError` for sections that have no effect or stand for the same."""
    for one, several in PAIRS.items():
        if one in document and several in document:
            raise ParameterError(f"A scenario has [{one}] or [{several}.NAME], not both.")
    idle = next((name for name in SECTIONS if name in document), None)
    if idle is not None and not is_bench(document):
        raise ParameterError(
            f"[{idle}] has no effect, since there is neither [sensor] nor [controller]."
        )


def has_controllers(document: Table) -> bool:
    """Whether a scenario has controllers."""
    return "controller" in document or "controllers" in document


def assemble_bench(assembly: Assembly, plant: AbstractSystem, places: Places) -> Closed | None:
    """The bench that a scenario describes, if it does; notes places and origins of its numbers.

    Raises:
        InputError: a section, a name or a value does not fit.
    """
    if not is_bench(assembly.document):
        return None
    places.note_system("plant", "")
    conduct = _build_conduct(assembly, places)
    bench, outside = _build_bench(PartsBuilder(assembly, plant, places), conduct)
    return Closed(bench, outside, int(conduct.seed) if conduct.noise == "drawn" else None)


def _build_bench(
    parts: PartsBuilder, conduct: Conduct
) -> tuple[Bench, dict[str, AbstractController]]:
    """The bench, and controllers outside of it."""
    from martensite.control.loop.bench import Bench
    from martensite.control.loop.parts import Controllers, Faults, Observers, Sensors

    document, given = parts.assembly.document, dict[str, Any]()
    given |= {"plant": parts.plant, "period": conduct.period, "switching": conduct.switching}
    given["substeps"] = int(conduct.substeps)
    given["sensors"] = Sensors(**dict(map(parts.sensor, list_rows(document, "sensor"))))
    bench = Bench(**given)
    observers = dict(parts.observer(bench, row) for row in list_rows(document, "observer"))
    bench = bench.with_parts(observers=Observers(**observers))
    builder = ControllersBuilder(parts, bench)
    found = dict(map(builder.controller, list_rows(document, "controller")))
    _check_references(document, found)
    faults = dict(parts.fault(bench, row) for row in list_named(document, FAULTS))
    bench = bench.with_parts(
        controllers=Controllers(**{name: one for name, one in found.items() if one.kernel}),
        supervisor=parts.supervisor(bench),
        faults=Faults(**faults),
    )
    return bench, {name: one for name, one in found.items() if not one.kernel}


def _check_references(document: Table, found: Mapping[str, AbstractController]) -> None:
    """Every reference is that of a controller."""
    single = "controller" in document
    given = section_of(document, "references", {})
    idle = next((name for name in given if single or name not in found), None)
    if idle is not None:
        raise ParameterError(
            f"[references.{idle}] has no effect, since there is no [controllers.{idle}]. "
            f"{suggest_name(idle, [] if single else found)}"
        )
    if "reference" in document and not single:
        raise ParameterError(
            "[reference] has no effect, since there is no [controller]; write [references.DRIVE]."
        )


def _build_conduct(assembly: Assembly, places: Places) -> Conduct:
    """[bench], with the period from where it stands."""
    document = assembly.document
    table = section_of(document, BENCH, {})
    stands = [
        (path, own[PERIOD])
        for path in ("controller", BENCH, RUN)
        if PERIOD in (own := section_of(document, path, {}))
    ]
    if len(stands) != 1:
        where = " and ".join(f"[{path}]" for path, _ in stands)
        fault = f"`period` stands in {where}; leave one" if where else "A bench needs `period`"
        raise ParameterError(
            f'{fault}: write `period = "20 ms"`, the time from one sample to the next, in '
            f"[{'controller' if 'controller' in document else BENCH}]."
        )
    ((path, given),) = stands
    made = Builder(origins=assembly.origins).build(Conduct, {**table, PERIOD: given}, BENCH)
    places.note(PERIOD, f"{path}.{PERIOD}")
    assembly.origins[f"{path}.{PERIOD}"] = "scenario"
    return made
