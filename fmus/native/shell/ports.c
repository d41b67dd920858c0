/* fmi2Get... and fmi2Set... of variables. A call that is refused sets nothing. Tests: tests/native/test_values.py. */
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

/* How many of n references that begin with this one lie within its run where they follow each other. */
static size_t reach(fmi2ValueReference reference, size_t n)
{
    return n <= variables[reference].followers ? n : variables[reference].followers + 1;
}

static Instance *begin_get(fmi2Component component, const char *function, const fmi2ValueReference references[],
                           size_t n, const void *values, fmi2Status *status)
{
    Instance *c = enter(component, function, IN_ANY, status);
    if (c != NULL && n > 0 && (references == NULL || values == NULL)) {
        *status = refuse_text(c, function, "an array is NULL");
        return NULL;
    }
    return c;
}

/* Where the value of a variable of this kind lies, outputs evaluated; NULL where it cannot be read. */
static const unsigned char *readable(Instance *c, const char *function, fmi2ValueReference reference, Kind kind)
{
    if (!known(c, function, reference, kind)) {
        return NULL;
    }
    const Variable *v = &variables[reference];
    return v->causality == CAUSALITY_OUTPUT && make_outputs_fresh(c, function) != fmi2OK ? NULL : place(c, v);
}

/* Run by run, since masters read many variables in every step. */
fmi2Status fmi2GetReal(fmi2Component component, const fmi2ValueReference references[], size_t n, fmi2Real values[])
{
    fmi2Status status;
    Instance *c = begin_get(component, "fmi2GetReal", references, n, values, &status);
    for (size_t i = 0; c != NULL && i < n;) {
        const unsigned char *from = readable(c, "fmi2GetReal", references[i], KIND_REAL);
        if (from == NULL) {
            return fmi2Error;
        }
        const fmi2ValueReference first = references[i];
        const size_t most = reach(first, n - i);
        for (size_t k = 0; k < most && references[i] == first + k; ++k, ++i) {
            memcpy(&values[i], from + k * sizeof values[i], sizeof values[i]);
        }
    }
    return status;
}

fmi2Status fmi2GetInteger(fmi2Component component, const fmi2ValueReference refs[], size_t n, fmi2Integer values[])
{
    fmi2Status status;
    Instance *c = begin_get(component, "fmi2GetInteger", refs, n, values, &status);
    for (size_t i = 0; c != NULL && i < n; ++i) {
        const unsigned char *from = readable(c, "fmi2GetInteger", refs[i], KIND_INTEGER);
        int32_t value;
        if (from == NULL) {
            return fmi2Error;
        }
        memcpy(&value, from, sizeof value);
        values[i] = value;
    }
    return status;
}

fmi2Status fmi2GetBoolean(fmi2Component component, const fmi2ValueReference refs[], size_t n, fmi2Boolean values[])
{
    fmi2Status status;
    Instance *c = begin_get(component, "fmi2GetBoolean", refs, n, values, &status);
    for (size_t i = 0; c != NULL && i < n; ++i) {
        const unsigned char *from = readable(c, "fmi2GetBoolean", refs[i], KIND_BOOLEAN);
        bool value;
        if (from == NULL) {
            return fmi2Error;
        }
        memcpy(&value, from, sizeof value);
        values[i] = value ? fmi2True : fmi2False;
    }
    return status;
}

