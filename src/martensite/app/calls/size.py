"""Size a wire: every size and alloy put to a request. Long work.

Stopped, it ends with the candidates judged so far.

{"fields": {"force": "8 N", …}} -> {"asked": {…}, "columns": […], "candidates": [{…}], …}

Notes: {"done": candidates, "of": candidates}.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from martensite.app.calls._sizing import asked, typed
from martensite.app.worker import Desk
from martensite.base import units
from martensite.base.errors import InputError
from martensite.design.sizing.candidates import Candidate, size_wire
from martensite.design.sizing.margins import Margin, margins, tightest
from martensite.design.sizing.request import WireRequest
from martensite.design.sizing.scenario import scenario_text
from martensite.physics.materials.wires import WireCatalogue, load_wires
from martensite.show.reports import sizing as words


def answer(request: Mapping[str, Any], desk: Desk) -> dict[str, Any]:
    """Judge the candidates, the best first."""
    wire, catalogue = asked(request), load_wires()
    total = len(catalogue.sizes) * len(wire.alloys())
    desk.tell({"done": 0, "of": total})
    sizing = size_wire(
        wire, catalogue, lambda done, of: desk.tell({"done": done, "of": of}), desk.stop.is_set
    )
    return {
        "asked": typed(request),
        "columns": [" ".join(name.split("\n")).strip() for name in words.COLUMNS],
        "candidates": [
            _shown(wire, number, found, catalogue)
            for number, found in enumerate(sizing.candidates, start=1)
        ],
        "of": total,
    }


def _shown(
    request: WireRequest, number: int, found: Candidate, catalogue: WireCatalogue
) -> dict[str, Any]:
    limits = margins(request, found)
    text, refused = _scenario(request, found, catalogue)
    return {
        **found.to_dict(),
        "cells": words.row(number, found),
        "headline": words.headline(found),
        "sentences": list(words.sentences(request, found)),
        "doubts": words.doubts(found),
        "margins": [_margin(limit) for limit in limits],
        "tightest": _margin(tightest(limits)),
        "scenario": text,
        "no_scenario": refused,
    }


def _margin(margin: Margin) -> dict[str, Any]:
    """A margin with its numbers as they are shown."""
    shown = "" if margin.unit == margin.shown == "1" else margin.shown
    used, limit = (
        f"{units.from_si(value, margin.shown, margin.unit):.3g}"
        for value in (margin.used, margin.limit)
    )
    return {
        "name": margin.name,
        "share": margin.share,
        "used": used,
        "limit": limit,
        "unit": shown,
        "chosen": margin.chosen,
    }


def _scenario(
    request: WireRequest, found: Candidate, catalogue: WireCatalogue
) -> tuple[str | None, str]:
    """Its scenario, or the sentence why there is none."""
    try:
        return scenario_text(request, found, catalogue), ""
    except InputError as error:
        return None, str(error)
