"""C code of the columns of derivatives: from the columns of the inputs of a block to its own.

A tile holds dw[signal][column][sample]. Blocks without memory multiply rows of it. Blocks with memory carry the columns
of their state from sample to sample, several columns together as z[sample][signal][column], padded to whole vectors.
Columns of earlier blocks enter through the inputs, own columns through precomputed partial derivatives.

A block writes its columns to `to`, rows `stride` numbers apart: the tile or the final place. Tiles are always computed
in full.
"""

from __future__ import annotations

from collections.abc import Sequence

from martensite.identify.chains.plan import ChainPiece, Entry

TILE = 64
"""Samples that pass all blocks together."""
LANES = 8
"""Unit of the padding of columns."""


def pad_count(count: int, unit: int = LANES) -> int:
    """Return the next multiple of a unit, at least one."""
    return -(-max(count, 1) // unit) * unit


def count_room(piece: ChainPiece, extra: int) -> int:
    """Return the size of the zeroed work space of a block, in addition to the tile."""
    block = piece.block
    if not block.states():
        return 0
    signals, rows = max(block.inputs, block.outputs), block.outputs + _count_direct(piece)
    return TILE * (signals * pad_count(piece.first + extra) + rows * pad_count(piece.count))


def list_moving(piece: ChainPiece) -> int:
    """Return the number of columns of partial derivatives for inputs and states."""
    return piece.block.inputs + piece.block.states()


def list_through(piece: ChainPiece) -> list[Entry]:
    """Return the partial derivatives by inputs and states."""
    return [e for e in piece.step.entries if e.column < list_moving(piece)]


def list_own(piece: ChainPiece) -> list[Entry]:
    """Return the partial derivatives by free numbers."""
    return [e for e in piece.step.entries if e.column >= list_moving(piece)]


def _count_direct(piece: ChainPiece) -> int:
    """Return the number of outputs and states that depend directly on free numbers."""
    return max(len({e.row for e in list_own(piece)}), 1)


def at_once(piece: ChainPiece, results: Sequence[str]) -> tuple[list[str], list[str], list[str]]:
    """Return the code of a block without memory: before, in, and after its loop over samples."""
    block, entries = piece.block, list_through(piece)
    values = {e.place: f"j[{k}][t]" for k, e in enumerate(entries)}
    inside = [f"{values[e.place]} = {results[e.place]};" for e in entries]
    inside += [
        f"to[({e.row} * M + lo + {e.column - list_moving(piece)}) * stride + t] = {results[e.place]};"
        for e in list_own(piece)
    ]
    written = {(e.row, e.column - list_moving(piece)) for e in list_own(piece)}
    zeros = [(r, c) for r in range(block.outputs) for c in range(piece.count)]
    lines = [
        "for (long q = 0; q < lo; q++) {",
        "    #pragma omp simd",
        "    for (long t = 0; t < TILE; t++) {",
        *(f"        const double q{i} = dw[({i} * M + q) * TILE + t];" for i in sorted({e.column for e in entries})),
        *(
            f"        to[({row} * M + q) * stride + t] = {_print_sum(row, entries, values)};"
            for row in range(block.outputs)
        ),
        "    }",
        "}",
        *(
            f"memset(to + ({row} * M + lo + {column}) * stride, 0, sizeof(double) * TILE);"
            for row, column in zeros
            if (row, column) not in written
        ),
    ]
    return [f"double j[{max(len(entries), 1)}][TILE];", "(void)j;"], inside, lines


def in_sequence(piece: ChainPiece, results: Sequence[str]) -> tuple[list[str], list[str], list[str]]:
    """Return the code of a block with memory: before, in, and after its loop over samples."""
    block = piece.block
    varying = [e for e in list_through(piece) if not e.constant]
    rows = sorted({e.row for e in list_own(piece)})
    signals, direct = max(block.inputs, block.outputs), _count_direct(piece)
    before = [
        f"enum {{ LP = lo ? (lo + {LANES - 1}) / {LANES} * {LANES} : {LANES}, CP = {pad_count(piece.count)} }};",
        f"double j[{max(len(varying), 1)}][TILE];",
        "(void)j;",
        f"double *restrict o = z + TILE * {signals} * LP, *restrict g = o + TILE * {direct} * CP;",
    ]
    inside = [f"j[{k}][t] = {results[e.place]};" for k, e in enumerate(varying)]
    inside += [
        f"o[(t * {direct} + {rows.index(e.row)}) * CP + {e.column - list_moving(piece)}] = {results[e.place]};"
        for e in list_own(piece)
    ]
    values = {e.place: f"j[{k}][t]" for k, e in enumerate(varying)}
    values |= {e.place: results[e.place] for e in list_through(piece) if e.constant}
    return before, inside, _print_carried(piece, values, rows)


def _print_carried(piece: ChainPiece, values: dict[int, str], rows: list[int]) -> list[str]:
    """Return the code of all columns of a tile: earlier ones as e, own ones as f."""
    block, entries, direct = piece.block, list_through(piece), _count_direct(piece)
    inputs, outputs, states = block.inputs, block.outputs, block.states()
    signals = max(inputs, outputs)
    reads = {i: f"z[(t * {signals} + {i}) * LP + q]" for i in range(inputs)}
    writes = [f"z[(t * {signals} + {i}) * LP + q]" for i in range(outputs)]
    own_writes = [f"g[(t * {outputs} + {i}) * CP + q]" for i in range(outputs)]
    first = {row: f"o[(t * {direct} + {k}) * CP + q]" for k, row in enumerate(rows)}
    state_entries = [e for e in entries if e.column >= inputs]
    lines = [
        *_print_turned(inputs, "lo", f"z[(t * {signals} + i) * LP + q] = dw[(i * M + q) * TILE + t];"),
        f"double e[{states}][LP], f[{states}][CP];",
        "memset(e, 0, sizeof(e)); memset(f, 0, sizeof(f));",
        *_print_moved(states, "e[i]", "ds + i * M", "lo"),
        *_print_moved(states, "f[i]", "ds + i * M + lo", "count"),
        "for (long t = 0; t < n; t++) {",
        "    if (lo > 0) {",
        *_print_columns("LP", _print_rows(piece, entries, values, reads, writes, {}, "e")),
        "    }",
        "    if (count > 0) {",
        *_print_columns("CP", _print_rows(piece, state_entries, values, {}, own_writes, first, "f")),
        "    }",
        "}",
        *_print_moved(states, "ds + i * M", "e[i]", "lo"),
        *_print_moved(states, "ds + i * M + lo", "f[i]", "count"),
    ]
    back = f"to[(i * M + q) * stride + t] = z[(t * {signals} + i) * LP + q];"
    mine = f"to[(i * M + lo + q) * stride + t] = g[(t * {outputs} + i) * CP + q];"
    return [*lines, *_print_turned(outputs, "lo", back), *_print_turned(outputs, "count", mine)]


def _print_turned(signals: int, columns: str, body: str) -> list[str]:
    return [
        f"for (long i = 0; i < {signals}; i++) for (long q = 0; q < {columns}; q++)",
        "    for (long t = 0; t < TILE; t++)",
        f"        {body}",
    ]


def _print_moved(states: int, target: str, source: str, count: str) -> list[str]:
    return [f"for (long i = 0; i < {states}; i++) memcpy({target}, {source}, sizeof(double) * {count});"]


def _print_columns(lanes: str, body: Sequence[str]) -> list[str]:
    return [
        "        #pragma omp simd",
        f"        for (long q = 0; q < {lanes}; q++) {{",
        *(f"            {line}" for line in body),
        "        }",
    ]


def _print_rows(
    piece: ChainPiece,
    entries: Sequence[Entry],
    values: dict[int, str],
    reads: dict[int, str],
    writes: Sequence[str],
    first_terms: dict[int, str],
    state: str,
) -> list[str]:
    """Return the code of one sample of some columns; all are read before any is written."""
    inputs, states = piece.block.inputs, piece.block.states()
    states_of = [f"{state}[{k}][q]" for k in range(states)]
    places = reads | {inputs + k: place for k, place in enumerate(states_of)}
    lines = [f"const double q{c} = {places[c]};" for c in sorted({e.column for e in entries})]
    for row, target in enumerate([*writes, *states_of]):
        text = _print_sum(row, entries, values)
        if row in first_terms:
            text = first_terms[row] if text == "0.0" else f"{first_terms[row]} + {text}"
        lines.append(f"{target} = {text};")
    return lines


def _print_sum(row: int, entries: Sequence[Entry], values: dict[int, str]) -> str:
    terms = [f"{values[e.place]} * q{e.column}" for e in entries if e.row == row]
    return " + ".join(terms) or "0.0"
