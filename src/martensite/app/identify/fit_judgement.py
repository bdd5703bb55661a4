"""The verdict on a fit: headline, reasons, determined parameters, next recordings.

Good, usable and not usable follow from the sentences of `martensite.fit.fit_verdicts`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from martensite.app.messages import JsonTable
from martensite.base.errors import DataError, MartensiteError
from martensite.fit.experiment_kinds.base import Proposal, recognise_experiment
from martensite.fit.fit import Fit
from martensite.fit.fit_verdicts import (
    describe_predictions,
    warn_of_baselines,
    warn_of_directions,
    warn_of_misses,
    warn_of_predictions,
    warn_of_rivals,
    warn_of_search,
)
from martensite.fit.free_parameters import is_nuisance
from martensite.fit.log_models import LogModel
from martensite.fit.log_trials import TriedModel
from martensite.search.quantity_text import format_quantity
from martensite.show.summaries.fit_tables import mark_parameter
from martensite.show.summaries.log_model import list_next_records


@dataclass(frozen=True)
class FitJudgement:
    """Reasons to reject a fit, or to use it with care."""

    against: list[str]
    care: list[str]

    @property
    def word(self) -> str:
        """Return good, usable, or not usable."""
        return "not usable" if self.against else "usable" if self.care else "good"


def judge_fit(fit: Fit) -> FitJudgement:
    """Return the warnings of a fit, sorted by their consequence."""
    against = [*warn_of_baselines(fit), *warn_of_misses(fit)]
    care = [*warn_of_rivals(fit), *warn_of_search(fit), *warn_of_predictions(fit), *warn_of_directions(fit)]
    return FitJudgement(against, care)


def describe_judgement(fit: Fit, proposal: Proposal | None) -> JsonTable:
    """Return the verdict for the page."""
    judgement = judge_fit(fit)
    marks = {free.name: mark_parameter(fit, free.name) for free in fit.problem.free if not is_nuisance(free.path)}
    return {
        "word": judgement.word,
        "headline": _write_headline(fit, judgement),
        "reasons": [*judgement.against, *judgement.care],
        "told": [_describe_number(fit, name) for name, mark in marks.items() if not mark],
        "untold": [f"`{name}`: {mark}" for name, mark in marks.items() if mark],
        "next": _list_next(fit, proposal),
    }


def _write_headline(fit: Fit, judgement: FitJudgement) -> str:
    error = describe_predictions(fit)[0]
    if judgement.word == "good":
        return f"Good: the model predicts held-out data, and the logs determine all free parameters. {error}"
    more = len(judgement.against) + len(judgement.care) - 1
    rest = f" ({more} more below)" if more else ""
    word = "Not usable" if judgement.against else "Usable with care"
    return f"{word}. {[*judgement.against, *judgement.care][0]}{rest}"


def _describe_number(fit: Fit, name: str) -> str:
    free = next(one for one in fit.problem.free if one.name == name)
    low, high = fit.uncertainty.widen_interval(name)
    within = f" ({format_quantity(low, free.unit)} to {format_quantity(high, free.unit)})"
    return f"`{name}` = {format_quantity(fit[name], free.unit)}{within if math.isfinite(high - low) else ''}"


class JudgedModel(LogModel):
    """A fit of the page as a model of its logs."""

    @property
    def predicts(self) -> bool:
        """Return whether no reason rejects it."""
        return judge_fit(self.fit).word != "not usable"


def _list_next(fit: Fit, proposal: Proposal | None) -> list[str]:
    """Return suggestions for further records; empty for an unknown experiment."""
    records = [one.record for one in fit.problem.experiments]
    named = proposal or Proposal(fit.scenario.title if fit.scenario else "", {}, (), (), records)
    try:
        experiment = recognise_experiment(records)
        return list_next_records(JudgedModel(experiment, TriedModel(named, fit, ()), (), ()))
    except (DataError, MartensiteError):
        return []
