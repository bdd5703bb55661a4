"""C99: the traced kernels as C source, compiled on the spot with the system's compiler.

No allocation, no library beyond libm, no second physics: the source is printed from the same
graph as the Python. Arrays of a batch are laid out [variable][lane], so that the compiler can
turn the loop over lanes into SIMD instructions.
"""

from __future__ import annotations

import ctypes
import hashlib
import os
import re
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache, partial
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from martensite.base.errors import MartensiteError
from martensite.base.files import cache_folder
from martensite.kernels.floats import LARGEST
from martensite.kernels.graph import Expr
from martensite.kernels.polynomials import ERFCX, ERFCX_CENTRE, QUARTER_SINE, evaluate_estrin
from martensite.kernels.printer import (
    FLAG,
    NUMBER,
    PYTHON_OPERATORS,
    SLOPES,
    Dialect,
    LoopText,
    Printer,
    RepeatText,
)
from martensite.kernels.program import Function, Program

FLAGS = (
    "-std=c99",
    "-O3",
    "-march=native",
    "-fno-math-errno",
    "-fno-trapping-math",
    "-ffp-contract=off",
    "-fno-tree-pre",
    "-fopenmp-simd",
    "-fPIC",
    "-shared",
)
WIDE = ("-mprefer-vector-width=512",)
"""For processors with AVX-512: compilers prefer half the width, which costs a batch a third."""


def _print_constant(value: float | bool) -> str:
    return str(int(value)) if isinstance(value, bool) else c_number(value)


def c_number(value: float) -> str:
    """A number in C."""
    return repr(value).replace("inf", "HUGE_VAL")


_TYPES = {FLAG: "_Bool", NUMBER: "double", SLOPES: "slopes"}
"""`slopes` is a vector type that the source declares where it has any."""
_WORD = re.compile(r"[A-Za-z_]\w*")


def _print_assignment(
    name: str, expression: str, kind: str, types: Mapping[str, str] = _TYPES
) -> str:
    return f"const {types[kind]} {name} = {expression};"


def _print_loop(loop: LoopText, types: Mapping[str, str] = _TYPES) -> list[str]:
    """A loop over arrays on the stack."""
    rows = len(loop.columns[0])
    kinds = [_declare_kind(kind, types) for kind in loop.row_kinds]
    columns = [f"{loop.name}_{name}" for name in loop.row]
    tables = zip(kinds, columns, loop.columns, strict=True)
    named = set(_WORD.findall(" ".join((*loop.body, *loop.outputs))))
    inputs = list(zip(kinds, loop.row, columns, strict=True))
    results = list(zip(loop.results(), loop.outputs, strict=True))
    stored = [_declare_kind(kind, types) for kind in loop.output_kinds]
    made = zip(stored, loop.results(), strict=True)
    row = f"r_{loop.name}"
    return [
        *(f"{kind} {name}[{rows}];" for kind, name in made),
        *(f"const {kind} {name}[{rows}] = {{{', '.join(cells)}}};" for kind, name, cells in tables),
        *(f"(void){column};" for _, name, column in inputs if name not in named),
        f"for (int {row} = 0; {row} < {rows}; {row}++) {{",
        *(
            f"    const {kind} {name} = {column}[{row}];"
            for kind, name, column in inputs
            if name in named
        ),
        *(f"    {line}" for line in loop.body),
        *(f"    {name}[{row}] = {value};" for name, value in results),
        "}",
    ]


def _declare_kind(kind: str, types: Mapping[str, str]) -> str:
    """Type of what a loop holds: it stores flags as numbers."""
    return types[NUMBER if kind == FLAG else kind]


@dataclass(frozen=True)
class LoopCondition:
    """How a loop asks whether it goes on, and keeps the state of lanes that do not."""

    test: str = "{} > 0.0"
    """Whether the first number of the state is above 0, in any lane."""
    keep: str = "{new}"
    """What a variable becomes, from its `old` and `new` value and the first number, `going`."""


def _print_repetition(
    loop: RepeatText, types: Mapping[str, str] = _TYPES, going: LoopCondition = LoopCondition()
) -> list[str]:
    """A loop over variables of its own block."""
    name, first = loop.name, loop.state[0]
    test = f" && {going.test.format(first)}" if loop.stops else ""
    keep = going.keep if loop.stops else LoopCondition.keep
    kinds = [_declare_kind(kind, types) for kind in loop.kinds]
    state = list(zip(kinds, loop.state, loop.begin, loop.outputs, strict=True))
    rows = zip(loop.used, kinds, loop.results(), loop.state, strict=True)
    results = [row[1:] for row in rows if row[0]]
    named = set(_WORD.findall(" ".join((*loop.body, *loop.outputs, test))))
    named |= {r[-1] for r in results}
    return [
        *(f"{kind} {result};" for kind, result, _ in results),
        "{",
        *(f"    {kind} {name} = {begin};" for kind, name, begin, _ in state),
        *(f"    (void){name};" for name in loop.state if name not in named),
        f"    for (int k_{name} = 0; k_{name} < {loop.count}{test}; k_{name}++) {{",
        *(f"        {line}" for line in loop.body),
        *(f"        const {kind} n_{name} = {value};" for kind, name, _, value in state),
        *(
            f"        {name} = {keep.format(old=name, new=f'n_{name}', going=first)};"
            for _, name, _, _ in (*state[1:], state[0])
        ),
        "    }",
        *(f"    {result} = {name};" for _, result, name in results),
        "}",
    ]


