"""Numbers of the fits: the paper's two stages, other excitation, models with hysteresis."""

from __future__ import annotations

from typing import Any

from martensite.studies.hammerstein_wiener.comparisons import (
    VARIANTS,
    compare_elsewhere,
    compare_position,
    in_series,
    rest_position,
    score_sealed,
)

PAPER, BETTER, WHOLE = "stage 2", "stage 2, hysteresis", "whole"
KEYS = {PAPER: "paper", BETTER: "hysteresis", WHOLE: "whole"}
"""Keys of models in claims."""
SEALED = (101, 102, 103, 104, 105)
"""Seeds of records that were used for no choice."""
FEW = ("fan", "5 K warmer", "load +20 %")
"""Other benches of the short study."""


def compute_fit(*, full: bool) -> dict[str, Any]:
    """Return all open-loop numbers."""
    seeds = SEALED if full else SEALED[:2]
    return {
        "stage_1": compare_position("stage 1", "validation"),
        "stage_2": compare_position(PAPER, "validation"),
        "series": in_series(PAPER, "validation"),
        "slow_cooling_error": in_series(PAPER, "slow").worst_cooling * 1e3,
        "stage_2_slow": compare_position(PAPER, "slow").fit,
        "series_slow": in_series(PAPER, "slow").fit,
        "stage_1_slow": compare_position("stage 1", "slow").fit,
        "better": compare_position(BETTER, "validation"),
        "hysteresis_slow": compare_position(BETTER, "slow").fit,
        "hysteresis_series": in_series(BETTER, "validation").fit,
        "whole_fit": compare_position(WHOLE, "validation").fit,
        "whole_slow": compare_position(WHOLE, "slow").fit,
        "rest_hysteresis": rest_position("series " + BETTER),
        "rest_whole": rest_position(WHOLE),
        "sealed": [_list_sealed(name, seeds) for name in KEYS],
        "elsewhere": [_list_elsewhere(name) for name in (VARIANTS if full else FEW)],
    }


def _list_sealed(name: str, seeds: tuple[int, ...]) -> dict[str, Any]:
    middle, least = score_sealed(name, seeds)
    shared = {"key": KEYS[name], "name": name, "count": len(seeds)}
    return shared | {"median": middle, "least": least}


def _list_elsewhere(variant: str) -> dict[str, Any]:
    key = variant.replace(" ", "-").replace("%", "percent")
    fits = {"fit": WHOLE, "better": BETTER, "paper": PAPER}
    scores = {name: compare_elsewhere(model, variant).fit for name, model in fits.items()}
    return {"key": key, "variant": variant} | scores
