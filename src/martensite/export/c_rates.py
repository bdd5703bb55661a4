"""Right-hand side of a core in C, `NAME_differentiate`, for external integrators."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from martensite.export.c_core import CCore

DIFFERENTIATE = "differentiate"


def print_rates(core: CCore) -> str:
    """Return a template of `NAME_differentiate`; empty without continuous states."""
    return _RATES if core.continuous else ""


RATES_PROTOTYPE = """\
/* Rates dx[CONTINUOUS] in time of the continuous numbers of the state, of which NAME_continuous says where in x they
   are. `after` has the state that follows from them under the inputs u[INPUTS]; it may be m itself. Nothing is written
   unless all is finite. */
extern const int NAME_continuous[NAME_CONTINUOUS];
int NAME_differentiate(const NAME_model *m, const NAME_real *u, NAME_model *after, NAME_real *dx);

"""

_RATES = """
const int ${NAME}_continuous[${NAME}_CONTINUOUS] = {$CONTINUOUS};

int ${NAME}_differentiate(const ${NAME}_model *m, const ${NAME}_real *u, ${NAME}_model *after, ${NAME}_real *dx) {
    $REAL y[${NAME}_STATES + ${NAME}_CONTINUOUS];
    int i;
    if (!${NAME}_finite(u, ${NAME}_INPUTS)) return ${NAME}_BAD_INPUT;
    ${NAME}_kernel_differentiate(m->c, m->x, u, $ZERO, y);
    if (!${NAME}_finite(y, ${NAME}_STATES + ${NAME}_CONTINUOUS)) return ${NAME}_NOT_FINITE;
    if (after != m) *after = *m;
    for (i = 0; i < ${NAME}_STATES; i++) after->x[i] = y[i];
    for (i = 0; i < ${NAME}_CONTINUOUS; i++) dx[i] = y[${NAME}_STATES + i];
    return ${NAME}_OK;
}
"""
