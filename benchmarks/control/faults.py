"""The twelve faults of the benchmark of controllers: each alone, from a time in the run on, with one set of numbers.

| fault | what goes wrong | until |
| --- | --- | --- |
| `ambient-step` | surroundings 15 K warmer | end |
| `draught` | a fan: film coefficient times 2.5 | end |
| `contact-resistance` | a fifth of the cold resistance of the element, in a row with it | end |
| `open-circuit` | a loose contact: no current | two thirds |
| `supply-sag` | 70 % of the voltage | end |
| `supply-surge` | 130 % of the voltage | end |
| `stuck-on` | the driver gives a quarter of its full signal, whatever is wanted | end |
| `drift` | the reading off by 5 % of its span per second | end |
| `drop-out` | no readings | two thirds |
| `stuck` | the same reading again and again | end |
| `noise-burst` | noise of 5 % of the span on top | two thirds |
| `late-readings` | readings 200 ms later | two thirds |

All begin after a third of the run. The numbers are chosen, from what benches of small wires meet, and are the same for
every controller.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

from martensite.base.errors import ParameterError, suggest_name
from martensite.control.faults.base import FAULTS, AbstractFault
from martensite.control.loop.bench import Bench
from martensite.kernels import floats

BEGIN, OVER = 1.0 / 3.0, 2.0 / 3.0
"""Shares of a run at which faults begin, and at which those that pass are over."""
OHMIC_SPAN = 0.12
"""Change of the resistance in a full stroke, as a share of it, where none is given; assumed, wires have 10 to 20 %."""


class FaultCase(NamedTuple):
    """A fault of the benchmark."""

    numbers: dict[str, float]
    """Of the fault; in shares where `scaled` says of what."""
    scaled: str = ""
    """`span` of the reading, `resistance` of the cold element, `full` signal, or nothing."""
    over: float = math.inf
    """Share of the run at which it is over."""


FAULT_CASES: dict[str, FaultCase] = {
    "ambient-step": FaultCase({"by": 15.0}),
    "draught": FaultCase({"factor": 2.5}),
    "contact-resistance": FaultCase({"resistance": 0.2}, "resistance"),
    "open-circuit": FaultCase({}, over=OVER),
    "supply-sag": FaultCase({"share": 0.7}),
    "supply-surge": FaultCase({"share": 1.3}),
    "stuck-on": FaultCase({"level": 0.25}, "full"),
    "drift": FaultCase({"rate": 0.05}, "span"),
    "drop-out": FaultCase({}, over=OVER),
    "stuck": FaultCase({}),
    "noise-burst": FaultCase({"deviation": 0.05}, "span", OVER),
    "late-readings": FaultCase({"by": 0.2}, over=OVER),
}
"""By the name of the fault, which is that of its kind."""


def build_faults(
    bench: Bench, duration: float, *, sensor: str = "", span: float | None = None, full: float = 1.0
) -> dict[str, AbstractFault]:
    """The twelve faults for a bench, by name; a table of one of them is `FaultTable(fault=found[name])`.

    Args:
        bench: the bench that they are for, with a sensor at least.
        duration: of the run [s].
        sensor: name of the sensor that fails; by default the first.
        span: of its reading [SI] in the task; by default 12 % of the resistance at rest, for a sensor of that.
        full: the full signal, in the unit of the sources.

    Raises:
        ParameterError: there is no such sensor, or its span is not known.
    """
    known = bench.sensors.members()
    if not known or (sensor and sensor not in known):
        raise ParameterError(f"The faults of the benchmark need a sensor. {suggest_name(sensor, known)}")
    failing = sensor or next(iter(known))
    ohms = _find_cold_resistance(bench)
    scales = {"": 1.0, "resistance": ohms, "full": full, "span": _require_span(bench, failing, span, ohms)}
    found: dict[str, AbstractFault] = {}
    for name, case in FAULT_CASES.items():
        cls = FAULTS[name]
        given: dict[str, Any] = {key: value * scales[case.scaled] for key, value in case.numbers.items()}
        given |= {"sensor": failing} if "sensor" in cls.declarations else {}
        found[name] = cls(**given, start=BEGIN * duration, end=case.over * duration)
    return found


def _require_span(bench: Bench, sensor: str, span: float | None, ohms: float) -> float:
    """Span of a reading [SI]: as given, or that of a resistance."""
    if span is not None:
        return span
    mounted = bench.sensors.members()[sensor]
    if mounted.sensor.unit != "ohm":
        raise ParameterError(
            f"Give the span of the reading of `{sensor}` in the task: only that of a resistance is known."
        )
    return OHMIC_SPAN * ohms


def _find_cold_resistance(bench: Bench) -> float:
    """Resistance of the first element at rest [ohm]."""
    plant = bench.plant
    idle = [0.0 for _ in plant.drives()]
    shown = dict(zip(plant.outputs(), plant.observe(floats, plant.init(floats, *idle), *idle), strict=True))
    return float(shown[plant.label(next(iter(plant.actuators())), "resistance")])
