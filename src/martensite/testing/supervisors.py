"""Suite for supervisors and checks: finite values, alarms, and no cut without an alarm."""

import math
from typing import Any

import numpy as np

from martensite.control.checks.base import AbstractCheck
from martensite.control.loop.parts import AbstractSupervisor
from martensite.kernels import floats
from martensite.kernels.namespace import Namespace, Scalar
from martensite.testing.conformance import require_condition
from martensite.testing.readings import PERIOD, draw_readings, find_range, require_same_traced

COUNT = 400
"""Number of samples."""
DRIVE = "drive"
ABSURD = (math.nan, math.inf, -math.inf, 1e300)
WIDE = 3.0
"""Factor by which readings of a supervisor exceed the usual ones."""


def name_drives(part: AbstractSupervisor | AbstractCheck) -> list[str]:
    """Return the drives that a part names, or a default drive."""
    named = part.names() if isinstance(part, AbstractCheck) else part.drives()
    return list(dict.fromkeys(named)) or [DRIVE]


def separate_readings(check: AbstractCheck) -> AbstractCheck:
    """Return a check with different readings where it would compare a reading with itself."""
    names, texts = check.reads(), dict[str, str]()
    for name, declared in check.declarations.items():
        value = getattr(check, name)
        if declared.kind == "text" and value in names:
            texts[name] = f"other.{value}" if value in texts.values() else value
    return check.with_parts(**texts)


def check_alarm(check: AbstractCheck) -> None:
    """A check has a positive integer for its alarm."""
    require_condition(isinstance(check.alarm, int) and check.alarm > 0, f"Its `alarm` is {check.alarm}.")


def check_size(check: AbstractCheck) -> None:
    """The memory of a check has `size` numbers."""
    rng = np.random.default_rng(3)
    memory = check.rest(floats, draw_readings(check.reads(), rng))
    for _ in range(20):
        numbers = all(isinstance(x, float | int) for x in memory)
        require_condition(
            len(memory) == check.size and numbers, f"Its `size` is {check.size}, but it remembers {list(memory)}."
        )
        wanted = dict.fromkeys(name_drives(check), float(rng.uniform(0.0, 1.0)))
        readings = draw_readings(check.reads(), rng)
        memory = check.look(floats, memory, wanted, readings, PERIOD).memory
        memory = check.remember_allowed(floats, memory, wanted, PERIOD)


def check_trips(check: AbstractCheck) -> None:
    """A check trips and clears on some readings, and never does both at once."""
    check, rng, tripped, cleared = separate_readings(check), np.random.default_rng(4), 0, 0
    names = check.reads()
    readings = draw_readings(names, rng)
    memory, wanted = check.rest(floats, readings), dict.fromkeys(name_drives(check), 1.0)
    for k in range(COUNT):
        if k % 40 < 20:  # half of the time a reading stays as it is
            far = 10.0 ** rng.uniform(-6.0, 9.0)
            readings = {n: far * value for n, value in draw_readings(names, rng).items()}
        looked = check.look(floats, memory, wanted, readings, PERIOD)
        require_condition(not (looked.trips and looked.clears), f"It trips and clears at once, at {readings}.")
        tripped, cleared = tripped + bool(looked.trips), cleared + bool(looked.clears)
        memory = check.remember_allowed(floats, looked.memory, wanted, PERIOD)
    require_condition(tripped, f"In {COUNT} samples of all sorts of readings it never trips.")
    require_condition(cleared, f"In {COUNT} samples of all sorts of readings it never clears.")


def check_traced_check(check: AbstractCheck) -> None:
    """The findings of a check are a straight-line kernel."""

    def look(one: AbstractCheck, xp: Namespace, u: Scalar, *shares: Scalar) -> Any:
        wanted, findings = dict.fromkeys(name_drives(one), u), list[Scalar]()
        memory = one.rest(xp, place_readings(one.reads(), shares))
        for order in (shares, shares[::-1]):
            looked = one.look(xp, memory, wanted, place_readings(one.reads(), order), PERIOD)
            findings += [xp.where(looked.trips, 1.0, 0.0), xp.where(looked.clears, 1.0, 0.0)]
            memory = one.remember_allowed(xp, looked.memory, wanted, PERIOD)
        return (*findings, *memory, 0.0 * u)

    require_same_traced(check, look, {"u": (-1.0, 1.0), "x": (0.0, 1.0), "y": (0.0, 1.0)})


def place_readings(names: tuple[str, ...], shares: tuple[Scalar, ...]) -> dict[str, Scalar]:
    """Return readings and ages at these fractions of their usual ranges."""
    both = dict.fromkeys(entry for name in names for entry in (name, f"{name}.age"))
    readings: dict[str, Scalar] = {}
    for k, name in enumerate(both):
        low, high = find_range(name)
        readings[name] = low + shares[k % len(shares)] * (high - low)
    return readings


def check_verdict(supervisor: AbstractSupervisor) -> None:
    """A supervisor gives a signal for each drive, an integer alarm, and a memory of constant size."""
    rng = np.random.default_rng(6)
    memory = supervisor.rest(floats, draw_readings(supervisor.reads(), rng))
    count = len(memory)
    for _ in range(COUNT):
        wanted = {name: float(rng.uniform(-1.0, 1.0)) for name in name_drives(supervisor)}
        readings = {n: x * WIDE * rng.random() for n, x in draw_readings(supervisor.reads(), rng).items()}
        verdict = supervisor.judge(floats, memory, wanted, readings, PERIOD)
        require_condition(
            set(verdict.signals) == set(wanted),
            f"Asked for {', '.join(wanted)}, it answers {', '.join(verdict.signals)}.",
        )
        alarm, memory = verdict.alarm, verdict.memory
        require_condition(alarm >= 0.0 and alarm == int(alarm), f"Its alarm is {alarm}.")
        require_condition(len(memory) == count, f"It remembers {count} numbers first, then {len(memory)}.")
        same = all(verdict.signals[name] == value for name, value in wanted.items())
        require_condition(alarm > 0.0 or same, "It changes a signal without an alarm.")


def check_absurd_readings(supervisor: AbstractSupervisor) -> None:
    """For any readings, its signals are finite."""
    names = (*supervisor.reads(), *(f"{name}.age" for name in supervisor.reads()))
    wanted = dict.fromkeys(name_drives(supervisor), 0.5)
    for level in ABSURD:
        readings = dict.fromkeys(names, level)
        memory = supervisor.rest(floats, readings)
        for _ in range(3):
            verdict = supervisor.judge(floats, memory, wanted, readings, PERIOD)
            memory = verdict.memory
            finite = all(math.isfinite(x) for x in (*verdict.signals.values(), verdict.alarm))
            require_condition(finite, f"At readings of {level} it allows {verdict.signals}.")


def check_traced_verdict(supervisor: AbstractSupervisor) -> None:
    """Its verdict is a straight-line kernel."""

    def judge(one: AbstractSupervisor, xp: Namespace, u: Scalar, *shares: Scalar) -> Any:
        memory = one.rest(xp, place_readings(one.reads(), shares))
        outputs: list[Scalar] = []
        for order in (shares, shares[::-1]):
            wanted = dict.fromkeys(name_drives(one), u)
            verdict = one.judge(xp, memory, wanted, place_readings(one.reads(), order), PERIOD)
            memory = verdict.memory
            outputs += [*verdict.signals.values(), verdict.alarm]
        return (*outputs, *memory)

    require_same_traced(supervisor, judge, {"u": (-1.0, 1.0), "x": (0.0, 3.0), "y": (0.0, 3.0)})
