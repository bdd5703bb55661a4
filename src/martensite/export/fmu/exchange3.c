/* The functions of FMI 3.0 for model exchange, on what exchange.c has. */

FMI(fmi3EnterEventMode)(void *c) { return c == NULL ? ERROR : begin_event(c); }

FMI(fmi3EnterContinuousTimeMode)(void *c) { return c == NULL ? ERROR : end_event(c); }

/* Inputs that jump are all that can happen: nothing is left to be iterated. */
FMI(fmi3UpdateDiscreteStates)(void *c, bool *update, bool *terminated, bool *nominals_changed,
                              bool *values_changed, bool *defined, double *next)
{
    bool *const flags[] = {update, terminated, nominals_changed, values_changed, defined};
    if (c == NULL || in_phase(c, "To update discrete states", 1u << EVENT)) return ERROR;
    for (size_t k = 0; k < sizeof flags / sizeof *flags; k++)
        if (flags[k] != NULL) *flags[k] = false;
    if (next != NULL) *next = 0.0;
    return OK;
}

FMI(fmi3CompletedIntegratorStep)(void *c, bool no_state_before, bool *event_mode, bool *terminated)
{
    if (c == NULL) return ERROR;
    if (event_mode != NULL) *event_mode = false;
    if (terminated != NULL) *terminated = false;
    return complete_step(c);
}

FMI(fmi3SetTime)(void *c, double time) { return c == NULL ? ERROR : set_time(c, time); }

FMI(fmi3SetContinuousStates)(void *c, const double x[], size_t count)
{
    return c == NULL ? ERROR : set_states(c, x, count);
}

FMI(fmi3GetContinuousStates)(void *c, double x[], size_t count)
{
    return c == NULL ? ERROR : get_states(c, x, count);
}

FMI(fmi3GetContinuousStateDerivatives)(void *c, double dx[], size_t count)
{
    return c == NULL ? ERROR : get_rates(c, dx, count);
}

FMI(fmi3GetNominalsOfContinuousStates)(void *c, double x[], size_t count)
{
    return c == NULL ? ERROR : get_nominals(c, x, count);
}

FMI(fmi3GetEventIndicators)(void *c, double z[], size_t count)
{
    return c == NULL ? ERROR : get_indicators(c, count);
}

static int write_count(size_t *count, size_t value)
{
    if (count == NULL) return ERROR;
    *count = value;
    return OK;
}

FMI(fmi3GetNumberOfEventIndicators)(void *c, size_t *count)
{
    return c == NULL ? ERROR : write_count(count, 0);
}

FMI(fmi3GetNumberOfContinuousStates)(void *c, size_t *count)
{
    return c == NULL ? ERROR : write_count(count, FMU_CONTINUOUS);
}
