"""The application: global options, errors as one sentence, exit codes."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Any

import typer
from typer.core import TyperGroup

from martensite.base.errors import MartensiteError
from martensite.base.interrupts import rescue_answer
from martensite.cli.folder_group import FolderGroup, make_group

if TYPE_CHECKING:
    from typer._click import Context


class PlainErrors(TyperGroup):
    """Command group that reports a `MartensiteError` as one sentence."""

    def parse_args(self, ctx: Context, args: list[str]) -> list[str]:
        """Accept `--debug` before or after the command name."""
        ctx.obj = {"debug": "--debug" in args}
        return super().parse_args(ctx, [arg for arg in args if arg != "--debug"])

    def invoke(self, ctx: Context) -> Any:
        """Run a command; exit with 1 or 2 on an error, with 130 on an interrupt."""
        try:
            with rescue_answer(lambda: "Interrupted; no file was written."):
                return super().invoke(ctx)
        except MartensiteError as error:
            if ctx.obj["debug"]:
                raise
            typer.secho(f"error: {error}", fg=typer.colors.RED, err=True)
            raise typer.Exit(error.exit_code) from None


class Commands(PlainErrors, FolderGroup):
    """Commands of `martensite`, listed by topic."""

    order = ("Simulate", "From logs", "Design", "Take along", "Look up")


app = make_group("martensite.cli.commands", Commands)


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
    """Simulate, identify and control shape-memory-alloy actuators.

    Exit codes: 0 success, 1 computation failed or negative answer, 2 bad input, 130 interrupted.
    """
