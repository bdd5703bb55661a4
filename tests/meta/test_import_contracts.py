"""The import contracts hold, and breaking one is noticed.

Source of truth: the layers of `pyproject.toml`. import-linter sees import statements; this file checks strings that
name a module, the public names of stubs, pairs of files that import each other, and imported names that do not exist.
"""

import ast
import os
import re
import shutil
import subprocess
import sys
import tomllib
from collections.abc import Iterator, Sequence
from importlib import import_module
from pathlib import Path
from pkgutil import iter_modules

import grimp
import pytest
from source_facts import PACKAGE, ROOT, Facts, list_imports, read_facts


def lint_imports(folder: Path) -> subprocess.CompletedProcess[str]:
    """Run import-linter on the package that lies in a folder."""
    command = [
        sys.executable,
        "-c",
        "from importlinter.cli import lint_imports_command as c; c()",
        "--config",
        str(ROOT / "pyproject.toml"),
        "--no-cache",
    ]
    changes = {"PYTHONPATH": str(folder), "PYTHONDONTWRITEBYTECODE": "1", "COLUMNS": "200"}
    environment = os.environ | changes
    return subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True, check=False)


def test_contracts_hold() -> None:
    done = lint_imports(PACKAGE.parent)
    assert done.returncode == 0, done.stdout + done.stderr
    assert "0 broken" in done.stdout


VIOLATIONS = {
    ("physics/thermal/base.py", "martensite.actuators.elements.wire"): "A module imports only",
    ("actuators/assembly/systems.py", "martensite.simulate.api"): "layers below its own",
    ("physics/laws/strip_laws.py", "martensite.physics.laws.extra"): "No law imports another",
    ("actuators/elements/wire.py", "pint"): "martensite.base.units imports pint",
    ("simulate/march.py", "xarray"): "imports no xarray",
    ("export/mjcf.py", "martensite.cli.commands.sweep"): "layers below its own",
    ("simulate/result.py", "mujoco"): "Only martensite.export imports mujoco",
}


def test_violations_are_noticed(tmp_path: Path) -> None:
    """In one copy of the package: each is reported, with its two modules."""
    package = tmp_path / "martensite"
    shutil.copytree(PACKAGE, package, ignore=shutil.ignore_patterns("__pycache__", "*.toml"))
    (package / "physics" / "laws" / "extra.py").write_text('"""Another law."""\n')
    for file, module in VIOLATIONS:
        spoiled = package / file
        spoiled.write_text(f"{spoiled.read_text()}\n\ndef _late() -> None:\n    import {module}\n")
    done = lint_imports(tmp_path)
    assert done.returncode == 1, done.stdout + done.stderr
    summary, _, details = done.stdout.partition("Broken contracts")
    broken = [text for text in summary.splitlines() if "BROKEN" in text]
    for (file, module), contract in VIOLATIONS.items():
        assert any(contract in text for text in broken), contract
        assert f"martensite.{file[:-3].replace('/', '.')} -> {module} (l." in details, (file, module)


# ---------------------------------------------------------------- modules named in strings and stubs


def read_ranks() -> dict[str, int]:
    """Return the layer of each room, 0 for the highest."""
    contracts = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["tool"]["importlinter"]["contracts"]
    (layers,) = [one["layers"] for one in contracts if one["id"] == "layers"]
    return {room.strip(" ()"): rank for rank, row in enumerate(layers) for room in row.split("|")}


RANKS = read_ranks()


def find_room(module: str) -> str:
    """Return the room of a module; empty for the root package."""
    return module.partition(".")[2].partition(".")[0]


def list_named_modules(facts: Facts) -> Iterator[tuple[int, str]]:
    """Yield line and name of each module of the package that a string names: whole, or at the start of an f-string."""
    for line, text in facts.strings:
        name = text.partition(":")[0].rstrip(".")
        place = PACKAGE.joinpath(*name.split(".")[1:])
        if find_room(name) and (place.with_suffix(".py").exists() or (place / "__init__.py").exists()):
            yield line, name


def find_upward_strings(package: Path) -> list[str]:
    """Return the places where a string names a module of a higher layer."""
    found: list[str] = []
    for path in sorted(package.glob("*/**/*.py")):  # the root package may name every module
        own = path.relative_to(package).parts[0]
        for line, module in list_named_modules(read_facts(path)):
            room = find_room(module)
            if room != own and RANKS[room] <= RANKS[own]:
                found.append(f"{path.relative_to(package)}:{line} names `{module}`")
    return found


def test_no_string_names_a_module_of_a_higher_layer() -> None:
    assert find_upward_strings(PACKAGE) == []


@pytest.mark.parametrize(
    "code",
    [
        'import_module("martensite.show.html")',
        'import_extra("martensite.app.notebook", "notebook")',
        'import_module(f"martensite.show.{name}")',
        'HOME = "martensite.show.html:render_fragment"',
    ],
)
def test_an_upward_string_is_noticed(tmp_path: Path, code: str) -> None:
    (tmp_path / "simulate").mkdir()
    (tmp_path / "simulate" / "late.py").write_text(f"def load(name):\n    {code}\n")
    assert len(find_upward_strings(tmp_path)) == 1
    (tmp_path / "simulate" / "late.py").rename(tmp_path / "__init__.py")
    assert find_upward_strings(tmp_path) == []


STUBS = {"fit": {"show"}, "identify": {"scenario", "show"}}
"""Rooms whose public names stand in higher rooms. The list only shrinks."""


