/* The functions of FMI 3.0, on what states.c has: those of co-simulation and, as the standard
   wants it, all others, which refuse. The types are those of the standard's C interface. */

#include <stdbool.h>

#ifdef FMI3_OVERRIDE_FUNCTION_PREFIX
#undef FMI3_FUNCTION_PREFIX
#endif
#ifndef FMI3_FUNCTION_PREFIX
#define FMI3_FUNCTION_PREFIX
#endif
#define FMI_NAME(name) FMU_GLUE(FMI3_FUNCTION_PREFIX, fmi3##name)

#include "states.c"

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

FMI_OTHER(const char *, GetVersion)(void) { return "3.0"; }

FMI(SetDebugLogging)(void *c, bool on, size_t count, const char *const categories[])
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

FMI_OTHER(void *, InstantiateCoSimulation)(
    const char *name, const char *token, const char *resources, bool visible, bool logging,
    bool event_mode, bool early_return, const uint32_t intermediate[], size_t intermediate_count,
    void *environment, logger3 logger, updated update)
{
    if (event_mode || intermediate_count > 0)
        return refused_instance(environment, logger,
                                "This FMU has neither event mode nor intermediate variables.");
    return create(name, token, environment, (void (*)(void))logger);
}

FMI_OTHER(void *, InstantiateModelExchange)(
    const char *name, const char *token, const char *resources, bool visible, bool logging,
    void *environment, logger3 logger)
{
    return refused_instance(environment, logger, "This FMU is for co-simulation only.");
}

FMI_OTHER(void *, InstantiateScheduledExecution)(
    const char *name, const char *token, const char *resources, bool visible, bool logging,
    void *environment, logger3 logger, clocked update, lock preemption, lock no_preemption)
{
    return refused_instance(environment, logger, "This FMU is not for scheduled execution.");
}

FMI(EnterInitializationMode)(void *c, bool tolerance_defined, double tolerance, double start, bool stop_defined,
                             double stop)
{
    if (c == NULL) return ERROR;
    if (stop_defined && !(stop > start))
        return say(c, ERROR, "A simulation from %g s to %g s has no length.", start, stop);
    return enter(c, start);
}

/* ---------------------------------------------------------------- values */

static int fits(const instance *i, size_t count, size_t room)
{
    if (count == room) return OK;
    return say(i, ERROR, "There are %lu values for %lu variables.", (unsigned long)room, (unsigned long)count);
}

PASS(GetFloat64, (void *c, const uint32_t vr[], size_t count, double values[], size_t room),
     fits(c, count, room) ? ERROR : get_all(c, vr, count, values))
PASS(SetFloat64, (void *c, const uint32_t vr[], size_t count, const double values[], size_t room),
     fits(c, count, room) ? ERROR : set_all(c, vr, count, values))

static int none_of(const instance *i, size_t count)
{
    return count == 0 ? OK : say(i, ERROR, "All variables of this FMU are of type Float64.");
}

