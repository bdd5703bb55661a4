"""Structures on the rungs of the ladder, for an order and a delay."""

from __future__ import annotations

import re

LINEAR = re.compile(r"oe\(\d+,(\d+),(\d+)\)")
"""A linear block in a text: order and delay."""
CURVES = ("poly3", "pwl(8,fixed)", "sigmoid4")
"""Static blocks."""


def write_linear(order: int, delay: int, ins: int = 1, outs: int = 1) -> str:
    """Return the text of a linear model with its line."""
    if (ins, outs) == (1, 1):
        return f"oe({order + (delay == 0)},{order},{delay}) | poly1"
    return f"{_write_state_space(order, delay, ins, outs)} | {_repeat_block('poly1', outs)}"


def _write_state_space(order: int, delay: int, ins: int, outs: int) -> str:
    return f"ss({order},{ins},{outs},{delay})"


def _repeat_block(block: str, count: int) -> str:
    return block if count == 1 else f"[{' & '.join([block] * count)}]"


def list_rungs(order: int, delay: int, ins: int = 1, outs: int = 1) -> list[tuple[str, list[str]]]:
    """Return names and structures of the rungs above the linear one, quickest first."""
    single = (ins, outs) == (1, 1)
    line = f"oe({order + (delay == 0)},{order},{delay})" if single else _write_state_space(order, delay, ins, outs)

    def join(before: str, after: str) -> str:
        parts = [_repeat_block(before, ins) if before else "", line, _repeat_block(after, outs) if after else ""]
        return " | ".join(part for part in parts if part)

    last = "" if single else "poly1"  # an `ss` behind a static block cannot have an offset
    rungs = [
        ("Hammerstein", [join(curve, last) for curve in CURVES]),
        ("Wiener", [join("", curve) for curve in CURVES]),
        ("Hammerstein–Wiener", [join(curve, curve) for curve in CURVES]),
        (
            "hysteresis",
            [
                *(join(block, "poly1") for block in ("boucwen", "duhem1", "pi8")),
                join("pi8", "poly3"),
                *(join("", f"{block} | poly1" if single else block) for block in (("duhem2",) if single else ())),
                *((join("", "pi8 | sigmoid4"), join("poly2", "pi8 | sigmoid4")) if single else ()),
                *((join("preisach(5,6)", ""), join("", "preisach(5,6)"), "heated(position)") if single else ()),
            ],
        ),
    ]
    if single:
        near = f"oe({order + 1},{order + 1},{max(delay, 1)})"
        own = f"oe({order},{order},{max(delay, 1)})"
        loops = [f"[{own} < boucwen] | poly1", f"[{near} < boucwen] | poly1", f"[{near} < pi6] | poly1"]
        rungs.append(("feedback", [f"fb({max(order, 2)},3,2) | poly1", *loops]))
    if ins == 1:
        small = [(min(order, 2), 3), (min(max(order, 2), 3), 2)]
        rungs.append(("nonlinear state space", [f"nlss({n},{d},{outs},{delay})" for n, d in small]))
    return rungs


def list_neighbours(structure: str) -> list[str]:
    """Return the structure with one pole more, and with another delay."""
    match = LINEAR.search(structure)
    if match is None:
        return []
    order, delay = int(match[1]), int(match[2])
    pairs = [(order + 1, delay), (order, delay + 1), (order + 1, delay + 1)]
    return [LINEAR.sub(f"oe({n},{n},{k})", structure) for n, k in pairs if k]
