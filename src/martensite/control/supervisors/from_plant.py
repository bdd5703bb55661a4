"""Guard from the data of a plant: temperature bounds of all elements.

The bounds are for elements of one temperature: wires, coils, bundles and chains. Ribbons and axial wires have many
temperatures, so that a bound of the mean does not cover their hottest point.
"""

import math
from collections.abc import Mapping

from martensite.actuators.assembly import AbstractSystem, Actuator
from martensite.actuators.elements.base import AbstractElement
from martensite.actuators.elements.lumped import AbstractLumped
from martensite.base.errors import InputError
from martensite.control.checks.base import AbstractCheck, Checks
from martensite.control.checks.thermal_bound import ThermalBound
from martensite.control.supervisors.guard import Guard
from martensite.kernels import floats
from martensite.physics.thermal.base import Environment
from martensite.physics.thermal.ends import AbstractEnds, AdiabaticEnds

GRID = 201
SHARES = tuple(10.0 ** (-0.25 * k) for k in range(13))
"""Fractions of the full signal in the search of the worst case."""
STRAINS = (0.0, 0.1)
"""Strains between which the resistance is searched for its extremes."""


def build_thermal_guard(
    system: AbstractSystem,
    *,
    temperature_limit: float | None = None,
    hottest: float | None = None,
    least_cooling: float = 1.0,
    full: float | None = None,
    band: float = 0.0,
    answer: str = "latch",
    hold: float = 0.0,
    checks: Mapping[str, AbstractCheck] | None = None,
) -> Guard:
    """Build a guard that bounds the temperature of every element of a plant without a sensor.

    Args:
        system: plant whose elements have one temperature, such as `wire` or a bundle.
        temperature_limit: highest temperature [K]; default: the limit of each element.
        hottest: highest ambient temperature [K]; default: the ambient temperature of each element.
        least_cooling: smallest film coefficient over the coefficient of the environment, such as 0.5 in enclosed air.
        full: largest signal, in the unit of the sources; default: 1, for sources with a duty cycle.
        band: distance below the limit at which signals come back [K], for the answer `resume`.
        answer: `latch`, `resume`, or `limit`, which lowers the signal so that the bound holds.
        hold: shortest time of a cut [s].
        checks: further checks by name.

    Raises:
        InputError: the limit or the full signal is missing, or an element has several temperatures.
    """
    bounds: dict[str, AbstractCheck] = dict(checks or {})
    for port, one in system.actuators().items():
        drive = system.drive_at(port)
        limit = one.element.limits.temperature_limit if temperature_limit is None else temperature_limit
        if not math.isfinite(limit):
            raise InputError(f"The element at `{drive}` has no `temperature_limit`; give one to the guard.")
        cut = () if len(system.actuators()) == 1 else (drive,)
        bound = find_bound(one, drive, limit, _find_full_signal(one, full), hottest, least_cooling)
        bounds[f"bound_{drive}"] = bound.with_parts(drives=cut, band=band)
    return Guard(checks=Checks(**bounds), answer=answer, hold=hold)


def find_bound(
    one: Actuator, drive: str, limit: float, full: float, hottest: float | None = None, least_cooling: float = 1.0
) -> ThermalBound:
    """Return the temperature bound of the actuator of a drive, at a limit [K]; options as for `build_thermal_guard`."""
    ambient = one.environment.temperature if hottest is None else hottest
    return ThermalBound(
        drive=drive,
        limit=limit,
        ambient=ambient,
        power=worst_power(one, limit, full),
        full=full,
        rises="square" if one.source.unit in ("V", "A") else "linear",
        capacity=one.element.heat_capacity_total(),
        conductance=least_cooling * least_conductance(one, ambient, limit),
    )


def worst_power(actuator: Actuator, hottest: float, full: float) -> float:
    """Return the power at full signal of the line or parabola that bounds the power of all signals [W].

    The bound holds for all resistances of the element up to `hottest` [K] and for sources with a limit.

    Raises:
        InputError: the source heats without a signal.
    """
    element, source = _require_lumped(actuator.element), actuator.source
    temperatures = actuator.environment.temperature, hottest
    ohms = [
        element.ohms(floats, fraction, strain, temperature, rphase)
        for fraction, rphase in ((0.0, 0.0), (1.0, 0.0), (0.0, 1.0))
        for strain in STRAINS
        for temperature in temperatures
    ]
    grid = _build_grid(min(ohms), max(ohms))

    def most(signal: float) -> float:
        currents = ((source.current(floats, sign * signal, one), one) for sign in (-1.0, 1.0) for one in grid)
        return max(current * current * one for current, one in currents)

    if most(0.0) > 0.0:
        raise InputError(f"Drive `{source.registered_name}` heats without a signal: no guard can bound that.")
    rises = 2 if source.unit in ("V", "A") else 1
    return max(most(full * share) / share**rises for share in SHARES)


def least_conductance(actuator: Actuator, ambient: float, limit: float) -> float:
    """Return the smallest heat loss per kelvin between ambient and limit [K], without the ends [W/K]."""
    element = _remove_ends(_require_lumped(actuator.element))
    around = Environment(temperature=ambient, cooling=actuator.environment.cooling)
    warm = _build_grid(ambient, limit)[1:]
    return min(element.heat_loss(floats, one, around) / (one - ambient) for one in warm)


def _find_full_signal(actuator: Actuator, full: float | None) -> float:
    if full is None and actuator.source.unit != "1":
        raise InputError(
            f"Drive `{actuator.source.registered_name}` takes a signal in {actuator.source.unit}: "
            f"give its largest value as `full`."
        )
    return 1.0 if full is None else full


def _require_lumped(element: AbstractElement) -> AbstractLumped:
    """Return the element; raise `InputError` if it has several temperatures."""
    if not isinstance(element, AbstractLumped):
        raise InputError(
            f"The bound of a guard is known for elements of one temperature, such as `wire`, not "
            f"for `{element.registered_name}`; give it as a check `thermal-bound`."
        )
    return element


def _remove_ends(element: AbstractElement) -> AbstractElement:
    parts = dict(element.children())
    inner = {n: _remove_ends(one) for n, one in parts.items() if isinstance(one, AbstractElement)}
    ends = {n: AdiabaticEnds() for n, one in parts.items() if isinstance(one, AbstractEnds)}
    return element.with_parts(**inner, **ends)


def _build_grid(low: float, high: float) -> list[float]:
    return [low + (high - low) * k / (GRID - 1) for k in range(GRID)]
