/* Values by their references: what FMI 2 and 3 share. */

#include "instance.c"

static int refresh(instance *i)
{
    if (!i->stale) return OK;
    if (i->m.phase == INITIALIZING) return begin(i);
    const int status = CORE(observe)(&i->m.model, i->m.inputs, i->outputs);
    if (status >= CORE_STATUS(UNSOLVED) || !finite_outputs(i))
        return say(i, ERROR, "An output is infinite or undefined under these inputs.");
    i->stale = 0;
    return OK;
}

static int get(instance *i, uint32_t reference, double *value)
{
    const uint32_t index = reference % FMU_KIND;
    switch (reference / FMU_KIND) {
    case 0:
        if (index >= FMU_INPUTS) break;
        *value = i->m.inputs[index];
        return OK;
    case 1:
        if (index >= FMU_OUTPUTS) break;
        if (i->m.phase == INSTANTIATED)
            return say(i, ERROR, "Outputs are not known before the initialization.");
        if (refresh(i)) return ERROR;
        *value = i->outputs[index];
        return OK;
    case 2:
        if (index >= FMU_NUMBERS || rules[index].kind == HIDDEN) break;
        *value = i->m.model.p[rules[index].place];
        return OK;
    case 3:
        if (index > FMU_OWN) break;
        *value = index == 0 ? i->m.time : i->m.inner;
        return OK;
    default: break;
    }
    return say(i, ERROR, "There is no variable with value reference %lu.",
               (unsigned long)reference);
}

/* What is wrong with a value for an input or a parameter; 0 if nothing is. */
static int checked(const instance *i, uint32_t reference, double value)
{
    const uint32_t kind = reference / FMU_KIND, index = reference % FMU_KIND;
    const int known = (kind == 0 && index < FMU_INPUTS) || (kind == 1 && index < FMU_OUTPUTS)
                      || (kind == 2 && index < FMU_NUMBERS && rules[index].kind != HIDDEN)
                      || (kind == 3 && index <= FMU_OWN);
    const rule *r = kind == 2 && known ? &rules[index] : NULL;
    if (!known)
        return say(i, ERROR, "There is no variable with value reference %lu.",
                   (unsigned long)reference);
    if (kind == 1 || (kind == 3 && index == 0))
        return say(i, ERROR, "The variable with value reference %lu cannot be set.",
                   (unsigned long)reference);
    if (!isfinite(value))
        return say(i, ERROR, "The variable with value reference %lu must be finite, but is %g.",
                   (unsigned long)reference, value);
    if (kind == 0)
        return in_phase(i, "To set an input", 1u << INSTANTIATED | 1u << INITIALIZING | 1u << STEPPING);
    if (r != NULL && r->kind == CONSTANT)
        return say(i, ERROR, "Parameter `%s` is a constant of this FMU.", r->name);
    if (in_phase(i, "To set a parameter", 1u << INSTANTIATED | 1u << INITIALIZING)) return ERROR;
    if (r == NULL && value <= 0.0)
        return say(i, DISCARD, "Parameter `inner_step` must be above 0, but is %g.", value);
    if (r != NULL && (value < r->low || value > r->high || (r->open && value <= r->low)))
        return say(i, DISCARD, "Parameter `%s` must be %s %g and at most %g, but is %g.", r->name,
                   r->open ? "above" : "at least", r->low, r->high, value);
    return OK;
}

static void assign(instance *i, uint32_t reference, double value)
{
    const uint32_t kind = reference / FMU_KIND, index = reference % FMU_KIND;
    if (kind == 0) {
        if (i->m.inputs[index] != value) i->refused_step = -1.0;
        i->m.inputs[index] = value;
        i->m.slopes[index] = 0.0;
    } else if (kind == 2) {
        i->m.model.p[rules[index].place] = value;
    } else {
        i->m.inner = value;
    }
}

/* Several values: all of them, or none if one is refused. */
static int set_all(instance *i, const uint32_t *references, size_t count, const double *values)
{
    if (count > 0 && (references == NULL || values == NULL))
        return say(i, ERROR, "Value references or values are missing.");
    for (size_t k = 0; k < count; k++) {
        const int status = checked(i, references[k], values[k]);
        if (status != OK) return status;
    }
    for (size_t k = 0; k < count; k++) assign(i, references[k], values[k]);
    i->stale = 1;
    return OK;
}

static int get_all(instance *i, const uint32_t *references, size_t count, double *values)
{
    if (count > 0 && (references == NULL || values == NULL))
        return say(i, ERROR, "Value references or values are missing.");
    for (size_t k = 0; k < count; k++)
        if (get(i, references[k], &values[k])) return ERROR;
    return OK;
}
