"""`design`, `sweep`, `sensitivity`, `pareto`, `steady`: commands that the distribution `martensite-sweep` brings."""

from __future__ import annotations

from collections.abc import Callable

from martensite.base.errors import InputError
from martensite.base.lazy import import_extra
from martensite.cli.app import app

ABOUT = {
    "design": "Find numbers for which a goal is best and limits are kept.",
    "sweep": "Run many variants of a scenario; go on where it stopped.",
    "sensitivity": "Say which numbers of a sweep explain its variance.",
    "pareto": "Find the runs of a sweep that no other beats.",
    "steady": "Find the rest, the limit cycle or the folds of a scenario.",
}
"""What the help text says of each where the distribution is absent."""
WHATEVER = {"ignore_unknown_options": True, "allow_extra_args": True}
"""Settings of a command that takes all words, to answer them with one sentence."""


def add_commands() -> None:
    """Add the commands, or, where they are absent, some of their names that say what brings them."""
    try:
        app.add_typer(import_extra("martensite_sweep.cli", "sweep", "`martensite-sweep`").sweeps)
    except InputError as error:
        for name, about in ABOUT.items():
            app.command(name, help=about, add_help_option=False, context_settings=WHATEVER)(_make_refusal(error))


def _make_refusal(error: InputError) -> Callable[[], None]:
    def refuse() -> None:
        raise error

    return refuse


add_commands()
