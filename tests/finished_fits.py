"""Small fits to records made by the model itself: with a file, without one, with gaps, held out.

A wire under a dead weight is heated and cooled once. The scenarios begin with other numbers than
those that the records were made with.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from martensite.fit.experiment import Experiment
from martensite.fit.fit import Fit
from martensite.fit.problem import build_problem
from martensite.fit.solve import solve_problem
from martensite.logs.reader import read_table
from martensite.scenario.scenario import Scenario, read_scenario
from martensite.search.free_numbers import SearchRange
from martensite.signals.records import Record

TRUE = {"element.law.A_s": "62 degC", "element.law.C_A": "9 MPa/K", "element.law.eps_L": "0.037"}
FREE = ("A_s", "C_A", "eps_L")
NOISE = 2e-4
"""Standard deviation of the strain."""
LOADS = {"light": 0.6, "middle": 1.1, "heavy": 1.6, "kept": 1.3}
"""Record -> mass [kg]."""
LAW = 'law = { kind = "liang-rogers", modulus = "mixture" }\n'
TEXT = f"""
title = "A wire in a chamber"
[element]
kind = "wire"
material = "flexinol-90"
diameter = "0.381 mm"
length = "100 mm"
heat_capacity = "500 J/kg/K"
{LAW}[mechanism]
kind = "dead-weight"
mass = "1 kg"
[drive]
kind = "temperature"
waveform = {{ kind = "triangle", low = "20 degC", high = "140 degC", frequency = "0.0125 Hz" }}
[run]
duration = "80 s"
samples = 81
step = "1 s"
"""
Wishes = tuple[SearchRange | str, ...]


@dataclass(frozen=True)
class Sample:
    """A fit, and what it was made of."""

    fit: Fit
    scenario: Scenario
    folder: Path
    files: dict[str, Path]
    """Record -> its file, where it has one."""


def scenario(load: str = "light", **changes: Any) -> Scenario:
    """The scenario of a record."""
    return read_scenario(TEXT, None, {"mechanism.mass": f"{LOADS[load]} kg"} | changes)


def truth(load: str, noise: float = NOISE, zero: float = 0.0) -> dict[str, list[float]]:
    """Columns of a record, as a laboratory would have measured them."""
    result = scenario(load, **TRUE).run()
    seed = list(LOADS).index(load)
    error = np.random.default_rng(seed).normal(0.0, noise, len(result.times))
    return {
        "time": result.times.tolist(),
        "temperature": result["temperature"].tolist(),
        "strain": (np.asarray(result["strain"]) + error + zero).tolist(),
    }


def written(load: str, folder: Path, **how: Any) -> Record:
    """A record from a file."""
    columns, path = truth(load, **how), folder / f"{load} run.csv"
    rows = [",".join(map(repr, row)) for row in zip(*columns.values(), strict=True)]
    path.write_text("\n".join(["time [s],temperature [K],strain [1]", *rows]), encoding="utf-8")
    return read_table(path)


def made(load: str, gaps: slice = slice(0), **how: Any) -> Record:
    """A record without a file; rows in `gaps` miss their strain."""
    columns = truth(load, **how)
    strain = np.asarray(columns["strain"])
    strain[gaps] = math.nan
    units = {"time": "s", "temperature": "K", "strain": "1"}
    return Record(load, columns | {"strain": strain.tolist()}, units)


def experiment(load: str, record: Record, *held: tuple[float, float]) -> Experiment:
    """A record with its scenario."""
    one = scenario(load)
    return Experiment(load, one.system, one.waveform, record, {"strain": "strain"}, 1.0, held)


def sample(folder: Path, free: Wishes = FREE, each: Wishes = ("offset",), **how: Any) -> Sample:
    """Four records: from a file, from a file and with its end kept back, with gaps, kept back."""
    whole = (-math.inf, math.inf)
    light, middle = written("light", folder), written("middle", folder, zero=1e-3)
    heavy, kept = made("heavy", slice(10, 14)), written("kept", folder)
    experiments = (
        experiment("light", light),
        experiment("middle", middle, (70.0, 90.0)),
        experiment("heavy", heavy),
        experiment("kept", kept, whole),
    )
    fit = solve_problem(build_problem(experiments, free, each=each), **how)
    files = {one.name: one.record.source for one in experiments if one.record.source}
    return Sample(fit, scenario(), folder, files)


def poor_sample(folder: Path) -> Sample:
    """One with a parameter on its bound, one without effect, and one for every record."""
    free = (SearchRange("A_s", 330.0, 333.0, 332.0), "C_A", "eps_L", "heat_capacity")
    return sample(folder, free, ("offset", SearchRange("E_A", 4e10, 1.2e11)))
