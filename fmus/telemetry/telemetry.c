/* An FMU that plays the rows of resources/telemetry.bin back at their own instants. One library serves any record: the
 * file says how many ports there are. fmus/telemetry/__init__.py writes it and describes it.
 *
 * Value references, in their order: hold, shift, rows, age, ended; then of each port its elements, valid, sample. */
#include "rows.h"

fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid, fmi2String resources,
                              const fmi2CallbackFunctions *calls, fmi2Boolean visible, fmi2Boolean log)
{
    (void)visible, (void)log;
    Telemetry *t = host_instance(sizeof *t, name, type, guid, resources, calls);
    if (t == NULL) {
        return NULL;
    }
    const char *reason = "resources/telemetry.bin has other ports";
    if (!rows_open(t, resources, guid, &reason)) {
        host_refuse(&t->host, reason);
        fmi2FreeInstance(t);
        return NULL;
    }
    return t;
}

void fmi2FreeInstance(fmi2Component c)
{
    Telemetry *t = c;
    if (t != NULL) {
        record_close(&t->file);
        t->host.calls.freeMemory(t);
    }
}

fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean d, fmi2Real tolerance, fmi2Real start, fmi2Boolean s,
                               fmi2Real stop)
{
    (void)d, (void)tolerance, (void)s, (void)stop;
    ((Telemetry *)c)->start = start;
    return fmi2OK;
}

/* The row of the start and those before it are taken at the first Get, so that shift may be set before. */
static bool prepared(Telemetry *t)
{
    if (!t->begun) {
        if (!rows_rewind(t)) {
            return false;
        }
        rows_advance(t, t->start);
        t->begun = true;
    }
    return true;
}

fmi2Status fmi2ExitInitializationMode(fmi2Component c)
{
    return prepared(c) ? fmi2OK : host_refuse(c, "resources/telemetry.bin cannot be read");
}

fmi2Status fmi2Reset(fmi2Component c)
{
    Telemetry *t = c;
    t->hold = t->shift = t->start = 0.0;
    return rows_rewind(t) ? fmi2OK : host_refuse(&t->host, "resources/telemetry.bin cannot be read");
}

fmi2Status fmi2DoStep(fmi2Component c, fmi2Real time, fmi2Real h, fmi2Boolean no_set_state_before)
{
    (void)no_set_state_before;
    Telemetry *t = c;
    if (!prepared(t)) {
        return host_refuse(&t->host, "resources/telemetry.bin cannot be read");
    }
    rows_advance(t, time + h);
    if ((uint64_t)t->rows < t->head.rows && rows_peek(t) == NULL) {
        return host_refuse(&t->host, "resources/telemetry.bin ends before its last row");
    }
    return fmi2OK;
}

static const Port *port_of(const Telemetry *t, fmi2ValueReference reference)
{
    for (uint32_t i = t->head.ports; i-- > 0;) {
        if (reference >= t->ports[i].reference) {
            return reference < t->ports[i].reference + t->ports[i].size + 2 ? &t->ports[i] : NULL;
        }
    }
    return NULL;
}

fmi2Status fmi2GetReal(fmi2Component c, const fmi2ValueReference r[], size_t n, fmi2Real v[])
{
    Telemetry *t = c;
    if (!prepared(t)) {
        return fmi2Error;
    }
    for (size_t i = 0; i < n; ++i) {
        const Port *p = port_of(t, r[i]);
        if (r[i] == HOLD || r[i] == SHIFT) {
            v[i] = r[i] == HOLD ? t->hold : t->shift;
        } else if (r[i] == AGE) {
            v[i] = t->rows > 0 ? t->now - t->last : 0.0;
        } else if (p != NULL && r[i] < p->reference + p->size) {
            v[i] = t->values[p->first + r[i] - p->reference];
        } else {
            return host_refuse(&t->host, "fmi2GetReal: there is no Real variable with this value reference");
        }
    }
    return fmi2OK;
}

fmi2Status fmi2GetInteger(fmi2Component c, const fmi2ValueReference r[], size_t n, fmi2Integer v[])
{
    Telemetry *t = c;
    if (!prepared(t)) {
        return fmi2Error;
    }
    for (size_t i = 0; i < n; ++i) {
        const Port *p = port_of(t, r[i]);
        if (r[i] != ROWS && (p == NULL || r[i] != p->reference + p->size + 1)) {
            return host_refuse(&t->host, "fmi2GetInteger: there is no Integer variable with this value reference");
        }
        v[i] = r[i] == ROWS ? t->rows : p->sample;
    }
    return fmi2OK;
}

fmi2Status fmi2GetBoolean(fmi2Component c, const fmi2ValueReference r[], size_t n, fmi2Boolean v[])
{
    Telemetry *t = c;
    if (!prepared(t)) {
        return fmi2Error;
    }
    for (size_t i = 0; i < n; ++i) {
        const Port *p = port_of(t, r[i]);
        if (r[i] == ENDED) {
            v[i] = (uint64_t)t->rows == t->head.rows;
        } else if (p != NULL && r[i] == p->reference + p->size) {
            v[i] = p->fresh || (p->sample > 0 && t->now - p->time <= t->hold + 1e-9);
        } else {
            return host_refuse(&t->host, "fmi2GetBoolean: there is no Boolean variable with this value reference");
        }
    }
    return fmi2OK;
}

fmi2Status fmi2SetReal(fmi2Component c, const fmi2ValueReference r[], size_t n, const fmi2Real v[])
{
    Telemetry *t = c;
    for (size_t i = 0; i < n; ++i) {
        if (r[i] > SHIFT || !(v[i] - v[i] == 0.0)) {
            return host_refuse(&t->host, "fmi2SetReal: expected hold or shift, and a finite number");
        }
        *(r[i] == HOLD ? &t->hold : &t->shift) = v[i];
        t->begun = t->begun && r[i] != SHIFT;
    }
    return fmi2OK;
}

#define SET(NAME, TYPE)                                                                                                \
    fmi2Status NAME(fmi2Component c, const fmi2ValueReference r[], size_t n, const TYPE v[])                           \
    {                                                                                                                  \
        (void)c, (void)r, (void)v;                                                                                     \
        return n == 0 ? fmi2OK : fmi2Error;                                                                            \
    }

SET(fmi2SetInteger, fmi2Integer)
SET(fmi2SetBoolean, fmi2Boolean)
