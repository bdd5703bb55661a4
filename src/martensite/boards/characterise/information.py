"""Choice of excitation profiles by their information for a fit, before the wire is heated.

    F = Σ_courses Σ_t J(t)ᵀ J(t)/σ²,      J: slopes of the readings with the free numbers, in units of their widths

Courses are chosen one by one, by the largest gain of ln det(F + 1) over their time, until the time is used (D-optimal,
greedy). A course is used at most twice, since models are inexact and a repetition gives less information than they
predict. For the same reason the noise σ of a reading is at least 1 % of its range. Widths are the uncertainties before
the tests, so 1 means no new information. The roots of the diagonal of (F + 1)⁻¹ are the remaining uncertainties.

A course is safe if the hottest of many possible wires stays below the limit; otherwise its duty is reduced.

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
"""Wires among which the hottest is sought."""
NUDGE = 0.05
"""Change of a free number for its slope, as a share of its width."""
REPEATS, DOUBT = 2, 0.01
"""Largest number of uses of a course, and smallest noise of a reading, as a fraction of its range."""
FINITE = 0.75
"""Share of the wires that the model must be able to run; numbers far apart may contradict each other."""
WEAKER, TRIES = 0.9, 20
"""A course that is too hot is tried with so much of its duty, so often."""
Numbers = NDArray[np.float64]


@dataclass(frozen=True)
class UnknownNumber:
    """A number of the wire that is to be learnt."""

    path: str
    """In the plant."""
    unit: str
    value: float
    """Value in the scenario [SI]."""
    width: float
    """Uncertainty of the value, one standard deviation [SI]."""


@dataclass(frozen=True, eq=False)
class ChosenCourses:
    """Courses, and what they will tell."""

    courses: tuple[DutyCourse, ...]
    hottest: float
    """Highest temperature of all possible wires, over all courses [K]."""
    left: Numbers
    """Remaining uncertainty of every parameter, as a fraction of its width."""


def choose_courses(
    bench: Bench, unknown: Sequence[UnknownNumber], candidates: Sequence[DutyCourse], *, limit: float, budget: float
) -> ChosenCourses:
    """Return the safe courses that tell most within a time.

    Args:
        bench: plant and sensors.
        unknown: what is to be learnt.
        candidates: courses to choose among.
        limit: temperature [K] that no wire passes.
        budget: time for all courses [s].

    Raises:
        InputError: no course fits into the time.
        SolveError: the model fails under all of them.
    """
    safe = [found for one in candidates if (found := make_safe(bench.plant, unknown, one, limit)) is not None]
    if not safe:
        raise SolveError("The model fails under every course, or all are too hot: see the temperature limit.")
    told = {one.name: compute_information(bench, unknown, one) for one, _ in safe}
    total, chosen, left = np.eye(len(unknown)), list[tuple[DutyCourse, float]](), budget
    while True:
        taken = [one.name for one, _ in chosen]
        fits = [(one, hot) for one, hot in safe if one.duration <= left and taken.count(one.name) < REPEATS]
        if not fits:
            break
        before = np.linalg.slogdet(total)[1]
        gains = [(np.linalg.slogdet(total + told[one.name])[1] - before) / one.duration for one, _ in fits]
        best, hot = fits[int(np.argmax(gains))]
        total, left = total + told[best.name], left - best.duration
        chosen.append((best, hot))
    if not chosen:
        shortest = min(one.duration for one, _ in safe)
        raise InputError(f"No course fits into {budget:.4g} s; the shortest takes {shortest:.4g} s.")
    spread = np.sqrt(np.diag(np.linalg.inv(total)))
    return ChosenCourses(tuple(one for one, _ in chosen), max(hot for _, hot in chosen), spread)


def make_safe(
    plant: AbstractSystem, unknown: Sequence[UnknownNumber], course: DutyCourse, limit: float
) -> tuple[DutyCourse, float] | None:
    """Return a course with as much of its duty as no wire that may be at hand gets too hot by, and the hottest [K]."""
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
    """Return the information of a course on all numbers, in units of their widths; 0 where the model fails."""
    count = len(unknown)
    values = {one.path: np.full(2 * count, one.value) for one in unknown}
    for k, one in enumerate(unknown):
        values[one.path][2 * k] += NUDGE * one.width
        values[one.path][2 * k + 1] -= NUDGE * one.width
    rows, names = _march_wires(bench.plant, course, values, 2 * count)
    every = max(1, round(bench.period / STEP))
    found = np.zeros((count, count))
    for mounted in bench.sensors.members().values():
        (seen, *_), sensor = mounted.sees(), mounted.sensor
        if seen not in names:
            continue
        column = rows[::every, names.index(seen)]
        noise = np.hypot(float(sensor.noise), float(sensor.resolution) / np.sqrt(12.0))
        noise = np.hypot(noise, float(getattr(sensor, "relative_noise", 0.0)) * float(np.mean(np.abs(column))))
        slopes = (column[:, ::2] - column[:, 1::2]) / (2.0 * NUDGE)
        noise = np.hypot(noise, DOUBT * float(np.ptp(np.mean(column, axis=1))))
        if noise > 0.0 and np.isfinite(slopes).all():
            found += slopes.T @ slopes / noise**2
    return found


def _march_wires(
    plant: AbstractSystem, course: DutyCourse, values: Mapping[str, Numbers], count: int
) -> tuple[Numbers, list[str]]:
    """Return the outputs of wires under a course, (steps, outputs, wires), and their names."""
    lanes = Lanes(plant, count, values)
    lanes.reset(np.zeros((1, count)))
    duty = course.sample(STEP)
    return lanes.advance(np.broadcast_to(duty[:, None, None], (len(duty), 1, count)), STEP), list(lanes.names)
