"""Report on the guard of a scenario: all checks, and the worst state that they allow."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any

from martensite.actuators.elements.limits import MELTING
from martensite.base.errors import InputError
from martensite.base.formats import show_quantity
from martensite.base.summary import Block, DataTable, Sentence
from martensite.base.units import OF_READINGS
from martensite.control.checks.base import AbstractCheck
from martensite.control.checks.thermal_bound import ThermalBound
from martensite.control.loop.names import list_readings
from martensite.control.supervisors.default_guard import find_full_signal, list_heated
from martensite.control.supervisors.guard import Guard
from martensite.control.supervisors.worst_case import find_worst_case
from martensite.scenario.sections import SUPERVISOR

if TYPE_CHECKING:
    from martensite.control.loop.bench import Bench
    from martensite.scenario.scenario import Scenario

LIMITS = ("limit", "timeout", "longest")
"""Names of the parameters at which a check trips."""
LIMITED = (".limits.temperature_limit", ".limits.stress_limit")
"""Endings of the paths of the limits of elements."""
KELVIN = 1.0
"""Ignored excess of a temperature above its limit [K]."""


def collect_guard(scenario: Scenario) -> dict[str, Any] | None:
    """Return the checks of the guard and the worst case of every heated drive; None without a bench.

    Temperatures are in K. A worst case that is not defined, as for elements with several temperatures, is missing.
    """
    bench = scenario.bench
    if bench is None:
        return None
    controllers = bench.controllers.members()
    checks = bench.supervisor.checks.members() if isinstance(bench.supervisor, Guard) else {}
    worst: list[dict[str, Any]] = []
    for drive, one in list_heated(bench.plant, controllers).items():
        try:
            case = find_worst_case(bench, drive, find_full_signal(one, controllers[drive]))
        except InputError:
            continue
        trusts = getattr(checks.get(case.check), "cooling", "")
        limit = one.element.limits.temperature_limit
        worst.append({"drive": drive, **case._asdict(), "limit": limit, "trusts": trusts})
    return {"checks": [_collect_check(scenario, bench, name, one) for name, one in checks.items()], "worst": worst}


def describe_guard(guard: Mapping[str, Any]) -> Iterator[Block]:
    """Yield the report of the guard as a table, and a sentence for every drive."""
    if guard["checks"]:
        rows = [(one["check"], one["trips"], one["from"], one["then"]) for one in guard["checks"]]
        yield DataTable(("check", "trips at", "source of the limit", "action"), rows)
    for one in guard["worst"]:
        free, guarded = (_write_temperature(one[name]) for name in ("free", "guarded"))
        if not one["check"]:
            words = (
                f"No check limits the temperature of the element of `{one['drive']}`. "
                f"Its full command heats the element to {free}."
            )
            yield Sentence(words, "caution" if one["free"] > one["limit"] + KELVIN else "")
            continue
        trusted = f" if `{one['trusts']}` is correct" if one["trusts"] else ""
        words = (
            f"The guard `{one['check']}` keeps the element of `{one['drive']}` below {guarded}{trusted}, at the "
            f"ambient conditions of this file. Without the guard, the full command would heat it to {free}."
        )
        yield Sentence(words, "caution" if one["trusts"] or one["guarded"] > one["limit"] + KELVIN else "")


def _write_temperature(kelvin: float) -> str:
    return "its melting point" if kelvin > MELTING else show_quantity(kelvin, "K")


def _collect_check(scenario: Scenario, bench: Bench, name: str, check: AbstractCheck) -> dict[str, Any]:
    key = next((key for key in LIMITS if key in check.declarations), "")
    limit, unit = (check.value_of(key), check.declarations[key].unit) if key else (math.inf, "1")
    reading = getattr(check, "reading", getattr(check, "drive", ""))
    if unit in OF_READINGS:
        unit = list_readings(bench)[reading].unit
    return {
        "check": name,
        "kind": check.registered_name,
        "trips": f"{check.registered_name}: {reading} {show_quantity(limit, unit)}",
        "from": _find_origin(scenario, f"{SUPERVISOR}.checks.{name}.{key}", limit),
        "then": _tell_answer(bench, check),
    }


def _tell_answer(bench: Bench, check: AbstractCheck) -> str:
    """Return the response of the guard to a tripped check."""
    guard: Any = bench.supervisor
    drives = ", ".join(check.cuts() or [drive.name for drive in bench.plant.drives()])
    if isinstance(check, ThermalBound) and guard.answer == "limit":
        return f"limits {check.drive}"
    if guard.answer == "resume":
        return f"switches {drives} off until all checks pass"
    return f"switches {drives} off permanently"


def _find_origin(scenario: Scenario, path: str, limit: float) -> str:
    """Return the origin of a limit: the scenario, the sensors, or a limit of the element."""
    where = scenario.origins.get(path, "default")
    if where != "plant":
        return where
    for leaf in scenario.leaves():
        if leaf.path.endswith(LIMITED) and leaf.value == limit:
            own = scenario.places.path(leaf.path)
            return f"{own}, {scenario.origins.get(own, 'default')}"
    return where
