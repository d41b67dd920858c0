/* fmi2Get... and fmi2Set... of variables. A call that is refused changes nothing. */
#include "instance.h"

#include <math.h>

static unsigned char *place(Instance *c, const Variable *v)
{
    return (unsigned char *)&c->memory.ports + v->offset;
}

/* Whether there is a variable of this kind; refuses where not. */
static bool known(const Instance *c, const char *function, fmi2ValueReference reference, Kind kind)
{
    if (reference < BLOCK_VARIABLES && variables[reference].kind == kind) {
        return true;
    }
    return refuse_reference(c, function, reference, kind);
}

/* The instance when `n` variables of this kind may be read; outputs are then evaluated. */
static Instance *begin_get(fmi2Component component, const char *function, const fmi2ValueReference references[], size_t n,
                           const void *values, Kind kind, fmi2Status *status)
{
    Instance *c = enter(component, function, IN_ANY, status);
    if (c == NULL) {
        return NULL;
    }
    *status = fmi2Error;
    if (n > 0 && (references == NULL || values == NULL)) {
        refuse_text(c, function, "an array is NULL");
        return NULL;
    }
    bool outputs = false;
    for (size_t i = 0; i < n; ++i) {
        if (!known(c, function, references[i], kind)) {
            return NULL;
        }
        outputs = outputs || variables[references[i]].causality == CAUSALITY_OUTPUT;
    }
    if (outputs && make_outputs_fresh(c, function) != fmi2OK) {
        return NULL;
    }
    *status = fmi2OK;
    return c;
}

fmi2Status fmi2GetReal(fmi2Component component, const fmi2ValueReference references[], size_t n, fmi2Real values[])
{
    fmi2Status status;
    Instance *c = begin_get(component, "fmi2GetReal", references, n, values, KIND_REAL, &status);
    for (size_t i = 0; c != NULL && i < n; ++i) {
        memcpy(&values[i], place(c, &variables[references[i]]), sizeof values[i]);
    }
    return status;
}

fmi2Status fmi2GetInteger(fmi2Component component, const fmi2ValueReference references[], size_t n, fmi2Integer values[])
{
    fmi2Status status;
    Instance *c = begin_get(component, "fmi2GetInteger", references, n, values, KIND_INTEGER, &status);
    for (size_t i = 0; c != NULL && i < n; ++i) {
        int32_t value;
        memcpy(&value, place(c, &variables[references[i]]), sizeof value);
        values[i] = value;
    }
    return status;
}

fmi2Status fmi2GetBoolean(fmi2Component component, const fmi2ValueReference references[], size_t n, fmi2Boolean values[])
{
    fmi2Status status;
    Instance *c = begin_get(component, "fmi2GetBoolean", references, n, values, KIND_BOOLEAN, &status);
    for (size_t i = 0; c != NULL && i < n; ++i) {
        bool value;
        memcpy(&value, place(c, &variables[references[i]]), sizeof value);
        values[i] = value ? fmi2True : fmi2False;
    }
    return status;
}

/* The pointers stay valid until the string is set anew or the instance is freed. */
fmi2Status fmi2GetString(fmi2Component component, const fmi2ValueReference references[], size_t n, fmi2String values[])
{
    fmi2Status status;
    Instance *c = begin_get(component, "fmi2GetString", references, n, values, KIND_STRING, &status);
    for (size_t i = 0; c != NULL && i < n; ++i) {
        values[i] = (const char *)place(c, &variables[references[i]]);
    }
    return status;
}

static bool settable(const Instance *c, const char *function, const Variable *v)
{
    if (v->causality == CAUSALITY_OUTPUT) {
        refuse_variable(c, function, v, "is an output and cannot be set");
        return false;
    }
    if (v->variability == FIXED && c->memory.mode == MODE_STEP) {
        refuse_variable(c, function, v, "is a fixed parameter and cannot be set after initialization");
        return false;
    }
    return true;
}

