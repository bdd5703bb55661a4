"""C code of a chain: its steady state, its simulation, and both with derivatives.

Samples pass in tiles that stay in the cache, columns of derivatives are rows of a tile. A block without memory is
evaluated for a whole tile. A block with memory is evaluated sample by sample: first values and partial derivatives,
then the columns, for which the tile is transposed (`native_columns`).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from martensite.identify.chains.native_columns import TILE, at_once, count_room, in_sequence
from martensite.identify.chains.plan import ChainPiece, ChainPlan
from martensite.kernels.c99 import C_DIALECT, write_prelude
from martensite.kernels.kernel_printer import KernelPrinter, Statements

Taps = tuple[tuple[int, int], ...]


def chain_source(plan: ChainPlan, taps: Taps, extra: bool) -> str:
    """Return the C code of `rest`, `run` and `slopes`; of `slopes` alone with `extra` columns for the state."""
    columns = plan.columns + plan.states * extra
    writer = _Writer(plan, taps, columns, KernelPrinter(plan.program, C_DIALECT))
    parts = [write_prelude(), f"enum {{ TILE = {TILE}, M = {columns} }};\n", writer.prepare()]
    numbers = range(len(plan.pieces))
    if not extra:
        parts += [*(writer.block(k, False) for k in numbers), writer.march(False)]
    parts += [*(writer.block(k, True) for k in numbers), writer.march(True)]
    return "\n".join([*parts, *([] if extra else [writer.rest()])])


@dataclass(frozen=True)
class _Writer:
    """Functions of one chain; `columns` is M, including the initial state."""

    plan: ChainPlan
    taps: Taps
    columns: int
    kernels: KernelPrinter

    @property
    def direct(self) -> bool:
        """Return whether all outputs belong to the last block, which then writes them directly."""
        last = len(self.plan.pieces) - 1
        return self.taps == tuple((last, i) for i in range(self.plan.pieces[last].block.outputs))

    def prepare(self) -> str:
        """Return `prepare(p, c)`, a long list of assignments that must not be inlined."""
        statements = self.kernels.prepare
        return _print_function(
            "static __attribute__((noinline)) void prepare(\n    const double *restrict p, double *restrict c)",
            [*statements.lines, *(f"c[{i}] = {value};" for i, value in enumerate(statements.results))],
        )

    def statements(self, name: str) -> Statements:
        """Return a function over its inputs x0, x1, … and its state s0, s1, …."""
        function = self.plan.program.functions[name]
        return self.kernels.print_function(function, function.inputs)

    def block(self, k: int, slopes: bool) -> str:
        """Return one block over a tile of signals w[signal][TILE], which it replaces."""
        piece = self.plan.pieces[k]
        named = self.statements(piece.step.name if slopes else f"v{piece.step.name}")
        before, inside, after = list[str](), list[str](), list[str]()
        if slopes:
            make = in_sequence if piece.block.states() else at_once
            before, inside, after = make(piece, named.results)
        last = slopes and self.direct and k == len(self.plan.pieces) - 1
        tail = ", double *restrict ds, double *restrict dw, double *restrict z" if slopes else ""
        tail += ", double *restrict to, const long stride" if last else ""
        head = (
            [
                f"enum {{ lo = M - {self.plan.columns - piece.first}, count = {piece.count} }};",
                "(void)ds; (void)dw; (void)z;",
            ]
            if slopes
            else []
        )
        head += ["enum { stride = TILE };", "double *const to = dw;"] if slopes and not last else []
        head += ["(void)to;"] if slopes else []
        lines = [*head, *before, *_print_loop(piece, named.lines, named.results, inside, slopes), *after]
        return _print_function(
            f"static void block{k}{'d' if slopes else ''}(long n, const double *restrict c,\n"
            f"    double *restrict w, double *restrict s{tail})",
            ["(void)n; (void)c; (void)s;", *lines],
        )

    def march(self, slopes: bool) -> str:
        """Return the loop over tiles; the columns of signals are dw[signal][M][TILE]."""
        plan, inputs = self.plan, self.plan.pieces[0].block.inputs
        state, offset, steps = 0, 0, list[str]()
        for k, piece in enumerate(plan.pieces):
            tail = f", ds + {state} * M, dw, z + {offset}" if slopes else ""
            last = slopes and self.direct and k == len(plan.pieces) - 1
            tail += ", dy, stride" if last else ""
            steps.append(f"block{k}{'d' if slopes else ''}(n, c, w, s + {state}{tail});")
            state += piece.block.states()
            offset += count_room(piece, self.columns - plan.columns)
            steps += self._write_taps(k, slopes and not last)
        zeros = f"memset(dw + i * M * TILE, 0, sizeof(double) * TILE * (M - {plan.columns}));"
        scratch = [f"double *restrict z = dw + {plan.width} * TILE * M;"] if slopes else []
        lines = [
            f"double c[{self.plan.program.constants}], w[{plan.width} * TILE] = {{0.0}};",
            *scratch,
            "prepare(p, c);",
            "for (long done = 0; done < samples; done += TILE) {",
            "    const long n = samples - done < TILE ? samples - done : TILE;",
            f"    for (long t = 0; t < n; t++) for (long i = 0; i < {inputs}; i++)",
            f"        w[i * TILE + t] = u[t * {inputs} + i];",
            *([f"    for (long i = 0; i < {inputs}; i++) {zeros}"] if slopes else []),
            *(f"    {line}" for line in steps),
            f"    u += n * {inputs}; y += n * {len(self.taps)};{' dy += n;' if slopes else ''}",
            "}",
        ]
        more = "double *restrict ds, double *restrict dw, " if slopes else ""
        tail = ", double *restrict dy, long stride" if slopes else ""
        name = "slopes" if slopes else "run"
        return _print_function(
            f"void {name}(long samples, const double *restrict p, const double *restrict u,\n"
            f"    double *restrict s, {more}double *restrict y{tail})",
            lines,
        )

    def _write_taps(self, k: int, slopes: bool) -> list[str]:
        piece, count, lines = self.plan.pieces[k], len(self.taps), list[str]()
        columns = f"(M - {self.plan.columns - piece.first - piece.count})"
        for place, channel in ((i, tap[1]) for i, tap in enumerate(self.taps) if tap[0] == k):
            lines.append(f"for (long t = 0; t < n; t++) y[t * {count} + {place}] = w[{channel} * TILE + t];")
            row, size = f"dy + ({place} * M + q) * stride", "sizeof(double) * TILE"
            if slopes:
                lines += [
                    f"for (long q = 0; q < {columns}; q++)",
                    f"    memcpy({row}, dw + ({channel} * M + q) * TILE, {size});",
                    f"for (long q = {columns}; q < M; q++) memset({row}, 0, {size});",
                ]
        return lines

    def rest(self) -> str:
        """Return the code of the steady state: each block under the steady output of the block before."""
        plan, inputs = self.plan, self.plan.pieces[0].block.inputs
        lines = [
            f"double c[{self.plan.program.constants}], w[{plan.width} * TILE] = {{0.0}};",
            f"double s1[{plan.states + 1}], ds1[{plan.states} * M + 1];",
            f"double *restrict z = dw + {plan.width} * TILE * M;",
            "(void)s1; (void)ds1; (void)z;",
            "prepare(p, c);",
            f"memset(ds, 0, sizeof(double) * {plan.states} * M);",
            f"for (long i = 0; i < {inputs}; i++) w[i * TILE] = x[i];",
        ]
        state, offset = 0, 0
        for k, piece in enumerate(plan.pieces):
            count = piece.block.states()
            if count:
                lines += ["{", *(f"    {line}" for line in self._write_rest(piece, state)), "}"]
            if k < len(plan.pieces) - 1:
                lines += [
                    f"memcpy(s1, s + {state}, sizeof(double) * {count});",
                    f"memcpy(ds1, ds + {state} * M, sizeof(double) * {count} * M);",
                    f"block{k}d(1, c, w, s1, ds1, dw, z + {offset});",
                ]
            state += count
            offset += count_room(piece, 0)
        return _print_function(
            "void rest(const double *restrict p, const double *restrict x, double *restrict s,\n"
            "    double *restrict ds, double *restrict dw)",
            lines,
        )

    def _write_rest(self, piece: ChainPiece, state: int) -> list[str]:
        inputs, first = piece.block.inputs, piece.first
        named = self.statements(piece.rest.name)
        lines = [*(f"const double x{i} = w[{i} * TILE];" for i in range(inputs))]
        lines += ["(void)x0;", *named.lines]
        lines += [f"s[{state + i}] = {named.results[i]};" for i in range(piece.rest.rows)]
        for e in piece.rest.entries:
            target, value = f"ds[{state + e.row} * M", named.results[e.place]
            lines.append(
                f"for (long q = 0; q < {first}; q++) {target} + q] += {value} * dw[({e.column} * M + q) * TILE];"
                if e.column < inputs
                else f"{target} + {first + e.column - inputs}] += {value};"
            )
        return lines


def _print_loop(
    piece: ChainPiece, lines: Sequence[str], results: Sequence[str], inside: Sequence[str], slopes: bool
) -> list[str]:
    """Return the loop over samples, with the state in local variables."""
    inputs, outputs, states = piece.block.inputs, piece.block.outputs, piece.block.states()
    body = [
        *(f"const double x{i} = w[{i} * TILE + t];" for i in range(inputs)),
        "(void)x0;",
        *lines,
        *inside,
        *(f"const double y{i} = {results[i]};" for i in range(outputs)),
        *(f"const double n{i} = {results[outputs + i]};" for i in range(states)),
        *(f"w[{i} * TILE + t] = y{i};" for i in range(outputs)),
        *(f"s{i} = n{i};" for i in range(states)),
    ]
    whole = slopes and not states
    return [
        *(f"double s{i} = s[{i}];" for i in range(states)),
        *([] if states else ["#pragma omp simd"]),
        f"for (long t = 0; t < {'TILE' if whole else 'n'}; t++) {{",
        *(f"    {line}" for line in body),
        "}",
        *(f"s[{i}] = s{i};" for i in range(states)),
    ]


def _print_function(head: str, lines: Sequence[str]) -> str:
    body = "".join(f"    {line}\n" for line in lines)
    return f"{head} {{\n{body}}}\n"
