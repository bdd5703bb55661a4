"""Suite for observers: names of estimates, finite values, steady state."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from martensite.control.loop.parts import NEVER
from martensite.control.observers.base import AbstractObserver
from martensite.kernels import floats
from martensite.kernels.namespace import Namespace, Scalar
from martensite.testing.conformance import require_condition
from martensite.testing.readings import PERIOD, require_same_traced

Named = Mapping[str, float]
ABSURD = ((1e9, 0.0), (-1e9, 0.0), (0.0, 0.0), (1e-300, 0.0), (1e9, NEVER))
"""Readings, and their ages [s]."""
WITHIN = 2.0
"""Allowed steady error in standard deviations; clipped sigma points shift the mean at full martensite."""


def find_readings(observer: AbstractObserver, xp: Namespace, signal: Scalar) -> dict[str, Any]:
    """Return the readings of the model at rest under a signal, and their ages."""
    model, count = observer.model, len(observer.model.drives())
    signals = [signal] * count
    outputs = model.observe(xp, model.init(xp, *signals), *signals)
    both = dict(zip(model.outputs(), outputs, strict=True))
    readings = {name: both[name] for name in observer.reads()}
    return readings | {f"{name}.age": 0.0 for name in readings}


def set_drives(observer: AbstractObserver, signal: Scalar) -> dict[str, Scalar]:
    """Return the same signal for each drive of the model."""
    return {drive.name: signal for drive in observer.model.drives()}


def check_reads(observer: AbstractObserver) -> None:
    """The model of an observer has all outputs that the observer reads."""
    unknown = set(observer.reads()) - set(observer.model.outputs())
    require_condition(not unknown, f"It reads {', '.join(sorted(unknown))}, which its model does not have.")


def check_memory(observer: AbstractObserver) -> None:
    """An observer gives one value per name, and its memory has constant size."""
    readings, names = find_readings(observer, floats, 0.0), list(observer.estimates())
    guess, memory = observer.rest(floats, readings, set_drives(observer, 0.0))
    count = len(memory)
    for k in range(3):
        require_condition(len(guess) == len(names), f"{len(guess)} estimates, but {len(names)} names.")
        require_condition(len(memory) == count, f"It remembers {count} numbers first, then {len(memory)}.")
        numbers = all(isinstance(x, float | int) for x in (*guess, *memory))
        require_condition(numbers, "What it estimates or remembers is not all numbers.")
        drives = set_drives(observer, 0.1 * k)
        guess, memory = observer.update(floats, memory, readings, drives, PERIOD, 1 + k)


def check_absurd_readings(observer: AbstractObserver) -> None:
    """For any readings, and without any reading, its estimates are finite."""
    readings, drives = find_readings(observer, floats, 0.0), set_drives(observer, 0.3)
    for level, age in ABSURD:
        absurd = {name: age if name.endswith(".age") else level for name in readings}
        guess, memory = observer.rest(floats, absurd, set_drives(observer, 0.0))
        for _ in range(3):
            guess, memory = observer.update(floats, memory, absurd, drives, PERIOD, 1)
        finite = bool(np.isfinite([*guess, *memory]).all())
        require_condition(finite, f"At readings of {level:g}, {age:g} s old, it says {list(guess)}.")
        estimates = dict(zip(observer.estimates(), guess, strict=True))
        fraction = estimates.get("martensite_fraction", 0.0)
        require_condition(0.0 <= fraction <= 1.0, f"It estimates a fraction of {fraction:.4g}.")


def check_rest(observer: AbstractObserver) -> None:
    """With the plant at rest, its estimates stay within their declared deviations."""
    readings, drives = find_readings(observer, floats, 0.0), set_drives(observer, 0.0)
    guess, memory = observer.rest(floats, readings, drives)
    first = dict(zip(observer.estimates(), guess, strict=True))
    for _ in range(5):
        guess, memory = observer.update(floats, memory, readings, drives, PERIOD, 1)
    last = dict(zip(observer.estimates(), guess, strict=True))
    for name in sorted(set(last) & set(observer.model.outputs())):
        allowed = WITHIN * last.get(f"{name}_std", 0.0) + 1e-9 * (1.0 + abs(first[name]))
        require_condition(
            abs(last[name] - first[name]) <= allowed,
            f"At rest its `{name}` goes from {first[name]:.6g} to {last[name]:.6g}.",
        )


def check_traced(observer: AbstractObserver) -> None:
    """Its estimates are a straight-line kernel."""

    def follow(one: AbstractObserver, xp: Namespace, u: Scalar, share: Scalar, age: Scalar) -> Any:
        readings = find_readings(one, xp, u)
        readings |= {name: share * readings[name] for name in one.reads()}
        readings |= {f"{name}.age": xp.maximum(age, 0.0) for name in one.reads()}
        first, memory = one.rest(xp, readings, set_drives(one, u))
        guess, memory = one.update(xp, memory, readings, set_drives(one, u), PERIOD, 1)
        return (*first, *guess, *memory)

    ranges = {"u": (0.0, 2.0), "share": (0.95, 1.05), "age": (-1.0, 1.0)}
    require_same_traced(observer, follow, ranges, 6)
