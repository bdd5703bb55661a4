"""C99 source of the traced kernels, compiled by `martensite.kernels.compiler`.

The source comes from the same graph as the Python code, without allocation and with libm only. Batch arrays have the
layout [variable][batch element], so that the compiler can use SIMD instructions over batch elements.

In differentiated functions, values are scalars and derivatives short vectors, which a compiler keeps in registers. All
directions then share one evaluation of the values. This needs the vector types of gcc or clang.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial

from martensite.kernels.compiler import read_source
from martensite.kernels.floats import LARGEST
from martensite.kernels.kernel_printer import KernelPrinter, Statements
from martensite.kernels.polynomials import ERFCX, ERFCX_CENTRE, QUARTER_SINE, evaluate_estrin
from martensite.kernels.printer import FLAG, NUMBER, PYTHON_OPERATORS, SLOPES, Dialect, LoopText, RepeatText
from martensite.kernels.program import Function, Program
from martensite.kernels.quick_compiler import compiles_only_quickly
from martensite.kernels.rolled_lines import merge_texts, roll_lines
from martensite.kernels.slopes import ZERO


def _print_constant(value: float | bool) -> str:
    return str(int(value)) if isinstance(value, bool) else c_number(value)


def c_number(value: float) -> str:
    """Return the C literal of a number."""
    return repr(value).replace("inf", "HUGE_VAL")


_TYPES = {FLAG: "_Bool", NUMBER: "double", SLOPES: "slopes"}
"""C types by kind; `slopes` is a vector type that the source declares."""
MOST_VARIABLES = 32
"""Largest number of state variables of a loop outside an array."""
_WORD = re.compile(r"[A-Za-z_]\w*")


def _print_assignment(name: str, expression: str, kind: str, types: Mapping[str, str] = _TYPES) -> str:
    return f"const {types[kind]} {name} = {expression};"


def _print_loop(loop: LoopText, types: Mapping[str, str] = _TYPES) -> list[str]:
    """Return a loop over arrays on the stack."""
    row, tables, inputs = f"r_{loop.name}", list[str](), list[str]()
    for name, cells, kind in zip(loop.row, loop.columns, loop.row_kinds, strict=True):
        number, text = _declare_kind(kind, types), merge_texts(cells, row)
        if text is None:
            text = f"{loop.name}_{name}[{row}]"
            tables += _print_table(number, f"{loop.name}_{name}", cells)
        inputs.append(f"const {number} {name} = {text};")
    kinds = [_declare_kind(kind, types) for kind in loop.state_kinds]
    states = list(zip(kinds, loop.state, loop.begin, loop.carried, strict=True))
    return [
        *(f"{_declare_kind(kind, types)} {name}[{loop.rows}];" for name, (_, kind) in loop.result_columns.items()),
        *tables,
        *(f"{kind} {name} = {begin};" for kind, name, begin, _ in states),
        f"for (int {row} = 0; {row} < {loop.rows}; {row}++) {{",
        *(f"    {line}" for line in inputs),
        *(f"    {line}" for line in loop.body),
        *(f"    {name}[{row}] = {value};" for name, (value, _) in loop.result_columns.items()),
        *(f"    const {kind} n_{name} = {value};" for kind, name, _, value in states),
        *(f"    {name} = n_{name};" for _, name, _, _ in states),
        "}",
    ]


def _print_table(number: str, name: str, cells: Sequence[str]) -> list[str]:
    """Return the declaration of a column of different expressions."""
    lines = [f"{name}[{row}] = {cell};" for row, cell in enumerate(cells)]
    rolled = roll_lines(lines)
    if len(rolled) < len(lines):
        return [f"{number} {name}[{len(cells)}];", *rolled]
    return [f"const {number} {name}[{len(cells)}] = {{{', '.join(cells)}}};"]


def _declare_kind(kind: str, types: Mapping[str, str]) -> str:
    """Return the type of a loop variable, with flags stored as numbers."""
    return types[NUMBER if kind == FLAG else kind]


@dataclass(frozen=True)
class LoopCondition:
    """Test that continues a loop, and expression that freezes finished batch elements."""

    test: str = "{} > 0.0"
    """Test whether the first state variable is above 0 in any batch element."""
    keep: str = "{new}"
    """New value of a variable, from `old`, `new` and the first state variable, `going`."""


def _print_repetition(
    loop: RepeatText, types: Mapping[str, str] = _TYPES, going: LoopCondition = LoopCondition()
) -> list[str]:
    """Print a loop over its state variables."""
    name, first = loop.name, loop.state[0]
    test = f" && {going.test.format(first)}" if loop.stops else ""
    keep = going.keep if loop.stops else LoopCondition.keep
    news = [f"n_{one}" for one in loop.state]
    rows = list(zip(loop.state, news, strict=True))
    named = set(_WORD.findall(" ".join((*loop.body, *loop.outputs, test))))
    step = [
        *_declare_states(loop, news, loop.outputs, types, "const "),
        *roll_lines([f"{old} = {keep.format(old=old, new=new, going=first)};" for old, new in (*rows[1:], rows[0])]),
    ]
    return [
        *_declare_states(loop, loop.state, loop.begin, types),
        *(f"(void){name};" for name in loop.state if _WORD.findall(name)[0] not in named),
        f"for (int k_{name} = 0; k_{name} < {loop.count}{test}; k_{name}++) {{",
        *(f"    {line}" for line in (*loop.body, *step)),
        "}",
    ]


def _declare_states(
    loop: RepeatText, names: Sequence[str], values: Sequence[str], types: Mapping[str, str], head: str = ""
) -> list[str]:
    """Return the declaration of state variables or arrays with the given values."""
    kinds = [_declare_kind(kind, types) for kind in loop.kinds]
    if not names[0].endswith("]"):
        return [f"{head}{kind} {name} = {value};" for kind, name, value in zip(kinds, names, values, strict=True)]
    arrays = {name.split("[")[0]: kind for kind, name in zip(kinds, names, strict=True)}
    counts = Counter(name.split("[")[0] for name in names)
    return [
        *(f"{kind} {array}[{counts[array]}];" for array, kind in arrays.items()),
        *roll_lines([f"{name} = {value};" for name, value in zip(names, values, strict=True)]),
    ]


C_DIALECT = Dialect(
    templates={
        **PYTHON_OPERATORS,
        "neg": "(-1.0 * {})",  # tcc negates one byte in memory, and the next load waits for it
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
    },
    wants_names=frozenset({"where", "minimum", "maximum", "sqrt", "exp", "log", "power"}),
    assign=_print_assignment,
    constant=_print_constant,
    loop=_print_loop,
    repeat=_print_repetition,
    most_variables=MOST_VARIABLES,
)
BRANCHING = C_DIALECT.wants_names - {"where"}
"""Operations of single runs that need names: a branch that is not chosen may be skipped."""


def scalar_dialect(
    number: str,
    templates: Mapping[str, str],
    constant: Callable[[float | bool], str],
    flag: str = _TYPES[FLAG],
    going: LoopCondition = LoopCondition(),
) -> Dialect:
    """Return the C dialect of single runs in a type such as `double`, which may skip branches that are not chosen."""
    types = {**_TYPES, NUMBER: number, FLAG: flag}
    return replace(
        C_DIALECT,
        templates={**C_DIALECT.templates, "neg": PYTHON_OPERATORS["neg"], **templates},
        wants_names=BRANCHING,
        assign=partial(_print_assignment, types=types),
        constant=constant,
        loop=partial(_print_loop, types=types),
        repeat=partial(_print_repetition, types=types, going=going),
    )


def c_source(
    program: Program, functions: Iterable[Function], shares_inverses: bool = False, single: bool = False
) -> str:
    """Return C source of `prepare` and traced functions of a program, over batch elements.

    With `single`, functions accept one batch element only, and are quicker without optimisation.
    Divisions by the same number may share its inverse, which is quicker but rounds differently. The inverse of a
    subnormal number is infinite, so exponentials are 0 below -700.
    """
    dialect = replace(C_DIALECT, shares_inverses=shares_inverses)
    if shares_inverses:
        limited = f"({{0}} > -700.0 ? {C_DIALECT.templates['exp']} : 0.0)"
        dialect = replace(dialect, templates={**C_DIALECT.templates, "exp": limited})
    if single:
        dialect = replace(dialect, wants_names=BRANCHING)
    place = "{}[{}]" if single else "{}[{} * n + l]"
    kernels = KernelPrinter(program, dialect, place)
    parts = [write_prelude(), _print_function("prepare", "p", (), kernels.prepare, place)]
    for one in functions:
        parts += [QUICK_TO_COMPILE] if one.name == "init" else []
        parts.append(_print_function(one.name, "c", ("x",), kernels.print_function(one), place))
    return "\n".join(parts)


QUICK_TO_COMPILE = """#if defined(__GNUC__) && !defined(__clang__)
__attribute__((optimize("O0"))) static inline void k_init(long, const double *restrict, const double *restrict,
                                                          double *restrict);
