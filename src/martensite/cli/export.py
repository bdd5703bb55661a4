"""`export`: the commands that the distribution `martensite-export` brings."""

from __future__ import annotations

from importlib.util import find_spec
from typing import Any

import typer
from typer.core import TyperGroup

from martensite.base.lazy import import_extra
from martensite.cli.app import app


class ExportCommands(TyperGroup):
    """Commands that are imported when one of them, or their list, is asked for."""

    def list_commands(self, ctx: typer.Context) -> list[str]:
        """Their names; `InputError` says what brings them."""
        known = find_spec("martensite_export") is not None
        if not self.commands and (known or not ctx.resilient_parsing):  # a shell that completes words wants no sentence
            group = import_extra("martensite_export.cli", "export", "`martensite-export`").export
            self.commands = typer.main.get_group(group).commands
            if find_spec("martensite_hardware") is not None:
                boards = import_extra("martensite_hardware.cli", "hardware").exports
                self.commands.update(typer.main.get_group(boards).commands)
        return super().list_commands(ctx)

    def get_command(self, ctx: typer.Context, cmd_name: str) -> Any:
        """The command of a name."""
        return self.commands[cmd_name] if cmd_name in self.list_commands(ctx) else None


app.add_typer(
    typer.Typer(cls=ExportCommands, help="Write a scenario for another program.", no_args_is_help=True), name="export"
)
