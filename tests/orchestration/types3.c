/* An FMU of FMI 3.0 that hands on what it gets, in every numeric type, as arrays whose size is a parameter of their structure.
 *
 * Variables by their value references: 1 the structural parameter n, 3; of type T, the inputs 100 + T, shape [n, 2], and the
 * outputs 200 + T, which in a step become the inputs; 300 a parameter, text; 301 an output: the number of steps. The size of
 * each Get and Set is checked against the variables it names. */
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#if defined(_WIN32)
#define API __declspec(dllexport)
#else
#define API __attribute__((visibility("default")))
#endif
typedef void (*Log)(void *environment, int status, const char *category, const char *message);

enum { OK, WARNING, DISCARD, ERROR };
enum { SIZE = 6, TEXT = 300, STEPS = 301 };

#define TYPES(X)                                                                                                       \
    X(Float64, double, 0)                                                                                              \
    X(Float32, float, 1)                                                                                               \
    X(Int8, int8_t, 2)                                                                                                 \
    X(UInt8, uint8_t, 3)                                                                                               \
    X(Int16, int16_t, 4)                                                                                               \
    X(UInt16, uint16_t, 5)                                                                                             \
    X(Int32, int32_t, 6)                                                                                               \
    X(UInt32, uint32_t, 7)                                                                                             \
    X(Int64, int64_t, 8)                                                                                               \
    X(UInt64, uint64_t, 9)                                                                                             \
    X(Boolean, bool, 10)

#define FIELD(name, type, number) type in##name[SIZE], out##name[SIZE];
typedef struct {
    TYPES(FIELD)
    uint64_t steps;
    char text[64];
    Log log;
    void *environment;
} Instance;

static int refused(Instance *it, const char *text)
{
    it->log(it->environment, ERROR, "logStatusError", text);
    return ERROR;
}

#define EXCHANGE(name, type, number)                                                                                   \
    API int fmi3Get##name(void *instance, const uint32_t references[], size_t count, type values[], size_t length)     \
    {                                                                                                                  \
        Instance *it = instance;                                                                                       \
        size_t n = 0;                                                                                                  \
        for (size_t i = 0; i < count; i++) {                                                                           \
            if (references[i] == STEPS) {                                                                              \
                values[n++] = (type)it->steps;                                                                         \
                continue;                                                                                              \
            }                                                                                                          \
            if (references[i] != 100 + number && references[i] != 200 + number)                                        \
                return refused(it, "fmi3Get" #name " of another type");                                                \
            memcpy(values + n, references[i] >= 200 ? it->out##name : it->in##name, sizeof it->in##name);              \
            n += SIZE;                                                                                                 \
        }                                                                                                              \
        return n == length ? OK : refused(it, "fmi3Get" #name " of another length");                                   \
    }                                                                                                                  \
    API int fmi3Set##name(void *instance, const uint32_t references[], size_t count, const type values[],              \
                          size_t length)                                                                               \
    {                                                                                                                  \
        Instance *it = instance;                                                                                       \
        if (length != count * SIZE)                                                                                    \
            return refused(it, "fmi3Set" #name " of another length");                                                  \
        for (size_t i = 0; i < count; i++) {                                                                           \
            if (references[i] != 100 + number)                                                                         \
                return refused(it, "fmi3Set" #name " of another type");                                                \
            memcpy(it->in##name, values + i * SIZE, sizeof it->in##name);                                              \
        }                                                                                                              \
        return OK;                                                                                                     \
    }
TYPES(EXCHANGE)

API int fmi3SetString(void *instance, const uint32_t references[], size_t count, const char *const values[],
                      size_t length)
{
    Instance *it = instance;
    if (count != 1 || length != 1 || references[0] != TEXT)
        return refused(it, "fmi3SetString of another variable");
    strncpy(it->text, values[0], sizeof it->text - 1);
    it->log(it->environment, OK, "logAll", it->text);
    return OK;
}

API void *fmi3InstantiateCoSimulation(const char *name, const char *token, const char *resources, bool visible,
                                      bool logging, bool events, bool early, const uint32_t intermediate[],
                                      size_t count, void *environment, Log log, void *update)
{
    (void)name, (void)token, (void)resources, (void)visible, (void)logging, (void)events, (void)early,
        (void)intermediate;
    (void)count, (void)update;
    Instance *it = calloc(1, sizeof *it);
    it->log = log;
    it->environment = environment;
    for (size_t i = 0; i < SIZE; i++) /* as modelDescription.xml says */
        it->inInt16[i] = (int16_t)(i + 1);
    return it;
}
API void fmi3FreeInstance(void *instance)
{
    free(instance);
}
API int fmi3EnterInitializationMode(void *instance, bool tolerance_defined, double tolerance, double start,
                                    bool stop_defined, double stop)
{
    (void)instance, (void)tolerance_defined, (void)tolerance, (void)start, (void)stop_defined, (void)stop;
    return OK;
}
static int hand_on(Instance *it)
{
#define COPY(name, type, number) memcpy(it->out##name, it->in##name, sizeof it->in##name);
    TYPES(COPY)
    return OK;
}
API int fmi3ExitInitializationMode(void *instance)
{
    return hand_on(instance);
}
API int fmi3Terminate(void *instance)
{
    (void)instance;
    return OK;
}
API int fmi3DoStep(void *instance, double time, double step, bool no_restore, bool *event, bool *end, bool *early,
                   double *last)
{
    (void)no_restore;
    Instance *it = instance;
    it->steps++;
    *event = *end = *early = false;
    *last = time + step;
    return hand_on(it);
}
