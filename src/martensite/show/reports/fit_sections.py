"""The content of the report of a fit: warnings first, then the numbers, then what they rest on."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Sequence
from typing import TYPE_CHECKING, Any

from martensite.fit.fit import Fit
from martensite.fit.fit_provenance import cautions_of
from martensite.fit.fit_rows import compared
from martensite.fit.fit_verdicts import amount, predictions, warnings
from martensite.fit.task import LogFit
from martensite.scenario.law_match import KIND, law_words
from martensite.search.profile import Profile
from martensite.search.words import joined, number
from martensite.show.figures.fit import MOST as PANELS
from martensite.show.figures.fit import has_loops, plot_fit, plot_fit_loops
from martensite.show.figures.fit_knowledge import (
    plot_correlation,
    plot_search,
    plot_singular_values,
)
from martensite.show.figures.fit_likelihood import plot_likelihood
from martensite.show.figures.fit_residuals import MOST as RESIDUALS
from martensite.show.figures.fit_residuals import plot_fit_residuals
from martensite.show.reports import fit_tables
from martensite.show.reports.blocks import (
    Block,
    Bullets,
    Folded,
    Notice,
    Picture,
    Section,
    Text,
)

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from martensite.scenario.scenario import Scenario

MANY = 4
"""Records up to which a title names them one by one."""


def title_of(fit: Fit) -> str:
    """A headline from the law and the records."""
    names = [one.name for one in fit.problem.experiments]
    which = joined(names) if len(names) <= MANY else f"{len(names)} records"
    return f"Fit of {_law(fit)[KIND]} to {which}"


def lead_of(fit: Fit) -> str:
    """What was fitted to how much, in one line."""
    rows = compared(fit)
    seen, kept = (sum(int(flags.sum()) for flags in column)
                  for column in ([r.used for r in rows], [r.held for r in rows]))  # fmt: skip
    return (
        f"{len(fit.problem.free)} parameters fitted to {seen} measured values; {kept} more kept "
        f"back. Ended: {fit.reason}."
    )


def sections(fit: Fit, scenario: Scenario | None, profiles: Sequence[Profile]) -> list[Block]:
    """All blocks of the report, in order."""
    return [
        *_first(fit),
        *_result(fit),
        *_agreement(fit),
        *_problem(fit, scenario),
        *_knowledge(fit, profiles),
        *_residuals(fit),
        *_search(fit),
    ]


def pictures(fit: Fit, profiles: Sequence[Profile]) -> dict[str, tuple[Draw, str]]:
    """Name of each figure that there is -> how to draw it, and its caption."""
    rows = len(compared(fit))
    found: dict[str, tuple[Draw, str]] = {
        "measured": (
            plot_fit,
            f"Measured and modelled, over time. What was kept back is tinted.{_some(rows, PANELS)}",
        ),
    }
    if has_loops(fit):
        found["loops"] = (plot_fit_loops, f"The same as loops.{_some(rows, PANELS)}")
    found["directions"] = (
        plot_singular_values,
        "Left: singular values of the Jacobian per search range, in units of the noise. Right: "
        "what moves in the least certain direction.",
    )
    if len(fit.problem.free) > 1:
        found["correlations"] = (
            plot_correlation,
            "Correlations of the parameters; hatched where the data do not determine one.",
        )
    if profiles:
        found["likelihoods"] = (
            lambda fit: plot_likelihood(profiles, fit),
            "How the cost rises if one parameter is held elsewhere and all others follow; shaded: "
            "the interval.",
        )
    found["residuals"] = (
        plot_fit_residuals,
        "Left: modelled less measured. Right: autocorrelation of what was fitted; white residuals "
        f"stay within the grey band.{_some(rows, RESIDUALS)}",
    )
    if len(fit.history) > 1:
        found["search"] = (plot_search, "The least cost over the runs of the search.")
    return found


def _some(count: int, most: int) -> str:
    """That a figure leaves some records out, if it does."""
    return f" {most} of {count} are drawn." if count > most else ""


Draw = Callable[[Fit], "Figure"]


def _draw(fit: Fit, name: str, profiles: Sequence[Profile] = ()) -> Iterator[Block]:
    """A figure, if there is one of that name."""
    known = pictures(fit, profiles)
    if name in known:
        draw, caption = known[name]
        yield Picture(name, draw(fit), caption)


def _first(fit: Fit) -> Iterator[Block]:
    """What must be known before a number is used."""
    found = [*warnings(fit), *cautions_of(fit)]
    if found:
        items = _printed([*predictions(fit), *found])
        yield Notice("Read this first", items, warning=True)
    else:
        title = "Nothing speaks against these numbers"
        yield Notice(title, _printed(predictions(fit)), warning=False)


def _result(fit: Fit) -> Iterator[Block]:
    yield Section("Parameters")
    yield fit_tables.parameters(fit)
    own = fit_tables.own_numbers(fit)
    if own is not None:
        yield own
    yield Folded("All digits, in SI", fit_tables.in_full(fit))


def _agreement(fit: Fit) -> Iterator[Block]:
    yield Section("Measured and modelled")
    yield fit_tables.errors(fit)
    yield from _draw(fit, "measured")
    yield from _draw(fit, "loops")


def _problem(fit: Fit, scenario: Scenario | None) -> Iterator[Block]:
    yield Section("What was fitted")
    yield Bullets(list(_facts(fit, scenario)))
    yield fit_tables.records(fit)


def _facts(fit: Fit, scenario: Scenario | None) -> Iterator[str]:
    """Scenario, material, law, and what residuals are measured by."""
    if scenario is not None:
        file = f" (`{scenario.path.name}`)" if scenario.path else ""
        yield f"Scenario: {scenario.title}{file}."
        if scenario.material is not None:
            yield f"Numbers that are not fitted: material `{scenario.material.name}`, or scenario."
    yield f"System: {fit.system().described()}."
    law = _law(fit)
    options = joined([f"`{name} = {word}`" for name, word in law.items() if name != KIND])
    yield f"Law: `{law[KIND]}`{f' with {options}' if options else ''}."
    for output in dict.fromkeys(one.output for one in compared(fit)):
        known = output in fit.problem.noise
        unit = fit.system().outputs()[output].unit
        size = amount(output, fit.problem.scale(output), unit, 4)
        what = "its known noise" if known else "the range over which it was measured"
        yield f"Residuals of `{output}` are divided by {what}, {size}."
    yield f"Loss: {fit.loss}."
    yield from fit.notes if isinstance(fit, LogFit) else ()


def _knowledge(fit: Fit, profiles: Sequence[Profile]) -> Iterator[Block]:
    yield Section("What the data cannot tell")
    found = [*fit.identifiability.sentences, *fit.uncertainty.sentences]
    yield Bullets(_printed(list(dict.fromkeys(found))))
    yield from _draw(fit, "directions")
    yield from _draw(fit, "correlations")
    if profiles:
        yield Bullets(_printed([one.sentence for one in profiles]))
        yield from _draw(fit, "likelihoods", profiles)


def _residuals(fit: Fit) -> Iterator[Block]:
    yield Section("Residuals")
    if fit.whiteness:
        yield Bullets([one.sentence for one in fit.whiteness])
    else:
        yield Text("Too few rows for a test of whiteness.")
    yield from _draw(fit, "residuals")


def _search(fit: Fit) -> Iterator[Block]:
    yield Section("Search")
    yield Text(
        f"Method `{fit.method}`, ended: {fit.reason}. {fit.simulations} runs of single records and "
        f"{fit.jacobians} with derivatives in all directions, {number(fit.seconds, 3)} s. Cost "
        f"(mean squared residual) {number(fit.cost, 4)}."
    )
    yield from _draw(fit, "search")


def _printed(sentences: Sequence[str]) -> list[str]:
    """Sentences with degrees as they are printed."""
    return [re.sub(r"(?<= )degC\b", "°C", one) for one in sentences]


def _law(fit: Fit) -> dict[str, Any]:
    actuators = fit.system().actuators()
    return law_words(next(iter(actuators.values())).element.law)
