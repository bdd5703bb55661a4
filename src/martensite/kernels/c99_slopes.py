"""C of traced functions with their derivatives: values as numbers, slopes as short vectors.

A compiler keeps a vector of derivatives in one or a few registers, so that all directions are
computed beside a single evaluation of the values. Needs the vector types of gcc or clang.
"""

from __future__ import annotations

from collections.abc import Sequence

from martensite.kernels.c99 import C_DIALECT, write_prelude
from martensite.kernels.graph import PARAMETER, SLOPE, VARYING, Expr
from martensite.kernels.printer import SLOPES, Printer
from martensite.kernels.program import Function, Program
from martensite.kernels.tangent import ZERO, slope_input

WIDTHS = (4, 8, 16)
"""Directions that are computed together."""


def slopes_source(
    program: Program, functions: Sequence[Function], wrt: Sequence[int], width: int
) -> str:
    """C of `prepare` and of differentiated functions, in `width` directions.

    Every function takes constants and inputs, each followed by its slopes:
    `k_step(c, dc, x, dx, y, dy)`; `k_prepare(p, dp, c, dc)`.
    """
    printer = Printer(program.graph, C_DIALECT)
    graph = program.graph
    for i in range(len(program.parameters)):
        printer.share([graph.input(f"p{i}", 0)], lambda _, i=i: f"p[{i}]")
    for k, i in enumerate(wrt):
        node = graph.input(slope_input(f"p{i}"), PARAMETER | SLOPE)
        printer.share([node], lambda _, k=k: f"dp[{k}]")
    hoisted = program.hoisted_nodes
    parts = [
        _declare_types(width),
        _print_function(printer, "prepare", ("p", "dp"), ("c", "dc"), hoisted),
    ]
    for node, (array, place, flag) in zip(hoisted, _list_places(printer, hoisted), strict=True):
        text = f"{array}[{place}]"
        printer.share([node], lambda _, t=f"({text} != 0.0)" if flag else text: t)
    parts += [_print_traced(printer, function) for function in functions]
    return "\n".join(parts)


def count_constants(program: Program) -> tuple[int, int]:
    """How many numbers, and how many derivatives, depend on parameters alone."""
    slopes = sum(bool(program.graph.depends[node.index] & SLOPE) for node in program.hoisted_nodes)
    return len(program.hoisted_nodes) - slopes, slopes


def _declare_types(width: int) -> str:
    return (
        f"{write_prelude()}"
        f"typedef double slopes __attribute__((vector_size({8 * width}), aligned(8)));\n"
        f"static const slopes {ZERO};\n"
    )


def _list_places(printer: Printer, nodes: Sequence[Expr]) -> list[tuple[str, int, bool]]:
    """Array, index and whether it is a flag, of every constant."""
    counts = {"c": 0, "dc": 0}
    found: list[tuple[str, int, bool]] = []
    for node in nodes:
        array = "dc" if printer.kind(node.index) == SLOPES else "c"
        found.append((array, counts[array], printer.is_flag(node.index)))
        counts[array] += 1
    return found


def _print_traced(printer: Printer, function: Function) -> str:
    graph = printer.graph
    for i, name in enumerate(function.inputs):
        printer.share([graph.input(name, 0)], lambda _, i=i: f"x[{i}]")
        node = graph.input(slope_input(name), VARYING | SLOPE)
        printer.share([node], lambda _, i=i: f"dx[{i}]")
    count = len(function.outputs) // 2
    arrays = [("y", k) for k in range(count)] + [("dy", k) for k in range(count)]
    taken = ("c", "dc", "x", "dx")
    return _print_body(printer, function.name, taken, ("y", "dy"), function.outputs, arrays)


def _print_function(
    printer: Printer,
    name: str,
    taken: tuple[str, ...],
    made: tuple[str, str],
    outputs: Sequence[Expr],
) -> str:
    arrays = [(array, place) for array, place, _ in _list_places(printer, outputs)]
    return _print_body(printer, name, taken, made, outputs, arrays)


def _print_body(
    printer: Printer,
    name: str,
    taken: Sequence[str],
    made: tuple[str, str],
    outputs: Sequence[Expr],
    arrays: Sequence[tuple[str, int]],
) -> str:
    lines, values = printer.block(outputs)
    lines += [f"{a}[{k}] = {value};" for (a, k), value in zip(arrays, values, strict=True)]
    kinds = ("double", "slopes")
    arguments = [f"const {kinds[i % 2]} *restrict {a}" for i, a in enumerate(taken)]
    arguments += [f"{kind} *restrict {a}" for kind, a in zip(kinds, made, strict=True)]
    body = "".join(f"    {line}\n" for line in lines)
    return f"static void k_{name}({', '.join(arguments)}) {{\n{body}}}\n"
