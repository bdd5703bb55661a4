"""Panels of columns over time and over one another, and alarms.

A panel has related columns: a coordinate with its reference and its readings, a temperature with the highest
temperature. Columns of an actuator are listed under its port, all others under the empty port.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import asdict, dataclass, field
from itertools import pairwise

import numpy as np

from martensite.actuators.assembly.outputs import OUTPUTS
from martensite.app.messages import JsonTable
from martensite.app.views.columns import describe_column
from martensite.control.loop.bench import Bench
from martensite.control.loop.names import ALARM, MEASURED
from martensite.control.observers.base import ESTIMATED
from martensite.show.figures.bench_loops import find_alarmed_spans
from martensite.show.figures.bench_loops import find_loops as controlled
from martensite.show.figures.hysteresis import LOOPS
from martensite.show.figures.labels import FRACTIONS
from martensite.simulate.alarms import Alarm, Numbers, farthest_changes, undelivered_margins
from martensite.simulate.result import Result

TOGETHER = {"hottest": "temperature", "oriented_fraction": "martensite_fraction", "heat_loss": "power"}
"""Output of the common panel by output of an actuator."""
USUAL = ("temperature", "martensite_fraction", "stress", "drive")
"""Panels of actuators that are displayed by default."""
LEVELS = ("temperature", "stress")
"""Kinds with a limit on the column itself."""
Span = tuple[float, float]
MOST_SPANS = 400
"""Largest number of listed spans; later ones are merged."""


@dataclass
class TracePanel:
    """Traces of one panel."""

    key: str
    title: str
    usual: bool
    includes: tuple[float, ...]
    """Values that the axis always includes [SI]."""
    ports: dict[str, list[str]] = field(default_factory=dict[str, list[str]])
    """Columns by port, without repeated ones."""

    def add(self, port: str, column: str) -> None:
        """Put a column into the panel."""
        self.ports.setdefault(port, []).append(column)


def list_panels(result: Result, *, repeated: bool = False) -> list[JsonTable]:
    """Return the panels over time, from top to bottom; `repeated` includes columns that repeat another."""
    panels: dict[str, TracePanel] = {}
    homes = _find_homes(result)
    for name in result.columns:
        port, key, usual = homes.get(name, ("", name, False))
        if key not in panels:
            title = OUTPUTS[key].long_name if key in OUTPUTS else _find_title(result, key, name)
            panels[key] = TracePanel(key, title, usual, (0.0, 1.0) if key in FRACTIONS else ())
        if repeated or not _is_repeated(result, panels[key], port, name):
            panels[key].add(port, name)
    for panel in panels.values():
        if sum(name in result.system.mechanism.outputs() for name in panel.ports.get("", [])) > 1:
            panel.title = "coordinates of the mechanism"
    return [asdict(panel) for panel in sorted(panels.values(), key=_rank_panel)]


def _find_homes(result: Result) -> dict[str, tuple[str, str, bool]]:
    homes = dict(_place_mechanism(result))
    for port, actuator in result.system.actuators().items():
        twice = actuator.source.sets_temperature
        for name in OUTPUTS:
            key = TOGETHER.get(name, name)
            usual = key in USUAL and not (twice and key == "drive")
            homes[result.system.label(port, name)] = port, key, usual
    beside = dict(_place_bench(result)) | dict(_place_estimates(result))
    return homes | {name: homes[home] for name, home in beside.items() if home in homes}


def _place_mechanism(result: Result) -> Iterator[tuple[str, tuple[str, str, bool]]]:
    """Yield port, panel and default visibility of the mechanism's outputs; outputs of one unit share a panel."""
    first: dict[str, str] = {}
    judged = result.system.mechanism.convergence_scales()
    for name, output in result.system.mechanism.outputs().items():
        key = first.setdefault(output.unit, name)
        yield name, ("", key, key in judged or key == result.coordinate)


def _place_bench(result: Result) -> Iterator[tuple[str, str]]:
    if not isinstance(result.system, Bench):
        return
    plant = result.system.plant
    for name, mounted in result.system.sensors.members().items():
        truth = mounted.sees()[0]
        if truth in result.outputs and result.unit(truth) == result.unit(MEASURED + name):
            yield MEASURED + name, truth
    drives = {plant.drive_at(port): plant.label(port, "drive") for port in plant.actuators()}
    for loop in controlled(result):
        names = [n for n in ("reference", f"reference.{loop.drive}") if n in result.columns]
        yield names[-1] if names else "", loop.truth
        if loop.requested_signal and loop.drive in drives:
            yield loop.requested_signal, drives[loop.drive]


def _place_estimates(result: Result) -> Iterator[tuple[str, str]]:
    return ((n, n.removeprefix(ESTIMATED)) for n in result.columns if n.startswith(ESTIMATED))


def _find_title(result: Result, key: str, name: str) -> str:
    return result.outputs[key if key in result.outputs else name].long_name