static Instance *begin_set(fmi2Component component, const char *function, const fmi2ValueReference references[], size_t n,
                           const void *values, Kind kind, fmi2Status *status)
{
    Instance *c = enter(component, function, IN_SETUP | IN_INITIALIZATION | IN_STEP, status);
    if (c == NULL) {
        return NULL;
    }
    *status = fmi2Error;
    if (n > 0 && (references == NULL || values == NULL)) {
        refuse_text(c, function, "an array is NULL");
        return NULL;
    }
    for (size_t i = 0; i < n; ++i) {
        if (!known(c, function, references[i], kind) || !settable(c, function, &variables[references[i]])) {
            return NULL;
        }
    }
    *status = fmi2OK;
    return c;
}

/* After a value of v was written. */
static void touched(Instance *c, const Variable *v)
{
    c->memory.fresh = false;
    if (v->causality == CAUSALITY_PARAMETER) {
        c->law_current = false;
    }
}

static bool within(const Instance *c, const char *function, const Variable *v, double value)
{
    return (value >= v->min && value <= v->max && isfinite(value)) || refuse_value(c, function, v, value);
}

fmi2Status fmi2SetReal(fmi2Component component, const fmi2ValueReference references[], size_t n, const fmi2Real values[])
{
    fmi2Status status;
    Instance *c = begin_set(component, "fmi2SetReal", references, n, values, KIND_REAL, &status);
    for (size_t i = 0; c != NULL && i < n; ++i) {
        if (!within(c, "fmi2SetReal", &variables[references[i]], values[i])) {
            return fmi2Error;
        }
    }
    for (size_t i = 0; c != NULL && i < n; ++i) {
        memcpy(place(c, &variables[references[i]]), &values[i], sizeof values[i]);
        touched(c, &variables[references[i]]);
    }
    return status;
}

fmi2Status fmi2SetInteger(fmi2Component component, const fmi2ValueReference references[], size_t n, const fmi2Integer values[])
{
    fmi2Status status;
    Instance *c = begin_set(component, "fmi2SetInteger", references, n, values, KIND_INTEGER, &status);
    for (size_t i = 0; c != NULL && i < n; ++i) {
        if (!within(c, "fmi2SetInteger", &variables[references[i]], values[i])) {
            return fmi2Error;
        }
    }
    for (size_t i = 0; c != NULL && i < n; ++i) {
        const int32_t value = values[i];
        memcpy(place(c, &variables[references[i]]), &value, sizeof value);
        touched(c, &variables[references[i]]);
    }
    return status;
}

fmi2Status fmi2SetBoolean(fmi2Component component, const fmi2ValueReference references[], size_t n, const fmi2Boolean values[])
{
    fmi2Status status;
    Instance *c = begin_set(component, "fmi2SetBoolean", references, n, values, KIND_BOOLEAN, &status);
    for (size_t i = 0; c != NULL && i < n; ++i) {
        if (values[i] != fmi2False && values[i] != fmi2True) {
            const Fault f = {variables[references[i]].name, "fmi2False (0) or fmi2True (1)", NULL, values[i]};
            return refuse_fault(c, "fmi2SetBoolean", &f);
        }
    }
    for (size_t i = 0; c != NULL && i < n; ++i) {
        const bool value = values[i] != fmi2False;
        memcpy(place(c, &variables[references[i]]), &value, sizeof value);
        touched(c, &variables[references[i]]);
    }
    return status;
}

fmi2Status fmi2SetString(fmi2Component component, const fmi2ValueReference references[], size_t n, const fmi2String values[])
{
    fmi2Status status;
    Instance *c = begin_set(component, "fmi2SetString", references, n, values, KIND_STRING, &status);
    for (size_t i = 0; c != NULL && i < n; ++i) {
        const Variable *v = &variables[references[i]];
        if (values[i] == NULL) {
            return refuse_variable(c, "fmi2SetString", v, "cannot be NULL");
        }
        if (strlen(values[i]) >= TEXT_SIZE) {
            return refuse_variable(c, "fmi2SetString", v, "has at most 63 bytes");
        }
    }
    for (size_t i = 0; c != NULL && i < n; ++i) {
        const Variable *v = &variables[references[i]];
        memset(place(c, v), 0, TEXT_SIZE);
        memcpy(place(c, v), values[i], strlen(values[i]));
        touched(c, v);
    }
    return status;
}
