"""A table of cycles decides between exponential drift, the logarithm of the cycles, and both.

Source of truth: the closed form ε = ε_hot + (σ/σ_r)(ε_∞ w + ε_d d) with known numbers, and noise of known size.
"""

from __future__ import annotations

import math
import random
import re
from pathlib import Path

import numpy as np
import pytest

from martensite.fit.api import fit_logs
from martensite.fit.fit import Fit
from martensite.scenario.scenario import read_scenario

WIRE = """
[element]
kind = "wire"
material = "flexinol-90"
law = { kind = "liang-rogers", modulus = "mixture" }
diameter = "0.2 mm"
length = "200 mm"
[element.wear]
settling_cycles = 100
residual_strain = "0.5 %"
residual_strain_per_decade = "0.1 %"
reference_stress = "150 MPa"
[mechanism]
kind = "dead-weight"
mass = "480 g"
[drive]
kind = "temperature"
waveform = { kind = "triangle", low = "20 degC", high = "130 degC", frequency = "0.01 Hz" }
[run]
duration = "100 s"
step = "1 s"
"""
CYCLES = (0, 3, 6, 10, 20, 30, 60, 100, 200, 300, 500, 700, 1000, 1500, 2000, 3000)
NAMES = ("settling_cycles", "residual_strain", "residual_strain_per_decade")
NOISE = 5e-5
TRUTHS = {"exponential": (40.0, 0.008, 0.0), "logarithm": (10.0, 0.0, 0.002), "both": (20.0, 0.005, 0.0015)}


def grow(cycles: float, numbers: tuple[float, ...]) -> float:
    settling, end, decade = numbers
    return end * (1.0 - math.exp(-cycles / settling)) + decade * math.log10(1.0 + cycles / settling)


def fit_table(path: Path, truth: tuple[float, ...], seed: int) -> Fit:
    """Return the fit to a table of the truth."""
    new = read_scenario(WIRE, None, {f"element.wear.{name}": 0 for name in NAMES[1:]}).run()
    load, hot, chance = new["stress"][0] / 150e6, min(new["strain"]), random.Random(seed)
    rows = [f"{n},{100.0 * (hot + load * grow(n + 0.5, truth) + chance.gauss(0.0, NOISE)):.5f}" for n in CYCLES]
    path.write_text("\n".join(["cycles,min strain [%]", *rows]))
    return fit_logs(
        read_scenario(WIRE),
        str(path),
        "settling_cycles=2..500,residual_strain,residual_strain_per_decade",
        hold_out="none",
    )


@pytest.mark.parametrize("law", TRUTHS)
def test_the_data_decide(law: str, tmp_path: Path) -> None:
    truth = TRUTHS[law]
    fit = fit_table(tmp_path / "cycles.csv", truth, seed=1)
    assert f"Drift law: {law}." in fit.notes[-1]
    assert all(re.search(rf" {name} [\d.e-]+ ", fit.notes[-1]) for name in TRUTHS)
    found = {name: fit.numbers.get(name, 0.0) for name in NAMES}
    for name, true in zip(NAMES, truth, strict=True):
        low, high = fit.uncertainty.widen_interval(name, 0.99) if name in fit.numbers else (0.0, 0.0)
        assert low <= true <= high
    # ten times more cycles than measured, within the interval of the prediction
    values = tuple(found.values())
    steps = {name: 1e-4 * found[name] for name in fit.problem.names}
    slopes = [
        (grow(3e4, tuple((found | {name: found[name] + step}).values())) - grow(3e4, values)) / step
        for name, step in steps.items()
    ]
    assert abs(grow(3e4, values) - grow(3e4, truth)) <= fit.uncertainty.half_width(np.array(slopes))
