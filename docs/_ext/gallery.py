"""Sphinx extension: a gallery of figures that other pages draw.

The directive `gallery` has a line `PAGE | title | description` for every figure. The figure is the
first of the cell with the tag `gallery` on that page, or with `PAGE#NAME` the drawing `NAME.svg` in
it. Nothing is drawn twice; a figure that is missing is a warning, which fails the build. A fourth entry is
a scenario, which the figure leads to on the bench beside the documentation, where there is one (`live`).

The directive `devices` has a line `SCENARIO | title | description` for every picture of the bench,
`_static/devices/SCENARIO.webp` (`device_pictures`). It leads to the bench, or to the page about it.
"""

from __future__ import annotations

from typing import Any

import live
from docutils import nodes
from sphinx.util import logging
from sphinx.util.docutils import SphinxDirective

TAG = "tag_gallery"
"""The class of a cell with the tag `gallery`."""
ABOUT = "howto/app"
"""The page about the bench."""
PICTURES = "_static/devices/"
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
            source, title, alt, *scenario = (word.strip() for word in line.split("|"))
            found += Place("", source=source, title=title, alt=alt, live=scenario[0] if scenario else "")
        return [found]


class Devices(SphinxDirective):
    """Pictures of the bench, each with a link to its scenario there."""

    has_content = True

    def run(self) -> list[nodes.Node]:
        """One place for every line."""
        found = nodes.container("", classes=["gallery", "devices"])
        for line in filter(str.strip, self.content):
            scenario, title, alt = (word.strip() for word in line.split("|"))
            found += Place("", source=ABOUT, title=title, alt=alt, live=scenario, device=scenario)
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
        device = place.get("device")
        up = "../" * docname.count("/")
        uri = f"{up}{PICTURES}{device}.webp" if device else drawn(app.env.get_doctree(page), name)
        if uri is None:
            if app.config.nb_execution_mode != "off":
                _logger.warning("no figure for the gallery on %s", place["source"], location=place)
            place.parent.remove(place)
        else:
            address = live.find_live(app, docname, place["live"]) if place["live"] else None
            target = app.builder.get_relative_uri(docname, page) if page in app.env.found_docs else ""
            place.replace_self(_figure(uri, target, address, place))


def _figure(uri: str, target: str, address: str | None, place: Place) -> nodes.figure:
    """A picture with its title below it; a device leads to the bench at once."""
    device = place.get("device")
    target = (address or target) if device else target
    image = nodes.image("", uri=uri, alt=place["alt"], candidates={"*": uri}, loading="lazy")
    link = nodes.reference("", "", image, refuri=target, internal=True)
    caption = nodes.caption("", "", nodes.reference("", place["title"], refuri=target, internal=True))
    if address and not device:
        caption += [nodes.Text(" · "), live.make_link(address, place["title"])]
    return nodes.figure("", link, caption, ids=[nodes.make_id(f"figure-{device or place['source']}")])


def _again(app: Any, env: Any) -> list[str]:
    """The first page is written anew at every build: figures may have changed."""
    return [app.config.root_doc]


def setup(app: Any) -> dict[str, Any]:
    """Entry point of the extension."""
    app.add_node(Place)
    app.setup_extension("live")
    app.add_directive("gallery", Gallery)
    app.add_directive("devices", Devices)
    app.connect("doctree-resolved", _fill)
    app.connect("env-updated", _again)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
