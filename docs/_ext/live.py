"""Sphinx extension: files and figures of a page lead to the bench that lies beside the documentation.

The setting `live_bench` is the folder of a bench written as files, as `make site` makes it; without it
nothing is linked. A file that a cell writes is linked if the bench has its text; a cell with the tag
`live-NAME` if it has the scenario NAME, else that is a warning, which fails the build.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from docutils import nodes
from sphinx.util import logging

from martensite.cli.commands.web_bench import build_address

BESIDE = "bench/"
"""Where the bench lies, from the first page."""
TAG = "tag_live-"
"""How the class of a cell with such a tag begins."""
WORDS = "Open live"
_logger = logging.getLogger(__name__)


def read_texts(folder: str) -> dict[str, str]:
    """The scenarios of a bench, texts by name; none without a bench."""
    if not folder:
        return {}
    manifest = json.loads((Path(folder) / "runs" / "manifest.json").read_text("utf-8"))
    return {one["name"]: one["text"] for one in manifest["scenarios"]}


def find_live(app: Any, docname: str, name: str) -> str | None:
    """The address of a scenario on the bench, from a page; None if there is no bench, or not this scenario."""
    texts = read_texts(app.config.live_bench)
    if texts and name not in texts:
        _logger.warning("the bench has no scenario `%s`, which is linked on %s", name, docname)
    return build_address("../" * docname.count("/") + BESIDE, texts[name]) if name in texts else None


def make_link(address: str, title: str = "") -> nodes.reference:
    """The link to the bench."""
    told = f"{WORDS}: {title}" if title else WORDS
    return nodes.reference("", WORDS, refuri=address, internal=True, classes=["live"], reftitle=told)


def _link(app: Any, page: nodes.document, docname: str) -> None:
    texts = read_texts(app.config.live_bench)
    names = {text.strip(): name for name, text in texts.items()}
    for box in list(page.findall(nodes.container)):
        if box.get("literal_block") and isinstance(box[0], nodes.caption):
            name = names.get(box[-1].astext().strip())
            if name and (address := find_live(app, docname, name)):
                box[0] += [nodes.Text(" · "), make_link(address, box[0].astext())]
        for tag in box.get("classes", ()):
            address = find_live(app, docname, tag.removeprefix(TAG)) if tag.startswith(TAG) else None
            if address:
                box += nodes.paragraph("", "", make_link(address))


def setup(app: Any) -> dict[str, Any]:
    """Entry point of the extension."""
    app.add_config_value("live_bench", "", "html")
    app.connect("doctree-resolved", _link)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
