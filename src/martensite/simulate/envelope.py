"""The envelope: what no run leaves, whatever its parameters say.

No wire is hotter than where NiTi melts, colder than absolute zero, bears 3 GPa or is stretched by a
fifth, and a user may declare tighter bounds (`martensite.elements.limits`). A run that gets there
stops, and says when, where and how far.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from martensite import units
from martensite.simulate.compiled import ENVELOPE
from martensite.simulate.marching import Limits, Marched, Row
from martensite.system import AbstractSystem

STOPS = ("temperature_stop", "stress_stop", "strain_stop")
"""Numbers of an element that bound it more tightly."""
WORDS = {
    "hottest": "temperature", "stress": "stress", "strain": "strain",
}  # fmt: skip
BEYOND = {
    "hottest": "where NiTi melts, unless `temperature_stop` is lower",
    "stress": "what no NiTi wire bears, unless `stress_stop` is lower",
    "strain": "what no straight wire bears, unless `strain_stop` is lower",
}


def envelope_of(system: AbstractSystem) -> Limits:
    """Bounds of what `CompiledMarch.envelope` names."""
    low: list[float] = []
    high: list[float] = []
    for actuator in system.actuators().values():
        limits, straight = actuator.element.limits, actuator.element.straight
        strain = limits.strain_stop if straight else float("inf")
        low += [0.0, -limits.stress_stop, -strain]
        high += [limits.temperature_stop, limits.stress_stop, strain]
    return Limits(tuple(low), tuple(high))


def varied_stops(paths: Iterable[str]) -> list[str]:
    """Paths of parameters that bound an element."""
    return [path for path in paths if path.rpartition(".")[2] in STOPS]


def rows_inside(system: AbstractSystem, rows: Iterable[Row]) -> Iterator[Row]:
    """The rows of outputs before the first one that is outside; the first row of all stays."""
    names, limits = list(system.outputs()), envelope_of(system)
    places = [names.index(system.label(port, n)) for port in system.actuators() for n in ENVELOPE]
    for k, row in enumerate(rows):
        triples = zip(limits.low, (row[place] for place in places), limits.high, strict=True)
        if k and not all(low <= value <= high for low, value, high in triples):
            return
        yield row


def describe_exit(system: AbstractSystem, found: Marched) -> str:
    """When, where and how far a run left the envelope."""
    value = found.value
    ports = list(system.actuators())
    port, name = ports[found.place // len(ENVELOPE)], ENVELOPE[found.place % len(ENVELOPE)]
    limits = envelope_of(system)
    bound = limits.high[found.place] if value > 0.0 else limits.low[found.place]
    unit = system.outputs()[system.label(port, name)].unit
    shown = units.of_column(name, unit)
    where = f" of `{port}`" if len(ports) > 1 else ""
    reason = "absolute zero" if name == "hottest" and value <= 0.0 else BEYOND[name]
    return (
        f"The run stopped at t = {found.time:.6g} s: the {WORDS[name]}{where} came to "
        f"{units.from_si(value, shown, unit):.5g} {shown}, beyond "
        f"{units.from_si(bound, shown, unit):.5g} {shown}, {reason}."
    )
