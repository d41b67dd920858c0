/* fmi3Get... and fmi3Set... of variables, which are arrays here: element by element those of FMI 2.0.
 * Tests: tests/native/test_fmi3.py. */
#include "fmi3.h"

static const char *const types[] = {"", "Float64", "Int32", "Int64, an enumeration", "Boolean", "String"};

/* How many values the variable at a reference has; 0, with a message, where it is none of this type or there is no room. */
static size_t size_at(const Instance *c, fmi3ValueReference reference, ArrayType type, size_t room)
{
    if (reference >= BLOCK_VARIABLES || arrays[reference].size == 0) {
        refuse_fault(c, c->called, &(Fault){"value reference", "that of a variable of this FMU", NULL, reference});
        return 0;
    }
    if (arrays[reference].type != type) {
        Message m = message("is of type ");
        put(&m, types[arrays[reference].type]);
        refuse_variable(c, c->called, &variables[reference], m.text);
        return 0;
    }
    if (arrays[reference].size > room) {
        refuse_variable(c, c->called, &variables[reference], "has more values than were asked for");
        return 0;
    }
    return arrays[reference].size;
}

Instance *elements(fmi3Instance instance, const char *function, const fmi3ValueReference references[], size_t n,
                   ArrayType type, const void *values, size_t n_values, fmi2ValueReference all[BLOCK_VARIABLES])
{
    Instance *c = called(instance, function);
    size_t found = 0;
    if (c != NULL && n > 0 && (references == NULL || values == NULL)) {
        refuse_text(c, function, "an array is NULL");
        return NULL;
    }
    if (c != NULL && n_values > BLOCK_VARIABLES) {
        refuse_text(c, function, "more values than the FMU has variables");
        return NULL;
    }
    for (size_t i = 0; c != NULL && i < n; ++i) {
        const size_t size = size_at(c, references[i], type, n_values - found);
        if (size == 0) {
            return NULL;
        }
        for (size_t k = 0; k < size; ++k) {
            all[found++] = references[i] + (fmi2ValueReference)k;
        }
    }
    if (c != NULL && found != n_values) {
        refuse_text(c, function, "the number of values is not that of the variables' elements");
        return NULL;
    }
    return c;
}

FMI3_EXPORT fmi3Status fmi3GetFloat64(fmi3Instance instance, const fmi3ValueReference references[], size_t n,
                                      fmi3Float64 values[], size_t n_values)
{
    fmi2ValueReference all[BLOCK_VARIABLES];
    if (n == 1 && n_values == 1 && instance != NULL && references != NULL && values != NULL && references[0] == TIME) {
        values[0] = ((Instance *)instance)->memory.time;
        return fmi2OK;
    }
    Instance *c = elements(instance, "fmi3GetFloat64", references, n, ARRAY_FLOAT64, values, n_values, all);
    return c == NULL ? fmi2Error : fmi2GetReal(c, all, n_values, values);
}

FMI3_EXPORT fmi3Status fmi3SetFloat64(fmi3Instance instance, const fmi3ValueReference references[], size_t n,
                                      const fmi3Float64 values[], size_t n_values)
{
    fmi2ValueReference all[BLOCK_VARIABLES];
    Instance *c = elements(instance, "fmi3SetFloat64", references, n, ARRAY_FLOAT64, values, n_values, all);
    return c == NULL ? fmi2Error : fmi2SetReal(c, all, n_values, values);
}

FMI3_EXPORT fmi3Status fmi3GetInt32(fmi3Instance instance, const fmi3ValueReference references[], size_t n,
                                    fmi3Int32 values[], size_t n_values)
{
    fmi2ValueReference all[BLOCK_VARIABLES];
    Instance *c = elements(instance, "fmi3GetInt32", references, n, ARRAY_INT32, values, n_values, all);
    return c == NULL ? fmi2Error : fmi2GetInteger(c, all, n_values, values);
}

FMI3_EXPORT fmi3Status fmi3SetInt32(fmi3Instance instance, const fmi3ValueReference references[], size_t n,
                                    const fmi3Int32 values[], size_t n_values)
{
    fmi2ValueReference all[BLOCK_VARIABLES];
    Instance *c = elements(instance, "fmi3SetInt32", references, n, ARRAY_INT32, values, n_values, all);
    return c == NULL ? fmi2Error : fmi2SetInteger(c, all, n_values, values);
}

