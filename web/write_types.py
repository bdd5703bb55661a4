"""Write the TypeScript that follows from Python: types of forms, constants, and sentences about a run.

    python write_types.py            write src/form/types.ts, src/engine/constants.ts and src/engine/sentences.ts
    python write_types.py --check    exit with 1 if one of them is not up to date

Each `TypedDict` of the sources becomes an interface, each alias of several types a type. Each listed constant becomes
an exported constant of the same name, and each listed sentence a function (`write_sentences.py`), so that runs in the
page have the error bounds, alarms and words of runs in Python.
"""

from __future__ import annotations

import ast
import json
import sys
from collections.abc import Iterator
from pathlib import Path

from write_sentences import write_sentence

HERE = Path(__file__).parent
ROOT = HERE.parent
SOURCES = (ROOT / "src/martensite/scenario/catalogue.py", ROOT / "src/martensite/app/forms/form_types.py")
ACCURACY = ("LOCAL", "ERROR_SAFETY", "FLOOR", "COMMON", "FINER", "MOST_PASSES", "FEW", "LEAST_ACCURACY")
SIMULATE = ROOT / "src/martensite/simulate"
LOOP = ROOT / "src/martensite/control/loop/run.py"
VIEWS = ROOT / "src/martensite/app/views"
FIGURES = ROOT / "src/martensite/show/figures"
ALARMS = ("ROUNDING", "DRIFT", "CYCLE", "RETURNED", "DOUBT_FRACTION", "LOADED_ALIKE")
CONSTANTS = {
    SIMULATE / "accuracy.py": ACCURACY,
    SIMULATE / "marching.py": ("SHORTEST", "FINEST", "ROUGHNESS"),
    SIMULATE / "march.py": ("SOLVED", "COARSE"),
    SIMULATE / "grid.py": ("JUST_AFTER",),
    SIMULATE / "ledger.py": ("LEAST_HEAT", "LEAST_WORK"),
    SIMULATE / "track.py": ("LOOKED_AT",),
    SIMULATE / "recorded_track.py": ("RESOLVED_ANGLE", "LOBATTO_END"),
    SIMULATE / "alarms.py": ALARMS,
    SIMULATE / "compiled_law.py": ("NOTICEABLE",),
    FIGURES / "hysteresis.py": ("RIPPLE", "STILL"),
    FIGURES / "phase_diagram.py": ("LEAST_STRESS",),
    VIEWS / "diagrams.py": ("PRESCRIBED", "NO_ELEMENT", "NO_WORK", "HEADROOM", "STRESSES", "TEMPERATURES", "COLDER"),
    VIEWS / "traces.py": ("MOST_SPANS",),
    ROOT / "src/martensite/show/summaries/run.py": ("ENERGIES",),
    ROOT / "src/martensite/studies/sommerfeld/runs.py": ("WINDOW", "CAPTURED"),
}
SENTENCES = {
    SIMULATE / "alarms.py": {
        "writeExcursion": "first at t",
        "writeLimitAlarm": " reaches ",
        "writeStrainAlarm": "strain varies",
        "writeSlackAlarm": "is slack",
        "writeSourceAlarm": "cannot deliver",
        "writeSupplyAlarm": "the sources ask",
        "writeDriftAlarm": "the first cycle drifts",
        "writeDoubt": "The stress comes to",
    },
    SIMULATE / "compiled_law.py": {"writeCompression": "the stress falls to"},
    SIMULATE / "forks.py": {"writeDecision": "Warning: at "},
    SIMULATE / "api.py": {"writeMissed": "was not reached", "writeResidual": "is not accounted for"},
    SIMULATE / "marching.py": {"writeFailure": "The coupled step"},
    SIMULATE / "envelope.py": {"writeStop": "The run stopped", "writeBound": " reached "},
    LOOP: {"writeGuard": "The guard", "writeEnd": "The run ends at"},
    VIEWS / "traces.py": {"writeSupervisor": "the supervisor raised"},
}
"""Name of a function in TypeScript -> words of its sentence."""
HEAD = "// Written by write_types.py from declarations in Python; do not edit.\n"
PLAIN = {"str": "string", "int": "number", "float": "number", "bool": "boolean", "Any": "unknown"}


def write_types() -> str:
    """The whole file."""
    blocks = [block for path in SOURCES for block in list_blocks(ast.parse(path.read_text("utf-8")))]
    return "\n".join([HEAD, *blocks])


def write_constants() -> str:
    """Return the file of constants.

    Raises:
        KeyError: a constant is no longer assigned in its file.
    """
    lines = [HEAD]
    for path, names in CONSTANTS.items():
        values = dict(list_assignments(ast.parse(path.read_text("utf-8"))))
        lines += [f"export const {name} = {write_value(values[name])};" for name in names]
    return "\n".join([*lines, ""])


def write_sentences() -> str:
    """Return the file of sentences.

    Raises:
        KeyError: a sentence is no longer in its file.
    """
    lines = [HEAD, 'import { formatGeneral, formatPower } from "../views/formulas.ts";', ""]
    for path, names in SENTENCES.items():
        tree = ast.parse(path.read_text("utf-8"))
        lines += [write_sentence(tree, name, words) for name, words in names.items()]
    return "\n".join([*lines, ""])


def list_assignments(tree: ast.Module) -> Iterator[tuple[str, ast.expr]]:
    """Yield the names that a module assigns, with their values."""
    for node in tree.body:
        match node:
            case ast.Assign(targets=[ast.Name(id=name)], value=value):
                yield name, value
            case ast.Assign(targets=[ast.Tuple(elts=names)], value=ast.Tuple(elts=values)):
                yield from ((ast.unparse(name), value) for name, value in zip(names, values, strict=True))


def write_value(value: ast.expr) -> str:
    """Return a number, a text, or a table of them, in TypeScript."""
    match ast.literal_eval(value):
        case dict() as table:
            entries = ", ".join(f"{key}: {json.dumps(one, ensure_ascii=False)}" for key, one in table.items())
            return f"{{ {entries} }} as const"
        case plain:
            return json.dumps(plain, ensure_ascii=False)


TARGETS = {
    HERE / "src/form/types.ts": write_types,
    HERE / "src/engine/constants.ts": write_constants,
    HERE / "src/engine/sentences.ts": write_sentences,
}


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
    """Write the files, or report a file that is not up to date."""
    for target, write in TARGETS.items():
        made = write()
        if sys.argv[1:] != ["--check"]:
            target.write_text(made, encoding="utf-8")
        elif not target.exists() or target.read_text("utf-8") != made:
            sys.exit(f"{target.relative_to(HERE)} is not the newest; run `python write_types.py` in web/.")


if __name__ == "__main__":
    main()
