/* FMI 3.0 for co-simulation on top of an FMU of FMI 2.0, for tests: the same block behind either version.
 *
 * The FMU of FMI 2.0 is linked with this file, or, with -DLOADS, loaded from the file "block" in the resources. A value
 * reference holds the type (0 real, 1 integer, 2 boolean, 3 text), the causality, the number of elements and the first of their
 * references in FMI 2.0, which follow each other: type << 28 | causality << 24 | elements << 16 | reference. What a master
 * without clocks, events and states does not call gives an error, as it may. */
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#if defined(_WIN32)
#include <windows.h>
#define API __declspec(dllexport)
#else
#include <dlfcn.h>
#define API __attribute__((visibility("default")))
#endif

typedef void (*Log)(void *environment, int status, const char *category, const char *message);
typedef struct {
    void (*logger)(void *, const char *, int, const char *, const char *, ...);
    void *(*allocate)(size_t, size_t);
    void (*release)(void *);
    void *finished, *environment;
} Callbacks;
typedef struct {
    void *block;
    Log log;
    void *environment;
    Callbacks callbacks;
} Instance;
enum { OK, WARNING, DISCARD, ERROR, FATAL };
enum { MOST = 4096 };

#define FUNCTIONS(X)                                                                                                   \
    X(void *, fmi2Instantiate, (const char *, int, const char *, const char *, const Callbacks *, int, int))           \
    X(void, fmi2FreeInstance, (void *))                                                                                \
    X(int, fmi2SetupExperiment, (void *, int, double, double, int, double))                                            \
    X(int, fmi2EnterInitializationMode, (void *))                                                                      \
    X(int, fmi2ExitInitializationMode, (void *))                                                                       \
    X(int, fmi2Terminate, (void *))                                                                                    \
    X(int, fmi2Reset, (void *))                                                                                        \
    X(int, fmi2GetReal, (void *, const unsigned *, size_t, double *))                                                  \
    X(int, fmi2SetReal, (void *, const unsigned *, size_t, const double *))                                            \
    X(int, fmi2GetInteger, (void *, const unsigned *, size_t, int *))                                                  \
    X(int, fmi2SetInteger, (void *, const unsigned *, size_t, const int *))                                            \
    X(int, fmi2GetBoolean, (void *, const unsigned *, size_t, int *))                                                  \
    X(int, fmi2SetBoolean, (void *, const unsigned *, size_t, const int *))                                            \
    X(int, fmi2SetString, (void *, const unsigned *, size_t, const char *const *))                                     \
    X(int, fmi2DoStep, (void *, double, double, int))

#define FIELD(type, name, arguments) type(*name) arguments;
static struct {
    FUNCTIONS(FIELD)
} two;

#ifdef LOADS
static int load(const char *resources)
{
    char path[4096];
    snprintf(path, sizeof path, "%sblock", resources);
#if defined(_WIN32)
    HMODULE library = LoadLibraryA(path);
#define FIND(type, name, arguments) *(FARPROC *)&two.name = GetProcAddress(library, #name);
#else
    void *library = dlopen(path, RTLD_NOW | RTLD_LOCAL);
#define FIND(type, name, arguments) *(void **)&two.name = dlsym(library, #name);
#endif
    if (library) {
        FUNCTIONS(FIND)
    }
    return library != NULL;
}
#else
#define DECLARE(type, name, arguments) extern type name arguments;
FUNCTIONS(DECLARE)
static int load(const char *resources)
{
    (void)resources;
#define TAKE(type, name, arguments) two.name = name;
    FUNCTIONS(TAKE)
    return 1;
}
#endif

static void logger(void *instance, const char *name, int status, const char *category, const char *format, ...)
{
    char text[1024];
    va_list arguments;
    (void)name;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    Instance *it = instance;
    it->log(it->environment, status, category, text);
}

/* References of FMI 2.0 of all the elements; their number, or -1 where it is not that of the values. */
static long expand(const uint32_t references[], size_t count, size_t values, unsigned into[MOST])
{
    size_t n = 0;
    for (size_t i = 0; i < count; i++)
        for (uint32_t k = 0; k < (references[i] >> 16 & 0xff) && n < MOST; k++)
            into[n++] = (references[i] & 0xffff) + k;
    return n == values ? (long)n : -1;
}

#define EXCHANGE(NAME, TYPE, KIND, HELD)                                                                               \
    API int fmi3Get##NAME(void *instance, const uint32_t references[], size_t count, TYPE values[], size_t length)     \
    {                                                                                                                  \
        unsigned all[MOST];                                                                                            \
        HELD held[MOST];                                                                                               \
        const long n = expand(references, count, length, all);                                                         \
        const int status = n < 0 ? ERROR : two.fmi2Get##KIND(((Instance *)instance)->block, all, (size_t)n, held);     \
        for (long i = 0; i < n; i++)                                                                                   \
            values[i] = (TYPE)held[i];                                                                                 \
        return status;                                                                                                 \
    }                                                                                                                  \
    API int fmi3Set##NAME(void *instance, const uint32_t references[], size_t count, const TYPE values[],              \
                          size_t length)                                                                               \
    {                                                                                                                  \
        unsigned all[MOST];                                                                                            \
        HELD held[MOST];                                                                                               \
        const long n = expand(references, count, length, all);                                                         \
        for (long i = 0; i < n; i++)                                                                                   \
            held[i] = (HELD)values[i];                                                                                 \
        return n < 0 ? ERROR : two.fmi2Set##KIND(((Instance *)instance)->block, all, (size_t)n, held);                 \
    }
