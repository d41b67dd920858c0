/* Directional and adjoint derivatives of the outputs, by the block's C on dual numbers (dual.h).
 * Tests: tests/native/test_derivatives.py. */
#include "fmi3.h"

#if BLOCK_DERIVATIVES

#include <math.h>

/* The values of all variables, Booleans and whole numbers among them, by their value references. */
static void numbers(const Instance *c, double values[BLOCK_VARIABLES])
{
    for (size_t i = 0; i < BLOCK_VARIABLES; ++i) {
        const unsigned char *from = (const unsigned char *)&c->memory.ports + variables[i].offset;
        int32_t whole = 0;
        bool flag = false;
        if (variables[i].kind == KIND_REAL) {
            memcpy(&values[i], from, sizeof values[i]);
        } else if (variables[i].kind == KIND_INTEGER) {
            memcpy(&whole, from, sizeof whole);
            values[i] = whole;
        } else {
            memcpy(&flag, from, sizeof flag);
            values[i] = flag;
        }
    }
}

/* What both functions begin with: the instance with outputs that fit its inputs; NULL where something is wrong. */
static Instance *begin(fmi3Instance instance, const char *function, const fmi3ValueReference unknowns[],
                       size_t n_unknowns, const double *of_unknowns, size_t n_of, fmi2ValueReference of[],
                       const fmi3ValueReference knowns[], size_t n_knowns, const double *by_knowns, size_t n_by,
                       fmi2ValueReference by[])
{
    fmi2Status status;
    if (elements(instance, function, unknowns, n_unknowns, ARRAY_FLOAT64, of_unknowns, n_of, of) == NULL ||
        elements(instance, function, knowns, n_knowns, ARRAY_FLOAT64, by_knowns, n_by, by) == NULL) {
        return NULL;
    }
    Instance *c = enter(instance, function, IN_INITIALIZATION | IN_STEP | IN_TERMINATED, &status);
    for (size_t i = 0; c != NULL && i < n_of + n_by; ++i) {
        const Variable *v = &variables[i < n_of ? of[i] : by[i - n_of]];
        if ((v->causality == CAUSALITY_OUTPUT) != (i < n_of)) {
            refuse_variable(c, function, v,
                            i < n_of ? "is no output" : "is an output: expected an input or a parameter");
            return NULL;
        }
    }
    return c == NULL || make_outputs_fresh(c, function) != fmi2OK ? NULL : c;
}

/* The derivatives of all outputs along `seeds`; none between the block's own instants, where it holds. */
static void along(const Instance *c, const double values[], const double seeds[], double slopes[BLOCK_VARIABLES])
{
    const bool running = c->memory.mode != MODE_INITIALIZATION;
    memset(slopes, 0, BLOCK_VARIABLES * sizeof slopes[0]);
    if (!c->memory.held) {
        block_slopes(values, seeds, running ? state_of(c) : NULL, slopes);
    }
}

static fmi3Status checked(const Instance *c, const char *function, const fmi2ValueReference at[], const double found[],
                          size_t n)
{
    for (size_t i = 0; i < n; ++i) {
        if (!isfinite(found[i])) {
            return refuse_variable(c, function, &variables[at[i]], "has no derivative here");
        }
    }
    return fmi2OK;
}

FMI3_EXPORT fmi3Status fmi3GetDirectionalDerivative(fmi3Instance instance, const fmi3ValueReference unknowns[],
                                                    size_t n_unknowns, const fmi3ValueReference knowns[],
                                                    size_t n_knowns, const fmi3Float64 seed[], size_t n_seed,
                                                    fmi3Float64 sensitivity[], size_t n_sensitivity)
{
    const char *const function = "fmi3GetDirectionalDerivative";
    fmi2ValueReference of[BLOCK_VARIABLES], by[BLOCK_VARIABLES];
    double values[BLOCK_VARIABLES], seeds[BLOCK_VARIABLES] = {0.0}, slopes[BLOCK_VARIABLES];
    const Instance *c = begin(instance, function, unknowns, n_unknowns, sensitivity, n_sensitivity, of, knowns,
                              n_knowns, seed, n_seed, by);
    if (c == NULL) {
        return fmi2Error;
    }
    for (size_t k = 0; k < n_seed; ++k) {
        seeds[by[k]] += seed[k];
    }
    numbers(c, values);
    along(c, values, seeds, slopes);
    for (size_t i = 0; i < n_sensitivity; ++i) {
        sensitivity[i] = slopes[of[i]];
    }
    return checked(c, function, of, sensitivity, n_sensitivity);
}

FMI3_EXPORT fmi3Status fmi3GetAdjointDerivative(fmi3Instance instance, const fmi3ValueReference unknowns[],
                                                size_t n_unknowns, const fmi3ValueReference knowns[], size_t n_knowns,
                                                const fmi3Float64 seed[], size_t n_seed, fmi3Float64 sensitivity[],
                                                size_t n_sensitivity)
{
    const char *const function = "fmi3GetAdjointDerivative";
    fmi2ValueReference of[BLOCK_VARIABLES], by[BLOCK_VARIABLES];
    double values[BLOCK_VARIABLES], seeds[BLOCK_VARIABLES] = {0.0}, slopes[BLOCK_VARIABLES];
    const Instance *c = begin(instance, function, unknowns, n_unknowns, seed, n_seed, of, knowns, n_knowns, sensitivity,
                              n_sensitivity, by);
    if (c == NULL) {
        return fmi2Error;
    }
    numbers(c, values);
    for (size_t k = 0; k < n_sensitivity; ++k) {
        seeds[by[k]] = 1.0;
        along(c, values, seeds, slopes);
        seeds[by[k]] = 0.0;
        sensitivity[k] = 0.0;
        for (size_t i = 0; i < n_seed; ++i) {
            sensitivity[k] += seed[i] * slopes[of[i]];
        }
    }
    return checked(c, function, by, sensitivity, n_sensitivity);
}

#endif
