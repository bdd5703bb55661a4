"""Guess of the meaning of columns without headings or units, from their values.

The physics of shape-memory records decides. A strain is a few percent at most, as a fraction up to 0.12. In an isobaric
loop the stress is constant and the strain falls as the temperature rises (the wire shortens on heating). In an
isothermal test the temperature is constant and the strain rises with the stress. A supply is stepped, and the current
follows with noise. Ambiguous columns are reported.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from martensite.base.units import choose_readable_unit
from martensite.logs.cells import Numbers
from martensite.logs.layout import CANONICAL

LARGEST_STRAIN = 0.12
"""Largest strain of a record in fractions; larger values are percent."""
STEADY = 0.15
"""Largest relative standard deviation of a constant quantity."""
STIFFEST = 1.2e11
"""Largest modulus of these alloys [Pa], with a margin; a stiffer column is not a stress."""
EVEN = 0.02
"""Largest relative deviation of equal time steps from their median."""

INFINITE = float("inf")
FRACTION = (("1", 1.0), ("%", INFINITE)), ((-1.0, INFINITE),)
SIZES = {
    "strain": ((("1", LARGEST_STRAIN), ("%", 15.0), ("ppm", INFINITE)), ((-1.0, 0.09), (0.15, 15.0))),
    "stress": ((("MPa", 1e5), ("Pa", INFINITE)), ((20.0, INFINITE),)),
    "martensite_fraction": FRACTION,
    "duty": FRACTION,
    "voltage": ((("V", 60.0), ("mV", INFINITE)), ((-1.0, 24.0),)),
    "current": ((("A", 15.0), ("mA", INFINITE)), ((-1.0, 15.0),)),
}
"""Units with the largest size of their values, and ranges of sizes without an alternative, by quantity."""
ROTATIONS = frozenset({"angle", "rotor_angle", "rotor_speed", "drive"})
"""Quantities in degrees or radians, or in rpm or rad/s."""


@dataclass(frozen=True)
class ValueGuess:
    """Meaning of a column, guessed from its values."""

    name: str
    unit: str
    sure: bool
    """True if there is no alternative."""


def guess_unit(name: str, numbers: Numbers) -> ValueGuess:
    """Return the unit of a known quantity without a unit in its heading; empty if the size does not decide."""
    finite = numbers[np.isfinite(numbers)]
    if not finite.size:
        return ValueGuess(name, "", False)
    low, high, size = float(finite.min()), float(finite.max()), float(np.abs(finite).max())
    if name == "temperature":
        return ValueGuess(name, "K", high < 700.0) if low > 200.0 else ValueGuess(name, "degC", size < 400.0)
    if name == "time":
        return ValueGuess(name, *_guess_time_unit(finite))
    if name in SIZES:
        units, sure = SIZES[name]
        unit = next(unit for unit, most in units if size <= most)
        return ValueGuess(name, unit, any(above < size <= most for above, most in sure))
    usual = "" if name in ROTATIONS else CANONICAL.get(name, "")
    return ValueGuess(name, usual and choose_readable_unit(usual), False)


def _guess_time_unit(times: Numbers) -> tuple[str, bool]:
    """Return seconds, except for computer stamps and widely spaced whole numbers; and certainty."""
    first = float(times[0])
    stamp = next((unit for unit, size in (("s", 1e9), ("ms", 1e12), ("us", 1e15)) if size < first < 2.2 * size), "")
    if stamp:
        return stamp, True
    steps = np.diff(times)
    step = float(np.median(steps[steps > 0.0])) if np.any(steps > 0.0) else 1.0
    if 3e4 < first < 6e4 and step < 0.02:
        return "day", True  # of a spreadsheet
    whole = bool(np.all(times == np.round(times)))
    if whole and step >= 1000.0 and times[-1] > 1e6:
        return "us", False
    return ("ms", False) if whole and step >= 5.0 else ("s", not whole or step <= 2.0)


def guess_columns(columns: Mapping[int, Numbers]) -> dict[int, ValueGuess]:
    """Return place -> meaning of columns from their values alone, without ambiguous columns."""
    left = {place: one for place, one in columns.items() if np.isfinite(one).sum() > 2}
    times = next((place for place, one in left.items() if is_even_time(one)), None)
    guesses: dict[int, ValueGuess] = {}
    if times is not None and len(columns) > 1:
        unit, sure = _guess_time_unit(left.pop(times))
        guesses[times] = ValueGuess("time", unit, sure)
    return guesses | (_guess_loop(left) or _guess_pair(left) or _guess_supply(left))


def is_even_time(numbers: Numbers) -> bool:
    """Return whether numbers rise by equal steps."""
    if not np.all(np.isfinite(numbers)) or len(numbers) < 3:
        return False
    steps = np.diff(numbers)
    middle = float(np.median(steps))
    return (
        middle > 0.0 and bool(np.all(steps > 0.0)) and float(np.quantile(np.abs(steps - middle), 0.9)) <= EVEN * middle
    )


def is_rising(numbers: Numbers) -> bool:
    """Return whether numbers never fall, and rise in total."""
    finite = numbers[np.isfinite(numbers)]
    return finite.size > 1 and bool(np.all(np.diff(finite) >= 0.0)) and bool(finite[-1] > finite[0])


def _is_strain(numbers: Numbers) -> bool:
    size, span = float(np.nanmax(np.abs(numbers))), float(np.nanmax(numbers) - np.nanmin(numbers))
    return 5e-4 < size < 15.0 and span > 2e-4 * max(1.0, size)


def _is_temperature(numbers: Numbers) -> bool:
    return float(np.nanmin(numbers)) > -200.0 and 10.0 < float(np.nanmax(numbers)) < 700.0


def _is_steady(numbers: Numbers) -> bool:
    mean = abs(float(np.nanmean(numbers)))
    return mean > 1.0 and float(np.nanstd(numbers)) <= STEADY * mean


def _correlate(one: Numbers, other: Numbers) -> float:
    both = np.isfinite(one) & np.isfinite(other)
    if both.sum() < 3 or np.ptp(one[both]) == 0.0 or np.ptp(other[both]) == 0.0:
        return 0.0
    return float(np.corrcoef(one[both], other[both])[0, 1])


def _guess_loop(columns: Mapping[int, Numbers]) -> dict[int, ValueGuess]:
    """Return temperature, strain and stress of a loop with constant temperature or stress."""
    places = _sort_loop(columns) if len(columns) == 3 else None
    if places is None:
        return {}
    strain, level, swept = places
    unit = guess_unit("strain", columns[strain])
    slope = _correlate(columns[swept], columns[strain])
    strains = float(np.ptp(columns[strain])) * (0.01 if unit.unit == "%" else 1.0)
    stiff = 1e6 * float(np.ptp(columns[swept])) / strains > STIFFEST
    if (slope < -0.3 or stiff) and _is_temperature(columns[swept]):
        heat, stress = swept, level
    elif slope > 0.3 and _is_temperature(columns[level]):
        heat, stress = level, swept
    else:
        return {}
    sure = abs(slope) > 0.5 or stiff
    units = {"temperature": heat, "stress": stress}
    guesses = {place: ValueGuess(name, guess_unit(name, columns[place]).unit, sure) for name, place in units.items()}
    return {strain: unit} | guesses


def _sort_loop(columns: Mapping[int, Numbers]) -> tuple[int, int, int] | None:
    """Return the places of the strain, of the constant quantity and of the other one of three columns."""

    def size(place: int) -> float:
        return float(np.nanmax(np.abs(columns[place])))

    strain, *others = sorted(columns, key=size)
    steady = [place for place in others if _is_steady(columns[place])]
    if not _is_strain(columns[strain]) or not steady:
        steady = [place for place in columns if _is_steady(columns[place])]  # 7 MPa is less than strains in percent
        if len(steady) != 1:
            return None
        strain = min((place for place in columns if place not in steady), key=size)
    level = min(steady, key=lambda place: float(np.nanstd(columns[place]) / np.nanmean(columns[place])))
    return strain, level, next(place for place in columns if place not in (strain, level))


def _guess_pair(columns: Mapping[int, Numbers]) -> dict[int, ValueGuess]:
    """Return a strain and a temperature with which it falls, or a stress with which it rises."""
    if len(columns) != 2:
        return {}
    strain, other = sorted(columns, key=lambda place: float(np.nanmax(np.abs(columns[place]))))
    slope, numbers = _correlate(columns[strain], columns[other]), columns[other]
    if (
        not _is_strain(columns[strain])
        or abs(slope) < 0.5
        or float(np.nanmax(np.abs(columns[strain]))) > 0.5 * float(np.nanmax(np.abs(numbers)))
    ):
        return {}
    name = "temperature" if slope < 0.0 and _is_temperature(numbers) else "stress"
    unit = guess_unit("strain", columns[strain])
    return {
        strain: ValueGuess("strain", unit.unit, False),
        other: ValueGuess(name, guess_unit(name, numbers).unit, False),
    }


def _guess_supply(columns: Mapping[int, Numbers]) -> dict[int, ValueGuess]:
    """Return the set-point of a stepped supply, and the current that follows it."""
    if len(columns) != 2:
        return {}
    levels = {place: len(np.unique(one[np.isfinite(one)])) for place, one in columns.items()}
    stepped = min(levels, key=levels.__getitem__)
    (follower,) = (place for place in columns if place != stepped)
    drive, answer = columns[stepped], columns[follower]
    if levels[stepped] < 3 or levels[stepped] * 5 > len(drive) or levels[follower] < 4 * levels[stepped]:
        return {}
    if _correlate(mend_fall(drive, answer)[0], answer) < 0.7:
        return {}
    milli = float(np.nanmax(drive)) > 60.0
    names = ("mV", "mA") if milli else ("V", "A")
    return {stepped: ValueGuess("voltage", names[0], False), follower: ValueGuess("current", names[1], False)}


def mend_fall(drive: Numbers, answer: Numbers) -> tuple[Numbers, list[int], float]:
    """Return a stepped drive repaired after resets of its counter, with rows and height of the resets.

    A fall is a reset if it is at least five usual steps and the answer changes by less than a tenth of its range.
    """
    steps = np.diff(drive)
    usual = float(np.median(np.abs(steps[steps != 0.0]))) if np.any(steps != 0.0) else 0.0
    reach = float(np.nanmax(answer) - np.nanmin(answer))
    falls = [
        int(k) + 1
        for k in np.flatnonzero(steps < -5.0 * usual)
        if abs(float(np.nanmedian(answer[k + 1 : k + 6]) - np.nanmedian(answer[max(0, k - 4) : k + 1]))) < 0.1 * reach
    ]
    if not falls or usual == 0.0 or not np.all(np.diff(falls) > 5):
        return drive, [], 0.0
    height = usual - float(steps[falls[0] - 1])
    mended = drive.copy()
    for row in falls:
        mended[row:] += height
    return mended, falls, height
