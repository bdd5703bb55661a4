/* The functions of FMI 3.0, on what states.c has: those of co-simulation, of model
   exchange where the model gives rates, and, as the standard
   wants it, all others, which refuse. The types are those of the standard's C interface. */

#include <stdbool.h>
#include "states.c"

#ifdef FMI3_OVERRIDE_FUNCTION_PREFIX
#undef FMI3_FUNCTION_PREFIX
#endif
#ifndef FMI3_FUNCTION_PREFIX
#define FMI3_FUNCTION_PREFIX
#endif
#define FMI(name) FMU_EXPORT int FMU_GLUE(FMI3_FUNCTION_PREFIX, name)
#define FMI_OTHER(type, name) FMU_EXPORT type FMU_GLUE(FMI3_FUNCTION_PREFIX, name)

#ifdef __GNUC__
#pragma GCC diagnostic ignored "-Wunused-parameter"
#endif

typedef void (*logger3)(void *environment, int status, const char *category, const char *message);
typedef void (*clocked)(void *environment);
typedef void (*lock)(void);
typedef void (*updated)(void *environment, double time, bool set_requested, bool get_allowed,
                        bool step_finished, bool can_return, bool *return_requested,
                        double *return_time);

static void emit(const instance *i, int status, const char *category, const char *text)
{
    ((logger3)i->logger)(i->environment, status, category, text);
}

FMI_OTHER(const char *, fmi3GetVersion)(void) { return "3.0"; }

FMI(fmi3SetDebugLogging)(void *c, bool on, size_t count, const char *const categories[])
{
    if (c == NULL) return ERROR;
    ((instance *)c)->quiet = !on && count == 0;
    return OK;
}

static void *refused_instance(void *environment, logger3 logger, const char *why)
{
    if (logger != NULL) logger(environment, ERROR, "logStatusError", why);
    return NULL;
}

FMI_OTHER(void *, fmi3InstantiateCoSimulation)(
    const char *name, const char *token, const char *resources, bool visible, bool logging,
    bool event_mode, bool early_return, const uint32_t intermediate[], size_t intermediate_count,
    void *environment, logger3 logger, updated update)
{
    if (event_mode || intermediate_count > 0)
        return refused_instance(environment, logger,
                                "This FMU has neither event mode nor intermediate variables.");
    return create(name, token, environment, (void (*)(void))logger);
}

FMI_OTHER(void *, fmi3InstantiateModelExchange)(
    const char *name, const char *token, const char *resources, bool visible, bool logging,
    void *environment, logger3 logger)
{
#ifdef FMU_CONTINUOUS
    instance *i = create(name, token, environment, (void (*)(void))logger);
    if (i != NULL) i->exchange = 1;
    return i;
#else
    return refused_instance(environment, logger, "This FMU is for co-simulation only.");
#endif
}

FMI_OTHER(void *, fmi3InstantiateScheduledExecution)(
    const char *name, const char *token, const char *resources, bool visible, bool logging,
    void *environment, logger3 logger, clocked update, lock preemption, lock no_preemption)
{
    return refused_instance(environment, logger, "This FMU is not for scheduled execution.");
}

FMI_OTHER(void, fmi3FreeInstance)(void *c) { destroy(c); }

FMI(fmi3EnterInitializationMode)(void *c, bool tolerance_defined, double tolerance, double start,
                                 bool stop_defined, double stop)
{
    if (c == NULL) return ERROR;
    if (stop_defined && !(stop > start))
        return say(c, ERROR, "A simulation from %g s to %g s has no length.", start, stop);
    return enter(c, start);
}

FMI(fmi3ExitInitializationMode)(void *c) { return c == NULL ? ERROR : leave(c); }

FMI(fmi3Terminate)(void *c) { return c == NULL ? ERROR : terminate(c); }

FMI(fmi3Reset)(void *c)
{
    if (c == NULL) return ERROR;
    reset(c);
    return OK;
}

/* ---------------------------------------------------------------- values */

