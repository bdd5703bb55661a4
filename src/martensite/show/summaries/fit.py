"""A fit: prediction errors, parameters, errors by log, warnings, identifiability and search."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterator, Sequence
from typing import TYPE_CHECKING, Any

from martensite.base import units
from martensite.base.formats import typeset_unit
from martensite.base.summary import Block, BulletList, DataTable, Heading, Notice, Picture, Sentence, Summary
from martensite.fit.baselines import score_baselines
from martensite.fit.fit import Fit, list_compared, list_held_out
from martensite.fit.fit_verdicts import describe_predictions, format_error, list_fit_warnings
from martensite.fit.posterior import Posterior
from martensite.scenario.laws import KIND, law_words
from martensite.search.free_numbers import FreeNumber
from martensite.search.profile import Profile
from martensite.search.quantity_text import format_number, join_phrases, list_names
from martensite.show.figures.fit import MOST as PANELS
from martensite.show.figures.fit import MOST_RESIDUALS as RESIDUALS
from martensite.show.figures.fit import has_loops, plot_fit, plot_fit_loops, plot_fit_residuals
from martensite.show.figures.fit_knowledge import plot_correlation, plot_likelihood, plot_search, plot_singular_values
from martensite.show.summaries import fit_tables

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from martensite.scenario.scenario import Scenario

MANY = 4
"""Largest number of records named in a title."""


def summarise_fit(
    fit: Fit,
    scenario: Scenario | None = None,
    profiles: Sequence[Profile] = (),
    title: str = "",
    posterior: Posterior | None = None,
) -> Summary:
    """Return the summary of a fit."""
    blocks = [
        _describe_verdict(fit),
        *_describe_parameters(fit),
        *_describe_agreement(fit),
        *_list_warnings(fit),
        *_describe_problem(fit, scenario or fit.scenario),
        *_describe_knowledge(fit, profiles, posterior),
        *_describe_residuals(fit),
        *_describe_search(fit),
    ]
    data = _collect_numbers(fit) | {
        "profiles": [profile.to_dict() for profile in profiles],
        "posterior": None if posterior is None else _collect_posterior(posterior),
    }
    return Summary(title or _make_title(fit), blocks, data, _make_lead(fit))


def _make_title(fit: Fit) -> str:
    names = [one.name for one in fit.problem.experiments]
    which = join_phrases(names) if len(names) <= MANY else f"{len(names)} records"
    return f"Fit of {_find_law(fit)[KIND]} to {which}"


def _make_lead(fit: Fit) -> str:
    rows = list_compared(fit)
    fitted = sum(int(row.training_rows.sum()) for row in rows)
    held_out_count = sum(int(row.held_out_rows.sum()) for row in rows)
    count = len(collect_warnings(fit))
    warned = f" {count} {'warning' if count == 1 else 'warnings'} below." if count else " No warnings."
    ended = fit.reason[:1].upper() + fit.reason[1:]
    return f"{ended}: {len(fit.problem.free)} parameters, {fitted} fitted and {held_out_count} held-out values.{warned}"


def _list_pictures(fit: Fit, profiles: Sequence[Profile]) -> dict[str, tuple[DrawFit, str]]:
    rows = len(list_compared(fit))
    table: dict[str, tuple[DrawFit, str]] = {
        "measured": (
            plot_fit,
            "Measured and modelled over time. Held-out rows are tinted." + _count_panels(rows, PANELS),
        )
    }
    if has_loops(fit):
        table["loops"] = (plot_fit_loops, f"Measured and modelled loops.{_count_panels(rows, PANELS)}")
    table["directions"] = (
        plot_singular_values,
        "Left: singular values of the Jacobian per search range, in units of the noise. Right: "
        "parameters of the least certain direction.",
    )
    if len(fit.problem.free) > 1:
        table["correlations"] = (
            plot_correlation,
            "Correlations of the parameters; hatched where the data do not determine one.",
        )
    if profiles:
        table["likelihoods"] = (
            lambda fit: plot_likelihood(profiles, fit),
            "Cost over one parameter, with all other parameters optimised; shaded: the interval.",
        )
    table["residuals"] = (
        plot_fit_residuals,
        "Left: modelled minus measured. Right: autocorrelation of the fitted residuals; white residuals "
        f"stay within the grey band.{_count_panels(rows, RESIDUALS)}",
    )
    if len(fit.history) > 1:
        table["search"] = (plot_search, "Lowest cost over the runs of the search.")
    return table


def _count_panels(count: int, most: int) -> str:
    return f" {most} of {count} are drawn." if count > most else ""


DrawFit = Callable[[Fit], "Figure"]


def _show_picture(fit: Fit, name: str, profiles: Sequence[Profile] = ()) -> Iterator[Block]:
    pictures = _list_pictures(fit, profiles)
    if name in pictures:
        draw, caption = pictures[name]
        yield Picture(name, lambda: draw(fit), caption)


def _describe_verdict(fit: Fit) -> Block:
    return Notice("Prediction", _typeset_sentences(describe_predictions(fit)), warning=False)


def _list_warnings(fit: Fit) -> Iterator[Block]:
    if sentences := collect_warnings(fit):
        yield Notice("Warning", _typeset_sentences(sentences), warning=True)


def collect_warnings(fit: Fit) -> list[str]:
    """Return the warnings for users of the values."""
    weak = list(dict.fromkeys(name for one in fit.identifiability.weak for name in one.names))
    warnings = list(dict.fromkeys([*fit.cautions, *list_fit_warnings(fit)]))
    if weak:
        warnings.append(
            f"The data determine only a combination of {list_names(weak)}. Use these values together, near the "
            "measured conditions."
        )
    return warnings


def _describe_parameters(fit: Fit) -> Iterator[Block]:
    yield Heading("Parameters")
    yield fit_tables.tabulate_parameters(fit)
    own = fit_tables.tabulate_own_numbers(fit)
    if own is not None:
        yield own
    yield fit_tables.tabulate_all_digits(fit)


def _describe_agreement(fit: Fit) -> Iterator[Block]:
    yield Heading("Errors by log")
    yield fit_tables.tabulate_errors(fit)
    yield from _show_picture(fit, "measured")
    yield from _show_picture(fit, "loops")
    if fit.notes:
        yield BulletList([f"Note: {one}" for one in fit.notes])


def _describe_problem(fit: Fit, scenario: Scenario | None) -> Iterator[Block]:
    yield Heading("Problem", detail=True)
    yield BulletList(list(_list_facts(fit, scenario)))
    yield fit_tables.tabulate_records(fit)


def _list_facts(fit: Fit, scenario: Scenario | None) -> Iterator[str]:
    if scenario is not None:
        file = f" (`{scenario.path.name}`)" if scenario.path else ""
        yield f"Scenario: {scenario.title}{file}."
        if scenario.material is not None:
            yield f"Parameters that are not fitted: material `{scenario.material.name}`, or scenario."
    yield f"System: {fit.system().description()}."
    law = _find_law(fit)
    options = join_phrases([f"`{name} = {word}`" for name, word in law.items() if name != KIND])
    yield f"Law: `{law[KIND]}`{f' with {options}' if options else ''}."
    for output, unit in dict.fromkeys((one.output, one.description.unit) for one in list_compared(fit)):
        declared = output in fit.problem.noise
        size = format_error(output, fit.problem.scale(output), unit, 4)
        what = "its declared noise" if declared else "its measured range"
        yield f"Residuals of `{output}` are divided by {what}, {size}."
    yield f"Loss: {fit.loss}."


def _describe_knowledge(fit: Fit, profiles: Sequence[Profile], posterior: Posterior | None) -> Iterator[Block]:
    yield Heading("Identifiability")
    entries = [*fit.identifiability.sentences, *fit.uncertainty.sentences]
    yield BulletList(_typeset_sentences(list(dict.fromkeys(entries))))
    yield from _show_picture(fit, "directions")
    yield from _show_picture(fit, "correlations")
    if profiles:
        yield BulletList(_typeset_sentences([one.sentence for one in profiles]))
        yield from _show_picture(fit, "likelihoods", profiles)
    if posterior is not None:
        rows = [(free.name, _write_draws(free, posterior)) for free in fit.problem.free]
        yield DataTable(("parameter", "95 % interval of samples"), rows, right=(1,))
        yield Sentence(posterior.sentence, "" if posterior.converged else "caution")


def _write_draws(free: FreeNumber, posterior: Posterior) -> str:
    low, high = posterior.interval(free.name)
    spelling = fit_tables.choose_parameter_unit(free, high)
    low, high = (units.from_si(end, spelling, free.unit) for end in (low, high))
    return f"{low:.5g} to {high:.5g} {typeset_unit(spelling)}".rstrip()


def _describe_residuals(fit: Fit) -> Iterator[Block]:
    yield Heading("Residuals")
    if fit.whiteness:
        white = sum(one.white for one in fit.whiteness)
        yield Sentence(f"Residuals are white in {white} of {len(fit.whiteness)} comparisons.")
        yield BulletList([one.sentence for one in fit.whiteness], detail=True)
    else:
        yield Sentence("There are too few rows for a test of whiteness.")
    yield from _show_picture(fit, "residuals")


def _describe_search(fit: Fit) -> Iterator[Block]:
    yield Heading("Search")
    yield Sentence(
        f"Method `{fit.method}`: {fit.reason} after {fit.simulations} runs ({fit.jacobians} with derivatives) in "
        f"{format_number(fit.seconds, 3)} s. Cost (mean squared residual): {format_number(fit.cost, 4)}."
    )
    yield from _show_picture(fit, "search")


def _typeset_sentences(sentences: Sequence[str]) -> list[str]:
    return [re.sub(r"(?<= )degC\b", "°C", one) for one in sentences]


def _find_law(fit: Fit) -> dict[str, Any]:
    actuators = fit.system().actuators()
    return law_words(next(iter(actuators.values())).element.law)


def _collect_numbers(fit: Fit) -> dict[str, Any]:
    held_out = [one.experiment for one in fit.held_out_records]
    return {
        "parameters": {free.name: _collect_parameter(fit, free) for free in fit.problem.free},
        "cost": fit.cost,
        "reason": fit.reason,
        "method": fit.method,
        "loss": fit.loss,
        "simulations": fit.simulations,
        "jacobians": fit.jacobians,
        "seconds": fit.seconds,
        "scores": [score.to_dict() for score in fit.scores],
        "baselines": [score.to_dict() for score in score_baselines(fit)],
        "transfer": [
            score.to_dict() for held_out in fit.transfer for one in list_held_out(held_out) for score in one.score()
        ],
        "held_out": {
            one.name: [[_write_end(end) for end in pair] for pair in one.held_out_intervals]
            for one in (*fit.problem.experiments, *held_out)
            if one.held_out_intervals
        },
        "uncertainty": fit.uncertainty.to_dict(),
        "identifiability": fit.identifiability.to_dict(),
        "whiteness": [one.to_dict() for one in fit.whiteness],
        "notes": list(fit.notes),
        "warnings": collect_warnings(fit),
    }


def _write_end(end: float) -> float | None:
    return end if math.isfinite(end) else None


def _collect_parameter(fit: Fit, free: FreeNumber) -> dict[str, Any]:
    low, high = fit.uncertainty.widen_interval(free.name)
    return {
        "value": fit[free.name],
        "unit": free.unit,
        "low": _write_end(low),
        "high": _write_end(high),
        "start": free.start,
        "bounds": [free.low, free.high],
        "meaning": free.doc,
        "at_bound": free.name in fit.at_bound(),
    }


def _collect_posterior(posterior: Posterior) -> dict[str, Any]:
    return {
        "intervals": {name: list(posterior.interval(name)) for name in posterior.samples},
        "autocorrelation_times": posterior.times,
        "effective": posterior.effective,
        "converged": posterior.converged,
        "sentence": posterior.sentence,
    }
