"""The application: global options, and errors as one sentence with an exit code."""

from __future__ import annotations

from typing import Annotated, Any

import typer
from typer.core import TyperGroup

from martensite.base.errors import MartensiteError
from martensite.base.interrupts import rescue_answer

GROUPS = {
    "Simulate": ("run", "steady", "check", "law", "demo", "study"),
    "From logs": ("fit", "identify"),
    "Design": ("size", "wire", "design", "tune", "sweep", "sensitivity", "pareto"),
    "Take along": ("export", "hardware", "app"),
    "Look up": ("list", "params", "describe", "materials", "data", "cite", "conform"),
}
"""Commands of the help text, the most used first."""


class PlainErrors(TyperGroup):
    """Commands that answer errors made on purpose with a sentence, not a traceback."""

    def parse_args(self, ctx: typer.Context, args: list[str]) -> list[str]:
        """Accept `--debug` before or after the name of the command."""
        ctx.obj = {"debug": "--debug" in args}
        return super().parse_args(ctx, [arg for arg in args if arg != "--debug"])

    def invoke(self, ctx: typer.Context) -> Any:
        """Run a command; exit with 1 or 2 on an error, with 130 where it is interrupted."""
        try:
            with rescue_answer(lambda: "Interrupted; no file was written."):
                return super().invoke(ctx)
        except MartensiteError as error:
            if ctx.obj["debug"]:
                raise
            typer.secho(f"error: {error}", fg=typer.colors.RED, err=True)
            raise typer.Exit(error.exit_code) from None


class Commands(PlainErrors):
    """The commands of `martensite`, listed by groups."""

    def list_commands(self, ctx: typer.Context) -> list[str]:
        """The commands by groups; others follow."""
        known = super().list_commands(ctx)
        grouped = [name for names in GROUPS.values() for name in names]
        return [*grouped, *(name for name in known if name not in grouped)]

    def format_commands(self, ctx: typer.Context, formatter: Any) -> None:
        """The commands of the help text, each group under its title."""
        left = self.list_commands(ctx)
        for title, names in {**GROUPS, "Others": tuple(left)}.items():
            found = {name: self.get_command(ctx, name) for name in names if name in left}
            rows = [
                (name, one.get_short_help_str(66)) for name, one in found.items() if one is not None and not one.hidden
            ]
            left = [name for name in left if name not in found]
            if rows:
                with formatter.section(title):
                    formatter.write_dl(rows)


app = typer.Typer(
    cls=Commands,
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,  # importing rich for a help text takes longer than all the rest
    context_settings={"help_option_names": ["-h", "--help"]},
)


def _print_version(wanted: bool) -> None:
    if wanted:
        from martensite import __version__

        typer.echo(f"martensite {__version__}")
        raise typer.Exit


@app.callback()
def read_options(
    version: Annotated[
        bool, typer.Option("--version", callback=_print_version, is_eager=True, help="Show the version.")
    ] = False,
    debug: Annotated[bool, typer.Option("--debug", help="Show the traceback of an error (with any command).")] = False,
) -> None:
    """Simulate shape-memory-alloy actuators, and reproduce published results.

    Exit codes: 0 success, 1 a run was started and failed, 2 bad input, 130 interrupted.
    """
