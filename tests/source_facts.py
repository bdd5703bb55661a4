"""Facts about Python files that the tests of house rules compare, from one pass over each syntax tree."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
PACKAGE = ROOT / "src" / "martensite"


@dataclass
class Facts:
    """Facts about a file."""

    lines: int
    top: list[str] = field(default_factory=list[str])
    """Names of functions at the top of the module."""
    functions: list[tuple[str, int]] = field(default_factory=list[tuple[str, int]])
    """Name and cyclomatic complexity of each function."""
    classes: list[ast.ClassDef] = field(default_factory=list[ast.ClassDef])
    """Classes, with empty methods."""
    documented: list[str] = field(default_factory=list[str])
    """Docstrings of modules, classes and functions; empty without."""
    docstrings: list[str] = field(default_factory=list[str])
    """Texts that are statements: docstrings, also of attributes."""
    messages: list[str] = field(default_factory=list[str])
    """First argument of raised errors."""
    strings: list[tuple[int, str]] = field(default_factory=list[tuple[int, str]])
    """Line and text of strings that begin with the name of the package."""


def list_children(node: ast.AST) -> list[ast.AST]:
    """Return the nodes of a node; in a third of the time of `ast.iter_child_nodes`."""
    found: list[ast.AST] = []
    for value in vars(node).values():
        if isinstance(value, list):
            found += [one for one in value if isinstance(one, ast.AST)]
        elif isinstance(value, ast.AST) and not isinstance(value, ast.expr_context):
            found.append(value)
    return found


def walk_tree(tree: ast.AST) -> Iterator[ast.AST]:
    """Yield all nodes, parents first."""
    nodes = [tree]
    while nodes:
        node = nodes.pop()
        yield node
        nodes += list_children(node)


def count_branches(function: ast.FunctionDef) -> int:
    """Return the cyclomatic complexity of a function, without the functions within it."""
    count, nodes = 1, list_children(function)
    while nodes:
        node = nodes.pop()
        if isinstance(node, ast.FunctionDef | ast.ClassDef):
            continue
        count += isinstance(node, ast.If | ast.IfExp | ast.For | ast.While | ast.ExceptHandler | ast.match_case)
        if isinstance(node, ast.BoolOp):
            count += len(node.values) - 1
        if isinstance(node, ast.comprehension):
            count += 1 + len(node.ifs)
        nodes += list_children(node)
    return count


def join_literal(node: ast.AST) -> str:
    """Return the text of a string, f-string or sum of both; empty for anything else."""
    if isinstance(node, ast.Constant):
        return node.value if isinstance(node.value, str) else ""
    if isinstance(node, ast.JoinedStr):
        return "".join(join_literal(one) or "…" for one in node.values)
    return join_literal(node.left) + join_literal(node.right) if isinstance(node, ast.BinOp) else ""


def collect_facts(text: str) -> Facts:
    """Return the facts about the text of a file."""
    tree = ast.parse(text)
    found = Facts(text.count("\n"), [node.name for node in tree.body if isinstance(node, ast.FunctionDef)])
    for node in walk_tree(tree):
        if isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef):
            found.documented.append(ast.get_docstring(node) or "")
            if isinstance(node, ast.FunctionDef):
                found.functions.append((node.name, count_branches(node)))
            elif isinstance(node, ast.ClassDef):
                found.classes.append(node)
        elif isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant):
            found.docstrings.append(str(node.value.value).strip())
        elif isinstance(node, ast.Raise) and isinstance(node.exc, ast.Call) and node.exc.args:
            found.messages.append(join_literal(node.exc.args[0]))
        elif isinstance(node, ast.Constant) and isinstance(node.value, str) and node.value.startswith("martensite."):
            found.strings.append((node.lineno, node.value))
    for one in found.classes:
        for inner in one.body:
            if isinstance(inner, ast.FunctionDef):  # only what is said of it is needed
                inner.body = inner.body[:1]
    return found


@cache
def read_facts(path: Path) -> Facts:
    """Return the facts about a file."""
    return collect_facts(path.read_text("utf-8"))


IMPORT = re.compile(r"^[ \t]*(from [\w.]+ import (?:\((?:[^()#]|#[^\n]*)*\)|[^\n#;\\]*))", re.MULTILINE)


@cache
def list_imports(path: Path) -> list[tuple[int, ast.ImportFrom]]:
    """Return line and statement of each import from a module, also in functions and in texts of code."""
    text, found = path.read_text("utf-8"), list[tuple[int, ast.ImportFrom]]()
    for one in IMPORT.finditer(text):
        with suppress(SyntaxError):  # a sentence
            (node,) = ast.parse(one[1]).body
            assert isinstance(node, ast.ImportFrom)
            found.append((text.count("\n", 0, one.start(1)) + 1, node))
    return found


@cache
def read_package() -> dict[str, Facts]:
    """Return the facts about each file of the package by its path."""
    return {str(path.relative_to(PACKAGE)): read_facts(path) for path in sorted(PACKAGE.rglob("*.py"))}
