"""Sphinx extension: reference pages written from the package's own declarations.

A page holds a comment `<!-- from-declarations: NAME -->`, and this extension puts Markdown in
its place before the page is parsed. Nothing about a parameter, a material, a command or a
cited work is written twice.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from functools import partial
from typing import Any

import bench
import bibtex
import blocks
import commands
import parts
import sources

from martensite.actuators.elements.limits import ElementLimits
from martensite.control import ManualMode, PidLaw, ReadingFilter, ReferenceShaping, SignalSlew
from martensite.control.loop.parts import MountedSensor
from martensite.physics.laws.base import LAWS
from martensite.physics.laws.wear import Wear
from martensite.physics.thermal.base import Environment
from martensite.scenario.bench import BenchSettings
from martensite.scenario.guard import FromPlant
from martensite.scenario.run_section import Run

PAGES = ("brinson", "elahinia", "lagoudas", "liang-rogers", "mas", "mas-hybrid", "mas-polycrystal", "tanaka")
"""Laws whose page lists their parameters."""
SOURCES = {
    "migaone-paper": ("migaone",),
    "copaci2019": ("hammerstein-wiener",),
    "ranjith2018": ("platform",),
    "kossoski2018": ("wire-heating", "sommerfeld"),
    "finger-paper": ("finger", "finger-calibration"),
}
"""Works that have a page of their own, with the studies of each."""
AROUND = {
    "law": PidLaw,
    "reading-filter": ReadingFilter,
    "shaping": ReferenceShaping,
    "manual": ManualMode,
    "slew": SignalSlew,
}
"""Tables of a controller that are in no registry."""
REBUILT = [name for studies in SOURCES.values() for name in studies]
SECTIONS: dict[str, Callable[[], str]] = {
    "parts": parts.all_parts,
    "blocks": blocks.all_blocks,
    "sweeps": parts.sweeps,
    "materials": parts.all_materials,
    "numbers": parts.canonical_numbers,
    "outputs": parts.outputs,
    "status": parts.statuses,
    "units": parts.everyday_units,
    "commands": commands.all_commands,
    "bibliography": bibtex.bibliography,
    **{f"figure-{name}": partial(sources.drawing, name) for name in REBUILT},
    **{f"claims-{name}": partial(sources.claims, name) for name in REBUILT},
    **{f"source-{key}": partial(sources.entry, key) for key in SOURCES},
    **{f"rebuilt-{key}": partial(sources.count_reproduced, studies) for key, studies in SOURCES.items()},
    **{f"cite-{key}": partial(sources.both_entries, key) for key in SOURCES},
    **{f"digest-{name}": partial(parts.digest, name) for name in REBUILT},
    **{f"law-{name}": partial(parts.parameters_of, LAWS[name]) for name in PAGES},
    "studies": parts.all_studies,
    "run": lambda: parts.parameters_of(Run),
    "bench": lambda: parts.parameters_of(BenchSettings),
    "from-plant": lambda: parts.parameters_of(FromPlant),
    **{f"controller-{name}": partial(parts.parameters_of, cls) for name, cls in AROUND.items()},
    "mounted": lambda: parts.parameters_of(MountedSensor),
    "environment": lambda: parts.parameters_of(Environment),
    "limits": lambda: parts.parameters_of(ElementLimits),
    "wear": lambda: parts.parameters_of(Wear),
    **{f"api-{name}": partial(parts.api_page, name) for name in parts.list_api()},
    "app-addresses": bench.addresses,
    "app-calls": bench.calls,
}
_BAR = re.compile(r"(``.*?``)|\|")
_MARK = re.compile(r"<!-- from-declarations: ([\w-]+) -->")


def filled(text: str) -> str:
    """The text with every mark, and every field of a number, replaced by what it stands for."""
    return _MARK.sub(lambda mark: SECTIONS[mark[1]](), sources.with_numbers(text))


def _fill(app: Any, page: str, content: list[str]) -> None:
    content[0] = filled(content[0])


def _keep_bars(app: Any, what: str, name: str, obj: object, options: Any, lines: list[str]) -> None:
    """Docstrings write |x| for an absolute value, which reStructuredText takes for a substitution."""
    lines[:] = [_BAR.sub(lambda found: found[1] or r"\|", line) for line in lines]


def _always(app: Any, env: Any, added: Any, changed: Any, removed: Any) -> list[str]:
    """Pages with a mark are read at every build: their source is the package."""
    return [page for page in env.found_docs if _MARK.search(env.doc2path(page).read_text("utf-8"))]


def setup(app: Any) -> dict[str, Any]:
    """Entry point of the extension."""
    app.connect("source-read", _fill)
    app.connect("autodoc-process-docstring", _keep_bars)
    app.connect("env-get-outdated", _always)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
