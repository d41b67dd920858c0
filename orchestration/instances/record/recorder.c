/* Stands before an FMU's functions: writes each call into mapped memory, passes it on, and writes its answer behind it.
 *
 * The file is mapped by the caller, so that what is written is kept whatever becomes of the process. Nothing is
 * allocated here: `room` moves the window on the file, and `memory` gives more of it. calls.h has the format.
 *
 * Longer than 250 lines: each kind of function of both versions of FMI has its own arguments. */
#include "calls.h"

#include <stdatomic.h>
#include <stdbool.h>
#include <string.h>

#if defined(_WIN32)
#define EXPORT __declspec(dllexport)
#else
#define EXPORT __attribute__((visibility("default")))
#endif

typedef struct Shape {
    struct Shape *next;
    uint32_t number, references, values;
    uint32_t *reference;
    uint8_t *last;
} Shape;

typedef struct Recorder {
    uint8_t *at, *end; /* what is left of the window; none where nothing more can be written */
    void (*room)(size_t);
    void *(*memory)(size_t); /* cleared */
    void *component;
    void *function[FUNCTION_COUNT];
    Shape *shapes[FUNCTION_COUNT];
    uint32_t count;
    double setup[SETUP_VALUES], step[STEP_VALUES], answers[STEP_ANSWERS];
} Recorder;

/* The recorder of the instance that is made next in this thread; `instantiate` has no argument for it. */
static Recorder *next;

EXPORT void recorder_next(Recorder *recorder)
{
    next = recorder;
}

EXPORT size_t recorder_size(void)
{
    return sizeof(Recorder);
}

/* The name of a function by its number; NULL behind the last, empty for what is none of FMI's. */
EXPORT const char *recorder_name(unsigned function)
{
#define NAME(name, kind, version, size) #name,
    static const char *const names[] = {"", "", FUNCTIONS(NAME)};
    return function < FUNCTION_COUNT ? names[function] : NULL;
}

EXPORT void recorder_take(Recorder *it, unsigned number, void *function)
{
    it->function[number] = function;
}

/* Whether so many bytes can be written, and what `values` writes beyond. */
static bool fits(Recorder *it, size_t bytes)
{
    const size_t needed = bytes + 2 * sizeof(uint64_t);
    if (it->at != NULL && (size_t)(it->end - it->at) < needed) {
        it->room(needed);
    }
    return it->at != NULL;
}

/* Puts a byte before what has been written behind it up to `at`: until then, and behind that, zero ends the record. */
static void put(Recorder *it, unsigned value, uint8_t *at)
{
    *at = END;
    atomic_signal_fence(memory_order_seq_cst);
    *it->at = (uint8_t)value;
    it->at = at;
}

static uint8_t *bytes(uint8_t *at, const void *from, size_t count)
{
    memcpy(at, from, count);
    return at + count;
}

static uint8_t *text(uint8_t *at, const char *from)
{
    const uint32_t length = from == NULL ? 0 : (uint32_t)strlen(from);
    at = bytes(at, &length, sizeof length);
    return bytes(at, from == NULL ? "" : from, length);
}

static size_t text_size(const char *from)
{
    return 4 + (from == NULL ? 0 : strlen(from));
}

static size_t values_size(size_t count, size_t size)
{
    return (count + 7) / 8 + count * size;
}

static uint8_t *values(uint8_t *mask, void *last, const void *now, size_t count, size_t size)
{
    uint8_t *at = mask + (count + 7) / 8, *const held = last;
    const uint8_t *given = now;
    if (size == 8) { /* as below, and quick: each value is written, and the next one over it if it is the last one's */
        for (size_t i = 0; i < count; i += 8) {
            unsigned differ = 0;
            for (size_t k = i; k < count && k < i + 8; k++) {
                uint64_t a, b;
                memcpy(&a, held + 8 * k, 8);
                memcpy(&b, given + 8 * k, 8);
                memcpy(at, &b, 8);
                memcpy(held + 8 * k, &b, 8);
                at += a != b ? 8 : 0;
                differ |= (unsigned)(a != b) << (k - i);
            }
            mask[i / 8] = (uint8_t)differ;
        }
        return at;
    }
    memset(mask, 0, (count + 7) / 8);
    for (size_t i = 0; i < count * size; i += size) {
        if (memcmp(held + i, given + i, size) != 0) {
            mask[i / size / 8] = (uint8_t)(mask[i / size / 8] | 1u << i / size % 8);
            memcpy(held + i, given + i, size);
            at = bytes(at, given + i, size);
        }
    }
    return at;
}

