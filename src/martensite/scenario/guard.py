"""Guard of a scenario: named checks, checks derived from the plant, or the default.

    [supervisor]
    kind = "guard"
    from_plant = true                    # or a table: { hottest = "40 degC", least_cooling = 0.8 }

    [supervisor.checks.bound_drive]      # changed parameters of a derived check
    limit = "110 degC"

A check of another name or kind is added to the derived checks. A check without a limit takes the limit of the element
that it reads (`temperature_limit`, `stress_limit`). An element without this limit is an error.

A loop without a section gets the default guard (`martensite.control.supervisors.default_guard`). A section without a
kind changes the parameters of the default guard. `kind = "none"` removes the guard.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import Any

from martensite.base.errors import ParameterError
from martensite.base.parameters import Number, Parametrised, param
from martensite.base.units import DEGREES
from martensite.control.checks.base import CHECKS as CHECK_KINDS
from martensite.control.checks.base import AbstractCheck
from martensite.control.controllers.base import AbstractController
from martensite.control.loop.bench import Bench
from martensite.control.supervisors import default_guard
from martensite.control.supervisors.from_plant import build_thermal_guard
from martensite.control.supervisors.from_sensors import build_sensor_checks, find_known_limit
from martensite.scenario.build import Builder, Table, as_table, name_section
from martensite.scenario.sections import SUPERVISOR
from martensite.signals.base import DRIVE

FROM_PLANT, CHECKS, KIND, LIMIT = "from_plant", "checks", "kind", "limit"
GUARD, NONE, ANSWER = "guard", "none", "answer"
UNGUARDED = "Nothing guards this loop: [supervisor] turns it off."


class FromPlant(Parametrised):
    """Conditions of a guard that is derived from the plant."""

    temperature_limit: Number = param(
        "K", "highest temperature; by default that of [element.limits]", above=0.0, default=math.inf
    )
    hottest: Number = param("K", "hottest surroundings; by default those of [environment]", above=0.0, default=math.inf)
    least_cooling: Number = param(
        "1",
        "least film coefficient over that of [environment]; above 1 for a guard that expects more",
        above=0.0,
        high=100.0,
        default=1.0,
    )
    full: Number = param(
        DRIVE, "largest signal; by default 1, for sources that take a duty", above=0.0, default=math.inf
    )
    band: Number = param(
        DEGREES, "how far below the limit signals come back, where the answer is `resume`", low=0.0, default=0.0
    )

    def numbers(self) -> dict[str, Any]:
        """Return the numbers of a bound; None for an unknown one."""
        numbers = {name: _known_number(getattr(self, name)) for name in ("temperature_limit", "hottest", "full")}
        return {**numbers, "least_cooling": self.least_cooling}


def complete_guard(
    table: Table, bench: Bench, controllers: Mapping[str, AbstractController], builder: Builder, noisy: bool
) -> tuple[Table | None, set[str], list[str]]:
    """Return the table of a guard, the paths of derived parameters, and sentences on missing data.

    The table is None without a guard.

    Raises:
        InputError: the plant lacks data for a requested guard.
    """
    kind = table.get(KIND)
    if kind == NONE:
        return None, set(), [UNGUARDED] if controllers else []
    checks, cautions = dict[str, AbstractCheck](), list[str]()
    rest = {key: value for key, value in table.items() if key != FROM_PLANT}
    conditions = _read_knowledge(table.get(FROM_PLANT, kind is None), builder)
    if kind is None:
        rest = {KIND: GUARD, ANSWER: default_guard.ANSWER, **rest}
    if conditions is not None:
        with name_section(SUPERVISOR):
            if kind is None:
                bounds, cautions = default_guard.find_default_bounds(bench.plant, controllers, **conditions.numbers())
                checks = {name: one.with_parts(band=conditions.band) for name, one in bounds.items()}
            else:
                checks = _build_checks(bench, conditions, noisy)
    full, taken = _fill_rows(rest, checks, bench, builder)
    if full[CHECKS] or kind is not None:
        return full, taken, cautions
    return None, set(), cautions or ([UNGUARDED] if conditions is None and controllers else [])


def _read_knowledge(given: Any, builder: Builder) -> FromPlant | None:
    """Return the conditions of derived checks, or None for a guard without them."""
    if given is False:
        return None
    if given is not True and not isinstance(given, Mapping):
        raise ParameterError(
            f"[{SUPERVISOR}] `{FROM_PLANT}` must be true, false, or a table such as "
            f'`{{ hottest = "40 degC" }}`, but is {given!r}.'
        )
    path = f"{SUPERVISOR}.{FROM_PLANT}"
    return builder.build(FromPlant, {} if given is True else as_table(given, path), path)


def _fill_rows(
    rest: Table, checks: Mapping[str, AbstractCheck], bench: Bench, builder: Builder
) -> tuple[Table, set[str]]:
    """Return the table of a guard with derived checks and limits, and the paths of these numbers."""
    below = f"{SUPERVISOR}.{CHECKS}"
    rows, taken = dict(as_table(rest.get(CHECKS, {}), below)), set[str]()
    for name, check in checks.items():
        own = as_table(rows.get(name, {}), f"{below}.{name}")
        row = dict(_write_row(check, builder.scales.drive))
        if own.get(KIND, row[KIND]) == row[KIND]:  # one of another kind stands instead
            rows[name] = row | own
            taken |= {f"{below}.{name}.{key}" for key in row if key not in own}
    for name, given in rows.items():
        own = as_table(given, f"{below}.{name}")
        limit = None if LIMIT in own else find_known_limit(bench, str(own.get(KIND)), own)
        if limit is not None:
            rows[name] = {**own, LIMIT: f"{limit!r} {CHECK_KINDS[str(own[KIND])].declarations[LIMIT].unit}"}
            taken.add(f"{below}.{name}.{LIMIT}")
    return {**rest, CHECKS: rows}, taken


def _build_checks(bench: Bench, conditions: FromPlant, noisy: bool) -> dict[str, AbstractCheck]:
    numbers = conditions.numbers()
    sensed = build_sensor_checks(
        bench, noisy=noisy, temperature_limit=numbers["temperature_limit"], band=conditions.band
    )
    return build_thermal_guard(bench.plant, **numbers, band=conditions.band, checks=sensed).checks.members()


def _known_number(number: float) -> float | None:
    return number if math.isfinite(number) else None


def _write_row(check: AbstractCheck, drive: str) -> Iterator[tuple[str, Any]]:
    """Yield a check as entries of a scenario, without default values."""
    yield KIND, check.registered_name
    for name, declared in check.declarations.items():
        value = check.__dict__[name]
        if value == declared.default:
            continue
        if declared.kind != "parameter":
            yield name, list(value) if isinstance(value, tuple) else value
            continue
        unit = drive if declared.unit == DRIVE else declared.unit
        yield name, value if unit == "1" else f"{value!r} {'K' if unit == DEGREES else unit}"