/* Enumerations. */
FMI3_EXPORT fmi3Status fmi3GetInt64(fmi3Instance instance, const fmi3ValueReference references[], size_t n,
                                    fmi3Int64 values[], size_t n_values)
{
    fmi2ValueReference all[BLOCK_VARIABLES];
    fmi2Integer narrow[BLOCK_VARIABLES];
    Instance *c = elements(instance, "fmi3GetInt64", references, n, ARRAY_INT64, values, n_values, all);
    const fmi3Status status = c == NULL ? fmi2Error : fmi2GetInteger(c, all, n_values, narrow);
    for (size_t i = 0; status == fmi2OK && i < n_values; ++i) {
        values[i] = narrow[i];
    }
    return status;
}

FMI3_EXPORT fmi3Status fmi3SetInt64(fmi3Instance instance, const fmi3ValueReference references[], size_t n,
                                    const fmi3Int64 values[], size_t n_values)
{
    fmi2ValueReference all[BLOCK_VARIABLES];
    fmi2Integer narrow[BLOCK_VARIABLES];
    Instance *c = elements(instance, "fmi3SetInt64", references, n, ARRAY_INT64, values, n_values, all);
    for (size_t i = 0; c != NULL && i < n_values; ++i) {
        if (values[i] < INT32_MIN || values[i] > INT32_MAX) {
            return refuse_value(c, c->called, &variables[all[i]], (double)values[i]);
        }
        narrow[i] = (fmi2Integer)values[i];
    }
    return c == NULL ? fmi2Error : fmi2SetInteger(c, all, n_values, narrow);
}

FMI3_EXPORT fmi3Status fmi3GetBoolean(fmi3Instance instance, const fmi3ValueReference references[], size_t n,
                                      fmi3Boolean values[], size_t n_values)
{
    fmi2ValueReference all[BLOCK_VARIABLES];
    fmi2Boolean wide[BLOCK_VARIABLES];
    Instance *c = elements(instance, "fmi3GetBoolean", references, n, ARRAY_BOOLEAN, values, n_values, all);
    const fmi3Status status = c == NULL ? fmi2Error : fmi2GetBoolean(c, all, n_values, wide);
    for (size_t i = 0; status == fmi2OK && i < n_values; ++i) {
        values[i] = wide[i] != fmi2False;
    }
    return status;
}

FMI3_EXPORT fmi3Status fmi3SetBoolean(fmi3Instance instance, const fmi3ValueReference references[], size_t n,
                                      const fmi3Boolean values[], size_t n_values)
{
    fmi2ValueReference all[BLOCK_VARIABLES];
    fmi2Boolean wide[BLOCK_VARIABLES];
    Instance *c = elements(instance, "fmi3SetBoolean", references, n, ARRAY_BOOLEAN, values, n_values, all);
    for (size_t i = 0; c != NULL && i < n_values; ++i) {
        wide[i] = values[i] ? fmi2True : fmi2False;
    }
    return c == NULL ? fmi2Error : fmi2SetBoolean(c, all, n_values, wide);
}

FMI3_EXPORT fmi3Status fmi3GetString(fmi3Instance instance, const fmi3ValueReference references[], size_t n,
                                     fmi3String values[], size_t n_values)
{
    fmi2ValueReference all[BLOCK_VARIABLES];
    Instance *c = elements(instance, "fmi3GetString", references, n, ARRAY_STRING, values, n_values, all);
    return c == NULL ? fmi2Error : fmi2GetString(c, all, n_values, values);
}

FMI3_EXPORT fmi3Status fmi3SetString(fmi3Instance instance, const fmi3ValueReference references[], size_t n,
                                     const fmi3String values[], size_t n_values)
{
    fmi2ValueReference all[BLOCK_VARIABLES];
    Instance *c = elements(instance, "fmi3SetString", references, n, ARRAY_STRING, values, n_values, all);
    return c == NULL ? fmi2Error : fmi2SetString(c, all, n_values, values);
}
