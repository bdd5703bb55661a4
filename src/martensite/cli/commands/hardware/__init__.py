"""`hardware`: boards and their logs."""

from __future__ import annotations

from martensite.cli.app import app
from martensite.cli.folder_group import make_group

hardware = make_group(__name__, help="Boards: log, run, calibrate, replay, hardware in the loop.")
app.add_typer(hardware, name="hardware", rich_help_panel="Take along")
