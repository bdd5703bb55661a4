"""The public names: one list, the same for people, type checkers and `import *`.

Source of truth: the block of imports that type checkers read. The table of lazy imports
must agree with it, and each name must be what its home module defines.
"""

from __future__ import annotations

import ast
import subprocess
import sys
from importlib import import_module
from pathlib import Path

import martensite

TREE = ast.parse(Path(martensite.__file__).read_text(encoding="utf-8"))


def imported_for_checkers() -> dict[str, tuple[str, str]]:
    """Public name -> module, and name there: imported, or assigned from such an import."""
    (block,) = [node for node in TREE.body if isinstance(node, ast.If)]
    found = {
        str(name.asname): (str(node.module), name.name)
        for node in block.body
        if isinstance(node, ast.ImportFrom)
        for name in node.names
    }
    for node in block.body:
        if isinstance(node, ast.Assign):
            found[ast.unparse(node.targets[0])] = found.pop(ast.unparse(node.value))
    return found


def test_lists_agree() -> None:
    expected = imported_for_checkers()
    home = {name: place.partition(":")[::2] for name, place in martensite._HOME.items()}
    found = {name: (f"martensite.{where}", own or name) for name, (where, own) in home.items()}
    assert found == expected
    assert dir(martensite) == sorted([*expected, "__version__"])


def test_every_name_is_what_its_module_defines() -> None:
    for name, (module, own) in imported_for_checkers().items():
        found = getattr(martensite, name)
        assert found is getattr(import_module(module), own)
        assert found.__module__ == module, f"{name} is defined elsewhere"


def test_import_is_light_and_simulate_stays_a_function() -> None:
    code = (
        "import sys, martensite as ms;"
        "heavy = {'numpy', 'jax', 'pint', 'xarray', 'typer', 'rich'} & sys.modules.keys();"
        "import martensite.simulate.api, martensite.simulate.result;"
        "print(len(heavy), callable(ms.simulate), hasattr(ms, 'nothing'))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.split() == ["0", "True", "False"]
