/* One instance of an FMU around a core of traced kernels: what FMI 2 and 3 share.

   A function returns one of the statuses below, in the numbers of the standard, and says why
   through the logger. What is refused leaves the instance as it was. */

#include <math.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#if defined(_WIN32) || defined(__CYGWIN__)
#define FMU_EXPORT __declspec(dllexport)
#elif defined(__GNUC__) && __GNUC__ >= 4
#define FMU_EXPORT __attribute__((visibility("default")))
#else
#define FMU_EXPORT
#endif
#ifdef __GNUC__
#pragma GCC diagnostic ignored "-Wunused-parameter"
#endif
#define FMU_GLUED(a, b) a##b
#define FMU_GLUE(a, b) FMU_GLUED(a, b)
/* A function of the standard, whose version adds a prefix to the name; PASS is one that calls another, and needs an
   instance. */
#define FMI_OTHER(type, name) FMU_EXPORT type FMI_NAME(name)
#define FMI(name) FMI_OTHER(int, name)
#define PASS(name, arguments, call) FMI(name) arguments { return c == NULL ? ERROR : call; }

enum { FMU_LONGEST = 512 }; /* of a message */
enum { OK, WARNING, DISCARD, ERROR, FATAL };
enum { INSTANTIATED, INITIALIZING, STEPPING, TERMINATED };

static const char *const phases[] = {"after instantiation", "in initialization",
                                     "while stepping", "after termination"};

/* All that a saved state holds; no pointers. */
typedef struct {
    char token[FMU_TOKEN_SIZE];
    uint64_t size;
    CORE_MODEL model;
    double inputs[FMU_INPUTS + 1], slopes[FMU_INPUTS + 1];
    double start, time, count, inner;
    uint64_t phase, coarse;
} memory;

typedef struct {
    memory m;
    double outputs[FMU_OUTPUTS + 1], before[CORE_STATES + 1];
    double refused_step; /* length of a step that failed from here under these inputs; or -1 */
    int stale, quiet;
    char *name;
    void *environment;
    void (*logger)(void);
} instance;

/* Hands a sentence to the importer; each version of the standard has its own. */
static void emit(const instance *i, int status, const char *category, const char *text);

static int say(const instance *i, int status, const char *format, ...)
{
    static const char *const categories[] = {
        "logStatusOK", "logStatusWarning", "logStatusDiscard", "logStatusError", "logStatusFatal"};
    char text[FMU_LONGEST];
    va_list arguments;
    if (i == NULL || i->quiet || i->logger == NULL) return status;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    emit(i, status, categories[status], text);
    return status;
}

static int in_phase(const instance *i, const char *what, unsigned phases_allowed)
{
    if (phases_allowed & (1u << i->m.phase)) return OK;
    return say(i, ERROR, "%s is not allowed %s.", what, phases[i->m.phase]);
}

/* ---------------------------------------------------------------- life */

static int reset(instance *i)
{
    memset(&i->m, 0, sizeof i->m);
    memcpy(i->m.token, FMU_TOKEN, FMU_TOKEN_SIZE);
    i->m.size = sizeof i->m;
    CORE(defaults)(&i->m.model);
    memcpy(i->m.inputs, first_inputs, sizeof first_inputs);
    i->m.inner = FMU_STEP;
    i->stale = 1;
    i->refused_step = -1.0;
    return OK;
}

static instance *create(const char *name, const char *token, void *environment,
                        void (*logger)(void))
{
    instance *i = calloc(1, sizeof *i);
    const size_t length = name == NULL ? 0 : strlen(name);
    if (i == NULL) return NULL;
    i->environment = environment;
    i->logger = logger;
    i->name = malloc(length + 1);
    if (i->name == NULL) {
        free(i);
        return NULL;
    }
    memcpy(i->name, name == NULL ? "" : name, length);
    i->name[length] = '\0';
    if (token == NULL || strcmp(token, FMU_TOKEN) != 0) {
        say(i, ERROR, "The token of the model description is `%s`, but that of the binary is `%s`: "
            "they are not of the same FMU.", token == NULL ? "" : token, FMU_TOKEN);
        free(i->name);
        free(i);
        return NULL;
    }
    reset(i);
    return i;
}

static void destroy(instance *i)
{
    if (i == NULL) return;
    free(i->name);
    free(i);
}

static const char *outcome(int status)
{
    switch (status) {
    case CORE_STATUS(LONG_STEP): return "the step is long for the transformation";
    case CORE_STATUS(UNSOLVED): return "law, heat and mechanism were not solved together";
    case CORE_STATUS(OUT_OF_RANGE): return "a phase fraction left the interval from 0 to 1";
    case CORE_STATUS(NOT_FINITE): return "a number became infinite or undefined";
    case CORE_STATUS(BAD_INPUT): return "an input or a parameter cannot be used";
    default: return "unknown status";
    }
}

static int finite_outputs(const instance *i)
{
    for (int k = 0; k < FMU_OUTPUTS; k++)
        if (!isfinite(i->outputs[k])) return 0;
    return 1;
}

/* The state at rest under the inputs given. */
static int begin(instance *i)
{
    int status = CORE(prepare)(&i->m.model);
    if (status < CORE_STATUS(UNSOLVED)) status = CORE(start)(&i->m.model, i->m.inputs);
    if (status < CORE_STATUS(UNSOLVED)) {
        status = CORE(observe)(&i->m.model, i->m.inputs, i->outputs);
        if (status < CORE_STATUS(UNSOLVED) && !finite_outputs(i))
            status = CORE_STATUS(NOT_FINITE);
    }
    if (status >= CORE_STATUS(UNSOLVED))
        return say(i, ERROR, "There is no state at rest with these parameters and inputs: %s.",
                   outcome(status));
    i->stale = 0;
    return OK;
}

static int enter(instance *i, double start)
{
    if (in_phase(i, "To begin the initialization", 1u << INSTANTIATED)) return ERROR;
    if (!isfinite(start)) return say(i, ERROR, "The start time must be finite, but is %g.", start);
    i->m.start = i->m.time = start;
    i->m.phase = INITIALIZING;
    i->stale = 1;
    return OK;
}

static int leave(instance *i)
{
    if (in_phase(i, "To end the initialization", 1u << INITIALIZING)) return ERROR;
    if (begin(i)) return ERROR;
    i->m.phase = STEPPING;
    i->refused_step = -1.0;
    return OK;
}

static int terminate(instance *i)
{
    if (in_phase(i, "To terminate", 1u << STEPPING)) return ERROR;
    i->m.phase = TERMINATED;
    return OK;
}