#endif
"""
"""Declaration of a function called once per run, where optimisation costs more time than it saves."""


def _print_function(name: str, constants: str, inputs: Sequence[str], statements: Statements, place: str) -> str:
    results = [f"{place.format('y', i)} = {text};" for i, text in enumerate(statements.results)]
    lines = [*statements.lines, *roll_lines(results)]
    arguments = ", ".join(f"const double *restrict {a}" for a in (constants, *inputs))
    body = "".join(f"        {line}\n" for line in lines)
    loop = f"    #pragma omp simd\n    for (long l = 0; l < n; l++) {{\n{body}    }}\n"
    text = loop if " * n" in place else f"    (void)n;\n{body}"
    return f"static inline void k_{name}(long n, {arguments}, double *restrict y) {{\n{text}}}\n"


def write_prelude() -> str:
    """Return the first lines of every source."""
    return f"{read_source('kernels', 'vector_math.c', {})}\n{write_functions('double', 'static inline', 'erfcx')}"


def write_functions(
    number: str,
    head: str,
    erfcx: str,
    suffix: str = "",
    literal: Callable[[float], str] = repr,
    largest: float = LARGEST,
) -> str:
    """Return the C text of powers up to `largest`, a quarter sine and erfcx, in the precision of a suffix."""
    zero, one, two, most, centre = map(literal, (0.0, 1.0, 2.0, largest, ERFCX_CENTRE))

    def series(coefficients: list[float]) -> str:
        powers, text = evaluate_estrin(coefficients, constant=f"{{!r}}{suffix}")
        return "".join(f", {name} = {power}" for name, power in powers) + f";\n    return {text}"

    return (
        f"{head} {number} power_of({number} base, {number} exponent) {{\n"
        f"    const {number} y = pow{suffix}(base > {zero} ? base : {one}, exponent);\n"
        f"    return base > {zero} ? (y < {most} ? y : {most}) : {zero};\n}}\n"
        f"{head} {number} quarter_sine({number} x) {{\n"
        f"    const {number} z = x * x{series(QUARTER_SINE)} * x;\n}}\n"
        f"{head} {number} {erfcx}({number} x) {{\n"
        f"    const {number} z = (x - {centre}) / (x + {centre}){series(ERFCX)} / ({one} + {two} * x);\n}}\n"
    )


# ---------------------------------------------------------------- values and derivatives

WIDTHS = (4, 8, 16)
"""Numbers of directions computed together in vectors."""


def choose_width(count: int) -> int:
    """Return the vector width for a number of directions; 1 under a quick compiler."""
    if compiles_only_quickly():
        return 1
    return next((width for width in WIDTHS if width >= count), WIDTHS[-1])


def slopes_source(program: Program, functions: Sequence[Function], wrt: Sequence[int], width: int) -> str:
    """Return C source of `prepare` and differentiated functions, in `width` directions.

    Every function takes constants and inputs, each followed by its derivatives: `k_step(c, dc, x, dx, y, dy)` and
    `k_prepare(p, dp, c, dc)`. With one direction the source has no vectors and suits all compilers.
    """
    vector = f" __attribute__((vector_size({8 * width}), aligned(8)))" if width > 1 else ""
    kernels = KernelPrinter(program, C_DIALECT, moving=wrt)
    places = kernels.list_places("c", program.hoisted_nodes)
    parts = [
        f"{write_prelude()}typedef double slopes{vector};\nstatic const slopes {ZERO};\n",
        _print_slopes("prepare", ("p", "dp"), ("c", "dc"), kernels.prepare, places),
    ]
    taken = ("c", "dc", "x", "dx")
    for one in functions:
        places = [(array, k) for array in ("y", "dy") for k in range(len(one.outputs) // 2)]
        statements = kernels.print_function(one)
        parts.append(_print_slopes(one.name, taken, ("y", "dy"), statements, places))
    return "\n".join(parts)


def _print_slopes(
    name: str, taken: Sequence[str], given: tuple[str, str], statements: Statements, places: Sequence[tuple[str, int]]
) -> str:
    rows = zip(places, statements.results, strict=True)
    lines = [*statements.lines, *roll_lines([f"{array}[{k}] = {text};" for (array, k), text in rows])]
    kinds = ("double", "slopes")
    arguments = [f"const {kinds[i % 2]} *restrict {a}" for i, a in enumerate(taken)]
    arguments += [f"{kind} *restrict {a}" for kind, a in zip(kinds, given, strict=True)]
    body = "".join(f"    {line}\n" for line in lines)
    return f"static void k_{name}({', '.join(arguments)}) {{\n{body}}}\n"
