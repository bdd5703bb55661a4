"""A reader who follows README.md, then the tutorial, copy and paste, gets what the pages show.

All files, commands and snippets of both are taken in their order in one folder, as they stand
there and nothing else: what a page hides, the reader has not. Sources of truth: the output that
README.md shows, and that of the tutorial where it is followed alone.
"""

from __future__ import annotations

import ast
import io
import math
import re
import shlex
import shutil
from contextlib import redirect_stdout
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import pytest
from command import Command
from fences import README, ROOT, Fence, apart, fences

from martensite.kernels.compiler import find_compiler
from martensite.simulate.accuracy import RunEngine

TUTORIAL = ROOT / "docs" / "tutorial.md"
CELL = "{code-cell} ipython3"
HIDDEN = ("remove-cell", "remove-input")
NOT_COPIED = ("make ", "pip ", "uv pip ", "martensite app")
LEFT_OUT = "…"
NUMBER = re.compile(r"[+-]?\d+(?:\.\d+)?(?:e[+-]?\d+)?")
TAGS = re.compile(r":tags: \[([\w, -]+)\]\n")
OPTIONS = re.compile(r"(:\w+: .*\n)*")
"""Lines at the top of a cell that a reader does not see."""
FILE = re.compile(r"(?:# |%%writefile )(\S+)\n(.*)", re.DOTALL)


@dataclass
class Reader:
    """Somebody with a terminal and Python, both in one folder."""

    folder: Path
    outputs: list[str] = field(default_factory=list[str])
    """Of each command and each snippet."""
    names: dict[str, Any] = field(default_factory=lambda: {"__name__": "__main__"})
    """What the snippets have made so far."""

    def write(self, name: str, text: str) -> None:
        (self.folder / name).write_text(text, encoding="utf-8")

    def command(self, line: str) -> None:
        """Call it, unless a test of its own does."""
        if apart(line, self.folder):
            return
        done = Command(*shlex.split(line)[1:])()
        assert done.exit_code == 0, f"{line}: {done.output}"
        assert done.stdout.strip(), line
        self.outputs.append(done.stdout)

    def python(self, source: str) -> None:
        """Run lines as a session of Python does: the value of the last one is shown."""
        body, shown = ast.parse(source).body, io.StringIO()
        last = body.pop() if isinstance(body[-1], ast.Expr) else None
        value: Any = None
        with redirect_stdout(shown):
            exec(compile(ast.Module(body, []), "snippet", "exec"), self.names)
            if isinstance(last, ast.Expr):
                value = eval(compile(ast.Expression(last.value), "snippet", "eval"), self.names)
        self.outputs.append(shown.getvalue() + ("" if value is None else f"{value!r}\n"))

    def read(self, block: Fence) -> None:
        """Do what a block of README.md says, or compare with what it shows."""
        if block.language == "text":
            assert same(block.text, self.outputs[-1]), f"{block.text}\n{self.outputs[-1]}"
        elif block.language == "toml" and (file := FILE.fullmatch(block.text)):
            self.write(file[1], block.text)
        elif block.language == "python":
            self.python(block.text)
            self.names = {"__name__": "__main__"}
        elif block.language in ("bash", "sh"):
            for line in block.text.splitlines():
                if line.startswith("martensite ") and not line.startswith(NOT_COPIED):
                    self.command(line)
                else:
                    assert not line.strip() or line.startswith((*NOT_COPIED, "python ")), line

    def follow(self, page: Path) -> list[str]:
        """Read a page from top to bottom; the outputs of its blocks."""
        before = len(self.outputs)
        for block in fences(page):
            source = visible(block)
            if source is None:
                self.read(block)
            elif file := FILE.fullmatch(source) if source.startswith("%%") else None:
                self.write(file[1], file[2])
            elif source.startswith("!"):
                for line in source.splitlines():
                    self.command(line[1:])
            elif source:
                self.python(source)
        return self.outputs[before:]


def visible(block: Fence) -> str | None:
    """What a reader sees of a cell; None for what is none."""
    if block.language != CELL:
        return None
    tags = TAGS.match(block.text)
    hidden = tags is not None and any(tag in tags[1].split(", ") for tag in HIDDEN)
    return "" if hidden else OPTIONS.sub("", block.text, count=1)


