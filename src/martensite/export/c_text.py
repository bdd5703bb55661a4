"""Header of a C core: one struct per model, and the functions on it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from martensite.base.status import Status
from martensite.export.c_kernels import precision_of
from martensite.export.c_names import CoreVariable

if TYPE_CHECKING:
    from martensite.export.c_core import CCore


def count_elements(count: int) -> int:
    """Return the length of an array; C has no arrays of length 0."""
    return max(1, count)


def header_text(core: CCore) -> str:
    """Return NAME.h."""
    name, guard = core.name, f"{core.name.upper()}_H"
    return (
        f"{_describe_core(core)}#ifndef {guard}\n#define {guard}\n\n"
        '#ifdef __cplusplus\nextern "C" {\n#endif\n\n'
        f"typedef {precision_of(core.precision).number} {name}_real;\n\n"
        f"{_print_counts(core)}"
        f"{_print_indices('Parameters: places in p', name, core.parameters)}"
        f"{_print_indices('Inputs: places in u', name, core.inputs)}"
        f"{_print_indices('Outputs: places in y', name, core.outputs)}"
        f"{_print_answers(core)}"
        f"{_print_declarations(core)}"
        "#ifdef __cplusplus\n}\n#endif\n\n#endif\n"
    )


def _describe_core(core: CCore) -> str:
    kind = f"`{precision_of(core.precision).number}`"
    pace = "" if core.sample is None else _PACE
    return (
        _format_comment(f"{core.name}: {core.description}.\n\n{_ABOUT.format(kind=kind, name=core.name)}{pace}") + "\n"
    )


_ABOUT = """\
Written by martensite (`martensite export c`) from the kernels that its simulations run. C99, in
{kind}; no allocation, no variables outside of the model, no library but libm, no recursion.
All quantities in SI: K, Pa, m, s.

    {name}_model m;
    {name}_defaults(&m);       parameters of the scenario
    {name}_start(&m, u);       at rest under the inputs u
    {name}_step(&m, u, dt);    go on by dt [s] under constant inputs
    {name}_observe(&m, u, y);  outputs in this state

For results equal to those of martensite bit for bit compile without -ffast-math and with
-ffp-contract=off (the default of gcc with -std=c99)."""
_PACE = """

It is a system in discrete time: a step goes on by one sample, and dt must be the sample time."""


def _format_comment(text: str) -> str:
    lines = [f" * {line}".rstrip() for line in _escape_comment(text).split("\n")]
    return "\n".join(["/*", *lines, " */"]) + "\n"


def _print_answers(core: CCore) -> str:
    if not core.answers:
        return ""
    rows = [f"    {core.name}_a_{answer} = {i},\n" for i, answer in enumerate(core.answers)]
    last = f"    {core.name}_ANSWERS = {len(core.answers)}\n"
    return (
        f"/* Answers of a step that is tried, as the outputs of their names. */\nenum {{\n{''.join(rows)}{last}}};\n\n"
    )


def _escape_comment(text: str) -> str:
    return text.replace("*/", "* /").replace("/*", "/ *")


def _print_counts(core: CCore) -> str:
    counts = {
        "PARAMETERS": len(core.parameters),
        "CONSTANTS": core.constants,
        "STATES": core.states,
        "INPUTS": len(core.inputs),
        "OUTPUTS": len(core.outputs),
    }
    rows = ",\n".join(f"    {core.name}_{key} = {count}" for key, count in counts.items())
    return f"enum {{\n{rows}\n}};\n\n"


def _print_indices(title: str, name: str, variables: Sequence[CoreVariable]) -> str:
    if not variables:
        return ""
    last = len(variables) - 1
    rows = [
        f"    {name}_{v.identifier} = {v.index}{',' if v.index < last else ''} /* [{_escape_comment(v.unit)}] "
        f"{_escape_comment(v.words)}{'' if v.has_effect else ' (changes nothing)'} */"
        for v in variables
    ]
    return f"/* {title}, with their units. */\nenum {{\n" + "\n".join(rows) + "\n};\n\n"


STATUS_WORDS = {
    Status.OK: "done",
    Status.LONG_STEP: "done, but coarse: the step crossed much of a transformation",
    Status.UNSOLVED: "not solved to its tolerance: the state is as it was; make a shorter step",
    Status.OUT_OF_RANGE: "kept for the numbers of martensite.simulate.Status; not given",
    Status.NOT_FINITE: "a number became infinite or none: the state is as it was",
}


def _print_declarations(core: CCore) -> str:
    name = core.name
    status = "".join(f"    {name}_{one.name} = {int(one)}, /* {words} */\n" for one, words in STATUS_WORDS.items())
    bad = "/* an argument is not finite, out of its range, or no sample time */"
    return (
        f"/* How a call ended. */\nenum {name}_status {{\n{status}"
        f"    {name}_BAD_INPUT = {len(STATUS_WORDS)} {bad}\n}};\n\n"
        "/* All that a model knows: only numbers, so copy it to save and to restore it. */\n"
        f"typedef struct {{\n"
        f"    {name}_real p[{count_elements(len(core.parameters))}]; /* parameters */\n"
        f"    {name}_real c[{count_elements(core.constants)}]; /* what follows from them */\n"
        f"    {name}_real x[{count_elements(core.states)}]; /* state */\n"
        f"    {name}_real residual, crossing; /* of the last step: mismatch that is left, share "
        f"of a strip crossed */\n}} {name}_model;\n\n"
        + (_PROTOTYPES + _TRIED * bool(core.answers)).replace("NAME", name)
    )


_PROTOTYPES = """\
/* Parameters of the scenario, prepared; the model must be started before it steps. */
void NAME_defaults(NAME_model *m);

/* After p has changed. BAD_INPUT if one is not finite or out of its range, NOT_FINITE if they
   contradict each other; only p is changed then. */
int NAME_prepare(NAME_model *m);

/* At rest under the inputs u[INPUTS]. */
int NAME_start(NAME_model *m, const NAME_real *u);

/* Go on by dt >= 0 under constant inputs u[INPUTS]; 0 keeps the state. */
int NAME_step(NAME_model *m, const NAME_real *u, NAME_real dt);

/* Outputs y[OUTPUTS] under the inputs u[INPUTS]; y is written only if all are finite. */
int NAME_observe(const NAME_model *m, const NAME_real *u, NAME_real *y);

"""

_TRIED = """\
/* Try a step from the state of m, which stays as it is, as often as wanted. It is committed by
   keeping `after`, which may be m itself. Inputs u[INPUTS] are those at the end of the step. y[ANSWERS]
   are answers there, and dy[a * INPUTS + i] the slope of answer a by input i, through the
   solve of the step: the consistent tangent. Nothing is written if the step fails.
   A step may take no time (dt = 0) where laws have no rates and the temperature is an input. */
int NAME_try(const NAME_model *m, const NAME_real *u, NAME_real dt, NAME_model *after, NAME_real *y,
             NAME_real *dy);

"""
