"""Command line: one file per group of commands, and nothing heavy before it is needed.

Every command takes `--json`, never prompts, and exits with 0, with 1 if something was started and
failed, with 2 on bad input, or with 130 where it is interrupted. An error is one sentence on standard error.
"""

from __future__ import annotations

from importlib import import_module

from martensite.base.interrupts import handle_signals
from martensite.cli.app import app

__all__ = ["app", "main"]

COMMANDS = (
    "check data design export board_calibrate board_cost board_learn board_run hardware fit fit_film fit_logs "
    "fit_laboratory identify law listings run size steady study sweep tune web_bench wire"
)
"""Modules whose commands register themselves."""

for _name in COMMANDS.split():
    import_module(f"martensite.cli.{_name}")


def main() -> None:
    """Entry point of the `martensite` command."""
    with handle_signals():
        app(prog_name="martensite")
