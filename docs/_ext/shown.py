"""Sphinx extension: cells are shown as a reader types them.

A cell of commands (`!martensite …`) is shown as lines of a shell, one that writes a file
(`%%writefile NAME`) as that file under its name. A paragraph that begins with `Figure:` is the caption of
the drawing directly above it, and its alternative text; without one, the heading above is.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import Any

from docutils import nodes

CAPTION = "Figure:"
_FILE = re.compile(r"%%writefile (\S+)\n(.*)", re.DOTALL)
_LEXERS = {"toml": "toml", "py": "python"}


def commands(source: str) -> str | None:
    """The lines of a cell as a shell takes them; None if there is anything else in it."""
    lines = source.strip().splitlines()
    if not lines or not all(line.startswith("!") for line in lines):
        return None
    return "\n".join(line[1:] for line in lines)


def file(source: str) -> tuple[str, str] | None:
    """Name and text of the file that a cell writes; None if it writes none."""
    found = _FILE.fullmatch(source)
    return (found[1], found[2].rstrip("\n")) if found else None


def _show(app: Any, page: nodes.document) -> None:
    for number, block in enumerate(_sources(page)):
        source = block.astext()
        lines, written = commands(source), file(source)
        if lines is not None:
            block.replace_self(_block(lines, "bash"))
        elif written is not None:
            block.replace_self(_captioned(*written, f"file-{number}"))
    for image in page.findall(nodes.image):
        caption = _find_caption(image)
        if caption is not None:
            caption["classes"].append("figure-caption")
            image["alt"] = caption.astext()
        elif _of_cell(image):
            image["alt"] = f"{CAPTION} {_heading(image)}"


def _find_caption(image: nodes.Node) -> nodes.paragraph | None:
    """Return the paragraph after a drawing, or after the cell that drew it, that begins with `Figure:`."""
    boxes = [box for box in (image, *_above(image)) if isinstance(box, nodes.Element)]
    cells = [box for box in boxes if box.get("nb_element") == "cell_code"]
    for box in cells or boxes:
        following = box.next_node(descend=False, siblings=True)
        if isinstance(following, nodes.paragraph) and following.astext().startswith(CAPTION):
            return following
        if following is not None:
            return None
    return None


def _sources(page: nodes.document) -> Iterator[nodes.literal_block]:
    """The code of all cells."""
    for box in list(page.findall(nodes.container)):
        if box.get("nb_element") == "cell_code_source":
            yield from list(box.findall(nodes.literal_block))


def _block(text: str, language: str) -> nodes.literal_block:
    return nodes.literal_block(text, text, language=language)


def _captioned(name: str, text: str, anchor: str) -> nodes.container:
    """A file with its name above it."""
    language = _LEXERS.get(name.rpartition(".")[2], "text")
    caption = nodes.caption("", "", nodes.literal("", name))
    box = nodes.container("", literal_block=True, classes=["literal-block-wrapper"], ids=[anchor])
    box += [caption, _block(text, language)]
    return box


def _of_cell(image: nodes.Node) -> bool:
    """Whether a cell drew an image."""
    return any(box.get("nb_element") == "cell_code_output" for box in _above(image))


def _heading(image: nodes.Node) -> str:
    """The heading of the section in which something stands."""
    titles = [box[0].astext() for box in _above(image) if isinstance(box, nodes.section)]
    return titles[0] if titles else ""


def _above(node: nodes.Node) -> Iterator[nodes.Element]:
    """What a node stands in, from the inside."""
    while node.parent is not None:
        node = node.parent
        if isinstance(node, nodes.Element):
            yield node


def setup(app: Any) -> dict[str, Any]:
    """Entry point of the extension."""
    app.connect("doctree-read", _show)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
