/* Plays the record of an FMU's calls on its library, and says where an answer differs.
 *
 *     replay RECORD FOLDER [--library PATH] [--tolerance T] [--until N] [--shortest FILE] [--log]
 *
 * FOLDER holds the unpacked FMU. --tolerance: a number differs by more than this share of the largest value that its
 * port has had; 0 by default. --until: plays the first N calls. --shortest: writes the record up to the first call
 * that differs, fails or does not return. --log: prints what the FMU logs.
 * Exit status: 0 all answers are those of the record, 1 one is not, 2 it cannot be played, 3 the FMU has ended it.
 *
 * Longer than 250 lines: so that who gets it has one file to read. calls.h has the format. */
#include "calls.h"

#include <math.h>
#include <signal.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#if defined(_WIN32)
#include <windows.h>
#else
#include <dlfcn.h>
#endif

typedef void *Library;
typedef void (*Any)(void);

static Library opened(const char *path)
{
#if defined(_WIN32)
    return (Library)LoadLibraryExA(path, NULL, LOAD_WITH_ALTERED_SEARCH_PATH);
#else
    (void)dlopen("libm.so.6", RTLD_NOW | RTLD_GLOBAL); /* which some FMUs expect in their host */
    return dlopen(path, RTLD_NOW | RTLD_GLOBAL);
#endif
}

static const char *why(void)
{
#if defined(_WIN32)
    return "cannot be loaded";
#else
    return dlerror();
#endif
}

static Any function_of(Library library, const char *name)
{
#if defined(_WIN32)
    return (Any)GetProcAddress((HMODULE)library, name);
#else
    Any function;
    *(void **)&function = dlsym(library, name);
    return function;
#endif
}

typedef struct {
    const char *name;
    enum Kind kind;
    unsigned version, size;
} Description;
#define DESCRIBE(name, kind, version, size) {#name, kind, version, size},
static const Description FUNCTION[] = {{"", PLAIN, 0, 0}, {"", PLAIN, 0, 0}, FUNCTIONS(DESCRIBE)};
static const char *const STATUS[] = {"ok", "warning", "discard", "error", "fatal", "pending"};

typedef struct {
    char type[12], name[200];
    uint32_t reference, now; /* in the record, and in the FMU that is played */
    size_t size;
} Variable;

typedef struct {
    unsigned function;
    uint32_t references, values;
    uint32_t *reference, *now;
    uint8_t *last;
    double *largest;
} Shape;

static struct {
    uint8_t *data, *at, *end, *call;
    Variable *variables;
    size_t variable_count, shape_count;
    Shape *shapes;
    double setup[SETUP_VALUES], step[STEP_VALUES], answers[STEP_ANSWERS], time, tolerance;
    uint64_t recorded_state[256];
    void *state[256];
    size_t states;
    unsigned long number, until, differing;
    const char *shortest;
    bool written, log;
    void *component;
} it;

static void fail(const char *what, const char *which)
{
    fprintf(stderr, "%s: %s\n", what, which);
    exit(2);
}

static void *take(size_t bytes)
{
    void *memory = calloc(bytes > 0 ? bytes : 1, 1);
    if (memory == NULL) {
        fail("no memory", "ended");
    }
    return memory;
}

static uint8_t *next(size_t bytes)
{
    uint8_t *at = it.at;
    if ((size_t)(it.end - at) < bytes) {
        fail("the record is cut off", "its last call cannot be played");
    }
    it.at += bytes;
    return at;
}

static uint32_t number_of(size_t bytes)
{
    uint32_t value = 0;
    memcpy(&value, next(bytes), bytes);
    return value;
}

static char *text(void)
{
    const uint32_t length = number_of(4);
    char *made = take(length + 1);
    memcpy(made, next(length), length);
    return made;
}

static void values(void *last, size_t count, size_t size)
{
    const uint8_t *mask = next((count + 7) / 8);
    for (size_t i = 0; i < count; i++) {
        if (mask[i / 8] >> i % 8 & 1) {
            memcpy((uint8_t *)last + i * size, next(size), size);
        }
    }
}

/* The record up to here, for who gets it: written once. */
static void write_shortest(const uint8_t *end)
{
    if (it.shortest == NULL || it.written) {
        return;
    }
    it.written = true;
    FILE *file = fopen(it.shortest, "wb");
    if (file == NULL || fwrite(it.data, 1, (size_t)(end - it.data), file) != (size_t)(end - it.data)) {
        fail(it.shortest, "cannot be written");
    }
    fclose(file);
    printf("the shortest record that fails, %lu calls: %s\n", it.number, it.shortest);
}

