"""`conform`: whether a part keeps what its interface promises."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Any

import typer

from martensite.cli.app import app
from martensite.cli.options import Imports, Json, import_modules

if TYPE_CHECKING:
    from martensite.testing import Conformance


@app.command()
def conform(
    target: Annotated[
        str, typer.Argument(metavar="FILE|NAME", help="A .py or .toml file, or a name.")
    ],
    json: Json = False,
    modules: Imports = None,
) -> None:
    """Try whether parts of your own keep what they promise.

    A law, for example, must not depend on how a path is cut into steps. Parts of this package can
    be tried as well. They are made of the typical values of their declarations, once for every
    choice of an option. Ends with 1 if a check fails.
    """
    import_modules(modules)
    from martensite.cli import show
    from martensite.testing import check_target

    found = check_target(target)
    if json:
        show.as_json([_row(one) for one in found])
    else:
        for one in found:
            _print(one)
    if not all(one.holds for one in found):
        raise typer.Exit(1)


def _row(found: Conformance) -> dict[str, Any]:
    """A part, ready for JSON."""
    return {
        "name": found.name,
        "kind": found.kind,
        "holds": found.holds,
        "findings": [vars(one) for one in found.findings],
    }


def _print(found: Conformance) -> None:
    """Every promise in a line, and below it what is wrong."""
    from martensite.cli import show

    show.text(str(found), "bold")
    faults = {one.check: one for one in found.faults}
    for check, promise in {one.check: one.promise for one in found.findings}.items():
        fault = faults.get(check)
        show.text(f"  {'kept  ' if fault is None else 'broken'}  {promise}")
        if fault is not None:
            show.text(f"          {fault.part}: {fault.fault}", "red")
