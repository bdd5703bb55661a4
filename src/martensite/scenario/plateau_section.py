"""Section `[element.law.plateaus]`: stresses of a superelastic test in place of transformation temperatures."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, TypeVar

from martensite.base import units
from martensite.base.errors import ParameterError
from martensite.characterise.plateaus import TEMPERATURES, Plateaus, convert_plateaus
from martensite.scenario.build import Table, as_table, name_section
from martensite.scenario.exact_text import exact_text
from martensite.search.quantity_text import list_names

KEY = "plateaus"
STRESSES = ("loading_start", "loading_end", "unloading_start", "unloading_end")
TEST = ("temperature", *STRESSES)
SECOND = "second"
DETERMINED = (*TEMPERATURES[:4], "sigma_f")
"""Parameters that follow from plateaus."""
PLACEHOLDERS = {"M_f": -40.0, "M_s": -30.0, "A_s": -20.0, "A_f": -10.0}
"""Temperatures of a law before its plateaus are converted, less the temperature of the test [K]."""
Element = TypeVar("Element")


def build_with_plateaus(element: Table, path: str, build: Callable[[Table], Element]) -> Element:
    """Return an element whose law has given plateaus, or as it is described if it has none.

    Args:
        element: table of the element.
        path: path of the table in the scenario.
        build: builds an element from a table.

    Raises:
        InputError: the plateaus are contradictory, or the law has no plateaus.
        SolveError: no transformation temperatures give these plateaus.
    """
    law = element.get("law")
    if not isinstance(law, Mapping) or KEY not in law:
        return build(element)
    where = f"{path}.law.{KEY}"
    table = as_table(law[KEY], where)
    first, second = _read_test(table, where, (*TEST, SECOND)), table.get(SECOND)
    law_entries = {name: value for name, value in law.items() if name != KEY}
    given = next((name for name in DETERMINED if name in law_entries or name in element), None)
    if given is not None:
        raise ParameterError(f"[{where}] The plateaus determine `{given}`; leave one of them out.")
    with name_section(where):
        if second is not None:
            slopes = first.estimate_slopes(_read_test(as_table(second, f"{where}.{SECOND}"), f"{where}.{SECOND}", TEST))
            law_entries |= {name: exact_text(x, "Pa/K") for name, x in zip(TEMPERATURES[4:], slopes, strict=True)}
    begin = {name: exact_text(first.temperature + x, "K") for name, x in PLACEHOLDERS.items()}
    if law.get("kind") == "brinson":
        begin["sigma_f"] = "9 GPa"
    trial_element: Any = build({**element, "law": {**law_entries, **begin}})
    with name_section(where):
        values = convert_plateaus(trial_element.law, first)
    unit = {leaf.path: leaf.declared.unit for leaf in trial_element.law.leaves()}
    return build({**element, "law": {**law_entries, **{name: exact_text(x, unit[name]) for name, x in values.items()}}})


def _read_test(table: Table, path: str, keys: tuple[str, ...]) -> Plateaus:
    unknown = next((key for key in table if key not in keys), None)
    missing = next((key for key in TEST if key not in table), None)
    if unknown or missing:
        raise ParameterError(
            f"[{path}] needs {list_names(TEST)}, but {f'has `{unknown}`' if unknown else f'lacks `{missing}`'}."
        )
    with name_section(path):
        begin, end, back, last = (units.parse_quantity(table[key], "Pa") for key in STRESSES)
        return Plateaus(units.parse_quantity(table["temperature"], "K"), (begin, end), (back, last))
