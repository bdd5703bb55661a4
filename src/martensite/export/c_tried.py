"""Trial steps for a host in C: `NAME_try` of the core of a port, with derivatives.

It computes the same as `martensite.export.ports.kernel.PortKernel.try_step` on floats: for a core with `probes`, an
unsolved step is split into equal parts, and its derivatives are central differences.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from martensite.export.c_core import CCore

PARTS = 64
"""Largest number of parts of a step."""


def print_tried(core: CCore) -> str:
    """Return a template of `NAME_try`; empty without answers."""
    if not core.answers:
        return ""
    parts = (_IN_PARTS, _IN_PARTS_CALL) if core.probes else ("", "")
    return _TRIED.replace("IN_PARTS_CALL", parts[1]).replace("IN_PARTS", parts[0])


_TRIED = """
enum {
    ${NAME}_ANSWERED = ${NAME}_STATES + 2,
    ${NAME}_SLOPED = ${NAME}_STATES + 2 + ${NAME}_ANSWERS,
    ${NAME}_TRIED = ${NAME}_STATES + 2 + ${NAME}_ANSWERS * (1 + ${NAME}_INPUTS)
};

/* How a step ended that is in `found`: state, residual, crossing, answers, slopes. */
static int ${NAME}_judge(const $REAL *found) {
    if (!${NAME}_finite(found, ${NAME}_TRIED)) return ${NAME}_NOT_FINITE;
    if (found[${NAME}_STATES] > $SOLVED) return ${NAME}_UNSOLVED;
    return found[${NAME}_STATES + 1] > $COARSE ? ${NAME}_LONG_STEP : ${NAME}_OK;
}
IN_PARTS
int ${NAME}_try(const ${NAME}_model *m, const ${NAME}_real *u, ${NAME}_real dt, ${NAME}_model *after,
                ${NAME}_real *y, ${NAME}_real *dy) {
    $REAL found[${NAME}_TRIED];
    int i, status;
    if (!${NAME}_finite(u, ${NAME}_INPUTS)) return ${NAME}_BAD_INPUT;
    if (!(dt >= $ZERO && dt <= $LARGEST)) return ${NAME}_BAD_INPUT;
    ${NAME}_kernel_respond(m->c, m->x, u, dt, found);
    status = ${NAME}_judge(found);
IN_PARTS_CALL    if (status >= ${NAME}_UNSOLVED) return status;
    if (after != m) *after = *m;
    for (i = 0; i < ${NAME}_STATES; i++) after->x[i] = found[i];
    after->residual = found[${NAME}_STATES];
    after->crossing = found[${NAME}_STATES + 1];
    for (i = 0; i < ${NAME}_ANSWERS; i++) y[i] = found[${NAME}_ANSWERED + i];
    for (i = 0; i < ${NAME}_ANSWERS * ${NAME}_INPUTS; i++) dy[i] = found[${NAME}_SLOPED + i];
    return status;
}
"""

_IN_PARTS = """
/* Changes of the inputs by which a step in parts is differenced. */
static const $REAL ${NAME}_probe[${NAME}_INPUTS] = {$PROBES};

/* A step in equal parts; the inputs where it begins are the first numbers of the state. */
static int ${NAME}_in_parts(const ${NAME}_model *m, const $REAL *u, $REAL dt, int parts, $REAL *found) {
    $REAL x[${NAME}_STATES], v[${NAME}_INPUTS], worst = $ZERO, crossing = $ZERO;
    int i, k;
    for (i = 0; i < ${NAME}_STATES; i++) x[i] = m->x[i];
    for (k = 1; k <= parts; k++) {
        const $REAL share = ($REAL)k / ($REAL)parts;
        for (i = 0; i < ${NAME}_INPUTS; i++) v[i] = k < parts ? m->x[i] + (u[i] - m->x[i]) * share : u[i];
        ${NAME}_kernel_respond(m->c, x, v, dt / ($REAL)parts, found);
        if (!${NAME}_finite(found, ${NAME}_TRIED)) return ${NAME}_NOT_FINITE;
        if (found[${NAME}_STATES] > worst) worst = found[${NAME}_STATES];
        if (found[${NAME}_STATES + 1] > crossing) crossing = found[${NAME}_STATES + 1];
        for (i = 0; i < ${NAME}_STATES; i++) x[i] = found[i];
    }
    found[${NAME}_STATES] = worst;
    found[${NAME}_STATES + 1] = crossing;
    return ${NAME}_judge(found);
}

static int ${NAME}_difference(const ${NAME}_model *m, const $REAL *u, $REAL dt, int parts, $REAL *found) {
    $REAL side[2][${NAME}_TRIED], v[${NAME}_INPUTS];
    int a, i, k, s;
    for (i = 0; i < ${NAME}_INPUTS; i++) {
        for (s = 0; s < 2; s++) {
            int status;
            for (k = 0; k < ${NAME}_INPUTS; k++) v[k] = u[k];
            v[i] = u[i] + (s == 0 ? ${NAME}_probe[i] : -${NAME}_probe[i]);
            status = ${NAME}_in_parts(m, v, dt, parts, side[s]);
            if (status >= ${NAME}_UNSOLVED) return status;
        }
        for (a = 0; a < ${NAME}_ANSWERS; a++)
            found[${NAME}_SLOPED + a * ${NAME}_INPUTS + i] =
                (side[0][${NAME}_ANSWERED + a] - side[1][${NAME}_ANSWERED + a]) / ($TWO * ${NAME}_probe[i]);
    }
    return ${NAME}_judge(found);
}
"""

_IN_PARTS_CALL = """\
    for (i = 2; i <= $PARTS && status == ${NAME}_UNSOLVED; i *= 2) {
        status = ${NAME}_in_parts(m, u, dt, i, found);
        if (status < ${NAME}_UNSOLVED) status = ${NAME}_difference(m, u, dt, i, found);
    }
"""
