"""Synthetic records of the calibration test, and their fit problems.

A record is the angle of the finger with the values of Table 1, 201 samples over one period of a slow sine of power,
with white noise of 1°. It is simulated in steps of 10 ms and fitted in steps of 1/9 s, three between two samples, which
changes angles by 0.005° (RMS): so fit and record have different discretisation.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache, partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from martensite.base.errors import SolveError
from martensite.fit.evaluation import Evaluation
from martensite.fit.experiment import Experiment
from martensite.fit.problem import Problem, build_problem
from martensite.search.free_numbers import SearchRange
from martensite.signals.records import Record
from martensite.studies.readings import load_once
from martensite.studies.tables import Printed

if TYPE_CHECKING:
    from martensite.actuators.assembly import AbstractSystem

SCENARIO = Path(__file__).with_name("scenario.toml")
load_scenario = partial(load_once, SCENARIO)
SAMPLES = 201
NOISE = math.radians(1.0)
"""Standard deviation of an angle [rad]."""
SEED = 0
STEP, FINE = 1.0 / 9.0, 0.01
"""Steps of a fit, and of the synthetic measurement [s]."""


@dataclass(frozen=True)
class Data:
    """Records of one fit."""

    key: str
    name: str
    arm: float
    """Place a of the spring [m]."""
    count: int
    """Number of records, one for each of the first distances r."""
    first: int
    """Noise row of the first record."""


NEAR = Data("8mm", "a = 8 mm", 8e-3, 1, 0)
FAR = Data("16mm", "a = 16 mm", 16e-3, 1, 1)
JOINT = Data("joint", "a = 16 mm, three r", 16e-3, 3, 2)
EVERY = (NEAR, FAR, JOINT)


def build_finger(arm: float, offset: float, values: tuple[tuple[str, float], ...] = ()) -> AbstractSystem:
    """Return the finger of Table 1 with changed parameters."""
    places = {"mechanism.arm": arm, "mechanism.offset": offset}
    return load_scenario().system.with_values(places | dict(values))


@cache
def draw_noise() -> Any:
    """Return white noise of unit deviation (records, samples), the same in all runs."""
    records = sum(data.count for data in EVERY)
    return np.random.default_rng(SEED).standard_normal((records, SAMPLES))


@cache
def clean_angle(arm: float, offset: float, printed: Printed, values: tuple[tuple[str, float], ...] = ()) -> Any:
    """Return the noise-free angle with the values of Table 1, optionally changed (samples,) [rad]."""
    blank = np.linspace(0.0, 1.0, SAMPLES)
    experiment = _build_experiment("clean", build_finger(arm, offset, values), blank, printed)
    fine = build_problem((experiment,), ["stiffness"], step=FINE)  # not really free
    evaluation = fine.evaluate(fine.start)
    if evaluation is None:
        raise SolveError("The run with Table 1 fails.")
    return evaluation.fitted_records[0].model[:, 0]


def build_experiments(
    data: Data,
    printed: Printed,
    *,
    noisy: bool = True,
    arm: float | None = None,
    values: tuple[tuple[str, float], ...] = (),
) -> tuple[Experiment, ...]:
    """Return the records of a set with the fitted finger.

    Args:
        data: the set.
        printed: the paper's numbers.
        noisy: whether to add noise.
        arm: place of the spring in the fit, if different [m].
        values: other changed parameters in the fit.
    """
    experiments: list[Experiment] = []
    for k, offset in enumerate(printed.offsets[: data.count]):
        angles = clean_angle(data.arm, offset, printed)
        if noisy:
            angles = angles + NOISE * draw_noise()[data.first + k]
        system = build_finger(arm or data.arm, offset, values)
        experiments.append(_build_experiment(f"r = {1e3 * offset:.1f} mm", system, angles, printed))
    return tuple(experiments)


def _build_experiment(name: str, system: AbstractSystem, angles: Any, printed: Printed) -> Experiment:
    times = np.linspace(0.0, 1.0 / printed.frequency, SAMPLES)
    columns = {"time": times.tolist(), "angle": angles.tolist()}
    record = Record(name, columns, {"time": "s", "angle": "rad"})
    wave = load_scenario().waveform
    return Experiment(name, system, wave, record, {"angle": "angle"}, step=STEP)


def build_calibration(records: Sequence[Experiment], printed: Printed, start: Sequence[float]) -> Problem:
    """Return the search of the paper: its five parameters within its ranges."""
    wishes = [
        SearchRange(one.name, one.low, one.high, begin) for one, begin in zip(printed.searched, start, strict=True)
    ]
    return build_problem(records, wishes, noise={"angle": NOISE})


@cache
def table_problem(data: Data, printed: Printed) -> Problem:
    """Return the search on a set of records, starting from Table 1."""
    return build_calibration(build_experiments(data, printed), printed, printed.searched.column("value"))


@cache
def at_table(data: Data, printed: Printed) -> Evaluation:
    """Return the residuals of a set of records with Table 1, and their derivatives."""
    begin = table_problem(data, printed)
    evaluation = begin.evaluate(begin.start, slopes=True)
    if evaluation is None:
        raise SolveError(f"The runs of {data.name} with Table 1 fail.")
    return evaluation
