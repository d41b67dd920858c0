/* What small FMUs of FMI 2.0 for tests have in common: types, the log, and functions that do nothing or are not offered. */
#ifndef SMALL_FMU_H
#define SMALL_FMU_H

#include <math.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef void (*Logger)(void *, const char *, int, const char *, const char *, ...);
typedef struct {
    Logger logger;
    void *allocate, *free, *finished, *environment;
} Callbacks;
enum { OK, WARNING, DISCARD, ERROR, FATAL, PENDING };

#if defined(_WIN32)
#define API __declspec(dllexport)
#else
#define API __attribute__((visibility("default")))
#endif

/* Logs "text value"; returns the status. */
static int log_value(const Callbacks *callbacks, const char *name, int status, const char *text, double value)
{
    callbacks->logger(callbacks->environment, name, status, "logStatus", "%s %g", text, value);
    return status;
}

API const char *fmi2GetTypesPlatform(void)
{
    return "default";
}
API const char *fmi2GetVersion(void)
{
    return "2.0";
}
API int fmi2SetDebugLogging(void *c, int on, size_t n, const char *const names[])
{
    (void)c, (void)on, (void)n, (void)names;
    return OK;
}
API int fmi2Reset(void *c)
{
    (void)c;
    return OK;
}
API int fmi2GetString(void *c, const unsigned v[], size_t n, const char *x[])
{
    (void)c, (void)v;
    for (size_t i = 0; i < n; i++)
        x[i] = "";
    return OK;
}
API int fmi2SetString(void *c, const unsigned v[], size_t n, const char *const x[])
{
    (void)c, (void)v, (void)n, (void)x;
    return OK;
}

#define UNUSED(name, ...)                                                                                              \
    API int name(__VA_ARGS__)                                                                                          \
    {                                                                                                                  \
        return ERROR;                                                                                                  \
    }
UNUSED(fmi2GetFMUstate, void *c, void **s)
UNUSED(fmi2SetFMUstate, void *c, void *s)
UNUSED(fmi2FreeFMUstate, void *c, void **s)
UNUSED(fmi2SerializedFMUstateSize, void *c, void *s, size_t *n)
UNUSED(fmi2SerializeFMUstate, void *c, void *s, char *b, size_t n)
UNUSED(fmi2DeSerializeFMUstate, void *c, const char *b, size_t n, void **s)
UNUSED(fmi2GetDirectionalDerivative, void *c, const unsigned *a, size_t n, const unsigned *b, size_t m, const double *x,
       double *y)
UNUSED(fmi2SetRealInputDerivatives, void *c, const unsigned *v, size_t n, const int *o, const double *x)
UNUSED(fmi2GetRealOutputDerivatives, void *c, const unsigned *v, size_t n, const int *o, double *x)
UNUSED(fmi2CancelStep, void *c)
UNUSED(fmi2GetStatus, void *c, int k, int *x)
UNUSED(fmi2GetRealStatus, void *c, int k, double *x)
UNUSED(fmi2GetIntegerStatus, void *c, int k, int *x)
#ifndef TELLS_ITS_END
UNUSED(fmi2GetBooleanStatus, void *c, int k, int *x)
#endif
UNUSED(fmi2GetStringStatus, void *c, int k, const char **x)

#endif
