/* An FMU that stands before a block and gives it what a scenario does to its inputs: signals with faults or a delay,
 * and values at given times. One library serves any of them: resources/changes.bin says what happens.
 * fmus/changes/__init__.py writes it and describes it. */
#include <math.h>

#include "table.h"

fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid, fmi2String resources,
                              const fmi2CallbackFunctions *calls, fmi2Boolean visible, fmi2Boolean log)
{
    (void)visible, (void)log;
    Changes *c = host_instance(sizeof *c, name, type, guid, resources, calls);
    if (c == NULL) {
        return NULL;
    }
    const char *reason;
    if (!table_open(c, resources, guid, &reason)) {
        host_refuse(&c->host, reason);
        fmi2FreeInstance(c);
        return NULL;
    }
    return c;
}

void fmi2FreeInstance(fmi2Component component)
{
    Changes *c = component;
    if (c != NULL) {
        c->host.calls.freeMemory(c);
    }
}

fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean d, fmi2Real tolerance, fmi2Real start, fmi2Boolean s,
                               fmi2Real stop)
{
    (void)c, (void)d, (void)tolerance, (void)start, (void)s, (void)stop;
    return fmi2OK;
}

fmi2Status fmi2ExitInitializationMode(fmi2Component c)
{
    table_begin(c);
    return fmi2OK;
}

fmi2Status fmi2Reset(fmi2Component c)
{
    table_reset(c);
    return fmi2OK;
}

fmi2Status fmi2DoStep(fmi2Component c, fmi2Real t, fmi2Real h, fmi2Boolean no_set_state_before)
{
    (void)no_set_state_before;
    if (!(h > 0.0)) {
        return host_refuse(c, "fmi2DoStep: expected a step above 0");
    }
    table_step(c, t, h);
    return fmi2OK;
}

/* Whether there is a variable of this type with this reference: an input where one is set. */
static bool known(const Changes *c, fmi2ValueReference reference, Type type, bool set)
{
    const uint32_t i = reference / 2u;
    const bool output = reference % 2u != 0u;
    return i < c->head.channels && c->channels[i].type == (uint32_t)type && (output ? !set : c->channels[i].fed != 0u);
}

static double value_of(const Changes *c, fmi2ValueReference reference)
{
    return reference % 2u != 0u ? table_output(c, reference / 2u) : c->inputs[reference / 2u];
}

#define ACCESS(NAME, LONG, TYPE, FOUND, ROUNDED)                                                                       \
    fmi2Status fmi2Get##NAME(fmi2Component c, const fmi2ValueReference r[], size_t n, TYPE v[])                        \
    {                                                                                                                  \
        for (size_t i = 0; i < n; ++i) {                                                                               \
            if (!known(c, r[i], FOUND, false)) {                                                                       \
                return host_refuse(c, "fmi2Get" LONG ": there is no such variable with this value reference");         \
            }                                                                                                          \
            v[i] = (TYPE)(ROUNDED(value_of(c, r[i])));                                                                 \
        }                                                                                                              \
        return fmi2OK;                                                                                                 \
    }                                                                                                                  \
    fmi2Status fmi2Set##NAME(fmi2Component c, const fmi2ValueReference r[], size_t n, const TYPE v[])                  \
    {                                                                                                                  \
        for (size_t i = 0; i < n; ++i) {                                                                               \
            if (!known(c, r[i], FOUND, true) || !isfinite((double)v[i])) {                                             \
                return host_refuse(c, "fmi2Set" LONG ": expected a finite number for an input of this type");          \
            }                                                                                                          \
            ((Changes *)c)->inputs[r[i] / 2u] = (double)v[i];                                                          \
        }                                                                                                              \
        return fmi2OK;                                                                                                 \
    }

#define AS_IT_IS(x) (x)
#define NEAREST(x) ((x) < 0.0 ? (x) - 0.5 : (x) + 0.5)
#define TRUTH(x) ((x) != 0.0)

ACCESS(Real, "Real", fmi2Real, REAL, AS_IT_IS)
ACCESS(Integer, "Integer", fmi2Integer, INTEGER, NEAREST)
ACCESS(Boolean, "Boolean", fmi2Boolean, BOOLEAN, TRUTH)