#define NONE_OF(type, name) \
    PASS(Get##name, (void *c, const uint32_t vr[], size_t count, type values[], size_t room), none_of(c, count)) \
    PASS(Set##name, (void *c, const uint32_t vr[], size_t count, type const values[], size_t room), none_of(c, count))

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

PASS(GetBinary, (void *c, const uint32_t vr[], size_t count, size_t sizes[], const uint8_t *values[], size_t room),
     none_of(c, count))
PASS(SetBinary,
     (void *c, const uint32_t vr[], size_t count, const size_t sizes[], const uint8_t *const values[], size_t room),
     none_of(c, count))
PASS(GetClock, (void *c, const uint32_t vr[], size_t count, bool values[]), none_of(c, count))
PASS(SetClock, (void *c, const uint32_t vr[], size_t count, const bool values[]), none_of(c, count))

/* ---------------------------------------------------------------- saved states */

PASS(GetFMUState, (void *c, void **state), save(c, state))
PASS(SetFMUState, (void *c, void *state), restore(c, state))
PASS(FreeFMUState, (void *c, void **state), forget(state))
PASS(SerializedFMUStateSize, (void *c, void *state, size_t *size), serialized_size(c, state, size))
PASS(SerializeFMUState, (void *c, void *state, uint8_t bytes[], size_t size), serialize(c, state, bytes, size))
PASS(DeserializeFMUState, (void *c, const uint8_t bytes[], size_t size, void **state),
     deserialize(c, bytes, size, state))

/* ---------------------------------------------------------------- steps */

FMI(DoStep)(void *c, double time, double length, bool no_state_before, bool *event_needed, bool *terminated,
            bool *early, double *last_time)
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
    return say(i, ERROR, "%s is nothing that this FMU does.", name);
}

#define REFUSED(name, arguments) PASS(name, arguments, not_here(c, "fmi3" #name))

REFUSED(EnterStepMode, (void *c))
REFUSED(EnterConfigurationMode, (void *c))
REFUSED(ExitConfigurationMode, (void *c))
REFUSED(EvaluateDiscreteStates, (void *c))
REFUSED(GetNumberOfVariableDependencies, (void *c, uint32_t vr, size_t *count))
REFUSED(GetVariableDependencies,
        (void *c, uint32_t dependent, size_t elements[], uint32_t independents[], size_t of_independents[],
         int kinds[], size_t count))
REFUSED(GetDirectionalDerivative,
        (void *c, const uint32_t unknowns[], size_t unknown_count, const uint32_t knowns[], size_t known_count,
         const double seed[], size_t seeds, double found[], size_t room))
REFUSED(GetAdjointDerivative,
        (void *c, const uint32_t unknowns[], size_t unknown_count, const uint32_t knowns[], size_t known_count,
         const double seed[], size_t seeds, double found[], size_t room))
REFUSED(GetOutputDerivatives,
        (void *c, const uint32_t vr[], size_t count, const int32_t orders[], double values[], size_t room))
REFUSED(GetIntervalDecimal, (void *c, const uint32_t vr[], size_t count, double intervals[], int qualifiers[]))
REFUSED(GetIntervalFraction,
        (void *c, const uint32_t vr[], size_t count, uint64_t counters[], uint64_t resolutions[], int qualifiers[]))
REFUSED(GetShiftDecimal, (void *c, const uint32_t vr[], size_t count, double shifts[]))
REFUSED(GetShiftFraction, (void *c, const uint32_t vr[], size_t count, uint64_t counters[], uint64_t resolutions[]))
REFUSED(SetIntervalDecimal, (void *c, const uint32_t vr[], size_t count, const double intervals[]))
REFUSED(SetIntervalFraction,
        (void *c, const uint32_t vr[], size_t count, const uint64_t counters[], const uint64_t resolutions[]))
REFUSED(SetShiftDecimal, (void *c, const uint32_t vr[], size_t count, const double shifts[]))
REFUSED(SetShiftFraction,
        (void *c, const uint32_t vr[], size_t count, const uint64_t counters[], const uint64_t resolutions[]))
REFUSED(ActivateModelPartition, (void *c, uint32_t clock, double time))
REFUSED(EnterEventMode, (void *c))
REFUSED(EnterContinuousTimeMode, (void *c))
REFUSED(UpdateDiscreteStates,
        (void *c, bool *update, bool *terminated, bool *nominals, bool *values, bool *defined, double *next))
REFUSED(CompletedIntegratorStep, (void *c, bool no_state_before, bool *event_mode, bool *terminated))
REFUSED(SetTime, (void *c, double time))
REFUSED(SetContinuousStates, (void *c, const double x[], size_t count))
REFUSED(GetContinuousStates, (void *c, double x[], size_t count))
REFUSED(GetContinuousStateDerivatives, (void *c, double x[], size_t count))
REFUSED(GetNominalsOfContinuousStates, (void *c, double x[], size_t count))
REFUSED(GetEventIndicators, (void *c, double z[], size_t count))
REFUSED(GetNumberOfEventIndicators, (void *c, size_t *count))
REFUSED(GetNumberOfContinuousStates, (void *c, size_t *count))
