"""Options that several commands share, and what they do."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from martensite.base.errors import UnitError

Json = Annotated[bool, typer.Option("--json", help="Print JSON instead of text.")]
ScenarioFile = Annotated[Path, typer.Argument(metavar="SCENARIO", help="A scenario file (TOML).")]
Settings = Annotated[
    list[str] | None,
    typer.Option(
        "--set",
        metavar="PATH=VALUE",
        help='Change a value of the scenario, e.g. --set element.diameter="0.25 mm"; repeatable.',
    ),
]
Imports = Annotated[
    list[str] | None,
    typer.Option(
        "--import",
        metavar="MODULE",
        help="Import a module, or a .py file, that registers parts of your own; repeatable.",
    ),
]
Force = Annotated[bool, typer.Option("--force", help="Replace existing files.")]
Figure = Annotated[Path | None, typer.Option(help="Figure to write: .png, .svg or .pdf.")]


def quantity(name: str, text: str, unit: str) -> float:
    """The number, in the SI `unit`, that the option `name` holds as text with a unit.

    Raises:
        UnitError: it is no quantity, or one of another dimension.
    """
    from martensite.base import units

    try:
        return units.parse_quantity(text, unit)
    except UnitError as error:
        raise UnitError(f"Option `--{name.replace('_', '-')}`: {error}") from None


def import_modules(names: list[str] | None) -> None:
    """Import what `--import` names."""
    from martensite.base import registry

    registry.import_modules(names or [])
