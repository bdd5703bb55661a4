"""Sections of a scenario: single, by name, and those of a bench."""

from __future__ import annotations

from collections.abc import Iterator

from martensite.base.errors import ParameterError
from martensite.scenario.assemble import section_of
from martensite.scenario.build import Table, as_table

PAIRS = {"sensor": "sensors", "observer": "observers", "controller": "controllers", "reference": "references"}
"""Section of several components, by section of a single one."""
BENCH, SUPERVISOR, FAULTS, RUN = "bench", "supervisor", "faults", "run"
SECTIONS = (*PAIRS, *PAIRS.values(), SUPERVISOR, FAULTS, BENCH)
"""Sections of the components around a system."""
MAKING = tuple(name for name in SECTIONS if "reference" not in name and name != BENCH)
"""Sections that turn a scenario into a bench."""
PERIOD, NAME, MODEL, MODELS, REFERENCE = "period", "name", "model", "models", "reference"
Row = tuple[str, Table, str]
"""Name, table and path of a component."""


def is_bench(document: Table) -> bool:
    """Return true for the scenario of a bench."""
    return any(name in document for name in MAKING)


def has_controllers(document: Table) -> bool:
    """Return true for a scenario with controllers."""
    return "controller" in document or "controllers" in document


def check_sections(document: Table) -> None:
    """Raise `ParameterError` for contradicting sections and sections without effect."""
    for one, several in PAIRS.items():
        if one in document and several in document:
            raise ParameterError(f"A scenario has [{one}] or [{several}.NAME], not both.")
    idle = next((name for name in SECTIONS if name in document), None)
    if idle is not None and not is_bench(document):
        raise ParameterError(f"[{idle}] has no effect, since there is neither [sensor] nor [controller].")


def list_rows(document: Table, one: str) -> Iterator[Row]:
    """Yield every component of a section; a single one has the name ''."""
    if one in document and one in PAIRS:
        yield "", section_of(document, one), one
    several = PAIRS.get(one, one)
    for name, table in section_of(document, several, {}).items():
        yield name, as_table(table, f"{several}.{name}"), f"{several}.{name}"


def check_name(name: str, path: str) -> str:
    """Return a name that is valid for a column.

    Raises:
        ParameterError: the name is not valid.
    """
    if not name.isidentifier():
        raise ParameterError(f"[{path}] A name consists of letters, digits and underscores, but is `{name}`.")
    return name
