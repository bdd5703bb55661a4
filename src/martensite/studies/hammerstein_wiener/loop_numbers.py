"""Numbers of the closed loop: gains tuned on a model, applied to model and bench."""

from __future__ import annotations

from typing import Any

import numpy as np

from martensite.studies.hammerstein_wiener import loops
from martensite.studies.hammerstein_wiener.bench import INTERVAL
from martensite.studies.hammerstein_wiener.fit_numbers import BETTER, KEYS, WHOLE
from martensite.studies.hammerstein_wiener.loop import LEVELS

SMALL, LOOSE = "stage 2, 12 wavelets", "stage 2, not anchored"
BEGIN = LEVELS[0][1]
"""Time of the first step [s]."""


def compute_loop(*, full: bool) -> dict[str, Any]:
    """Return the steps and sine; in full also other models, including one without a steady state."""
    both, sine = loops.compare_steps(WHOLE), loops.compare_sines(WHOLE)
    pairs, (heating, cooling) = both.responses(), sine.branches
    return {
        "whole_likeness": both.likeness,
        "steps": [
            {
                "k": k,
                "model": model,
                "bench": bench,
                "overshoot": 100.0 * bench.overshoot,
                "model_overshoot": 100.0 * model.overshoot,
            }
            for k, (model, bench) in enumerate(pairs, start=1)
        ],
        "whole_steady": abs(pairs[-1][1].error),
        "sine": sine,
        "heated_microns": 1e6 * sine.apart_heated,
        "unheated_microns": 1e6 * sine.apart_unheated,
        "sine_heating": heating,
        "sine_cooling": cooling,
        "slower": [{"percent": first_step_share()}] if full else [],
        "traps": [compute_trap()] if full else [],
        "others": [_list_other(name) for name in (SMALL, BETTER)] if full else [],
    }


def first_step_share() -> float:
    """Return the bench position [%] when the model of the paper's structure has risen to 90 %."""
    both = loops.compare_steps(SMALL)
    (model, _), *_ = both.responses()
    done = round((BEGIN + model.rise) / INTERVAL)
    share = both.bench.output[done] / model.after
    return 100.0 * share


def compute_trap() -> dict[str, float]:
    """Return a model without a steady state, and the bench under gains tuned on it."""
    still = loops.build_controlled(LOOSE).chain.simulate(np.zeros((1, 1)))[0, -1]
    both = loops.compare_steps(LOOSE)
    return {"rest": float(still), "way": float(np.ptp(both.bench.output)), "likeness": both.likeness}


def _list_other(name: str) -> dict[str, Any]:
    likeness, apart = loops.compare_steps(name).likeness, loops.compare_sines(name).apart
    return {"key": KEYS.get(name, "paper"), "name": name, "likeness": likeness, "apart": apart}