FMI(fmi3GetFloat64)(void *c, const uint32_t vr[], size_t count, double values[], size_t room)
{
    if (c == NULL) return ERROR;
    if (count != room) return say(c, ERROR, "There are %lu values for %lu variables.",
                                  (unsigned long)room, (unsigned long)count);
    return get_all(c, vr, count, values);
}

FMI(fmi3SetFloat64)(void *c, const uint32_t vr[], size_t count, const double values[], size_t room)
{
    if (c == NULL) return ERROR;
    if (count != room) return say(c, ERROR, "There are %lu values for %lu variables.",
                                  (unsigned long)room, (unsigned long)count);
    return set_all(c, vr, count, values);
}

static int none_of(const instance *i, size_t count)
{
    if (i == NULL) return ERROR;
    return count == 0 ? OK : say(i, ERROR, "All variables of this FMU are of type Float64.");
}

#define NONE_OF(type, name) \
    FMI(fmi3Get##name)(void *c, const uint32_t vr[], size_t count, type values[], size_t room) \
    { \
        return none_of(c, count); \
    } \
    FMI(fmi3Set##name)(void *c, const uint32_t vr[], size_t count, type const values[], \
                       size_t room) \
    { \
        return none_of(c, count); \
    }

NONE_OF(float, Float32)
NONE_OF(int8_t, Int8)
NONE_OF(uint8_t, UInt8)
NONE_OF(int16_t, Int16)
NONE_OF(uint16_t, UInt16)
NONE_OF(int32_t, Int32)
NONE_OF(uint32_t, UInt32)
NONE_OF(int64_t, Int64)
NONE_OF(uint64_t, UInt64)
NONE_OF(bool, Boolean)
NONE_OF(const char *, String)

FMI(fmi3GetBinary)(void *c, const uint32_t vr[], size_t count, size_t sizes[],
                   const uint8_t *values[], size_t room)
{
    return none_of(c, count);
}

FMI(fmi3SetBinary)(void *c, const uint32_t vr[], size_t count, const size_t sizes[],
                   const uint8_t *const values[], size_t room)
{
    return none_of(c, count);
}

FMI(fmi3GetClock)(void *c, const uint32_t vr[], size_t count, bool values[])
{
    return none_of(c, count);
}

FMI(fmi3SetClock)(void *c, const uint32_t vr[], size_t count, const bool values[])
{
    return none_of(c, count);
}

/* ---------------------------------------------------------------- saved states */

FMI(fmi3GetFMUState)(void *c, void **state) { return c == NULL ? ERROR : save(c, state); }

FMI(fmi3SetFMUState)(void *c, void *state) { return c == NULL ? ERROR : restore(c, state); }

FMI(fmi3FreeFMUState)(void *c, void **state) { return c == NULL ? ERROR : forget(state); }

FMI(fmi3SerializedFMUStateSize)(void *c, void *state, size_t *size)
{
    return c == NULL ? ERROR : serialized_size(c, state, size);
}

FMI(fmi3SerializeFMUState)(void *c, void *state, uint8_t bytes[], size_t size)
{
    return c == NULL ? ERROR : serialize(c, state, bytes, size);
}

FMI(fmi3DeserializeFMUState)(void *c, const uint8_t bytes[], size_t size, void **state)
{
    return c == NULL ? ERROR : deserialize(c, bytes, size, state);
}

/* ---------------------------------------------------------------- steps */

FMI(fmi3DoStep)(void *c, double time, double length, bool no_state_before, bool *event_needed,
                bool *terminated, bool *early, double *last_time)
{
    if (c == NULL) return ERROR;
    const int status = advance(c, time, length);
    if (event_needed != NULL) *event_needed = false;
    if (terminated != NULL) *terminated = false;
    if (early != NULL) *early = false;
    if (last_time != NULL) *last_time = ((instance *)c)->m.time;
    return status;
}

/* ---------------------------------------------------------------- what this FMU does not do */

static int not_here(const instance *i, const char *name)
{
    return i == NULL ? ERROR : say(i, ERROR, "%s is nothing that this FMU does.", name);
}

#define REFUSED(name, arguments) \
    FMI(name) arguments { return not_here(c, #name); }

REFUSED(fmi3EnterStepMode, (void *c))
REFUSED(fmi3EnterConfigurationMode, (void *c))
REFUSED(fmi3ExitConfigurationMode, (void *c))
REFUSED(fmi3EvaluateDiscreteStates, (void *c))
#ifndef FMU_CONTINUOUS
REFUSED(fmi3EnterEventMode, (void *c))
REFUSED(fmi3EnterContinuousTimeMode, (void *c))
REFUSED(fmi3UpdateDiscreteStates,
        (void *c, bool *update, bool *terminated, bool *nominals, bool *values, bool *defined,
         double *next))
REFUSED(fmi3CompletedIntegratorStep,
        (void *c, bool no_state_before, bool *event_mode, bool *terminated))
REFUSED(fmi3SetTime, (void *c, double time))
REFUSED(fmi3SetContinuousStates, (void *c, const double x[], size_t count))
REFUSED(fmi3GetContinuousStates, (void *c, double x[], size_t count))
REFUSED(fmi3GetContinuousStateDerivatives, (void *c, double x[], size_t count))
REFUSED(fmi3GetNominalsOfContinuousStates, (void *c, double x[], size_t count))
REFUSED(fmi3GetEventIndicators, (void *c, double z[], size_t count))
REFUSED(fmi3GetNumberOfEventIndicators, (void *c, size_t *count))
REFUSED(fmi3GetNumberOfContinuousStates, (void *c, size_t *count))
#endif
REFUSED(fmi3GetNumberOfVariableDependencies, (void *c, uint32_t vr, size_t *count))
REFUSED(fmi3GetVariableDependencies,
        (void *c, uint32_t dependent, size_t elements[], uint32_t independents[],
         size_t of_independents[], int kinds[], size_t count))
REFUSED(fmi3GetDirectionalDerivative,
        (void *c, const uint32_t unknowns[], size_t unknown_count, const uint32_t knowns[],
         size_t known_count, const double seed[], size_t seeds, double found[], size_t room))
REFUSED(fmi3GetAdjointDerivative,
        (void *c, const uint32_t unknowns[], size_t unknown_count, const uint32_t knowns[],
         size_t known_count, const double seed[], size_t seeds, double found[], size_t room))
REFUSED(fmi3GetOutputDerivatives,
        (void *c, const uint32_t vr[], size_t count, const int32_t orders[], double values[],
         size_t room))
REFUSED(fmi3GetIntervalDecimal,
        (void *c, const uint32_t vr[], size_t count, double intervals[], int qualifiers[]))
REFUSED(fmi3GetIntervalFraction,
        (void *c, const uint32_t vr[], size_t count, uint64_t counters[], uint64_t resolutions[],
         int qualifiers[]))
REFUSED(fmi3GetShiftDecimal, (void *c, const uint32_t vr[], size_t count, double shifts[]))
REFUSED(fmi3GetShiftFraction,
        (void *c, const uint32_t vr[], size_t count, uint64_t counters[], uint64_t resolutions[]))
REFUSED(fmi3SetIntervalDecimal,
        (void *c, const uint32_t vr[], size_t count, const double intervals[]))
REFUSED(fmi3SetIntervalFraction,
        (void *c, const uint32_t vr[], size_t count, const uint64_t counters[],
         const uint64_t resolutions[]))
REFUSED(fmi3SetShiftDecimal, (void *c, const uint32_t vr[], size_t count, const double shifts[]))
REFUSED(fmi3SetShiftFraction,
        (void *c, const uint32_t vr[], size_t count, const uint64_t counters[],
         const uint64_t resolutions[]))
REFUSED(fmi3ActivateModelPartition, (void *c, uint32_t clock, double time))
