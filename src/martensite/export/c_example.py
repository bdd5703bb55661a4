"""An example beside a C core: a program that plays given inputs and prints the outputs as CSV."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import groupby
from string import Template

from martensite.export.c_core import CCore
from martensite.export.c_kernels import Precision, precision_of
from martensite.export.c_text import count_elements

Step = tuple[float, tuple[float, ...]]
"""Length [s] and inputs of a step."""


def example_text(core: CCore, first: Sequence[float], steps: Sequence[Step]) -> str:
    """NAME_example.c, which prints time and outputs at the start and after every step.

    Args:
        core: what it calls.
        first: inputs at the start.
        steps: what is played; equal steps in a row are one row of its table.
    """
    precision = precision_of(core.precision)
    titles = ",".join(("time", *(one.name for one in core.outputs)))
    return Template(_EXAMPLE).substitute(
        NAME=core.name,
        REAL=precision.number,
        INPUTS=count_elements(len(core.inputs)),
        OUTPUTS=count_elements(len(core.outputs)),
        FIRST=_format_numbers(precision, first),
        ROWS=",\n".join(_format_rows(precision, steps)),
        TITLES=titles.replace("\\", "\\\\").replace('"', '\\"'),
        FORMAT="%.17g" if precision.number == "double" else "%.9g",
    )


def _format_rows(precision: Precision, steps: Sequence[Step]) -> Iterator[str]:
    for (length, inputs), equal in groupby(steps):
        count = sum(1 for _ in equal)
        yield f"    {{{count}, {precision.literal(length)}, {_format_numbers(precision, inputs)}}}"


def _format_numbers(precision: Precision, values: Sequence[float]) -> str:
    return f"{{{', '.join(map(precision.literal, values)) or '0'}}}"


_EXAMPLE = """\
/*
 * Plays inputs and prints time and outputs as CSV.
 *
 *     cc -std=c99 -O2 ${NAME}_example.c ${NAME}.c -lm -o ${NAME}_example
 */
#include "${NAME}.h"

#include <stdio.h>

static const $REAL first[$INPUTS] = $FIRST;

static const struct {
    int steps;
    $REAL dt; /* s */
    $REAL u[$INPUTS];
} played[] = {
$ROWS
};

static int print_outputs(const ${NAME}_model *m, const $REAL *u, double time) {
    $REAL y[$OUTPUTS];
    int i, status = ${NAME}_observe(m, u, y);
    if (status != ${NAME}_OK) return status;
    printf("$FORMAT", time);
    for (i = 0; i < ${NAME}_OUTPUTS; i++) printf(",$FORMAT", (double)y[i]);
    printf("\\n");
    return status;
}

static int failed(int status, double time) {
    if (status == ${NAME}_OK || status == ${NAME}_LONG_STEP) return 0;
    fprintf(stderr, "status %d at %g s\\n", status, time);
    return 1;
}

int main(void) {
    static ${NAME}_model model;
    const int rows = (int)(sizeof played / sizeof played[0]);
    double time = 0.0;
    int row, step;

    ${NAME}_defaults(&model);
    if (failed(${NAME}_start(&model, first), time)) return 1;
    printf("$TITLES\\n");
    if (failed(print_outputs(&model, first, time), time)) return 1;
    for (row = 0; row < rows; row++)
        for (step = 0; step < played[row].steps; step++) {
            if (failed(${NAME}_step(&model, played[row].u, played[row].dt), time)) return 1;
            time += (double)played[row].dt;
            if (failed(print_outputs(&model, played[row].u, time), time)) return 1;
        }
    return 0;
}
"""