/* The pointers stay valid until the string is set anew or the instance is freed. */
fmi2Status fmi2GetString(fmi2Component component, const fmi2ValueReference references[], size_t n, fmi2String values[])
{
    fmi2Status status;
    Instance *c = begin_get(component, "fmi2GetString", references, n, values, &status);
    for (size_t i = 0; c != NULL && i < n; ++i) {
        const unsigned char *from = readable(c, "fmi2GetString", references[i], KIND_STRING);
        if (from == NULL) {
            return fmi2Error;
        }
        values[i] = (const char *)from;
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

static Instance *begin_set(fmi2Component component, const char *function, const fmi2ValueReference references[],
                           size_t n, const void *values, fmi2Status *status)
{
    Instance *c = enter(component, function, IN_SETUP | IN_INITIALIZATION | IN_STEP, status);
    if (c != NULL && n > 0 && (references == NULL || values == NULL)) {
        *status = refuse_text(c, function, "an array is NULL");
        return NULL;
    }
    return c;
}

/* The variable of this kind that is to be set; NULL where it cannot be. */
static const Variable *writable(const Instance *c, const char *function, fmi2ValueReference reference, Kind kind)
{
    return known(c, function, reference, kind) && settable(c, function, &variables[reference]) ? &variables[reference]
                                                                                               : NULL;
}

/* After a value of v was written. */
static void touched(Instance *c, const Variable *v)
{
    c->memory.fresh = false;
    if (v->causality == CAUSALITY_PARAMETER) {
        c->law_current = false;
    }
}

fmi2Status fmi2SetReal(fmi2Component component, const fmi2ValueReference references[], size_t n,
                       const fmi2Real values[])
{
    fmi2Status status;
    Instance *c = begin_set(component, "fmi2SetReal", references, n, values, &status);
    size_t run = 0;
    for (size_t i = 0; c != NULL && i < n; i += run) {
        const Variable *v = writable(c, "fmi2SetReal", references[i], KIND_REAL);
        if (v == NULL) {
            return fmi2Error;
        }
        const double low = v->min, high = v->max;
        const size_t most = reach(references[i], n - i);
        for (run = 0; run < most && references[i + run] == references[i] + run; ++run) {
            if (!(values[i + run] >= low && values[i + run] <= high)) {
                return refuse_value(c, "fmi2SetReal", &v[run], values[i + run]);
            }
        }
    }
    const size_t together = run == n ? n : 1; /* one run, as of a master that keeps the order of references */
    for (size_t i = 0; c != NULL && i < n; i += together) {
        memcpy(place(c, &variables[references[i]]), &values[i], together * sizeof values[i]);
        touched(c, &variables[references[i]]);
    }
    return status;
}

fmi2Status fmi2SetInteger(fmi2Component component, const fmi2ValueReference references[], size_t n,
                          const fmi2Integer values[])
{
    fmi2Status status;
    Instance *c = begin_set(component, "fmi2SetInteger", references, n, values, &status);
    for (size_t i = 0; c != NULL && i < n; ++i) {
        const Variable *v = writable(c, "fmi2SetInteger", references[i], KIND_INTEGER);
        if (v == NULL) {
            return fmi2Error;
        }
        if (!(values[i] >= v->min && values[i] <= v->max)) {
            return refuse_value(c, "fmi2SetInteger", v, values[i]);
        }
    }
    for (size_t i = 0; c != NULL && i < n; ++i) {
        const int32_t value = values[i];
        memcpy(place(c, &variables[references[i]]), &value, sizeof value);
        touched(c, &variables[references[i]]);
    }
    return status;
}

fmi2Status fmi2SetBoolean(fmi2Component component, const fmi2ValueReference references[], size_t n,
                          const fmi2Boolean values[])
{
    fmi2Status status;
    Instance *c = begin_set(component, "fmi2SetBoolean", references, n, values, &status);
    for (size_t i = 0; c != NULL && i < n; ++i) {
        const Variable *v = writable(c, "fmi2SetBoolean", references[i], KIND_BOOLEAN);
        if (v == NULL) {
            return fmi2Error;
        }
        if (values[i] != fmi2False && values[i] != fmi2True) {
            return refuse_fault(c, "fmi2SetBoolean",
                                &(Fault){v->name, "fmi2False (0) or fmi2True (1)", NULL, values[i]});
        }
    }
    for (size_t i = 0; c != NULL && i < n; ++i) {
        const bool value = values[i] != fmi2False;
        memcpy(place(c, &variables[references[i]]), &value, sizeof value);
        touched(c, &variables[references[i]]);
    }
    return status;
}

fmi2Status fmi2SetString(fmi2Component component, const fmi2ValueReference references[], size_t n,
                         const fmi2String values[])
{
    fmi2Status status;
    Instance *c = begin_set(component, "fmi2SetString", references, n, values, &status);
    for (size_t i = 0; c != NULL && i < n; ++i) {
        const Variable *v = writable(c, "fmi2SetString", references[i], KIND_STRING);
        if (v == NULL) {
            return fmi2Error;
        }
        if (values[i] == NULL) {
            return refuse_variable(c, "fmi2SetString", v, "cannot be NULL");
        }
        if (strlen(values[i]) >= TEXT_SIZE) {
            return refuse_variable(c, "fmi2SetString", v, "has at most 127 bytes");
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
