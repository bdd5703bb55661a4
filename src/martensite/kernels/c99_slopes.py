"""C of traced functions with their derivatives: values as numbers, slopes as short vectors.

A compiler keeps a vector of derivatives in one or a few registers, so that all directions are
computed beside a single evaluation of the values. Needs the vector types of gcc or clang.
"""

from __future__ import annotations

from collections.abc import Sequence

from martensite.kernels.c99 import C_DIALECT, write_prelude
from martensite.kernels.kernel_printer import KernelPrinter, Statements
from martensite.kernels.program import Function, Program
from martensite.kernels.slopes import ZERO

WIDTHS = (4, 8, 16)
"""Directions that are computed together."""


def slopes_source(program: Program, functions: Sequence[Function], wrt: Sequence[int], width: int) -> str:
    """C of `prepare` and of differentiated functions, in `width` directions.

    Every function takes constants and inputs, each followed by its slopes:
    `k_step(c, dc, x, dx, y, dy)`; `k_prepare(p, dp, c, dc)`.
    """
    kernels = KernelPrinter(program, C_DIALECT, moving=wrt)
    places = kernels.list_places("c", program.hoisted_nodes)
    parts = [
        f"{write_prelude()}"
        f"typedef double slopes __attribute__((vector_size({8 * width}), aligned(8)));\n"
        f"static const slopes {ZERO};\n",
        _print_function("prepare", ("p", "dp"), ("c", "dc"), kernels.prepare, places),
    ]
    taken = ("c", "dc", "x", "dx")
    for one in functions:
        places = [(array, k) for array in ("y", "dy") for k in range(len(one.outputs) // 2)]
        made = kernels.print_function(one)
        parts.append(_print_function(one.name, taken, ("y", "dy"), made, places))
    return "\n".join(parts)


def _print_function(
    name: str, taken: Sequence[str], given: tuple[str, str], made: Statements, places: Sequence[tuple[str, int]]
) -> str:
    rows = zip(places, made.results, strict=True)
    lines = [*made.lines, *(f"{array}[{k}] = {text};" for (array, k), text in rows)]
    kinds = ("double", "slopes")
    arguments = [f"const {kinds[i % 2]} *restrict {a}" for i, a in enumerate(taken)]
    arguments += [f"{kind} *restrict {a}" for kind, a in zip(kinds, given, strict=True)]
    body = "".join(f"    {line}\n" for line in lines)
    return f"static void k_{name}({', '.join(arguments)}) {{\n{body}}}\n"
