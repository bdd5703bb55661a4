"""Command line: one file per group of commands, and nothing heavy before it is needed.

Every command takes `--json`, never prompts, and exits with 0, with 1 if something was
started and failed, or with 2 on bad input. An error is one sentence on standard error.
"""

from __future__ import annotations

from martensite.cli import (
    check,
    cite,
    data,
    demo,
    export,
    fit,
    fit_logs,
    identify,
    law,
    listings,
    run,
    size,
    study,
    tune,
)
from martensite.cli.app import app

__all__ = [
    "app", "check", "cite", "data", "demo", "export", "fit", "fit_logs", "identify", "law",
    "listings", "main", "run", "size", "study", "tune",
]  # fmt: skip


def main() -> None:
    """Entry point of the `martensite` command."""
    app(prog_name="martensite")
