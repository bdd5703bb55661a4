"""`conform`: test parts and commands against their contracts."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from martensite.base.summary import Block, Heading, Sentence, Summary
from martensite.cli.app import app
from martensite.cli.options import Imports, Json, import_modules

if TYPE_CHECKING:
    from martensite.testing.conformance import Conformance


@app.command("conform", rich_help_panel="Look up")
def conform(
    target: Annotated[
        str, typer.Argument(metavar="FILE|NAME", help="Python file, material file (.toml), or name, e.g. wire.")
    ],
    json: Json = False,
    modules: Imports = None,
) -> None:
    """Test parts, studies and commands against their contracts.

    A law, for example, must not depend on the number of steps of a path. Kinds of experiment can be tested as
    well. Each part is built from the typical values of its declaration, once for every choice of an option. The
    exit code is 1 if a check fails.
    """
    import_modules([*(modules or []), *([target] if target.endswith(".py") else [])])
    from martensite.show.terminal import print_summary
    from martensite.testing.conformance import check_command, check_target

    commands = dict(list_commands())
    own = {name: one for name, one in commands.items() if _is_meant(one, name, target)}
    reports = check_target(target, commands, required=not own)
    reports += [check_command(one, name, find_kind(name)) for name, one in own.items()]
    blocks = [block for one in reports for block in _describe_findings(one)]
    print_summary(Summary("", blocks, [_collect_findings(one) for one in reports]), json)
    if not all(one.holds for one in reports):
        raise typer.Exit(1)


def list_commands(group: Any = None, words: str = "") -> Iterator[tuple[str, Any]]:
    """Yield the name of each command, e.g. `export c`, with the command."""
    listed: Any = typer.main.get_command(app) if group is None else group
    for name in listed.list_commands(None):
        one = listed.get_command(None, name)
        if hasattr(one, "list_commands"):
            yield from list_commands(one, f"{words}{name} ")
        else:
            yield f"{words}{name}", one


def find_kind(name: str) -> str:
    """Return `exporter` or `command`."""
    return "exporter" if name.startswith("export ") else "command"


def _is_meant(command: Any, name: str, target: str) -> bool:
    """Test whether the target is a command name, its last word, or its file."""
    if target.endswith(".py"):
        return command.callback.__module__ == Path(target).stem
    return target in (name, name.rpartition(" ")[2])


def _collect_findings(report: Conformance) -> dict[str, Any]:
    return {
        "name": report.name,
        "kind": report.kind,
        "holds": report.holds,
        "findings": [vars(one) for one in report.findings],
    }


def _describe_findings(report: Conformance) -> Iterator[Block]:
    yield Heading(str(report))
    faults = {one.check: one for one in report.faults}
    for check, promise in {one.check: one.promise for one in report.findings}.items():
        fault = faults.get(check)
        yield Sentence(f"  {'kept  ' if fault is None else 'broken'}  {promise}")
        if fault is not None:
            yield Sentence(f"          {fault.part}: {fault.fault}", "bad")
