"""A material as a `uniaxialMaterial` of OpenSees, by its C interface for packages (`matObj`, `modelState`).

OpenSees (the Tcl program) loads a library named like the material, and calls its function of that name with an
operation code (`isw`). Strain comes from the host; temperature is a table over the model time, since OpenSees passes
none to a uniaxial material.
"""

from __future__ import annotations

from martensite.export.ports.host_source import join_source
from martensite.export.ports.kernel import PortKernel


def write_opensees(kernel: PortKernel, name: str) -> dict[str, str]:
    """Return the source of a package, and an example script, by file ending."""
    core = kernel.write_core(name=f"{name}_core")
    source = join_source(
        core, _PACKAGE.replace("MATERIAL", name), f"{name}: a uniaxialMaterial of OpenSees, written by martensite."
    )
    return {"_opensees.c": source, ".tcl": _SCRIPT.replace("MATERIAL", name)}


_PACKAGE = """\
/* ---------------------------------------------------------------- OpenSees

   $LAW

   uniaxialMaterial MATERIAL $$tag $$n $$t1 $$T1 ... $$tn $$Tn

   Temperatures T [K] at times t of the model, straight between them and as at the nearer end outside;
   n = 1 for a constant one. The material begins at the first of them. Stress is in Pa, strain counts
   from the start; a model in other units scales stress by an area in its units and a factor.

   cc -O2 -std=c99 -fPIC -shared -ffp-contract=off -o MATERIAL.so MATERIAL_opensees.c -lm

   What follows declares what it uses of the interface of OpenSees (SRC/api/elementAPI.h). */

enum { INIT = 0, COMMIT = 1, REVERT = 2, FORM = 3, REVERT_TO_START = 5, DELETE = 6, UNIAXIAL = 1 };

typedef struct {
    double time, dt;
} modelState;

typedef struct matObject {
    int tag, matType, nParam, nState;
    double *theParam, *cState, *tState;
    void (*matFunctPtr)(struct matObject *, modelState *, double *, double *, double *, int *, int *);
    void *matObjectPtr;
} matObj;

#ifdef _WIN32
#define ${NAME}_EXPORT __declspec(dllexport)
#else
#define ${NAME}_EXPORT __attribute__((visibility("default")))
#endif

extern int ops_error_(char *text, int length);
extern int ops_getintinput_(int *count, int *data);
extern int ops_getdoubleinput_(int *count, double *data);
extern int ops_allocatematerial_(matObj *material);

static int ${NAME}_say(const char *text) {
    char line[256];
    int i;
    for (i = 0; i < 255 && text[i]; i++) line[i] = text[i];
    line[i] = 0;
    ops_error_(line, 1);
    return -1;
}

/* Temperature [K] at a time, from n pairs of both. */
static double ${NAME}_temperature(const double *table, int n, double time) {
    int k;
    if (time <= table[0]) return table[1];
    for (k = 1; k < n; k++) {
        const double *a = table + 2 * (k - 1), *b = table + 2 * k;
        if (time <= b[0]) return a[1] + (b[1] - a[1]) * (time - a[0]) / (b[0] - a[0]);
    }
    return table[2 * n - 1];
}

/* States hold whether and when they were reached, strain, temperature, then those of the kernel. */
enum { ${NAME}_TIME = 0, ${NAME}_KEPT = 1, ${NAME}_COUNT = 1 + ${NAME}_STATES };

static int ${NAME}_begin(matObj *material) {
    double u[${NAME}_INPUTS];
    ${NAME}_model m;
    int i;
    ${NAME}_defaults(&m);
    u[${NAME}_u_strain] = 0.0;
    u[${NAME}_u_temperature] = material->theParam[2];
    if (${NAME}_start(&m, u) != ${NAME}_OK) return ${NAME}_say("MATERIAL cannot be started at this temperature.");
    material->cState[${NAME}_TIME] = material->theParam[1];
    for (i = 0; i < ${NAME}_STATES; i++) material->cState[${NAME}_KEPT + i] = m.x[i];
    for (i = 0; i < ${NAME}_COUNT; i++) material->tState[i] = material->cState[i];
    return 0;
}

/* theParam: number of pairs, then the pairs. */
static int ${NAME}_create(matObj *material) {
    int one = 1, two, tag, n, k;
    double *table;
    if (ops_getintinput_(&one, &tag) < 0 || ops_getintinput_(&one, &n) < 0 || n < 1 || n > 10000)
        return ${NAME}_say("MATERIAL takes a tag, a number of pairs, and so many pairs of time and temperature [K].");
    material->tag = tag;
    material->nParam = 1 + 2 * n;
    material->nState = ${NAME}_COUNT;
    ops_allocatematerial_(material);
    table = material->theParam + 1;
    material->theParam[0] = n;
    for (k = 0; k < n; k++) {
        two = 2;
        if (ops_getdoubleinput_(&two, table + 2 * k) < 0)
            return ${NAME}_say("MATERIAL misses a pair of time and temperature [K].");
        if (k > 0 && !(table[2 * k] > table[2 * k - 2])) return ${NAME}_say("Times of MATERIAL must rise.");
    }
    return ${NAME}_begin(material);
}

/* Stress and tangent at a trial strain, from what is committed. */
static int ${NAME}_form(matObj *material, const modelState *model, double strain, double *tangent, double *stress) {
    double u[${NAME}_INPUTS], y[${NAME}_ANSWERS], dy[${NAME}_ANSWERS * ${NAME}_INPUTS];
    const double time = model == 0 ? material->cState[${NAME}_TIME] : model->time;
    const double dt = time - material->cState[${NAME}_TIME];
    ${NAME}_model m;
    int i;
    ${NAME}_defaults(&m);
    for (i = 0; i < ${NAME}_STATES; i++) m.x[i] = material->cState[${NAME}_KEPT + i];
    u[${NAME}_u_strain] = strain;
    u[${NAME}_u_temperature] = ${NAME}_temperature(material->theParam + 1, (int)material->theParam[0], time);
    if (${NAME}_try(&m, u, dt > 0.0 ? dt : 0.0, &m, y, dy) >= ${NAME}_UNSOLVED)
        return ${NAME}_say("MATERIAL did not solve a step; make it shorter.");
    material->tState[${NAME}_TIME] = time;
    for (i = 0; i < ${NAME}_STATES; i++) material->tState[${NAME}_KEPT + i] = m.x[i];
    *stress = y[${NAME}_a_stress];
    *tangent = dy[${NAME}_a_stress * ${NAME}_INPUTS + ${NAME}_u_strain];
    return 0;
}

${NAME}_EXPORT void localInit(void) {
    (void)${NAME}_say("MATERIAL: $LAW, written by martensite");
}

${NAME}_EXPORT void MATERIAL(matObj *material, modelState *model, double *strain, double *tangent, double *stress,
                             int *isw, int *result) {
    int i;
    *result = 0;
    switch (*isw) {
    case INIT: *result = ${NAME}_create(material) < 0 ? -1 : UNIAXIAL; break;
    case COMMIT:
        for (i = 0; i < ${NAME}_COUNT; i++) material->cState[i] = material->tState[i];
        break;
    case REVERT:
        for (i = 0; i < ${NAME}_COUNT; i++) material->tState[i] = material->cState[i];
        break;
    case REVERT_TO_START: *result = ${NAME}_begin(material); break;
    case FORM: *result = ${NAME}_form(material, model, *strain, tangent, stress); break;
    default: break;
    }
}
"""

_SCRIPT = """\
# A bar of 1 m and 1 mm^2 of MATERIAL, pulled by 5 % in 100 steps and let go, at 25 degrees Celsius. It needs
# MATERIAL.so in this folder, and OpenSees itself: openseespy loads no packages.
model basic -ndm 1 -ndf 1
node 1 0.0
node 2 1.0
fix 1 1
uniaxialMaterial MATERIAL 1 1 0.0 298.15
element truss 1 1 2 1.0e-6 1
timeSeries Path 1 -time {0.0 1.0 2.0} -values {0.0 0.05 0.0}
pattern Plain 1 1 { sp 2 1 1.0 }
constraints Penalty 1.0e12 1.0e12
numberer Plain
system BandGeneral
test NormDispIncr 1.0e-12 20
algorithm Newton
integrator LoadControl 0.01
analysis Static
recorder Element -file MATERIAL.out -time -ele 1 axialForce
analyze 200
"""
