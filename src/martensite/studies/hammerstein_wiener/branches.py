"""Measured branches of the hysteresis of the bench.

`branches.csv` holds fractions of transformation over temperature, on heating and on cooling, at 50 and at 100 MPa. They
are derived from isobaric cycles of a Flexinol wire (Leal 2016; MIT licence, Copyright (c) 2016 Mecanon), so that the
study runs without those files.

Derivation: z = 1 - ε/ε_max; each branch on a grid of 0.1 K, constant beyond its ends, smoothed with a Gaussian of 1.2
K, made monotone and scaled to 0 to 1; then sampled at each whole degree. Elastic and thermal strain are included.
"""

from __future__ import annotations

import csv
from functools import cache
from pathlib import Path
from typing import NamedTuple

import numpy as np
from scipy.interpolate import PchipInterpolator
from scipy.ndimage import gaussian_filter1d

from martensite.control.sensors.base import Numbers
from martensite.studies.readings import ZERO

FILE = Path(__file__).parent / "branches.csv"
GRID = ZERO + 0.1 * np.arange(1801)
"""0 to 180 °C in steps of 0.1 K [K]."""
SMOOTHING = 12.0
"""Standard deviation, in steps of the grid."""
STRESSES = (50, 100)
"""Stresses of the branches [MPa]."""
STROKES = (0.041256, 0.043500)
"""Strain range at these stresses."""
SHOWN = slice(200, 1451, 10)
"""Rows of the grid in the file: 20 to 145 °C."""
COLUMNS = ("temperature", "heating 50 MPa", "cooling 50 MPa", "heating 100 MPa", "cooling 100 MPa")
HEADER = """\
# Fractions of transformation (1 = austenite) of a Flexinol wire of 0.381 mm at constant stress.
# Source: P. Leal, morphing_wing (2016), https://github.com/Mecanon/morphing_wing, commit
# 28d027de4bca755d22345071b8d5abafff1c8778, experimental/sma_database/final_third_training.
# Licence of the source: MIT, Copyright (c) 2016 Mecanon.
# Derived: 1 - strain/largest strain per branch, smoothed (Gaussian, 1.2 K), monotone, scaled to
# 0 to 1; see branches.py beside this file. Temperatures in degC.
"""


class HysteresisLoop(NamedTuple):
    """Branches at one stress, on `GRID`."""

    heating: Numbers
    cooling: Numbers
    stroke: float
    """Strain of the whole transformation."""


@cache
def build_loop(share: float) -> HysteresisLoop:
    """Return branches between 50 MPa (share 0) and 100 MPa (share 1).

    Temperatures at equal fractions are mixed linearly, as stress shifts branches in temperature.
    """
    curves = _read_branches()
    heating, cooling = (_mix_branches(curves[a], curves[b], share) for a, b in ((0, 2), (1, 3)))
    stroke = (1.0 - share) * STROKES[0] + share * STROKES[1]
    return HysteresisLoop(heating, cooling, stroke)


def invert_branch(branch: Numbers, fractions: Numbers) -> Numbers:
    """Return the temperatures [K] of a branch at fractions."""
    rising = np.concatenate([[True], np.diff(branch) > 1e-12])
    return np.interp(fractions, branch[rising], GRID[rising])


def _mix_branches(low: Numbers, high: Numbers, share: float) -> Numbers:
    if share == 0.0:
        return low
    levels = np.unique(np.concatenate([low, high]))
    moved = (1.0 - share) * invert_branch(low, levels) + share * invert_branch(high, levels)
    return np.interp(GRID, moved, levels)


def _read_branches() -> list[Numbers]:
    with FILE.open(encoding="utf-8", newline="") as lines:
        rows = list(csv.reader(line for line in lines if not line.startswith("#")))
    table = np.array(rows[1:], dtype=float)
    kelvin = np.concatenate([[GRID[0]], table[:, 0] + ZERO, [GRID[-1]]])
    ends = [np.concatenate([[0.0], column, [1.0]]) for column in table[:, 1:].T]
    return [np.clip(PchipInterpolator(kelvin, column)(GRID), 0.0, 1.0) for column in ends]


def derive_text() -> str:
    """Return the text of `branches.csv`, from the measurements."""
    from martensite.characterise.isobaric_cycles import cut_cycle
    from martensite.logs.reader import read_table

    columns = [GRID[SHOWN] - ZERO]
    for stress in STRESSES:
        cycle = cut_cycle(read_table(f"data:flexinol-isobaric/isobaric_{stress}MPa.txt"))
        longest = max(*cycle.heating.strain, *cycle.cooling.strain)
        for leg in (cycle.heating, cycle.cooling):
            columns.append(_derive_branch(np.array(leg.temperature), np.array(leg.strain) / longest)[SHOWN])
    rows = [",".join([f"{row[0]:.0f}", *(f"{z:.6f}" for z in row[1:])]) for row in np.array(columns).T.tolist()]
    return HEADER + "\n".join([",".join(COLUMNS), *rows, ""])


def _derive_branch(kelvin: Numbers, share: Numbers) -> Numbers:
    order = np.argsort(kelvin, kind="stable")
    raw = np.interp(GRID, kelvin[order], 1.0 - share[order])
    smooth = gaussian_filter1d(raw, SMOOTHING, mode="nearest")
    above = np.maximum.accumulate(smooth)
    below = np.minimum.accumulate(smooth[::-1])[::-1]
    middle = 0.5 * (above + below)
    return (middle - middle[0]) / (middle[-1] - middle[0])
