"""Sphinx extension: a gallery of figures that other pages draw.

The directive `gallery` has a line `PAGE | title | description` for every figure. The figure is the
first of the cell with the tag `gallery` on that page, or with `PAGE#NAME` the drawing `NAME.svg` in
it. Nothing is drawn twice; a figure that is missing is a warning, which fails the build.
"""

from __future__ import annotations

from typing import Any

from docutils import nodes
from sphinx.util import logging
from sphinx.util.docutils import SphinxDirective

TAG = "tag_gallery"
"""The class of a cell with the tag `gallery`."""
_MIMES = ("image/svg+xml", "image/png", "image/gif")
_logger = logging.getLogger(__name__)


class Place(nodes.General, nodes.Element):
    """Where a figure of another page shall stand."""


class Gallery(SphinxDirective):
    """Figures of other pages, each with a link to its page."""

    has_content = True

    def run(self) -> list[nodes.Node]:
        """One place for every line."""
        found = nodes.container("", classes=["gallery"])
        for line in filter(str.strip, self.content):
            source, title, alt = (word.strip() for word in line.split("|"))
            found += Place("", source=source, title=title, alt=alt)
        return [found]


def drawn(page: nodes.document, name: str) -> str | None:
    """Where the figure of a page lies: the named one, or that of the cell with the tag."""
    if name:
        uris = [image["uri"] for image in page.findall(nodes.image)]
        return next((uri for uri in uris if uri.endswith(f"/{name}.svg")), None)
    for box in page.findall(nodes.container):
        if TAG in box.get("classes", ()):
            return _best(box)
    return None


def _best(cell: nodes.Element) -> str | None:
    """The first image of a cell, a drawing before pixels."""
    images = list(cell.findall(nodes.image))
    kinds = [getattr(image.parent, "attributes", {}).get("mime_type", "") for image in images]
    for mime in (*_MIMES, ""):
        if mime in kinds:
            return images[kinds.index(mime)]["uri"]
    return None


def _fill(app: Any, doctree: nodes.document, docname: str) -> None:
    for place in list(doctree.findall(Place)):
        page, _, name = place["source"].partition("#")
        uri = drawn(app.env.get_doctree(page), name)
        if uri is None:
            if app.config.nb_execution_mode != "off":
                _logger.warning("no figure for the gallery on %s", place["source"], location=place)
            place.parent.remove(place)
        else:
            place.replace_self(_figure(uri, app.builder.get_relative_uri(docname, page), place))


def _figure(uri: str, target: str, place: Place) -> nodes.figure:
    image = nodes.image("", uri=uri, alt=place["alt"], candidates={"*": uri}, loading="lazy")
    link = nodes.reference("", "", image, refuri=target, internal=True)
    words = nodes.reference("", place["title"], refuri=target, internal=True)
    anchor = nodes.make_id(f"figure-{place['source']}")
    return nodes.figure("", link, nodes.caption("", "", words), ids=[anchor])


def _again(app: Any, env: Any) -> list[str]:
    """The first page is written anew at every build: figures may have changed."""
    return [app.config.root_doc]


def setup(app: Any) -> dict[str, Any]:
    """Entry point of the extension."""
    app.add_node(Place)
    app.add_directive("gallery", Gallery)
    app.connect("doctree-resolved", _fill)
    app.connect("env-updated", _again)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
