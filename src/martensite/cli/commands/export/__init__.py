"""`export`: a scenario in the form of another program; one file per form."""

from __future__ import annotations

from martensite.cli.app import app
from martensite.cli.folder_group import make_group

export = make_group(__name__, help="Write a scenario as C, FMU, WebAssembly, firmware or for FEM.")
app.add_typer(export, name="export", rich_help_panel="Take along")
