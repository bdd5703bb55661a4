"""That texts of a figure do not cover one another, nor leave the page."""

from __future__ import annotations

import itertools
from collections.abc import Iterable
from typing import Any

from matplotlib.figure import Figure
from matplotlib.text import Text


def check_apart(figure: Figure, texts: Iterable[Text]) -> None:
    """Raise `AssertionError` for texts of a figure that was drawn which touch or are cut off."""
    renderer = figure.canvas.get_renderer()  # type: ignore[attr-defined]
    page = figure.bbox.padded(0.5)
    boxes = [(text.get_text(), Text.get_window_extent(text, renderer)) for text in texts]
    for name, box in boxes:
        assert page.containsx(box.x0) and page.containsx(box.x1), name
        assert page.containsy(box.y0) and page.containsy(box.y1), name
    for (a, one), (b, other) in itertools.combinations(boxes, 2):
        shared = min(one.x1, other.x1) - max(one.x0, other.x0)
        heights = min(one.y1, other.y1) - max(one.y0, other.y0)
        assert shared <= 0.5 or heights <= 0.5, f"{a!r} touches {b!r}"


def visible_texts(figure: Figure) -> list[Any]:
    """All texts that are drawn: not those of ticks outside the view."""
    ticks = set()
    drawn = []
    for axes in figure.axes:
        for axis in (axes.xaxis, axes.yaxis):
            known = [t.label1 for t in axis.get_major_ticks()]
            low, high = sorted(axis.get_view_interval())
            inside = [t for t in axis.get_major_ticks() if low <= t.get_loc() <= high]
            ticks |= {id(text) for text in known}
            drawn += [t.label1 for t in inside if t.label1.get_visible()]
    others = [t for t in figure.findobj(Text) if id(t) not in ticks]
    drawn += [t for t in others if t.get_visible()]
    return [t for t in drawn if t.get_text().strip()]
