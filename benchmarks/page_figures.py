"""Drawings of the benchmark page as SVG: lines on axes, from numbers alone.

What: written by hand, digit for digit the same from the same numbers with any version of any
library, so that a drawing can be compared with the numbers it is made of.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from html import escape
from typing import NamedTuple

from benchmarks.report import Table

WIDTH, HEIGHT = 560, 300
LEFT, RIGHT, TOP, BOTTOM = 62, 190, 14, 44
COLOURS = ("#1f5f8b", "#d55e00", "#5a8f7b", "#8a6fa8", "#b0783c", "#6f6f6f", "#a61c00")
TYPE = "font-family:sans-serif;font-size:11px;fill:#333333"
Points = Sequence[tuple[float, float]]
Line = Mapping[str, Points]


class Logarithmic(NamedTuple):
    """An axis from a power of ten to another, in pixels."""

    low: int
    high: int
    begin: float
    end: float

    def at(self, value: float) -> float:
        """Pixel of a value."""
        share = (math.log10(value) - self.low) / (self.high - self.low)
        return self.begin + share * (self.end - self.begin)

    def ticks(self) -> dict[str, float]:
        """Pixels of powers of ten; every second one where there are many."""
        step = 1 if self.high - self.low <= 7 else 2
        return {power(n): self.at(10.0**n) for n in range(self.low, self.high + 1, step)}


class Linear(NamedTuple):
    """An axis from 0 to a number, in pixels."""

    high: int
    begin: float
    end: float

    def at(self, value: float) -> float:
        """Pixel of a value."""
        return self.begin + value / self.high * (self.end - self.begin)

    def ticks(self) -> dict[str, float]:
        """Pixels of about five whole numbers, or of halves."""
        step = 0.5 if self.high <= 3 else math.ceil(self.high / 5)
        count = math.floor(self.high / step)
        return {f"{k * step:g}": self.at(k * step) for k in range(count + 1)}


Axis = Logarithmic | Linear


def logarithmic(values: Sequence[float], begin: float, end: float) -> Logarithmic:
    """The logarithmic axis that holds some values."""
    low = math.floor(math.log10(min(values)) + 1e-9)
    high = math.ceil(math.log10(max(values)) - 1e-9)
    return Logarithmic(low, max(high, low + 1), begin, end)


def power(exponent: int) -> str:
    """A power of ten as it is printed; small ones in full."""
    if -2 <= exponent <= 3:
        return f"{10.0**exponent:g}"
    return f'10<tspan dy="-4" font-size="8">{exponent}</tspan>'


def text(x: float, y: float, words: str, more: str = "") -> str:
    """Words at a place."""
    return f'<text x="{x:.1f}" y="{y:.1f}" style="{TYPE}"{more}>{words}</text>'


def rule(x1: float, y1: float, x2: float, y2: float) -> str:
    """A line of the grid."""
    return f'<path d="M{x1:.1f} {y1:.1f}L{x2:.1f} {y2:.1f}" stroke="#dddddd"/>'


def frame(across: Axis, up: Axis, labels: tuple[str, str]) -> list[str]:
    """Grid, ticks and labels."""
    found: list[str] = []
    for words, x in across.ticks().items():
        found.append(rule(x, up.begin, x, up.end))
        found.append(text(x, up.begin + 16, words, ' text-anchor="middle"'))
    for words, y in up.ticks().items():
        found.append(rule(across.begin, y, across.end, y))
        found.append(text(across.begin - 6, y + 4, words, ' text-anchor="end"'))
    middle = (across.begin + across.end) / 2, (up.begin + up.end) / 2
    turned = f' text-anchor="middle" transform="rotate(-90 14 {middle[1]:.1f})"'
    found.append(text(middle[0], HEIGHT - 8, escape(labels[0]), ' text-anchor="middle"'))
    found.append(text(14, middle[1], escape(labels[1]), turned))
    return found


def drawn(points: Points, across: Axis, up: Axis, colour: str) -> list[str]:
    """A line through points, each of them marked."""
    places = [(across.at(x), up.at(y)) for x, y in points]
    way = "L".join(f"{x:.1f} {y:.1f}" for x, y in places)
    dots = [f'<circle cx="{x:.1f}" cy="{y:.1f}" r="2.6" fill="{colour}"/>' for x, y in places]
    return [f'<path d="M{way}" fill="none" stroke="{colour}" stroke-width="1.6"/>', *dots]


def figure(lines: Line, labels: tuple[str, str], linear: bool = False) -> str:
    """An SVG of lines, each with its name beside the drawing; `linear` of the axis upwards."""
    every = [point for points in lines.values() for point in points]
    across = logarithmic([x for x, _ in every], LEFT, WIDTH - RIGHT)
    values = [y for _, y in every]
    if linear:
        up: Axis = Linear(math.floor(max(values)) + 1, HEIGHT - BOTTOM, TOP)
    else:
        up = logarithmic(values, HEIGHT - BOTTOM, TOP)
    found = frame(across, up, labels)
    for i, (name, points) in enumerate(lines.items()):
        colour, y = COLOURS[i % len(COLOURS)], TOP + 10 + 17 * i
        found += drawn(points, across, up, colour)
        found.append(f'<circle cx="{WIDTH - RIGHT + 14}" cy="{y - 4}" r="3.2" fill="{colour}"/>')
        found.append(text(WIDTH - RIGHT + 22, y, escape(name)))
    head = (
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {HEIGHT}" '
        f'width="{WIDTH}" height="{HEIGHT}" role="img">'
    )
    return "\n".join([head, '<rect width="100%" height="100%" fill="white"/>', *found, "</svg>", ""])


# ---------------------------------------------------------------- what is drawn


def against_runs(tables: Mapping[str, Sequence[Table]], column: str) -> Line:
    """Points of a column over the number of runs, of sweeps and of bare lanes."""
    found: dict[str, Points] = {}
    for name, part in {"sweep into a store": "sweep", "C lanes alone": "batches"}.items():
        for table in tables.get(part, ()):
            if "memory" in table.rows[0]:
                found[name] = [(row["runs"], row[column]) for row in table.rows if row[column]]
    return found


def cost(tables: Mapping[str, Sequence[Table]]) -> str | None:
    """Cost of a run against the number of runs."""
    lines = against_runs(tables, "ratio")
    return figure(lines, ("runs", "CPU time of a run, relative")) if lines else None


def memory(tables: Mapping[str, Sequence[Table]]) -> str | None:
    """Peak memory against the number of runs."""
    lines = against_runs(tables, "memory")
    return figure(lines, ("runs", "peak memory, relative"), True) if lines else None


def throughput(tables: Mapping[str, Sequence[Table]]) -> str | None:
    """Runs per second of each engine on the wire, at its first setting, against the batch."""
    lines: dict[str, list[tuple[float, float]]] = {}
    for table in tables.get("batches", ()):
        if "coupled wire" in table.title and "rate" in table.rows[0]:
            size = float(table.title.rsplit(" ", 1)[1])
            rates = {row["engine"]: row["rate"] for row in reversed(table.rows)}
            for name in dict.fromkeys(row["engine"] for row in table.rows):
                lines.setdefault(name, []).append((size, rates[name]))
    return figure(lines, ("runs in a batch", "runs per second, relative")) if lines else None


FIGURES: dict[str, Callable[[Mapping[str, Sequence[Table]]], str | None]] = {
    "cost": cost,
    "memory": memory,
    "throughput": throughput,
}
