"""What a run must warn about: its alarms, coarse steps, and laws near where they are doubtful."""

from __future__ import annotations

from martensite.base.status import Status
from martensite.physics.laws.base import AbstractLaw
from martensite.simulate.alarms import Columns, alarms_of
from martensite.simulate.result import Result

NEAR = 0.8
"""Share of a stress from which a law is doubtful, from which on it is said."""


def add_warnings(result: Result, columns: Columns | None = None) -> Result:
    """Note alarms and warnings in a result; judged on other columns than its own if given."""
    result.alarms.extend(alarms_of(result.system, result.times, columns or result.columns))
    result.warnings.extend(alarm.sentence for alarm in result.alarms)
    if result.status is Status.LONG_STEP:
        result.warnings.append(f"Warning: {result.status.sentence}")
    result.warnings.extend(_describe_doubts(result, columns or result.columns))
    return result


def _describe_doubts(result: Result, columns: Columns) -> list[str]:
    """Of laws that the stress brings near to where they are doubtful."""
    found: list[str] = []
    for port, one in result.system.actuators().items():
        law, name = one.element.law, result.system.label(port, "stress")
        doubt = law.doubt() if isinstance(law, AbstractLaw) else None
        if doubt is None or name not in columns:
            continue
        most = max(map(abs, columns[name]))
        if most > NEAR * doubt.stress:
            words = f"Caution: {doubt.sentence} The stress comes to {most / 1e6:.4g} MPa."
            found.append(words)
    return list(dict.fromkeys(found))