def same(shown: str, found: str) -> bool:
    """Whether all lines shown are found in this order; none is left out but at an ellipsis."""
    found = found.replace(" s in C, accuracy", " s on floats, accuracy")  # what is done first
    lines = iter([line.split() for line in found.splitlines() if line.strip()])
    skipping = False
    for line in filter(str.strip, shown.splitlines()):
        if line.strip() == LEFT_OUT:
            skipping = True
            continue
        candidates = lines if skipping else [next(lines, [])]
        if not any(alike(line.split(), candidate) for candidate in candidates):
            return False
        skipping = False
    return skipping or next(lines, None) is None


def alike(one: list[str], other: list[str]) -> bool:
    """Whether words are equal and numbers nearly.

    How many steps a run takes follows the last digits of the mathematics library of a machine.
    """
    near = 0.1 if "steps" in one else 0.02
    return len(one) == len(other) and all(_alike(a, b, near) for a, b in zip(one, other, strict=True))


def _alike(one: str, other: str, near: float) -> bool:
    if NUMBER.sub("#", one) != NUMBER.sub("#", other):
        return False
    pairs = zip(NUMBER.findall(one), NUMBER.findall(other), strict=True)
    return all(math.isclose(float(a), float(b), rel_tol=near, abs_tol=1e-9) for a, b in pairs)


def timeless(outputs: list[str]) -> list[str]:
    """Outputs without how long a search took."""
    return [re.sub(r"(, | in )[\d.e+-]+ s(?=[.\n])", r"\1some time", text) for text in outputs]


@pytest.fixture
def reader(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Reader:
    """In a fresh checkout: its examples, and nothing of his own."""
    shutil.copytree(ROOT / "examples", tmp_path / "examples")
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("matplotlib.pyplot.show", lambda: None)  # there is no screen
    # which runtime is ready first depends on what the process did before, and on other work of the machine
    if find_compiler() is None:
        monkeypatch.setattr(RunEngine, "_quickest", lambda self, plan: self._on_floats(plan, hasty=False))
    else:
        monkeypatch.setattr(RunEngine, "_quickest", RunEngine._on_c)
    return Reader(tmp_path)


def test_the_readme_is_followed(reader: Reader) -> None:
    assert len(reader.follow(README)) >= 5


@pytest.mark.slow  # the documentation follows the tutorial alone whenever it is built
def test_the_tutorial_is_the_same_after_the_readme(
    reader: Reader, tmp_path_factory: pytest.TempPathFactory, monkeypatch: pytest.MonkeyPatch
) -> None:
    reader.follow(README)
    both = reader.follow(TUTORIAL)
    assert len(both) >= 12
    monkeypatch.chdir(tmp_path_factory.mktemp("alone"))
    alone = Reader(Path.cwd()).follow(TUTORIAL)
    assert timeless(both) == timeless(alone)


def test_what_a_page_hides_the_reader_has_not(reader: Reader) -> None:
    page = reader.folder / "page.md"
    text = f"```{CELL}\n:tags: [remove-cell]\nx = 1\n```\n\n```{CELL}\nLINES\n```\n"
    page.write_text(text.replace("LINES", "y = 2\ny + 1"), encoding="utf-8")
    assert reader.follow(page) == ["3\n"]
    page.write_text(text.replace("LINES", "x + 1"), encoding="utf-8")
    with pytest.raises(NameError):
        reader.follow(page)


def test_a_readme_that_shows_another_output_is_noticed(reader: Reader) -> None:
    page = reader.folder / "README.md"
    text = "```bash\nmartensite list law\n```\n\n```text\n…\n{}\n…\n```\n"
    page.write_text(text.format("no law at all"), encoding="utf-8")
    with pytest.raises(AssertionError, match="no law at all"):
        reader.follow(page)


@pytest.mark.parametrize(
    ("shown", "agrees"),
    [
        ("a 1.00 mm\n…\nc", True),
        ("…\nb 2", True),
        ("a 1.1 mm\n…\nc", False),
        ("a 1 m\n…\nc", False),
        ("a 1 mm\nc", False),
        ("a 1 mm\nb 2", False),
    ],
)
def test_outputs_are_compared(shown: str, agrees: bool) -> None:
    found = "a 1 mm\n\nb 2\nc\n" if not shown.startswith("…") else "a 1 mm\nb 2\n"
    assert same(shown, found) == agrees
