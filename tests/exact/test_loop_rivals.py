"""Predictions of loops without a model.

Source of truth: loops that shift in proportion to their load, which averages of neighbours repeat exactly; and minor
loops that are scaled pieces of the major loop.
"""

from __future__ import annotations

import numpy as np
import pytest

from martensite.fit.loop_rivals import LoopColumns, average_neighbours, find_branches, has_reversals, repeat_branches
from martensite.search.rivals import FAILS, PREDICTS, RIVALLED, Prediction

WAY = np.linspace(0.0, 1.0, 400)


def make_loop(load: float) -> LoopColumns:
    """Heat from 20 to 120 and cool; strips shift by 10 K, and the strain grows, from load 0 to 1."""
    up, down = 20.0 + 100.0 * WAY, 120.0 - 100.0 * WAY
    low = 60.0 + 10.0 * load
    strain = np.concatenate([1.0 - np.clip((x - a) / 15.0, 0.0, 1.0) for x, a in ((up, low), (down, low - 20.0))])
    return LoopColumns(np.concatenate([up, down]), (4.0 + load) * strain, load)


def test_neighbours_repeat_a_loop_between_them() -> None:
    middle = make_loop(0.4)
    found = average_neighbours(middle, [make_loop(0.0), make_loop(1.0)])
    assert float(np.sqrt(np.mean((found - middle.column) ** 2))) < 0.05
    nearest = repeat_branches(middle, find_branches(make_loop(0.0)))
    assert float(np.sqrt(np.mean((nearest - middle.column) ** 2))) > 0.3


def test_highest_load_is_extrapolated_and_one_load_gives_no_average() -> None:
    top = make_loop(1.0)
    found = average_neighbours(top, [make_loop(0.0), make_loop(0.5)])
    assert float(np.sqrt(np.mean((found - top.column) ** 2))) < 0.06
    assert average_neighbours(top, [make_loop(0.5)]) is None


def test_descent_after_a_reversal_is_the_scaled_major_descent() -> None:
    """Heated to the middle of the strip only, then cooled: half of the descent of the major loop."""
    major = make_loop(0.0)
    drive = np.concatenate([major.drive, 20.0 + 47.5 * WAY, 67.5 - 47.5 * WAY])
    loop = LoopColumns(drive, np.concatenate([major.column, np.full(800, np.nan)]))
    assert has_reversals(loop)
    assert not has_reversals(major)
    found = repeat_branches(loop, find_branches(loop))
    assert found[1199] == pytest.approx(2.0, abs=0.05)
    assert found[-1] == pytest.approx(4.0, abs=0.05)
    half = np.interp(47.5, (drive[1200:])[::-1], found[1200:][::-1])
    assert half == pytest.approx(3.0, abs=0.1)


@pytest.mark.parametrize(
    ("rms", "rival", "verdict"),
    [
        (0.05, 0.1, PREDICTS),
        (0.09, 0.1, RIVALLED),
        (0.09, 0.01, RIVALLED),
        (0.2, 0.3, PREDICTS),
        (0.22, 0.1, FAILS),
        (0.3, 1.0, FAILS),
    ],
)
def test_one_rule_of_prediction(rms: float, rival: float, verdict: str) -> None:
    """Better than 0.8 of every rival and 75 % explained; usable from 80 % on although a rival is as good."""
    found = Prediction(rms, 1.0, {"mean": 1.0, "neighbours": rival})
    assert found.verdict == verdict and found.predicts == (verdict == PREDICTS)
