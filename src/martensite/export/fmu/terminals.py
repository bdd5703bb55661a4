"""terminalsAndIcons.xml of FMI 3.0: terminals of an element, and its icon.

The force pulls at the moved end. Tension is positive, so the power into the element through that end is force ·
velocity.
"""

from __future__ import annotations

import struct
import zlib
from collections.abc import Mapping, Sequence
from xml.etree.ElementTree import Element, SubElement

from martensite.export.fmu.description import as_text
from martensite.export.fmu.variables import FmuVariable

Members = Mapping[str, tuple[str, str]]
"""Name in the terminal, and kind, by variable."""
TERMINALS: Mapping[str, tuple[str, Members]] = {
    "end": (
        "the end that is moved",
        {"elongation": ("s", "signal"), "velocity": ("v", "signal"), "force": ("f", "inflow")},
    ),
    "surroundings": ("what it is cooled by", {"ambient": ("T", "signal"), "heat_loss": ("Q_flow", "outflow")}),
    "drive": (
        "what heats it",
        {
            "drive": ("drive", "signal"),
            "resistance": ("R", "signal"),
            "current": ("i", "signal"),
            "voltage": ("v", "signal"),
        },
    ),
}
PIXELS = 64
_TURNS = 6


def write_terminals(variables: Sequence[FmuVariable]) -> str:
    """Return terminalsAndIcons.xml of an element with the given variables."""
    names = {one.name for one in variables}
    root = Element("fmiTerminalsAndIcons", fmiVersion="3.0")
    box = {"x1": "-100", "y1": "-100", "x2": "100", "y2": "100"}
    graphics = SubElement(root, "GraphicalRepresentation")
    SubElement(graphics, "CoordinateSystem", box, suggestedScalingFactorTo_mm="0.1")
    SubElement(graphics, "Icon", box)
    every = SubElement(root, "Terminals")
    for name, (words, members) in TERMINALS.items():
        terminal = SubElement(every, "Terminal", name=name, matchingRule="plug", description=words)
        for variable, (member, kind) in members.items():
            if variable in names:
                SubElement(
                    terminal, "TerminalMemberVariable", variableName=variable, memberName=member, variableKind=kind
                )
    return as_text(root)


def draw_icon() -> bytes:
    """Return a wound wire between two grips as PNG, 64 by 64 pixels, black on white."""
    middle, size = PIXELS // 2, PIXELS // 4
    rows = [[255] * PIXELS for _ in range(PIXELS)]
    for column in range(4, PIXELS - 4):
        phase = (column - 4) * 2 * _TURNS / (PIXELS - 8)
        height = abs(phase % 2.0 - 1.0) * 2.0 - 1.0
        for thick in range(-4, 5):
            rows[middle + round(size * height) + thick][column] = 0
    for edge in (2, 3, PIXELS - 4, PIXELS - 3):
        for row in range(middle - size - 6, middle + size + 7):
            rows[row][edge] = 0
    return _write_png(rows)


def _write_png(rows: Sequence[Sequence[int]]) -> bytes:
    """Return rows of 8-bit grey values as PNG."""
    head = struct.pack(">IIBBBBB", len(rows[0]), len(rows), 8, 0, 0, 0, 0)
    lines = b"".join(b"\0" + bytes(row) for row in rows)
    chunks = [(b"IHDR", head), (b"IDAT", zlib.compress(lines, 9)), (b"IEND", b"")]
    body = (
        struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data)) for kind, data in chunks
    )
    return b"\x89PNG\r\n\x1a\n" + b"".join(body)
