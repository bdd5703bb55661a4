"""Source of a C core: kernels, tables of parameters, public functions.

A step with a non-finite result leaves the state unchanged.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from string import Template
from typing import TYPE_CHECKING

from martensite.export.c_kernels import CKernel, kernels_text, precision_of
from martensite.export.c_names import CoreVariable
from martensite.export.c_text import count_elements
from martensite.export.c_tried import PARTS, print_tried
from martensite.simulate.march import COARSE

if TYPE_CHECKING:
    from martensite.export.c_core import CCore


def source_text(core: CCore) -> str:
    """Return NAME.c."""
    traced, count = core.program.functions, len(core.inputs)
    kernels = [CKernel.of(traced["init"], 0, count)]
    stepped = ("step", "observe", *["respond"] * bool(core.answers))
    kernels += [CKernel.of(traced[name], core.states, count) for name in stepped]
    prefix = f"{core.name}_"
    begin = (
        _BEGIN
        + kernels_text(core.program, core.parameter_indices, kernels, prefix, precision_of(core.precision))
        + "\n"
    )
    more = print_tried(core)
    return fill_text(core, begin + _FINITE + _print_tables(core) + _PREPARE + _START + _print_step(core) + _SEEN + more)


def fill_text(core: CCore, text: str) -> str:
    """Return a template with its placeholders, such as `$REAL`, filled in."""
    precision = precision_of(core.precision)
    return Template(text).substitute(
        NAME=core.name,
        REAL=precision.number,
        F=precision.suffix,
        LARGEST=precision.largest,
        ZERO=precision.literal(0.0),
        SOLVED=precision.literal(precision.solved),
        COARSE=precision.literal(COARSE),
        NEAR=precision.literal(precision.near),
        SAMPLE=core.sample or "",
        N_CONSTANTS=count_elements(core.constants),
        N_STATES=count_elements(core.states),
        N_RESULTS=count_elements(core.states + (2 if core.has_report else 0)),
        N_OUTPUTS=count_elements(len(core.outputs)),
        TWO=precision.literal(2.0),
        PARTS=PARTS,
        PROBES=", ".join(map(precision.literal, core.probes)),
    )


def _print_tables(core: CCore) -> str:
    low = [_print_bound(core, v, v.low) for v in core.parameters]
    high = [_print_bound(core, v, v.high) for v in core.parameters]
    values = [precision_of(core.precision).literal(v.default) for v in core.parameters]
    return _print_table("low", low) + _print_table("high", high) + _print_table("value", values)


def _print_table(name: str, numbers: Sequence[str]) -> str:
    rows = ",\n".join(f"    {text}" for text in numbers or ["0"])
    return f"static const $REAL ${{NAME}}_{name}[{count_elements(len(numbers))}] = {{\n{rows}\n}};\n\n"


def _print_bound(core: CCore, variable: CoreVariable, value: float) -> str:
    """Return an end of the allowed range; infinite only if the parameter may be."""
    if math.isinf(value) and not variable.endless:
        return f"{'-' if value < 0.0 else ''}{precision_of(core.precision).largest}"
    return precision_of(core.precision).literal(value)


def _print_step(core: CCore) -> str:
    """Return a template of a step: its start, kernel call, checks and stored values."""
    return "".join(
        [
            _STEP_BEGIN,
            _STEP_CHECKED,
            _SAMPLE if core.sample else "",
            "    ${NAME}_kernel_step(m->c, m->x, u, dt, y);\n",
            _CHECKED if core.has_report else _FINITE_STATE,
            _TAKEN,
            _REPORTED if core.has_report else "    return ${NAME}_OK;\n",
            "}\n\n",
        ]
    )


_BEGIN = """\
#include "${NAME}.h"

#include <float.h>
#include <math.h>

"""

_FINITE = """\
static int ${NAME}_finite(const $REAL *v, int count) {
    int i;
    for (i = 0; i < count; i++)
        if (!(fabs$F(v[i]) <= $LARGEST)) return 0;
    return 1;
}

