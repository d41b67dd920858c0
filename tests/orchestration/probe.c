/* A small FMU for tests of the master: y = gain u (direct), dx/dt = u, and faults on demand.
 *
 * Reals: 0 fault_time, 1 y, 2 u, 3 gain, 4 x; the others are only kept. Integers: 0 fault, 1 steps.
 * Its GUID is "probe". */
#include "small_fmu.h"

#ifndef DIRECT /* y of all reals; a test may compile another */
#define DIRECT(x) ((x)[3] * (x)[2])
#endif

typedef struct {
    double real[64];
    int integer[64], boolean[64];
    int flights;
    char name[64];
    const Callbacks *callbacks;
} Probe;
enum { NONE, STEP_ERROR, STEP_NAN, STEP_FATAL, STEP_DISCARD, LEAVE_ERROR, STEP_WARNING };

static int tell(Probe *p, int status, const char *text, double value)
{
    return log_value(p->callbacks, p->name, status, text, value);
}

API void *fmi2Instantiate(const char *name, int type, const char *guid, const char *resources,
                          const Callbacks *callbacks, int visible, int logging)
{
    (void)type, (void)resources, (void)visible, (void)logging;
    if (strcmp(guid, "probe")) {
        callbacks->logger(callbacks->environment, name, ERROR, "logStatus", "expected the GUID probe, found %s", guid);
        return NULL;
    }
    Probe *p = calloc(1, sizeof *p);
    strncpy(p->name, name, sizeof p->name - 1);
    p->callbacks = callbacks;
    return p;
}
API void fmi2FreeInstance(void *c)
{
#ifdef NO_END
    for (volatile int on = 1; on;) {
    }
#endif
    free(c);
}
API int fmi2SetupExperiment(void *c, int a, double tolerance, double start, int b, double stop)
{
    (void)c, (void)a, (void)tolerance, (void)start, (void)b, (void)stop;
    return OK;
}
API int fmi2EnterInitializationMode(void *c)
{
#ifdef NO_START
    return tell(c, ERROR, "cannot begin, by", 1.0);
#endif
    (void)c;
    return OK;
}
API int fmi2ExitInitializationMode(void *c)
{
    Probe *p = c;
#ifdef DRIFT
    p->flights++;
#endif
    return p->integer[0] == LEAVE_ERROR ? tell(p, ERROR, "the gain is refused:", p->real[3]) : OK;
}
API int fmi2Terminate(void *c)
{
    (void)c;
    return OK;
}
API int fmi2GetReal(void *c, const unsigned v[], size_t n, double x[])
{
    Probe *p = c;
    p->real[1] = DIRECT(p->real);
    for (size_t i = 0; i < n; i++)
        x[i] = p->real[v[i]];
    return OK;
}
API int fmi2SetReal(void *c, const unsigned v[], size_t n, const double x[])
{
    for (size_t i = 0; i < n; i++)
        ((Probe *)c)->real[v[i]] = x[i];
    return OK;
}
API int fmi2GetInteger(void *c, const unsigned v[], size_t n, int x[])
{
    for (size_t i = 0; i < n; i++)
        x[i] = ((Probe *)c)->integer[v[i]];
    return OK;
}
API int fmi2SetInteger(void *c, const unsigned v[], size_t n, const int x[])
{
    for (size_t i = 0; i < n; i++)
        ((Probe *)c)->integer[v[i]] = x[i];
    return OK;
}
API int fmi2GetBoolean(void *c, const unsigned v[], size_t n, int x[])
{
    for (size_t i = 0; i < n; i++)
        x[i] = ((Probe *)c)->boolean[v[i]];
    return OK;
}
API int fmi2SetBoolean(void *c, const unsigned v[], size_t n, const int x[])
{
    for (size_t i = 0; i < n; i++)
        ((Probe *)c)->boolean[v[i]] = x[i];
    return OK;
}
API int fmi2DoStep(void *c, double t, double h, int keep)
{
    (void)keep;
    Probe *p = c;
    p->integer[1]++;
    p->real[4] += h * p->real[2];
#ifdef DRIFT /* from this flight on something is left of those before, whatever fmi2Reset does */
    p->real[4] += p->flights >= DRIFT ? 0.01 * h : 0.0;
#endif
    if (p->integer[0] == NONE || t < p->real[0])
        return OK;
    switch (p->integer[0]) {
    case STEP_ERROR:
        return tell(p, ERROR, "cannot step from", t);
    case STEP_DISCARD:
        return tell(p, DISCARD, "step too long:", h);
    case STEP_FATAL:
        return tell(p, FATAL, "broken at", t);
    case STEP_WARNING:
        return tell(p, WARNING, "tired at", t);
    case STEP_NAN:
        p->real[4] = NAN;
    }
    return OK;
}
