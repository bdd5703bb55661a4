/* Model exchange: an importer integrates the continuous states. What FMI 2 and 3 share.

   The state of the model holds what the importer sets; `settled` is the same with all that follows
   from it under the inputs, found when it is asked for. Solves begin where the last accepted step
   of the integrator ended, so that rates depend on states and inputs alone between such steps. */

/* From here a solve begins. */
static void accept_step(instance *i)
{
    if (!i->unsettled) memcpy(i->m.model.x, i->settled.x, sizeof i->m.model.x);
}

static int begin_event(instance *i)
{
    if (in_phase(i, "An event", 1u << CONTINUOUS_TIME)) return ERROR;
    accept_step(i);
    i->m.phase = EVENT;
    return OK;
}

static int end_event(instance *i)
{
    if (in_phase(i, "To go on in time", 1u << EVENT)) return ERROR;
    i->m.phase = CONTINUOUS_TIME;
    return OK;
}

static int complete_step(instance *i)
{
    if (in_phase(i, "To complete a step", 1u << CONTINUOUS_TIME)) return ERROR;
    const int status = settle(i);
    if (status == OK) accept_step(i);
    return status;
}

static int set_time(instance *i, double time)
{
    if (in_phase(i, "To set the time", 1u << EVENT | 1u << CONTINUOUS_TIME)) return ERROR;
    if (!isfinite(time)) return say(i, ERROR, "The time must be finite, but is %g.", time);
    i->m.time = time;
    return OK;
}

static int counted(const instance *i, const double *numbers, size_t count)
{
    if (count == FMU_CONTINUOUS && numbers != NULL) return OK;
    return say(i, ERROR, "There are %lu continuous states, but %lu numbers were handed over.",
               (unsigned long)FMU_CONTINUOUS, numbers == NULL ? 0ul : (unsigned long)count);
}

static int set_states(instance *i, const double *x, size_t count)
{
    if (in_phase(i, "To set continuous states", 1u << CONTINUOUS_TIME) || counted(i, x, count))
        return ERROR;
    for (size_t k = 0; k < count; k++)
        if (!isfinite(x[k]))
            return say(i, DISCARD, "Continuous state %lu must be finite, but is %g.",
                       (unsigned long)k, x[k]);
    for (size_t k = 0; k < count; k++) i->m.model.x[CORE(continuous)[k]] = x[k];
    spoil(i);
    return OK;
}

static int get_states(instance *i, double *x, size_t count)
{
    if (counted(i, x, count)) return ERROR;
    for (size_t k = 0; k < count; k++)
        if (get(i, (uint32_t)(STATE_KIND * FMU_KIND + k), &x[k])) return ERROR;
    return OK;
}

static int get_rates(instance *i, double *dx, size_t count)
{
    if (counted(i, dx, count)) return ERROR;
    if (in_phase(i, "To ask for rates", ~(1u << INSTANTIATED))) return ERROR;
    if (i->m.phase == INITIALIZING && refresh(i)) return ERROR;
    const int status = settle(i);
    if (status == OK) memcpy(dx, i->rates, sizeof i->rates);
    return status;
}

static int get_nominals(const instance *i, double *x, size_t count)
{
    if (counted(i, x, count)) return ERROR;
    memcpy(x, nominals, sizeof nominals);
    return OK;
}

static int get_indicators(const instance *i, size_t count)
{
    return count == 0 ? OK : say(i, ERROR, "This FMU has no event indicators.");
}

PASS(EnterEventMode, (void *c), begin_event(c))
PASS(EnterContinuousTimeMode, (void *c), end_event(c))
PASS(SetTime, (void *c, double time), set_time(c, time))
PASS(SetContinuousStates, (void *c, const double x[], size_t count), set_states(c, x, count))
PASS(GetContinuousStates, (void *c, double x[], size_t count), get_states(c, x, count))
PASS(GetNominalsOfContinuousStates, (void *c, double x[], size_t count), get_nominals(c, x, count))
PASS(GetEventIndicators, (void *c, double z[], size_t count), get_indicators(c, count))
