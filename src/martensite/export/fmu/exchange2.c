/* The functions of FMI 2.0 for model exchange, on what exchange.c has. */

FMI(fmi2EnterEventMode)(void *c) { return c == NULL ? ERROR : begin_event(c); }

FMI(fmi2EnterContinuousTimeMode)(void *c) { return c == NULL ? ERROR : end_event(c); }

typedef struct {
    int new_discrete_states, terminate, nominals_changed, values_changed, next_defined;
    double next;
} event_info2;

/* Inputs that jump are all that can happen: nothing is left to be iterated. */
FMI(fmi2NewDiscreteStates)(void *c, event_info2 *info)
{
    if (c == NULL || info == NULL || in_phase(c, "To update discrete states", 1u << EVENT))
        return ERROR;
    memset(info, 0, sizeof *info);
    return OK;
}

FMI(fmi2CompletedIntegratorStep)(void *c, int no_state_before, int *event_mode, int *terminated)
{
    (void)no_state_before;
    if (c == NULL) return ERROR;
    if (event_mode != NULL) *event_mode = 0;
    if (terminated != NULL) *terminated = 0;
    return complete_step(c);
}

FMI(fmi2SetTime)(void *c, double time) { return c == NULL ? ERROR : set_time(c, time); }

FMI(fmi2SetContinuousStates)(void *c, const double x[], size_t count)
{
    return c == NULL ? ERROR : set_states(c, x, count);
}

FMI(fmi2GetContinuousStates)(void *c, double x[], size_t count)
{
    return c == NULL ? ERROR : get_states(c, x, count);
}

FMI(fmi2GetDerivatives)(void *c, double dx[], size_t count)
{
    return c == NULL ? ERROR : get_rates(c, dx, count);
}

FMI(fmi2GetNominalsOfContinuousStates)(void *c, double x[], size_t count)
{
    return c == NULL ? ERROR : get_nominals(c, x, count);
}

FMI(fmi2GetEventIndicators)(void *c, double z[], size_t count)
{
    (void)z;
    return c == NULL ? ERROR : get_indicators(c, count);
}
