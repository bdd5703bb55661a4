"""Options of several commands."""

from __future__ import annotations

import inspect
from collections.abc import Callable
from dataclasses import MISSING, dataclass, fields, is_dataclass
from functools import wraps
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, get_type_hints, overload

from typer import Argument, Option

from martensite.base.errors import InputError, UnitError

if TYPE_CHECKING:
    from martensite.scenario.scenario import Scenario

Text = str | None
Texts = list[str] | None
Json = Annotated[bool, Option("--json", help="Print JSON instead of text.")]
ScenarioFile = Annotated[Path, Argument(metavar="SCENARIO", help="Scenario file (.toml).")]
NamedColumns = Annotated[
    list[str] | None,
    Option(
        "--as",
        metavar="COL=QUANTITY[UNIT]",
        help=("Meaning of a column by heading or number, e.g. 2=stress[MPa], or 3=- to ignore it; repeatable."),
    ),
]
Settings = Annotated[
    Texts,
    Option(
        "--set",
        metavar="PATH=VALUE",
        help='Change of a value of the scenario, e.g. element.diameter="0.25 mm"; repeatable.',
    ),
]
Imports = Annotated[
    Texts, Option("--import", metavar="MODULE", help="Module or .py file that registers parts of your own; repeatable.")
]
Force = Annotated[bool, Option("--force", help="Overwrite existing files.")]
SaveAnyway = Annotated[
    bool, Option("--save-anyway", help="Write the result even if it is worse than before or exceeds a limit.")
]
FigureFile = Annotated[Path | None, Option(help="Figure to write: .png, .svg or .pdf.")]


@overload
def read_quantity(name: str, text: str, unit: str) -> float: ...
@overload
def read_quantity(name: str, text: str | None, unit: str) -> float | None: ...
def read_quantity(name: str, text: str | None, unit: str) -> float | None:
    """Return an option in the SI `unit`; None if not given."""
    from martensite.base import units

    if text is None:
        return None
    try:
        return units.parse_quantity(text, unit)
    except UnitError as error:
        raise UnitError(f"Option `--{name.replace('_', '-')}`: {error}") from None


@overload
def read_positive(name: str, text: str, unit: str) -> float: ...
@overload
def read_positive(name: str, text: str | None, unit: str) -> float | None: ...
def read_positive(name: str, text: str | None, unit: str) -> float | None:
    """Return an option above 0 in the SI `unit`; None if not given."""
    quantity = read_quantity(name, text, unit)
    if quantity is not None and not quantity > 0.0:
        raise InputError(f"Option `--{name}` must be above 0 {unit}, but is {quantity:g} {unit}.")
    return quantity


def refuse_idle(option: str, idle: bool, reason: str) -> None:
    """Raise `InputError` for an option without effect."""
    if idle:
        raise InputError(f"Option `{option}` has no effect, since {reason}.")


def import_modules(names: list[str] | None) -> None:
    """Import the modules of `--import`."""
    from martensite.base import registry

    registry.import_modules(names or [])


def load_scenario(path: str | Path, settings: list[str] | None, modules: list[str] | None = None) -> Scenario:
    """Return the scenario of a file after `--import` and `--set`."""
    import_modules(modules)
    from martensite.scenario.overrides import read_settings
    from martensite.scenario.scenario import load

    return load(path, read_settings(settings or []))


def load_without_log(path: str | Path, settings: list[str] | None, modules: list[str] | None = None) -> Scenario:
    """Return the scenario of a file, with a stand-in for a followed log."""
    import_modules(modules)
    from martensite.scenario.overrides import read_settings
    from martensite.scenario.recorded_waveforms import unknown_log
    from martensite.scenario.scenario import load

    return load(path, read_settings(settings or []), log=unknown_log())


@dataclass(frozen=True)
class ScenarioSource:
    """Scenario file with `--set` and `--import`."""

    file: ScenarioFile
    settings: Settings = None
    modules: Imports = None

    def load(self) -> Scenario:
        """Return the scenario, for a run that starts at home and at rest."""
        return load_scenario(self.file, self.settings, self.modules).require_home("This command")


def spread_options(command: Callable[..., None]) -> Callable[..., None]:
    """Turn dataclass arguments of a command into its options, one per field."""
    own = inspect.signature(command, eval_str=True).parameters.values()
    groups: dict[str, Any] = {one.name: one.annotation for one in own if is_dataclass(one.annotation)}
    parameters: list[inspect.Parameter] = []
    for one in own:
        named = _list_fields(groups[one.name]) if one.name in groups else [one]
        parameters += [each.replace(kind=inspect.Parameter.KEYWORD_ONLY) for each in named]

    @wraps(command)
    def call_command(**given: Any) -> None:
        for name, group in groups.items():
            given[name] = group(**{one.name: given.pop(one.name) for one in fields(group)})
        command(**given)

    call_command.__annotations__ = {one.name: one.annotation for one in parameters}
    setattr(call_command, "__signature__", inspect.Signature(parameters))  # noqa: B010
    return call_command


def _list_fields(group: Any) -> list[inspect.Parameter]:
    hints = get_type_hints(group, include_extras=True)
    return [
        inspect.Parameter(
            one.name,
            inspect.Parameter.KEYWORD_ONLY,
            default=inspect.Parameter.empty if one.default is MISSING else one.default,
            annotation=hints[one.name],
        )
        for one in fields(group)
    ]
