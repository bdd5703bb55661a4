"""Logs of rigs drawn at random, fitted without a scenario: the unseen cadence, and what is said of it.

Source of truth: the simulated rig itself (`benchmarks.driven_rigs`), every fifth outside of the models that are tried.
Seeds 0 to 19 were used to choose thresholds, 100 to 119 were kept apart.
"""

from __future__ import annotations

import numpy as np
import pytest
from benchmarks.driven_rigs import draw_rig

from martensite.fit.drive_lag import fit_drive_lag
from martensite.fit.log_models import model_logs
from martensite.search.rivals import BETTER, EXPLAINED


def judge_rig(seed: int, records: int = 3) -> tuple[float, bool]:
    """Fit [%] of the unseen cadence, and whether the verdict is right about it."""
    rig = draw_rig(seed, records)
    model = model_logs(rig.records)
    (predicted,) = model.predict_record(rig.unseen).values()
    measured = np.asarray(rig.unseen[rig.column])
    lag = fit_drive_lag(rig.records, rig.drive, rig.column, refined=2).predict(rig.unseen, rig.drive)
    error, naive = (float(np.sqrt(np.mean((one - measured) ** 2))) for one in (predicted, lag))
    explained = 1.0 - error / float(np.std(measured))
    truth = explained >= EXPLAINED and error < BETTER * naive
    return 100.0 * explained, model.predicts == truth


def test_unseen_cadence_of_a_rig_is_predicted() -> None:
    fit, right = judge_rig(17, records=2)
    assert fit > 90.0
    assert right


@pytest.mark.slow
def test_rigs_kept_apart_are_predicted_and_judged() -> None:
    found = [judge_rig(seed) for seed in range(100, 120)]
    assert float(np.median([fit for fit, _ in found])) >= 90.0
    assert sum(right for _, right in found) >= 18
