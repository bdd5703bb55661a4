"""C source of traced functions for a batch, with each number as a pair of short vectors.

A compiler vectorises a loop over batch elements only if its body has no loop and no branch, unlike the solves of
mechanisms. Explicit vectors avoid this limit. A pair of vectors forms two independent chains of operations, which
keeps the processor busy.

All batch elements use the same instructions, so results do not depend on the position in the batch. Divisions by the
same number share its inverse, because division is slow; results differ from single runs by rounding. This needs the
vector types of gcc or clang.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace

from martensite.kernels.c99 import C_DIALECT, LoopCondition, c_number, scalar_dialect
from martensite.kernels.compiler import read_source
from martensite.kernels.floats import LARGEST
from martensite.kernels.kernel_printer import KernelPrinter, Statements
from martensite.kernels.polynomials import ERFCX, ERFCX_CENTRE, QUARTER_SINE, evaluate_estrin
from martensite.kernels.printer import Dialect
from martensite.kernels.program import Function, Program
from martensite.kernels.rolled_lines import roll_lines

BLOCK = 16
"""Divisor of the batch size: a pair of the widest vectors, or several pairs of narrower ones."""

_BINARY = (
    ("add sub mul div lt le gt ge", "plus minus times over below at_most above at_least"),
    ("both either minimum maximum power", "both either least most power_of"),
)
_UNARY = (
    ("neg negate abs sqrt exp log", "minus_of not_of size_of root_of exp_of log_of"),
    ("sin cos tanh nearest quarter_sine erfcx", "sin_of cos_of tanh_of rint_of quarter_sine_of erfcx_of"),
)
_TEMPLATES = {
    operation: f"{name}{arguments}"
    for arguments, table in (("({}, {})", _BINARY), ("({})", _UNARY))
    for operations, names in table
    for operation, name in zip(operations.split(), names.split(), strict=True)
} | {"where": "pick({}, {}, {})", "eps": "all(2.220446049250313e-16)"}
"""Operations as functions on pairs of vectors."""


def lanes_source(program: Program, functions: Iterable[Function]) -> str:
    """Return C source of `prepare` and traced functions of a program, over a multiple of `BLOCK` batch elements.

    Functions and layout are the same as in `martensite.kernels.c99.c_source`.
    """
    kernels = KernelPrinter(program, _build_dialect(), "AT({}, {})", "differs({}, all(0.0))")
    parts = [_write_prelude(), _print_function("prepare", "p", (), kernels.prepare)]
    for one in functions:
        parts.append(_print_function(one.name, "c", ("x",), kernels.print_function(one)))
    return "\n".join(parts)


def _build_dialect() -> Dialect:
    templates = {**C_DIALECT.templates, **_TEMPLATES}
    going = LoopCondition("some(above({}, all(0.0)))", "pick(above({going}, all(0.0)), {new}, {old})")
    dialect = scalar_dialect("number", templates, _print_constant, "flags", going)
    return replace(dialect, wants_names=frozenset(), shares_inverses=True)


def _print_constant(value: float | bool) -> str:
    if isinstance(value, bool):
        return f"FLAGS({-int(value)})"
    return f"all({c_number(value)})"


def _print_function(name: str, constants: str, inputs: Sequence[str], statements: Statements) -> str:
    values = zip(statements.results, statements.flags, strict=True)
    numbers = [f"pick({value}, all(1.0), all(0.0))" if flag else value for value, flag in values]
    lines = [*statements.lines, *roll_lines([f"PUT(y, {i}, {number});" for i, number in enumerate(numbers)])]
    arguments = ", ".join(f"const double *restrict {a}" for a in (constants, *inputs))
    body = "".join(f"        {line}\n" for line in lines)
    return (
        f"static inline void k_{name}(long n, {arguments}, double *restrict y) {{\n"
        f"    for (long l = 0; l < n; l += PAIR) {{\n{body}    }}\n}}\n"
    )


def _write_prelude() -> str:
    centre = f"all({ERFCX_CENTRE!r})"
    return (
        f"{read_source('kernels', 'vector_math.c', {})}{read_source('kernels', 'vectors.c', {})}"
        "INLINE number power_of(number x, number y) {\n"
        "    const flags positive = above(x, all(0.0));\n"
        f"    const number z = least(pow_1(pick(positive, x, all(1.0)), y), all({LARGEST!r}));\n"
        "    return pick(positive, z, all(0.0));\n}\n"
        "INLINE number quarter_sine_of(number x) {\n"
        f"    const number z = times(x, x){_print_polynomial(QUARTER_SINE, 'times({}, x)')}}}\n"
        "INLINE number erfcx_of(number x) {\n"
        f"    const number z = over(minus(x, {centre}), plus(x, {centre}))"
        f"{_print_polynomial(ERFCX, 'over({}, plus(all(1.0), times(all(2.0), x)))')}}}\n"
    )


def _print_polynomial(coefficients: list[float], result: str) -> str:
    """Return a polynomial in z, with the required powers, in the notation of the result."""
    powers, text = evaluate_estrin(coefficients, "times({}, {})", "plus({}, {})", "all({!r})")
    lines = "".join(f", {name} = {power}" for name, power in powers)
    return f"{lines};\n    return {result.format(text)};\n"
