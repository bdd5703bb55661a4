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
from typing import Any

from martensite.base.errors import ParameterError
from martensite.base.parameters import Parametrised, param
from martensite.base.units import DEGREES
from martensite.control.checks.base import AbstractCheck
from martensite.control.loop.bench import Bench
from martensite.control.supervisors.from_plant import guard_for
from martensite.control.supervisors.from_sensors import checks_for
from martensite.kernels.namespace import Scalar
from martensite.scenario.build import Builder, Table, as_table, name_section
from martensite.scenario.sections import SUPERVISOR
from martensite.signals.base import DRIVE

FROM_PLANT, CHECKS, KIND = "from_plant", "checks", "kind"


class FromPlant(Parametrised):
    """What is known beside the plant for a guard that is made from it."""

    temperature_limit: Scalar = param(
        "K", "highest temperature; by default that of [element.limits]", above=0.0, default=math.inf
    )
    hottest: Scalar = param("K", "hottest surroundings; by default those of [environment]", above=0.0, default=math.inf)
    least_cooling: Scalar = param(
        "1", "least film coefficient over that of [environment]", above=0.0, high=1.0, default=1.0
    )
    full: Scalar = param(
        DRIVE, "largest signal; by default 1, for sources that take a duty", above=0.0, default=math.inf
    )
    band: Scalar = param(
        DEGREES, "how far below the limit signals come back, where the answer is `resume`", low=0.0, default=0.0
    )


def add_plant_checks(table: Table, bench: Bench, builder: Builder, noisy: bool) -> tuple[Table, set[str]]:
    """The table of a guard with the checks of its plant, if it wants them; paths of their numbers.

    Raises:
        InputError: the plant does not say what such a guard needs.
    """
    given = table.get(FROM_PLANT, False)
    rest = {key: value for key, value in table.items() if key != FROM_PLANT}
    if given is False:
        return rest, set()
    if given is not True and not isinstance(given, Mapping):
        raise ParameterError(
            f"[{SUPERVISOR}] `{FROM_PLANT}` must be true, false, or a table such as "
            f'`{{ hottest = "40 degC" }}`, but is {given!r}.'
        )
    path, below = f"{SUPERVISOR}.{FROM_PLANT}", f"{SUPERVISOR}.{CHECKS}"
    known: FromPlant = builder.build(FromPlant, {} if given is True else as_table(given, path), path)
    with name_section(SUPERVISOR):
        found = _build_checks(bench, known, noisy)
    rows, taken = dict(as_table(rest.get(CHECKS, {}), below)), set[str]()
    for name, check in found.items():
        own = as_table(rows.get(name, {}), f"{below}.{name}")
        row = dict(_write_row(check, builder.scales.drive))
        if own.get(KIND, row[KIND]) == row[KIND]:  # one of another kind stands instead
            rows[name] = row | own
            taken |= {f"{below}.{name}.{key}" for key in row if key not in own}
    return {**rest, CHECKS: rows}, taken


def _build_checks(bench: Bench, known: FromPlant, noisy: bool) -> dict[str, AbstractCheck]:
    limit = _known_number(known.temperature_limit)
    sensed = checks_for(bench, noisy=noisy, temperature_limit=limit, band=known.band)
    guard = guard_for(
        bench.plant,
        temperature_limit=limit,
        hottest=_known_number(known.hottest),
        least_cooling=known.least_cooling,
        full=_known_number(known.full),
        band=known.band,
        checks=sensed,
    )
    return guard.checks.members()


def _known_number(number: float) -> float | None:
    return number if math.isfinite(number) else None


def _write_row(check: AbstractCheck, drive: str) -> Iterator[tuple[str, Any]]:
    """A check as a table of a scenario; what is as by default is left out."""
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