static void say_call(void)
{
    printf("call %lu, %s at %.10g s: ", it.number, FUNCTION[*it.call].name, it.time);
}

/* A signal in a call of the FMU's. */
static void ended(int which)
{
    signal(which, SIG_DFL);
    say_call();
    printf("ends the process with signal %d\n", which);
    write_shortest(it.at);
    fflush(stdout);
    raise(which);
}

static double as_double(const uint8_t *value, const char *type, size_t size)
{
#define AS(text, ctype)                                                                                                \
    if (strcmp(type, text) == 0) {                                                                                     \
        ctype one;                                                                                                     \
        memcpy(&one, value, sizeof one);                                                                               \
        return (double)one;                                                                                            \
    }
    AS("Float32", float);
    AS("Int8", int8_t);
    AS("Int16", int16_t);
    AS("Int32", int32_t);
    AS("Int64", int64_t);
    AS("UInt8", uint8_t);
    AS("UInt16", uint16_t);
    AS("UInt32", uint32_t);
    AS("UInt64", uint64_t);
    AS("Integer", int32_t);
    if (strcmp(type, "Boolean") == 0) {
        return size == 1 ? *value != 0 : as_double(value, "Integer", 4) != 0.0;
    }
    double one;
    memcpy(&one, value, sizeof one);
    return one;
}

/* The record's variable that a function reads or writes by this reference; NULL where the record has none. */
static const Variable *variable_of(const Shape *shape, uint32_t reference)
{
    const char *type = FUNCTION[shape->function].name + 7;
    for (size_t v = 0; v < it.variable_count; v++) {
        if (it.variables[v].reference == reference && strcmp(it.variables[v].type, type) == 0) {
            return &it.variables[v];
        }
    }
    return NULL;
}

/* The call, and the port and its element to which value i of a shape belongs. */
static void say_port(const Shape *shape, size_t i)
{
    size_t first = 0;
    say_call();
    for (uint32_t k = 0; k < shape->references; k++) {
        const Variable *one = variable_of(shape, shape->reference[k]);
        const size_t size = one == NULL ? 0 : one->size;
        if (i < first + size) {
            printf("%s", one->name);
            if (size > 1) {
                printf("[%lu]", (unsigned long)(i - first + 1));
            }
            return;
        }
        first += size;
    }
    printf("a variable without name[%lu]", (unsigned long)i + 1);
}

static bool differs(const Shape *shape, size_t i, double was, double now)
{
    shape->largest[i] = fmax(shape->largest[i], fabs(was));
    if (isnan(was) || isnan(now)) {
        return isnan(was) != isnan(now);
    }
    return was != now && !(fabs(was - now) <= it.tolerance * shape->largest[i]);
}

/* Whether a result is not as recorded; all of them are told of the first call that has one. */
static bool compare(Shape *shape, const void *got, char *const *texts)
{
    const Description *f = &FUNCTION[shape->function];
    bool found = false;
    for (size_t i = 0; i < shape->values; i++) {
        if (f->size == 0) {
            const char *now = ((const char *const *)got)[i] == NULL ? "" : ((const char *const *)got)[i];
            if (strcmp(texts[i], now) != 0) {
                found = true;
                if (it.differing == 0) {
                    say_port(shape, i);
                    printf(" is '%s', recorded '%s'\n", now, texts[i]);
                }
            }
            continue;
        }
        const double was = as_double(shape->last + i * f->size, f->name + 7, f->size);
        const double now = as_double((const uint8_t *)got + i * f->size, f->name + 7, f->size);
        if (differs(shape, i, was, now)) {
            found = true;
            if (it.differing == 0) {
                say_port(shape, i);
                printf(" is %.17g, recorded %.17g\n", now, was);
            }
        }
    }
    return found;
}

/* The status of a call against that of the record, which says what follows. Returns whether results follow. */
static bool answered(int status, bool first)
{
    const unsigned was = it.at < it.end ? number_of(1) : 0;
    const char *now = status >= 0 && status < 6 ? STATUS[status] : "unknown";
    if (was == 0) {
        say_call();
        printf("has not returned in the record; here it gives status %s\n", now);
        write_shortest(it.at);
        exit(1);
    }
    if ((int)was - 1 != status) {
        if (it.differing++ == 0) {
            say_call();
            printf("gives status %s, recorded %s\n", now, was <= 6 ? STATUS[was - 1] : "unknown");
            write_shortest(it.at);
        }
        exit(1); /* what FMI allows from here on is another */
    }
    if (status > 1 && first) {
        say_call();
        printf("gives status %s, as in the record\n", now);
        write_shortest(it.at);
    }
    return status <= 1;
}

