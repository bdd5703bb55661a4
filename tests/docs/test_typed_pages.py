"""What users copy from the README and the pages passes a strict type check, and a misspelt name does not.

Source of truth: pyrefly, run once over all cells, with the library as it is installed.
"""

from __future__ import annotations

import json
import re
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
from fences import README, ROOT, fences

PAGES = (README, ROOT / "docs/howto/from-python.md", ROOT / "docs/howto/own-law.md")
PLOTS = ("matplotlib", "plt.", "page_setup")
"""Cells with them show a figure: matplotlib has no complete types."""
MAGIC = re.compile(r"^%%writefile (\S+\.py)\n")
WRONG = {
    'ms.Wire(material="flexinol-90", diametre="0.25 mm", length="200 mm")': "Unexpected keyword argument `diametre`",
    "ms.Step(hihg=1.0)": "Unexpected keyword argument `hihg`",
    "ms.Environment(temperature=[1.0], cooling=ms.thermal.ConstantCooling(h=70.0))": "parameter `temperature`",
    'ms.run("a.toml", over={"diameter": 3e-4})': "dict value type `Sequence[Numeric] | ndarray`",
}
SETTINGS = """preset = "strict"
[errors]
missing-override-decorator = "ignore"
unannotated-return = "error"
unknown-argument-type = "error"
unknown-attribute-access = "error"
unknown-variable-type = "error"
"""
RIGHT = """import numpy as np
import pint
import martensite as ms

ms.Environment(temperature="22 degC", cooling=ms.thermal.ConstantCooling(h=70.0))
wire = ms.Wire(material="flexinol-90", diameter="0.25 mm", length=0.2, law="brinson")
def build(stiffness: pint.Quantity) -> ms.BiasSpring:
    return ms.BiasSpring(stiffness=stiffness, preload="4 N")


half: float = 0.5 * wire.diameter
ms.run("a.toml", over={"diameter": np.linspace(2e-4, 3e-4, 5), "mass": ["0.3 kg", 0.4]}, duration="30 s")
"""


def list_cells(page: Path) -> Iterator[tuple[str, str]]:
    """Name of a file and its text: modules that a page writes, and all other cells of Python in one."""
    script: list[str] = []
    for block in fences(page):
        if block.language.split()[0:2] in (["python"], ["{code-cell}", "ipython3"]):
            text = re.sub(r"^:tags:.*\n", "", block.text)
            module = MAGIC.match(text)
            if module:
                yield module[1], text[module.end() :]
            elif not text.startswith(("%%", "!")) and not any(word in text for word in PLOTS):
                script.append(text)
    yield f"page_{page.stem.replace('-', '_').lower()}.py", "\n".join(script)


def test_cells_pass_strict_types_and_misspelt_names_do_not(tmp_path: Path) -> None:
    pytest.importorskip("pyrefly", reason="pyrefly is not installed")
    files = dict(cell for page in PAGES for cell in list_cells(page)) | {"right.py": RIGHT}
    assert len(files) == 5 and all(len(text.splitlines()) > 5 for text in files.values())
    wrong = "import martensite as ms\n" + "\n".join(WRONG) + "\n"
    for name, text in (files | {"wrong.py": wrong}).items():
        (tmp_path / name).write_text(text, encoding="utf-8")
    (tmp_path / "pyrefly.toml").write_text(SETTINGS, encoding="utf-8")
    python = f"--python-interpreter-path={sys.executable}"
    command = [sys.executable, "-m", "pyrefly", "check", "--output-format=json", python]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False, timeout=500)
    found = [one for one in json.loads(done.stdout)["errors"] if one["severity"] == "error"]
    said = [(Path(one["path"]).name, one["line"] - 1, one["description"]) for one in found]
    assert [one for one in said if one[0] != "wrong.py"] == []
    for line, (call, words) in enumerate(WRONG.items(), start=1):
        assert any(one[1] == line and words in one[2] for one in said), (call, said)
