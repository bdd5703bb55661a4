"""Envelope: physical limits of every run.

The limits are the melting point of NiTi, absolute zero, a stress of 3 GPa and a strain of 20 %. Users can declare
tighter limits (`martensite.actuators.elements.limits`). A run stops at the envelope and reports time, place and
value.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator

import numpy as np

from martensite.actuators.assembly import AbstractSystem
from martensite.base import units
from martensite.base.formats import typeset_unit
from martensite.base.remember_results import remember
from martensite.simulate.compiled import ENVELOPE
from martensite.simulate.marching import Exit, Row, RunLimits
from martensite.simulate.track import Track

STOPS = ("temperature_stop", "stress_stop", "strain_stop")
"""Parameters of an element with tighter limits."""
WORDS = {"hottest": "temperature", "stress": "stress", "strain": "strain"}
BEYOND = {
    "hottest": "the melting point of NiTi or `temperature_stop`",
    "stress": "the strength of NiTi or `stress_stop`",
    "strain": "the fracture strain of a straight wire or `strain_stop`",
}


@remember
def envelope_of(system: AbstractSystem) -> RunLimits:
    """Return the bounds of `CompiledMarch.envelope`."""
    low: list[float] = []
    high: list[float] = []
    for actuator in system.actuators().values():
        limits, straight = actuator.element.limits, actuator.element.straight
        strain = limits.strain_stop if straight else float("inf")
        low += [0.0, -limits.stress_stop, -strain]
        high += [limits.temperature_stop, limits.stress_stop, strain]
    return RunLimits(tuple(low), tuple(high))


def varied_stops(paths: Iterable[str]) -> list[str]:
    """Return the paths of parameters that bound an element."""
    return [path for path in paths if path.rpartition(".")[2] in STOPS]


class Envelope:
    """Envelope of a system for rows of its outputs."""

    def __init__(self, system: AbstractSystem) -> None:
        names = list(system.outputs())
        ports = system.actuators()
        self.places = [names.index(system.label(port, name)) for port in ports for name in ENVELOPE]
        self.limits = envelope_of(system)

    def find_exit(self, row: Row, finite: bool = False) -> Exit | None:
        """Return the first limit that a row of outputs exceeds; None if it is inside."""
        return self.limits.find_exit([row[place] for place in self.places], finite)


def rows_inside(system: AbstractSystem, rows: Iterable[Row]) -> Iterator[Row]:
    """Yield the rows of outputs before the first row outside; always yield the first row."""
    envelope = Envelope(system)
    for k, row in enumerate(rows):
        if k and envelope.find_exit(row) is not None:
            return
        yield row


def cut_outside(system: AbstractSystem, track: Track) -> Track:
    """Return the rows of a single-run track before the first row outside."""
    envelope = Envelope(system)
    rows: list[list[float]] = track.values[:, envelope.places].tolist()
    outside_rows = (k for k, row in enumerate(rows) if k and envelope.limits.find_exit(row) is not None)
    return track.cut(np.arange(len(rows)) < next(outside_rows, len(rows)))


def describe_exit(system: AbstractSystem, time: float, place: int, value: float) -> str:
    """Describe the time [s], place and value at which a run left the envelope."""
    return f"The run stopped at t = {time:.6g} s: {describe_bound(system, place, value)}"


def describe_bound(system: AbstractSystem, place: int, value: float) -> str:
    """Describe the place and the value at which the envelope was left."""
    ports = list(system.actuators())
    port, name = ports[place // len(ENVELOPE)], ENVELOPE[place % len(ENVELOPE)]
    limits = envelope_of(system)
    bound = limits.high[place] if value > 0.0 else limits.low[place]
    unit = system.outputs()[system.label(port, name)].unit
    readable_unit = units.of_column(name, unit)
    where = f" of `{port}`" if len(ports) > 1 else ""
    reason = "absolute zero" if name == "hottest" and value <= 0.0 else BEYOND[name]
    limit = f"the limit of {units.from_si(bound, readable_unit, unit):.5g} {typeset_unit(readable_unit)}"
    excess = f"{units.from_si(value, readable_unit, unit):.5g} {typeset_unit(readable_unit)}"
    reached = limit if value == bound else f"{excess}, beyond {limit}"
    return f"the {WORDS[name]}{where} reached {reached} ({reason})."
