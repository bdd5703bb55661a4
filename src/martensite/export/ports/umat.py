"""A material as a user material of Abaqus and CalculiX: the interface `UMAT` on a port.

The first component of stress and strain follows the law; trusses have no other. Where a host has more (`NTENS` > 1:
CalculiX computes trusses as solids), the others are those of a linear elastic fibre without lateral contraction,

    σ_k = E_l ε_k,    τ_k = E_l/2 γ_k,

uncoupled from the first, so that a bar along its first axis carries axial stress alone.
"""

from __future__ import annotations

from string import Template

from martensite.export.c_core import CCore
from martensite.export.ports.kernel import PortKernel

CONSTANTS = 4
"""Number of constants before the parameters of the material."""
SHOWN = 5
"""State variables before those of the kernel."""


def write_umat(kernel: PortKernel, name: str) -> dict[str, str]:
    """Return the source of a user material, and the lines of its input file, by file ending."""
    core = kernel.write_core(name=name)
    whole = core.source.replace(f'#include "{core.name}.h"', core.header)
    rows = [
        f"     {place + 1:3d}  {one.default:<14.8g} {one.name} [{one.unit}]\n"
        for place, one in enumerate(core.parameters)
    ]
    interface = Template(_UMAT).substitute(
        NAME=core.name, LAW=core.description, PARAMETERS="".join(rows), INDEX=len(rows)
    )
    title = f"{name}: a user material of Abaqus and CalculiX, written by martensite."
    return {"_umat.c": f"/* {title} */\n\n{whole}\n{interface}", "_umat.inp": _write_deck(core)}


def count_state_variables(kernel: PortKernel) -> int:
    """Return the value of `*DEPVAR` of a material."""
    return SHOWN + kernel.size


def _write_deck(core: CCore) -> str:
    return (
        f"** {core.description}\n"
        "** Constants: Pa per unit of stress; kelvin at zero of the scale of temperature; lateral modulus (0: that of\n"
        "** the axis at the start); temperature at the start. Units here: N, mm, MPa, degrees Celsius.\n"
        f"*MATERIAL, NAME={core.name.upper()}\n*DEPVAR\n{SHOWN + core.states},\n"
        f"*USER MATERIAL, CONSTANTS={CONSTANTS}\n1.E6, 273.15, 0., 25.\n"
    )


