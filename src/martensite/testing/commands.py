"""Suite of commands: words of the help, the option `--json`, and imports."""

import ast
import inspect
import sys
from collections.abc import Iterator
from pathlib import Path

from typer.core import TyperCommand

from martensite.testing.conformance import require_condition

HEAVY = ("numpy", "scipy", "matplotlib", "xarray", "pint", "h5netcdf")
"""Packages that are slow to import."""


def check_help(command: TyperCommand) -> None:
    """Its help begins with a sentence, and each argument and option has a text."""
    first = inspect.cleandoc(command.help or "").partition("\n\n")[0]
    require_condition(first.endswith(".") and first[:1].isupper(), "its docstring does not begin with a sentence")
    silent = [one.name for one in command.params if not getattr(one, "help", None)]
    require_condition(not silent, f"`{', '.join(map(str, silent))}` has no help text")


def check_json(command: TyperCommand) -> None:
    """It has the option `--json`."""
    require_condition("--json" in list_options(command), "it has no option `--json`")


def check_imports(command: TyperCommand) -> None:
    """Its file imports heavy packages within functions only."""
    file = sys.modules[command.callback.__module__].__file__ if command.callback else None
    tree = ast.parse(Path(file).read_text("utf-8") if file else "")
    heavy = sorted({*_list_imports(tree)} & {*HEAVY})
    require_condition(not heavy, f"its file imports {', '.join(heavy)} at the top; import inside the function")


def list_options(command: TyperCommand) -> list[str]:
    """Return the option names of a command."""
    return [name for one in command.params for name in one.opts]


def _list_imports(tree: ast.Module) -> Iterator[str]:
    for node in tree.body:
        if isinstance(node, ast.Import):
            yield from (one.name.partition(".")[0] for one in node.names)
        elif isinstance(node, ast.ImportFrom):
            yield (node.module or "").partition(".")[0]