EXCHANGE(Float64, double, Real, double)
EXCHANGE(Float32, float, Real, double)
EXCHANGE(Int8, int8_t, Integer, int)
EXCHANGE(UInt8, uint8_t, Integer, int)
EXCHANGE(Int16, int16_t, Integer, int)
EXCHANGE(UInt16, uint16_t, Integer, int)
EXCHANGE(Int32, int32_t, Integer, int)
EXCHANGE(UInt32, uint32_t, Integer, int)
EXCHANGE(Int64, int64_t, Integer, int)
EXCHANGE(UInt64, uint64_t, Integer, int)
EXCHANGE(Boolean, bool, Boolean, int)

API int fmi3SetString(void *instance, const uint32_t references[], size_t count, const char *const values[],
                      size_t length)
{
    unsigned all[MOST];
    const long n = expand(references, count, length, all);
    return n < 0 ? ERROR : two.fmi2SetString(((Instance *)instance)->block, all, (size_t)n, values);
}

API const char *fmi3GetVersion(void)
{
    return "3.0";
}
API void *fmi3InstantiateCoSimulation(const char *name, const char *token, const char *resources, bool visible,
                                      bool logging, bool events, bool early, const uint32_t intermediate[],
                                      size_t count, void *environment, Log log, void *update)
{
    (void)intermediate, (void)update;
    Instance *it = calloc(1, sizeof *it);
    it->log = log;
    it->environment = environment;
    it->callbacks = (Callbacks){logger, calloc, free, NULL, it};
    if (visible || !logging || events || early || count || !resources) {
        log(environment, ERROR, "logStatusError", "asked for what a master without events does not need");
    } else if (!load(resources)) {
        log(environment, ERROR, "logStatusError", "the block in the resources cannot be loaded");
    } else {
        it->block = two.fmi2Instantiate(name, 1, token, resources, &it->callbacks, 0, 1);
    }
    if (!it->block) {
        free(it);
        return NULL;
    }
    return it;
}
API void fmi3FreeInstance(void *instance)
{
    two.fmi2FreeInstance(((Instance *)instance)->block);
    free(instance);
}
API int fmi3EnterInitializationMode(void *instance, bool tolerance_defined, double tolerance, double start,
                                    bool stop_defined, double stop)
{
    void *block = ((Instance *)instance)->block;
    const int status = two.fmi2SetupExperiment(block, tolerance_defined, tolerance, start, stop_defined, stop);
    return status > WARNING ? status : two.fmi2EnterInitializationMode(block);
}
API int fmi3ExitInitializationMode(void *instance)
{
    return two.fmi2ExitInitializationMode(((Instance *)instance)->block);
}
API int fmi3Terminate(void *instance)
{
    return two.fmi2Terminate(((Instance *)instance)->block);
}
API int fmi3Reset(void *instance)
{
    return two.fmi2Reset(((Instance *)instance)->block);
}
#ifndef WITHOUT_STEP_3
API int fmi3DoStep(void *instance, double time, double step, bool no_restore, bool *event, bool *end, bool *early,
                   double *last)
{
    *event = *end = *early = false;
    const int status = two.fmi2DoStep(((Instance *)instance)->block, time, step, no_restore);
    *last = time + step;
    if (status > FATAL + 1) { /* an answer in place of a status: 10 and the sum of 1, 2 and 4 */
        *event = (status - 10) & 1;
        *end = (status - 10) & 2;
        *early = (status - 10) & 4;
        return OK;
    }
    return status;
}
#endif

#define UNUSED(name)                                                                                                   \
    API int fmi3##name(void)                                                                                           \
    {                                                                                                                  \
        return ERROR;                                                                                                  \
    }
UNUSED(SetDebugLogging)
UNUSED(EnterEventMode)
UNUSED(EnterStepMode)
UNUSED(EnterConfigurationMode)
UNUSED(ExitConfigurationMode)
UNUSED(GetString)
UNUSED(GetBinary)
UNUSED(SetBinary)
UNUSED(GetClock)
UNUSED(SetClock)
UNUSED(GetNumberOfVariableDependencies)
UNUSED(GetVariableDependencies)
UNUSED(GetFMUState)
UNUSED(SetFMUState)
UNUSED(FreeFMUState)
UNUSED(SerializedFMUStateSize)
UNUSED(SerializeFMUState)
UNUSED(DeserializeFMUState)
UNUSED(GetDirectionalDerivative)
UNUSED(GetAdjointDerivative)
UNUSED(GetIntervalDecimal)
UNUSED(GetIntervalFraction)
UNUSED(GetShiftDecimal)
UNUSED(GetShiftFraction)
UNUSED(SetIntervalDecimal)
UNUSED(SetIntervalFraction)
UNUSED(SetShiftDecimal)
UNUSED(SetShiftFraction)
UNUSED(EvaluateDiscreteStates)
UNUSED(UpdateDiscreteStates)
UNUSED(GetOutputDerivatives)
