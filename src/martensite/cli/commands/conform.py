"""`conform`: whether parts of your own, commands among them, keep their contracts."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Annotated, Any

import typer

from martensite.base.summary import Block, Heading, Sentence, Summary
from martensite.cli.app import app
from martensite.cli.options import Imports, Json, import_modules

if TYPE_CHECKING:
    from martensite.testing.conformance import Conformance


@app.command("conform", rich_help_panel="Look up")
def conform(
    target: Annotated[str, typer.Argument(metavar="FILE|NAME", help="A .py or .toml file, or a name.")],
    json: Json = False,
    modules: Imports = None,
) -> None:
    """Try whether parts of your own keep what they promise.

    A law, for example, must not depend on how a path is cut into steps. Parts of this package can
    be tried as well. They are made of the typical values of their declarations, once for every
    choice of an option. Ends with 1 if a check fails.
    """
    import_modules(modules)
    from martensite.show.terminal import print_summary
    from martensite.testing.conformance import check_target

    found = check_target(target)
    blocks = [block for one in found for block in _describe_findings(one)]
    print_summary(Summary("", blocks, [_collect_findings(one) for one in found]), json)
    if not all(one.holds for one in found):
        raise typer.Exit(1)


def _collect_findings(found: Conformance) -> dict[str, Any]:
    return {
        "name": found.name,
        "kind": found.kind,
        "holds": found.holds,
        "findings": [vars(one) for one in found.findings],
    }


def _describe_findings(found: Conformance) -> Iterator[Block]:
    yield Heading(str(found))
    faults = {one.check: one for one in found.faults}
    for check, promise in {one.check: one.promise for one in found.findings}.items():
        fault = faults.get(check)
        yield Sentence(f"  {'kept  ' if fault is None else 'broken'}  {promise}")
        if fault is not None:
            yield Sentence(f"          {fault.part}: {fault.fault}", "bad")