C_DIALECT = Dialect(
    templates={
        **PYTHON_OPERATORS,
        "where": "({0} ? {1} : {2})",
        "both": "({} & {})",
        "either": "({} | {})",
        "negate": "(!{})",
        "minimum": "({0} < {1} ? {0} : {1})",
        "maximum": "({0} > {1} ? {0} : {1})",
        "abs": "fabs({})",
        "sqrt": "({0} > 0.0 ? sqrt({0}) : 0.0)",
        "exp": "exp({0} < 700.0 ? {0} : 700.0)",
        "log": "log({0} > 1e-300 ? {0} : 1e-300)",
        "power": "power_of({}, {})",
        "sin": "sin({})",
        "cos": "cos({})",
        "tanh": "tanh({})",
        "nearest": "rint({})",
        "quarter_sine": "quarter_sine({})",
        "erfcx": "erfcx({})",
        "detach": "{}",
        "implicit_root": "{}",
        "store": "{}",
        "eps": "2.220446049250313e-16",
    },
    wants_names=frozenset({"where", "minimum", "maximum", "sqrt", "exp", "log", "power"}),
    assign=_print_assignment,
    constant=_print_constant,
    loop=_print_loop,
    repeat=_print_repetition,
)


def scalar_dialect(
    number: str,
    templates: Mapping[str, str],
    constant: Callable[[float | bool], str],
    flag: str = _TYPES[FLAG],
    going: LoopCondition = LoopCondition(),
) -> Dialect:
    """C of one run at a time, which may leave out what is not chosen.

    Args:
        number: the type of numbers, such as `double` or `float`.
        templates: operations that look otherwise than in a batch.
        constant: how a number is written.
        flag: the type of what is true or false.
        going: how loops end.
    """
    types = {**_TYPES, NUMBER: number, FLAG: flag}
    return replace(
        C_DIALECT,
        templates={**C_DIALECT.templates, **templates},
        wants_names=C_DIALECT.wants_names - {"where"},
        assign=partial(_print_assignment, types=types),
        constant=constant,
        loop=partial(_print_loop, types=types),
        repeat=partial(_print_repetition, types=types, going=going),
    )


def c_source(program: Program, functions: Iterable[Function], shares_inverses: bool = False) -> str:
    """C of `prepare` and of some traced functions of a program, over lanes.

    Divisions by one number may share its inverse, which is quicker and rounds differently.
    """
    printer = Printer(program.graph, replace(C_DIALECT, shares_inverses=shares_inverses))
    for i in range(len(program.parameters)):
        printer.share([program.graph.input(f"p{i}", 0)], lambda _, i=i: f"p[{i} * n + l]")
    parts = [write_prelude(), _print_function(printer, "prepare", "p", (), program.hoisted_nodes)]
    flags = [printer.is_flag(node.index) for node in program.hoisted_nodes]

    def constant(i: int) -> str:
        return f"(c[{i} * n + l] != 0.0)" if flags[i] else f"c[{i} * n + l]"

    printer.share(program.hoisted_nodes, constant)
    parts += [_print_traced(printer, function) for function in functions]
    return "\n".join(parts)


def _print_traced(printer: Printer, function: Function) -> str:
    for i, name in enumerate(function.inputs):
        printer.share([printer.graph.input(name, 0)], lambda _, i=i: f"x[{i} * n + l]")
    return _print_function(printer, function.name, "c", ("x",), function.outputs)


def _print_function(
    printer: Printer, name: str, constants: str, inputs: Sequence[str], outputs: Sequence[Expr]
) -> str:
    lines, values = printer.block(outputs)
    lines += [f"y[{i} * n + l] = {value};" for i, value in enumerate(values)]
    arguments = ", ".join(f"const double *restrict {a}" for a in (constants, *inputs))
    body = "".join(f"        {line}\n" for line in lines)
    return (
        f"static inline void k_{name}(long n, {arguments}, double *restrict y) {{\n"
        f"    #pragma omp simd\n    for (long l = 0; l < n; l++) {{\n{body}    }}\n}}\n"
    )