static void message_2(void *environment, const char *instance, int status, const char *category, const char *message,
                      ...)
{
    va_list arguments;
    (void)environment, (void)instance, (void)category;
    if (it.log) {
        va_start(arguments, message);
        fprintf(stderr, "  %s: ", status >= 0 && status < 6 ? STATUS[status] : "");
        vfprintf(stderr, message, arguments);
        fprintf(stderr, "\n");
        va_end(arguments);
    }
}

static void message_3(void *environment, int status, const char *category, const char *message)
{
    (void)environment, (void)category;
    if (it.log) {
        fprintf(stderr, "  %s: %s\n", status >= 0 && status < 6 ? STATUS[status] : "", message);
    }
}

static void **state_of(uint64_t recorded)
{
    for (size_t i = 0; i < it.states; i++) {
        if (it.recorded_state[i] == recorded) {
            return &it.state[i];
        }
    }
    if (it.states == 256) {
        fail("the record has too many states", "256 are held");
    }
    it.recorded_state[it.states] = recorded;
    return &it.state[it.states++];
}

static void *instance(Any function, const char *name, const char *token, const char *folder, unsigned version)
{
    char resources[4200];
    static const struct {
        void (*logger)(void *, const char *, int, const char *, const char *, ...);
        void *(*allocate)(size_t, size_t);
        void (*release)(void *);
        void (*finished)(void *, int);
        void *environment;
    } callbacks = {message_2, calloc, free, NULL, NULL};
    if (version == 2) {
        snprintf(resources, sizeof resources, "file://%s%s/resources", *folder == '/' ? "" : "/", folder);
        return ((void *(*)(const char *, int, const char *, const char *, const void *, int, int))function)(
            name, 1, token, resources, &callbacks, 0, 1);
    }
    snprintf(resources, sizeof resources, "%s/resources/", folder);
    return ((void *(*)(const char *, const char *, const char *, bool, bool, bool, bool, const uint32_t *, size_t,
                       void *, void (*)(void *, int, const char *, const char *), void *))function)(
        name, token, resources, false, true, false, false, NULL, 0, NULL, message_3, NULL);
}

/* The value of an attribute behind `from`, before `end`; into `into`. Returns whether it is there. */
static bool attribute(const char *from, const char *end, const char *name, char *into, size_t room)
{
    const size_t length = strlen(name);
    for (const char *at = from; at + length + 2 < end; at++) {
        if (strncmp(at, name, length) == 0 && at[length] == '=' && strchr(" \t\r\n", at[-1]) != NULL) {
            const char *first = at + length + 2, *last = strchr(first, at[length + 1]);
            if (last == NULL || (size_t)(last - first) >= room) {
                return false;
            }
            memcpy(into, first, (size_t)(last - first));
            into[last - first] = '\0';
            return true;
        }
    }
    return false;
}

static char *read_file(const char *path, size_t *size)
{
    FILE *file = fopen(path, "rb");
    if (file == NULL || fseek(file, 0, SEEK_END) != 0) {
        return NULL;
    }
    const long length = ftell(file);
    char *data = take((size_t)length + 1);
    rewind(file);
    *size = fread(data, 1, (size_t)length, file);
    fclose(file);
    return data;
}

/* Value references and token as this FMU has them, which need not be those of the record. Returns the token. */
static char *described(const char *folder)
{
    static char token[400];
    char path[4200], name[200], reference[24];
    size_t size = 0;
    snprintf(path, sizeof path, "%s/modelDescription.xml", folder);
    const char *xml = read_file(path, &size), *end = xml + size;
    if (xml == NULL) {
        fail(path, "cannot be read; expected the folder of an unpacked FMU");
    }
    const char *root = strstr(xml, "<fmiModelDescription"), *close = root == NULL ? NULL : strchr(root, '>');
    if (close == NULL || (!attribute(root, close, "guid", token, sizeof token) &&
                          !attribute(root, close, "instantiationToken", token, sizeof token))) {
        fail(path, "has no token");
    }
    for (const char *at = strchr(xml, '<'); at != NULL && at < end; at = strchr(at + 1, '<')) {
        const char *last = strchr(at, '>');
        if (last == NULL || !attribute(at, last, "valueReference", reference, sizeof reference) ||
            !attribute(at, last, "name", name, sizeof name)) {
            continue;
        }
        for (char *c = name; *c != '\0'; c++) { /* `R[1,2]` is R[1][2] in a record */
            if (*c == ',' && strlen(name) + 2 < sizeof name) {
                memmove(c + 1, c, strlen(c) + 1);
                *c++ = ']';
                *c = '[';
                while (c[1] == ' ') {
                    memmove(c + 1, c + 2, strlen(c + 1));
                }
            }
        }
        for (size_t v = 0; v < it.variable_count; v++) {
            if (strcmp(it.variables[v].name, name) == 0) {
                it.variables[v].now = (uint32_t)strtoul(reference, NULL, 10);
            }
        }
    }
    return token;
}

