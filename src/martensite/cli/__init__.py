"""Command line: one file per command in `commands`.

Exit codes: 0 success, 1 a computation failed, 2 bad input, 130 interrupted. Errors are one sentence on standard error.
"""

from __future__ import annotations

import gc

from martensite.base.interrupts import handle_signals
from martensite.cli.app import app

__all__ = ["app", "main"]


def main() -> None:
    """Run the `martensite` command."""
    gc.set_threshold(50_000, 20, 50)  # imports and traces keep most of what they create
    with handle_signals():
        app(prog_name="martensite")