# glibc has these over vectors; without it gcc calls them lane by lane
_VECTOR_MATH = """
#if defined(__GLIBC__) && defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__)
#pragma omp declare simd notinbranch
double exp(double);
#pragma omp declare simd notinbranch
double log(double);
#pragma omp declare simd notinbranch
double pow(double, double);
#pragma omp declare simd notinbranch
double sin(double);
#pragma omp declare simd notinbranch
double cos(double);
#if __GLIBC_PREREQ(2, 35)
#pragma omp declare simd notinbranch
double tanh(double);
#endif
#endif
"""


def vector_math() -> str:
    """Declarations after which a loop over lanes calls functions of vectors, where there are."""
    return _VECTOR_MATH


def write_prelude() -> str:
    """What every source begins with."""
    return (
        f"#include <math.h>\n#include <string.h>\n{_VECTOR_MATH}\n"
        "static inline double power_of(double base, double exponent) {\n"
        "    const double y = pow(base > 0.0 ? base : 1.0, exponent);\n"
        f"    return base > 0.0 ? (y < {LARGEST!r} ? y : {LARGEST!r}) : 0.0;\n}}\n"
        "static inline double quarter_sine(double x) {\n"
        f"    const double z = x * x{_print_polynomial(QUARTER_SINE)} * x;\n}}\n"
        "static inline double erfcx(double x) {\n"
        f"    const double z = (x - {ERFCX_CENTRE}) / (x + {ERFCX_CENTRE})"
        f"{_print_polynomial(ERFCX)} / (1.0 + 2.0 * x);\n}}\n"
    )


def _print_polynomial(coefficients: list[float]) -> str:
    """A polynomial in z, with the powers that it needs."""
    powers, text = evaluate_estrin(coefficients)
    return "".join(f", {name} = {power}" for name, power in powers) + f";\n    return {text}"


def find_compiler() -> str | None:
    """The C compiler that would be used, or None.

    That of the machine: the one that `CC` names, `cc` or `gcc`; else the one of the package
    `ziglang`, which the extra `cc` installs.
    """
    return shutil.which(os.environ.get("CC", "cc")) or shutil.which("gcc") or _find_zig()


_ZIG = """#!/bin/sh
for word; do shift; [ "$word" = -fno-tree-pre ] || set -- "$@" "$word"; done
exec "{python}" -m ziglang cc "$@"
"""


@cache
def _find_zig() -> str | None:
    """A program that calls the C compiler of the package `ziglang`; None without it, or Windows."""
    if find_spec("ziglang") is None or os.name != "posix":
        return None
    text = _ZIG.format(python=sys.executable)
    path = cache_folder() / "c" / f"zig-cc-{hashlib.sha256(text.encode()).hexdigest()[:12]}"
    if not path.exists():
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
        path.chmod(0o755)
    return str(path)


def load_library(source: str, more: tuple[str, ...] = ()) -> Any:
    """Compile C source to a shared library in the cache (by hash) and load it.

    The environment variable `MARTENSITE_CFLAGS` has the last word on the flags of the compiler.

    Args:
        source: the C.
        more: further flags of the compiler.

    Raises:
        MartensiteError: there is no compiler, or it failed.
    """
    command = _build_command(more)
    path = _kept_as(command, source)
    if not path.exists():
        _compile_source(command, source, path)
    return ctypes.CDLL(str(path))


def is_compiled(source: str, more: tuple[str, ...] = ()) -> bool:
    """Whether `load_library` would find what it needs, so that nothing is compiled."""
    return find_compiler() is not None and _kept_as(_build_command(more), source).exists()


def _build_command(more: tuple[str, ...]) -> tuple[str, ...]:
    """The compiler and its flags."""
    cc = find_compiler()
    if cc is None:
        raise MartensiteError(
            "The C runtime needs a C compiler and none was found; install gcc or clang, "
            "or use the runtime `floats`."
        )
    wide = WIDE if "avx512f" in _describe_machine() else ()
    return (cc, *FLAGS, *wide, *more, *os.environ.get("MARTENSITE_CFLAGS", "").split())


def _kept_as(command: Sequence[str], source: str) -> Path:
    """Where a library is kept."""
    key = hashlib.sha256(" ".join((*command, _describe_machine(), source)).encode()).hexdigest()[
        :24
    ]
    return cache_folder() / "c" / f"{key}.so"


def _describe_machine() -> str:
    """What -march=native depends on, so that a shared cache folder never misleads."""
    try:
        text = Path("/proc/cpuinfo").read_text()
    except OSError:
        return ""
    return next((line for line in text.splitlines() if line.startswith("flags")), "")


def _compile_source(command: Sequence[str], source: str, path: Path) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(dir=path.parent) as folder:
        code, library = Path(folder) / "kernel.c", Path(folder) / "kernel.so"
        code.write_text(source)
        done = subprocess.run(
            [*command, str(code), "-o", str(library), "-lm"],
            capture_output=True,
            text=True,
            check=False,
        )
        if done.returncode != 0:
            raise MartensiteError(
                f"The C compiler `{command[0]}` failed: {done.stderr.strip()[:500]}"
            )
        library.replace(path)
