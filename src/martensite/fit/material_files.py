"""Material files from fits: parameters, their uncertainty, and their sources.

Table `[law]` has the law and its options. `[sources]` has the fit and the sources of fixed parameters. `[values]` has
all parameters, fitted ones with intervals and bounds. `[fit]` has the search, the free parameters, and the records
with hashes and errors.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

from martensite.base.errors import DataError
from martensite.base.files import write_file
from martensite.base.toml_text import toml_key, toml_value
from martensite.fit.fit import find_covered_range, list_compared
from martensite.fit.fit_provenance import PACKAGE, build_provenance, describe_program, list_published
from martensite.fit.fit_verdicts import describe_predictions, list_fit_warnings
from martensite.fit.material_numbers import FIT, MaterialNumbers
from martensite.physics.materials.base import MaterialNumber, Source
from martensite.scenario.citations import list_entries
from martensite.scenario.exact_text import format_quantity, shown_range
from martensite.search.quantity_text import join_phrases

if TYPE_CHECKING:
    from martensite.fit.fit import Fit
    from martensite.scenario.scenario import Scenario

MANY_RECORDS = 5
"""Largest number of records that are listed by name."""


def write_material(
    fit: Fit,
    path: str | Path,
    *,
    scenario: Scenario | None = None,
    title: str = "",
    cite: str = "",
    port: str | None = None,
    digits: int | None = None,
) -> None:
    """Write a material file with the parameters of a fit, replacing an existing file.

    The name of the material is the name of the file. A scenario uses `material = "./mine.toml"`; `load_material` reads
    the file.

    Args:
        fit: finished fit.
        path: path of the file, ending in .toml. Its folder must exist.
        scenario: scenario at the start of the fit, if the fit does not have it. It gives the sources of fixed
            parameters; without it they are labelled as assumed.
        title: title of the material, by default from law and records.
        cite: bibliography key of the records, by default the key of a published data set, or of this package.
        port: actuator with the parameters, required only if several differ.
        digits: significant digits of fitted parameters, by default all.

    Raises:
        InputError: the path does not end in .toml, the file cannot be written, or the actuators of the fitted system
            have different parameters.
    """
    path = Path(path)
    if path.suffix.lower() != ".toml":
        raise DataError(f"A material file ends in .toml, but this is `{path}`.")
    numbers = MaterialNumbers(fit, scenario or fit.scenario, port, digits)
    text = format_material(numbers, title, cite)
    write_file(path, text)


def format_material(numbers: MaterialNumbers, title: str = "", cite: str = "") -> str:
    """Return the text of a material file; arguments as in `write_material`."""
    fit = numbers.fit
    key = cite or next(iter(list_published(fit)), PACKAGE)
    list_entries([key])
    values = numbers.values()
    law = numbers.law_table()
    what = f"law {law['kind']} to {_format_outputs(fit)} of {_format_records(fit)}"
    sources = {FIT: Source(key, f"Fit by {describe_program()}: {what}"), **numbers.sources}
    provenance: dict[str, Any] = build_provenance(fit)
    if numbers.scenario:
        provenance = {"scenario": numbers.scenario.title, **provenance}
    free, records = provenance.pop("free"), provenance.pop("records")
    return "\n".join(
        [
            *_format_entries({"title": title or f"Fit of {what}"}),
            *_format_entries({"summary": _summarise_fit(numbers, values), "limits": _describe_limits(numbers)}),
            *_format_section("law", law),
            *_list_sources(sources),
            *_format_section("values", {name: _format_value(number) for name, number in values.items()}),
            *_format_section("fit", provenance),
            *_format_section("fit.free", free),
            *(line for one in records for line in _format_section("fit.records", one, "[[{}]]")),
            "",
        ]
    )


# ---------------------------------------------------------------- words


def _format_records(fit: Fit) -> str:
    names = [one.name for one in fit.problem.experiments]
    return join_phrases(names) if len(names) <= MANY_RECORDS else f"{len(names)} records"


def _format_outputs(fit: Fit) -> str:
    return join_phrases(list(dict.fromkeys(n for one in fit.problem.experiments for n in one.outputs)))


def _summarise_fit(numbers: MaterialNumbers, values: dict[str, MaterialNumber]) -> str:
    fit, law = numbers.fit, numbers.law_table()
    fitted = [name for name, number in values.items() if number.kind == "fitted" and number.source == FIT]
    options = join_phrases([f"{name} {word}" for name, word in law.items() if name != "kind"])
    words = [
        f"Numbers of law {law['kind']}{f' ({options})' if options else ''}, fitted to "
        f"{_format_outputs(fit)} of {_format_records(fit)}.",
        f"Fitted: {join_phrases(fitted) or 'none of them'}.",
    ]
    if numbers.material:
        words.append(f"Where another source is named, the number is that of {numbers.material.name}.")
    if others := numbers.others():
        phrase = join_phrases([f"{free.name} = {format_quantity(fit[free.name], free.unit)}" for free in others])
        words.append(f"Fitted with them, but no numbers of a material: {phrase}.")
    return " ".join(words)


def _describe_limits(numbers: MaterialNumbers) -> str:
    fit = numbers.fit
    units = {"temperature": "K", "stress": "Pa"}
    ranges = [f"{name} {shown_range(r, units[name])}" for name, r in find_covered_range(fit).items()]
    held_out_names = [one.record for one in list_compared(fit) if not one.training_rows.any()]
    words = [f"They hold for this law, and were fitted at {join_phrases(ranges)}."]
    if held_out_names:
        words.append(f"Kept back: {join_phrases(list(dict.fromkeys(held_out_names)))}.")
    return " ".join([*words, *describe_predictions(fit), *list_fit_warnings(fit), *fit.cautions]).replace("`", "")


# ---------------------------------------------------------------- TOML


def _format_entries(table: dict[str, Any]) -> Iterator[str]:
    yield from (f"{toml_key(key)} = {toml_value(value)}" for key, value in table.items())


def _format_section(name: str, table: dict[str, Any], heading: str = "[{}]") -> Iterator[str]:
    yield from ("", heading.format(name))
    yield from _format_entries(table)


def _list_sources(sources: dict[str, Source]) -> Iterator[str]:
    for key, source in sources.items():
        yield from _format_section(f"sources.{toml_key(key)}", {"cite": source.cite, "text": source.text})


def _format_value(number: MaterialNumber) -> dict[str, str]:
    entries = {
        "value": number.text,
        "kind": number.kind,
        "source": number.source,
        "where": number.where,
        "note": number.note,
    }
    return {key: text for key, text in entries.items() if text}
