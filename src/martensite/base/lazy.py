"""Public names that are imported when they are first used, and packages that extras bring.

A package says in its stub, `__init__.pyi`, which names it offers and where they are defined;
people, type checkers and this module read these lines. Importing such a package imports nothing
else.
"""

from __future__ import annotations

import ast
import sys
from collections.abc import Callable
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from types import FunctionType
from typing import Any

from martensite.base.argument_types import guard_arguments
from martensite.base.errors import InputError


def import_extra(module: str, extra: str, title: str = "") -> Any:
    """A module that an extra of this package brings.

    Raises:
        InputError: it is not installed; the sentence names the extra.
    """
    try:
        return import_module(module)
    except ImportError:
        raise InputError(
            f"This needs {title or module}, which is not installed; run `pip install martensite[{extra}]`."
        ) from None


def list_public_names(package: str) -> dict[str, tuple[str, str]]:
    """Public name of a package -> the module that defines it, and its name there."""
    stub = Path(str(sys.modules[package].__file__)).with_suffix(".pyi")
    body = ast.parse(stub.read_text(encoding="utf-8")).body
    imported = {
        alias.asname or alias.name: (str(node.module), alias.name)
        for node in body
        if isinstance(node, ast.ImportFrom)
        for alias in node.names
    }
    found = {name: home for name, home in imported.items() if not name.startswith("_")}
    for node in body:  # `BlockChain = _Chain`: another name than that of the module
        if isinstance(node, ast.Assign):
            found[ast.unparse(node.targets[0])] = imported[ast.unparse(node.value)]
    return found


def attach_names(package: str) -> tuple[Callable[[str], Any], Callable[[], list[str]]]:
    """Make `__getattr__` and `__dir__` of a package, from its stub.

    A name that is a module is the module; a function answers objects of the wrong kind in a
    sentence (`base.argument_types`).
    """
    names = list_public_names(package)

    def import_name(name: str) -> Any:
        if name not in names:
            raise AttributeError(f"module {package!r} has no attribute {name!r}")
        home, own = names[name]
        module = import_module(home)
        is_module = hasattr(module, "__path__") and find_spec(f"{home}.{own}") is not None
        found = import_module(f"{home}.{own}") if is_module else getattr(module, own)
        if isinstance(found, FunctionType):
            found = guard_arguments(found)
        setattr(sys.modules[package], name, found)
        return found

    return import_name, lambda: sorted(names)
