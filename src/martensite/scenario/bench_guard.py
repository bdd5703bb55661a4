"""The guard of a scenario: checks that it names, and if it wants so those that its plant gives.

    [supervisor]
    kind = "guard"
    from_plant = true                    # or a table: { hottest = "40 degC", least_cooling = 0.8 }

    [supervisor.checks.bound_drive]      # numbers of such a check, where others are wanted
    limit = "110 degC"

A check of another name, or of another kind, is one of its own.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any

from martensite.base.errors import ParameterError
from martensite.base.parameters import Parametrised, param
from martensite.base.units import DEGREES
from martensite.kernels.namespace import Scalar
from martensite.scenario.bench_tables import BENCH, SUPERVISOR
from martensite.scenario.build import Builder, Table, as_table, name_section
from martensite.signals.base import DRIVE

if TYPE_CHECKING:
    from martensite.control.checks.base import AbstractCheck
    from martensite.control.loop.bench import Bench

FROM_PLANT, CHECKS, KIND = "from_plant", "checks", "kind"
PLANT = "plant"
"""Origin of numbers that come from the plant."""


class FromPlant(Parametrised):
    """What is known beside the plant for a guard that is made from it."""

    temperature_limit: Scalar = param(
        "K", "highest temperature; by default that of [element.limits]", above=0.0, default=math.inf
    )
    hottest: Scalar = param(
        "K", "hottest surroundings; by default those of [environment]", above=0.0, default=math.inf
    )
    least_cooling: Scalar = param(
        "1", "least film coefficient over that of [environment]", above=0.0, high=1.0, default=1.0
    )
    full: Scalar = param(
        DRIVE,
        "largest signal; by default 1, for sources that take a duty",
        above=0.0,
        default=math.inf,
    )
    band: Scalar = param(
        DEGREES,
        "how far below the limit signals come back, where the answer is `resume`",
        low=0.0,
        default=0.0,
    )


def with_plant(table: Table, bench: Bench, builder: Builder, document: Table) -> Table:
    """The table of a guard, with the checks that its plant gives if it wants them.

    Raises:
        InputError: the plant does not say what such a guard needs.
    """
    given = table.get(FROM_PLANT, False)
    rest = {key: value for key, value in table.items() if key != FROM_PLANT}
    if given is False:
        return rest
    if given is not True and not isinstance(given, Mapping):
        raise ParameterError(
            f"[{SUPERVISOR}] `{FROM_PLANT}` must be true, false, or a table such as "
            f'`{{ hottest = "40 degC" }}`, but is {given!r}.'
        )
    path = f"{SUPERVISOR}.{FROM_PLANT}"
    known = builder.build(FromPlant, {} if given is True else as_table(given, path), path)
    with name_section(SUPERVISOR):
        found = _build_checks(bench, known, document)
    own = as_table(rest.get(CHECKS, {}), f"{SUPERVISOR}.{CHECKS}")
    rows = {name: dict(_write_row(one, builder)) for name, one in found.items()}
    return {**rest, CHECKS: own | {name: _merge_row(row, own, name) for name, row in rows.items()}}


def note_origins(table: Table, full: Table, origins: dict[str, str]) -> None:
    """Say of the numbers that a guard has from its plant that they come from there."""
    own = as_table(table.get(CHECKS, {}), f"{SUPERVISOR}.{CHECKS}")
    for name, row in as_table(full.get(CHECKS, {}), f"{SUPERVISOR}.{CHECKS}").items():
        written = as_table(own.get(name, {}), f"{SUPERVISOR}.{CHECKS}.{name}")
        for key in row if isinstance(row, dict) else ():
            path = f"{SUPERVISOR}.{CHECKS}.{name}.{key}"
            if key not in written and path in origins:
                origins[path] = PLANT


def _build_checks(bench: Bench, known: FromPlant, document: Table) -> dict[str, AbstractCheck]:
    """Checks of the plant and its sensors, by name."""
    from martensite.control.supervisors.from_plant import guard_for
    from martensite.control.supervisors.from_sensors import checks_for

    def told(number: float) -> float | None:
        return number if math.isfinite(number) else None

    limit, noisy = told(known.temperature_limit), document.get(BENCH, {}).get("noise") != "none"
    sensed = checks_for(bench, noisy=noisy, temperature_limit=limit, band=known.band)
    guard = guard_for(
        bench.plant,
        temperature_limit=limit,
        hottest=told(known.hottest),
        least_cooling=known.least_cooling,
        full=told(known.full),
        band=known.band,
        checks=sensed,
    )
    return guard.checks.members()


def _write_row(check: AbstractCheck, builder: Builder) -> Iterator[tuple[str, Any]]:
    """A check as a table of a scenario; what is as by default is left out."""
    yield KIND, check.registered_name
    for name, declared in check.declarations.items():
        value = check.__dict__[name]
        if value == declared.default:
            continue
        if declared.kind != "parameter":
            yield name, list(value) if isinstance(value, tuple) else value
            continue
        unit = builder.scales.drive if declared.unit == DRIVE else declared.unit
        yield name, value if unit == "1" else f"{value!r} {'K' if unit == DEGREES else unit}"


def _merge_row(row: dict[str, Any], own: Table, name: str) -> Table:
    """A check of the plant with the numbers that are given; one of another kind instead."""
    given = as_table(own.get(name, {}), f"{SUPERVISOR}.{CHECKS}.{name}")
    return {**row, **given} if given.get(KIND, row[KIND]) == row[KIND] else given
