"""Choice of duty cycle profiles by their information for a fit, before the wire is heated.

    F = Σ_profiles Σ_t J(t)ᵀ J(t)/σ²,      J: slopes of the readings by the free parameters, in units of their widths

Profiles are chosen one by one, by the largest gain of ln det(F + 1) over their time, until the time is used (D-optimal,
greedy). A profile is used at most twice, and the noise σ of a reading is at least 1 % of its range, since models are
inexact. Widths are the uncertainties before the tests; the roots of the diagonal of (F + 1)⁻¹ are the remaining ones,
so 1 means no new information. A profile is safe if the hottest of many possible wires stays below the limit; otherwise
its duty cycle is reduced.

Source: Fedorov and Leonov (2013), Optimal Design for Nonlinear Response Models, chapter 3.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from martensite.actuators.assembly import AbstractSystem
from martensite.base.errors import InputError, SolveError
from martensite.boards.characterise.experiments import STEP, DutyCourse
from martensite.control.loop.bench import Bench
from martensite.search.starts import draw_points
from martensite.simulate.lanes import Lanes

OTHERS = 32
"""Number of possible wires in the search of the hottest."""
NUDGE = 0.05
"""Step of a parameter for its slope, over its width."""
REPEATS, DOUBT = 2, 0.01
"""Largest number of uses of a profile, and least noise of a reading over its range."""
FINITE = 0.75
"""Least fraction of the wires that the model can run."""
WEAKER, TRIES = 0.9, 20
"""Factor of the duty cycle of a profile that is too hot, and number of tries."""
Numbers = NDArray[np.float64]


@dataclass(frozen=True)
class UnknownNumber:
    """An unknown parameter of the wire."""

    path: str
    unit: str
    value: float
    """Value in the scenario [SI]."""
    width: float
    """Uncertainty of the value, one standard deviation [SI]."""


@dataclass(frozen=True, eq=False)
class ChosenCourses:
    """Chosen profiles with their expected information."""

    courses: tuple[DutyCourse, ...]
    hottest: float
    """Highest temperature of all possible wires, over all courses [K]."""
    remaining_uncertainty: Numbers
    """Remaining uncertainty of every parameter over its width."""


def choose_courses(
    bench: Bench, unknown: Sequence[UnknownNumber], candidates: Sequence[DutyCourse], *, limit: float, budget: float
) -> ChosenCourses:
    """Return the safe profiles with the most information within a time.

    Args:
        bench: plant and sensors.
        unknown: unknown parameters.
        candidates: profiles to choose from.
        limit: highest temperature of any possible wire [K].
        budget: time of all profiles [s].

    Raises:
        InputError: no profile fits into the time.
        SolveError: the model fails under all profiles.
    """
    safe = [pair for one in candidates if (pair := make_safe(bench.plant, unknown, one, limit)) is not None]
    if not safe:
        raise SolveError("The model fails under every course, or all are too hot: see the temperature limit.")
    information = {one.name: compute_information(bench, unknown, one) for one, _ in safe}
    chosen = _choose_greedily([one for one, _ in safe], information, budget)
    if not chosen:
        shortest = min(one.duration for one, _ in safe)
        raise InputError(f"No course fits into {budget:.4g} s; the shortest takes {shortest:.4g} s.")
    total = np.eye(len(unknown)) + sum(information[one.name] for one in chosen)
    hottest = max(hot for one, hot in safe if one in chosen)
    return ChosenCourses(tuple(chosen), hottest, np.sqrt(np.diag(np.linalg.inv(total))))


def _choose_greedily(
    courses: Sequence[DutyCourse], information: Mapping[str, Numbers], budget: float
) -> list[DutyCourse]:
    """Return the profiles with the largest gain of information over time, one by one."""
    total, chosen = np.eye(len(information[courses[0].name])), list[DutyCourse]()
    while fits := [one for one in courses if one.duration <= budget and chosen.count(one) < REPEATS]:
        before = np.linalg.slogdet(total)[1]
        gains = [(np.linalg.slogdet(total + information[one.name])[1] - before) / one.duration for one in fits]
        best = fits[int(np.argmax(gains))]
        total, budget = total + information[best.name], budget - best.duration
        chosen.append(best)
    return chosen


def make_safe(
    plant: AbstractSystem, unknown: Sequence[UnknownNumber], course: DutyCourse, limit: float
) -> tuple[DutyCourse, float] | None:
    """Return a profile with a duty cycle that is safe for all possible wires, and the hottest [K]; or None."""
    points = 2.0 * draw_points(len(unknown), OTHERS, 0) - 1.0
    values = {one.path: one.value + 2.0 * one.width * z for one, z in zip(unknown, points.T, strict=True)}
    for _ in range(TRIES):
        rows, names = _march_wires(plant, course, values, OTHERS)
        fine = np.isfinite(rows).all(axis=(0, 1))
        hottest = float(np.max(rows[:, names.index("hottest")][:, fine], initial=0.0))
        if fine.mean() >= FINITE and hottest <= limit:
            return course, hottest
        course = course.scaled(WEAKER)
    return None


def compute_information(bench: Bench, unknown: Sequence[UnknownNumber], course: DutyCourse) -> Numbers:
    """Return the information of a profile, in units of the widths; 0 where the model fails."""
    count = len(unknown)
    values = {one.path: np.full(2 * count, one.value) for one in unknown}
    for k, one in enumerate(unknown):
        values[one.path][2 * k] += NUDGE * one.width
        values[one.path][2 * k + 1] -= NUDGE * one.width
    rows, names = _march_wires(bench.plant, course, values, 2 * count)
    every = max(1, round(bench.period / STEP))
    information = np.zeros((count, count))
    for mounted in bench.sensors.members().values():
        (output, *_), sensor = mounted.sees(), mounted.sensor
        if output not in names:
            continue
        column = rows[::every, names.index(output)]
        noise = np.hypot(float(sensor.noise), float(sensor.resolution) / np.sqrt(12.0))
        noise = np.hypot(noise, float(getattr(sensor, "relative_noise", 0.0)) * float(np.mean(np.abs(column))))
        slopes = (column[:, ::2] - column[:, 1::2]) / (2.0 * NUDGE)
        noise = np.hypot(noise, DOUBT * float(np.ptp(np.mean(column, axis=1))))
        if noise > 0.0 and np.isfinite(slopes).all():
            information += slopes.T @ slopes / noise**2
    return information


def _march_wires(
    plant: AbstractSystem, course: DutyCourse, values: Mapping[str, Numbers], count: int
) -> tuple[Numbers, list[str]]:
    """Return the outputs of wires under a profile, (steps, outputs, wires), and their names."""
    lanes = Lanes(plant, count, values)
    lanes.reset(np.zeros((1, count)))
    duty = course.sample(STEP)
    return lanes.advance(np.broadcast_to(duty[:, None, None], (len(duty), 1, count)), STEP), list(lanes.names)
