"""Findings about loops that need no run: signals out of reach, and guard limits above element limits."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from martensite.actuators.elements.limits import MELTING
from martensite.base.formats import write_quantity
from martensite.control.supervisors.from_sensors import find_known_limit
from martensite.control.supervisors.guard import Guard
from martensite.kernels import floats
from martensite.signals.base import DRIVE

if TYPE_CHECKING:
    from martensite.actuators.assembly import AbstractSystem
    from martensite.control.checks.base import AbstractCheck
    from martensite.control.controllers.base import AbstractController
    from martensite.control.loop.bench import Bench
    from martensite.physics.electrical.base import AbstractSource

LIMITS, HOLDERS = ("low", "high"), ("", "law", "inner.law")
"""Parameters that are the least and largest signal, and the parts of controllers that have them."""
ROUNDING, SHORT = 1e-9, 0.05
"""Tolerances of the limits of a source: of a duty cycle, and of a supply, whose reach changes with the resistance."""


@dataclass(frozen=True)
class LoopFinding:
    """One finding of a check of a loop."""

    test: str
    where: str
    """Path of the parameter."""
    sentence: str
    number: float
    """Measured value, in the SI `unit`."""
    allowed: float
    unit: str
    remedy: str
    fault: bool
    """True if the loop cannot work; False for a caution."""

    def __str__(self) -> str:
        """Return the sentence with its remedy."""
        return f"{'Not sound' if self.fault else 'Caution'}: {self.sentence} {self.remedy}"


def check_signals(bench: Bench) -> list[LoopFinding]:
    """Return the limits of controllers that the sources cannot reach."""
    findings = list[LoopFinding]()
    for drive, controller in bench.controllers.members().items():
        findings.extend(_judge_span(f"controllers.{drive}", list_limits(controller)))
        source, ohms = find_source(bench.plant, drive)
        if source is not None:
            for path, value in list_limits(controller).items():
                findings.extend(_judge_limit(f"controllers.{drive}.{path}", value, source, ohms))
    return findings


def _judge_span(where: str, limits: Mapping[str, float]) -> Iterator[LoopFinding]:
    level = max(limits.values(), default=0.0)
    if len(limits) > 1 and min(limits.values()) == level:
        sentence = f"The least and the largest signal of `{where}` are both {level:.3g}: nothing is controlled."
        yield LoopFinding("signal", where, sentence, 0.0, 0.0, "1", "Try a larger `high`.", fault=True)


def check_guard(bench: Bench) -> list[LoopFinding]:
    """Return a fault for every limit of the guard above the limit of its element, or above its melting point."""
    checks = bench.supervisor.checks.members() if isinstance(bench.supervisor, Guard) else {}
    return [
        finding
        for name, one in checks.items()
        for finding in _judge_guard(bench, f"supervisor.checks.{name}.limit", one)
    ]


def _judge_guard(bench: Bench, where: str, check: AbstractCheck) -> Iterator[LoopFinding]:
    most, whose = find_known_limit(bench, check.registered_name, vars(check)), "limit of the element"
    unit = check.declarations["limit"].unit if "limit" in check.declarations else ""
    if most is None and unit == "K":
        most, whose = MELTING, "melting point of NiTi"
    if most is None or check.value_of("limit") <= most * (1.0 + ROUNDING):
        return
    limit, own = check.value_of("limit"), write_quantity(most, unit, 4)
    sentence = f"`{where}` is {write_quantity(limit, unit, 4)}, above the {whose}, {own}: it is not protected."
    remedy = f'Try `limit = "{own}"`, or change the `limits` of the element.'
    if most == MELTING:
        remedy = "Try the temperature that the element bears."
    yield LoopFinding("guard", where, sentence, limit, most, unit, remedy, fault=True)


def list_limits(controller: AbstractController) -> dict[str, float]:
    """Return the least and largest signal of a controller, by path."""
    return {
        leaf.path: float(leaf.value)
        for leaf in controller.leaves()
        if leaf.declared.unit == DRIVE and (split := leaf.path.rpartition("."))[2] in LIMITS and split[0] in HOLDERS
    }


def find_source(plant: AbstractSystem, drive: str) -> tuple[AbstractSource | None, float]:
    """Return the source of a drive, and the resistance of its element in the steady state [ohm]."""
    for port, one in plant.actuators().items():
        if plant.drive_at(port) == drive:
            signals = [one.environment.temperature if each.unit == "K" else 0.0 for each in plant.drives()]
            rest: Any = plant.observe(floats, plant.init(floats, *signals), *signals)
            outputs = dict(zip(plant.outputs(), rest, strict=True))
            return one.source, float(outputs[plant.label(port, "resistance")])
    return None, math.nan


def _judge_limit(where: str, value: float, source: AbstractSource, ohms: float) -> Iterator[LoopFinding]:
    reach, unit, name = source.reach(ohms), source.unit, where.rpartition(".")[2]
    words, title = f"`{where}` is {write_quantity(value, unit)}", source.registered_name
    slack = ROUNDING if unit == "1" else SHORT
    idle, *sizes = (source.current(floats, u, ohms) ** 2 for u in (0.0, value, -value))
    heats = value < 0.0 and min(sizes) > idle
    if heats:
        sentence = f"{words}: below 0 the element is heated again, and the loop turns its sign."
        yield LoopFinding("signal", where, sentence, value, 0.0, unit, f"Try `{name} = 0`.", fault=True)
    for bound, beyond, side in ((reach.least, reach.least - value, "least"), (reach.most, value - reach.most, "most")):
        if beyond > slack * max(abs(bound), ROUNDING) and not heats:
            at = "" if unit == "1" else f" at {ohms:.3g} ohm"
            sentence = f"{words}, but `{title}` can be given {write_quantity(bound, unit, 4)} at {side}{at}."
            level = write_quantity(bound, unit, 3)
            remedy = f"Try `{name} = {level}`." if unit == "1" else f'Try `{name} = "{level}"`.'
            yield LoopFinding("signal", where, sentence, value, bound, unit, remedy, fault=unit == "1")
