"""C of the columns of derivatives: how those of a block follow from those of its inputs.

A tile holds dw[signal][column][sample]. Blocks without memory multiply rows of it. Blocks with
memory carry the columns of their state from sample to sample; there several columns go together,
as z[sample][signal][column], padded to whole vectors. The columns of what comes before the block
enter through its inputs, its own through partial derivatives that are laid out beforehand.
"""

from __future__ import annotations

from collections.abc import Sequence

from martensite.identify.chains.plan import Entry, Piece

TILE = 64
"""Samples that go through all blocks together."""
LANES = 8
"""Columns are padded to a multiple of these."""


def padded(columns: int) -> int:
    """Columns with their padding."""
    return -(-max(columns, 1) // LANES) * LANES


def room(piece: Piece, extra: int) -> int:
    """Numbers that a block with memory needs beside the tile."""
    block = piece.block
    signals, rows = max(block.inputs, block.outputs), 2 * block.outputs + block.states()
    return TILE * (signals * padded(piece.first + extra) + rows * padded(piece.count))


def columns_at_once(piece: Piece) -> list[str]:
    """All columns of a block without memory; y holds results and derivatives of the tile."""
    block, entries = piece.block, piece.step.entries
    inputs, outputs = range(block.inputs), range(block.outputs)
    through = [e for e in entries if e.column < block.inputs]
    values = {e.place: f"y[{e.place} * n + t]" for e in through}
    lines = [
        "for (long q = 0; q < lo; q++) {",
        "    double *restrict d = dw + q * TILE;",
        "    #pragma omp simd",
        "    for (long t = 0; t < n; t++) {",
        *(f"        const double q{i} = d[{i} * M * TILE + t];" for i in inputs
          if any(e.column == i for e in through)),
        *(f"        d[{row} * M * TILE + t] = {_sum(row, through, values)};" for row in outputs),
        "    }",
        "}",
    ]  # fmt: skip
    own = {(e.row, e.column - block.inputs): e.place for e in entries if e.column >= block.inputs}
    for row in outputs:
        for column in range(piece.count):
            target, size = f"dw + ({row} * M + lo + {column}) * TILE", "sizeof(double) * n"
            place = own.get((row, column))
            lines.append(f"memset({target}, 0, {size});" if place is None
                         else f"memcpy({target}, y + {place} * n, {size});")  # fmt: skip
    return lines


def columns_in_sequence(piece: Piece) -> tuple[list[str], list[str]]:
    """C around the loop over samples of a block with memory: before it, and after it.

    Of the lines before it, the indented ones belong into the loop: they keep y.
    """
    block, entries = piece.block, piece.step.entries
    moving = block.inputs + block.states()
    through = [e for e in entries if e.column < moving]
    own = [e for e in entries if e.column >= moving]
    rows = sorted({e.row for e in own})
    varying = [e for e in through if not e.constant]
    before = [
        f"enum {{ LP = lo ? (lo + {LANES - 1}) / {LANES} * {LANES} : {LANES}, "
        f"CP = {padded(piece.count)} }};",
        f"double j[{max(len(varying), 1)}][TILE];",
        "(void)j;",
        f"double *restrict o = z + TILE * {max(block.inputs, block.outputs)} * LP;",
        f"memset(o, 0, sizeof(double) * TILE * {max(len(rows), 1)} * CP);",
        *(f"    j[{k}][t] = y[{e.place}];" for k, e in enumerate(varying)),
        *(f"    o[(t * {max(len(rows), 1)} + {rows.index(e.row)}) * CP + {e.column - moving}] "
          f"= y[{e.place}];" for e in own),
    ]  # fmt: skip
    after = [f"const double k{e.place} = y[{e.place}];" for e in through if e.constant]
    return before, [*after, *_earlier(piece, through), *_own(piece, through, rows)]


def _through(piece: Piece) -> list[Entry]:
    """The partial derivatives with respect to inputs and states."""
    moving = piece.block.inputs + piece.block.states()
    return [e for e in piece.step.entries if e.column < moving]


def _values(through: Sequence[Entry]) -> dict[int, str]:
    """What the partial derivatives are called in the loop over samples."""
    varying = [e.place for e in through if not e.constant]
    names = {e.place: f"k{e.place}" for e in through if e.constant}
    return names | {place: f"j[{k}][t]" for k, place in enumerate(varying)}


def _sum(row: int, entries: Sequence[Entry], values: dict[int, str]) -> str:
    terms = [f"{values[e.place]} * q{e.column}" for e in entries if e.row == row]
    return " + ".join(terms) or "0.0"


def _earlier(piece: Piece, through: Sequence[Entry]) -> list[str]:
    """Columns of the blocks before: their tile turned, run through, and turned back."""
    block = piece.block
    inputs, outputs = block.inputs, block.outputs
    signals = max(inputs, outputs)

    def turned(count: int, body: str) -> list[str]:
        return [f"for (long i = 0; i < {count}; i++) for (long q = 0; q < lo; q++)",
                "    for (long t = 0; t < n; t++)", f"        {body}"]  # fmt: skip

    at, tile = f"z[(t * {signals} + i) * LP + q]", "dw[(i * M + q) * TILE + t]"
    reads = {i: f"z[(t * {signals} + {i}) * LP + q]" for i in range(inputs)}
    writes = [f"z[(t * {signals} + {i}) * LP + q]" for i in range(outputs)]
    return [
        "if (lo > 0) {",
        f"    memset(z, 0, sizeof(double) * TILE * {signals} * LP);",
        *(f"    {line}" for line in turned(inputs, f"{at} = {tile};")),
        *(f"    {line}" for line in _carried(piece, through, "0", "lo", "LP", reads, writes, {})),
        *(f"    {line}" for line in turned(outputs, f"{tile} = {at};")),
        "}",
    ]


def _own(piece: Piece, through: Sequence[Entry], rows: list[int]) -> list[str]:
    """Columns of the free numbers of the block itself."""
    block = piece.block
    if not piece.count:
        return []
    kept = max(len(rows), 1)
    begun = {row: f"o[(t * {kept} + {k}) * CP + q]" for k, row in enumerate(rows)}
    held = [e for e in through if e.column >= block.inputs]
    given = [f"g[({i} * TILE + t) * CP + q]" for i in range(block.outputs)]
    turned = [
        f"for (long i = 0; i < {block.outputs}; i++) for (long q = 0; q < count; q++)",
        "    for (long t = 0; t < n; t++)",
        "        dw[(i * M + lo + q) * TILE + t] = g[(i * TILE + t) * CP + q];",
    ]
    return [
        "{",
        f"    double *restrict g = o + TILE * {kept} * CP;",
        *(f"    {line}" for line in _carried(piece, held, "lo", "count", "CP", {}, given, begun)),
        *(f"    {line}" for line in turned),
        "}",
    ]


def _carried(
    piece: Piece, entries: Sequence[Entry], first: str, count: str, lanes: str,
    reads: dict[int, str], writes: Sequence[str], begun: dict[int, str],
) -> list[str]:  # fmt: skip
    """Some columns of the state through all samples; all are read before any is written."""
    block, values = piece.block, _values(_through(piece))
    inputs, outputs, states = block.inputs, block.outputs, block.states()
    places = reads | {inputs + k: f"e[{k}][q]" for k in range(states)}
    targets = {**dict(enumerate(writes)), **{outputs + k: f"e[{k}][q]" for k in range(states)}}
    used = sorted({e.column for e in entries})
    lines = [f"const double q{c} = {places[c]};" for c in used]
    for row in range(outputs + states):
        text = _sum(row, entries, values)
        if row in begun:
            text = begun[row] if text == "0.0" else f"{begun[row]} + {text}"
        lines.append(f"{targets[row]} = {text};")
    copied = f"sizeof(double) * {count}"
    return [
        f"double e[{states}][{lanes}];",
        "memset(e, 0, sizeof(e));",
        f"for (long i = 0; i < {states}; i++) memcpy(e[i], ds + i * M + {first}, {copied});",
        "for (long t = 0; t < n; t++) {",
        "    #pragma omp simd",
        f"    for (long q = 0; q < {lanes}; q++) {{",
        *(f"        {line}" for line in lines),
        "    }",
        "}",
        f"for (long i = 0; i < {states}; i++) memcpy(ds + i * M + {first}, e[i], {copied});",
    ]
