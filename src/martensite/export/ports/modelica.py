"""An element as a Modelica package: a model between two flanges, on functions in C.

The state is a vector of discrete variables, advanced by a pure function at every sample; so an event iteration may
ask again. Between samples the force follows the elongation by the consistent tangent of the last step,

    F(t) = F_k + ∂F/∂e (e(t) - e_k)     while taut,

which couples it to a mass implicitly, by the solver of the tool. No Modelica tool was at hand: the C is tried, the
package is written by the specification of the language, 3.4 and later, and has not been run.
"""

from __future__ import annotations

from string import Template

from martensite.export.c_core import CCore
from martensite.export.ports.host_source import join_source
from martensite.export.ports.kernel import PortKernel


def write_modelica(kernel: PortKernel, name: str, period: float) -> dict[str, str]:
    """Files of a package by their paths below its folder; `period` [s] is that of its samples by default."""
    core = kernel.write_core(name=f"{name}_core")
    source = join_source(core, _SOURCE, f"{name}: functions of a Modelica package, written by martensite.")
    guard = f"{name.upper()}_MODELICA"  # tools put it in once for every function
    guarded = f"#ifndef {guard}\n#define {guard}\n\n{source}\n#endif\n"
    return {"package.mo": _write_package(core, name, period), f"Resources/Include/{name}.c": guarded}


def _write_package(core: CCore, name: str, period: float) -> str:
    drive = core.inputs[0]
    return Template(_PACKAGE).substitute(
        NAME=name, CORE=core.name, WHAT=core.description, STATES=core.states, PERIOD=repr(period), UNIT=drive.unit
    )


_SOURCE = """\
/* ---------------------------------------------------------------- Modelica

   $LAW */

extern void ModelicaFormatError(const char *text, ...);

enum { ${NAME}_SHOWN = 6 };

static void ${NAME}_show(const ${NAME}_model *m, const double *u, double tangent, double *y) {
    double seen[${NAME}_OUTPUTS];
    if (${NAME}_observe(m, u, seen) != ${NAME}_OK) ModelicaFormatError("$NAME: an output is no finite number.\\n");
    y[0] = seen[${NAME}_y_force];
    y[1] = seen[${NAME}_y_temperature];
    y[2] = seen[${NAME}_y_resistance];
    y[3] = seen[${NAME}_y_martensite_fraction];
    y[4] = seen[${NAME}_y_heat_loss];
    y[5] = tangent;
}

/* State x[STATES] as mounted under inputs u, and y: force, temperature, resistance, fraction, heat loss, dF/de. */
void ${NAME}_modelica_start(const double *u, double *x, double *y) {
    double answer[${NAME}_ANSWERS], slopes[${NAME}_ANSWERS * ${NAME}_INPUTS];
    ${NAME}_model m, after;
    int i;
    ${NAME}_defaults(&m);
    if (${NAME}_start(&m, u) != ${NAME}_OK) ModelicaFormatError("$NAME cannot be started under these inputs.\\n");
    if (${NAME}_try(&m, u, 1e-9, &after, answer, slopes) >= ${NAME}_UNSOLVED)
        ModelicaFormatError("$NAME has no stiffness to start with.\\n");
    for (i = 0; i < ${NAME}_STATES; i++) x[i] = m.x[i];
    ${NAME}_show(&m, u, slopes[${NAME}_a_force * ${NAME}_INPUTS + ${NAME}_u_elongation], y);
}

/* State and y after a step of dt [s] from x, at whose end the inputs u hold. */
void ${NAME}_modelica_advance(const double *x, const double *u, double dt, double *after, double *y) {
    double answer[${NAME}_ANSWERS], slopes[${NAME}_ANSWERS * ${NAME}_INPUTS];
    ${NAME}_model m;
    int i;
    ${NAME}_defaults(&m);
    for (i = 0; i < ${NAME}_STATES; i++) m.x[i] = x[i];
    if (${NAME}_try(&m, u, dt, &m, answer, slopes) >= ${NAME}_UNSOLVED)
        ModelicaFormatError("$NAME did not solve a step of %g s; choose a shorter period.\\n", dt);
    for (i = 0; i < ${NAME}_STATES; i++) after[i] = m.x[i];
    ${NAME}_show(&m, u, slopes[${NAME}_a_force * ${NAME}_INPUTS + ${NAME}_u_elongation], y);
}
"""

_PACKAGE = """\
package ${NAME} "${WHAT}"

  constant Integer states = ${STATES} "Numbers of a state";
  constant Integer shown = 6 "Force, temperature, resistance, martensite fraction, heat loss, dF/de";

  function start "State as mounted, at rest"
    input Real u[3] "Drive [${UNIT}], elongation [m], ambient temperature [K]";
    output Real x[states];
    output Real y[shown];
  external "C" ${CORE}_modelica_start(u, x, y)
    annotation(Include="#include \\"${NAME}.c\\"", IncludeDirectory="modelica://${NAME}/Resources/Include");
  end start;

  function advance "State after a step, at whose end the inputs hold"
    input Real x[states];
    input Real u[3] "Drive [${UNIT}], elongation [m], ambient temperature [K]";
    input Real dt "[s]";
    output Real after[states];
    output Real y[shown];
  external "C" ${CORE}_modelica_advance(x, u, dt, after, y)
    annotation(Include="#include \\"${NAME}.c\\"", IncludeDirectory="modelica://${NAME}/Resources/Include");
  end advance;

  model Element "An element between two flanges; it pulls and never pushes"
    parameter Modelica.Units.SI.Time period = ${PERIOD} "From sample to sample";
    parameter Modelica.Units.SI.Length mounted = 0 "Distance of the flanges as mounted";
    Modelica.Mechanics.Translational.Interfaces.Flange_a flange_a;
    Modelica.Mechanics.Translational.Interfaces.Flange_b flange_b;
    Modelica.Thermal.HeatTransfer.Interfaces.HeatPort_a surroundings "What cools it";
    Modelica.Blocks.Interfaces.RealInput drive "Drive [${UNIT}]";
    Modelica.Blocks.Interfaces.RealOutput temperature "[K]";
    Modelica.Blocks.Interfaces.RealOutput resistance "[ohm]";
    Modelica.Blocks.Interfaces.RealOutput martensite_fraction "[1]";
    Modelica.Units.SI.Length elongation "From where it is mounted";
    Modelica.Units.SI.Force force "Tension";
  protected
    discrete Real x[states] "State";
    discrete Real y[shown] "What it says of itself";
    discrete Modelica.Units.SI.Length sampled "Elongation at the last sample";
  initial equation
    (x, y) = start({drive, elongation, surroundings.T});
    sampled = elongation;
  equation
    elongation = flange_b.s - flange_a.s - mounted;
    when sample(period, period) then
      (x, y) = advance(pre(x), {drive, elongation, surroundings.T}, period);
      sampled = elongation;
    end when;
    force = max(0, y[1] + y[6]*(elongation - sampled));
    flange_b.f = force;
    flange_a.f = -force;
    temperature = y[2];
    resistance = y[3];
    martensite_fraction = y[4];
    surroundings.Q_flow = -y[5];
  end Element;

  annotation(uses(Modelica(version="4.0.0")));
end ${NAME};
"""
