/* An FMU inside a container: its library and its instance, what it logs, and its errors, which are told with its name.
 */
#include <string.h>

#include "container.h"
#include "record_file.h"
#include "system.h"

enum { TEXT_SIZE = 1024, NEEDED = 7 };

/* The first are needed of every FMU, the others where they are called. */
static const struct {
    const char *name;
    size_t place;
} functions[] = {
    {"fmi2Instantiate", offsetof(Inner, instantiate)},
    {"fmi2FreeInstance", offsetof(Inner, free)},
    {"fmi2SetupExperiment", offsetof(Inner, setup)},
    {"fmi2EnterInitializationMode", offsetof(Inner, enter)},
    {"fmi2ExitInitializationMode", offsetof(Inner, leave)},
    {"fmi2Terminate", offsetof(Inner, terminate)},
    {"fmi2DoStep", offsetof(Inner, step)},
    {"fmi2Reset", offsetof(Inner, reset)},
    {"fmi2GetReal", offsetof(Inner, get[KIND_REAL])},
    {"fmi2GetInteger", offsetof(Inner, get[KIND_INTEGER])},
    {"fmi2GetBoolean", offsetof(Inner, get[KIND_BOOLEAN])},
    {"fmi2GetString", offsetof(Inner, get[KIND_STRING])},
    {"fmi2SetReal", offsetof(Inner, set[KIND_REAL])},
    {"fmi2SetInteger", offsetof(Inner, set[KIND_INTEGER])},
    {"fmi2SetBoolean", offsetof(Inner, set[KIND_BOOLEAN])},
    {"fmi2SetString", offsetof(Inner, set[KIND_STRING])},
    {"fmi2SetDebugLogging", offsetof(Inner, debug)},
    {"fmi2GetFMUstate", offsetof(Inner, get_state)},
    {"fmi2SetFMUstate", offsetof(Inner, set_state)},
    {"fmi2FreeFMUstate", offsetof(Inner, free_state)},
    {"fmi2SerializedFMUstateSize", offsetof(Inner, state_size)},
    {"fmi2SerializeFMUstate", offsetof(Inner, write_state)},
    {"fmi2DeSerializeFMUstate", offsetof(Inner, read_state)},
};

void container_say(const Container *c, fmi2Status status, const char *category, ...)
{
    char text[TEXT_SIZE];
    size_t n = 0;
    va_list parts;
    va_start(parts, category);
    for (const char *at; (at = va_arg(parts, const char *)) != NULL;) {
        for (; *at != '\0' && n < sizeof text - 2; ++at) {
            text[n++] = *at;
            if (*at == '%' || *at == '#') { /* those of a format, and before a value reference */
                text[n++] = *at;
            }
        }
    }
    va_end(parts);
    text[n] = '\0';
    if (c->host.calls.logger != NULL) {
        c->host.calls.logger(c->host.calls.componentEnvironment, c->host.name, status, category, text);
    }
}

/* The logger of the FMUs inside. Their value references mean nothing to the host, so #r12# is no more than text. */
static void pass(fmi2ComponentEnvironment environment, fmi2String instance, fmi2Status status, fmi2String category,
                 fmi2String message, ...)
{
    const Inner *inner = environment;
    char text[TEXT_SIZE];
    size_t n = 0;
    va_list given;
    (void)instance;
    va_start(given, message);
    system_write(text, sizeof text, message == NULL ? "" : message, given);
    va_end(given);
    for (const char *at = text; *at != '\0'; ++at) {
        at += at[0] == '#' && at[1] == '#';
        text[n++] = *at;
    }
    text[n] = '\0';
    container_say(inner->container, status, category, inner->name, ": ", text, NULL);
}

/* Puts texts one behind the other, the last of which is followed by NULL; false where they do not fit. */
static bool join(char *into, size_t size, ...)
{
    size_t n = 0;
    va_list parts;
    va_start(parts, size);
    for (const char *at; (at = va_arg(parts, const char *)) != NULL;) {
        for (; *at != '\0' && n < size; ++at) {
            into[n++] = *at;
        }
    }
    va_end(parts);
    into[n < size ? n : size - 1] = '\0';
    return n < size;
}

#if defined(_WIN32)
#define PLATFORM "/binaries/win64/"
#define SUFFIX ".dll"
#elif defined(__APPLE__)
#define PLATFORM "/binaries/darwin64/"
#define SUFFIX ".dylib"
#elif defined(__aarch64__)
#define PLATFORM "/binaries/aarch64-linux/"
#define SUFFIX ".so"
#else
#define PLATFORM "/binaries/linux64/"
#define SUFFIX ".so"
#endif

