"""Command line: one file per command in `commands`, and nothing heavy before it is needed.

Every command takes `--json`, never prompts, and exits with 0, with 1 if something was started and
failed, with 2 on bad input, or with 130 where it is interrupted. An error is one sentence on standard error.
"""

from __future__ import annotations

from martensite.base.interrupts import handle_signals
from martensite.cli.app import app

__all__ = ["app", "main"]


def main() -> None:
    """Entry point of the `martensite` command."""
    with handle_signals():
        app(prog_name="martensite")
