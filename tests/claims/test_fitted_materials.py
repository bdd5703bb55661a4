"""Shipped materials that were fitted to measured cycles: what they predict, and the fit again."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from martensite.fit.api import fit_logs
from martensite.kernels.compiler import find_compiler
from martensite.logs import datasets
from martensite.logs.reader import read_table
from martensite.physics.materials.base import load_material
from martensite.scenario.scenario import read_scenario

EXAMPLES = Path(__file__).parents[2] / "examples"
SCENARIO = """
[element]
kind = "wire"
material = "{material}"
diameter = "0.381 mm"
length = "100 mm"
initial_fraction = 0.0

[mechanism]
kind = "testing-machine"
control = "stress"
section = "0.1140092 mm^2"

[signals.command]
kind = "constant"
level = "{stress} MPa"

[drive]
kind = "temperature"
waveform = {{ kind = "log", from = "367 degC" }}

[run]
lead = "60 s"
"""
FLEXINOL, NITIHF = "flexinol-trained-0.381mm", "nitihf-bigelow2022"
HELD_OUT = 0.0015
"""Largest error of strain of a cycle that the fit did not see."""
AIM = 3e-4
"""Largest error over all levels of NiTiHf."""


def record(data: str, stress: int) -> str:
    """A measured cycle; the test is skipped without it."""
    name = f"{data}/isobaric_{stress}MPa.txt"
    if not datasets.is_here(name):
        pytest.skip(f"the measured data {data} are not on this machine (martensite data fetch)")
    return f"data:{name}"


def errors(material: str, data: str, stress: int) -> np.ndarray:
    """Predicted less measured strain [-] at the rows of a cycle."""
    log = read_table(record(data, stress), interval=1.0)
    scenario = read_scenario(SCENARIO.format(material=material, stress=stress), log=log)
    run = scenario.run(runtime="c" if find_compiler() else "floats")
    return np.interp(np.array(log.times) + 60.0, run.times, run["strain"]) - np.array(log["strain"])


def rms(numbers: np.ndarray) -> float:
    return float(np.sqrt(np.mean(numbers**2)))


@pytest.mark.parametrize("stress", [50, 100, 172, 200])
def test_every_cycle_of_flexinol_is_predicted(stress: int) -> None:
    found = errors(FLEXINOL, "flexinol-isobaric", stress)
    assert rms(found) < HELD_OUT
    assert rms(found - found.mean()) < 6e-4


def test_the_cycles_of_nitihf_are_repeated() -> None:
    squares = [rms(errors(NITIHF, "nitihf-isobaric", stress)) ** 2 for stress in (7, 50, 100, 300, 400)]
    assert math.sqrt(sum(squares) / len(squares)) < AIM


def test_materials_say_with_which_law_they_hold() -> None:
    waisted = {"kind": "lagoudas", "hardening": "waisted"}
    assert load_material(FLEXINOL).law == waisted
    assert load_material(NITIHF).law == waisted | {"surfaces": "curved"}


@pytest.mark.slow
def test_the_fit_gives_the_shipped_numbers_again(c_compiler: str) -> None:
    record("flexinol-isobaric", 172)
    found = fit_logs(EXAMPLES / "fit_flexinol_trained.toml")
    shipped = load_material(FLEXINOL).values
    for name in ("A_s", "A_f", "M_s", "M_f"):
        assert found[name] == pytest.approx(shipped[name].value, abs=0.5), name
    for name in ("C_A", "C_M", "H_min", "H_sat", "n_2", "n_4", "waist_f", "waist_r"):
        assert found[name] == pytest.approx(shipped[name].value, rel=2e-2), name
    held = [one for one in found.scores if one.part == "held-out"]
    assert [one.record for one in held] == ["172 MPa"]
    assert held[0].rms < HELD_OUT
