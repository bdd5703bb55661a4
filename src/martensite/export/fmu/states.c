/* Saved states, and functions of the standard: what FMI 2 and 3 share. */

#include "steps.c"

static int usable(const instance *i, const memory *m)
{
    if (memcmp(m->token, FMU_TOKEN, FMU_TOKEN_SIZE) != 0 || m->size != sizeof *m)
        return say(i, ERROR, "The state is not one of this FMU.");
    int sound = m->phase <= TERMINATED && isfinite(m->start) && isfinite(m->time) && isfinite(m->count)
                && isfinite(m->inner) && m->inner > 0.0;
    for (int d = 0; d < FMU_INPUTS; d++)
        sound = sound && isfinite(m->inputs[d]) && isfinite(m->slopes[d]);
    for (int k = 0; k < FMU_NUMBERS; k++)
        sound = sound && (rules[k].kind != FREE || isfinite(m->model.p[rules[k].place]));
    if (m->phase >= STEPPING)
        for (int k = 0; k < CORE_STATES; k++) sound = sound && isfinite(m->model.x[k]);
    return sound ? OK : say(i, ERROR, "The state holds numbers that cannot be.");
}

static int save(instance *i, void **state)
{
    if (state == NULL) return say(i, ERROR, "There is nowhere to put the state.");
    memory *m = *state == NULL ? malloc(sizeof *m) : *state;
    if (m == NULL) return say(i, ERROR, "There is no memory left.");
    memcpy(m, &i->m, sizeof *m);
    *state = m;
    return OK;
}

static int restore(instance *i, const memory *state)
{
    if (state == NULL) return say(i, ERROR, "There is no state to go back to.");
    if (usable(i, state)) return ERROR;
    memcpy(&i->m, state, sizeof i->m);
    i->stale = 1;
    i->refused_step = -1.0;
    return OK;
}

static int forget(void **state)
{
    if (state != NULL) {
        free(*state);
        *state = NULL;
    }
    return OK;
}

static int serialized_size(const instance *i, const void *state, size_t *size)
{
    if (state == NULL || size == NULL) return say(i, ERROR, "There is no state.");
    *size = sizeof(memory);
    return OK;
}

static int serialize(const instance *i, const void *state, void *bytes, size_t size)
{
    if (state == NULL || bytes == NULL) return say(i, ERROR, "There is no state.");
    if (size < sizeof(memory))
        return say(i, ERROR, "A state has %lu bytes, but there is room for %lu.",
                   (unsigned long)sizeof(memory), (unsigned long)size);
    memcpy(bytes, state, sizeof(memory));
    return OK;
}

static int deserialize(const instance *i, const void *bytes, size_t size, void **state)
{
    if (bytes == NULL || state == NULL) return say(i, ERROR, "There is no state.");
    if (size != sizeof(memory))
        return say(i, ERROR, "A state has %lu bytes, but %lu were given.",
                   (unsigned long)sizeof(memory), (unsigned long)size);
    memory *m = malloc(sizeof *m);
    if (m == NULL) return say(i, ERROR, "There is no memory left.");
    memcpy(m, bytes, sizeof *m);
    if (usable(i, m)) {
        free(m);
        return ERROR;
    }
    *state = m;
    return OK;
}

FMI_OTHER(void, FreeInstance)(void *c) { destroy(c); }

PASS(ExitInitializationMode, (void *c), leave(c))
PASS(Terminate, (void *c), terminate(c))
PASS(Reset, (void *c), reset(c))
