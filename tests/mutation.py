"""Mutants of the physics: small faults are put in on purpose, and the tests have to notice them.

    python tests/mutation.py map MAP.json [FOLDER ...]           which file of tests calls what
    python tests/mutation.py sample 30 LIST.jsonl ROOM ...       so many mutants of every room
    python tests/mutation.py run MAP.json LIST.jsonl OUT.jsonl   killed, survived or timeout

A mutant is one change inside a function: an operator, comparison, sign, number, branch, selection
or a statement less. Use a copy of the repository: sources change while it runs. Tests run in forks
of one process, so that a mutant costs its tests only; a command that was stopped goes on later.
"""

from __future__ import annotations

import ast
import builtins
import json
import os
import random
import resource
import signal
import sys
import tempfile
import time
from collections.abc import Iterator
from copy import deepcopy
from importlib.machinery import SourceFileLoader
from pathlib import Path
from typing import Any

import pytest

ROOT = Path.cwd()
SOURCE = ROOT / "src" / "martensite"
FOLDERS = ("contract", "exact", "order", "reference", "recover", "faults", "property", "meta")
BUDGET = 15.0
"""CPU time of the files of tests for one mutant [s], as the map says it: one of its own name, then the cheapest."""
WALL_LIMIT = 180.0
"""After so long [s] a mutant is a timeout: one that does not end is noticed."""
LIBRARIES = ("hypothesis", "matplotlib.pyplot", "scipy.optimize", "scipy.signal", "scipy.stats")

PAIRS: list[tuple[type, type]] = [
    *((ast.Add, ast.Sub), (ast.Mult, ast.Div), (ast.Eq, ast.NotEq), (ast.Is, ast.IsNot)),
    *((ast.Lt, ast.GtE), (ast.Gt, ast.LtE), (ast.In, ast.NotIn), (ast.And, ast.Or)),
]
SWAPS: dict[type, type] = {ast.Pow: ast.Mult, **dict(PAIRS), **{b: a for a, b in PAIRS}}
SELECTIONS = {"minimum": "maximum", "maximum": "minimum", "min": "max", "max": "min"}


def vary_node(node: ast.AST) -> Iterator[ast.AST]:
    """The mutants of one node."""
    new: Any = deepcopy(node)
    match node:
        case ast.BinOp(op=op) | ast.BoolOp(op=op) if type(op) in SWAPS:
            new.op = SWAPS[type(op)]()
            yield new
        case ast.Compare(ops=[op]) if type(op) in SWAPS:
            new.ops = [SWAPS[type(op)]()]
            yield new
        case ast.UnaryOp(op=ast.USub() | ast.Not(), operand=operand):
            yield operand
        case ast.Constant(value=bool() as value):
            yield ast.Constant(not value)
        case ast.Constant(value=int() | float() as value):
            yield ast.Constant(value + 1 if abs(value) < 10 else value * 1.1)
        case ast.Call(func=ast.Attribute(attr="where"), args=[_, _, _]):
            new.args[1:] = new.args[:0:-1]
            yield new
        case ast.Attribute(attr=name) | ast.Name(id=name) if name in SELECTIONS:
            yield ast.parse(ast.unparse(node)[: -len(name)] + SELECTIONS[name], mode="eval").body
        case ast.Expr(value=ast.Call()) | ast.AugAssign() | ast.Raise():
            yield ast.Pass()


def list_mutants(path: Path) -> Iterator[dict[str, Any]]:
    """Every mutant inside a function of a file, without messages, defaults and annotations."""
    text = path.read_bytes()
    starts = [0]
    for line in text.splitlines(keepends=True):
        starts.append(starts[-1] + len(line))

    def walk(node: Any, place: list[str]) -> Iterator[dict[str, Any]]:
        if isinstance(node, ast.JoinedStr | ast.arguments):
            return
        if isinstance(node, ast.FunctionDef | ast.ClassDef):
            inside = ["<locals>"] if isinstance(node, ast.FunctionDef) else []
            for child in node.body:
                yield from walk(child, [*place, node.name, *inside])
            return
        if "<locals>" in place:
            for new in vary_node(node):
                at = [starts[node.lineno - 1] + node.col_offset]
                at.append(starts[node.end_lineno - 1] + node.end_col_offset)
                said = ast.unparse(new)
                yield {
                    "file": str(path.relative_to(ROOT)),
                    "function": ".".join(place).removesuffix(".<locals>"),
                    "at": at,
                    "was": ast.unparse(node),
                    "new": said if isinstance(new, ast.stmt) else f"({said})",
                }
        if not isinstance(node, ast.Raise):
            for name, value in ast.iter_fields(node):
                for child in value if isinstance(value, list) else [value]:
                    if isinstance(child, ast.AST) and name != "annotation":
                        yield from walk(child, place)

    yield from walk(ast.parse(text), [])


def mark_calls(called: set[str]) -> None:
    """Let every function of the package that is imported from now on say in a set that it was called.

    A statement at its beginning: a tracer would make the marches ten times slower.
    """
    read = SourceFileLoader.get_code

    def walk(node: ast.AST, place: list[str]) -> None:
        for child in ast.iter_child_nodes(node):
            inner = place
            if isinstance(child, ast.FunctionDef | ast.ClassDef):
                inner = [*place, child.name]
            if isinstance(child, ast.FunctionDef):
                told = isinstance(child.body[0], ast.Expr) and isinstance(child.body[0].value, ast.Constant)
                note = ast.parse(f"_note_call({'.'.join(inner)!r})").body[0]
                ast.increment_lineno(note, child.body[0].lineno - 1)
                child.body.insert(int(told), note)
                inner = [*inner, "<locals>"]
            walk(child, inner)

    def get_code(loader: SourceFileLoader, name: str) -> Any:
        path = Path(loader.get_filename(name))
        if not path.is_relative_to(SOURCE):
            return read(loader, name)
        tree = ast.parse(path.read_bytes())
        walk(tree, [f"{path.relative_to(ROOT)}::"])
        return compile(ast.fix_missing_locations(tree), str(path), "exec", dont_inherit=True)

    builtins._note_call = called.add  # type: ignore[attr-defined]
    SourceFileLoader.get_code = get_code  # type: ignore[method-assign]