_UMAT = """\
/* ---------------------------------------------------------------- UMAT

   $LAW

   PROPS(1)  Pa per unit of stress of the model: 1 for SI, 1.0E6 for MPa (left out, or 0: 1)
   PROPS(2)  kelvin at the zero of its temperatures: 0, or 273.15 for degrees Celsius
   PROPS(3)  modulus of what is not axial, in units of the model; 0: that of the axis at the start
   PROPS(4)  temperature at the start; left out: that of the first increment, as Abaqus hands it over
             (CalculiX hands over that at the end of the increment: give it there)
   PROPS(5…) all $INDEX parameters of the material, or none for these:
$PARAMETERS
   STATEV    1 started; 2 martensite fraction; 3 net oriented fraction; 4 latent heat of the
             increment, per volume; 5 share of a strip that its elastic trial crossed; then the state.
   STRAN must hold all strain: give no *EXPANSION. Strain is small, or that of the host.
   RPL, DDSDDT, DRPLDE, DRPLDT are set for coupled analyses; SSE, SPD, SCD are not.
   An increment that fails sets PNEWDT to 0.5 and STRESS to no number. */

#include <stdio.h>
#include <stdlib.h>

#ifdef _WIN32
#define ${NAME}_UMAT __declspec(dllexport) void UMAT
#else
#define ${NAME}_UMAT __attribute__((visibility("default"))) void umat_
#endif

static double ${NAME}_prop(const double *props, const int *nprops, int place, double usual) {
    return *nprops > place ? props[place] : usual;
}

static void ${NAME}_refuse(const char *why) {
    fprintf(stderr, " *ERROR in the user material $NAME: %s\\n", why);
    exit(201);
}

/* The numbers of the material; they are prepared in every call, so that threads share nothing. */
static void ${NAME}_load(${NAME}_model *m, const double *props, const int *nprops) {
    int i;
    ${NAME}_defaults(m);
    if (*nprops <= 4) return;
    if (*nprops != 4 + ${NAME}_PARAMETERS) ${NAME}_refuse("it takes up to 4 constants, or 4 and all parameters");
    for (i = 0; i < ${NAME}_PARAMETERS; i++) m->p[i] = props[4 + i];
    if (${NAME}_prepare(m) != ${NAME}_OK) ${NAME}_refuse("its parameters are out of range, or contradict each other");
}

/* Axial modulus [Pa] of the state at the start. */
static double ${NAME}_modulus(const ${NAME}_model *m, double temperature) {
    ${NAME}_model start = *m, after;
    double u[${NAME}_INPUTS] = {0.0, 0.0}, y[${NAME}_ANSWERS], dy[${NAME}_ANSWERS * ${NAME}_INPUTS];
    u[${NAME}_u_temperature] = temperature;
    if (${NAME}_start(&start, u) != ${NAME}_OK) ${NAME}_refuse("it cannot be started at this temperature");
    if (${NAME}_try(&start, u, 0.0, &after, y, dy) >= ${NAME}_UNSOLVED) ${NAME}_refuse("it has no modulus");
    return dy[${NAME}_a_stress * ${NAME}_INPUTS + ${NAME}_u_strain];
}

${NAME}_UMAT(double *stress, double *statev, double *ddsdde, double *sse, double *spd, double *scd, double *rpl,
             double *ddsddt, double *drplde, double *drpldt, const double *stran, const double *dstran,
             const double *time, const double *dtime, const double *temp, const double *dtemp, const double *predef,
             const double *dpred, const char *cmname, const int *ndi, const int *nshr, const int *ntens,
             const int *nstatv, const double *props, const int *nprops, const double *coords, const double *drot,
             double *pnewdt, const double *celent, const double *dfgrd0, const double *dfgrd1, const int *noel,
             const int *npt, const int *layer, const int *kspt, const int *kstep, const int *kinc, int cmname_length) {
    enum { SHOWN = 5 };
    const double given = ${NAME}_prop(props, nprops, 0, 1.0), unit = given > 0.0 ? given : 1.0;
    const double zero = ${NAME}_prop(props, nprops, 1, 0.0);
    const double first = zero + ${NAME}_prop(props, nprops, 3, *temp);
    double lateral = unit * ${NAME}_prop(props, nprops, 2, 0.0);
    double u[${NAME}_INPUTS], y[${NAME}_ANSWERS], dy[${NAME}_ANSWERS * ${NAME}_INPUTS], seen[${NAME}_OUTPUTS];
    const double per = *dtime > 0.0 ? 1.0 / *dtime : 0.0;
    ${NAME}_model m;
    int i, status;
    (void)sse, (void)spd, (void)scd, (void)time, (void)predef, (void)dpred, (void)cmname, (void)nshr, (void)coords;
    (void)drot, (void)celent, (void)dfgrd0, (void)dfgrd1, (void)noel, (void)npt, (void)layer, (void)kspt, (void)kstep;
    (void)kinc, (void)cmname_length;
    if (*nstatv < SHOWN + ${NAME}_STATES) ${NAME}_refuse("*DEPVAR is too small for its state");
    ${NAME}_load(&m, props, nprops);
    if (statev[0] != 1.0) {
        u[${NAME}_u_strain] = stran[0];
        u[${NAME}_u_temperature] = first;
        if (${NAME}_start(&m, u) != ${NAME}_OK) ${NAME}_refuse("it cannot be started at this temperature");
    } else {
        for (i = 0; i < ${NAME}_STATES; i++) m.x[i] = statev[SHOWN + i];
    }
    u[${NAME}_u_strain] = stran[0] + dstran[0];
    u[${NAME}_u_temperature] = zero + *temp + *dtemp;
    status = ${NAME}_try(&m, u, *dtime, &m, y, dy);
    if (status < ${NAME}_UNSOLVED && ${NAME}_observe(&m, u, seen) != ${NAME}_OK) status = ${NAME}_NOT_FINITE;
    if (status >= ${NAME}_UNSOLVED) {
        *pnewdt = 0.5;
        for (i = 0; i < *ntens; i++) stress[i] = NAN;
        return;
    }
    if (*ntens > 1 && lateral <= 0.0) lateral = ${NAME}_modulus(&m, first);
    for (i = 0; i < *ntens * *ntens; i++) ddsdde[i] = 0.0;
    for (i = 0; i < *ntens; i++) {
        const double stiffness = (i < *ndi ? lateral : 0.5 * lateral) / unit;
        stress[i] = stiffness * (stran[i] + dstran[i]);
        ddsdde[i * (*ntens + 1)] = stiffness;
        ddsddt[i] = drplde[i] = 0.0;
    }
    stress[0] = y[${NAME}_a_stress] / unit;
    ddsdde[0] = dy[${NAME}_a_stress * ${NAME}_INPUTS + ${NAME}_u_strain] / unit;
    ddsddt[0] = dy[${NAME}_a_stress * ${NAME}_INPUTS + ${NAME}_u_temperature] / unit;
    *rpl = y[${NAME}_a_heat] / unit * per;
    drplde[0] = dy[${NAME}_a_heat * ${NAME}_INPUTS + ${NAME}_u_strain] / unit * per;
    *drpldt = dy[${NAME}_a_heat * ${NAME}_INPUTS + ${NAME}_u_temperature] / unit * per;
    statev[0] = 1.0;
    statev[1] = seen[${NAME}_y_martensite_fraction];
    statev[2] = seen[${NAME}_y_oriented_fraction];
    statev[3] = y[${NAME}_a_heat] / unit;
    statev[4] = m.crossing;
    for (i = 0; i < ${NAME}_STATES; i++) statev[SHOWN + i] = m.x[i];
}
"""