/* The lines before the calls. Returns the library's place in the FMU. */
static char *head(void)
{
    static char library[400];
    char *line = (char *)it.data, *last;
    if (strncmp(line, "FMI calls 1\n", 12) != 0) {
        fail("no record of calls", "expected 'FMI calls 1' in its first line");
    }
    for (; (last = memchr(line, '\n', (size_t)(it.end - (uint8_t *)line))) != NULL && last != line; line = last + 1) {
        *last = '\0';
        Variable one = {0};
        int begins = 0;
        unsigned long reference, size;
        if (sscanf(line, "variable %11s %lu %lu %n", one.type, &reference, &size, &begins) == 3 && begins > 0) {
            snprintf(one.name, sizeof one.name, "%s", line + begins);
            one.reference = one.now = (uint32_t)reference;
            one.size = size;
            it.variables = realloc(it.variables, (it.variable_count + 1) * sizeof one);
            it.variables[it.variable_count++] = one;
        } else {
            sscanf(line, "library %399[^\n]", library);
        }
        *last = '\n';
    }
    it.at = (uint8_t *)line + 1;
    return library;
}

static void shape(void)
{
    Shape one = {.function = number_of(1), .references = number_of(4), .values = number_of(4)};
    one.reference = take(4u * one.references);
    one.now = take(4u * one.references);
    memcpy(one.reference, next(4u * one.references), 4u * one.references);
    for (uint32_t k = 0; k < one.references; k++) {
        one.now[k] = one.reference[k];
        for (size_t v = 0; v < it.variable_count; v++) {
            if (it.variables[v].reference == one.reference[k] &&
                strcmp(it.variables[v].type, FUNCTION[one.function].name + 7) == 0) {
                one.now[k] = it.variables[v].now;
            }
        }
    }
    one.last = take(8u * one.values);
    one.largest = take(8u * one.values);
    it.shapes = realloc(it.shapes, (it.shape_count + 1) * sizeof one);
    it.shapes[it.shape_count++] = one;
}

static void exchange(Any function, const Description *f)
{
    const uint32_t which = number_of(2);
    if (which >= it.shape_count) {
        fail("the record is damaged", "a shape is missing");
    }
    Shape *one = &it.shapes[which];
    const bool sets = f->kind == SET;
    char **texts = take(sizeof *texts * one->values);
    void *buffer = take(8u * one->values), *data = f->size > 0 ? buffer : (void *)texts;
    for (size_t i = 0; f->size == 0 && sets && i < one->values; i++) {
        texts[i] = text();
    }
    if (sets && f->size > 0) {
        values(one->last, one->values, f->size);
        memcpy(buffer, one->last, f->size * one->values);
    } else if (!sets) {
        data = buffer;
    }
    const int status = f->version == 2 ? ((int (*)(void *, const uint32_t *, size_t, void *))function)(
                                             it.component, one->now, one->references, data)
                                       : ((int (*)(void *, const uint32_t *, size_t, void *, size_t))function)(
                                             it.component, one->now, one->references, data, one->values);
    if (answered(status, true) && !sets) {
        for (size_t i = 0; f->size == 0 && i < one->values; i++) {
            texts[i] = text();
        }
        if (f->size > 0) {
            values(one->last, one->values, f->size);
        }
        if (compare(one, buffer, texts)) {
            it.differing++;
            write_shortest(it.at);
        }
    }
    for (size_t i = 0; f->size == 0 && i < one->values; i++) {
        free(texts[i]);
    }
    free(texts);
    free(buffer);
}

static void step(Any function, unsigned version)
{
    values(it.step, STEP_VALUES, 8);
    it.time = it.step[0];
    if (version == 2) {
        answered(((int (*)(void *, double, double, int))function)(it.component, it.step[0], it.step[1], 1), true);
        return;
    }
    bool event = false, end = false, early = false;
    double last = it.time;
    const int status = ((int (*)(void *, double, double, bool, bool *, bool *, bool *, double *))function)(
        it.component, it.step[0], it.step[1], true, &event, &end, &early, &last);
    answered(status, true);
    values(it.answers, STEP_ANSWERS, 8);
    const double got[STEP_ANSWERS] = {event, end, early, last};
    if (memcmp(got, it.answers, sizeof got) != 0 && it.differing++ == 0) {
        say_call();
        printf("event %d, end %d, early %d, last time %.17g; recorded %.0f, %.0f, %.0f, %.17g\n", event, end, early,
               last, it.answers[0], it.answers[1], it.answers[2], it.answers[3]);
        write_shortest(it.at);
    }
}