"""

_PREPARE = """\
int ${NAME}_prepare(${NAME}_model *m) {
    $REAL c[$N_CONSTANTS];
    int i;
    for (i = 0; i < ${NAME}_PARAMETERS; i++)
        if (!(m->p[i] >= ${NAME}_low[i] && m->p[i] <= ${NAME}_high[i])) return ${NAME}_BAD_INPUT;
    ${NAME}_kernel_prepare(m->p, c);
    for (i = 0; i < ${NAME}_CONSTANTS; i++)
        if (c[i] != c[i]) return ${NAME}_NOT_FINITE;
    for (i = 0; i < ${NAME}_CONSTANTS; i++) m->c[i] = c[i];
    return ${NAME}_OK;
}

void ${NAME}_defaults(${NAME}_model *m) {
    const volatile $REAL *value = ${NAME}_value; /* gcc 12 folds rows of a table wrongly into vectors of 512 bits */
    int i;
    for (i = 0; i < ${NAME}_PARAMETERS; i++) m->p[i] = value[i];
    for (i = 0; i < ${NAME}_CONSTANTS; i++) m->c[i] = $ZERO;
    for (i = 0; i < ${NAME}_STATES; i++) m->x[i] = $ZERO;
    m->residual = $ZERO;
    m->crossing = $ZERO;
    (void)${NAME}_prepare(m);
}

"""

_START = """\
int ${NAME}_start(${NAME}_model *m, const ${NAME}_real *u) {
    $REAL y[$N_STATES];
    int i;
    if (!${NAME}_finite(u, ${NAME}_INPUTS)) return ${NAME}_BAD_INPUT;
    ${NAME}_kernel_init(m->c, m->x, u, $ZERO, y);
    if (!${NAME}_finite(y, ${NAME}_STATES)) return ${NAME}_NOT_FINITE;
    for (i = 0; i < ${NAME}_STATES; i++) m->x[i] = y[i];
    m->residual = $ZERO;
    m->crossing = $ZERO;
    return ${NAME}_OK;
}

"""

_STEP_BEGIN = """\
int ${NAME}_step(${NAME}_model *m, const ${NAME}_real *u, ${NAME}_real dt) {
"""

_STEP_CHECKED = """\
    $REAL y[$N_RESULTS];
    int i;
    if (!${NAME}_finite(u, ${NAME}_INPUTS)) return ${NAME}_BAD_INPUT;
    if (!(dt >= $ZERO && dt <= $LARGEST)) return ${NAME}_BAD_INPUT;
    if (dt == $ZERO) return ${NAME}_OK;
"""

_SAMPLE = """\
    if (!(fabs$F(dt - $SAMPLE) <= $NEAR * $SAMPLE)) return ${NAME}_BAD_INPUT;
"""

_CHECKED = """\
    if (!${NAME}_finite(y, ${NAME}_STATES + 2)) return ${NAME}_NOT_FINITE;
    m->residual = y[${NAME}_STATES];
    m->crossing = y[${NAME}_STATES + 1];
    if (m->residual > $SOLVED) return ${NAME}_UNSOLVED;
"""

_FINITE_STATE = """\
    if (!${NAME}_finite(y, ${NAME}_STATES)) return ${NAME}_NOT_FINITE;
"""

_TAKEN = """\
    for (i = 0; i < ${NAME}_STATES; i++) m->x[i] = y[i];
"""

_REPORTED = """\
    return m->crossing > $COARSE ? ${NAME}_LONG_STEP : ${NAME}_OK;
"""

_SEEN = """\
int ${NAME}_observe(const ${NAME}_model *m, const ${NAME}_real *u, ${NAME}_real *y) {
    $REAL seen[$N_OUTPUTS];
    int i;
    if (!${NAME}_finite(u, ${NAME}_INPUTS)) return ${NAME}_BAD_INPUT;
    ${NAME}_kernel_observe(m->c, m->x, u, $ZERO, seen);
    if (!${NAME}_finite(seen, ${NAME}_OUTPUTS)) return ${NAME}_NOT_FINITE;
    for (i = 0; i < ${NAME}_OUTPUTS; i++) y[i] = seen[i];
    return ${NAME}_OK;
}
"""
