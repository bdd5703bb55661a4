"""A fit in print and as JSON: parameters, errors, and what the data cannot tell."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from martensite.fit.posterior import Posterior
    from martensite.fit.task import LogFit
    from martensite.search.free_numbers import FreeNumber
    from martensite.search.profile import Profile
    from martensite.search.scores import Score

PARAMETERS = ("parameter", "value", "95 % interval", "start", "bounds", "")
WIDE = 1.1
"""Widening of intervals from which on it is told."""
WORST = 1000.0
"""Fit [%] below whose negative it is not told any more."""
SCORES = ("record", "output", "", "RMS", "fit", "largest", "bias")


@dataclass(frozen=True)
class Shown:
    """A finished fit, and what was found and written beside it."""

    fit: LogFit
    profiles: Sequence[Profile]
    posterior: Posterior | None
    written: Sequence[Path]

    def show(self) -> None:
        """Print it."""
        from martensite.cli import show

        _print_fit(self.fit)
        for note in self.fit.notes:
            show.text(f"Note: {note}")
        for profile in self.profiles:
            show.text(profile.sentence)
        if self.posterior is not None:
            _print_posterior(self.fit, self.posterior)
        for warning in warnings(self.fit):
            show.text(f"Warning: {warning}", "yellow")
        show.text(
            f"{self.fit.reason}; {self.fit.simulations} runs, {self.fit.jacobians} with "
            f"derivatives, {self.fit.seconds:.3g} s"
        )
        for path in self.written:
            show.text(f"wrote {path}")

    def as_dict(self) -> dict[str, Any]:
        """It, ready for JSON; numbers in SI."""
        return _as_dict(self.fit) | {
            "profiles": [profile.to_dict() for profile in self.profiles],
            "posterior": None if self.posterior is None else _posterior(self.posterior),
            "notes": list(self.fit.notes),
            "warnings": warnings(self.fit),
            "files": [str(path) for path in self.written],
        }


def _print_fit(fit: LogFit) -> None:
    from martensite.cli import show

    if fit.scenario is not None:
        show.text(fit.scenario.title, "bold")
    marks = {"not determined": "yellow", "weak": "yellow", "at a bound": "yellow"}
    show.table(PARAMETERS, _parameters(fit), right="value,95 % interval,start", colours={"": marks})
    show.table(SCORES, _scores(fit), right="RMS,fit,largest,bias")
    if fit.identifiability.determined:
        show.text(*fit.identifiability.sentences)
    if fit.uncertainty.widening > WIDE:
        show.text(fit.uncertainty.sentences[-1])
    white = sum(one.white for one in fit.whiteness)
    show.text(f"Residuals are white in {white} of {len(fit.whiteness)} comparisons.")


def _print_posterior(fit: LogFit, posterior: Posterior) -> None:
    from martensite.cli import show

    rows = [(free.name, _range(free, *posterior.interval(free.name))) for free in fit.problem.free]
    show.table(("parameter", "95 % of the draws"), rows, right="95 % of the draws")
    show.text(posterior.sentence, "" if posterior.settled else "yellow")


def _posterior(found: Posterior) -> dict[str, Any]:
    return {
        "intervals": {name: list(found.interval(name)) for name in found.samples},
        "r_hat": found.r_hat,
        "effective": found.effective,
        "divergences": found.divergences,
        "sentence": found.sentence,
    }


def _as_dict(fit: LogFit) -> dict[str, Any]:
    return {
        "parameters": {free.name: _parameter(fit, free) for free in fit.problem.free},
        "cost": fit.cost,
        "reason": fit.reason,
        "method": fit.method,
        "loss": fit.loss,
        "simulations": fit.simulations,
        "jacobians": fit.jacobians,
        "seconds": fit.seconds,
        "scores": [score.to_dict() for score in fit.scores],
        "held_out": {
            one.name: [[_end(end) for end in pair] for pair in one.held]
            for one in (*fit.problem.experiments, *(kept.experiment for kept in fit.kept))
            if one.held
        },
        "uncertainty": fit.uncertainty.to_dict(),
        "identifiability": fit.identifiability.to_dict(),
        "whiteness": [one.to_dict() for one in fit.whiteness],
    }


def warnings(fit: LogFit) -> list[str]:
    """What a reader must know before the numbers are used."""
    from martensite.fit.fit_verdicts import warnings as verdicts

    weak = list(dict.fromkeys(name for one in fit.identifiability.weak for name in one.names))
    found = [*fit.cautions, *verdicts(fit)]
    if weak:
        listed = ", ".join(f"`{name}`" for name in weak)
        found.append(
            f"The fitted values of {listed} rest on a direction that the data do not determine; "
            "use them together only, near what was measured."
        )
    return found


def _end(end: float) -> float | None:
    return end if math.isfinite(end) else None


def _parameter(fit: LogFit, free: FreeNumber) -> dict[str, Any]:
    low, high = fit.uncertainty.widened(free.name)
    return {
        "value": fit[free.name], "unit": free.unit, "low": _end(low), "high": _end(high),
        "start": free.start, "bounds": [free.low, free.high], "meaning": free.doc,
        "at_bound": free.name in fit.at_bound(),
    }  # fmt: skip


def _parameters(fit: LogFit) -> Iterator[tuple[str, ...]]:
    for free in fit.problem.free:
        low, high = fit.uncertainty.widened(free.name)
        known = math.isfinite(low) and math.isfinite(high)
        interval = _range(free, low, high) if known else "none"
        bounds = _range(free, free.low, free.high)
        value, start = _value(free, fit[free.name]), _value(free, free.start)
        yield free.name, value, interval, start, bounds, _mark(fit, free.name, known)


def _mark(fit: LogFit, name: str, known: bool) -> str:
    if not known:
        return "not determined"
    if name in fit.at_bound():
        return "at a bound"
    return "weak" if any(name in one.names for one in fit.identifiability.weak) else ""


def _shown(free: FreeNumber) -> tuple[float, float, str]:
    """Factor and offset to SI, and name, of the unit in which a parameter is read."""
    from martensite.base import units
    from martensite.fit.free_parameters import is_nuisance
    from martensite.search.words import difference

    if is_nuisance(free.path):
        factor, spelling = difference(free.unit)
        return factor, 0.0, spelling
    spelling = units.choose_readable_unit(free.unit)
    return (*units.find_conversion(spelling, free.unit), spelling)


def _value(free: FreeNumber, value: float) -> str:
    factor, offset, spelling = _shown(free)
    number = f"{(value - offset) / factor:.5g}"
    return number if spelling == "1" else f"{number} {spelling}"


def _range(free: FreeNumber, low: float, high: float) -> str:
    factor, offset, _ = _shown(free)
    return f"{(low - offset) / factor:.5g} to {_value(free, high)}"


def _scores(fit: LogFit) -> Iterator[tuple[str, ...]]:
    """Those of the training first."""
    for part in ("training", "held-out"):
        for score in fit.scores:
            if score.part == part:
                yield _score(score)


def _score(found: Score) -> tuple[str, ...]:
    from martensite.cli import show

    sizes = [show.difference(x, found.unit) for x in (found.rms, found.maximum, found.bias)]
    fit = f"{found.fit_percent:.1f} %" if found.fit_percent > -WORST else f"< -{WORST:.0f} %"
    if math.isnan(found.fit_percent):
        fit = ""
    return found.record, found.output, found.part, sizes[0], fit, sizes[1], sizes[2]
