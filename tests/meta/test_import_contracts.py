"""The import contracts hold, and breaking one is noticed."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

import martensite

PACKAGE = Path(next(iter(martensite.__path__))).resolve()
ROOT = Path(__file__).resolve().parents[2]


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


@pytest.fixture
def copy(tmp_path: Path) -> Path:
    """A copy of the package to be spoiled."""
    shutil.copytree(PACKAGE, tmp_path / "martensite", ignore=shutil.ignore_patterns("__pycache__", "*.toml"))
    return tmp_path


def test_contracts_hold() -> None:
    done = lint_imports(PACKAGE.parent)
    assert done.returncode == 0, done.stdout + done.stderr
    assert "0 broken" in done.stdout


@pytest.mark.parametrize(
    ("file", "line", "contract"),
    [
        ("physics/thermal/base.py", "import martensite.actuators.elements.wire", "A module imports only"),
        ("actuators/assembly/systems.py", "import martensite.simulate.api", "layers below its own"),
        ("physics/laws/strip_laws.py", "import martensite.physics.laws.extra", "No law imports another"),
        ("actuators/elements/wire.py", "import pint", "martensite.base.units imports pint"),
        ("simulate/march.py", "import xarray", "imports no xarray"),
        ("export/mjcf.py", "import martensite.cli.commands.sweep", "layers below its own"),
        ("simulate/result.py", "import mujoco", "Only martensite.export imports mujoco"),
    ],
)
def test_a_violation_is_noticed(copy: Path, file: str, line: str, contract: str) -> None:
    (copy / "martensite" / "physics" / "laws" / "extra.py").write_text('"""Another law."""\n')
    spoiled = copy / "martensite" / file
    spoiled.write_text(f"{spoiled.read_text()}\n\ndef _late() -> None:\n    {line}\n")
    done = lint_imports(copy)
    assert done.returncode == 1, done.stdout + done.stderr
    broken = [text for text in done.stdout.splitlines() if "BROKEN" in text]
    assert any(contract in text for text in broken)