/* The shape of a Get or Set, which is written where it is new; NULL where it cannot be. */
static Shape *shape_of(Recorder *it, unsigned function, const uint32_t *reference, size_t n, size_t count, size_t size)
{
    for (Shape *one = it->shapes[function]; one != NULL; one = one->next) {
        bool same = one->references == n && one->values == count;
        for (size_t i = 0; same && i < n; i++) {
            same = one->reference[i] == reference[i];
        }
        if (same) {
            return one;
        }
    }
    Shape *made = fits(it, 10 + 4 * n) ? it->memory(sizeof *made + 4 * n + 8 + count * size) : NULL;
    if (made == NULL) {
        it->at = NULL;
        return NULL;
    }
    *made = (Shape){it->shapes[function], it->count++, (uint32_t)n, (uint32_t)count, (uint32_t *)(made + 1), NULL};
    made->last = (uint8_t *)(made->reference + n);
    memcpy(made->reference, reference, n * 4);
    it->shapes[function] = made;
    uint8_t *at = it->at + 1;
    *at++ = (uint8_t)function;
    at = bytes(at, &made->references, 4);
    at = bytes(at, &made->values, 4);
    put(it, SHAPE, bytes(at, reference, n * 4));
    return made;
}

static void answer(Recorder *it, int status)
{
    if (it->at != NULL) {
        put(it, (unsigned)status + 1u, it->at + 1);
    }
}

static int plain(Recorder *it, unsigned function)
{
    if (fits(it, 2)) {
        put(it, function, it->at + 1);
    }
    const int status = ((int (*)(void *))it->function[function])(it->component);
    answer(it, status);
    return status;
}

/* A Set or Get up to the call itself. */
static Shape *begin(Recorder *it, unsigned function, const uint32_t *reference, size_t n, const void *given,
                    size_t count, size_t size, bool sets)
{
    Shape *const shape = it->at == NULL ? NULL : shape_of(it, function, reference, n, count, size);
    size_t needed = 4 + values_size(count, size);
    for (size_t i = 0; size == 0 && sets && i < count; i++) {
        needed += text_size(((const char *const *)given)[i]);
    }
    if (shape == NULL || !fits(it, needed)) {
        return NULL;
    }
    uint8_t *at = bytes(it->at + 1, &(uint16_t){(uint16_t)shape->number}, 2);
    if (sets && size > 0) {
        at = values(at, shape->last, given, count, size);
    }
    for (size_t i = 0; size == 0 && sets && i < count; i++) {
        at = text(at, ((const char *const *)given)[i]);
    }
    put(it, function, at);
    return shape;
}

static int finish(Recorder *it, Shape *shape, const void *taken, size_t count, size_t size, bool sets, int status)
{
    if (sets || shape == NULL || it->at == NULL || status > 1) {
        answer(it, status);
    } else if (size > 0) {
        put(it, (unsigned)status + 1u, values(it->at + 1, shape->last, taken, count, size));
    } else {
        answer(it, status);
        for (size_t i = 0; i < count; i++) {
            const char *one = ((const char *const *)taken)[i];
            if (fits(it, text_size(one))) {
                it->at = text(it->at, one);
                *it->at = END;
            }
        }
    }
    return status;
}