static bool load(Inner *inner, const BlockRow *row, const char *resources)
{
    const Container *c = inner->container;
    char own[512], path[PATH_SIZE];
    const char *reason = "its path is too long";
    if (join(own, sizeof own, c->text + row->folder, PLATFORM, c->text + row->identifier, SUFFIX, NULL) &&
        resource_path(path, resources, own)) {
        inner->library = system_load(path, &reason);
    }
    if (inner->library == NULL) {
        (void)REFUSE(c, inner->name, ": its library cannot be loaded: ", reason);
        return false;
    }
    for (size_t i = 0; i < sizeof functions / sizeof functions[0]; ++i) {
        void *const found = system_find(inner->library, functions[i].name);
        if (found == NULL && i < NEEDED) {
            (void)REFUSE(c, inner->name, ": its library lacks ", functions[i].name);
            return false;
        }
        memcpy((char *)inner + functions[i].place, &found, sizeof found);
    }
    return true;
}

bool inner_open(Inner *inner, const BlockRow *row, const char *resources, fmi2Boolean visible, fmi2Boolean log)
{
    const Container *c = inner->container;
    const size_t size = strlen(resources) + strlen(c->text + row->folder) + sizeof "//resources";
    char *uri = container_take(inner->container, size, 1);
    inner->name = c->text + row->name;
    if (uri == NULL || !load(inner, row, resources)) {
        return false;
    }
    const char *between = resources[0] != '\0' && resources[strlen(resources) - 1] == '/' ? "" : "/";
    join(uri, size, resources, between, c->text + row->folder, "/resources", NULL);
    inner->calls = (fmi2CallbackFunctions){pass, c->host.calls.allocateMemory, c->host.calls.freeMemory, NULL, inner};
    inner->instance =
        inner->instantiate(inner->name, fmi2CoSimulation, c->text + row->guid, uri, &inner->calls, visible, log);
    if (inner->instance == NULL) {
        (void)REFUSE(c, inner->name, ": fmi2Instantiate gave no instance");
    }
    return inner->instance != NULL;
}

void inner_close(Inner *inner)
{
    if (inner->lost) {
        return;
    }
    if (inner->instance != NULL) {
        inner->free(inner->instance);
    }
    if (inner->library != NULL) {
        system_unload(inner->library);
    }
}

fmi2Status inner_done(Inner *inner, fmi2Status status, const char *function)
{
    static const char *const names[] = {"fmi2OK",    "fmi2Warning", "fmi2Discard",
                                        "fmi2Error", "fmi2Fatal",   "fmi2Pending"};
    if (status <= fmi2Warning) {
        return fmi2OK;
    }
    const fmi2Status told = status == fmi2Fatal ? fmi2Fatal : fmi2Error;
    inner->lost = status == fmi2Fatal;
    container_say(inner->container, told, told == fmi2Fatal ? "logStatusFatal" : "logStatusError", inner->name, ": ",
                  function, " returned ", status <= fmi2Pending ? names[status] : "no status of FMI", NULL);
    return told;
}

const char *const GETTERS[KINDS] = {"fmi2GetReal", "fmi2GetInteger", "fmi2GetBoolean", "fmi2GetString"};
const char *const SETTERS[KINDS] = {"fmi2SetReal", "fmi2SetInteger", "fmi2SetBoolean", "fmi2SetString"};

fmi2Status inner_access(Inner *inner, bool sets, uint32_t kind, const fmi2ValueReference r[], size_t n, void *values)
{
    const Access function = sets ? inner->set[kind] : inner->get[kind];
    const char *const name = sets ? SETTERS[kind] : GETTERS[kind];
    if (inner->lost) {
        return fmi2Fatal;
    }
    if (function == NULL) {
        return REFUSE(inner->container, inner->name, ": its library lacks ", name);
    }
    return inner_done(inner, function(inner->instance, r, n, values), name);
}

fmi2Status inner_get(Inner *inner, uint32_t kind, fmi2ValueReference reference, double *value)
{
    fmi2Integer whole = 0;
    void *const into = kind == KIND_REAL ? (void *)value : (void *)&whole;
    const fmi2Status status = inner_access(inner, false, kind, &reference, 1, into);
    *value = kind == KIND_REAL ? *value : whole;
    return status;
}

fmi2Status inner_set(Inner *inner, uint32_t kind, fmi2ValueReference reference, double value)
{
    fmi2Integer whole = 0;
    if (kind != KIND_REAL && value > -2147483649.0 && value < 2147483648.0) {
        whole = (fmi2Integer)value;
    } else if (kind != KIND_REAL) {
        return REFUSE(inner->container, inner->name, ": ", SETTERS[kind], ": found a value that its type cannot hold");
    }
    return inner_access(inner, true, kind, &reference, 1, kind == KIND_REAL ? (void *)&value : (void *)&whole);
}
