"""Best parameters of an interrupted fit."""

from __future__ import annotations

from json import dumps
from pathlib import Path
from typing import Any

import typer

from martensite.base.formats import write_quantity


def tell_best(latest: dict[str, Any], resume: Path | None, json: bool) -> str:
    """Print the best numbers so far; the sentence with which an interrupted fit ends."""
    state = tell_state(resume)
    if not latest:
        return f"Interrupted; nothing was found yet{state}."
    problem, note = latest["problem"], latest["note"]
    numbers = problem.numbers(note.values)
    if json:
        typer.echo(dumps({"reason": "interrupted", "cost": note.cost, "numbers": numbers}))
    else:
        units = {free.name: free.unit for free in problem.free}
        best = ", ".join(f"{name} = {write_quantity(x, units[name])}" for name, x in numbers.items())
        typer.echo(f"Best so far: {best}")
    return f"Interrupted; these numbers are not judged{state}."


def tell_state(path: Path | None) -> str:
    """Describe how to resume an interrupted search."""
    if path is None or not path.exists():
        return ""
    return f"; the search goes on from `{path}` with --resume {path}"