static void call(Any function, const Description *f, const char *folder, const char *token)
{
    switch (f->kind) {
    case INSTANTIATE: {
        char *name = text(), *was = text();
        (void)was;
        it.component = instance(function, name, token, folder, f->version);
        answered(it.component == NULL ? 3 : 0, true);
        break;
    }
    case FREE:
        ((void (*)(void *))function)(it.component);
        answered(0, true);
        break;
    case SETUP: {
        const double *v = it.setup;
        values(it.setup, SETUP_VALUES, 8);
        answered(f->version == 2 ? ((int (*)(void *, int, double, double, int, double))function)(
                                       it.component, v[0] != 0.0, v[1], v[2], v[3] != 0.0, v[4])
                                 : ((int (*)(void *, bool, double, double, bool, double))function)(
                                       it.component, v[0] != 0.0, v[1], v[2], v[3] != 0.0, v[4]),
                 true);
        break;
    }
    case STEP:
        step(function, f->version);
        break;
    case SET:
    case GET:
        exchange(function, f);
        break;
    case STATE_GET: {
        void *made = NULL;
        if (answered(((int (*)(void *, void **))function)(it.component, &made), true)) {
            uint64_t recorded;
            memcpy(&recorded, next(8), 8);
            *state_of(recorded) = made;
        } else {
            next(8);
        }
        break;
    }
    case STATE_SET:
    case STATE_FREE: {
        uint64_t recorded;
        memcpy(&recorded, next(8), 8);
        void **state = state_of(recorded);
        answered(f->kind == STATE_SET ? ((int (*)(void *, void *))function)(it.component, *state)
                                      : ((int (*)(void *, void **))function)(it.component, state),
                 true);
        break;
    }
    case ENDED: {
        int value = 0;
        const int which = (int)number_of(1);
        answered(((int (*)(void *, int, int *))function)(it.component, which, &value), false);
        break;
    }
    case PLAIN:
        answered(((int (*)(void *))function)(it.component), true);
        break;
    }
}

int main(int count, char **argument)
{
    const char *library = NULL;
    char path[4800];
    size_t size = 0;
    if (count < 3) {
        fail("usage", "replay RECORD FOLDER [--library PATH] [--tolerance T] [--until N] [--shortest FILE] [--log]");
    }
    for (int i = 3; i < count; i++) {
        const char *value = i + 1 < count ? argument[i + 1] : "";
        if (strcmp(argument[i], "--log") == 0) {
            it.log = true;
            continue;
        }
        if (strcmp(argument[i], "--library") == 0) {
            library = value;
        } else if (strcmp(argument[i], "--tolerance") == 0) {
            it.tolerance = strtod(value, NULL);
        } else if (strcmp(argument[i], "--until") == 0) {
            it.until = strtoul(value, NULL, 10);
        } else if (strcmp(argument[i], "--shortest") == 0) {
            it.shortest = value;
        } else {
            fail("no such option", argument[i]);
        }
        i++;
    }
    it.data = (uint8_t *)read_file(argument[1], &size);
    if (it.data == NULL) {
        fail(argument[1], "cannot be read");
    }
    it.end = it.data + size;
    const char *place = head(), *token = described(argument[2]);
    snprintf(path, sizeof path, "%s/%s", argument[2], library == NULL ? place : library);
    Library loaded = opened(path);
    if (loaded == NULL) {
        fail(path, why());
    }
    for (int which = 0; which < 4; which++) {
        signal((const int[]){SIGSEGV, SIGABRT, SIGFPE, SIGILL}[which], ended);
    }
    while (it.at < it.end && *it.at != END && (it.until == 0 || it.number < it.until)) {
        it.call = it.at;
        const unsigned number = number_of(1);
        if (number == SHAPE) {
            shape();
            continue;
        }
        if (number >= FUNCTION_COUNT) {
            fail("the record is damaged", "a function has no name");
        }
        it.number++;
        Any function = function_of(loaded, FUNCTION[number].name);
        if (function == NULL) {
            fail(FUNCTION[number].name, "is missing in the library");
        }
        call(function, &FUNCTION[number], argument[2], token);
    }
    if (it.differing > 0) {
        printf("%lu of %lu calls differ\n", it.differing, it.number);
        return 1;
    }
    printf("%lu calls, all answers as recorded\n", it.number);
    return 0;
}