class Watcher:
    """A plugin of pytest: the cases that failed, and the functions that were called."""

    def __init__(self, note: Path) -> None:
        self.note, self.failed, self.called = note, [], set()

    def pytest_runtest_logreport(self, report: Any) -> None:
        if report.failed:
            self.failed.append(report.nodeid)

    def write_note(self) -> None:
        """Leave what was seen to the process that forked."""
        names = sorted(name.replace("::.", "::") for name in self.called)
        self.note.write_text(json.dumps({"failed": self.failed, "functions": names}))


def run_tests(arguments: list[str], watched: bool = False) -> dict[str, Any]:
    """Run pytest in a fork: its exit status (None at the limit), CPU time [s], and what it saw."""
    note = Path(tempfile.mkstemp(suffix=".json")[1])
    before, begun = sum(resource.getrusage(resource.RUSAGE_CHILDREN)[:2]), time.monotonic()
    child = os.fork()
    if child == 0:
        os.setsid()
        for stream in (0, 1, 2):
            os.dup2(os.open(os.devnull, os.O_RDWR), stream)
        watcher = Watcher(note)
        if watched:
            mark_calls(watcher.called)
        quiet = ["-W", "ignore::pytest.PytestAssertRewriteWarning", "-p", "no:cacheprovider"]
        status = pytest.main(["-m", "not slow", *quiet, *arguments], plugins=[watcher])
        watcher.write_note()
        os._exit(int(status))
    status = None
    while status is None and time.monotonic() < begun + WALL_LIMIT:
        time.sleep(0.05)
        ended, word = os.waitpid(child, os.WNOHANG)
        status = os.waitstatus_to_exitcode(word) if ended else None
    if status is None:
        os.killpg(child, signal.SIGKILL)
        os.waitpid(child, 0)
    cpu = sum(resource.getrusage(resource.RUSAGE_CHILDREN)[:2]) - before
    return {"status": status, "cpu": round(cpu, 2), **json.loads(note.read_text() or "{}")}


def write_map(out: Path, *folders: str) -> None:
    """Run every file of tests alone, and write what it costs and which functions it calls."""
    known = json.loads(out.read_text()) if out.exists() else {}
    for folder in folders or FOLDERS:
        for path in sorted((ROOT / "tests" / folder).glob("test_*.py")):
            name = str(path.relative_to(ROOT))
            if name not in known:
                known[name] = run_tests([name], watched=True)
                out.write_text(json.dumps(known))


def write_sample(count: int, out: Path, *rooms: str) -> None:
    """Draw mutants of every room, with a fixed seed."""
    drawn: list[dict[str, Any]] = []
    for room in rooms:
        found = [m for path in sorted((SOURCE / room).rglob("*.py")) for m in list_mutants(path)]
        drawn += random.Random(0).sample(found, min(count, len(found)))
    out.write_text("".join(json.dumps(mutant) + "\n" for mutant in drawn))


def run_mutants(known: dict[str, Any], wanted: list[str], out: Path) -> None:
    """Put every mutant in, run the cheapest files of tests that call its function, take it out."""
    done = len(out.read_text().splitlines()) if out.exists() else 0
    for number, mutant in enumerate(map(json.loads, wanted)):
        if number < done:
            continue
        place = f"{mutant['file']}::{mutant['function']}"
        calling = [name for name, told in known.items() if place in told.get("functions", [])]
        chosen, spent = [], 0.0
        own = Path(mutant["file"]).stem
        for name in sorted(calling, key=lambda name: (own not in name, known[name]["cpu"])):
            spent += known[name]["cpu"]
            if spent <= BUDGET or not chosen:
                chosen.append(name)
        known_to_fail = [f"--deselect={case}" for n in chosen for case in known[n]["failed"]]
        path, (begin, end) = ROOT / mutant["file"], mutant["at"]
        source = path.read_bytes()
        path.write_bytes(source[:begin] + mutant["new"].encode() + source[end:])
        moment = time.time() + 10 * number  # no two mutants share what Python compiled of one
        os.utime(path, (moment, moment))
        try:
            told = run_tests(["-x", *known_to_fail, *chosen]) if chosen else {"status": 0}
        finally:
            path.write_bytes(source)
        outcome = {None: "timeout", 0: "survived"}.get(told["status"], "killed")
        found = {**mutant, "outcome": outcome, "by": told.get("failed", []), "of": len(calling)}
        with out.open("a") as lines:
            lines.write(json.dumps(found) + "\n")


def main(command: str, *words: str) -> None:
    sys.path[:0] = [str(ROOT / "src"), str(ROOT)]
    os.environ["PYTHONPATH"] = os.pathsep.join(sys.path[:2])
    sys.dont_write_bytecode = True
    if command == "sample":
        return write_sample(int(words[0]), Path(words[1]), *words[2:])
    for library in LIBRARIES:
        __import__(library)
    if command == "map":
        return write_map(Path(words[0]), *words[1:])
    known, wanted = (Path(word).read_text() for word in words[:2])
    return run_mutants(json.loads(known), wanted.splitlines(), Path(words[2]))


if __name__ == "__main__":
    main(*sys.argv[1:])