def test_public_names_stand_in_their_room_or_below() -> None:
    upward: dict[str, set[str]] = {}
    for stub in sorted(PACKAGE.glob("*/**/__init__.pyi")):
        own = stub.relative_to(PACKAGE).parts[0]
        for node in ast.parse(stub.read_text("utf-8")).body:
            room = find_room(str(node.module)) if isinstance(node, ast.ImportFrom) else own
            if room != own and RANKS[room] <= RANKS[own]:
                upward.setdefault(own, set()).add(room)
    assert upward == STUBS


# ---------------------------------------------------------------- two files that import each other

CIRCLES = {("martensite.fit.condition_fits", "martensite.fit.fit_task")}
"""Pairs that are left. The list only shrinks."""


def find_circles(graph: grimp.ImportGraph) -> set[tuple[str, str]]:
    """Return the pairs of modules that import each other, at the top or within functions."""
    pairs = {(one, two) for one in graph.modules for two in graph.find_modules_directly_imported_by(one)}
    return {(one, two) for one, two in pairs if (two, one) in pairs and one < two}


def test_no_two_files_import_each_other() -> None:
    graph = grimp.build_graph("martensite", exclude_type_checking_imports=True, cache_dir=None)
    found = find_circles(graph)
    assert found == CIRCLES, "dissolve a new pair; remove a pair that is gone from the list"
    graph.add_import(importer="martensite.base.errors", imported="martensite.base.files")
    assert find_circles(graph) - found == {("martensite.base.errors", "martensite.base.files")}


# ---------------------------------------------------------------- names that imports ask for


def find_stale_imports(folder: Path) -> list[str]:
    """Return the imports from the package, at the top or within functions, of modules or names that do not exist."""
    found: list[str] = []
    for path in sorted(folder.rglob("*.py")):
        for line, node in list_imports(path):
            if (node.module or "").startswith("martensite."):
                found += [f"{path.name}:{line} {fault}" for fault in list_missing(str(node.module), node.names)]
    return found


def find_stale_helpers(folder: Path) -> list[str]:
    """Return the imports of tests from helper modules beside them that no longer define the name."""
    defined = {path.stem: list_defined(ast.parse(path.read_text("utf-8"))) for path in folder.glob("*.py")}
    found: list[str] = []
    for path in sorted(folder.rglob("*.py")):
        for line, node in list_imports(path):
            if node.module in defined:
                absent = [one.name for one in node.names if one.name not in {"*", *defined[node.module]}]
                found += [f"{path.name}:{line} wants `{name}` of `{node.module}`" for name in absent]
    return found


def list_defined(tree: ast.Module) -> set[str]:
    """Return the names that a module defines, assigns or imports, also within `if` and `try`."""
    names: set[str] = set()
    for node in ast.walk(tree):
        if isinstance(node, ast.FunctionDef | ast.ClassDef):
            names.add(node.name)
        elif isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store):
            names.add(node.id)
        elif isinstance(node, ast.Import | ast.ImportFrom):
            names |= {one.asname or one.name for one in node.names}
    return names


def list_missing(module: str, names: Sequence[ast.alias]) -> list[str]:
    """Return faults of `from module import names`."""
    try:
        home = import_module(module)
    except ModuleNotFoundError as error:
        ours = str(error.name).startswith("martensite")
        return [f"names the module `{error.name}`"] if ours else []  # else a third-party package is not installed
    absent = (one.name for one in names if not hasattr(home, one.name))
    modules = {one.name for one in iter_modules(getattr(home, "__path__", []))}
    return [f"wants `{name}` of `{module}`" for name in absent if name not in modules]


@pytest.mark.parametrize("folder", ["src/martensite", "tests", "benchmarks", "examples", "docs/_ext"])
def test_every_import_of_the_package_exists(folder: str) -> None:
    """Many imports stand within functions and in tests, where nothing but a run would notice that a name has moved."""
    assert find_stale_imports(ROOT / folder) == []


@pytest.mark.parametrize(
    "line", ["from martensite.logs.nowhere import read_log", "from martensite.logs.reader import read_all"]
)
def test_a_stale_import_is_noticed(tmp_path: Path, line: str) -> None:
    (tmp_path / "late.py").write_text(f"def load():\n    {line}\n")
    assert len(find_stale_imports(tmp_path)) == 1


def test_tests_import_what_their_helpers_define() -> None:
    assert find_stale_helpers(ROOT / "tests") == []


def test_a_name_that_left_a_helper_is_noticed(tmp_path: Path) -> None:
    (tmp_path / "shapes.py").write_text("LENGTH = 1.0\n")
    (tmp_path / "test_shapes.py").write_text("from shapes import LENGTH, WIDTH\n")
    assert find_stale_helpers(tmp_path) == ["test_shapes.py:1 wants `WIDTH` of `shapes`"]


SLOW = re.compile(r"^(from|import) scipy\.(signal|stats)\b", re.MULTILINE)
"""Imports of a second each, which every command would pay whose modules have them at their top."""


def test_slow_parts_of_scipy_are_imported_where_they_run() -> None:
    assert SLOW.search("import os\nfrom scipy.signal import lfilter\n")
    paths = [path for path in PACKAGE.rglob("*.py") if SLOW.search(path.read_text(encoding="utf-8"))]
    assert [str(path.relative_to(PACKAGE)) for path in paths] == []
