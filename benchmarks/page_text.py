"""Write the benchmark section as MyST and drawings from its numbers alone."""

from __future__ import annotations

import shlex
from collections.abc import Mapping, Sequence
from typing import Any

from benchmarks.page_figures import FIGURES
from benchmarks.page_words import ALT, CAPTIONS, CLOSING, COLUMNS, INTRODUCTION, PARTS, Words
from benchmarks.report import Table, text_of

FORMAT = 1
FOLDER = "benchmarks"
"""Beside the page: drawings and numbers."""
SHARES = ("median", "p99", "p99.9")


def render(numbers: Mapping[str, Any]) -> dict[str, str]:
    """Everything that is written, by its name beside the page: the page itself and its drawings.

    Raises:
        ValueError: the numbers are of another format.
    """
    if numbers.get("format") != FORMAT:
        raise ValueError(f"The numbers have format {numbers.get('format')}, not {FORMAT}.")
    tables = {
        name: [Table(t["title"], t["rows"], t.get("note", "")) for t in part["tables"]]
        for name, part in numbers["parts"].items()
    }
    drawn = {name: draw(tables) for name, draw in FIGURES.items()}
    files = {f"{FOLDER}/{name}.svg": svg for name, svg in drawn.items() if svg}
    pieces = [INTRODUCTION, conditions(numbers)]
    for name, words in PARTS.items():
        if name in tables:
            pieces.append(section(words, tables[name], files))
    pieces.append(CLOSING.format(command=command(numbers["options"])))
    return {f"{FOLDER}.md": "\n\n".join(piece.strip() for piece in pieces) + "\n", **files}


def command(options: Mapping[str, Any]) -> str:
    """The command line that made the numbers."""
    words = ["python", "-m", "benchmarks", "page"]
    for name, value in options.items():
        if value is True:
            words.append(f"--{name}")
        elif value is not False:
            words += [f"--{name}", str(value)]
    return shlex.join(words)


def conditions(numbers: Mapping[str, Any]) -> str:
    """Machine, versions, date, and what is missing."""
    found, parts = numbers["machine"], numbers["parts"].values()
    days = sorted({part["made"] for part in parts})
    when = days[0] if len(days) == 1 else f"{days[0]} to {days[-1]}"
    busy = max(part["load"] for part in parts)
    packages = ", ".join(f"{name} {number}" for name, number in found["packages"].items())
    lines = [
        "### Conditions",
        "",
        f"- Processor: {found['processor']}, {found['cores']} cores; {found['system']}.",
        f"- C: {found['compiler']}, `{found['flags']}`.",
        f"- Versions: {packages}.",
        f"- Date: {when}. Other load at the start of a part: at most {busy:.1f} of "
        f"{found['cores']} cores.{unquiet(busy, found['cores'])}",
    ]
    if numbers["options"].get("quick"):
        lines.append("- Quick run: fewer engines, smaller batches, one error.")
    absent = [*numbers["missing"], *without(numbers["parts"])]
    return "\n".join([*lines, "", "Not measured:" if absent else "", *(f"- {one}" for one in absent)])


def unquiet(busy: float, cores: int) -> str:
    """A warning where the machine was not idle."""
    few = busy <= 0.25 * cores
    return "" if few else " The computer was not quiet: the ratios are valid, but the spreads are wide."


def without(parts: Mapping[str, Any]) -> list[str]:
    """Sentences on parts that were not run."""
    return [f"{words.title}: not run." for name, words in PARTS.items() if name not in parts]


def section(words: Words, tables: Sequence[Table], files: Mapping[str, str]) -> str:
    """One part: its text, its drawings, its tables."""
    pieces = [f"### {words.title}", words.text.strip()]
    for name in words.figures:
        if f"{FOLDER}/{name}.svg" in files:
            pieces += [f"![{ALT[name]}]({FOLDER}/{name}.svg)", CAPTIONS[name]]
    for table in tables:
        pieces += [f"**{table.title}**", grid(table)]
        if table.note:
            pieces.append(table.note)
    return "\n\n".join(pieces)


def columns(table: Table) -> list[str]:
    """Columns that say something, in the order in which they come."""
    every = dict.fromkeys(name for row in table.rows for name in row)
    return [name for name in every if any(row.get(name) not in (None, "") for row in table.rows)]


def grid(table: Table) -> str:
    """A table in Markdown: texts to the left, numbers to the right."""
    names = columns(table)
    words = [all(isinstance(row.get(name, ""), str) for row in table.rows) for name in names]
    head = " | ".join(COLUMNS.get(name, name) for name in names)
    line = " | ".join("---" if left else "---:" for left in words)
    body = [" | ".join(shown(name, row.get(name)) for name in names) for row in table.rows]
    return "\n".join(f"| {one} |" for one in (head, line, *body))


def shown(name: str, value: Any) -> str:
    """A number as it is printed."""
    if isinstance(value, int) and not isinstance(value, bool):
        return f"{value:,}"
    if value == 0.0:
        return "0"
    if name in SHARES and isinstance(value, float):
        return f"{100.0 * value:.2g} %"
    if isinstance(value, float) and name in ("ratio", "rate", "memory"):
        return f"{value:,.0f}" if value >= 100.0 else f"{value:.3g}"
    return text_of(name, value)