def _is_repeated(result: Result, panel: TracePanel, port: str, name: str) -> bool:
    """Return whether the panel already has this column, such as the only temperature."""
    base = name.rpartition(".")[-1]
    own = panel.ports.get(port, [])
    return base in TOGETHER and any(np.array_equal(result[name], result[other]) for other in own)


def _rank_panel(panel: TracePanel) -> tuple[bool, int]:
    """Return a sort key: default panels first; mechanism, then actuators, then others."""
    order = [*USUAL, *(name for name in OUTPUTS if name not in USUAL)]
    listed = panel.key in order
    return not panel.usual, order.index(panel.key) + 1 if listed else 0 if panel.usual else 99


def list_loops(result: Result) -> list[JsonTable]:
    """Return the quantities over one another, by port: `{key, ports: {port: [x, y]}}`.

    They include the first coordinate over temperature for a single actuator.
    """
    system = result.system
    ports = list(system.actuators())
    entries = [
        {"key": f"{y}-{x}", "ports": {p: [system.label(p, x), system.label(p, y)] for p in ports}} for x, y in LOOPS
    ]
    if len(ports) == 1:
        pair = [system.label(ports[0], "temperature"), result.coordinate]
        entries.append({"key": "stroke", "ports": {ports[0]: pair}})
    return entries if ports else []


def list_alarms(result: Result) -> list[JsonTable]:
    """Return all alarms with panel, column, display, and spans [s]; then the alarm of the supervisor."""
    rows = [_describe_alarm(result, alarm) for alarm in result.alarms]
    return [*rows, *_list_supervised(result)]


def _describe_alarm(result: Result, alarm: Alarm) -> JsonTable:
    port = alarm.port or next(iter(result.system.actuators()))
    column = _name_judged(result, alarm, port)
    spans = list(_find_spans(*list_margins(result, alarm, port)))
    return {
        **asdict(alarm),
        "column": column,
        "how": describe_column(result, column),
        "panel": TOGETHER.get(alarm.quantity, alarm.quantity),
        "spans": _limit_spans(spans),
        "level": alarm.limit if alarm.kind in LEVELS else None,
    }


def list_margins(result: Result, alarm: Alarm, port: str) -> tuple[Numbers, Numbers]:
    """Return times [s] and the excess of a quantity beyond its limit."""
    system, judged = result.system, _name_judged(result, alarm, port)
    names = [judged, system.label(port, "resistance")] if alarm.kind == "supply" else [judged]
    times, columns = result.draw_curves(names, [judged])
    values = columns[judged]
    if alarm.kind == "slack":
        return times, np.where(values <= 0.0, 1.0, -1.0)
    if alarm.kind == "supply":
        return times, undelivered_margins(system.actuators()[port].source, values, columns[names[1]])
    return times, (farthest_changes(values) if alarm.kind == "strain" else values) - alarm.limit


def _name_judged(result: Result, alarm: Alarm, port: str) -> str:
    """Return the column of an alarm: of an actuator, or of the common supply."""
    return alarm.quantity if alarm.kind == "rig" else result.system.label(port, alarm.quantity)


def _find_spans(times: Numbers, margins: Numbers) -> Iterator[Span]:
    """Yield the spans in which a margin, linear between its points, is above zero."""
    times, margins = times.tolist(), margins.tolist()
    begin = times[0] if margins[0] > 0.0 else None
    for (t0, m0), (t1, m1) in pairwise(zip(times, margins, strict=True)):
        if (m0 > 0.0) == (m1 > 0.0):
            continue
        at = t0 + (t1 - t0) * m0 / (m0 - m1)
        if begin is None:
            begin = at
        else:
            yield begin, at
            begin = None
    if begin is not None:
        yield begin, times[-1]


def _limit_spans(spans: list[Span]) -> list[Span]:
    return spans if len(spans) <= MOST_SPANS else [*spans[: MOST_SPANS - 1], (spans[MOST_SPANS - 1][0], spans[-1][1])]


def _list_supervised(result: Result) -> Iterator[JsonTable]:
    spans = find_alarmed_spans(result)
    if not spans:
        return
    first, duration = spans[0][0], sum(end - begin for begin, end in spans)
    raised = f"Warning: the supervisor raised its alarm, first at t = {first:.4g} s, for {duration:.3g} s in all."
    yield {
        "kind": "supervisor",
        "quantity": ALARM,
        "unit": "1",
        "worst": 1.0,
        "limit": 0.0,
        "excess": 1.0,
        "first": first,
        "duration": duration,
        "worst_time": first,
        "port": "",
        "sentence": next((one for one in result.warnings if one.startswith("Warning: The guard")), raised),
        "column": ALARM,
        "panel": ALARM,
        "how": describe_column(result, ALARM),
        "spans": _limit_spans(spans),
        "level": None,
    }
