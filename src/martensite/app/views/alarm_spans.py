"""Alarms as the bench shows them: with the spans of time in which they occur.

Margins are those by which `martensite.simulate.alarms` judges, linear between samples.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import asdict
from itertools import pairwise

from martensite.app.messages import JsonTable
from martensite.app.views.columns import describe_column
from martensite.app.views.traces import TOGETHER
from martensite.control.loop.names import ALARM
from martensite.show.figures.bench_loops import find_alarmed_spans
from martensite.simulate.alarms import Alarm, farthest_changes, undelivered_margins
from martensite.simulate.result import Result

LEVELS = ("temperature", "stress")
"""Kinds whose limit is a level of the column itself."""
Span = tuple[float, float]
MOST_SPANS = 400
"""Spans that are told; what follows is one."""


def list_alarms(result: Result) -> list[JsonTable]:
    """All alarms with panel, column, how it is shown, and spans [s]; then the supervisor's."""
    found = [_describe_alarm(result, alarm) for alarm in result.alarms]
    return [*found, *_list_supervised(result)]


def _describe_alarm(result: Result, alarm: Alarm) -> JsonTable:
    port = alarm.port or next(iter(result.system.actuators()))
    column = result.system.label(port, alarm.quantity)
    spans = list(_find_spans(result.times, list_margins(result, alarm, port)))
    return {
        **asdict(alarm),
        "column": column,
        "how": describe_column(result, column),
        "panel": TOGETHER.get(alarm.quantity, alarm.quantity),
        "spans": _limit_spans(spans),
        "level": alarm.limit if alarm.kind in LEVELS else None,
    }


def list_margins(result: Result, alarm: Alarm, port: str) -> Sequence[float]:
    """How far beyond its limit the quantity is at every sample."""
    system = result.system
    values = result.columns[system.label(port, alarm.quantity)]
    if alarm.kind == "slack":
        return [1.0 if value <= 0.0 else -1.0 for value in values]
    if alarm.kind == "supply":
        ohms = result.columns[system.label(port, "resistance")]
        return undelivered_margins(system.actuators()[port].source, values, ohms)
    judged = farthest_changes(values) if alarm.kind == "strain" else values
    return [value - alarm.limit for value in judged]


def _find_spans(times: Sequence[float], margins: Sequence[float]) -> Iterator[Span]:
    """Spans in which a margin, linear between samples, is above zero."""
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
    """At most `MOST` spans."""
    return spans if len(spans) <= MOST_SPANS else [*spans[: MOST_SPANS - 1], (spans[MOST_SPANS - 1][0], spans[-1][1])]


def _list_supervised(result: Result) -> Iterator[JsonTable]:
    """The alarm of the supervisor of a bench, if it was raised."""
    spans = find_alarmed_spans(result)
    if not spans:
        return
    first, duration = spans[0][0], sum(end - begin for begin, end in spans)
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
        "sentence": f"Warning: the supervisor raised its alarm, first at t = {first:.4g} s, for "
        f"{duration:.3g} s in all.",
        "column": ALARM,
        "panel": ALARM,
        "how": describe_column(result, ALARM),
        "spans": _limit_spans(spans),
        "level": None,
    }
