"""Chains in C: simulation and derivatives of all columns in one pass, block after block.

Samples go through in tiles that stay in the cache, columns of derivatives as rows of a tile. A
block without memory is evaluated for a whole tile at once, its own columns as they come. One with
memory goes sample by sample: first its values with the partial derivatives of every sample, then
the columns, several at a time, which need a tile laid out the other way (`native_columns`).
"""

from __future__ import annotations

import ctypes
from typing import Any

import numpy as np

from martensite.identify.blocks.base import Numbers
from martensite.identify.chains.native_columns import (
    TILE,
    columns_at_once,
    columns_in_sequence,
    room,
)
from martensite.identify.chains.plan import Piece, Plan
from martensite.runtimes.c99 import c_source, load_library
from martensite.runtimes.once import once

Taps = tuple[tuple[int, int], ...]
"""What is given out: numbers of blocks, and of their outputs."""


class Native:
    """The compiled functions of a plan. Arrays are C-ordered; states are changed in place."""

    def __init__(self, plan: Plan, taps: Taps) -> None:
        self._plan, self._taps, self._width = plan, taps, plan.width
        self._library = _library(plan, taps, False)
        self._with_slopes: dict[int, tuple[Any, int]] = {}

    def rest(self, p: Numbers, x: Numbers, s: Numbers, ds: Numbers) -> None:
        """State at rest under constant inputs x, with its derivatives (states, columns)."""
        self._library.rest(_at(p), _at(x), _at(s), _at(ds))

    def run(self, p: Numbers, u: Numbers, s: Numbers, y: Numbers) -> None:
        """Simulate inputs u (samples, inputs) from a state, into y (samples, outputs)."""
        self._library.run(ctypes.c_long(len(u)), _at(p), _at(u), _at(s), _at(y))

    def slopes(
        self, p: Numbers, u: Numbers, s: Numbers, ds: Numbers, y: Numbers, dy: Numbers
    ) -> None:
        """The same with derivatives: dy is (samples, outputs, extra + columns).

        The first columns are those of the initial state; there are as many as ds has beyond
        those of the free numbers. Samples of dy must be next to each other.
        """
        columns = ds.shape[1]
        if columns not in self._with_slopes:
            library = _library(self._plan, self._taps, columns > self._plan.columns)
            self._with_slopes[columns] = library.slopes, scratch_size(self._plan, columns)
        slopes, size = self._with_slopes[columns]
        scratch = _aligned(size)
        slopes(
            ctypes.c_long(len(u)), _at(p), _at(u), _at(s), _at(ds), _at(scratch), _at(y), _at(dy),
            ctypes.c_long(dy.strides[2] // 8),
        )  # fmt: skip


def _aligned(count: int) -> Numbers:
    """Uninitialised numbers from the start of a cache line."""
    room = np.empty(count + 8)
    first = -room.ctypes.data % 64 // 8
    return room[first : first + count]


def scratch_size(plan: Plan, columns: int) -> int:
    """Numbers that `slopes` needs room for: one tile of signals, and that of the widest block."""
    wide = [room(piece, columns - plan.columns) for piece in plan.pieces if piece.block.states()]
    return plan.width * TILE * columns + max(wide, default=0)


def _at(array: Numbers) -> ctypes.c_void_p:
    return ctypes.c_void_p(array.ctypes.data)


@once(64)
def _library(plan: Plan, taps: Taps, extra: bool) -> Any:
    return load_library(chain_source(plan, taps, extra))


def chain_source(plan: Plan, taps: Taps, extra: bool) -> str:
    """C of `rest`, `run` and `slopes`, with `extra` columns for the initial state or without."""
    functions = list(plan.program.functions.values())
    columns = plan.columns + plan.states * extra
    parts = [
        c_source(plan.program, functions, alike=True),
        f"enum {{ TILE = {TILE}, M = {columns} }};\n",
    ]
    parts += [_block(piece, k, plan, slopes) for k, piece in enumerate(plan.pieces)
              for slopes in (False, True)]  # fmt: skip
    parts += [_rest(plan), _march(plan, taps, False), _march(plan, taps, True)]
    return "\n".join(parts)


def _march(plan: Plan, taps: Taps, slopes: bool) -> str:
    """The loop over tiles. Signals are w[WIDTH][TILE], their columns dw[WIDTH][TILE][m]."""
    width, outputs, inputs = plan.width, len(taps), plan.pieces[0].block.inputs
    name = "slopes" if slopes else "run"
    more = "double *restrict ds, " if slopes else ""
    last = "double *restrict dw, double *restrict y, double *restrict dy, long stride"
    last = last if slopes else "double *restrict y"
    body: list[str] = []
    state = 0
    for k, piece in enumerate(plan.pieces):
        tail = f", ds + {state} * M, dw, dw + {width} * TILE * M" if slopes else ""
        body.append(f"block{k}{'d' if slopes else ''}(n, c, w, s + {state}{tail});")
        state += piece.block.states()
        for place, (number, channel) in enumerate(taps):
            if number == k:
                body += _tapped(place, channel, outputs, piece, plan.columns, slopes)
    steps = "".join(f"        {line}\n" for line in body)
    zeros = ""
    if slopes:  # of the inputs, with respect to the initial state
        extra = f"sizeof(double) * TILE * (M - {plan.columns})"
        zeros = (
            f"        for (long i = 0; i < {inputs}; i++)\n"
            f"            memset(dw + i * M * TILE, 0, {extra});\n"
        )
    onward = f"y += n * {outputs};" + (" dy += n;" if slopes else "")
    return (
        f"void {name}(long samples, const double *restrict p, const double *restrict u,\n"
        f"            double *restrict s, {more}{last}) {{\n"
        f"    double c[{_constants(plan)}], w[{width} * TILE];\n    k_prepare(1, p, c);\n"
        "    for (long done = 0; done < samples; done += TILE) {\n"
        "        const long n = samples - done < TILE ? samples - done : TILE;\n"
        f"        for (long t = 0; t < n; t++) for (long i = 0; i < {inputs}; i++)\n"
        f"            w[i * TILE + t] = u[t * {inputs} + i];\n"
        f"        u += n * {inputs};\n{zeros}{steps}        {onward}\n    }}\n}}\n"
    )


def _tapped(
    place: int, channel: int, outputs: int, piece: Piece, columns: int, slopes: bool
) -> list[str]:
    """Copy one signal to the outputs, with zeros for what comes later in the chain."""
    lines = [f"for (long t = 0; t < n; t++) y[t * {outputs} + {place}] = w[{channel} * TILE + t];"]
    if slopes:
        known = f"(M - {columns - piece.first - piece.count})"
        row = f"dy + ({place} * M + q) * stride"
        lines += [
            f"for (long q = 0; q < {known}; q++)",
            f"    memcpy({row}, dw + ({channel} * M + q) * TILE, sizeof(double) * n);",
            f"for (long q = {known}; q < M; q++) memset({row}, 0, sizeof(double) * n);",
        ]
    return lines


def _block(piece: Piece, k: int, plan: Plan, slopes: bool) -> str:
    """One block over a tile; without memory for all samples at once."""
    states = piece.block.states()
    arguments = ", double *restrict ds, double *restrict dw, double *restrict z" if slopes else ""
    lines = _sequential(piece, slopes) if states else _at_once(piece, slopes)
    below = plan.columns - piece.first
    known = f"    enum {{ lo = M - {below}, count = {piece.count} }};\n" if slopes else ""
    unused = "    (void)s;\n" + ("    (void)ds; (void)z;\n" if slopes and not states else "")
    body = "".join(f"    {line}\n" for line in lines)
    return (
        f"static void block{k}{'d' if slopes else ''}(long n, const double *restrict c, "
        f"double *restrict w, double *restrict s{arguments}) {{\n"
        f"{known}{unused}{body}}}\n"
    )


def _at_once(piece: Piece, slopes: bool) -> list[str]:
    block, traced = piece.block, piece.step
    results = traced.rows + (len(traced.entries) if slopes else 0)
    name = traced.name if slopes else f"v{traced.name}"
    lines = [f"double x[{block.inputs} * TILE], y[{results} * TILE];"]
    lines += [f"for (long l = 0; l < n; l++) x[{i} * n + l] = w[{i} * TILE + l];"
              for i in range(block.inputs)]  # fmt: skip
    lines.append(f"k_{name}(n, c, x, y);")
    lines += [f"for (long l = 0; l < n; l++) w[{i} * TILE + l] = y[{i} * n + l];"
              for i in range(block.outputs)]  # fmt: skip
    return lines + (columns_at_once(piece) if slopes else [])


def _sequential(piece: Piece, slopes: bool) -> list[str]:
    """Sample by sample, the state in local variables meanwhile."""
    block, traced = piece.block, piece.step
    states = block.states()
    results = traced.rows + (len(traced.entries) if slopes else 0)
    name = traced.name if slopes else f"v{traced.name}"
    before, after = columns_in_sequence(piece) if slopes else ([], [])
    kept = [line for line in before if line.startswith("    ")]
    return [
        *(line for line in before if not line.startswith("    ")),
        f"double x[{block.inputs + states}], y[{results}];",
        f"memcpy(x + {block.inputs}, s, sizeof(double) * {states});",
        "for (long t = 0; t < n; t++) {",
        *(f"    x[{i}] = w[{i} * TILE + t];" for i in range(block.inputs)),
        f"    k_{name}(1, c, x, y);",
        *(f"    w[{i} * TILE + t] = y[{i}];" for i in range(block.outputs)),
        *(f"    x[{block.inputs + i}] = y[{block.outputs + i}];" for i in range(states)),
        *kept,
        "}",
        f"memcpy(s, x + {block.inputs}, sizeof(double) * {states});",
        *after,
    ]


def _constants(plan: Plan) -> int:
    return max(len(plan.program.hoisted), 1)


def _rest(plan: Plan) -> str:
    """The chain at rest: each block under what the block before gives at rest."""
    m = plan.columns
    lines = [
        f"double c[{_constants(plan)}];",
        f"double w[{plan.width}], z[{plan.width}], dw[{plan.width} * {m} + 1];",
        f"double dz[{plan.width} * {m} + 1];",
        "k_prepare(1, p, c);",
        f"memset(dw, 0, sizeof(dw)); memset(ds, 0, sizeof(double) * {plan.states} * {m});",
        f"memcpy(w, x, sizeof(double) * {plan.pieces[0].block.inputs});",
    ]
    state = 0
    for piece in plan.pieces:
        lines += ["{", *(f"    {line}" for line in _rested(piece, state, m)), "}"]
        state += piece.block.states()
    body = "".join(f"    {line}\n" for line in lines)
    return (
        "void rest(const double *p, const double *x, double *s, double *ds) {\n"
        f"{body}    (void)z; (void)dz;\n}}\n"
    )


def _rested(piece: Piece, state: int, m: int) -> list[str]:
    """Rest of one block, then its output in that state."""
    block, rest, step = piece.block, piece.rest, piece.step
    inputs, states = block.inputs, block.states()
    total = max(rest.rows + len(rest.entries), step.rows + len(step.entries), 1)
    lines = [f"double in[{inputs + states}], y[{total}];"]
    lines.append(f"memcpy(in, w, sizeof(double) * {inputs});")
    if states:
        lines += [f"k_{rest.name}(1, c, in, y);"]
        lines += [f"memcpy(s + {state}, y, sizeof(double) * {states});"]
        for e in rest.entries:
            target = f"ds[{state + e.row} * {m}"
            if e.column < inputs:
                source = f"dw[{e.column} * {m} + q]"
                lines.append(
                    f"for (long q = 0; q < {piece.first}; q++) "
                    f"{target} + q] += y[{e.place}] * {source};"
                )
            else:
                lines.append(f"{target} + {piece.first + e.column - inputs}] += y[{e.place}];")
        lines.append(f"memcpy(in + {inputs}, s + {state}, sizeof(double) * {states});")
    lines += [f"k_{step.name}(1, c, in, y);", "memset(dz, 0, sizeof(dz));"]
    for e in (e for e in step.entries if e.row < block.outputs):
        target = f"dz[{e.row} * {m}"
        known = piece.first + piece.count
        if e.column < inputs:
            lines.append(f"for (long q = 0; q < {known}; q++) "
                         f"{target} + q] += y[{e.place}] * dw[{e.column} * {m} + q];")  # fmt: skip
        elif e.column < inputs + states:
            source = f"ds[{state + e.column - inputs} * {m} + q]"
            lines.append(
                f"for (long q = 0; q < {known}; q++) {target} + q] += y[{e.place}] * {source};"
            )
        else:
            column = piece.first + e.column - inputs - states
            lines.append(f"{target} + {column}] += y[{e.place}];")
    lines += [f"memcpy(w, y, sizeof(double) * {block.outputs});", "memcpy(dw, dz, sizeof(dw));"]
    return lines