#define DO_PLAIN(name, version, size)                                                                                  \
    EXPORT int recorded_##name(Recorder *it)                                                                           \
    {                                                                                                                  \
        return plain(it, IS_##name);                                                                                   \
    }
#define DO_FREE(name, version, size)                                                                                   \
    EXPORT void recorded_##name(Recorder *it)                                                                          \
    {                                                                                                                  \
        if (fits(it, 2)) {                                                                                             \
            put(it, IS_##name, it->at + 1);                                                                            \
        }                                                                                                              \
        ((void (*)(void *))it->function[IS_##name])(it->component);                                                    \
        answer(it, 0);                                                                                                 \
    }
#define EXCHANGE_2(name, size, sets)                                                                                   \
    EXPORT int recorded_##name(Recorder *it, const uint32_t reference[], size_t n, void *data)                         \
    {                                                                                                                  \
        Shape *const shape = begin(it, IS_##name, reference, n, data, n, size, sets);                                  \
        const int status = ((int (*)(void *, const uint32_t *, size_t, void *))it->function[IS_##name])(               \
            it->component, reference, n, data);                                                                        \
        return finish(it, shape, data, n, size, sets, status);                                                         \
    }
#define EXCHANGE_3(name, size, sets)                                                                                   \
    EXPORT int recorded_##name(Recorder *it, const uint32_t reference[], size_t n, void *data, size_t count)           \
    {                                                                                                                  \
        Shape *const shape = begin(it, IS_##name, reference, n, data, count, size, sets);                              \
        const int status = ((int (*)(void *, const uint32_t *, size_t, void *, size_t))it->function[IS_##name])(       \
            it->component, reference, n, data, count);                                                                 \
        return finish(it, shape, data, count, size, sets, status);                                                     \
    }
#define DO_SET(name, version, size) EXCHANGE_##version(name, size, true)
#define DO_GET(name, version, size) EXCHANGE_##version(name, size, false)
#define DO_STATE(name, type, address)                                                                                  \
    EXPORT int recorded_##name(Recorder *it, type state)                                                               \
    {                                                                                                                  \
        if (fits(it, 10)) {                                                                                            \
            put(it, IS_##name, bytes(it->at + 1, &(uint64_t){(uint64_t)(uintptr_t)(address)}, 8));                     \
        }                                                                                                              \
        const int status = ((int (*)(void *, type))it->function[IS_##name])(it->component, state);                     \
        answer(it, status);                                                                                            \
        return status;                                                                                                 \
    }
#define DO_STATE_SET(name, version, size) DO_STATE(name, void *, state)
#define DO_STATE_FREE(name, version, size) DO_STATE(name, void **, *state)
#define DO_STATE_GET(name, version, size)                                                                              \
    EXPORT int recorded_##name(Recorder *it, void **state)                                                             \
    {                                                                                                                  \
        if (fits(it, 10)) {                                                                                            \
            put(it, IS_##name, it->at + 1);                                                                            \
        }                                                                                                              \
        const int status = ((int (*)(void *, void **))it->function[IS_##name])(it->component, state);                  \
        answer(it, status);                                                                                            \
        if (it->at != NULL) {                                                                                          \
            it->at = bytes(it->at, &(uint64_t){(uint64_t)(uintptr_t)*state}, 8);                                       \
            *it->at = END;                                                                                             \
        }                                                                                                              \
        return status;                                                                                                 \
    }
#define DO_ENDED(name, version, size)                                                                                  \
    EXPORT int recorded_##name(Recorder *it, int which, int *value)                                                    \
    {                                                                                                                  \
        if (fits(it, 3)) {                                                                                             \
            put(it, IS_##name, bytes(it->at + 1, &(uint8_t){(uint8_t)which}, 1));                                      \
        }                                                                                                              \
        const int status = ((int (*)(void *, int, int *))it->function[IS_##name])(it->component, which, value);        \
        answer(it, status);                                                                                            \
        return status;                                                                                                 \
    }
#define DO_INSTANTIATE(name, version, size) /* written out below, as are those of SETUP and STEP */
#define DO_SETUP(name, version, size)
#define DO_STEP(name, version, size)
#define DO(name, kind, version, size) DO_##kind(name, version, size)
FUNCTIONS(DO)

/* Name and token, whose places in both versions' arguments are not the same. */
static Recorder *instantiate(unsigned function, const char *name, const char *token)
{
    Recorder *const it = next;
    if (fits(it, 2 + text_size(name) + text_size(token))) {
        put(it, function, text(text(it->at + 1, name), token));
    }
    return it;
}

static Recorder *instantiated(Recorder *it)
{
    answer(it, it->component == NULL ? 3 : 0);
    return it->component == NULL ? NULL : it;
}

EXPORT void *recorded_fmi2Instantiate(const char *name, int type, const char *token, const char *resources,
                                      const void *callbacks, int visible, int log)
{
    Recorder *const it = instantiate(IS_fmi2Instantiate, name, token);
    void *(*make)(const char *, int, const char *, const char *, const void *, int, int) = (void *(*)(
        const char *, int, const char *, const char *, const void *, int, int))it->function[IS_fmi2Instantiate];
    it->component = make(name, type, token, resources, callbacks, visible, log);
    return instantiated(it);
}

typedef void *(*Instantiate3)(const char *, const char *, const char *, bool, bool, bool, bool, const uint32_t *,
                              size_t, void *, void (*)(void), void (*)(void));
EXPORT void *recorded_fmi3InstantiateCoSimulation(const char *name, const char *token, const char *resources,
                                                  bool visible, bool log, bool event, bool early,
                                                  const uint32_t *variables, size_t n, void *environment,
                                                  void (*message)(void), void (*update)(void))
{
    Recorder *const it = instantiate(IS_fmi3InstantiateCoSimulation, name, token);
    it->component = ((Instantiate3)it->function[IS_fmi3InstantiateCoSimulation])(
        name, token, resources, visible, log, event, early, variables, n, environment, message, update);
    return instantiated(it);
}

static void setup(Recorder *it, unsigned function, double defined, double tolerance, double start, double stops,
                  double stop)
{
    const double given[SETUP_VALUES] = {defined, tolerance, start, stops, stop};
    if (fits(it, 2 + values_size(SETUP_VALUES, 8))) {
        put(it, function, values(it->at + 1, it->setup, given, SETUP_VALUES, 8));
    }
}

EXPORT int recorded_fmi2SetupExperiment(Recorder *it, int defined, double tolerance, double start, int stops,
                                        double stop)
{
    setup(it, IS_fmi2SetupExperiment, defined, tolerance, start, stops, stop);
    const int status = ((int (*)(void *, int, double, double, int, double))it->function[IS_fmi2SetupExperiment])(
        it->component, defined, tolerance, start, stops, stop);
    answer(it, status);
    return status;
}

EXPORT int recorded_fmi3EnterInitializationMode(Recorder *it, bool defined, double tolerance, double start, bool stops,
                                                double stop)
{
    setup(it, IS_fmi3EnterInitializationMode, defined, tolerance, start, stops, stop);
    const int status =
        ((int (*)(void *, bool, double, double, bool, double))it->function[IS_fmi3EnterInitializationMode])(
            it->component, defined, tolerance, start, stops, stop);
    answer(it, status);
    return status;
}

static void step(Recorder *it, unsigned function, double time, double length)
{
    const double given[STEP_VALUES] = {time, length};
    if (fits(it, 2 + values_size(STEP_VALUES, 8) + values_size(STEP_ANSWERS, 8))) {
        put(it, function, values(it->at + 1, it->step, given, STEP_VALUES, 8));
    }
}

EXPORT int recorded_fmi2DoStep(Recorder *it, double time, double length, int no_restore)
{
    step(it, IS_fmi2DoStep, time, length);
    const int status =
        ((int (*)(void *, double, double, int))it->function[IS_fmi2DoStep])(it->component, time, length, no_restore);
    answer(it, status);
    return status;
}

EXPORT int recorded_fmi3DoStep(Recorder *it, double time, double length, bool no_restore, bool *event, bool *end,
                               bool *early, double *last)
{
    step(it, IS_fmi3DoStep, time, length);
    const int status =
        ((int (*)(void *, double, double, bool, bool *, bool *, bool *, double *))it->function[IS_fmi3DoStep])(
            it->component, time, length, no_restore, event, end, early, last);
    if (it->at != NULL) {
        const double given[STEP_ANSWERS] = {*event, *end, *early, *last};
        put(it, (unsigned)status + 1u, values(it->at + 1, it->answers, given, STEP_ANSWERS, 8));
    }
    return status;
}
