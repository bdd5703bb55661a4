"""Commands that distributions bring: `martensite-sweep`, `martensite-control`, `martensite-hardware`."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from martensite.base.errors import InputError
from martensite.base.lazy import import_extra
from martensite.cli.app import app

SWEEPS = {
    "design": "Find numbers for which a goal is best and limits are kept.",
    "sweep": "Run many variants of a scenario; go on where it stopped.",
    "sensitivity": "Say which numbers of a sweep explain its variance.",
    "pareto": "Find the runs of a sweep that no other beats.",
    "steady": "Find the rest, the limit cycle or the folds of a scenario.",
}
"""What the help text says of each where the distribution is absent."""
BOARDS = {"hardware": "Boards: log, run, calibrate, replay, the plant in the loop."}
CONTROLS = {"tune": "Tune the controller of a scenario, and show its loop."}
WHATEVER = {"ignore_unknown_options": True, "allow_extra_args": True}
"""Settings of a command that takes all words, to answer them with one sentence."""


def add_commands(extra: str, group: str, about: Mapping[str, str]) -> None:
    """Add the commands of a distribution, or, where it is absent, their names that say what brings them."""
    try:
        module = import_extra(f"martensite_{extra}.cli", extra, f"`martensite-{extra}`")
        app.add_typer(getattr(module, group))
    except InputError as error:
        for name, words in about.items():
            app.command(name, help=words, add_help_option=False, context_settings=WHATEVER)(_make_refusal(error))


def _make_refusal(error: InputError) -> Callable[[], None]:
    def refuse() -> None:
        raise error

    return refuse


add_commands("sweep", "sweeps", SWEEPS)
add_commands("control", "controls", CONTROLS)
add_commands("hardware", "boards", BOARDS)
