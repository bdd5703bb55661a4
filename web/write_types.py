"""Writes the page's types of forms from the tables that Python declares: src/form/types.ts.

    python write_types.py            writes it
    python write_types.py --check    exits with 1 if it is not the newest

Every `TypedDict` of the files below is an interface, every alias of several a type.
"""

from __future__ import annotations

import ast
import sys
from collections.abc import Iterator
from pathlib import Path

HERE = Path(__file__).parent
ROOT = HERE.parent
SOURCES = (ROOT / "src/martensite/scenario/catalogue.py", ROOT / "src/martensite/app/forms/form_types.py")
TARGET = HERE / "src" / "form" / "types.ts"
HEAD = "// Written by write_types.py from what Python declares; do not edit.\n"
PLAIN = {"str": "string", "int": "number", "float": "number", "bool": "boolean", "Any": "unknown"}


def write_types() -> str:
    """The whole file."""
    blocks = [block for path in SOURCES for block in list_blocks(ast.parse(path.read_text("utf-8")))]
    return "\n".join([HEAD, *blocks])


def list_blocks(tree: ast.Module) -> Iterator[str]:
    """Interfaces and types in the order in which a file declares them."""
    known: set[str] = {"TypedDict", "EntryDescription", "NamedPart"}
    for node in tree.body:
        match node:
            case ast.ClassDef(name=name, bases=bases) if {ast.unparse(b) for b in bases} & known:
                known.add(name)
                yield write_interface(node)
            case ast.Assign(targets=[ast.Name(id=name)], value=ast.BinOp() as value):
                yield f"export type {name} = {convert_type(value)};\n"


def write_interface(node: ast.ClassDef) -> str:
    """A table as an interface; what is said of it and of its entries becomes comments."""
    bases = ", ".join(name for b in node.bases if (name := ast.unparse(b)) != "TypedDict")
    head = f"export interface {node.name}{f' extends {bases}' if bases else ''} {{"
    lines = [*write_comment(ast.get_docstring(node)), head]
    for entry, after in zip(node.body, [*node.body[1:], None], strict=True):
        if isinstance(entry, ast.AnnAssign):
            lines += [f"  {line}" for line in write_comment(read_text(after))]
            lines.append(f"  {write_entry(entry)}")
    return "\n".join([*lines, "}", ""])


def read_text(node: ast.stmt | None) -> str | None:
    """The text that stands alone below an entry."""
    match node:
        case ast.Expr(value=ast.Constant(value=str() as text)):
            return text
    return None


def write_comment(text: str | None) -> list[str]:
    """A comment in one line, if there is something to say."""
    return [f"/** {' '.join(text.split())} */"] if text else []


def write_entry(entry: ast.AnnAssign) -> str:
    """One entry, with a question mark if it may be left out."""
    name, kind = ast.unparse(entry.target), entry.annotation
    match kind:
        case ast.Subscript(value=ast.Name(id="NotRequired"), slice=inner):
            return f"{name}?: {convert_type(inner)};"
    return f"{name}: {convert_type(kind)};"


def convert_type(kind: ast.expr) -> str:
    """A type of Python in TypeScript."""
    match kind:
        case ast.Constant(value=None):
            return "null"
        case ast.Name(id=name):
            return PLAIN.get(name, name)
        case ast.BinOp(left=left, right=right):
            return f"{convert_type(left)} | {convert_type(right)}"
        case ast.Subscript(value=ast.Name(id="list"), slice=inner):
            return f"{convert_type(inner)}[]"
        case ast.Subscript(value=ast.Name(id="dict"), slice=ast.Tuple(elts=[_, inner])):
            return f"Record<string, {convert_type(inner)}>"
        case ast.Subscript(value=ast.Name(id="Literal"), slice=ast.Constant(value=word)):
            return f'"{word}"'
    raise TypeError(f"`{ast.unparse(kind)}` has no type in TypeScript here.")


def main() -> None:
    """Write the file, or say that it is old."""
    made = write_types()
    if sys.argv[1:] != ["--check"]:
        TARGET.write_text(made, encoding="utf-8")
    elif TARGET.read_text("utf-8") != made:
        sys.exit("src/form/types.ts is not the newest; run `python write_types.py` in web/.")


if __name__ == "__main__":
    main()
