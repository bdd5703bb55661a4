"""`export`: a scenario in the form of another program, one subcommand and one file per form."""

from __future__ import annotations

import typer

from martensite.cli.app import app

export = typer.Typer(help="Write a scenario for another program.", no_args_is_help=True)
app.add_typer(export, name="export")
