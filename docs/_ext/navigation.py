"""Sphinx extension: the tree of pages beside each page is made of what it shows, the titles.

Sphinx copies all headings of all pages and every name of the reference, for each page anew, and then drops
what is no title: a third of what it does besides running the cells. Here they are dropped once. The tree opens
at the page alone: whole, it was a sixth of all that there is to hand out. Sphinx omits the captions of lists below
the first page; here each caption stands above the first page of its list.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from html import escape
from typing import Any

from docutils import nodes
from sphinx import addnodes

BEFORE_THEME = 400
"""Listeners run in the order of such numbers; that of a theme is 500."""


def keep_titles(contents: nodes.bullet_list) -> nodes.bullet_list:
    """The contents of a page without its headings; its lists of further pages remain."""
    kept = contents.deepcopy()
    for item in kept.children:
        if len(item.children) > 1:
            lists = list(item.findall(addnodes.toctree))
            item[1:] = [nodes.bullet_list("", *lists)] if lists else []  # type: ignore[index]
    return kept


def _prepare_titles(app: Any, page: str, template: str, context: dict[str, Any], doctree: Any) -> None:
    make_tree, env, short = context["toctree"], app.env, _shorten_once(app)

    def make_short_tree(**options: Any) -> str:
        full = env.tocs
        if options.get("titles_only"):
            env.tocs, options["collapse"] = short, True
        try:
            return _add_captions(make_tree(**options), app, page)
        finally:
            env.tocs = full

    context["toctree"] = make_short_tree


def find_groups(app: Any) -> Iterator[tuple[str, str]]:
    """Yield caption and first page of each captioned list of pages below the first page."""
    for page, contents in app.env.tocs.items():
        for one in contents.findall(addnodes.toctree) if page != app.config.root_doc else ():
            if one.get("caption") and one["entries"]:
                yield one["caption"], one["entries"][0][1]


def _add_captions(tree: str, app: Any, page: str) -> str:
    """Return a tree with the captions of its groups."""
    for caption, first in _find_groups_once(app):
        target = "#" if first == page else app.builder.get_relative_uri(page, first)
        entry = rf'(?=<li class="[^"]*"><a class="[^"]*" href="{re.escape(target)}">)'
        tree = re.sub(entry, f'<li class="menu-group">{escape(caption)}</li>', tree, count=1)
    return tree


def _shorten_once(app: Any) -> dict[str, nodes.bullet_list]:
    """The contents of all pages, by titles alone; no page is read any more."""
    if not hasattr(app, "short_contents"):
        app.short_contents = {page: keep_titles(found) for page, found in app.env.tocs.items()}
    return app.short_contents


def _find_groups_once(app: Any) -> list[tuple[str, str]]:
    """Captions and first pages of the groups; the contents of all pages are long."""
    if not hasattr(app, "groups_of_pages"):
        app.groups_of_pages = list(find_groups(app))
    return app.groups_of_pages


def setup(app: Any) -> dict[str, Any]:
    """Entry point of the extension."""
    app.connect("html-page-context", _prepare_titles, priority=BEFORE_THEME)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
