/* Steps of the co-simulation: what FMI 2 and 3 share. */

#include "values.c"

/* Inner steps of a system in continuous time; the last one ends where the step does. */
static int march(instance *i, double length)
{
    const double pieces = fmax(1.0, ceil(length / i->m.inner - 1e-9));
    if (pieces > FMU_MOST_STEPS) return -1;
    const double dt = length / pieces;
    double u[FMU_INPUTS + 1];
    int worst = CORE_STATUS(OK);
#ifdef FMU_VELOCITY
    i->m.slopes[FMU_MOVED] = i->m.inputs[FMU_VELOCITY];
#endif
    for (double k = 0.0; k < pieces; k += 1.0) {
        for (int d = 0; d < FMU_INPUTS; d++)
            u[d] = i->m.inputs[d] + i->m.slopes[d] * ((k + sampled_at[d]) * dt);
        const int status = CORE(step)(&i->m.model, u, dt);
        if (status > worst) worst = status;
        if (worst >= CORE_STATUS(UNSOLVED)) break;
    }
    for (int d = 0; d < FMU_INPUTS; d++) u[d] = i->m.inputs[d] + i->m.slopes[d] * length;
    if (worst < CORE_STATUS(UNSOLVED)) memcpy(i->m.inputs, u, sizeof(double) * FMU_INPUTS);
    return worst;
}

/* All periods of a system in discrete time that end within the step. */
static int sample(instance *i, double end)
{
    const double wanted = floor((end - i->m.start) / FMU_PERIOD + 1e-6);
    int worst = CORE_STATUS(OK);
    if (wanted - i->m.count > FMU_MOST_STEPS) return -1;
    while (i->m.count < wanted && worst < CORE_STATUS(UNSOLVED)) {
        const int status = CORE(step)(&i->m.model, i->m.inputs, FMU_PERIOD);
        if (status > worst) worst = status;
        i->m.count += 1.0;
    }
    return worst;
}

static int refused(instance *i, double time, double length, const char *why)
{
    const int again = i->refused_step >= 0.0 && i->refused_step <= length;
    i->refused_step = length;
    i->stale = 1;
    if (again)
        return say(i, ERROR, "The step from %g s over %g s failed again: %s.", time, length, why);
    return say(i, DISCARD, "The step from %g s over %g s failed: %s. Try a shorter one.", time,
               length, why);
}

static int advance(instance *i, double time, double length)
{
    if (in_phase(i, "A step", 1u << STEPPING)) return ERROR;
    if (!isfinite(time) || !isfinite(length))
        return say(i, ERROR, "Time and length of a step must be finite, but are %g and %g.", time,
                   length);
    if (length <= 0.0)
        return say(i, ERROR, "A step must be longer than 0 s, but is %g s.", length);
    if (fabs(time - i->m.time) > 1e-9 * (fabs(time) + length))
        return say(i, ERROR, "A step must begin at %.9g s, where the last one ended, but begins "
                   "at %.9g s.", i->m.time, time);
    const double count = i->m.count;
    double inputs[FMU_INPUTS + 1];
    memcpy(inputs, i->m.inputs, sizeof inputs);
    memcpy(i->before, i->m.model.x, sizeof i->m.model.x);
    const int status = FMU_PERIOD > 0.0 ? sample(i, time + length) : march(i, length);
    if (status >= 0 && status < CORE_STATUS(UNSOLVED)) {
        const int seen = CORE(observe)(&i->m.model, i->m.inputs, i->outputs);
        if (seen < CORE_STATUS(UNSOLVED) && finite_outputs(i)) {
            memset(i->m.slopes, 0, sizeof i->m.slopes);
            i->m.time = time + length;
            i->stale = 0;
            i->refused_step = -1.0;
            if (status != CORE_STATUS(LONG_STEP) || i->m.coarse) return OK;
            i->m.coarse = 1;
            return say(i, WARNING, "At %g s %s: the result is coarse; try a smaller `inner_step`.",
                       time, outcome(status));
        }
    }
    memcpy(i->m.model.x, i->before, sizeof i->m.model.x);
    memcpy(i->m.inputs, inputs, sizeof inputs);
    i->m.count = count;
    if (status < 0) return refused(i, time, length, "it has too many inner steps");
    return refused(i, time, length,
                   outcome(status < CORE_STATUS(UNSOLVED) ? CORE_STATUS(NOT_FINITE) : status));
}
