"""Pages are executed: what a cell gives is kept as it comes, and one that fails fails the build.

Source of truth: what a notebook keeps of the same cells, from the definition of its format.
"""

from __future__ import annotations

import logging
import subprocess
import sys
from collections.abc import Callable
from importlib import import_module
from pathlib import Path
from typing import Any

import pytest
from fences import README, ROOT, fences
from nbformat import v4, validate

HELPERS = str(ROOT / "docs" / "_ext")
SCENARIO = next(fence.text for fence in fences(README) if fence.language == "toml")
Page = Callable[..., list[Any]]


@pytest.fixture
def page(monkeypatch: pytest.MonkeyPatch) -> Page:
    """Executes cells as those of one page; the outputs of each."""
    monkeypatch.syspath_prepend(HELPERS)
    monkeypatch.setenv("PYTHONPATH", HELPERS)
    config = import_module("myst_nb.core.config").NbParserConfig(execution_timeout=60)
    executed = import_module("executed")
    executed.WARM.set_forkserver_preload(["processes"])

    def execute(*sources: str) -> list[Any]:
        notebook = v4.new_notebook(cells=[v4.new_code_cell(source) for source in sources])
        executed.Client(notebook, None, config, logging.getLogger("pages")).start_client()
        validate(notebook)
        return [cell.outputs for cell in notebook.cells]

    return execute


def test_outputs_are_kept_in_their_order(page: Page) -> None:
    first, second, third = page(
        "import sys\nprint('a')\nprint('b')\nx = 3",
        "from IPython.display import SVG, display\ndisplay(SVG('<svg/>'))\nprint(x)\nx + 1",
        "print('wrong', file=sys.stderr)\nx;",
    )
    assert [(output.name, output.text) for output in first] == [("stdout", "a\nb\n")]
    shown, printed, returned = second
    assert (shown.output_type, shown.data["image/svg+xml"]) == ("display_data", "<svg/>")
    assert printed.text == "3\n"
    assert (returned.output_type, returned.data["text/plain"]) == ("execute_result", "4")
    assert returned.execution_count == 2
    assert [(output.name, output.text) for output in third] == [("stderr", "wrong\n")]


def test_a_figure_is_a_drawing(page: Page) -> None:
    (outputs,) = page("import page_setup\npage_setup.plt.plot([0, 1]);")
    assert "<svg" in outputs[-1].data["image/svg+xml"]


def test_commands_run_in_the_folder_of_the_page(page: Page) -> None:
    outputs = page(
        f"%%writefile wire.toml\n{SCENARIO}", "!head -c 1 wire.toml | tr '#' '%'", "!martensite check wire.toml"
    )
    assert outputs[1][0].text == "%\n"
    assert "All limits are kept." in outputs[2][0].text


@pytest.mark.parametrize(
    ("source", "told"),
    [
        ("1 / 0", "ZeroDivisionError"),
        ("1 +", "SyntaxError"),
        ("!exit 3", "exited with 3"),
        ("!martensite fly", "No such command"),
        ("import os\nos._exit(0)", "the process ended"),
    ],
)
def test_a_cell_that_fails_fails_the_page(page: Page, source: str, told: str) -> None:
    with pytest.raises(Exception, match=told) as error:
        page("x = 1", source)
    assert type(error.value).__name__ == "ExecutionError"


def test_a_cell_that_fails_fails_the_build(tmp_path: Path) -> None:
    """Builds of sound pages are those of `test_built_pages.py`."""
    text = "---\nfile_format: mystnb\n---\n\n# A page\n\n```{code-cell}\n1 / 0\n```\n"
    (tmp_path / "index.md").write_text(text, encoding="utf-8")
    settings = {"extensions": "myst_nb,executed", "nb_execution_mode": "force"}
    given = [word for name, value in settings.items() for word in ("-D", f"{name}={value}")]
    done = subprocess.run(
        [sys.executable, "-m", "sphinx", "-W", "-q", "-C", *given, str(tmp_path), "built"],
        cwd=tmp_path,
        env={"PYTHONPATH": HELPERS, "HOME": str(tmp_path), "MARTENSITE_QUICK_C": "off"},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 2, done.stderr
    assert "ZeroDivisionError" in done.stderr
