"""Tables of conditions made of runs whose numbers are known: coils of SMA against a spring."""

from __future__ import annotations

import random
from collections.abc import Iterable, Mapping, Sequence
from itertools import product
from typing import Any

import numpy as np

from martensite.scenario.scenario import Scenario, read_scenario
from martensite.simulate.measures.base import parse_measure
from martensite.simulate.measures.run_table import tabulate_samples

COIL = """
title = "Coil against a spring"
[element]
kind = "coil-spring"
material = "flexinol-90"
law = { kind = "liang-rogers", modulus = "mixture", transformation = "stress" }
diameter = "0.5 mm"
coil_diameter = "3.5 mm"
coil_measure = "mean"
turns = 15
free_length = "12 mm"
[environment]
temperature = "22 degC"
cooling = { kind = "constant", h = "60 W/m^2/K" }
[mechanism]
kind = "bias-spring"
stiffness = "20 N/m"
preload = "0.6 N"
[drive]
kind = "current"
waveform = { kind = "step", high = "2.6 A", at = "0 s", until = "5 s" }
[run]
duration = "6 s"
tolerance = 1e-3
"""
TRUTH = {"element.law.A_s": "66 degC", "element.law.A_f": "80 degC"}
HEADINGS = ("peak stroke [mm]", "force rise [N]", "time to 90 % [s]")
MEASURES = {"stroke": 1e3, "change(force)": 1.0, "reach-time": 1.0}
"""Measure -> factor from SI to what its heading says."""


def make_coil(**settings: Any) -> Scenario:
    """The coil with other numbers, by dotted path with `__` for a dot."""
    return read_scenario(COIL, None, {name.replace("__", "."): value for name, value in settings.items()})


def measure_run(settings: Mapping[str, Any]) -> list[float]:
    """What the headings say of one run of a closely stepped coil."""
    result = read_scenario(COIL, None, dict(settings)).run(tolerance=1e-5)
    times, found = np.array(result.times), list[float]()
    for words, factor in MEASURES.items():
        one = parse_measure(words)
        column = np.array(result["force" if one.of else "position"])
        found.append(factor * float(one.value(tabulate_samples(times, column[None, :, None]))[0]))
    return found


def write_rows(
    specimens: Mapping[str, Mapping[str, Any]],
    currents: Sequence[float],
    truth: Mapping[str, Any] = TRUTH,
    *,
    columns: Iterable[str] = (),
    noise: float = 0.0,
    repeats: int = 1,
    seed: int = 1,
) -> list[str]:
    """Lines of a table: specimens with numbers of their own, of which `columns` are written down."""
    chance, written = random.Random(seed), list(columns)
    lines = [",".join(["specimen", *written, "current [A]", *HEADINGS])]
    for (name, own), current in product(specimens.items(), currents):
        settings = {**truth, **own, "drive.waveform.high": f"{current} A"}
        numbers = measure_run(settings)
        for _ in range(repeats):
            shaken = (f"{x * (1.0 + noise * chance.gauss(0.0, 1.0)):.5g}" for x in numbers)
            lines.append(",".join([name, *(str(own[one]) for one in written), str(current), *shaken]))
    return lines
