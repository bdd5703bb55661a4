"""What a run must warn about: its alarms, and coarse steps; with time and amount."""

from __future__ import annotations

from martensite.simulate.alarms import Columns, alarms_of
from martensite.simulate.result import Result
from martensite.status import Status


def add_warnings(result: Result, columns: Columns | None = None) -> Result:
    """Note alarms and warnings in a result; judged on other columns than its own if given."""
    result.alarms.extend(alarms_of(result.system, result.times, columns or result.columns))
    result.warnings.extend(alarm.sentence for alarm in result.alarms)
    if result.status is Status.LONG_STEP:
        result.warnings.append(f"Warning: {result.status.sentence}")
    return result
