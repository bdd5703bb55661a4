"""Limits on the source code: length of a file, complexity of a function, docstrings, private names.

Source of truth: the house rules in `CONTRIBUTING.md`. Ruff (C901) counts branches; the count here adds operands of
`and` and `or`, conditional expressions and comprehensions, and leaves nested functions to themselves. `test_names.py`
checks names. Lists and numbers of exceptions only shrink: an entry that is no longer needed fails.
"""

from __future__ import annotations

import ast
import re
import tomllib
from collections import Counter
from collections.abc import Mapping

from source_facts import PACKAGE, ROOT, Facts, collect_facts, list_imports, read_package

MOST_LINES = 400
LONG_FILES = {"simulate/adaptive.py"}
"""Files that are too long today: the step control is one algorithm on one state."""
MOST_BRANCHES = 15
COMPLEX: set[str] = set()
"""Functions that are too complex today."""
OPENINGS = {"What": 0, "Whether": 0, "Those|These|That of|The same|Likewise|Also": 0}
"""First words of docstrings that are no summary, and how often each occurs today; the aim is 0."""
PRIVATE = re.compile(r"^(?:(?:async )?def |class )?(_[A-Za-z]\w*)(?=[(:\[ ])", re.MULTILINE)
"""Private names at the top of a module."""
SLACK = 40
"""Docstrings by which a number may be above the count before it must be lowered."""


def find_long_files(sources: Mapping[str, Facts]) -> set[str]:
    """Return the files that have more lines than are allowed."""
    return {path for path, one in sources.items() if one.lines > MOST_LINES}


def find_complex(sources: Mapping[str, Facts]) -> set[str]:
    """Return path and name of the functions that are more complex than is allowed."""
    rows = ((path, name, count) for path, one in sources.items() for name, count in one.functions)
    return {f"{path}:{name}" for path, name, count in rows if count > MOST_BRANCHES}


def list_undocumented(sources: Mapping[str, Facts]) -> set[str]:
    """Return the public methods without a docstring whose name no base class of the package documents."""
    classes = [node for one in sources.values() for node in one.classes]
    bases: dict[str, set[str]] = {}
    documented: dict[str, set[str]] = {}
    for one in classes:
        parts = [node for base in one.bases for node in ast.walk(base)]
        names = {node.id for node in parts if isinstance(node, ast.Name)}
        names |= {node.attr for node in parts if isinstance(node, ast.Attribute)}
        bases[one.name] = bases.get(one.name, set()) | names
        methods = {x.name for x in one.body if isinstance(x, ast.FunctionDef) and ast.get_docstring(x)}
        fields = {x.target.id for x in one.body if isinstance(x, ast.AnnAssign) and isinstance(x.target, ast.Name)}
        documented[one.name] = documented.get(one.name, set()) | methods | fields

    def inherits(name: str, method: str, seen: frozenset[str] = frozenset()) -> bool:
        parents = bases.get(name, set()) - seen
        return any(method in documented.get(one, ()) or inherits(one, method, seen | parents) for one in parents)

    return {
        f"{one.name}.{node.name}"
        for one in classes
        for node in one.body
        if isinstance(node, ast.FunctionDef) and not one.name.startswith("_") and not node.name.startswith("_")
        if not (ast.get_docstring(node) or "overload" in map(ast.unparse, node.decorator_list))
        if not inherits(one.name, node.name)
    }


def count_openings(sources: Mapping[str, Facts]) -> Counter[str]:
    """Count the docstrings that begin with each of the words."""
    patterns = {words: re.compile(rf"({words})\b") for words in OPENINGS}
    texts = [text for one in sources.values() for text in one.docstrings]
    return Counter({words: sum(bool(one.match(text)) for text in texts) for words, one in patterns.items()})


def find_unused(text: str) -> set[str]:
    """Return the private names that a module defines and does not use."""
    return {name for name in PRIVATE.findall(text) if len(re.findall(rf"\b{name}\b", text)) == 1}


def test_files_are_short() -> None:
    assert find_long_files(read_package()) == LONG_FILES, "split a new long file; remove a file that is short now"


def test_functions_are_simple() -> None:
    assert find_complex(read_package()) == COMPLEX, "divide a new function; remove a function that is simple now"


def test_methods_have_a_docstring_or_an_interface_that_has_it() -> None:
    assert list_undocumented(read_package()) == set()


def test_docstrings_begin_with_a_summary() -> None:
    counts = count_openings(read_package())
    above = {words: counts[words] for words, most in OPENINGS.items() if counts[words] > most}
    assert above == {}, 'begin with an imperative, such as "Return ..."'
    below = {words: counts[words] for words, most in OPENINGS.items() if counts[words] + SLACK < most}
    assert below == {}, "lower the numbers in OPENINGS"


def test_ruff_limits_the_complexity() -> None:
    lint = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["tool"]["ruff"]["lint"]
    assert "C901" in lint["select"] and lint["mccabe"]["max-complexity"] == 15
    assert not [codes for codes in lint["per-file-ignores"].values() if "C901" in codes]
    assert [path for path in PACKAGE.rglob("*.py") if re.search(r"noqa:.*C901", path.read_text("utf-8"))] == []


def test_private_names_are_used_in_their_module_only() -> None:
    """The type checker reports neither an unused private name nor the import of one."""
    paths = sorted(PACKAGE.rglob("*.py"))
    assert {path.name: found for path in paths if (found := find_unused(path.read_text("utf-8")))} == {}
    imported = [(path.name, one.name) for path in paths for _, node in list_imports(path) for one in node.names]
    assert [one for one in imported if re.match(r"_(?!_)", one[1])] == []


def test_breaches_are_found() -> None:
    def collect(**texts: str) -> dict[str, Facts]:
        return {path: collect_facts(text) for path, text in texts.items()}

    sources = collect(a='"""What is read."""\n' + "\n" * MOST_LINES, b='def f():\n    """Return 1."""\n')
    assert find_long_files(sources) == {"a"}
    assert count_openings(sources)["What"] == 1
    tangled = "def g(a):\n    return [b for b in a if b and " + " and ".join("a" * 13) + "]\n"
    assert find_complex(collect(c=tangled, d=tangled.replace(" and a", "", 1))) == {"c:g"}
    assert find_unused("_a: int = 1\n_b = 2\ndef _c(): ...\nclass _D: ...\nprint(_b)\n") == {"_a", "_c", "_D"}
    parent = 'class A:\n    def move(self):\n        """Move."""\n    def turn(self): ...\n'
    child = "class B(A):\n    def move(self): ...\n    def stop(self): ...\n    def _hide(self): ...\n"
    assert list_undocumented(collect(a=parent, b=child)) == {"A.turn", "B.stop"}
