"""`export`: one file per target."""

from __future__ import annotations

from martensite.cli.app import app
from martensite.cli.folder_group import make_group

export = make_group(__name__, help="Write a scenario as C, FMU, WebAssembly, firmware or for FEM.")
app.add_typer(export, name="export", rich_help_panel="Take along")
