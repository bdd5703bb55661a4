/* The functions of FMI 2.0, on what states.c has. The types are those of the
   standard's C interface, declared here as far as they are needed. */

#ifdef FMI2_OVERRIDE_FUNCTION_PREFIX
#undef FMI2_FUNCTION_PREFIX
#endif
#ifndef FMI2_FUNCTION_PREFIX
#define FMI2_FUNCTION_PREFIX
#endif
#define FMI_NAME(name) FMU_GLUE(FMI2_FUNCTION_PREFIX, fmi2##name)

#include "states.c"

typedef void (*logger2)(void *environment, const char *instance_name, int status,
                        const char *category, const char *message, ...);

typedef struct {
    logger2 logger;
    void *(*allocate)(size_t, size_t);
    void (*release)(void *);
    void (*step_finished)(void *, int);
    void *environment;
} callbacks2;

/* The message is a format: a percent sign is doubled, and nothing follows it. */
static void emit(const instance *i, int status, const char *category, const char *text)
{
    char format[2 * FMU_LONGEST];
    size_t k = 0;
    for (; *text != '\0'; text++) {
        if (*text == '%') format[k++] = '%';
        format[k++] = *text;
    }
    format[k] = '\0';
    ((logger2)i->logger)(i->environment, i->name, status, category, format);
}

FMI_OTHER(const char *, GetTypesPlatform)(void) { return "default"; }

FMI_OTHER(const char *, GetVersion)(void) { return "2.0"; }

FMI_OTHER(void *, Instantiate)(const char *name, int type, const char *guid, const char *resources,
                               const callbacks2 *functions, int visible, int logging)
{
    instance *i = create(name, guid, functions == NULL ? NULL : functions->environment,
                         functions == NULL ? NULL : (void (*)(void))functions->logger);
    if (i == NULL || type == 1) return i;
    say(i, ERROR, "This FMU is for co-simulation, not for model exchange.");
    destroy(i);
    return NULL;
}

FMI(SetDebugLogging)(void *c, int on, size_t count, const char *const categories[])
{
    if (c == NULL) return ERROR;
    ((instance *)c)->quiet = !on && count == 0;
    return OK;
}

FMI(SetupExperiment)(void *c, int tolerance_defined, double tolerance, double start, int stop_defined, double stop)
{
    instance *i = c;
    if (c == NULL || in_phase(i, "To set up an experiment", 1u << INSTANTIATED)) return ERROR;
    if (!isfinite(start) || (stop_defined && !(stop > start)))
        return say(i, ERROR, "An experiment from %g s to %g s has no length.", start, stop);
    i->m.start = start;
    return OK;
}

PASS(EnterInitializationMode, (void *c), enter(c, ((instance *)c)->m.start))

/* ---------------------------------------------------------------- values */

PASS(GetReal, (void *c, const unsigned vr[], size_t count, double values[]), get_all(c, vr, count, values))
PASS(SetReal, (void *c, const unsigned vr[], size_t count, const double values[]), set_all(c, vr, count, values))

static int none_of(const instance *i, size_t count)
{
    return count == 0 ? OK : say(i, ERROR, "All variables of this FMU are real.");
}

#define NONE_OF(type, name) \
    PASS(Get##name, (void *c, const unsigned vr[], size_t count, type values[]), none_of(c, count)) \
    PASS(Set##name, (void *c, const unsigned vr[], size_t count, type const values[]), none_of(c, count))

NONE_OF(int, Integer)
NONE_OF(int, Boolean)
NONE_OF(const char *, String)

/* ---------------------------------------------------------------- saved states */

PASS(GetFMUstate, (void *c, void **state), save(c, state))
PASS(SetFMUstate, (void *c, void *state), restore(c, state))
PASS(FreeFMUstate, (void *c, void **state), forget(state))
PASS(SerializedFMUstateSize, (void *c, void *state, size_t *size), serialized_size(c, state, size))
PASS(SerializeFMUstate, (void *c, void *state, char bytes[], size_t size), serialize(c, state, bytes, size))
PASS(DeSerializeFMUstate, (void *c, const char bytes[], size_t size, void **state), deserialize(c, bytes, size, state))

/* ---------------------------------------------------------------- steps */

PASS(DoStep, (void *c, double time, double length, int no_state_before), advance(c, time, length))
PASS(CancelStep, (void *c), say(c, ERROR, "A step of this FMU ends before it returns."))

/* Slopes of inputs over the next step. */
FMI(SetRealInputDerivatives)(void *c, const unsigned vr[], size_t count, const int order[], const double values[])
{
    instance *i = c;
    if (c == NULL || in_phase(i, "To set a slope", 1u << INITIALIZING | 1u << STEPPING))
        return ERROR;
    if (count > 0 && (vr == NULL || order == NULL || values == NULL))
        return say(i, ERROR, "Value references, orders or values are missing.");
    for (size_t k = 0; k < count; k++)
        if (FMU_PERIOD > 0.0 || vr[k] >= FMU_INPUTS || order[k] != 1 || !isfinite(values[k]))
            return say(i, ERROR, "The variable with value reference %u cannot have a derivative "
                       "of order %d of %g.", vr[k], order[k], values[k]);
    for (size_t k = 0; k < count; k++) i->m.slopes[vr[k]] = values[k];
    return OK;
}

PASS(GetRealOutputDerivatives, (void *c, const unsigned vr[], size_t count, const int order[], double values[]),
     count == 0 ? OK : say(c, ERROR, "This FMU does not know derivatives of outputs."))

static int no_status(const instance *i)
{
    return i == NULL ? ERROR : say(i, DISCARD, "This FMU does not know the status asked for.");
}

PASS(GetStatus, (void *c, int kind, int *value), no_status(c))
PASS(GetIntegerStatus, (void *c, int kind, int *value), no_status(c))
PASS(GetStringStatus, (void *c, int kind, const char **value), no_status(c))

FMI(GetRealStatus)(void *c, int kind, double *value)
{
    if (c == NULL || kind != 2 || value == NULL) return no_status(c);
    *value = ((instance *)c)->m.time;
    return OK;
}

FMI(GetBooleanStatus)(void *c, int kind, int *value)
{
    if (c == NULL || kind != 3 || value == NULL) return no_status(c);
    *value = ((instance *)c)->m.phase == TERMINATED;
    return OK;
}

PASS(GetDirectionalDerivative,
     (void *c, const unsigned unknowns[], size_t unknown_count, const unsigned knowns[], size_t known_count,
      const double seed[], double sensitivity[]),
     say(c, ERROR, "This FMU does not know derivatives."))
