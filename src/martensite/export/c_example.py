"""Example program for a C core: it plays inputs and prints the outputs as CSV."""

from __future__ import annotations

import os
import re
import subprocess
import tempfile
from collections.abc import Iterator, Mapping, Sequence
from itertools import accumulate, groupby
from pathlib import Path
from string import Template
from typing import Any

from martensite.actuators.assembly import AbstractSystem
from martensite.base.errors import MartensiteError, ParameterError
from martensite.base.files import write_file
from martensite.base.status import Status
from martensite.control.loop.bench import Bench
from martensite.control.loop.names import MEASURED, hand_drives, list_previews, list_references
from martensite.control.loop.realtime import list_reads
from martensite.control.loop.run import reference_waveforms
from martensite.export.c_core import CCore
from martensite.export.c_kernels import Precision, precision_of
from martensite.export.c_text import STATUS_WORDS, count_elements
from martensite.kernels.compiler import find_compiler
from martensite.signals.base import AbstractWaveform
from martensite.simulate.api import first_step
from martensite.simulate.compiled import compile_march
from martensite.simulate.drive_waveforms import Waveforms, by_name, grid_of
from martensite.simulate.result import Result

Step = tuple[float, tuple[float, ...]]
"""Length [s] and inputs of a step."""


def example_text(core: CCore, first: Sequence[float], steps: Sequence[Step]) -> str:
    """Return NAME_example.c, which prints time and outputs at the start and after each step.

    Args:
        core: the model.
        first: inputs at the start.
        steps: the steps; equal consecutive steps become one row of its table.
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


Played = tuple[tuple[float, ...], list[Step]]
"""Inputs at the start, and the steps."""
MOST = 5
"""Largest ratio of played to requested steps."""
MOST_TRIED = 50
"""Largest number of trial runs."""
LONGEST = 120.0
"""Timeout of a trial run [s]."""


def list_run_inputs(
    system: AbstractSystem, waveform: Waveforms | Mapping[str, Any], duration: float, steps: int, most: int = MOST
) -> Played:
    """Return the inputs of a run of a system, or of a bench without noise.

    Args:
        system: the system or bench.
        waveform: its drive.
        duration: duration of the run [s].
        steps: smallest number of steps; steps are no longer than the first of a run, or are the samples.
        most: the run is cut after `most * steps` steps.
    """
    waveforms: Mapping[str, AbstractWaveform]
    if isinstance(system, Bench):
        waveforms = {**by_name(system.plant, waveform), **reference_waveforms(system)}
    else:
        waveforms = by_name(system, waveform)
    step = system.sample_time() or min(first_step(system, duration, 2), duration / steps)
    grid = grid_of(system, waveforms, min(duration, most * steps * step), 2, step)
    starts = list(accumulate(compile_march(system).widths, initial=0))[:-1]
    sampled, inputs = grid.list_inputs()
    rows = (tuple(row[k] for k in starts) for row in inputs)  # the mean comes first
    return tuple(sampled[0]), list(zip(grid.lengths, rows, strict=True))


def list_loop_inputs(bench: Bench, waveform: Waveforms, result: Result, steps: int, most: int = MOST) -> Played:
    """Return readings, ages, references and free signals of a run on a bench, by sample.

    At most `most * steps` samples are returned.
    """
    sensors, taken = bench.sensors.members(), bench.controllers.members()
    measured = [(MEASURED if sensors else "") + name for name in list_reads(bench)]
    ages = [sensors[name].delay if name in sensors else 0.0 for name in list_reads(bench)]
    given, played = by_name(bench.plant, waveform), reference_waveforms(bench)
    others = [one.name for one in (*list_previews(bench), *hand_drives(bench))]
    free = [given.get(d.name) for d in bench.plant.drives() if d.name not in taken]
    count = min(len(result.times), most * steps + 1)
    rows = [
        (
            *(result.columns[name][k] for name in measured),
            *ages,
            *(result.columns[name][k] for name in list_references(bench)),
            *(played[name].value(result.times[k]) for name in others),
            *(one.value(result.times[k]) if one else 0.0 for one in free),
        )
        for k in range(count)
    ]
    return rows[0], [(bench.period, row) for row in rows[1:]]


def try_program(core: CCore, played: Played) -> str:
    """Compile a core and play it, because single precision can be too coarse for a model.

    Returns:
        A sentence about the trial.
    """
    cc, length = find_compiler(), sum(dt for dt, _ in played[1])
    if cc is None:
        return f"Not tried: there is no C compiler here that could say whether {core.precision} is enough."
    more = os.environ.get("MARTENSITE_CFLAGS", "").split()
    with tempfile.TemporaryDirectory() as folder:
        code = [*core.write(folder), Path(folder) / "example.c"][1:]
        write_file(code[-1], example_text(core, *played))
        build = [cc, "-std=c99", "-O1", *more, *map(str, code), "-o", f"{folder}/example", "-lm"]
        built = subprocess.run(build, capture_output=True, text=True, check=False)
        if built.returncode:
            raise MartensiteError(f"The C compiler `{cc}` failed: {built.stderr.strip()[:500]}")
        try:
            done = subprocess.run([f"{folder}/example"], capture_output=True, text=True, check=False, timeout=LONGEST)
        except subprocess.TimeoutExpired:
            return f"Tried in {core.precision} for {LONGEST:g} s of computing only: it had not stopped by then."
    if done.returncode:
        raise ParameterError(
            f"In {core.precision} this program stops{_explain_stop(done.stderr)} Write it in float64, or for a law "
            "and a mechanism that need fewer digits."
        )
    return f"Tried in {core.precision} over {length:.6g} s of the scenario: it does not stop."


def _explain_stop(stderr: str) -> str:
    """Return when and why an example stopped, from its error output."""
    match = re.search(r"status (\d+) at (\S+) s", stderr)
    if match is None:
        return "."
    status, bad = int(match[1]), len(STATUS_WORDS)
    why = "An argument was not finite, or out of its range." if status == bad else Status(status).sentence
    return f" at {match[2]} s of the scenario: {why.partition('. ')[0].rstrip('.')}."
